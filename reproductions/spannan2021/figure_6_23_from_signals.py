"""Figure 6.23 as a measurement would show it: the slow run-up and run-down, seen by the accelerometer on the lid.

The source simulates this run and takes the place of a ball, which no sensor sees. The guided balls of figure_6_23_on_the_rig run
once more, and only the signal of the lid and the pulse a turn are evaluated: spectra of pieces of 8 s, with the line that is
called subsynchronous in each. Rubber and rolling resistance were fitted to the five speeds, so rows of onset, line and release
are fitted.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.plots.style import heading, look, picture, save_picture
from reproductions import Found, compared_all
from reproductions.spannan2021._five_speeds import LINE, ONSET, RELEASE
from reproductions.spannan2021._logger import ENCODER, LID
from reproductions.spannan2021._rig_on_rubber import slowest_ball
from reproductions.spannan2021.figure_6_23_on_the_rig import APART, AT, HIGH, LOW, RATE, run, run_up
from reproductions.spannan2021.figure_6_24 import HALF_STEP

KEPT, PIECE, LONGER = 200.0, 8.0, 0.4  # samples per second; s, and s more, since a piece begins and ends with a pulse
CLEAR = 0.1  # rad/s, of the deviation of a line; more where it is gone within the piece
RESOLVED = 2.0 * np.pi / PIECE
CHANGE = RATE * PIECE  # rad/s, of the rotor speed from one piece to the next


class Piece(NamedTuple):
    """A piece of the signal: middle (s), rotor speed and subsynchronous line (rad/s), nan without one."""

    time: float
    speed: float
    line: float


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Onset, line and release in the run-up, and the line that comes back in the run-down."""
    found = run(False, samples=KEPT)
    signals = ab.measure.rotor_angle(ab.measure.record(found, (LID, ENCODER), f"{KEPT} Hz", seed=1))
    pieces = [piece(signals, start) for start in np.arange(0.0, float(found["time"][-1]) - PIECE - 2.0 * LONGER, PIECE)]
    turning = (HIGH - LOW) / RATE
    up = [one for one in pieces if one.time < turning]
    back = [one.speed for one in pieces if one.time > turning and np.isfinite(one.line)]
    hangs = np.flatnonzero([np.isfinite(one.line) for one in up])
    onset, release = (0.5 * (up[k].speed + up[k + 1].speed) for k in (hangs[0] - 1, hangs[-1]))
    line = float(np.interp(AT, [one.speed for one in up], [one.line for one in up]))
    time, _, slow = slowest_ball(found, PIECE)
    off = max(abs(up[k].line - float(np.interp(up[k].time, time, slow))) for k in hangs)
    true_onset, _, _, true_release, _ = run_up(found)
    at = "slow run-up, from the signal of the lid"
    rows = [
        Found("fitted", f"onset of the line, {at}", "rad/s", ONSET, onset, HALF_STEP),
        Found("fitted", f"line at 60 rad/s, {at}", "rad/s", LINE, line, APART + 0.5),
        Found("fitted", f"release, {at}", "rad/s", RELEASE, release, HALF_STEP),
        Found("fitted", f"the line comes back in the run-down, below the release, {at} (1 = true)", "1", 1.0,
              float(bool(back) and max(back) < release), 0.0),
        Found("internal", f"onset, signal against balls, {at}", "rad/s", true_onset, onset, CHANGE),
        Found("internal", f"release, signal against balls, {at}", "rad/s", true_release, release, CHANGE),
        Found("internal", f"line against the slowest ball, farthest of {hangs.size} pieces, {at}", "rad/s", 0.0, off,
              0.5 * RESOLVED),
    ]  # fmt: skip
    draw(signals, pieces, out)
    return compared_all("Spannan 2021", "6.23 in kind", rows)


def piece(signals: xr.Dataset, start: float) -> Piece:
    """What the spectrum of one piece shows."""
    part = signals.sel(time=slice(start, start + PIECE + LONGER))
    spectrum = ab.measure.spectrum(part, resolution=f"{1.0 / PIECE} Hz")
    lines = [
        float(spectrum["line_frequency"][k])
        for k, name in enumerate(spectrum["line_name"].values)
        if str(name).startswith("subsynchronous") and float(spectrum["line_frequency_deviation"][k]) < CLEAR
    ]
    return Piece(float(part["time"].mean()), float(spectrum.attrs["speed"]), lines[0] if lines else np.nan)


def draw(signals: xr.Dataset, pieces: list[Piece], out: Path) -> None:
    """Spectrogram with the lines that were found."""
    seen = ab.measure.order_map(
        signals, over="frequency", highest=78.0, revolutions=PIECE * signals["speed"].values.mean() / 6.28
    )
    frequency = seen["frequency"].values
    near = frequency > 44.0
    level = 20.0 * np.log10(seen["amplitude"].values.T[near] + 1e-6)
    with look():
        figure = picture(7.6, 4.2)
        axes = figure.subplots()
        shade = axes.pcolormesh(seen["time"], frequency[near], level, vmin=-50.0, shading="auto", rasterized=True)
        axes.plot(signals["time"], signals["speed"], color="white", lw=0.8, ls="--")
        axes.plot([one.time for one in pieces], [one.line for one in pieces], "o", color="black", mfc="white", ms=4,
                  label="line called subsynchronous")  # fmt: skip
        axes.plot([(speed - LOW) / RATE for speed in (ONSET, RELEASE)], [LINE, LINE], color="white", lw=3.0,
                  label="measured line, stepping upwards")  # fmt: skip
        axes.set(xlabel="time (s)", ylabel="frequency (rad/s)", xlim=(seen["time"][0], seen["time"][-1]))
        axes.grid(visible=False)
        axes.legend(loc="lower center", labelcolor="white")
        figure.colorbar(shade, ax=axes, label="acceleration of the lid (dB of 1 m/s²)")
        heading(figure, "Spannan 2021, figure 6.23 from the signal of the lid; rotor speed dashed")
        save_picture(figure, out / "figure_6_23_from_signals.png")

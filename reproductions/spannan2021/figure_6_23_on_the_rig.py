"""Figure 6.23 on the rig of bodies and softening bushings: a slow run-up and run-down with guided and with resolved balls.

Two balls in 0.65 mm^2/s oil and 594 g mm, 0.1 rad/s^2 as in the source, rolling resistance of 0.002, in the middle of what the
five speeds allow. Measured is figure 6.22: a line at 53 rad/s from 57.5 to 64 rad/s. The source simulates rubber that does not
soften: its slip before the release, 2.6 Hz, is far above what the measured line and release leave, 11 rad/s, and it says
itself that its model cannot have the softer rubber of the run-up.

The release hardly depends on friction and start; the speed at which the line comes back in the run-down does, and in some runs it
does not come back. So only that it does here, below the release, is compared.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.signal import spectrogram

import autobalancer as ab
from autobalancer.plots.style import look, picture, save_picture
from reproductions import Found, compared_all, said
from reproductions.spannan2021._five_speeds import LINE, ONSET, RELEASE
from reproductions.spannan2021._rig_on_rubber import RIG, on_the_rig, slowest_ball
from reproductions.spannan2021.figure_6_24 import HALF_STEP, ORBIT

ROLLING, RATE = 0.002, 0.1  # rad/s^2
LOW, HIGH = 52.0, 68.0  # rad/s
SAMPLES = 40.0  # per second
SLIP = RELEASE - LINE  # rad/s, from the measured line and release
SIMULATED = "the source simulates 16.3 rad/s, which its measured line and release exclude"
APART = 0.63  # rad/s, resolved in 10 s
AT = 60.0  # rad/s, where the line is read
SUDDEN = 5.0  # s


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Onset, line, slip and release of the run-up, guided and resolved, and the spectrogram of both."""
    runs = {name: run(resolved) for name, resolved in (("guided", False), ("resolved", True))}
    rows, releases = [], []
    for name, each in runs.items():
        onset, line, slip, release, lasts = run_up(each)
        releases.append(release)
        at = f"slow run-up, {RIG}, {name} balls, 0.002"
        rows += [
            Found("fitted", f"onset of the line, {at}", "rad/s", ONSET, onset, HALF_STEP),
            Found("fitted", f"line at 60 rad/s, {at}", "rad/s", LINE, line, APART + 0.5),
            Found("fitted", f"release, {at}", "rad/s", RELEASE, release, HALF_STEP),
            Found("fitted", f"slip before the release, measured release less line, {at}", "rad/s", SLIP, slip, HALF_STEP,
                  SIMULATED),
            said(f"the line ends suddenly: from 90 % to half of the slip within 5 s, {at}", lasts < SUDDEN),
            Found("fitted", f"the line comes back in the run-down, below the release, {at} (1 = true)", "1", 1.0,
                  float(caught(each) < release), 0.0, "from 76 rad/s in place of 68 it does not come back"),
        ]  # fmt: skip
    rows.append(
        Found("internal", f"release, resolved against guided balls, {RIG}", "rad/s", releases[0], releases[1], 0.3)
    )
    draw(runs, out)
    return compared_all("Spannan 2021", "6.23 in kind", rows)


def run(
    resolved: bool, rolling: float = ROLLING, start: tuple[float, float] | None = None, *, samples: float = SAMPLES
) -> xr.Dataset:
    """Slowly up and down again, with so many samples per second."""
    lasts = (HIGH - LOW) / RATE
    profile = {"kind": "table", "time": [0.0, lasts, 2.0 * lasts], "speed": [LOW, HIGH, LOW]}
    machine = on_the_rig(profile, rolling, resolved=resolved, start=start)
    save = ab.Samples(round(2.0 * lasts * samples) + 1)
    return ab.simulate(machine, duration=2.0 * lasts, save=save, tolerance=1e-7)


def run_up(found: xr.Dataset) -> tuple[float, float, float, float, float]:
    """Rotor speeds of onset and release, line at 60 rad/s, greatest slip (rad/s), and how long the end of the line lasts (s)."""
    slip, speed, _ = slips(found, 5.0)
    hanging = np.flatnonzero(slip > APART)
    most = float(slip.max())
    quick, _, time = slips(found, 1.0)
    nearly, half = (float(time[np.flatnonzero(quick > share * most)[-1]]) for share in (0.9, 0.5))
    line = AT - float(np.interp(AT, speed, slip))
    return float(speed[hanging[0]]), line, most, float(speed[hanging[-1]]), half - nearly


def caught(found: xr.Dataset) -> float:
    """Rotor speed at which the line comes back in the run-down, rad/s; nan if it does not."""
    time, speed, slow = slowest_ball(found)
    back = (time > 0.5 * float(found["time"][-1])) & (speed - slow > APART)
    return float(speed[back][0]) if back.any() else float("nan")


def slips(found: xr.Dataset, seconds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the run-up: how much slower than the rotor the slowest ball is, mean over some seconds, rotor speed, time."""
    time, speed, slow = slowest_ball(found, seconds)
    up = time < 0.5 * float(found["time"][-1])
    return (speed - slow)[up], speed[up], time[up]


def draw(runs: dict[str, xr.Dataset], out: Path) -> None:
    """Spectrogram of the place of one ball over time, one panel for each kind of balls, with the measured line."""
    with look():
        figure = picture(7.6, 6.0)
        panels = figure.subplots(2, 1, sharex=True, sharey=True)
        for panel, (name, found) in zip(panels, runs.items(), strict=True):
            angle = (found["rotor_angle"] + found["ball_angle_in_rotor"][:, 0]).values
            x = found["x"].values + ORBIT * np.cos(angle)
            frequency, time, power = spectrogram(x, fs=SAMPLES, nperseg=512, noverlap=448)
            frequency = 2.0 * np.pi * frequency
            near = (frequency > 44.0) & (frequency < 74.0)
            level = 10.0 * np.log10(power[near] + 1e-12)
            shade = panel.pcolormesh(time, frequency[near], level, vmin=-80.0, shading="auto", rasterized=True)
            panel.plot(found["time"], found["speed"], color="white", lw=0.8, ls="--")
            seen = [(speed - LOW) / RATE for speed in (ONSET, RELEASE)]
            panel.plot(seen, [LINE, LINE], color="white", lw=3.0, label="measured line, run-up")
            panel.set(ylabel="frequency (rad/s)", title=f"{name} balls", xlim=(time[0], time[-1]))
            panel.grid(visible=False)
            panel.legend(loc="lower center", labelcolor="white")
            figure.colorbar(shade, ax=panel, label="power density (dB)")
        panels[-1].set_xlabel("time (s)")
        figure.suptitle("Place of one ball on the rig of bodies; rotor speed dashed (Spannan 2021, figure 6.23)")
        save_picture(figure, out / "figure_6_23_on_the_rig.png")

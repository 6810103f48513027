"""Figure 6.22 done as the experimenter did it: the lid's accelerometer and a pulse a turn, recorded at each of the five speeds.

The rig of bodies on softening bushings with resolved balls, of figure_6_22, is stepped through the speeds; the signals of the
last seconds at each, with noise, are all that is looked at. The line is the one that the spectrum calls subsynchronous. The
rubber was fitted to this line, onset and release, so these rows say that the signals show what the balls do, and nothing new
of the rig.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.plots.style import BALLS, CRITICAL, INK, heading, legend, look, picture, save_picture
from reproductions import Found, compared_all, said
from reproductions.spannan2021._five_speeds import (
    HELD,
    LINE,
    LINE_WITHIN,
    ONSET,
    RECORD,
    RELEASE,
    SPEEDS,
    STARTS,
    STEP,
    profile,
    slowest,
)
from reproductions.spannan2021._logger import ENCODER, KEPT, LID, RATE, SURE
from reproductions.spannan2021._rig_on_rubber import on_the_rig
from reproductions.spannan2021.figure_6_22 import ROLLING
from reproductions.spannan2021.figure_6_24 import HALF_STEP

LONGER = 0.5  # s, since what is evaluated begins and ends with a pulse


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Line, onset, release and synchronous vibration from the spectra, and the spectra."""
    end = float(profile()["time"][-1])
    machine = on_the_rig(profile(), ROLLING, resolved=True, start=STARTS[0])
    run = ab.simulate(machine, duration=end, save=ab.Samples(round(KEPT * end) + 1), tolerance=1e-7)
    spectra = [spectrum(run, number) for number in range(SPEEDS.size)]
    lines = [subsynchronous(one) for one in spectra]
    hangs = np.array([line is not None for line in lines])
    first, last = np.flatnonzero(hangs)[[0, -1]]
    seen, sure = lines[2] or (np.nan, 0.0)
    size = np.array([synchronous(one) for one in spectra])
    on = "from the signal of the lid"
    rows = [
        Found("fitted", f"onset of the line, {on}", "rad/s", ONSET, 0.5 * float(SPEEDS[first - 1 : first + 1].sum()), HALF_STEP),
        Found("fitted", f"line at 580 rpm, {on}", "rad/s", LINE, seen, LINE_WITHIN),
        Found("fitted", f"release, {on}", "rad/s", RELEASE, 0.5 * float(SPEEDS[last : last + 2].sum()), HALF_STEP),
        said(f"above 64 rad/s the subsynchronous vibration vanishes and the synchronous one is less, {on}",
             bool(not hangs[3:].any() and (size[3:] < size[2]).all())),
        Found("internal", f"line at 580 rpm, {on}, against the speed of the slowest ball", "rad/s",
              float(slowest(run)[2]), seen, SURE * sure),
    ]  # fmt: skip
    draw(spectra, out)
    return compared_all("Spannan 2021", "6.22 in kind", rows)


def spectrum(run: xr.Dataset, number: int) -> xr.Dataset:
    """Of what the accelerometer sees at the end of one speed."""
    end = (number + 1) * (HELD + STEP) - STEP
    signals = ab.measure.record(run, (LID, ENCODER), RATE, start=end - RECORD - LONGER, end=end, seed=number)
    return ab.measure.spectrum(ab.measure.rotor_angle(signals), resolution=f"{1.0 / RECORD} Hz")


def subsynchronous(found: xr.Dataset) -> tuple[float, float] | None:
    """Frequency of the line that is named so, with its standard deviation, rad/s."""
    for number, name in enumerate(found["line_name"].values):
        if str(name).startswith("subsynchronous"):
            return float(found["line_frequency"][number]), float(found["line_frequency_deviation"][number])
    return None


def synchronous(found: xr.Dataset) -> float:
    """RMS of order 1, m/s^2."""
    return float(found["line_amplitude"][list(found["line_name"].values).index("order 1")] / 2.0**0.5)


def draw(spectra: list[xr.Dataset], out: Path) -> None:
    """RMS acceleration over the frequency, a line for each speed, with what was found."""
    top = max(float(one["line_amplitude"].max()) for one in spectra) / np.sqrt(2.0)
    with look():
        figure = picture(7.2, 4.6)
        axes = figure.subplots()
        for number, (speed, one) in enumerate(zip(SPEEDS, spectra, strict=True)):
            near = (one["frequency"].values > 42.0) & (one["frequency"].values < 80.0)
            rms = one["amplitude"].values[0, near] / np.sqrt(2.0)
            axes.plot(one["frequency"][near], speed + 5.5 * rms / top, color=BALLS[0], lw=1.1)
            labels = {"label": "order 1 of the tacho"}, {"label": "line called subsynchronous"}
            axes.plot(
                one.attrs["speed"], speed - 0.7, "^", color=CRITICAL, ms=4, ls="none", **labels[0] if not number else {}
            )
            if line := subsynchronous(one):
                axes.plot(line[0], speed - 0.7, "^", color=INK, ms=4, ls="none", **labels[1])
                axes.annotate(f"{line[0]:.2f}", (line[0], speed - 0.7), (5, -4), textcoords="offset points")
        axes.plot([LINE, LINE], [ONSET, RELEASE], color="black", lw=3.0, alpha=0.35, zorder=1, label="measured line")
        axes.set(xlabel="frequency (rad/s)", ylabel="rotor speed (rad/s)")
        legend(axes)
        heading(figure, f"Spannan 2021, figure 6.22 from the signal of the lid, highest peak {top:.2f} m/s² RMS")
        save_picture(figure, out / "figure_6_22_from_signals.png")

"""Figure 6.11 as far as blows can show it: frequencies of the two modes across, at rest and while the rotor turns.

The rig on the linear bushings of the catalog, without balls and unbalance, is struck at rest and at three speeds; accelerometers
on the lid, along x and y, are all that is looked at. The source computed its diagram and measured at rest only. The pair of the
first mode is nearer than its decay lets anybody part, so it is fitted as one mode; of the second mode the phases of x and y tell
which whirls forward. At 400 rpm this pair cannot be parted either with this noise: the fit says that a third mode is hardly more
than noise.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.plots.style import BALLS, INK, heading, legend, look, picture, save_picture
from reproductions import Found, compared_all, said
from reproductions.spannan2021._logger import LID, RATE, SURE
from reproductions.spannan2021.figure_6_9_from_signals import struck
from reproductions.spannan2021.figure_6_12 import HERTZ

RPM = np.pi / 30.0
TURNING = (600.0, 900.0, 1200.0)  # rpm
WITHIN = 0.01
LITTLE = 0.01  # by which the first frequency may change where gyroscopic moments do not influence it strongly


class Line(NamedTuple):
    """A frequency (Hz) and decay (1/s) with their deviations; whirl is 1 forward, -1 backward, 0 unknown."""

    frequency: float
    frequency_deviation: float
    decay: float
    decay_deviation: float
    whirl: int


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Both modes at rest against the source, the others against eigenvalues and its words."""
    found = {speed: lines(speed) for speed in (0.0, *TURNING)}
    off = {"frequency": 0.0, "decay": 0.0}
    for speed, seen in found.items():
        for line in seen:
            for name, away in off_by(line, speed).items():
                off[name] = max(off[name], away)
    first = [seen[0].frequency for seen in found.values()]
    split = {way: [one.frequency for seen in found.values() for one in seen[1:] if one.whirl == way] for way in (-1, 1)}
    rest = found[0.0]
    falls = len(split[-1]) == len(TURNING) and bool((np.diff([rest[1].frequency, *split[-1]]) < 0.0).all())
    rises = len(split[1]) == len(TURNING) and bool((np.diff([rest[1].frequency, *split[1]]) > 0.0).all())
    at = "after a blow, from acceleration of the lid"
    rows = [
        Found("fitted", f"first mode at rest, {at}", "Hz", 9.6, rest[0].frequency, 9.6 * WITHIN, figure="6.9, 6.11 in kind"),
        Found("fitted", f"second mode at rest, {at}", "Hz", 25.2, rest[1].frequency, 25.2 * WITHIN, figure="6.9, 6.11 in kind"),
        said(f"gyroscopic moments change the first frequency little up to 1200 rpm, {at}",
             bool(np.ptp(first) < LITTLE * first[0])),
        said(f"backward whirl of the second mode falls and forward whirl rises with the speed, {at}", falls and rises),
        *(
            Found("internal", f"{name} of both modes at four speeds, farthest from its eigenvalue, in stated deviations", "1",
                  0.0, away, SURE)
            for name, away in off.items()
        ),
    ]  # fmt: skip
    draw(found, out)
    return compared_all("Spannan 2021", "6.11 in kind", rows)


def lines(speed: float) -> list[Line]:
    """Modes as the signals after a blow show them at a speed (rpm), the lowest first."""
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed * RPM}}
    run = ab.simulate(with_value_at(struck(), "drive", drive), duration=2.0, save=ab.Samples(4001))
    sensors = (LID, replace(LID, direction="y"))
    signals = ab.measure.record(run, sensors, RATE, seed=round(speed))
    count = 3 if speed else 2
    along = ab.measure.damping(signals, sensors[0].channel, modes=count, start=0.0).sortby("frequency")
    if not speed:
        return [line_of(along.isel(mode=k)) for k in range(count)]
    across = ab.measure.damping(signals, sensors[1].channel, modes=count, start=0.0).sortby("frequency")
    first, *second = (along.isel(mode=k) for k in range(count))
    return [line_of(first), *(line_of(one, across.isel(mode=k)) for k, one in enumerate(second, 1))]


def line_of(along: xr.Dataset, across: xr.Dataset | None = None) -> Line:
    """Of one mode; it whirls forward where y lags x by a quarter of a turn."""
    ahead = 0.0 if across is None else float(np.sin(along["phase"] - across["phase"]))
    return Line(
        float(along["frequency"]) / HERTZ,
        float(along["frequency_uncertainty"]) / HERTZ,
        float(along["decay_rate"]),
        float(along["decay_rate_uncertainty"]),
        int(np.sign(ahead)),
    )


def off_by(line: Line, speed: float) -> dict[str, float]:
    """Distance to the nearest eigenvalue of the same whirl, in stated deviations; of a pair seen as one, to its middle."""
    modes = ab.rotor.modes(struck(), speed * RPM, balls=False, modes=6)
    modes = modes.isel(mode=[str(way) in ("forward", "backward") for way in modes["whirl"].values])
    if line.whirl:
        modes = modes.isel(mode=modes["whirl"].values == {1: "forward", -1: "backward"}[line.whirl])
    near = np.abs(modes["frequency"].values / HERTZ - line.frequency)
    kept = np.argsort(near)[: 1 if line.whirl else 2]
    frequency, decay = (float(modes[name].values[kept].mean()) for name in ("frequency", "decay_rate"))
    return {
        "frequency": abs(line.frequency - frequency / HERTZ) / line.frequency_deviation,
        "decay": abs(line.decay - decay) / line.decay_deviation,
    }


def draw(found: dict[float, list[Line]], out: Path) -> None:
    """Campbell diagram with what the signals show on it."""
    speeds = np.linspace(0.0, TURNING[-1], 31)
    modes = [ab.rotor.modes(struck(), speed * RPM, balls=False, modes=6) for speed in speeds]
    across = (
        np.array([np.sort(one["frequency"].values[one["whirl"].values != "straight"])[:4] for one in modes]) / HERTZ
    )
    colors, names = (
        {0: INK, 1: BALLS[0], -1: BALLS[1]},
        {0: "pair as one", 1: "forward by phase", -1: "backward by phase"},
    )
    with look():
        figure = picture(6.8, 4.6)
        axes = figure.subplots()
        for k, curve in enumerate(across.T):
            axes.plot(speeds, curve, color=INK, lw=0.9, label="eigenvalues" if not k else None)
        shown: set[int] = set()
        for speed, seen in found.items():
            for line in seen:
                label = None if line.whirl in shown else names[line.whirl]
                shown.add(line.whirl)
                axes.errorbar(speed, line.frequency, 2.0 * line.frequency_deviation, fmt="o", ms=5, mfc="none", capsize=2,
                              color=colors[line.whirl], label=label)  # fmt: skip
        axes.set(xlabel="rotor speed (rpm)", ylabel="natural frequency (Hz)", ylim=(0.0, 32.0))
        legend(axes)
        heading(figure, "Spannan 2021, figure 6.11 from signals after blows, 95 % intervals")
        save_picture(figure, out / "figure_6_11_from_signals.png")

"""Sections 6.1.2 and 6.1.7: one rubber for the three resonances of the discoidal rig, and which friction of its balls fits.

The source prints 9.6 Hz and a decay of 2.8 1/s after a blow, a passage of 10.7 Hz in a run-up with the rotor's own unbalance, and
balls that hang at 53 rad/s, 8.4 Hz: the stiffness of its rubber falls with the amplitude. The rubber here is fitted to these
numbers, so its rows are of that kind; blow and own unbalance are not printed. Not fitted are the speeds at which balls do not
hang; neither is the rig of bodies on bushings, to which this rubber was moved as it is.

The picture shows for which rolling resistance, adherence and drag a run through the five speeds meets all of them:
synchronous at 460 and 520 rpm, a line of 53 rad/s at 580, synchronous again at 640 and 700. On the rig of bodies and
bushings, with guided and with resolved balls, these runs are kept as a table, see _five_speeds_on_the_rig.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.machine import Machine
from autobalancer.plots.style import look, picture, save_picture
from autobalancer.studies.variations import in_threads
from reproductions import Found, compared_all
from reproductions.spannan2021 import _five_speeds_on_the_rig as table
from reproductions.spannan2021._five_speeds import STARTS, lines, lines_of, meets_all, profile, soft_rubber
from reproductions.spannan2021._rig_on_rubber import on_the_rig as rig_with
from reproductions.spannan2021.figure_6_24 import MASS

BLOW = 0.4  # N s, not printed
OWN = 30e-6  # kg m, not printed: small beside 594 g mm
RATE = 0.837  # rad/s^2
FREQUENCY, DECAY, PASSAGE = 9.6, 2.8, 10.7  # Hz, 1/s, Hz
HERTZ = 2.0 * math.pi
ROLLING = (0.0, 0.001, 0.002, 0.003, 0.005, 0.01)
CHOSEN = "softening rubber"
BALL_MODELS = ("guided", "resolved")
NOT_PRINTED = "blow and own unbalance are not printed and were chosen"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Frequency and decay after a blow, the passage in the run-up, and how many starts meet the five speeds."""
    frequency, decay = frequency_and_decay(after_a_blow())
    met = dict(zip(cases(), in_threads(lambda case: starts_that_meet(**case), list(cases().values())), strict=True))
    draw({"stand-in": met} | {f"rig, {balls} balls": table.starts_that_meet(balls) for balls in BALL_MODELS}, out)
    rows = [
        Found("fitted", "frequency after a blow of 0.4 N s", "Hz", FREQUENCY, frequency, 0.1, NOT_PRINTED),
        Found("fitted", "decay of the first second after it", "1/s", DECAY, decay, 0.3, NOT_PRINTED),
        Found("fitted", "passage in a run-up with 30 g mm", "Hz", PASSAGE, passage(), 0.2, NOT_PRINTED),
        Found("internal", "starts of 18 on linear rubber that meet all five speeds", "1", 0.0, sum(met["linear rubber"]), 0.0),
        Found("internal", "starts of 3 that meet them with rolling resistance 0.01, softening rubber", "1", 0.0,
              met[CHOSEN][-1], 0.0),
        Found("fitted", "starts of 3 that meet them with 0.001, softening rubber", "1", 3.0, met[CHOSEN][1], 0.0),
        *on_the_rig(),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "6.1.7", rows)


def machine(**more: Any) -> Machine:
    """The planar stand-in without balls."""
    return Machine(name="discoidal rotor", axis="vertical", rotor={"mass": MASS, "rubber": soft_rubber()}, **more)


def after_a_blow() -> xr.Dataset:
    """Two seconds after a blow at rest."""
    still = {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}}
    return ab.simulate(
        machine(start={"velocity": [BLOW / MASS, 0.0]}, drive=still), duration=2.0, save=ab.Samples(4001)
    )


def frequency_and_decay(run: xr.Dataset) -> tuple[float, float]:
    """Peak of the spectrum of a run of 2 s (Hz), and the decay of the amplitudes of the first second (1/s)."""
    time, x = run["time"].values, run["x"].values
    spectrum = np.abs(np.fft.rfft(x[:-1], 2**18))
    frequency = np.fft.rfftfreq(2**18, time[1])[int(spectrum.argmax())]
    size = np.abs(x)
    tops = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    tops = tops[time[tops] < 1.0]
    return float(frequency), -float(np.polyfit(time[tops], np.log(size[tops]), 1)[0])


def passage() -> float:
    """Speed of the greatest deflection in the run-up of figure 6.10, Hz."""
    profile = {"kind": "ramp", "start": 12.7, "end": 110.0, "duration": (110.0 - 12.7) / RATE}
    given = machine(unbalances=[{"moment": OWN}], drive={"kind": "speed", "profile": profile})
    run = ab.simulate(given, duration=profile["duration"], save=ab.Samples(8001), tolerance=1e-8)
    return float(run["speed"][int(run["deflection"].values.argmax())]) / HERTZ


def on_the_rig() -> list[Found]:
    """What the table of runs on the rig of bodies and bushings says, and one of its runs done again with each kind of balls."""
    rows, apart = [], 0.0
    for balls in BALL_MODELS:
        met = table.starts_that_meet(balls)[""]
        rows += [
            Found("fitted", f"starts of 3 that meet them with 0.001, rig of bodies on such bushings, {balls} balls", "1",
                  3.0, met[1], 0.0, "from the third start they hang at 520 rpm, too"),
            Found("internal", f"starts of 6 that do with 0.005 or 0.01 there, {balls} balls", "1", 0.0, sum(met[-2:]), 0.0),
        ]  # fmt: skip
        again = lines_of(rig_with(profile(), ROLLING[1], resolved=balls == "resolved", start=STARTS[0]))
        apart = max(apart, float(np.abs(again - table.lines_of_case(balls, "", ROLLING[1], 1)).max()))
    rows.append(
        Found("internal", "speeds of the table against those of runs now, farthest of ten", "rad/s", 0.0, apart, 0.05)
    )
    return rows


def cases() -> dict[str, dict[str, Any]]:
    """What is varied beside the rolling resistance."""
    soft = {"rubber": soft_rubber()}
    return {
        "linear rubber": {},
        CHOSEN: soft,
        "twice the adherence": soft | {"times": 2.0},
        "five times the adherence": soft | {"times": 5.0},
        "drag plateau 0.48": soft | {"plateau": 0.48},
        "drag plateau 0.74": soft | {"plateau": 0.74},
    }


def starts_that_meet(*, times: float = 1.0, **case: Any) -> list[int]:
    """How many of three starts meet all five speeds, for each rolling resistance; ``times`` it is the adherence."""
    return [
        sum(meets_all(lines(one, adherence=times * one, start=start, **case)) for start in STARTS) for one in ROLLING
    ]


def draw(met: dict[str, dict[str, list[int]]], out: Path) -> None:
    """Which friction and drag the five speeds exclude, one block for each model."""
    with look():
        figure = picture(6.8, 7.4)
        blocks = figure.subplots(len(met), 1, sharex=True, height_ratios=[len(cases) for cases in met.values()])
        for axes, (model, cases) in zip(blocks, met.items(), strict=True):
            values = np.array(list(cases.values()), float) / len(STARTS)
            axes.imshow(values, cmap="Greens", vmin=0.0, vmax=1.3, aspect="auto")
            for i, row in enumerate(cases.values()):
                for j, count in enumerate(row):
                    text = f"{count} of {len(STARTS)}" if count else "none"
                    axes.text(j, i, text, ha="center", va="center", fontsize=9, color="black" if count else "0.45")
            names = [name or CHOSEN for name in cases]
            axes.set_xticks(range(len(ROLLING)), [f"{one:g}" for one in ROLLING])
            axes.set_yticks(range(len(cases)), [name if "rubber" in name else f"… {name}" for name in names])
            axes.set_xticks(np.arange(len(ROLLING) - 1) + 0.5, minor=True)
            axes.set_yticks(np.arange(len(cases) - 1) + 0.5, minor=True)
            axes.grid(which="major", visible=False)
            axes.grid(which="minor", color="white", lw=2.0)
            axes.tick_params(which="both", length=0)
            axes.set_title(model)
        blocks[-1].set_xlabel("rolling resistance")
        figure.suptitle("Starts that meet the measurement at all five speeds")
        save_picture(figure, out / "softening_rubber.png")

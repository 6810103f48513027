"""Figure 6.22: two balls in 0.65 mm^2/s oil, the speed stepped upwards by 1 Hz, each held for 70 s.

Measured on the discoidal rig: a line at 53 rad/s from 57.5 to 64 rad/s, which are the middles of the steps from 520 to 580 and
from 580 to 640 rpm. Done here in the same way with the planar stand-in of table 6.4 and the drag law (6.9), repaired: the
speeds are 460 to 700 rpm, and the line is the speed in space of the slowest ball over the last 10 s of each, where it differs
from that of the rotor by more than the resolution of such a record. Rolling resistance is not known; those above zero were
chosen after seeing. On linear rubber the line is near the natural frequency of the stand-in, 60 rad/s, so it is missed with any
rolling resistance. Rubber that softens with the amplitude, fitted to this line among others, meets it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.machine import Rubber
from autobalancer.plots.drawing.save import save_picture
from autobalancer.plots.drawing.style import BALLS, CRITICAL, look, picture
from reproductions import Found, Kind, compared_all
from reproductions.spannan2021._five_speeds import (
    LINE,
    LINE_WITHIN,
    ONSET,
    RELEASE,
    SPEEDS,
    lines,
    onset_and_release,
    soft_rubber,
)
from reproductions.spannan2021.figure_6_24 import HALF_STEP, RUBBER


def cases() -> dict[str, tuple[float, Rubber | None, Kind]]:
    """Rolling resistance, rubber and kind of the rows of each case."""
    return {
        "linear rubber, no rolling resistance": (0.0, None, "printed"),
        "linear rubber, 0.002": (0.002, None, "fitted"),
        "softening rubber, 0.001": (0.001, soft_rubber(), "fitted"),
    }


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Onset, release and line of each case, and the lines over the speed."""
    rows, found = [], {}
    for name, (rolling, rubber, kind) in cases().items():
        line = found[name] = lines(rolling, rubber=rubber)
        onset, release = onset_and_release(line)
        at, note = f"stepping upwards, {name}", RUBBER if rubber is None else ""
        rows += [
            Found(kind, f"onset of the line, {at}", "rad/s", ONSET, onset, HALF_STEP, note),
            Found(kind, f"line at 580 rpm, {at}", "rad/s", LINE, line[2], LINE_WITHIN, note),
            Found(kind, f"release, {at}", "rad/s", RELEASE, release, HALF_STEP, note),
        ]
    draw(found, out)
    return compared_all("Spannan 2021", "6.22", rows)


def draw(found: dict[str, np.ndarray], out: Path) -> None:
    """Lines over the rotor speed."""
    with look():
        figure = picture(6.4, 4.0)
        axes = figure.subplots()
        axes.plot(SPEEDS, SPEEDS, color=CRITICAL, lw=0.9, ls="--", label="rotor speed")
        axes.hlines(LINE, ONSET, RELEASE, color="black", lw=3.0, label="measured line")
        for (name, line), color in zip(found.items(), BALLS, strict=False):
            axes.plot(SPEEDS, line, "o-", ms=6, mfc="none", color=color, label=name)
        axes.set(xlabel="rotor speed (rad/s)", ylabel="speed of the slowest ball in space (rad/s)")
        axes.set_title("Spannan 2021, figure 6.22: speed stepped upwards by 1 Hz")
        axes.legend(loc="upper left")
        save_picture(figure, out / "figure_6_22.png")

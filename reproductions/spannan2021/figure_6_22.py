"""Figure 6.22: two balls in 0.65 mm^2/s oil, the speed stepped upwards by 1 Hz, each held for 70 s.

Measured on the discoidal rig: a line at 53 rad/s from 57.5 to 64 rad/s, which are the middles of the steps from 520 to 580 and
from 580 to 640 rpm. Done here in the same way with the planar stand-in of table 6.4 and the drag law (6.9), repaired: the
speeds are 460 to 700 rpm, and the line is the speed in space of the slowest ball over the last 10 s of each, where it differs
from that of the rotor by more than the resolution of such a record. Rolling resistance is not known; 0.002 was chosen after
seeing. The line is near the natural frequency of the stand-in, 60 rad/s, so it is missed with any rolling resistance: the rubber
of the rig was probably softer under so large a motion.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.parameters import with_value_at
from autobalancer.plots.drawing.save import save_picture
from autobalancer.plots.drawing.style import BALLS, CRITICAL, look, picture
from reproductions import Found, Kind, compared_all
from reproductions.spannan2021._stall_runs import machine
from reproductions.spannan2021.figure_6_24 import HALF_STEP, RUBBER

SPEEDS = np.array([460.0, 520.0, 580.0, 640.0, 700.0]) * math.pi / 30.0
ONSET, RELEASE, LINE = 57.5, 64.0, 53.0  # rad/s
STEP, HELD, RECORD = 2.0, 70.0, 10.0  # s: to the next speed, at it, of it for the line
RESOLUTION = 2.0 * math.pi / RECORD
START = (0.3, -0.5)  # rad, from the unbalance
CASES: dict[float, Kind] = {0.0: "printed", 0.002: "fitted"}  # rolling resistance


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Onset, release and line for both rolling resistances, and the lines over the speed."""
    rows, lines = [], {}
    for rolling, kind in CASES.items():
        line = lines[rolling] = slowest(rolling)
        hanging = np.flatnonzero(SPEEDS - line > RESOLUTION)
        first, last = (int(hanging[0]), int(hanging[-1])) if hanging.size else (0, SPEEDS.size - 1)
        onset = 0.5 * (SPEEDS[first - 1] + SPEEDS[first]) if first > 0 else math.nan
        release = 0.5 * (SPEEDS[last] + SPEEDS[last + 1]) if last + 1 < SPEEDS.size else math.nan
        at = f"stepping upwards, rolling resistance {rolling:g}"
        rows += [
            Found(kind, f"onset of the line, {at}", "rad/s", ONSET, onset, HALF_STEP, RUBBER),
            Found(kind, f"line at 580 rpm, {at}", "rad/s", LINE, line[2], RESOLUTION, RUBBER),
            Found(kind, f"release, {at}", "rad/s", RELEASE, release, HALF_STEP, RUBBER),
        ]
    draw(lines, out)
    return compared_all("Spannan 2021", "6.22", rows)


def slowest(rolling: float) -> np.ndarray:
    """Mean speed in space of the slowest ball at the end of each speed, rad/s."""
    ends = np.arange(1, SPEEDS.size + 1) * (HELD + STEP) - STEP
    times = np.sort(np.concatenate([[0.0], ends, ends[:-1] + STEP]))
    profile = {"kind": "table", "time": times.tolist(), "speed": np.repeat(SPEEDS, 2).tolist()}
    balls = "balancers[1].races[1].balls[1]."
    stepped = machine(rolling, "whole", SPEEDS[:2].tolist(), 1.0)
    for path, value in (
        ("drive.profile", profile),
        (f"{balls}start_angles", START),
        (f"{balls}start_speeds", (0.0, 0.0)),
        ("start", {}),
    ):
        stepped = with_value_at(stepped, path, value)
    run = ab.simulate(stepped, duration=float(times[-1]), save=ab.Samples(2 * round(times[-1]) + 1), tolerance=1e-7)
    angle = (run["rotor_angle"] + run["ball_angle_in_rotor"]).transpose("time", ...).values
    at = np.array([np.interp([end - RECORD, end], run["time"].values, ball) for ball in angle.T for end in ends])
    return np.asarray(((at[:, 1] - at[:, 0]) / RECORD).reshape(angle.shape[1], -1).min(axis=0))


def draw(lines: dict[float, np.ndarray], out: Path) -> None:
    """Lines over the rotor speed."""
    with look():
        figure = picture(6.4, 4.0)
        axes = figure.subplots()
        axes.plot(SPEEDS, SPEEDS, color=CRITICAL, lw=0.9, ls="--", label="rotor speed")
        axes.hlines(LINE, ONSET, RELEASE, color="black", lw=3.0, label="measured line")
        for (rolling, line), color in zip(lines.items(), BALLS, strict=False):
            axes.plot(SPEEDS, line, "o-", ms=6, mfc="none", color=color, label=f"rolling resistance {rolling:g}")
        axes.set(xlabel="rotor speed (rad/s)", ylabel="speed of the slowest ball in space (rad/s)")
        axes.set_title("Spannan 2021, figure 6.22: speed stepped upwards by 1 Hz")
        axes.legend(loc="upper left")
        save_picture(figure, out / "figure_6_22.png")

"""Figures 10 to 12: no washer to four washers removed, measured with and without balls, and where the balls are.

The machine is that of figure 9, with the direction of the run-out that was fitted there, with three washers; the other numbers
of washers follow from table 2. Compared are levels (geometric means) from 4000 to 5000 rpm, of run-up and run-down together.
Without washers the rotor has a couple only, which one plane of balls cannot balance. Angles of the balls were measured from
photographs of three runs, counted from the light spot. The run-out moves the middle of the balls off it as in the photographs;
half the angle between the balls is the balanced one here, and larger in the photographs. The point of figure 12 where its
theory is that of the model at 4500 rpm is the one without washers; its other lines are straight.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.plots.drawing.save import save_picture
from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, CRITICAL, INK, UNBALANCE, look, picture
from autobalancer.results.series import wrapped
from reproductions import Found, compared_all, said
from reproductions.rodrigues2011.balls import STEPS, as_measured, geometric_mean, level, stepped, without_balls
from reproductions.rodrigues2011.rig import BEARINGS, DATA, RPM, columns

WASHERS = range(5)
FAST = (4000.0, 5000.0)  # rpm
WITHIN = 0.25
DAY = "the supports differed between the days of measurement: the second peak is at 1675 or at 1840 rpm"
FRICTION = "friction between balls and race is not printed; a rolling resistance of 0.0005 changes level and places up to twofold"
PLACES, SPREAD = (3000, 4000, 5000), 5.0  # rpm; deg, of the three measured runs


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Levels with and without balls for each number of washers, ball positions for two, and pictures."""
    balls = {n: stepped(as_measured(n)) for n in WASHERS}
    plain = {n: amplitudes(n) for n in WASHERS}
    ours = {n: (fast(plain[n]), math.sqrt(level(up, *FAST) * level(down, *FAST)))
            for n, (up, down) in ((n, (b.sel(direction="up"), b.sel(direction="down"))) for n, b in balls.items())}  # fmt: skip
    theirs = {n: (measured(n, "control"), measured(n, "abb")) for n in WASHERS}
    rows = []
    for n in WASHERS:
        about = f"washers removed: {n}; level from 4000 to 5000 rpm, ours over measured"
        rows.append(Found("printed", f"{about}, without balls", "1", 1.0, ours[n][0] / theirs[n][0], WITHIN, DAY))
        if n != 3:  # which is figure 9
            rows.append(Found("printed", f"{about}, two balls", "1", 1.0, ours[n][1] / theirs[n][1], WITHIN, FRICTION))
    raised = [theirs[n][1] > theirs[n][0] for n in WASHERS] == [ours[n][1] > ours[n][0] for n in WASHERS]
    rows.append(said("balls raise that level without washers, and reduce it with any", raised, FRICTION))
    still = ab.rotor.response(without_balls(as_measured(0)), np.array([4500.0]) * RPM, BEARINGS)["mean_of_greatest"]
    theory = float(columns("fig12_theory_plain")[1][0])
    rows.append(Found("printed", "theory without washers, 4500 rpm", "mm", theory, 1e3 * float(still[0]), 0.02 * theory,
                      figure="12"))  # fmt: skip
    rows += positions(balls[2])
    draw(balls, plain, out)
    draw_levels(ours, theirs, out)
    return compared_all("Rodrigues 2011", "11", rows)


def amplitudes(washers: int) -> np.ndarray:
    """Of the plain rotor at the speeds of the experiment, mm."""
    found = ab.rotor.response(without_balls(as_measured(washers)), STEPS * RPM, BEARINGS)
    return np.asarray(found["mean_of_greatest"].values * 1e3)


def fast(amplitude: np.ndarray) -> float:
    """Level of the plain rotor, mm."""
    return geometric_mean(STEPS, amplitude, *FAST)


def measured(washers: int, rotor: str) -> float:
    """Measured level of both ways, mm."""
    ways = [geometric_mean(*columns(f"fig11_nw{washers}_{rotor}_{way}"), *FAST) for way in ("runup", "rundown")]
    return math.sqrt(ways[0] * ways[1])


def positions(found: xr.Dataset) -> list[Found]:
    """Half the angle between the balls and their middle, mean over three speeds, against photographs."""
    light = float(as_measured(2).unbalances[0].angle) + math.pi
    at = found.sel(direction="up").sel(speed=np.array(PLACES) * RPM, method="nearest")
    middle = 0.5 * (at["least_ball_angle_in_rotor"] + at["greatest_ball_angle_in_rotor"]).values
    ours = np.sort(np.degrees(wrapped(middle - light)), axis=1).mean(axis=0)
    theirs = photographed()
    return [
        Found("printed", "half the angle between the balls, 3000 to 5000 rpm", "deg", 0.5 * (theirs[1] - theirs[0]),
              0.5 * (ours[1] - ours[0]), SPREAD, FRICTION, figure="10"),
        Found("printed", "middle of the balls from the light spot, 3000 to 5000 rpm", "deg", 0.5 * (theirs[1] + theirs[0]),
              0.5 * (ours[1] + ours[0]), SPREAD, FRICTION, figure="10"),
    ]  # fmt: skip


def photographed() -> tuple[float, float]:
    """Mean angles of the ball behind the light spot and of the one ahead of it, deg."""
    with (DATA / "fig10_ball_positions_measured.csv").open(encoding="utf-8", newline="") as file:
        found = [float(row["ball_angle_from_light_spot_deg"]) for row in csv.DictReader(file)
                 if int(row["speed_rpm"]) in PLACES]  # fmt: skip
    angles = np.array(found)
    return float(angles[angles < 0.0].mean()), float(angles[angles > 0.0].mean())


def draw(balls: dict[int, xr.Dataset], plain: dict[int, np.ndarray], out: Path) -> None:
    """Figure 11: a panel for each number of washers."""
    with look():
        figure = picture(8.4, 11.0)
        panels = figure.subplots(len(balls), 1, sharex=True, sharey=True)
        for panel, (n, found) in zip(panels, balls.items(), strict=True):
            for rotor, color, name in (("control", ALL_BALLS, "without balls"), ("abb", UNBALANCE, "two balls")):
                speed, amplitude = columns(f"fig11_nw{n}_{rotor}_runup")
                kept = speed > 590.0
                panel.plot(speed[kept], amplitude[kept], ".", ms=2.5, color=color, label=f"measured upwards, {name}")
            panel.plot(STEPS, plain[n], color=INK, lw=0.9, label="ours, without balls")
            panel.plot(
                STEPS,
                1e3 * found["amplitude"].sel(direction="up"),
                color=BALLS[0],
                lw=0.9,
                label="ours upwards, two balls",
            )
            panel.set(yscale="log", ylabel="amplitude (mm)", xlim=(600.0, 5400.0))
            panel.set_title(f"washers removed: {n}", color=INK)
        panels[-1].set_xlabel("rotor speed (rpm)")
        figure.suptitle("Rodrigues 2011, figure 11")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        save_picture(figure, out / "figure_11.png")


def draw_levels(ours: dict[int, tuple[float, float]], theirs: dict[int, tuple[float, float]], out: Path) -> None:
    """Figure 12: levels over the number of washers."""
    with look():
        figure = picture(6.4, 4.2)
        axes = figure.subplots()
        for i, (name, color) in enumerate((("without balls", INK), ("two balls", BALLS[0]))):
            axes.plot(list(theirs), [one[i] for one in theirs.values()], "o", color=color, label=f"measured, {name}")
            axes.plot(list(ours), [one[i] for one in ours.values()], "x-", lw=1.0, color=color, label=f"ours, {name}")
        for name, label in (("plain", "theory of the source"), ("abb", "_")):
            axes.plot(*columns(f"fig12_theory_{name}"), color=CRITICAL, ls="--", lw=0.9, label=label)
        axes.set(xlabel="washers removed", ylabel="amplitude (mm)", xticks=list(ours), ylim=(0.0, None))
        axes.set_title("Rodrigues 2011, figure 12: level from 4000 to 5000 rpm")
        axes.legend(loc="upper left")
        save_picture(figure, out / "figure_12.png")

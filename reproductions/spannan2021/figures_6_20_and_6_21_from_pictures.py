"""Figures 6.20 and 6.21 as they were measured: the sector of each rest from a stroboscopic picture.

The 360 run-ups of figures_6_20_and_6_21 end with the ball at rest in the turning rotor. A camera above, at rest and slightly
oblique, takes a picture of each, lit by a flash of 0.1 ms and with noise; the rotor is then at any angle, which marks on it show.
The tracker reads the ball angles, and the histograms count them. The source does not say where its camera stood. Race and
friction were chosen for figures_6_20_and_6_21, so what is compared with the source is fitted; what is new is that the pictures
give the rests back.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.plots.style import BALLS, INK, UNBALANCE, heading, look, picture, save_picture
from autobalancer.random_numbers import generator
from reproductions import Found, compared_all, said
from reproductions.spannan2021._logger import SURE
from reproductions.spannan2021.figures_6_20_and_6_21 import (
    OVAL,
    RUNS,
    SECTORS,
    WIDE,
    gatherings,
    preferred,
    rests,
    sectors,
    share,
    unbalances,
)
from reproductions.standing import standing

ORBIT, DIAMETER = 0.07695, 0.01095  # m; 5.4 g of steel
SPEED = 1200.0 * math.pi / 30.0
TILT, WIDTH, HEIGHT = "10 deg", 640, 480
FRAMES = 240.0  # pictures a second, as the camera of the source
TURN = 2.0 * math.pi


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Where rests gather by the pictures, and what the pictures add to where they are."""
    true = rests(OVAL)
    found = photographed(true.ravel())
    seen = found["ball_angle"].values[:, 0].reshape(true.shape)
    sure = found["ball_angle_deviation"].values[:, 0].reshape(true.shape)
    off = np.angle(np.exp(1j * (seen - true)))
    each = [counted(found, row, float(place)) for row, place in enumerate(unbalances())]
    whole = ab.measure.rest_histogram(single(found, range(true.size)), bins=SECTORS)
    other = int((sectors(seen) != sectors(true)).sum())
    unsure = math.sqrt(float((whole["count_deviation"] ** 2).sum()))
    scattered = sum(int((one["count"] > 0).sum()) > 1 for one in each)
    rows = [
        Found("fitted", "rests within 45 deg of a wide place, from pictures: more than 60 % (1 = true)", "1", 1.0,
              float(share(seen, WIDE) > 0.6), 0.0),
        Found("fitted", "directions around which rests gather, from pictures", "1", 2.0, gatherings(seen), 0.0),
        Found("fitted", "the first of them, against the wide place, from pictures", "deg", math.degrees(WIDE),
              preferred(seen), 10.0),
        said("rests for one unbalance scatter over several sectors, from pictures, for most unbalances", scattered > SECTORS // 2,
             "they do not depend on the start here; the scatter that the source ascribes to friction is missing"),
        Found("internal", f"error of {true.size} ball angles over their stated deviation, root mean square", "1", 1.0,
              float(np.sqrt(np.mean((off / sure) ** 2))), 0.35),
        Found("internal", f"greatest error of {true.size} ball angles from pictures of {WIDTH} by {HEIGHT}", "deg", 0.0,
              math.degrees(float(np.abs(off).max())), 0.5),
        Found("internal", f"rests of {true.size} counted in another sector than they are", "1", 0.0, other, SURE * unsure),
    ]  # fmt: skip
    draw(each, out)
    save_picture(ab.plot.answer(whole), out / "figure_6_21_from_pictures.png")
    return compared_all("Spannan 2021", "6.20, 6.21 in kind", rows)


def photographed(angles: np.ndarray) -> xr.Dataset:
    """Ball angles that the tracker reads from a picture of each rest, in order."""
    turns = generator(20).uniform(0.0, TURN, angles.size)
    runs = [standing([angle], ORBIT, DIAMETER, SPEED, turn) for angle, turn in zip(angles, turns, strict=True)]
    camera = ab.measure.film_camera(runs[0], tilt=TILT, width=WIDTH, height=HEIGHT)
    flash = ab.measure.Exposure(time="0.1 ms", noise=0.02, gradient=(0.1, 0.1))
    pictures = [
        next(iter(ab.measure.render_film(run, camera=camera, exposure=flash, end=2e-4, seed=number)))
        for number, run in enumerate(runs)
    ]
    return ab.measure.track_balls(np.array(pictures), ab.measure.film_setup(runs[0], camera), frame_rate=FRAMES)


def single(found: xr.Dataset, rows: range) -> list[xr.Dataset]:
    """Some of the pictures, each as a result of its own."""
    return [found.isel(time=[row]) for row in rows]


def counted(found: xr.Dataset, row: int, place: float) -> xr.Dataset:
    """Histogram of the rests for one unbalance, counted from it."""
    return ab.measure.rest_histogram(single(found, range(row * RUNS, (row + 1) * RUNS)), bins=SECTORS, reference=place)


def draw(each: list[xr.Dataset], out: Path) -> None:
    """Figure 6.20: one histogram for each unbalance."""
    with look():
        figure = picture(9.0, 5.4)
        panels = figure.subplots(3, 4, sharex=True, sharey=True)
        for axes, place, one in zip(panels.flat, unbalances(), each, strict=True):
            at = np.degrees(one["angle"].values)
            axes.bar(
                at, one["count"], 27.0, yerr=one["count_deviation"], color=BALLS[0], error_kw={"lw": 0.9, "ecolor": INK}
            )
            axes.axvline(180.0, color=UNBALANCE, lw=0.8, ls=(0, (4, 3)))
            axes.set_title(f"unbalance at {math.degrees(place):.0f}°", fontsize=9)
            axes.set_xticks([0, 90, 180, 270])
        figure.supxlabel("rest from the unbalance (deg); dashed: the ideal place")
        figure.supylabel(f"rests of {RUNS} run-ups")
        heading(figure, "Spannan 2021, figure 6.20 from pictures of the simulated race")
        save_picture(figure, out / "figure_6_20_from_pictures.png")

"""Section 6.2: photographs from the side, rectified by a homography, give the ball angles within 2 degrees.

The photographs themselves are not at hand. In their place a camera draws the disk with its two balls at the angles that figure 10
shows from 3000 rpm on, seen past a bearing at 35 degrees, with noise; they are then read blind, by search and by a hand that is
sure to 1.5 pixels. So this checks the reading of photographs, and is no measurement done again.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.plots.style import save_picture
from autobalancer.random_numbers import generator
from reproductions import Found, compared_all, said
from reproductions.rodrigues2011.balls import DIAMETER, ORBIT
from reproductions.rodrigues2011.rig import DATA, RPM
from reproductions.standing import standing

WITHIN, HAND, SLOWEST = 2.0, 1.5, 3000  # deg, as the source estimates; pixels; rpm
TILT = "35 deg"
SPEED = 4000.0 * RPM


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Greatest errors of the angles, found and clicked, and what they would be without rectification."""
    found, clicked, flat, results = [], [], [], []
    hand = generator(10)
    for number, angles in enumerate(pairs()):
        run = standing(np.radians(angles), ORBIT, DIAMETER, SPEED)
        camera = ab.measure.film_camera(run, tilt=TILT, width=640, height=480, turning=True)
        exposure = ab.measure.Exposure(noise=0.02, gradient=(0.15, 0.1))
        picture = next(iter(ab.measure.render_film(run, camera=camera, exposure=exposure, end=2e-4, seed=number)))
        setup = ab.measure.film_setup(run, camera)
        known = np.sort(np.radians(angles))
        view, height = camera.view(), 0.5 * DIAMETER
        exact = view.pixels([[ORBIT * np.cos(a), ORBIT * np.sin(a), height] for a in known])
        seen = ab.measure.photographed_angles(picture, setup)
        byhand = ab.measure.photographed_angles(picture, setup, clicked=exact + hand.normal(0.0, HAND, (2, 2)))
        found.append(degrees(seen["ball_angle"].values - known))
        clicked.append(degrees(byhand["ball_angle"].values - known))
        middle = view.pixels([0.0, 0.0, height])
        as_seen = np.arctan2(middle[1] - exact[:, 1], exact[:, 0] - middle[0])
        flat.append(degrees(as_seen - known))
        results.append(seen)
    save_picture(ab.plot.answer(ab.measure.rest_histogram(results, bins=24)), out / "photographs.png")
    worst, hands, without = (float(np.abs(away).max()) for away in (found, clicked, flat))
    note = "drawn photographs: those of the source are not at hand"
    rows = [
        Found(
            "internal", f"greatest error of angles found in {len(found)} photographs", "deg", 0.0, worst, WITHIN, note
        ),
        Found("internal", f"the same, clicked within {HAND:g} pixels", "deg", 0.0, hands, WITHIN, note),
        said(f"read without rectification they err by more than 2 degrees: {without:.2g} degrees", without > WITHIN),
    ]
    return compared_all("Rodrigues 2011", "10", rows)


def pairs() -> list[tuple[float, float]]:
    """Angles of both balls in each photograph from 3000 rpm on, degrees from the light spot."""
    with (DATA / "fig10_ball_positions_measured.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if int(row["speed_rpm"]) >= SLOWEST]
    at = {(r["panel"], r["run"], int(r["drawing_order"])): float(r["ball_angle_from_light_spot_deg"]) for r in rows}
    return [
        (angle, at[panel, run, order + 1])
        for (panel, run, order), angle in at.items()
        if order % 2 == 1 and (panel, run, order + 1) in at
    ]


def degrees(angle: np.ndarray) -> np.ndarray:
    """Within -180 to 180 degrees."""
    return np.asarray(np.degrees(np.angle(np.exp(1j * angle))))

"""Ball angles of figure 14b, read from photographs of the simulated rig.

The balls of the rig with two washers, with the numbers that the source used for this figure (figure_14), come to rest at speeds
above the resonances. A camera that looks past a bearing, at 35 degrees, takes a photograph of the disk at each; both balls are
found by search. The photographs are drawn, since those of the source are not at hand, and its figure is computed; what a reading
within the 2 degrees of section 6.2 would have shown is compared with it. Angles count from the light spot.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.plots.style import BALLS, UNBALANCE, heading, legend, look, picture, save_picture
from reproductions import Found, compared_all
from reproductions.rodrigues2011.balls import DIAMETER, OFF, ORBIT, RACE, from_heavy_spot, with_balls, with_unbalance
from reproductions.rodrigues2011.figure_14 import angles, steady_angles
from reproductions.rodrigues2011.photographs import TILT, WITHIN, degrees
from reproductions.rodrigues2011.rig import RPM
from reproductions.standing import standing

SLOWEST, EVERY = 2700.0, 9  # rpm; of the speeds of the source


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Angles in the photographs against those of the figure and of the simulation."""
    speeds, printed = steady_angles()
    chosen = np.flatnonzero(speeds >= SLOWEST)[::EVERY]
    speeds, printed = speeds[chosen], np.sort(printed[chosen], axis=1)
    true = np.sort(simulated(speeds), axis=1)
    seen = [photographed(pair, speed, number) for number, (pair, speed) in enumerate(zip(true, speeds, strict=True))]
    read, sure = (np.array([one[k] for one in seen]) for k in (0, 1))
    draw(speeds, printed, read, sure, out)
    at = f"two balls at {speeds.size} speeds from {speeds[0]:g} rpm"
    rows = [
        Found("fitted", f"(b) angles read from photographs against the figure, greatest deviation, {at}", "deg", 0.0,
              float(np.abs(degrees(np.radians(read - printed))).max()), WITHIN),
        Found("internal", f"angles read from photographs against the simulation, greatest error, {at}", "deg", 0.0,
              float(np.abs(degrees(np.radians(read - true))).max()), WITHIN),
    ]  # fmt: skip
    return compared_all("Rodrigues 2011", "14", rows)


def simulated(speeds: np.ndarray) -> np.ndarray:
    """Where the balls come to rest, degrees from the light spot, (speeds, balls)."""
    heavy = np.radians(210.0)
    machine = with_unbalance(with_balls(0.1, 2), 1.93e-5, heavy, 4.584e-5)
    machine = with_value_at(machine, f"{RACE}balls[1].start_angles", (heavy, heavy + OFF))
    return np.asarray(angles(from_heavy_spot(machine, speeds, dwell=9.0, window=3.0), machine))


def photographed(pair: np.ndarray, speed: float, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles of both balls and their standard deviations as one photograph shows them, degrees."""
    run = standing(np.radians(pair), ORBIT, DIAMETER, speed * RPM)
    camera = ab.measure.film_camera(run, tilt=TILT, width=640, height=480, turning=True)
    exposure = ab.measure.Exposure(noise=0.02, gradient=(0.15, 0.1))
    photograph = next(iter(ab.measure.render_film(run, camera=camera, exposure=exposure, end=2e-4, seed=number)))
    found = ab.measure.photographed_angles(photograph, ab.measure.film_setup(run, camera))
    return np.degrees(found["ball_angle"].values), np.degrees(found["ball_angle_deviation"].values)


def draw(speeds: np.ndarray, printed: np.ndarray, read: np.ndarray, sure: np.ndarray, out: Path) -> None:
    """Figure 14b above the resonances, with what was read."""
    with look():
        figure = picture(6.8, 4.0)
        axes = figure.subplots()
        for ball in (0, 1):
            names = ("figure of the source", "from photographs, 95 %") if ball == 0 else (None, None)
            axes.plot(speeds, printed[:, ball], "-", color=UNBALANCE, lw=0.9, label=names[0])
            axes.errorbar(speeds, read[:, ball], 2.0 * sure[:, ball], fmt="o", ms=5, mfc="none", color=BALLS[0], capsize=2,
                          label=names[1])  # fmt: skip
        axes.set(xlabel="rotor speed (rpm)", ylabel="ball angle from the light spot (°)", yticks=range(-180, 181, 45))
        legend(axes)
        heading(figure, "Rodrigues 2011, figure 14b: ball angles from photographs")
        save_picture(figure, out / "figure_14b_from_photographs.png")

"""Section 4.2.3 in kind: where adherence lets a ball rest near its balanced place, and how wide that interval is.

The source describes it without numbers. One ball that can balance the unbalance exactly, on a supercritical planar rotor in
its steady whirl: the interval has a closed form. Both ends are found by halving between starts that stay and starts that leave.
Balls from nearly all around come to rest inside. A second interval lies around the heavy place (figure 4.6 of the source),
where the force along the race is as small; a ball that begins there does not find its way.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab
from autobalancer.laws.stall import rest_interval
from autobalancer.machine import Machine
from autobalancer.plots.style import save_picture
from reproductions import Found, compared_all, said

MASS, STIFFNESS, ORBIT, BALL, SPEED, ADHERENCE = 10.0, 4e5, 0.1, 0.01, 300.0, 4e-4
STARTS = np.radians(np.linspace(-150.0, 150.0, 24))
HALVINGS, FAR = 17, math.radians(60.0)


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Ends of the intervals, simulated against the closed form, and rests from many starts."""
    misses = []
    for damping, heavy in ((0.0, False), (200.0, False), (200.0, True)):
        expected = np.degrees(closed(damping, heavy))
        found = np.degrees([end(side, damping, heavy) for side in (-1.0, 1.0)])
        misses.append(100.0 * np.abs(found - expected).max() / np.ptp(expected))
    rests = np.array([rest(float(start)) for start in STARTS])
    low, high = closed(200.0, False)
    inside = (rests[:, 0] >= low) & (rests[:, 0] <= high) & (rests[:, 1] == 1.0)
    rows = [
        Found("internal", "ends of three rest intervals against their closed form, farthest, over the width", "%", 0.0,
              float(max(misses)), 0.1),
        said("24 balls from up to 150 deg away all come to rest inside", bool(inside.all())),
        said("a ball 165 deg away rests near the heavy place", stuck()),
    ]  # fmt: skip
    draw(rests, out)
    return compared_all("Spannan 2021", "4.2.3 in kind", rows)


def closed(damping: float, heavy: bool) -> tuple[float, float]:
    """Ends of the interval, rad from its place."""
    rotor = {"mass": MASS + BALL, "stiffness": STIFFNESS, "damping": damping, "speed": SPEED}
    return rest_interval(BALL * ORBIT, BALL * ORBIT, ORBIT, ADHERENCE, **rotor, heavy=heavy)


def machine(start: float, damping: float, drag: float, steady: bool) -> Machine:
    """The rotor with its ball at ``start`` from the balanced place, in its steady whirl or at rest."""
    race = {
        "orbit_radius": ORBIT,
        "drag": {"law": "viscous", "damping": drag},
        "friction": {"rolling_resistance": 0.5 * ADHERENCE, "adherence": ADHERENCE},
        "balls": [{"mass": BALL, "diameter": 0.01, "start_angles": [math.pi + start]}],
    }
    gain = SPEED**2 / complex(STIFFNESS - (MASS + BALL) * SPEED**2, damping * SPEED)
    z = BALL * ORBIT * (1.0 - np.exp(1j * start)) * gain if steady else 0j
    return Machine(
        name="one ball that sticks",
        axis="vertical",
        rotor={"mass": MASS, "stiffness": STIFFNESS, "damping": damping},
        unbalances=[{"moment": BALL * ORBIT}],
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}},
        start={"deflection": (z.real, z.imag), "velocity": ((1j * SPEED * z).real, (1j * SPEED * z).imag)},
    )


def end(side: float, damping: float, heavy: bool) -> float:
    """An end of an interval, rad from its place, by halving between a ball that stays and one that leaves."""
    stays, place = float(np.mean(closed(damping, heavy))), math.pi if heavy else 0.0
    leaves = side * FAR
    for _ in range(HALVINGS):
        middle = 0.5 * (stays + leaves)
        run = ab.simulate(machine(place + middle, damping, 1e-4, True), duration=0.3, save=ab.Samples(31))
        stays, leaves = (middle, leaves) if bool(run["ball_at_rest"].all()) else (stays, middle)
    return 0.5 * (stays + leaves)


def stuck() -> bool:
    """Whether a ball that begins 15 degrees from the heavy place rests there."""
    place, still = rest(math.radians(-165.0))
    low, high = closed(200.0, True)
    return bool(still and low <= math.remainder(place - math.pi, 2.0 * math.pi) <= high)


def rest(start: float) -> tuple[float, float]:
    """Where a ball from ``start`` comes to rest, rad from the balanced place, and whether it does."""
    run = ab.simulate(machine(start, 200.0, 2e-3, False), duration=20.0, save=ab.Samples(2))
    place = math.remainder(float(run["ball_angle_in_rotor"][-1, 0]) - math.pi, 2.0 * math.pi)
    return place, float(run["ball_at_rest"][-1, 0])


def draw(rests: np.ndarray, out: Path) -> None:
    """Rests over starts, with the interval."""
    figure, axes = plt.subplots(figsize=(5.6, 3.6), layout="constrained")
    axes.axhspan(*np.degrees(closed(200.0, False)), color="0.9", label="closed form")
    axes.plot(np.degrees(STARTS), np.degrees(rests[:, 0]), "o", ms=4, label="simulated")
    axes.set(xlabel="start against the balanced place in deg", ylabel="rest against it in deg")
    axes.legend()
    save_picture(figure, out / "rest_interval.png")

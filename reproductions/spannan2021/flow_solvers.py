"""Chapter 3 in kind: flow in the annulus of the discoidal rig (table 6.2) against closed forms, and the order of both solvers.

The source solves the axisymmetric equations by finite differences; its outlook is a spectral method. Impulsive spin-up and
the lag behind a ramp have exact series where the fluid is so slow that it only diffuses; a pair of unequal cylinders ends in
circular Couette flow. Ekman spin-up of thin oil stands with figure 5.6. Orders come from runs on refined grids and steps,
with a smooth run-up and the secondary flow it drives, against a fine spectral solution.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from autobalancer.flow.annulus import Annulus, Walls
from autobalancer.flow.differences import DifferenceFlow
from autobalancer.flow.relaxation import all_modes
from autobalancer.flow.spectral import SpectralFlow
from autobalancer.flow.speed import wall_speed
from autobalancer.machine import Hill, Ramp
from autobalancer.plots.save import save_picture
from reproductions import compared_all

SLOW = 1e-3  # rad/s: no secondary flow
SMOOTH, UNTIL = Hill(end=40.0, half_time=0.2, exponent=6.0), 0.2
GRIDS, STEPS, SPECTRAL = (16, 24, 36), (250, 500), (8, 12, 16, 20)
SOLVERS = {"chebyshev": (SpectralFlow, 20), "differences": (DifferenceFlow, 32)}
Row = tuple[str, str, float, float, float]


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Spin-up, ramp, Couette flow, orders, and a picture of the errors over the grid."""
    rows: list[Row] = []
    for name in SOLVERS:
        rows += [
            (f"impulsive spin-up in 715 mm^2/s, orbit against the exact series, {name}", "%", 0.0, spin_up(name), 0.5),
            (f"lag behind a ramp in 715 mm^2/s, over the diffusive limit, {name}", "1", 1.0, ramp_lag(name), 5e-3),
            (f"circular Couette flow, greatest error over the wall speed, {name}", "%", 0.0, couette(name), 0.1),
        ]
    exact = orbit("chebyshev", 28, 1600)
    space = [abs(orbit("differences", n, 4 * n * n) - exact) for n in GRIDS]
    last = orbit("differences", 12, 4000)
    time = [abs(orbit("differences", 12, n) - last) for n in STEPS]
    points = [abs(orbit("chebyshev", n, 1600) - exact) for n in SPECTRAL]
    steps = [abs(orbit("chebyshev", 16, n) - orbit("chebyshev", 16, 3200)) for n in (200, 400)]
    rows += [
        ("order of the finite differences in space", "1", 2.0, order(space[1:], GRIDS[2] / GRIDS[1]), 0.3),
        ("order of the finite differences in time", "1", 2.0, order(time, 2.0), 0.3),
        ("order of the Chebyshev solver in time", "1", 3.0, order(steps, 2.0), 0.25),
        ("Chebyshev solver: every four points more gain a digit (1 = true)", "1", 1.0, gains(points), 0.0),
    ]
    draw(space, points, out)
    return compared_all("Spannan 2021", "chapter 3 in kind", rows)


def oil(viscosity: float) -> Annulus:
    """The annulus of table 6.2."""
    return Annulus(69.3e-3, 83.1e-3, 20e-3, 76.95e-3, viscosity, 950.0)


def solver(name: str, annulus: Annulus, points: int, **options: Any) -> Any:
    """A solver with equal numbers of intervals in both directions."""
    return SOLVERS[name][0](annulus, points, points, **options)


def marched(name: str, flow: Any, speed: Any, end: float) -> Any:
    """The history of a run with the solver's own steps."""
    return flow.march(speed, end, **({"tolerance": 1e-6} if name == "chebyshev" else {}))


def spin_up(name: str) -> float:
    """Greatest error at the orbit after an impulsive start, % of the wall speed, from a thirtieth of the spin-up time on."""
    annulus, start = oil(715e-6), wall_speed(SLOW, 0.0)
    track = marched(name, solver(name, annulus, SOLVERS[name][1]), start, 0.05)
    seen, late = np.array(track.times), np.array(track.times) > 1e-3
    miss = np.array(track.orbit) - all_modes(annulus).response(start, seen)
    return 100.0 * float(np.abs(miss[late]).max()) / SLOW


def ramp_lag(name: str) -> float:
    """Lag at the end of a slow ramp over the sum over all diffusion modes."""
    annulus, rate = oil(715e-6), 1e-2
    track = marched(name, solver(name, annulus, SOLVERS[name][1]), wall_speed(Ramp(end=0.3 * rate, duration=0.3)), 0.3)
    return (0.3 * rate - float(track.orbit[-1])) / (rate * all_modes(annulus).ramp_lag)


def couette(name: str) -> float:
    """Greatest error between cylinders that turn by -2 and 3 rad/s against a frame of 5 rad/s, % of the faster."""
    annulus = oil(715e-6)
    flow = solver(name, annulus, SOLVERS[name][1], walls=Walls(inner=-2.0, outer=3.0))
    marched(name, flow, wall_speed(5.0), 0.35)
    a, b, r = annulus.inner, annulus.outer, flow.radius
    exact = ((b * b * 3.0 + a * a * 2.0) + (-5.0) * a * a * b * b / r**2) / (b * b - a * a)
    return 100.0 * float(np.abs(flow.swirl / r[:, None] ** 2 - exact[:, None]).max()) / 3.0


def orbit(name: str, points: int, steps: int) -> float:
    """Fluid at the orbit at half time of a smooth run-up in 100 mm^2/s, equal steps."""
    how = {"order": 3} if name == "chebyshev" else {}
    flow = solver(name, oil(100e-6), points, **how)
    free = {"tolerance": 1.0} if name == "chebyshev" else {}
    return float(flow.march(wall_speed(SMOOTH), UNTIL, fixed=UNTIL / steps, **free).orbit[-1])


def order(errors: list[float], refined: float) -> float:
    """Order of the last two errors."""
    return math.log(errors[-2] / errors[-1]) / math.log(refined)


def gains(errors: list[float]) -> float:
    """Whether every error is below a tenth of the one before."""
    return float(all(after < 0.1 * before for before, after in pairwise(errors)))


def draw(space: list[float], points: list[float], out: Path) -> None:
    """Errors of both solvers over the number of intervals."""
    figure, axes = plt.subplots(figsize=(5.6, 3.6), layout="constrained")
    axes.loglog(GRIDS, np.array(space) / 40.0, "s-", label="finite differences")
    axes.loglog(SPECTRAL, np.array(points) / 40.0, "o-", label="Chebyshev")
    axes.set(xlabel="intervals in each direction", ylabel="error at the orbit over the greatest speed")
    axes.set_xticks([8, 12, 16, 24, 36], ["8", "12", "16", "24", "36"], minor=False)
    axes.legend()
    save_picture(figure, out / "flow_solvers.png")

"""The two solvers for the flow in an annulus against each other, at equal accuracy of the fluid's speed at the orbit.

Each runs at its fastest setting, out of a ladder of grids (and tolerances and schemes), that follows the reference within
1e-3 of the greatest speed of the rotor at all times, with three quarters as many intervals over the gap as over the height,
which are as 2 to 3. Both are compiled; the differences take the longest stable steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from tests.references.flow_differences import DifferenceFlow

from autobalancer.files.machine_file import load_race_machine
from autobalancer.flow.annulus import Annulus, annulus_of
from autobalancer.flow.relaxation import Track, wall_speed
from autobalancer.flow.solve import SpectralFlow
from autobalancer.machine import Ramp
from benchmarks import compared

MACHINE = Path(__file__).resolve().parent.parent / "examples" / "machines" / "discoidal.toml"
SPEED, GOAL = 60.0, 1e-3
Settings = dict[str, Callable[[], Track]]


def bench() -> list[dict[str, Any]]:
    """A run-up to 60 rad/s and a quarter more of its time, in 100 mm^2/s oil and in the thin one of the machine.

    In thin oil both solvers are held back by waves and convection, in viscous oil the explicit one by diffusion.
    """
    thin = annulus_of(load_race_machine(MACHINE))
    return [
        row("flow_chebyshev_vs_fd", Case(replace(thin, viscosity=5.0 * thin.viscosity), 0.5)),
        row("flow_chebyshev_vs_fd_thin", Case(thin, 4.0)),
    ]


@dataclass(frozen=True)
class Case:
    """A chamber and the duration of the run-up, s."""

    annulus: Annulus
    duration: float

    def spectral(self, points: int, tolerance: float, waves: bool = False) -> Track:
        flow = SpectralFlow(self.annulus, 3 * points // 4, points, order=2 if waves else 3, waves=waves)
        return flow.march(self.speed, 1.25 * self.duration, tolerance=tolerance)

    def differences(self, points: int) -> Track:
        return DifferenceFlow(self.annulus, 3 * points // 4, points).march(self.speed, 1.25 * self.duration)

    @property
    def speed(self) -> Any:
        return wall_speed(Ramp(end=SPEED, duration=self.duration))

    @cached_property
    def truth(self) -> np.ndarray:
        """By more points and smaller steps than needed; a test holds both solvers together."""
        return self.orbit(self.spectral(28, 1e-6))

    def orbit(self, track: Track) -> np.ndarray:
        """Speed of the fluid at the orbit at 501 times, rad/s."""
        times, _, speeds = track.arrays()
        return np.interp(np.linspace(0.0, 1.25 * self.duration, 501), times, speeds)


def row(name: str, case: Case) -> dict[str, Any]:
    us = fastest(
        case,
        {
            f"{3 * n // 4} x {n}, tolerance {t:g}, {'im' if waves else 'ex'}plicit waves": lambda n=n, t=t, waves=waves: (
                case.spectral(n, t, waves)
            )
            for n in (12, 14, 15, 16, 18, 20)
            for t, waves in ((1e-3, False), (1e-4, False), (1e-5, True), (5e-6, True), (2e-6, True))
        },
    )
    them = fastest(case, {f"{3 * n // 4} x {n}": lambda n=n: case.differences(n) for n in range(16, 97, 4)})
    note = (
        f"{1e6 * case.annulus.viscosity:.3g} mm^2/s, {1.25 * case.duration:g} s; ours: {us[1]}, error {us[2]:.1e}; "
        f"theirs: {them[1]}, error {them[2]:.1e}"
    )
    return compared(name, us[0], "finite differences, compiled", them[0], note=note)


def fastest(case: Case, settings: Settings) -> tuple[float, str, float]:
    """Seconds (the best of six), name and error of the fastest setting that reaches the goal; coarse ones come first."""
    best: tuple[float, str, float] | None = None
    for name, call in settings.items():
        error = float(np.abs(case.orbit(call()) - case.truth).max()) / SPEED
        if not error <= GOAL:
            continue
        times = []
        for _ in range(6):
            start = perf_counter()
            call()
            times.append(perf_counter() - start)
        if best is not None and min(times) > 2.0 * best[0]:
            break
        if best is None or min(times) < best[0]:
            best = (min(times), name, error)
    assert best is not None, "no setting reaches the goal"
    return best

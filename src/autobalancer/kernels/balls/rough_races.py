"""Equations of motion of a linear rotor with guided balls on real races: any path, friction, any drag, excitation."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.on_stations import gather, recover, touching
from autobalancer.kernels.balls.rates import rates_of
from autobalancer.kernels.flags import EQUATIONS, EQUATIONS_PART, njit


@njit(**EQUATIONS)
def guided_rough(time: float, y: Any, dy: Any, system: Any) -> None:
    """Guided balls on real races: paths of any shape, friction, any drag, fluid that lags, excitation."""
    for pressed in range(2):  # a number that changes: a constant would be compiled for each of its values
        if not _rough(time, y, dy, system, pressed):
            return


@njit(**EQUATIONS)
def guided_rough_tilting(time: float, y: Any, dy: Any, system: Any) -> None:
    """The same where balls feel the tilt of their race too."""
    for pressed in range(2):  # a number that changes: a constant would be compiled for each of its values
        if not _rough_tilting(time, y, dy, system, pressed):
            return


@njit(**EQUATIONS_PART)
def _rough(time, y, dy, system, pressed) -> bool:  # type: ignore[no-untyped-def]
    """Balls rub where the known part of the normal force, or (``pressed``) that found before, is positive."""
    return rates_of(time, y, dy, system, touching, gather, recover, (2, True, pressed))


@njit(**EQUATIONS_PART)
def _rough_tilting(time, y, dy, system, pressed) -> bool:  # type: ignore[no-untyped-def]
    return rates_of(time, y, dy, system, touching, gather, recover, (4, True, pressed))

"""Equations of motion of a linear rotor with guided balls on smooth circles with linear drag."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.on_stations import gather, recover, touching
from autobalancer.kernels.balls.rates import rates_of
from autobalancer.kernels.flags import EQUATIONS, njit


@njit(**EQUATIONS)
def guided(time: float, y: Any, dy: Any, system: Any) -> None:
    """Guided balls on smooth circles with linear drag; they feel the deflection of their station."""
    rates_of(time, y, dy, system, touching, gather, recover, (2, False, False))


@njit(**EQUATIONS)
def guided_tilting(time: float, y: Any, dy: Any, system: Any) -> None:
    """The same where balls feel the tilt of their race too."""
    rates_of(time, y, dy, system, touching, gather, recover, (4, False, False))

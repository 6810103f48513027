"""Tables from which contacts take what depends on the speed of an impact, see kernels/laws/rebound.py.

With a spring and a damper of ratio z, v' = -q - 2 z v and q' = v in a time of its own, with Hertz and the damper of Tsuji et
al. (1992) too (Antypov and Elliott 2011). With A^2 = v^2 + 2 z q v + q^2 and the phase s, tan(w s) = w q/(v + z q),
w^2 = 1 - z^2, the impact began at the speed A e^(z s). Where the damper would pull, the bodies have parted with e times it.

With the law of Pakuła (2021), (15), energy says it: the impact began at sqrt(v^2 + q^2) while the bodies approach, and at
sqrt(v^2/e^2 + q^2) while they part.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from autobalancer.catalog.resolve import Ball
from autobalancer.kernels.laws.rebound import DECADES, LEVELS, LOWEST, NONE, PER_DECADE, TURNS
from autobalancer.laws.rebound import LEAST, damping_ratio, slowest_rebound, wet_factor, yielding_factor
from autobalancer.machine.rebound import Rebound

Floats = NDArray[np.float64]
SPEEDS = np.logspace(LOWEST - 1.0, LOWEST + DECADES + 3.0, 2401)  # of impacts: beyond the table, as some of it is lost
LEVEL = LOWEST + np.arange(LEVELS) / PER_DECADE  # log10 of a speed
TURN = np.linspace(0.0, math.pi, TURNS)
Law = tuple[Rebound, float, float]  # restitution of slow impacts, and the speed below which a fluid leaves none (m/s)


def restitution_at(law: Law, speeds: Floats, least_left: float = LEAST) -> Floats:
    """Restitution of impacts at these speeds (m/s), ``least_left`` where it is less: 0.01 of contacts that are not rigid."""
    rebound, slow, least = law
    factor = np.ones_like(speeds)
    if rebound.yield_speed is not None:
        factor = yielding_factor(speeds, float(rebound.yield_speed), float(rebound.exponent))
    elif rebound.speeds:
        factor = np.interp(speeds, rebound.speeds, rebound.factors)
    if least > 0.0:
        factor = factor * wet_factor(speeds, least)
    return np.maximum(slow * factor, least_left)


def least_rebound(rebound: Rebound | None, one: Ball, other: Ball | None = None) -> float:
    """The speed below which a ball does not rebound from another, or from a wall, m/s; 0 without a fluid."""
    if rebound is None or rebound.critical_stokes is None:
        return 0.0
    mass, radius = one.mass, one.radius
    if other is not None:
        mass, radius = 1.0 / (1.0 / mass + 1.0 / other.mass), 1.0 / (1.0 / radius + 1.0 / other.radius)
    return slowest_rebound(float(rebound.critical_stokes), mass, radius, one.fluid_density * one.fluid_viscosity)


class Tables:
    """The tables of a machine one behind the other; equal contacts share one.

    ``kind`` is ``dampers``, ``shares`` or, of rigid contacts, ``remainders``.
    """

    def __init__(self, kind: Callable[[Law], Floats]) -> None:
        self._kind = kind
        self._first: dict[tuple[Callable[[Law], Floats], Law], int] = {}
        self._tables: list[Floats] = []

    def first(
        self, rebound: Rebound | None, slow: float, least: float, kind: Callable[[Law], Floats] | None = None
    ) -> int:
        """Where the table of a contact begins, NONE without one; restitution of slow impacts and speed without any (m/s).

        It may be of another ``kind``.
        """
        if rebound is None:
            return NONE
        kind = kind or self._kind
        law = (rebound, slow, float(f"{least:.9g}"))  # the same for equal balls, however it was rounded
        if (kind, law) not in self._first:
            self._first[kind, law] = sum(table.size for table in self._tables)
            self._tables.append(kind(law))
        return self._first[kind, law]

    @property
    def numbers(self) -> Floats:
        """All tables."""
        return np.concatenate([*self._tables, np.zeros(0)])


@lru_cache(maxsize=64)
def dampers(law: Law) -> Floats:
    """Damping ratios, (SIZE,)."""
    left = restitution_at(law, SPEEDS)
    ratio = _ratios(left)[:, None]
    kept = np.empty((SPEEDS.size, TURNS))
    q, v = np.sin(TURN), np.cos(TURN)
    ahead = v + ratio * q
    width = np.sqrt(np.abs(1.0 - ratio**2))
    with np.errstate(invalid="ignore", divide="ignore"):
        under = np.arctan2(width * q, ahead) / width
        over = np.arctanh(width * q / ahead) / width
        phase = np.where(ratio < 1.0, under, over)
        kept = np.exp(-ratio * phase) / np.sqrt(1.0 + 2.0 * ratio * q * v)
        parted = np.where(v < 0.0, left[:, None] / np.abs(v), np.inf)
    # a path ends where the force does
    kept = np.where(q + 2.0 * ratio * v < 0.0, parted, kept)
    kept[:, -1] = left
    return _over_the_plane(kept, ratio[:, 0])


@lru_cache(maxsize=64)
def shares(law: Law) -> Floats:
    """Restitution squared, (SIZE,)."""
    left = restitution_at(law, SPEEDS)[:, None]
    loss = np.where(np.cos(TURN) < 0.0, 1.0 / left**2, 1.0)
    return _over_the_plane(1.0 / np.sqrt(np.sin(TURN) ** 2 + np.cos(TURN) ** 2 * loss), left[:, 0] ** 2)


@lru_cache(maxsize=64)
def remainders(law: Law) -> Floats:
    """Restitution over the logarithm of the speed, (LEVELS,)."""
    return restitution_at(law, 10.0**LEVEL, 0.0)


def _over_the_plane(kept: Floats, values: Floats) -> Floats:
    """``values`` of impacts over angle and distance; ``kept`` is the distance over the speed at which they began."""
    reached = np.log10(SPEEDS)[:, None] + np.log10(kept)
    table = np.stack([np.interp(LEVEL, np.maximum.accumulate(reached[:, i]), values) for i in range(TURNS)])
    table.setflags(write=False)
    return np.asarray(table.ravel())


@lru_cache(maxsize=1)
def _known() -> tuple[Floats, Floats]:
    """Damping ratios over what they leave, ascending."""
    left = np.concatenate([np.geomspace(LEAST, 0.5, 200), np.linspace(0.5, 1.0, 400)[1:]])
    return left, np.array([damping_ratio(float(e)) for e in left])


def _ratios(left: Floats) -> Floats:
    return np.asarray(np.interp(left, *_known()))

"""Balanced states whose stability needs more than a polynomial: any balls, any supports."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.states.floquet import periodic_state
from autobalancer.stability.states.linear import eigensystem, kept, matrices
from autobalancer.stability.states.planar import Equilibrium, close_polygon, states_about

SAMPLES = 24  # of a continuum of unequal balls


def target(p: Plane, speed: float, center: complex) -> complex:
    """What the balls of races with this center have to add up to so that these run true, kg m."""
    if center == 0.0:
        return -p.fixed_load
    return -center * p.dynamic_stiffness(speed) / speed**2 - p.fixed_load


def running_true(p: Plane, speed: float) -> list[Equilibrium]:
    """The states in which at least one race runs true."""
    stiffness = p.dynamic_stiffness(speed)
    centers = sorted({complex(c) for c in p.offset}, key=lambda c: (abs(c), cmath.phase(c)))
    return [state for center in centers for state in states_about(p, speed, stiffness, center)]


@dataclass(frozen=True)
class AnyBalls:
    """Balls on isotropic supports. ``leading`` are directions of all but the two heaviest balls, from the target on."""

    plane: Plane
    leading: tuple[float, ...] | None = None  # None: the states in which a race runs true
    route: str = "eigenvalues"

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; of several states the most stable one."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        found = [self._growth(speed, state) for state in self.states(speed)]
        return min(found, default=math.nan)

    def _growth(self, speed: float, state: Equilibrium) -> float:
        values, _ = eigensystem(*matrices(self.plane, speed, state))
        return float(kept(values, state.freedom).real.max())

    def states(self, speed: float) -> list[Equilibrium]:
        """The balanced states at a speed."""
        p = self.plane
        if p.dynamic_stiffness(speed) == 0.0:
            return []
        if self.leading is None:
            return running_true(p, speed)
        center = complex(p.offset[0])
        wanted = target(p, speed, center)
        order = np.argsort(-p.moment, kind="stable")
        angles = np.empty(p.moment.size)
        angles[order[2:]] = cmath.phase(wanted) + np.array(self.leading)
        rest = wanted - complex((p.moment[order[2:]] * np.exp(1j * angles[order[2:]])).sum())
        for pair in close_polygon(p.moment[order[:2]], rest)[:1]:
            angles[order[:2]] = pair
            return [Equilibrium("balanced", angles, -center, p.moment.size - 2, 0)]
        return []


@dataclass(frozen=True)
class OnOrthotropicSupports:
    """Multipliers over a revolution; of several states the most stable one, of a continuum one member."""

    machine: Machine
    plane: Plane
    route: str = "multipliers"

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; nan also where no periodic state is found."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        p = self.plane
        if p.dynamic_stiffness(speed) == 0.0:
            return math.nan
        states = running_true(p, speed)
        if np.ptp(p.moment) == 0.0:
            states = states[:1]  # the mirror image is an exchange of equal balls
        found = []
        for state in states:
            try:
                values = periodic_state(self.machine, p, speed, state).exponents
            except QuestionError:  # shooting found nothing there
                continue
            found.append(float(kept(values, state.freedom).real.max()))
        return min(found, default=math.nan)


def sampled(p: Plane) -> list[AnyBalls]:
    """Places of all but two balls, drawn evenly, for which the other two can close the sum at high speed."""
    random = np.random.default_rng(0)
    high = 40.0 * math.sqrt(p.stiffness[0] / p.mass)
    found: list[AnyBalls] = []
    for _ in range(40 * SAMPLES):
        member = AnyBalls(p, tuple(random.uniform(-math.pi, math.pi, p.moment.size - 2)))
        if member.states(high):
            found.append(member)
        if len(found) == SAMPLES:
            break
    return found

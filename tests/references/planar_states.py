"""All states in which the balls rest in a rotor that turns at constant speed.

With the forward whirl Z of the race center (constant in the rotor) and the dynamic stiffness D a rotor with balls at
rest obeys D Z = W^2 (U + sum m E + sum m eps e^(i phi)), and a ball rests where the vector from the axis of rotation
to its race center, c = Z + E, has no component across the ball: Im(e^(-i phi) c) = 0. So in each race either

- c = 0: the race runs true, its balls may stand anywhere as long as they close the sum (*balanced*), or
- every ball stands along c, outward (+) or inward (-): *coincident* if all balls of the race are on one side, *in
  line* otherwise.

For races with one center this leaves a quadratic for each net moment, so that none is missed. On orthotropic supports
D is that of the forward component and the states are those of the averaged torque (Spannan 2021, 4.25-4.29 with the
signs corrected); the ripple at twice the speed is found by Floquet theory.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.stability.host.stations import Plane
from autobalancer.stability.states.ball_positions import PATTERNS, close_polygon


@dataclass(frozen=True)
class Equilibrium:
    """One state of rest in the rotor.

    ``freedom`` is the dimension of the continuum to which it belongs: n - 2 for n > 2 balls in a race that runs true.
    """

    name: str  # balanced, coincident, in line
    angles: Floats  # (n,) ball angles in the rotor, rad
    whirl: complex  # Z, deflection in the rotor, m
    freedom: int
    outward: int  # balls that stand outward (of the races that do not run true)


def equilibria_of(p: Plane, speed: float) -> list[Equilibrium]:
    """All of them, balanced ones first, then by deflection.

    Raises
    ------
    QuestionError
        At standstill, or at a critical speed of an undamped rotor, where its deflection is not determined.
    """
    if not (math.isfinite(speed) and speed > 0.0):
        raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")
    stiffness = p.dynamic_stiffness(speed)
    if stiffness == 0.0:
        raise QuestionError(
            f"speed: {speed:.6g} rad/s is a critical speed of an undamped rotor, where its deflection is not determined"
        )
    if p.moment.size == 0:
        return [Equilibrium("no balls", np.zeros(0), _whirl(p, np.zeros(0), speed), 0, 0)]
    found = balanced_about(p, speed, stiffness)
    found += (
        _aligned(p, speed, stiffness) if len(set(p.offset.tolist())) > 1 else _aligned_one_center(p, speed, stiffness)
    )
    order = {"balanced": 0, "coincident": 1, "in line": 2}
    return sorted(found, key=lambda e: (order[e.name], abs(e.whirl)))


def balanced_about(p: Plane, speed: float, stiffness: complex) -> list[Equilibrium]:
    """The states in which races of some center run true."""
    centers = sorted({complex(c) for c in p.offset}, key=lambda c: (abs(c), cmath.phase(c)))
    return [state for center in centers for state in states_about(p, speed, stiffness, center)]


def backward_whirl(p: Plane, speed: float, whirl: complex) -> complex:
    """The backward component of the whirl that comes with the forward component ``whirl``: z = a e^iWt + b e^-iWt."""
    x, y = (complex(k - p.mass * speed**2, b * speed) for k, b in zip(p.stiffness, p.damping, strict=True))
    return complex(np.conj(whirl * (y - x) / (y + x)))


def _whirl(p: Plane, angles: Floats, speed: float) -> complex:
    load = p.fixed_load + complex((p.moment * np.exp(1j * angles)).sum())
    return speed**2 * load / p.dynamic_stiffness(speed)


def states_about(p: Plane, speed: float, stiffness: complex, center: complex) -> list[Equilibrium]:
    """States in which the races with this center run true; other races stand along their own vector."""
    free = np.isclose(p.offset, center, rtol=0.0, atol=1e-15)
    others = np.flatnonzero(~free)
    if 2 ** len(others) > PATTERNS:
        raise QuestionError(f"steady states: {len(others)} balls in other races have too many arrangements to try all")
    found = []
    for signs in product((1.0, -1.0), repeat=len(others)):
        angles = np.zeros(p.moment.size)
        for ball, sign in zip(others, signs, strict=True):
            angles[ball] = cmath.phase(sign * (p.offset[ball] - center))
        placed = complex((p.moment[others] * np.exp(1j * angles[others])).sum())
        target = -center * stiffness / speed**2 - p.fixed_load - placed
        for closing in close_polygon(p.moment[free], target):
            full = angles.copy()
            full[free] = closing
            freedom = max(int(free.sum()) - 2, 0)
            found.append(Equilibrium("balanced", full, -center, freedom, int(sum(s > 0 for s in signs))))
    return found


def net_moments(p: Plane) -> dict[float, Floats]:
    """Net moments of balls in a row, outward counted +, each with one pattern of signs that makes it."""
    kinds, place = np.unique(p.moment, return_inverse=True)
    counts = np.bincount(place)
    if int(np.prod(counts + 1)) > PATTERNS:
        raise QuestionError("steady states: too many different balls to try all arrangements")
    found: dict[float, Floats] = {}
    for outward in product(*(range(int(count) + 1) for count in counts)):
        signs = np.empty(p.moment.size)
        for kind in range(kinds.size):
            members = np.flatnonzero(place == kind)
            signs[members] = -1.0
            signs[members[: outward[kind]]] = 1.0
        found.setdefault(round(float((signs * p.moment).sum()), 18), signs)
    return found


def _aligned_one_center(p: Plane, speed: float, stiffness: complex) -> list[Equilibrium]:
    """All balls along c = rho e^(i psi): e^(i psi) (rho D / W^2 - net) = F, a quadratic in rho for each net moment."""
    center = complex(p.offset[0])
    d = stiffness / speed**2
    force = p.fixed_load + center * d
    found = []
    for net, signs in net_moments(p).items():
        # |rho d - net|^2 = |F|^2 ; rho < 0 is the same state as -rho with all signs turned, which has its own entry
        a, b, c = abs(d) ** 2, -2.0 * net * d.real, net**2 - abs(force) ** 2
        root = b * b - 4.0 * a * c
        if root < 0.0:
            continue
        for rho in {(-b + s * math.sqrt(root)) / (2.0 * a) for s in (1.0, -1.0)}:
            side = rho * d - net
            if rho <= 0.0 or abs(side) == 0.0 or abs(force) == 0.0:
                continue
            psi = cmath.phase(force / side)
            angles = np.array([psi if sign > 0.0 else psi + math.pi for sign in signs])
            found.append(_named(signs, p, angles, rho * cmath.exp(1j * psi) - center))
    return found


def _aligned(p: Plane, speed: float, stiffness: complex) -> list[Equilibrium]:
    """Races with different centers: the two components of Z from many starts, for each pattern of signs."""
    from scipy.optimize import fsolve

    n = p.moment.size
    if 2**n > PATTERNS:
        raise QuestionError(
            f"steady states: {n} balls in races of different centers have too many arrangements to try all"
        )
    scale = (abs(p.fixed_load) + p.moment.sum()) * speed**2 / abs(stiffness) + np.abs(p.offset).max()
    found: list[Equilibrium] = []

    for pattern in product((1.0, -1.0), repeat=n):
        signs = np.array(pattern)

        def miss(z: Floats, signs: Floats = signs) -> list[float]:
            whirl = complex(z[0], z[1]) * scale
            c = whirl + p.offset
            load = p.fixed_load + complex((p.moment * signs * c / np.abs(c)).sum())
            error = (stiffness * whirl / speed**2 - load) / (abs(p.fixed_load) + p.moment.sum())
            return [error.real, error.imag]

        seen: list[complex] = []
        for size, angle in product((0.03, 0.3, 1.0), np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)):
            z, _, flag, _ = fsolve(miss, [size * math.cos(angle), size * math.sin(angle)], full_output=True, xtol=1e-13)
            whirl = complex(z[0], z[1]) * scale
            if flag == 1 and max(map(abs, miss(z))) < 1e-9 and all(abs(whirl - other) > 1e-7 * scale for other in seen):
                seen.append(whirl)
                found.append(_named(signs, p, np.angle(signs * (whirl + p.offset)), whirl))
    return found


def _named(signs: Floats, p: Plane, angles: Floats, whirl: complex) -> Equilibrium:
    one_side = all(len(set(signs[p.race == race])) == 1 for race in set(p.race.tolist())) and len(set(signs)) == 1
    return Equilibrium("coincident" if one_side else "in line", angles, whirl, 0, int((signs > 0.0).sum()))

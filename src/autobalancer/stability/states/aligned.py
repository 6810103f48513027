"""Stations that do not run true: every ball stands along the vector c from the axis of rotation to its race center.

With one center per station and its net moment n_p (balls outward counted +) in the direction psi_p of c_p,

    c_p = b_p + sum over q of h_pq n_q e^(i psi_q),    Im[e^(-i psi_p) c_p] = 0,    Re[e^(-i psi_p) c_p] > 0.

One station: a quadratic. Two stations: with x, y = e^(i psi) both conditions are quadratic in x, and their resultant is
a polynomial of degree six in y, so that no state is missed. More stations, or several centers at a station: Newton's
method from many starts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.states.planar import PATTERNS

STARTS = 40  # a pattern of balls; times the number of stations
OFF_CIRCLE = 0.02  # roots of the resultant that are farther from the unit circle are none


@dataclass(frozen=True)
class Aligned:
    """Whirl of A stations, Z = ``free`` + ``host`` . moments; SI."""

    host: Complexes  # (A, A) W^2 H
    free: Complexes  # (A,)
    balls: list[NDArray[np.int64]]  # numbers of the balls of each station
    moment: Floats  # (n,) of all balls of the machine
    offset: Complexes  # (n,)


def directions_of(a: Aligned) -> list[dict[int, float]]:
    """Ball angles of all solutions that are found, rad."""
    if any(np.ptp(a.offset[balls].real) or np.ptp(a.offset[balls].imag) for balls in a.balls) or len(a.balls) > 2:
        return _searched(a)
    centers = np.array([a.offset[balls[0]] for balls in a.balls])
    found = []
    for signs in product(*(_net(a.moment[balls]) for balls in a.balls)):
        nets = np.array([float(sign @ a.moment[balls]) for sign, balls in zip(signs, a.balls, strict=True)])
        solve = _one if len(a.balls) == 1 else _two
        for psi in solve(a.host * nets, a.free + centers):
            found.append(_placed(a, signs, psi))
    return found


def _placed(a: Aligned, signs: tuple[Floats, ...], psi: Floats) -> dict[int, float]:
    return {
        int(ball): float(angle if sign > 0.0 else angle + math.pi)
        for balls, side, angle in zip(a.balls, signs, psi, strict=True)
        for ball, sign in zip(balls, side, strict=True)
    }


def _net(moment: Floats) -> list[Floats]:
    """Patterns of signs, one for each net moment."""
    kinds, place = np.unique(moment, return_inverse=True)
    counts = np.bincount(place)
    if int(np.prod(counts + 1)) > PATTERNS:
        raise QuestionError("steady states: too many different balls to try all arrangements")
    found: dict[float, Floats] = {}
    for outward in product(*(range(int(count) + 1) for count in counts)):
        signs = np.empty(moment.size)
        for kind in range(kinds.size):
            members = np.flatnonzero(place == kind)
            signs[members] = -1.0
            signs[members[: outward[kind]]] = 1.0
        found.setdefault(round(float(signs @ moment), 18), signs)
    return list(found.values())


def _one(h: Complexes, b: Complexes) -> Iterator[Floats]:
    """e^(i psi) (rho - h) = b, a quadratic in rho > 0."""
    own, force = complex(h[0, 0]), complex(b[0])
    under = abs(force) ** 2 - own.imag**2
    if under < 0.0 or force == 0.0:
        return
    for rho in {own.real + math.sqrt(under), own.real - math.sqrt(under)}:
        if rho > 1e-13 * (abs(own) + abs(force)):
            yield np.array([np.angle(force / (rho - own))])


def _two(h: Complexes, b: Complexes) -> list[Floats]:
    if np.abs(b).max() <= 1e-14 * np.abs(h).max():
        return []  # nothing breaks the symmetry of turning: such states are a continuum that is not isolated
    size = np.maximum(np.abs(b), np.abs(h).sum(axis=1))
    h, b = h / size[:, None], b / size
    y = Polynomial([0.0, 1.0])
    a1, b1, c1 = -(np.conj(b[0]) * y + np.conj(h[0, 1])), 2j * h[0, 0].imag * y, b[0] * y + h[0, 1] * y**2
    a2, b2, c2 = h[1, 0] + 0.0 * y, b[1] + 2j * h[1, 1].imag * y - np.conj(b[1]) * y**2, -np.conj(h[1, 0]) * y**2
    resultant = (a1 * c2 - a2 * c1) ** 2 - (a1 * b2 - a2 * b1) * (b1 * c2 - b2 * c1)
    found: list[Floats] = []
    for second in resultant.roots():
        if abs(abs(second) - 1.0) > OFF_CIRCLE:
            continue
        for first in np.roots([a1(second), b1(second), c1(second)]):
            if abs(abs(first) - 1.0) < OFF_CIRCLE:
                _add(found, _polished(h, b, np.angle([first, second])))
    return found


def _add(found: list[Floats], psi: Floats | None) -> None:
    if psi is not None and not any(np.abs(np.exp(1j * psi) - np.exp(1j * old)).max() < 1e-7 for old in found):
        found.append(psi)


def _polished(h: Complexes, b: Complexes, psi: Floats) -> Floats | None:
    """Newton's method; none if it does not converge, or a ball would stand the other way round."""
    for _ in range(30):
        turn = np.exp(1j * psi)
        c = b + h @ turn
        miss = (c / turn).imag
        slope = ((1j * h * turn) / turn[:, None]).imag - np.diag((c / turn).real)
        step = np.linalg.lstsq(slope, -miss, rcond=1e-12)[0]
        psi = psi + step * min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300))
        if np.abs(step).max() < 1e-15:
            break
    turn = np.exp(1j * psi)
    along = (b + h @ turn) / turn
    if np.abs(along.imag).max() > 1e-11 or not (along.real > 1e-13).all():
        return None
    return np.asarray(psi)


def _searched(a: Aligned) -> list[dict[int, float]]:
    """Any number of stations and centers: the whirl by Newton's method for each pattern of signs."""
    from scipy.optimize import root

    balls = np.concatenate(a.balls)
    place = np.repeat(np.arange(len(a.balls)), [len(own) for own in a.balls])
    if 2 ** len(balls) > PATTERNS:
        raise QuestionError(f"steady states: {len(balls)} balls at such stations have too many arrangements to try all")
    moment, offset = a.moment[balls], a.offset[balls]
    scale = np.abs(a.free).max() + float((np.abs(a.host).max() * moment).sum()) + float(np.abs(offset).max())
    random = np.random.default_rng(0)
    count = len(a.balls)
    starts = random.normal(size=(STARTS * count, 2 * count)) * 10.0 ** random.uniform(-2.0, 0.3, (STARTS * count, 1))
    found: list[dict[int, float]] = []
    for pattern in product((1.0, -1.0), repeat=len(balls)):
        signs = np.array(pattern)

        def miss(parts: Floats, signs: Floats = signs) -> Floats:
            whirl = (parts[:count] + 1j * parts[count:]) * scale
            c = whirl[place] + offset
            load = np.zeros(count, np.complex128)
            np.add.at(load, place, moment * signs * c / np.maximum(np.abs(c), 1e-300))
            error = (whirl - a.free - a.host @ load) / scale
            return np.concatenate([error.real, error.imag])

        seen: list[Complexes] = []
        for start in starts:
            answer = root(miss, start, tol=1e-13)
            c = ((answer.x[:count] + 1j * answer.x[count:]) * scale)[place] + offset
            if np.abs(answer.fun).max() > 1e-10 or np.abs(c).min() < 1e-9 * scale:
                continue
            if any(np.abs(c - old).max() < 1e-7 * scale for old in seen):
                continue
            seen.append(c)
            angles = np.angle(signs * c)
            found.append(dict(zip(balls.tolist(), angles.tolist(), strict=True)))
    return _distinct(found, a)


def _distinct(found: list[dict[int, float]], a: Aligned) -> list[dict[int, float]]:
    """States that differ by an exchange of equal balls of one race center are one."""
    kept: dict[object, dict[int, float]] = {}
    for angles in found:
        key = tuple(
            sorted(
                (round(a.moment[ball], 15), *(round(v, 6) for v in (np.cos(angle), np.sin(angle))), str(a.offset[ball]))
                for ball, angle in angles.items()
            )
        )
        kept.setdefault(key, angles)
    return list(kept.values())

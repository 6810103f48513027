"""A point of a branch of stalled states: the balances of G groups of balls with linear drag, by Newton's method.

Unknowns x are the log of the slip W - v over the whirl v, the phases of all groups but the first, and the log of the rotor
speed W times a scale.
With H = R A^-1 L the receptance between groups, A = K + i v (C + W G) - v^2 M of n coordinates, group p is in balance where

    Im whole_p = need_p,    whole_p = - (1 + i mu_p) s_p v^4 e^(-i psi_p) sum_q H_pq n_q s_q e^(i psi_q),
    need_p = beta_p (W - v) + mu_p s_p eps_p v^2,

as in :mod:`autobalancer.stability.stall.states`. Slopes are exact: dH = - R A^-1 dA A^-1 L.
"""

from __future__ import annotations

import math

from numba import float64, int64, types

from autobalancer.kernels.compiler.flags import COMPILED, MERGED, njit
from autobalancer.kernels.fields import Field, Record
from autobalancer.kernels.system import matrix_type, vector_type

GROUP = Record(
    Field("total", "kg m", "n s: count times moment"),
    Field("moment", "kg m", "s, of one ball"),
    Field("rolling", "1", "mu"),
    Field("drag", "N m s", "beta"),
    Field("pressed", "kg m^2", "mu s eps"),
)
"""Balls that stall together."""

ROUNDS, CLOSE = 12, 1e-9  # of Newton's method; its last step
STIFFNESS, DAMPING, GYROSCOPIC, MASS, DYNAMIC, SLOPE, INVERSE = range(7)

_complex_matrix = types.Array(types.complex128, 2, "C")
_complex_stack = types.Array(types.complex128, 3, "C")


@njit(**MERGED)
def _invert(left, inverse, n) -> None:  # type: ignore[no-untyped-def]
    """Gauss and Jordan with the greatest pivot; ``left`` is lost."""
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 0.0
        inverse[i, i] = 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(left[i, k]) > abs(left[pivot, k]):
                pivot = i
        for j in range(n):
            left[k, j], left[pivot, j] = left[pivot, j], left[k, j]
            inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
        one = 1.0 / left[k, k]
        for j in range(n):
            left[k, j] *= one
            inverse[k, j] *= one
        for i in range(n):
            factor = left[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    left[i, j] -= factor * left[k, j]
                    inverse[i, j] -= factor * inverse[k, j]


@njit(**MERGED)
def _balances(rotor, push, seen, groups, x, scale, before, after, miss, slopes) -> None:  # type: ignore[no-untyped-def]
    """Brake over need less one of each group, and its slopes over x, (G, G + 1)."""
    n, count = push.shape
    speed = math.exp(x[count] / scale)
    v = speed / (1.0 + math.exp(x[0]))
    slip = v * math.exp(x[0])
    # dynamic stiffness at the whirl, and its slope
    for i in range(n):
        for j in range(n):
            turning = rotor[DAMPING, i, j] + speed * rotor[GYROSCOPIC, i, j]
            rotor[DYNAMIC, i, j] = rotor[STIFFNESS, i, j] + 1j * v * turning - v * v * rotor[MASS, i, j]
            rotor[SLOPE, i, j] = 1j * turning - 2.0 * v * rotor[MASS, i, j]
    inverse = rotor[INVERSE]
    _invert(rotor[DYNAMIC], inverse, n)
    # motion by the push of each group, and how each group feels it
    for g in range(count):
        for i in range(n):
            load, read = 0.0j, 0.0j
            for j in range(n):
                load += inverse[i, j] * push[j, g]
                read += seen[g, j] * inverse[j, i]
            after[i, g], before[g, i] = load, read
    # power that the whirl takes from each group, against what its drag gives
    for p in range(count):
        group, phase = groups[p], 0.0 if p == 0 else x[p]
        factor = -(1.0 + 1j * group.rolling) * group.moment * v**4 * complex(math.cos(phase), -math.sin(phase))
        whole, over_whirl, over_speed = 0.0j, 0.0j, 0.0j
        for q in range(count):
            phase = 0.0 if q == 0 else x[q]
            load = factor * groups[q].total * complex(math.cos(phase), math.sin(phase))
            host, by_whirl, by_speed = 0.0j, 0.0j, 0.0j
            for i in range(n):
                host += seen[p, i] * after[i, q]
                whirl, turn = 0.0j, 0.0j
                for j in range(n):
                    whirl += rotor[SLOPE, i, j] * after[j, q]
                    turn += rotor[GYROSCOPIC, i, j] * after[j, q]
                by_whirl -= before[p, i] * whirl
                by_speed -= before[p, i] * turn
            part = load * host
            whole += part
            over_whirl += load * by_whirl
            over_speed += 1j * v * load * by_speed
            slopes[p, q] = (1j * part).imag
        # the push grows with the fourth power of the whirl; a group's own phase turns its brake back
        over_whirl += 4.0 * whole / v
        slopes[p, p] -= (1j * whole).imag
        # drag by the slip, and rolling resistance by what presses the ball on its race, m v^2 eps
        need = group.drag * slip + group.pressed * v * v
        ratio = whole.imag / need
        miss[p] = ratio - 1.0
        for q in range(1, count):
            slopes[p, q] /= need
        need_by_slip = group.drag * slip - 2.0 * group.pressed * v * slip
        # slopes over the slip (as a logit), over the phases, and over the speed (as a logarithm)
        slopes[p, 0] = v / speed * (-slip * over_whirl.imag - ratio * need_by_slip) / need
        over_speed = speed * over_speed + v * over_whirl
        need_by_speed = group.drag * slip + 2.0 * group.pressed * v * v
        slopes[p, count] = (over_speed.imag - ratio * need_by_speed) / (scale * need)


@njit(**MERGED)
def _across(slopes, lower, count) -> None:  # type: ignore[no-untyped-def]
    """Rows made orthonormal in place, by Gram and Schmidt, twice; ``lower`` times them is what they were."""
    for p in range(count):
        for q in range(count):
            lower[p, q] = 0.0
        for _ in range(2):
            for q in range(p):
                share = 0.0
                for k in range(count + 1):
                    share += slopes[p, k] * slopes[q, k]
                lower[p, q] += share
                for k in range(count + 1):
                    slopes[p, k] -= share * slopes[q, k]
        size = 0.0
        for k in range(count + 1):
            size += slopes[p, k] * slopes[p, k]
        lower[p, p] = math.sqrt(size)
        for k in range(count + 1):
            slopes[p, k] /= lower[p, p]


@njit(
    int64(
        _complex_stack, _complex_matrix, _complex_matrix, GROUP.rows_type(), vector_type, vector_type, float64, int64,
        _complex_matrix, _complex_matrix, matrix_type, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def branch_point(rotor, push, seen, groups, x, along, scale, same_speed, before, after, slopes, lower):  # type: ignore[no-untyped-def]
    """The nearest point of the curve, or that at the ``same_speed``; whether it was found.

    ``x`` becomes the point and ``along`` the direction of the curve there, on the side of what it was. The first four of
    ``rotor`` (7, n, n) are K, C, G and M, the others, like what follows ``same_speed``, room for the work; ``lower`` is
    (G + 1, G), and its last row takes the misfits.
    """
    count = groups.size
    miss = lower[count]
    for _ in range(ROUNDS):
        # Newton's method with one unknown more than equations: the shortest step to the curve, as rows made orthonormal
        # give it by a triangular system
        _balances(rotor, push, seen, groups, x, scale, before, after, miss, slopes)
        if same_speed != 0:  # as if the speed did not count
            for p in range(count):
                slopes[p, count] = 0.0
        _across(slopes, lower, count)
        for p in range(count):
            for q in range(p):
                miss[p] -= lower[p, q] * miss[q]
            miss[p] /= lower[p, p]
        # the step, in all unknowns; what goes too far is given up
        size = 0.0
        for k in range(count + 1):
            change = 0.0
            for p in range(count):
                change -= miss[p] * slopes[p, k]
            x[k] += change
            size = max(size, abs(change)) if math.isfinite(change) else math.inf
        if not size < 1.0:
            return 0
        # on the curve: its direction is what the rows leave of the old one
        if size < CLOSE:
            _balances(rotor, push, seen, groups, x, scale, before, after, miss, slopes)
            _across(slopes, lower, count)
            for _ in range(2):
                for p in range(count):
                    share = 0.0
                    for k in range(count + 1):
                        share += along[k] * slopes[p, k]
                    for k in range(count + 1):
                        along[k] -= share * slopes[p, k]
            size = 0.0
            for k in range(count + 1):
                size += along[k] * along[k]
            for k in range(count + 1):
                along[k] /= math.sqrt(size)
            return 1
    return 0

"""The motion inside a long step, as polynomials of degree eight over pieces of it.

The pieces have the form of an explicit pair: eight stages that are the coefficients of x to x^8 (:func:`by_powers`), so that
:mod:`autobalancer.kernels.integrators.record` reads them like the steps of any pair. A step is one piece unless a mode turns
fast in it that no force drives, such as the free whirl after a start; then its own motion e^(z x) is followed exactly from
piece to piece.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from autobalancer.kernels.flags import MERGED, PART, njit
from autobalancer.kernels.integrators.collocation.amplitudes import FROZEN
from autobalancer.kernels.integrators.collocation.radau import SERIES
from autobalancer.kernels.integrators.collocation.sweep import summed
from autobalancer.kernels.integrators.tableau import Tableau
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, SPEED, THETA
from autobalancer.kernels.trigonometry import exponential_of_lanes, sine_cosine_of_lanes
from autobalancer.kernels.wide import NODES, all_lanes, lane, load, store, total

MISS = 2e-11  # of e^(z x), |z| = 1, from a polynomial through 0 and the nodes; it grows as |z|^9
SHARE = 0.1  # of the tolerance that pieces may miss
MOST = 1000  # pieces of a step


@cache
def by_powers() -> Tableau:
    """Stages that are coefficients of powers; only what dense output takes from a pair is there."""
    rows = NODES + 2 + NODES
    first = np.concatenate([np.zeros(NODES + 3, np.int64), np.arange(1, NODES + 1)])
    assert first.size == rows + 1
    return Tableau(NODES, NODES, NODES, NODES, np.zeros(NODES), first, np.arange(NODES), np.ones(NODES))


@njit(**MERGED)
def pieces_needed(step: float, a: Any) -> int:
    """Into how many pieces a step has to be cut; what no force drives is worked out for :func:`values_inside`."""
    forces = data(a.forces)
    most = 1.0
    for mode in range(a.modes):
        row = 2 * mode
        real = a.exponents[row] * step
        imaginary = (a.exponents[row + 1] - a.turning * a.held[FROZEN]) * step
        square = real * real + imaginary * imaginary
        its, beside = a.begin[row], a.begin[row + 1]
        if square > SERIES * SERIES:
            starts = data(a.radau.starts)
            inverse = 1.0 / square
            back_real, back_imaginary = real * inverse, -imaginary * inverse
            power_real, power_imaginary = -back_real * step, -back_imaginary * step
            sum_real, sum_imaginary = all_lanes(0.0), all_lanes(0.0)
            for q in range(NODES):
                one = load(starts, q * NODES)
                sum_real += one * power_real
                sum_imaginary += one * power_imaginary
                power_real, power_imaginary = (
                    power_real * back_real - power_imaginary * back_imaginary,
                    power_real * back_imaginary + power_imaginary * back_real,
                )
            one, other = load(forces, row * NODES), load(forces, (row + 1) * NODES)
            its -= total(sum_real * one - sum_imaginary * other)
            beside -= total(sum_real * other + sum_imaginary * one)
        a.free[row], a.free[row + 1] = its, beside
        miss = (abs(its) + abs(beside)) * max(a.weights[row], a.weights[row + 1]) * (MISS / SHARE)
        if miss * square * square * square * square * math.sqrt(square) > 1.0:
            most = max(most, math.sqrt(square) * miss ** (1.0 / 9.0))
    return math.ceil(min(most, MOST))


@njit(**MERGED)
def _places(number: int, pieces: int, a: Any) -> Any:
    """The nodes of a piece as fractions of the step; its end, and so that of the last piece, comes out exactly."""
    return (load(data(a.radau.nodes), 0) + float(number)) / float(pieces)


@njit(**MERGED)
def _at_begin(row: int, state: Any) -> float:
    """Speed, angle, then all of the balls."""
    if row == 0:
        return state[SPEED]
    return state[THETA] if row == 1 else state[BALLS + row - 2]


@njit(**MERGED)
def values_inside(number: int, pieces: int, step: float, a: Any, m: Any) -> None:
    """Rows of all unknowns at the nodes of a piece, into ``inside``; the state at the begin of the step is in ``origin``.

    What no force drives follows e^(z x) where z is large. Where it is small, the amplitude is the polynomial of degree 17
    with the values and slopes at 0 and the nodes.
    """
    values, forces, inside, state = data(a.values), data(a.forces), data(a.inside), data(a.origin)
    nodes, weights, bends, factors = data(a.radau.nodes), data(a.radau.weights), data(a.radau.bends), data(a.factors)
    x, basis, work, speed_row = _places(number, pieces, a), data(a.stretch), data(a.work), 2 * a.modes
    rows = speed_row + 2 + 2 * a.balls
    product = all_lanes(1.0)
    for j in range(NODES):  # of the distances from the nodes before j, then of those after it
        store(product * weights[j], basis, j * NODES)
        product *= x - nodes[j]
    at_begin = product * a.radau.start_weight
    product = all_lanes(1.0)
    for j in range(NODES - 1, -1, -1):
        store(product * load(basis, j * NODES), basis, j * NODES)
        product *= x - nodes[j]
    for mode in range(a.modes):
        row = 2 * mode
        real = a.exponents[row] * step
        imaginary = (a.exponents[row + 1] - a.turning * a.held[FROZEN]) * step
        its, beside = all_lanes(0.0), all_lanes(0.0)
        if real * real + imaginary * imaginary > SERIES * SERIES:
            one, other = a.free[row], a.free[row + 1]
            factor, turned = load(factors, row * NODES), load(factors, (row + 1) * NODES)
            store(load(values, row * NODES) - factor * one + turned * other, work, 0)
            store(load(values, (row + 1) * NODES) - factor * other - turned * one, work, NODES)
            sine, cosine = sine_cosine_of_lanes(x * imaginary)
            size = exponential_of_lanes(x * real)
            sine, cosine = size * sine, size * cosine
            its = summed(basis, 0, work, 0) + (cosine * one - sine * other)
            beside = summed(basis, 0, work, 1) + (cosine * other + sine * one)
        else:
            push, push_beside = 0.0, 0.0
            for j in range(-1, NODES):
                here, here_beside, alone, place = a.begin[row], a.begin[row + 1], at_begin, 0.0
                if j >= 0:
                    place = nodes[j]
                    here, here_beside = values[row * NODES + j], values[(row + 1) * NODES + j]
                    push, push_beside = forces[row * NODES + j], forces[(row + 1) * NODES + j]
                    alone = load(basis, j * NODES) * x * (1.0 / place)
                else:
                    starts = load(data(a.radau.starts), 0)
                    push = total(starts * load(forces, row * NODES))
                    push_beside = total(starts * load(forces, (row + 1) * NODES))
                near, square = x - place, alone * alone
                value_share, slope_share = square * (1.0 - near * (2.0 * bends[j + 1])), square * near
                rate = real * here - imaginary * here_beside + step * push
                rate_beside = real * here_beside + imaginary * here + step * push_beside
                its += value_share * here + slope_share * rate
                beside += value_share * here_beside + slope_share * rate_beside
        store(its, inside, row * NODES)
        store(beside, inside, (row + 1) * NODES)
    for j in range(NODES):
        store(load(basis, j * NODES) * x * (1.0 / nodes[j]), basis, j * NODES)
    for row in range(
        speed_row, rows
    ):  # differences from the begin, so that a speed that is kept stays what it is to the last bit
        begin = _at_begin(row - speed_row, state)
        store(load(values, row * NODES) - begin, work, 0)
        store(summed(basis, 0, work, 0) + begin, inside, row * NODES)


@njit(**MERGED)
def _write(component: int, numbers: Any, length: float, a: Any, m: Any) -> None:
    """The polynomial of one component of the state from its values at the nodes of the piece."""
    work, powers, stages, width = data(a.work), data(a.radau.powers), data(m.stages), m.trial.size
    per = 1.0 / length
    start, end = m.start[component], lane(numbers, NODES - 1)
    store(numbers - start - load(data(a.radau.nodes), 0) * (end - start), work, 0)
    even, odd = load(powers, 0) * work[0], load(powers, NODES) * work[1]
    for j in range(2, NODES, 2):
        even += load(powers, j * NODES) * work[j]
        odd += load(powers, (j + 1) * NODES) * work[j + 1]
    store((even + odd) * per, work, NODES)
    work[NODES] += (end - start) * per
    for k in range(NODES):
        stages[k * width + component] = work[NODES + k]
    a.reached[component] = end


@njit(**PART)
def write_piece(rows: Any, length: float, a: Any, m: Any) -> None:
    """Polynomials of all components over a piece of this length that begins at ``start``; its end goes to ``reached``."""
    a, m = behind(a), behind(m)
    shapes, size = data(a.shapes), 2 * a.modes
    for k in range(size):
        number = all_lanes(0.0)
        for q in range(size):
            number += load(rows, q * NODES) * shapes[k * size + q]
        _write(a.places[k], number, length, a, m)
    _write(SPEED, load(rows, size * NODES), length, a, m)
    _write(THETA, load(rows, (size + 1) * NODES), length, a, m)
    for i in range(2 * a.balls):
        _write(BALLS + i, load(rows, (size + 2 + i) * NODES), length, a, m)

"""One sweep of the iteration: values at all nodes from the forces there, and the forces of a step from those before it."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from autobalancer.kernels.compiler.flags import MERGED, PART, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import NODES, all_lanes, amount, greater, greatest, lane, load, store, total
from autobalancer.kernels.integrators.collocation import (
    BEGINS,
    DECAY_KNOWN,
    FROZEN,
    FROZEN_BEFORE,
    FROZEN_KNOWN,
    LENGTH_BEFORE,
    LENGTH_KNOWN,
    RENEWED,
    SERIES,
    SQUARE,
    decay,
    drift,
    exponentials,
    know_rates,
)
from autobalancer.kernels.integrators.tableau import Tableau
from autobalancer.kernels.system import BALLS, SPEED, THETA
from autobalancer.kernels.trigonometry import exponential_of_lanes, sine_cosine_of_lanes


@njit(**MERGED)
def summed(matrix: Any, first: int, numbers: Any, row: int) -> Any:
    """A matrix over the nodes times a row."""
    even, odd = all_lanes(0.0), all_lanes(0.0)
    for j in range(0, NODES, 2):
        even += load(matrix, first + j * NODES) * numbers[row * NODES + j]
        odd += load(matrix, first + (j + 1) * NODES) * numbers[row * NODES + j + 1]
    return even + odd


@njit(**MERGED)
def _put(value: Any, row: int, values: Any, weights: Any, change: Any) -> Any:
    """Put a row into its place; the greatest change so far."""
    moved = amount(value - load(values, row * NODES)) * weights[row]
    store(value, values, row * NODES)
    return greater(change, moved)


@njit(**MERGED)
def _speeds(number: int, row: int, begin: float, found: bool, step: float, a: Any) -> Any:
    """New speeds of the rotor (number 0) or of a ball from their accelerations, which are those for these speeds then.

    Accelerations that were ``found`` belong to the speeds that are there, those that were only continued to none.
    """
    forces, own = data(a.forces), 2 * a.modes + number
    if not found:
        return summed(data(a.radau.integrals), 0, forces, own) * step + begin
    work, rate = data(a.work), data(a.rates)[number]
    driven = load(forces, own * NODES) + (load(data(a.values), row * NODES) - begin) * rate
    store(driven, work, 0)
    gain = summed(data(a.solvers), data(a.solver_places)[number], work, 0)
    store(driven - gain * rate, forces, own * NODES)
    return gain + begin


@njit(**MERGED)
def sweep(found: bool, step: float, a: Any, m: Any) -> float:
    """New values from the forces; how much the one changed that changed most, in tolerances.

    ``found`` says whether the forces were found from the values that are there.
    """
    if found:
        know_rates(step, a)
    values, forces, weights, state = data(a.values), data(a.forces), data(a.weights), data(m.start)
    factors, sums, begin = data(a.factors), data(a.sums), data(a.begin)
    once, twice = data(a.radau.integrals), SQUARE
    nodes = load(data(a.radau.nodes), 0) * step
    # modes: e^(z t) at the nodes times the begin, plus the integrals of e^(z (t - s)) times the forces, complex numbers
    # as pairs of rows
    change = all_lanes(0.0)
    for mode in range(a.modes):
        real, imaginary, cross, other = all_lanes(0.0), all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)
        first, row = mode * 2 * SQUARE, 2 * mode
        for j in range(NODES):
            its, beside = forces[row * NODES + j], forces[(row + 1) * NODES + j]
            sum_real, sum_imaginary = load(sums, first + j * NODES), load(sums, first + SQUARE + j * NODES)
            real += sum_real * its
            cross += sum_imaginary * beside
            imaginary += sum_real * beside
            other += sum_imaginary * its
        its, beside = begin[row], begin[row + 1]
        factor, turned = load(factors, row * NODES), load(factors, (row + 1) * NODES)
        change = _put((real - cross) * step + factor * its - turned * beside, row, values, weights, change)
        change = _put((imaginary + other) * step + factor * beside + turned * its, row + 1, values, weights, change)
    row, own = 2 * a.modes, 2 * a.modes
    change = _put(_speeds(0, row, state[SPEED], found, step, a), row, values, weights, change)
    # the rotor's angle from its forces integrated twice
    angle = summed(once, twice, forces, own) * (step * step) + nodes * state[SPEED] + state[THETA]
    change = _put(angle, row + 1, values, weights, change)
    # balls: speed and angle likewise; damping is treated implicitly, else drag would limit the step
    for turn in range(2):  # in the second one, those that have the acceleration of another one
        for b in range(a.balls):
            head = a.heads[1 + b] if found else 1 + b
            if (head != 1 + b) == (turn == 1):
                rate, its = state[BALLS + a.balls + b], row + 2 + a.balls + b
                if turn == 0:
                    speed = _speeds(1 + b, its, rate, found, step, a)
                else:
                    speed = load(values, (row + 1 + a.balls + head) * NODES) - state[BALLS + a.balls + head - 1] + rate
                    store(load(forces, (own + head) * NODES), forces, (own + 1 + b) * NODES)
                change = _put(speed, its, values, weights, change)
                angle = summed(once, twice, forces, own + 1 + b) * (step * step) + nodes * rate + state[BALLS + b]
                change = _put(angle, row + 2 + b, values, weights, change)
    return greatest(change)


@njit(**MERGED)
def stand(a: Any, m: Any) -> None:
    """Values as at the begin of the step, at all nodes."""
    values, state, row = data(a.values), data(m.start), 2 * a.modes
    for k in range(2 * a.modes):
        store(all_lanes(a.begin[k]), values, k * NODES)
    store(all_lanes(state[SPEED]), values, row * NODES)
    store(all_lanes(state[THETA]), values, (row + 1) * NODES)
    for i in range(2 * a.balls):
        store(all_lanes(state[BALLS + i]), values, (row + 2 + i) * NODES)


@njit(**MERGED)
def go_on(step: float, shift: float, a: Any) -> None:
    """Forces of the last step continued over this one, which may begin inside it; the frozen speed grew by ``shift``."""
    matrix = data(a.radau.onward)
    # the polynomial through the last forces at the new nodes: Lagrange's basis, unless the step is as long as the last
    ratio, first = step / a.held[LENGTH_BEFORE], a.held[BEGINS]
    if ratio != 1.0 or first != 1.0:
        matrix, weights, places = data(a.stretch), data(a.radau.weights), data(a.radau.nodes)
        x = load(places, 0) * ratio + first
        product = all_lanes(1.0)
        for j in range(NODES):  # of the distances from the nodes before j, then of those after it
            store(product * weights[j], matrix, j * NODES)
            product *= x - places[j]
        product = all_lanes(1.0)
        for j in range(NODES - 1, -1, -1):
            store(product * load(matrix, j * NODES), matrix, j * NODES)
            product *= x - places[j]
    # all forces continued so
    forces, before = data(a.forces), data(a.forces_before)
    for row in range(2 * a.modes + 1 + a.balls):
        store(summed(matrix, 0, before, row), forces, row * NODES)
    # with another frozen speed the modes turn otherwise: the difference is a force
    if shift != 0.0:
        amplitudes = data(a.amplitudes_before)
        for mode in range(a.modes):
            real, imaginary = (2 * mode) * NODES, (2 * mode + 1) * NODES
            its, beside = summed(matrix, 0, amplitudes, 2 * mode), summed(matrix, 0, amplitudes, 2 * mode + 1)
            grown, turned = shift * drift(2 * mode, a), shift * (drift(2 * mode + 1, a) - a.turning)
            store(load(forces, real) - its * grown + beside * turned, forces, real)
            store(load(forces, imaginary) - beside * grown - its * turned, forces, imaginary)


# The motion inside a long step, as polynomials of degree eight over pieces of it.
#
# The pieces have the form of an explicit pair: eight stages that are the coefficients of x to x^8 (:func:`by_powers`),
# so that :mod:`autobalancer.kernels.integrators.recording` reads them like the steps of any pair. A step is one piece
# unless a mode turns fast in it that no force drives, such as the free whirl after a start; then its own motion e^(z
# x) is followed exactly from piece to piece.


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
        # z = exponent times step, of the mode as seen from the axes of the state
        real = a.exponents[row] * step
        imaginary = (a.exponents[row + 1] - a.turning * a.held[FROZEN]) * step
        square = real * real + imaginary * imaginary
        its, beside = a.begin[row], a.begin[row + 1]
        # what of the amplitude turns freely: take away the response to the polynomial of the force,
        # -sum_q F^(q) over z^(q + 1), which is smooth
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
        # a polynomial of degree eight misses e^(z x) by about MISS |z|^9: shorter pieces by |z| over so much
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
    # Lagrange's basis at the places asked for, from the distances to all nodes
    product = all_lanes(1.0)
    for j in range(NODES):  # of the distances from the nodes before j, then of those after it
        store(product * weights[j], basis, j * NODES)
        product *= x - nodes[j]
    at_begin = product * a.radau.start_weight
    product = all_lanes(1.0)
    for j in range(NODES - 1, -1, -1):
        store(product * load(basis, j * NODES), basis, j * NODES)
        product *= x - nodes[j]
    # modes: what no force drives turns by itself, the rest is a polynomial
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
def _write(component: int, numbers: Any, length: float, leading: int, a: Any, m: Any) -> None:
    """The polynomial of one component of the state, if it is a leading one, from its values at the nodes of the piece."""
    work, powers, stages, width = data(a.work), data(a.radau.powers), data(m.stages), m.trial.size
    per = 1.0 / length
    start, end = m.start[component], lane(numbers, NODES - 1)
    a.reached[component] = end
    if component >= leading:
        return
    # the difference from the chord is small, so its coefficients keep their digits; the chord is part of the first one
    store(numbers - start - load(data(a.radau.nodes), 0) * (end - start), work, 0)
    even, odd = load(powers, 0) * work[0], load(powers, NODES) * work[1]
    for j in range(2, NODES, 2):
        even += load(powers, j * NODES) * work[j]
        odd += load(powers, (j + 1) * NODES) * work[j + 1]
    store((even + odd) * per, work, NODES)
    work[NODES] += (end - start) * per
    for k in range(NODES):
        stages[k * width + component] = work[NODES + k]


@njit(**PART)
def write_piece(rows: Any, length: float, leading: int, a: Any, m: Any) -> None:
    """Polynomials of the leading components over a piece of this length that begins at ``start``; its end to ``reached``."""
    a, m = deref(a), deref(m)
    shapes, size = data(a.shapes), 2 * a.modes
    for k in range(size):
        number = all_lanes(0.0)
        for q in range(size):
            number += load(rows, q * NODES) * shapes[k * size + q]
        _write(a.places[k], number, length, leading, a, m)
    _write(SPEED, load(rows, size * NODES), length, leading, a, m)
    _write(THETA, load(rows, (size + 1) * NODES), length, leading, a, m)
    for i in range(2 * a.balls):
        _write(BALLS + i, load(rows, (size + 2 + i) * NODES), length, leading, a, m)


# Parts of a long step: its tolerances and modes before it, its error and its end after it.


# the estimate times this, so that whole runs miss no more than with the pair at the same tolerance; above FINE it grows with the
# fourth root of the tolerance, as the last coefficient says less about those that follow it in longer steps
STRICT, FINE = 3.0, 1e-6


@njit(**MERGED)
def weigh(a: Any, m: Any) -> None:
    """Inverse tolerances of all rows of values, and the amplitudes at the begin of the step."""
    size, weights, shapes, inverse = 2 * a.modes, data(a.weights), data(a.shapes), data(a.inverse)
    for q in range(size):
        weights[q] = 0.0
        number = 0.0
        for k in range(size):
            number += inverse[q * size + k] * m.start[a.places[k]]
        a.begin[q] = number
    # a mode may be wrong by what its shape makes of it in the sharpest of all coordinates
    for k in range(0, size, 2):
        one, other = a.places[k], a.places[k + 1]
        length = math.sqrt(m.start[one] ** 2 + m.start[other] ** 2)
        sharp = 1.0 / min(m.absolute[one] + m.relative[one] * length, m.absolute[other] + m.relative[other] * length)
        for q in range(size):
            weights[q] = max(weights[q], max(abs(shapes[k * size + q]), abs(shapes[(k + 1) * size + q])) * sharp)
    weights[size] = 1.0 / m.absolute[SPEED]
    weights[size + 1] = 1.0 / m.absolute[THETA]
    for i in range(2 * a.balls):
        weights[size + 2 + i] = 1.0 / m.absolute[BALLS + i]


@njit(**MERGED)
def know_modes(step: float, a: Any) -> None:
    """Factors and sums of all modes for this step and the frozen speed, unless they are known."""
    frozen = a.held[FROZEN]
    if step == a.held[LENGTH_KNOWN] and frozen == a.held[FROZEN_KNOWN]:
        return
    for mode in range(a.modes):
        real = a.exponents[2 * mode] * step
        if step != a.held[DECAY_KNOWN]:
            decay(mode, real, a)
        exponentials(mode, real, (a.exponents[2 * mode + 1] - a.turning * frozen) * step, a)
    a.held[LENGTH_KNOWN] = a.held[DECAY_KNOWN] = step
    a.held[FROZEN_KNOWN] = frozen
    a.tallies[RENEWED] += 1


@njit(**MERGED)
def step_miss(step: float, a: Any) -> float:
    """How far the forces are from the polynomials through the nodes, in what it makes of the motion, in tolerances."""
    forces, weights, size, frozen = data(a.forces), data(a.weights), 2 * a.modes, a.held[FROZEN]
    top, worst = load(data(a.radau.top), 0), 0.0
    for q in range(size + 1 + a.balls):
        miss = abs(total(top * load(forces, q * NODES)))
        if q < size:
            mode = q - q % 2
            turn = a.exponents[mode + 1] - a.turning * frozen
            fast = math.sqrt(a.exponents[mode] ** 2 + turn * turn)
            miss *= (2.0 / fast if fast * step > 2.0 else step) * weights[q]
        elif q == size:
            miss *= step * weights[q]
        else:
            own = q + 1
            miss *= step * max(weights[own + a.balls], step * weights[own] / (2.0 * NODES))
        if not miss <= worst:  # also when it is not a number
            worst = miss
    return worst * STRICT * max(1.0, math.sqrt(math.sqrt(1.0 / (FINE * weights[size + 1]))))


@njit(**MERGED)
def write_end(a: Any, m: Any) -> None:
    """The state at the last node."""
    values, shapes, size, last = data(a.values), data(a.shapes), 2 * a.modes, NODES - 1
    for k in range(size):
        number = 0.0
        for q in range(size):
            number += shapes[k * size + q] * values[q * NODES + last]
        m.state[a.places[k]] = number
    m.state[SPEED], m.state[THETA] = values[size * NODES + last], values[(size + 1) * NODES + last]
    for i in range(2 * a.balls):
        m.state[BALLS + i] = values[(size + 2 + i) * NODES + last]


@njit(**MERGED)
def remember(step: float, a: Any) -> None:
    """Forces and amplitudes of an accepted step, from which the next one is begun."""
    size = 2 * a.modes
    forces, before = data(a.forces), data(a.forces_before)
    for q in range(size + 1 + a.balls):
        store(load(forces, q * NODES), before, q * NODES)
    values, amplitudes = data(a.values), data(a.amplitudes_before)
    for q in range(size):
        store(load(values, q * NODES), amplitudes, q * NODES)
    a.held[LENGTH_BEFORE], a.held[FROZEN_BEFORE] = step, a.held[FROZEN]

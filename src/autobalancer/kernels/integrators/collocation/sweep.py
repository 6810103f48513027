"""One sweep of the iteration: values at all nodes from the forces there, and the forces of a step from those before it."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import BEGINS, LENGTH_BEFORE
from autobalancer.kernels.integrators.collocation.bases import drift
from autobalancer.kernels.integrators.collocation.exponentials import SQUARE
from autobalancer.kernels.integrators.collocation.rates import know_rates
from autobalancer.kernels.pointers import data
from autobalancer.kernels.system import BALLS, SPEED, THETA
from autobalancer.kernels.wide import NODES, all_lanes, amount, greater, greatest, load, store


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
    angle = summed(once, twice, forces, own) * (step * step) + nodes * state[SPEED] + state[THETA]
    change = _put(angle, row + 1, values, weights, change)
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
    forces, before = data(a.forces), data(a.forces_before)
    for row in range(2 * a.modes + 1 + a.balls):
        store(summed(matrix, 0, before, row), forces, row * NODES)
    if shift != 0.0:
        amplitudes = data(a.amplitudes_before)
        for mode in range(a.modes):
            real, imaginary = (2 * mode) * NODES, (2 * mode + 1) * NODES
            its, beside = summed(matrix, 0, amplitudes, 2 * mode), summed(matrix, 0, amplitudes, 2 * mode + 1)
            grown, turned = shift * drift(2 * mode, a), shift * (drift(2 * mode + 1, a) - a.turning)
            store(load(forces, real) - its * grown + beside * turned, forces, real)
            store(load(forces, imaginary) - beside * grown - its * turned, forces, imaginary)

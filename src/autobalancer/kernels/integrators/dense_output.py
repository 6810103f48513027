"""The state anywhere inside a step, without a step to get there.

For the whole state at a few places the weights of all stages at that place are worked out first (:func:`evaluate`).
For a few components at many places these become polynomials (:func:`polynomials`, then :func:`component`).
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.compiler.flags import INLINE, PART, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import LANES, NODES, add_product, all_lanes, lanes, load, put, store
from autobalancer.kernels.integrators.integrator_state import TAKEN, Memory


@njit(**INLINE)
def sums(row: int, i: int, t, m):  # type: ignore[no-untyped-def]
    """Row of the tableau times the stages, for the LANES components that begin at i."""
    total = lanes()
    first, columns, values, stages = data(t.first), data(t.columns), data(t.values), data(m.stages)
    for entry in range(first[row], first[row + 1]):
        add_product(total, values[entry], stages, columns[entry] * m.trial.size + i)
    return total


@njit(**INLINE)
def polynomials(components: int, t, m) -> None:  # type: ignore[no-untyped-def]
    """Dense output of the leading components, at least so many."""
    for power in range(t.degree):
        for i in range(0, components, LANES):
            put(sums(t.total + 2 + power, i, t, m), data(m.dense[power]), i)


@njit(**INLINE)
def component(i: int, x: float, m: Memory) -> float:
    """Component i of the state at the fraction x of the step."""
    dense, width = data(m.dense), m.dense.shape[1]
    value = 0.0
    for j in range(m.dense.shape[0] - 1, -1, -1):
        value = (value + dense[j * width + i]) * x
    return data(m.start)[i] + m.clock[TAKEN] * value


@njit(**INLINE)
def slope(i: int, x: float, m: Memory) -> float:
    """Derivative of :func:`component` with respect to x."""
    dense, width = data(m.dense), m.dense.shape[1]
    value = 0.0
    for j in range(m.dense.shape[0] - 1, -1, -1):
        value = value * x + (j + 1.0) * dense[j * width + i]
    return m.clock[TAKEN] * value


@njit(**PART)
def evaluate(x: float, pair: Any, out: Any) -> None:
    """The whole state at the fraction x of the step; ``pair`` points to (tableau, memory)."""
    t, m = deref(pair)
    if t.total == t.degree:  # the stages are the coefficients themselves
        stages, trial, start, width = data(m.stages), data(m.trial), data(m.start), m.trial.size
        way = m.clock[TAKEN] * x
        for i in range(0, width, NODES):
            state = load(stages, (NODES - 1) * width + i)
            for power in range(NODES - 2, -1, -1):
                state = state * x + load(stages, power * width + i)
            store(state * way + load(start, i), trial, i)
        for i in range(m.state.size):
            out[i] = trial[i]
        return
    # polynomials of a pair: the weight of each stage at x, then all components, eight at once
    first, columns, values, shares = data(t.first), data(t.columns), data(t.values), data(m.shares)
    for stage in range(t.total):
        shares[stage] = 0.0
    power = m.clock[TAKEN]
    for row in range(t.total + 2, t.total + 2 + t.degree):
        power *= x
        for entry in range(first[row], first[row + 1]):
            shares[columns[entry]] += power * values[entry]
    trial, stages = data(m.trial), data(m.stages)
    for i in range(0, m.trial.size, LANES):
        state = lanes()
        for stage in range(t.total):
            add_product(state, shares[stage], stages, stage * m.trial.size + i)
        add_product(state, 1.0, data(m.start), i)
        put(state, trial, i)
    for i in range(m.state.size):
        out[i] = trial[i]


@njit(**PART)
def states_at(places: Any, count: int, number: int, left: float, ring: Any, pair: Any) -> None:
    """Time and state at up to eight fractions of the step into the rows of a ring from the ``number``-th on.

    The polynomials of a long step are worked out at all of them at once.
    """
    t, m = deref(pair)
    rows, size, length = data(ring), ring.shape[0], ring.shape[1]
    for k in range(count):
        ring[(number + k) % size, 0] = left + places[k] * m.clock[TAKEN]
    if t.total != t.degree:
        for k in range(count):
            evaluate(places[k], pair, data(ring[(number + k) % size, 1:]))
        return
    # a long step: each component's polynomial at all places at once, then into the rows
    stages, trial, start, width = data(m.stages), data(m.trial), data(m.start), m.trial.size
    x = load(places, 0)
    way, first = x * m.clock[TAKEN], number % size
    for i in range(m.state.size):
        state = all_lanes(stages[(NODES - 1) * width + i])
        for power in range(NODES - 2, -1, -1):
            state = state * x + stages[power * width + i]
        store(state * way + start[i], trial, 0)
        for k in range(count):
            row = first + k if first + k < size else first + k - size
            rows[row * length + 1 + i] = trial[k]


# Quantities whose passage through a level is an event, as components of the state.


SUM, LENGTH, GREATEST = range(3)  # kinds of quantity


@njit(**PART)
def quantity(kind: int, first: int, second: int, x: float, pair: Any) -> float:
    """A quantity at the fraction x of the step.

    SUM of component ``first`` and, unless it is negative, ``second``; LENGTH of the vector of both; GREATEST amount of
    the components from ``first`` to before ``second``.
    """
    _, m = deref(pair)
    if kind == LENGTH:
        return math.hypot(component(first, x, m), component(second, x, m))
    if kind == SUM:
        return component(first, x, m) + (component(second, x, m) if second >= 0 else 0.0)
    greatest = 0.0
    for i in range(first, second):
        greatest = max(greatest, abs(component(i, x, m)))
    return greatest

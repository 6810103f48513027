"""The state anywhere inside a step, without a step to get there.

For the whole state at a few places the weights of all stages at that place are worked out first (:func:`evaluate`).
For a few components at many places these become polynomials (:func:`polynomials`, then :func:`component`).
"""

from __future__ import annotations

from typing import Any

from numba import njit

from autobalancer.kernels.flags import COMPILED, INLINE
from autobalancer.kernels.integrators.memory import BLOCK, TAKEN, Memory
from autobalancer.kernels.pointers import behind, data


@njit(**INLINE)
def sums(row: int, i: int, t, m):  # type: ignore[no-untyped-def]
    """Row of the tableau times the stages, for the BLOCK of components that begins at i."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    first, columns, values, stages = data(t.first), data(t.columns), data(t.values), data(m.stages)
    for entry in range(first[row], first[row + 1]):
        weight, place = values[entry], columns[entry] * m.trial.size + i
        a += weight * stages[place]
        b += weight * stages[place + 1]
        c += weight * stages[place + 2]
        d += weight * stages[place + 3]
    return a, b, c, d


@njit(**INLINE)
def polynomials(components: int, t, m) -> None:  # type: ignore[no-untyped-def]
    """Dense output of the leading components, at least so many."""
    step = m.clock[TAKEN]
    for power in range(t.degree):
        dense = data(m.dense[power])
        for i in range(0, components, BLOCK):
            a, b, c, d = sums(t.total + 2 + power, i, t, m)
            dense[i], dense[i + 1], dense[i + 2], dense[i + 3] = step * a, step * b, step * c, step * d


@njit(**INLINE)
def component(i: int, x: float, m: Memory) -> float:
    """Component i of the state at the fraction x of the step."""
    dense, width = data(m.dense), m.dense.shape[1]
    value = 0.0
    for j in range(m.dense.shape[0] - 1, -1, -1):
        value = (value + dense[j * width + i]) * x
    return data(m.start)[i] + value


@njit(**INLINE)
def slope(i: int, x: float, m: Memory) -> float:
    """Derivative of :func:`component` with respect to x."""
    dense, width = data(m.dense), m.dense.shape[1]
    value = 0.0
    for j in range(m.dense.shape[0] - 1, -1, -1):
        value = value * x + (j + 1.0) * dense[j * width + i]
    return value


@njit(**COMPILED)
def evaluate(x: float, pair: Any, out: Any) -> None:
    """The whole state at the fraction x of the step; ``pair`` points to (tableau, memory)."""
    t, m = behind(pair)
    first, columns, values, shares = data(t.first), data(t.columns), data(t.values), data(m.shares)
    for stage in range(t.total):
        shares[stage] = 0.0
    power = m.clock[TAKEN]
    for row in range(t.total + 2, t.total + 2 + t.degree):
        power *= x
        for entry in range(first[row], first[row + 1]):
            shares[columns[entry]] += power * values[entry]
    start, trial, stages = data(m.start), data(m.trial), data(m.stages)
    for i in range(0, m.trial.size, BLOCK):
        a, b, c, d = start[i], start[i + 1], start[i + 2], start[i + 3]
        for stage in range(t.total):
            weight, place = shares[stage], stage * m.trial.size + i
            a += weight * stages[place]
            b += weight * stages[place + 1]
            c += weight * stages[place + 2]
            d += weight * stages[place + 3]
        trial[i], trial[i + 1], trial[i + 2], trial[i + 3] = a, b, c, d
    for i in range(m.state.size):
        out[i] = trial[i]

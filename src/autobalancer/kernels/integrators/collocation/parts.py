"""Parts of a long step: its tolerances and modes before it, its error and its end after it."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import (
    DECAY_KNOWN,
    FROZEN,
    FROZEN_BEFORE,
    FROZEN_KNOWN,
    LENGTH_BEFORE,
    LENGTH_KNOWN,
    RENEWED,
)
from autobalancer.kernels.integrators.collocation.exponentials import decay, exponentials
from autobalancer.kernels.pointers import data
from autobalancer.kernels.system import BALLS, SPEED, THETA
from autobalancer.kernels.wide import NODES, load, store, total

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

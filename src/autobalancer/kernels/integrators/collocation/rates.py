"""Speeds that die out by themselves: that of the rotor by its motor, those of balls by their drag.

With u' = r - rate u, r all else, and A the integrals over the nodes, the values at all nodes follow from the accelerations a that
were found with the values v: u = u0 + h (1 + h rate A)^-1 A (a + rate (v - u0)). So the iteration need not find out how drag
acts, and a step may be long against 1/rate. Where a rate is not exact, only the iteration takes longer.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import STEP_KNOWN
from autobalancer.kernels.integrators.collocation.exponentials import SQUARE
from autobalancer.kernels.pointers import data
from autobalancer.kernels.wide import NODES, all_lanes, load, store

STAY = 0.1  # of a rate: a change of less leaves it as it is


@njit(**MERGED)
def set_rate(row: int, rate: float, a: Any) -> None:
    """Of the rotor (row 0) or of a ball; what grows by itself has none."""
    rates = data(a.rates)
    if not rate > 0.0:
        rate = 0.0
    if rate < math.inf and not abs(rate - rates[row]) <= STAY * rates[row]:
        rates[row] = rate
    a.heads[row] = row


@njit(**MERGED)
def follow(row: int, head: int, a: Any) -> None:
    """After its rate is set: a ball has the acceleration of another one that it touches."""
    a.heads[row] = head


@njit(**MERGED)
def know_rates(step: float, a: Any) -> None:
    """The matrices h (1 + h rate A)^-1 A for this step, unless they are known."""
    rates, known, places, same = data(a.rates), data(a.rates_known), data(a.solver_places), True
    for row in range(1 + a.balls):
        same = same and known[row] == step * rates[row]
    if same and a.held[STEP_KNOWN] == step:
        return
    a.held[STEP_KNOWN] = step
    for row in range(1 + a.balls):
        known[row] = step * rates[row]
        if row > 1 and known[row] == known[row - 1]:
            places[row] = places[row - 1]
        else:
            places[row] = row * SQUARE
            _damped(step, known[row], row * SQUARE, a)


@njit(**MERGED)
def _damped(step: float, x: float, place: int, a: Any) -> None:
    """h (1 + x A)^-1 A from this place on."""
    matrices, determinant, solvers = data(a.radau.damped), data(a.radau.determinant), data(a.solvers)
    size = determinant[NODES]
    for q in range(NODES - 1, -1, -1):
        size = size * x + determinant[q]
    scale = step / size
    for j in range(0, NODES, 4):
        one, two, three, four = all_lanes(0.0), all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)
        for q in range(NODES - 1, -1, -1):
            column = q * SQUARE + j * NODES
            one = one * x + load(matrices, column)
            two = two * x + load(matrices, column + NODES)
            three = three * x + load(matrices, column + 2 * NODES)
            four = four * x + load(matrices, column + 3 * NODES)
        column = place + j * NODES
        store(one * scale, solvers, column)
        store(two * scale, solvers, column + NODES)
        store(three * scale, solvers, column + 2 * NODES)
        store(four * scale, solvers, column + 3 * NODES)

"""What a mode does over a step: its own motion e^(z c), and the sums W with p(c_i) = e^(z c_i) p0 + h sum_j W_ij N_j.

z is the exponent of the mode times the step. N is the polynomial through the nodes, and the integral of e^(z (c - s)) N(s) is
taken exactly: for a small z from the series in z with the iterated integrals of N, else from the particular solution y =
-sum_q N^(q) / z^(q+1), which is a finite sum.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.integrators.collocation.radau import SERIES, TERMS
from autobalancer.kernels.pointers import data
from autobalancer.kernels.trigonometry import exponential_of_lanes, sine_cosine_of_lanes
from autobalancer.kernels.wide import NODES, all_lanes, load, store

SQUARE = NODES * NODES
SMALL = 1e-17  # a term of the series that is less is left out


@njit(**MERGED)
def decay(mode: int, real: float, a: Any) -> None:
    """e^(Re z c) at the nodes."""
    store(exponential_of_lanes(load(data(a.radau.nodes), 0) * real), data(a.decays), mode * NODES)


@njit(**MERGED)
def _add_powers(matrices: Any, count: int, powers: Any, sums: Any, first: int) -> None:
    """sum_q matrix_q z^q over so many powers; four columns at once, so that no sum waits for another."""
    for j in range(0, NODES, 4):
        real_0, real_1, real_2, real_3 = all_lanes(0.0), all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)
        beside_0, beside_1, beside_2, beside_3 = all_lanes(0.0), all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)
        for q in range(count):
            real, imaginary, place = powers[2 * q], powers[2 * q + 1], q * SQUARE + j * NODES
            column = load(matrices, place)
            real_0, beside_0 = real_0 + column * real, beside_0 + column * imaginary
            column = load(matrices, place + NODES)
            real_1, beside_1 = real_1 + column * real, beside_1 + column * imaginary
            column = load(matrices, place + 2 * NODES)
            real_2, beside_2 = real_2 + column * real, beside_2 + column * imaginary
            column = load(matrices, place + 3 * NODES)
            real_3, beside_3 = real_3 + column * real, beside_3 + column * imaginary
        place = first + j * NODES
        store(real_0, sums, place)
        store(real_1, sums, place + NODES)
        store(real_2, sums, place + 2 * NODES)
        store(real_3, sums, place + 3 * NODES)
        place += SQUARE
        store(beside_0, sums, place)
        store(beside_1, sums, place + NODES)
        store(beside_2, sums, place + 2 * NODES)
        store(beside_3, sums, place + 3 * NODES)


@njit(**MERGED)
def exponentials(mode: int, real: float, imaginary: float, a: Any) -> None:
    """Factors and sums of a mode with z = real + i imaginary; its decay is known."""
    factors, sums, work = data(a.factors), data(a.sums), data(a.work)
    sine, cosine = sine_cosine_of_lanes(load(data(a.radau.nodes), 0) * imaginary)
    size = load(data(a.decays), mode * NODES)
    factor_real, factor_imaginary = size * cosine, size * sine
    store(factor_real, factors, mode * 2 * NODES)
    store(factor_imaginary, factors, (mode * 2 + 1) * NODES)
    first = mode * 2 * SQUARE
    if real * real + imaginary * imaginary > SERIES * SERIES:
        slopes, starts = data(a.radau.slopes), data(a.radau.starts)
        inverse = 1.0 / (real * real + imaginary * imaginary)
        back_real, back_imaginary = real * inverse, -imaginary * inverse
        power_real, power_imaginary = -back_real, -back_imaginary
        start_real, start_imaginary = all_lanes(0.0), all_lanes(0.0)
        for q in range(NODES):
            work[2 * q], work[2 * q + 1] = power_real, power_imaginary
            its = load(starts, q * NODES)
            start_real += its * power_real
            start_imaginary += its * power_imaginary
            power_real, power_imaginary = (
                power_real * back_real - power_imaginary * back_imaginary,
                power_real * back_imaginary + power_imaginary * back_real,
            )
        store(start_real, work, 2 * NODES)
        store(start_imaginary, work, 3 * NODES)
        _add_powers(slopes, NODES, work, sums, first)
        for j in range(NODES):
            at_start, beside = work[2 * NODES + j], work[3 * NODES + j]
            sum_real, sum_imaginary = load(sums, first + j * NODES), load(sums, first + SQUARE + j * NODES)
            store(sum_real - factor_real * at_start + factor_imaginary * beside, sums, first + j * NODES)
            store(sum_imaginary - factor_real * beside - factor_imaginary * at_start, sums, first + SQUARE + j * NODES)
        return
    integrals = data(a.radau.integrals)
    power_real, power_imaginary, shrink, count = 1.0, 0.0, 1.0, 0
    while count < TERMS:
        work[2 * count], work[2 * count + 1] = power_real, power_imaginary
        power_real, power_imaginary = (
            power_real * real - power_imaginary * imaginary,
            power_real * imaginary + power_imaginary * real,
        )
        count += 1
        shrink /= count
        if (abs(power_real) + abs(power_imaginary)) * shrink < SMALL:
            break
    _add_powers(integrals, count, work, sums, first)

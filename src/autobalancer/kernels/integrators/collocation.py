"""Long steps by exponential collocation: the linear motion exactly, all else as polynomials through the nodes of a step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal, localcontext
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.compiler.flags import APART, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import (
    data,
    deref,
    passed_by_address,
    pointer_to,
    struct_type,
    value_type,
)
from autobalancer.kernels.compiler.simd import NODES, all_lanes, load, store
from autobalancer.kernels.system import Floats, Integers, tuple_type
from autobalancer.kernels.trigonometry import exponential_of_lanes, sine_cosine_of_lanes

# The eight Radau nodes of a step and all matrices over them, worked out with sixty digits.
#
# A polynomial N of degree seven is known by its values at the nodes c_i, which are fractions of the step; c_8 = 1. A
# matrix stands column by column: eight numbers for every node j, one for each node i.


TERMS = 27  # of the series in the exponent; the last is below rounding up to SERIES
SERIES = 3.0  # up to this exponent over a step the series is taken, beyond it the particular solution
DIGITS = 60


class Radau(NamedTuple):
    """Numbers of the nodes."""

    nodes: Floats  # (8,)
    integrals: Floats  # (TERMS 8 8) integral of N from 0 to c_i, then its integral, and so on
    slopes: Floats  # (8 8 8) N, its first derivative and so on at the nodes
    starts: Floats  # (8 8) the same at 0
    onward: Floats  # (8 8) N at 1 + c_i
    top: Floats  # (8,) leading Legendre coefficient of N
    weights: Floats  # (8,) of the barycentric formula through the nodes
    powers: Floats  # (8 8) coefficients of x to x^8 of the polynomial that is 0 at 0
    bends: Floats  # (9,) slope of each basis polynomial through 0 and the nodes at its own place
    start_weight: float  # of the barycentric formula through 0 and the nodes
    damped: Floats  # (8 8 8) with integral A: (1 + x A)^-1 A is the sum of x^q times these, over the sum of x^q times the next
    determinant: Floats  # (9,)


_Numbers = list[Decimal]


@cache
def radau() -> Radau:
    """See above."""
    with localcontext() as context:
        context.prec = DIGITS
        # in decimals of many digits, because iterated integrals and slopes cancel
        nodes = _nodes()
        basis = [_lagrange(nodes, j) for j in range(NODES)]
        with_zero = [Decimal(0), *nodes]
        around = [_lagrange(with_zero, j) for j in range(NODES + 1)]
        # integrals of the basis at the nodes, iterated as often as the series needs
        integrals, pieces = [], basis
        for _ in range(TERMS):
            pieces = [_integral(one) for one in pieces]
            integrals.append(_table(pieces, nodes))
        # its derivatives at the nodes and at the begin, for the particular solution
        slopes, starts, pieces = [], [], basis
        for _ in range(NODES):
            slopes.append(_table(pieces, nodes))
            starts.append([_at(one, Decimal(0)) for one in pieces])
            pieces = [_slope(one) for one in pieces]
        # the estimate of the error: how much of the highest Legendre polynomial the values at the nodes hold
        highest = Decimal(1)  # leading coefficient of the Legendre polynomial of degree seven over the step
        for k in range(1, NODES):
            highest = highest * (2 * (2 * k - 1)) / k
        return Radau(
            nodes=_floats(nodes),
            integrals=_floats(integrals),
            slopes=_floats(slopes),
            starts=_floats(starts),
            onward=_floats(_table(basis, [1 + c for c in nodes])),
            top=_floats([one[-1] / highest for one in basis]),
            weights=_floats([1 / _product(nodes, j) for j in range(NODES)]),
            powers=_floats([one[1:] for one in around[1:]]),
            bends=_floats([_at(_slope(one), place) for one, place in zip(around, with_zero, strict=True)]),
            start_weight=float(1 / _product(with_zero, 0)),
            **_damped(integrals[0]),
        )


def _damped(columns: list[_Numbers]) -> dict[str, Floats]:
    """After Faddeev and LeVerrier: M_0 = 1, d_q = tr(A M_(q-1)) / q, M_q = d_q - A M_(q-1), all columns first."""
    one = [[Decimal(int(i == j)) for i in range(NODES)] for j in range(NODES)]
    matrix, found, determinant = one, [], [Decimal(1)]
    for q in range(1, NODES + 1):
        product = [
            [sum((columns[k][i] * its[k] for k in range(NODES)), Decimal(0)) for i in range(NODES)] for its in matrix
        ]
        found.append(product)
        determinant.append(sum((product[i][i] for i in range(NODES)), Decimal(0)) / q)
        matrix = [
            [determinant[-1] * unit - its for unit, its in zip(*both, strict=True)]
            for both in zip(one, product, strict=True)
        ]
    return {"damped": _floats(found), "determinant": _floats(determinant)}


def _nodes() -> _Numbers:
    """Roots of P_8 - P_7 on (0, 1], by Newton's method from their neighborhoods."""
    coefficients = np.zeros(NODES + 1)
    coefficients[-2:] = -1.0, 1.0
    guesses = np.sort(np.polynomial.legendre.legroots(coefficients).real)[:-1]
    found = []
    for guess in guesses:
        x = Decimal(float(guess))
        for _ in range(8):
            before, value, rates = Decimal(1), x, (Decimal(0), Decimal(1))
            for k in range(2, NODES + 1):
                before, value, rates = (
                    value,
                    ((2 * k - 1) * x * value - (k - 1) * before) / k,
                    (rates[1], rates[0] + (2 * k - 1) * value),
                )
            x -= (value - before) / (rates[1] - rates[0])
        found.append((x + 1) / 2)
    return [*found, Decimal(1)]


def _product(places: _Numbers, j: int) -> Decimal:
    result = Decimal(1)
    for i, place in enumerate(places):
        if i != j:
            result *= places[j] - place
    return result


def _lagrange(places: _Numbers, j: int) -> _Numbers:
    """Coefficients of the polynomial that is 1 at place j and 0 at the others, lowest power first."""
    result = [1 / _product(places, j)]
    for i, place in enumerate(places):
        if i != j:
            result = [a - place * b for a, b in zip([Decimal(0), *result], [*result, Decimal(0)], strict=True)]
    return result


def _integral(polynomial: _Numbers) -> _Numbers:
    return [Decimal(0), *(a / (k + 1) for k, a in enumerate(polynomial))]


def _slope(polynomial: _Numbers) -> _Numbers:
    return [k * a for k, a in enumerate(polynomial)][1:] or [Decimal(0)]


def _at(polynomial: _Numbers, x: Decimal) -> Decimal:
    result = Decimal(0)
    for a in reversed(polynomial):
        result = result * x + a
    return result


def _table(polynomials: list[_Numbers], places: _Numbers) -> list[_Numbers]:
    return [[_at(one, place) for place in places] for one in polynomials]


def _floats(numbers: Sequence[object]) -> Floats:
    return np.array(numbers, dtype=object).astype(np.float64).ravel()


# What collocation remembers between two calls, beside the memory of every stepper: the motion at the nodes of a step.
#
# Unknowns have a row of eight lanes each, one lane for a node. With K modes and n balls the rows of ``values`` are
#
#     amplitudes (2 K: real and imaginary part of each), rotor speed, rotor angle, ball angles (n), ball speeds (n)
#
# and those of ``forces`` what drives them: 2 K of the amplitudes, p' = (exponent - i turning w0) p + force, the
# acceleration of the rotor, the accelerations of the balls (n). w0 is a frozen speed.


# places in Amplitudes.held
FROZEN, FROZEN_BEFORE, LENGTH_BEFORE, LENGTH_KNOWN, FROZEN_KNOWN, DECAY_KNOWN = range(6)
# step of the explicit pair when it was used last; when the work of long steps was counted last
PAIR_STEP, SINCE = 6, 7
BEGINS = 8  # where in the last step this one begins
BASIS = 9  # number of the modes in force; -1: none yet
STEP_KNOWN = 10  # step for which the matrices of the rates are known
HELD = 11
# places in Amplitudes.tallies
SWEEPS, RENEWED, UNSETTLED, LONG_STEPS, EXPLICIT, LEFT, CHUNK, IN_A_ROW, SWEEPS_THEN, HANDED = range(10)
TALLIES = 10


@passed_by_address
class Amplitudes(NamedTuple):
    """Numbers of a linear rotor with K modes and n balls, and the work space of its steps."""

    modes: int  # K
    balls: int  # n
    turning: int  # 1 if the axes turn with the rotor
    radau: Radau
    exponents: Floats  # (2 K,) real and imaginary part
    places: Integers  # (2 K,) where in the state the coordinates and their velocities are
    shapes: Floats  # (2 K 2 K) row by row: coordinates from amplitudes
    inverse: Floats  # (2 K 2 K) amplitudes from coordinates
    numbers: Floats  # own numbers of the equations at the nodes
    bases: Floats  # modes at several speeds; (0,) where they are the same at any speed
    held: Floats  # (HELD,)
    tallies: Integers  # (TALLIES,)
    begin: Floats  # (2 K,) amplitudes at the begin of a step
    weights: Floats  # (rows of values,) inverse tolerances
    values: Floats
    forces: Floats
    forces_before: Floats  # of the last step
    amplitudes_before: Floats  # (2 K 8)
    decays: Floats  # (K 8) e^(Re z c)
    factors: Floats  # (K 16) e^(z c): eight real parts, eight imaginary parts
    sums: Floats  # (K 128) what the forces do: 64 real parts, 64 imaginary parts
    free: Floats  # (2 K,) amplitudes that no force drives, for the dense output
    rates: Floats  # (1 + n) how fast the speeds of rotor and balls die out by themselves, 1/s
    rates_known: Floats  # (1 + n) these times the step, for which there are
    solvers: Floats  # ((1 + n) 64) matrices that integrate the speeds
    solver_places: Integers  # (1 + n) where each of them begins
    heads: Integers  # (1 + n) whose acceleration each of them has: its own number, or that of a ball that it touches
    inside: Floats  # as values, at eight places of a piece of the step
    stretch: Floats  # (64,) forces of the last step at the nodes of this one
    origin: Floats  # (n,) state at the begin of the step
    reached: Floats  # (n,) state at the end of a piece
    balls_work: Floats  # (8 n 8 + 16) rows of the balls, and the acceleration of their race
    work: Floats  # (WORK,)


WORK = 20 * NODES + 64
NO_BASES = np.zeros(0)
amplitudes_type = struct_type(tuple_type(Amplitudes, radau=tuple_type(Radau)))
amplitudes_at = pointer_to(value_type(amplitudes_type))
nodes_type = types.FunctionType(types.void(types.float64, types.float64, types.voidptr, types.voidptr))
"""(time, step, system, amplitudes): ``forces`` from ``values`` at all nodes of the step that begins at ``time``."""
watch_type = types.FunctionType(types.float64(types.float64, types.voidptr, types.voidptr))
"""(step, system, amplitudes): the fraction of the step up to which these forces hold, 1 if to its end.

SWITCHES if the switch has to tell.
"""
SWITCHES = 2.0


def _held() -> Floats:
    found = np.full(HELD, np.nan)
    found[BASIS] = -1.0
    return found


def amplitudes(
    exponents: np.ndarray,
    shapes: Floats,
    places: Integers,
    balls: int,
    numbers: Floats,
    size: int,
    *,
    turning: bool,
    bases: Floats = NO_BASES,
) -> Amplitudes:
    """Fresh ones.

    Parameters
    ----------
    exponents
        (K,) complex, of the modes at a speed of zero.
    shapes
        (2 K, 2 K) coordinates and velocities from real and imaginary parts of the amplitudes, alternating.
    places
        (2 K,) where these coordinates are in the state.
    size
        Length of the state.
    balls, numbers, turning
        See :class:`Amplitudes`.
    """
    modes = len(exponents)
    values, forces = 2 * modes + 2 + 2 * balls, 2 * modes + 1 + balls
    return Amplitudes(
        modes=modes,
        balls=balls,
        turning=int(turning),
        radau=radau(),
        exponents=np.column_stack([np.real(exponents), np.imag(exponents)]).astype(np.float64).ravel(),
        places=np.asarray(places, np.int64),
        shapes=np.array(shapes, np.float64).ravel(),
        inverse=np.asarray(np.linalg.inv(shapes), np.float64).ravel(),
        numbers=np.array(numbers, np.float64),
        bases=bases,
        held=_held(),
        tallies=np.zeros(TALLIES, np.int64),
        begin=np.zeros(2 * modes),
        weights=np.zeros(values),
        values=np.zeros(NODES * values),
        forces=np.zeros(NODES * forces),
        forces_before=np.zeros(NODES * forces),
        amplitudes_before=np.zeros(NODES * 2 * modes),
        decays=np.zeros(NODES * modes),
        factors=np.zeros(2 * NODES * modes),
        sums=np.zeros(2 * NODES * NODES * modes),
        free=np.zeros(2 * modes),
        rates=np.zeros(1 + balls),
        rates_known=np.full(1 + balls, np.nan),
        solvers=np.zeros(NODES * NODES * (1 + balls)),
        solver_places=np.zeros(1 + balls, np.int64),
        heads=np.arange(1 + balls),
        inside=np.zeros(NODES * values),
        stretch=np.zeros(NODES * NODES),
        origin=np.zeros(size),
        reached=np.zeros(size),
        balls_work=np.zeros(NODES * (8 * balls + 2)),
        work=np.zeros(WORK),
    )


# What a mode does over a step: its own motion e^(z c), and the sums W with p(c_i) = e^(z c_i) p0 + h sum_j W_ij N_j.
#
# z is the exponent of the mode times the step. N is the polynomial through the nodes, and the integral of e^(z (c -
# s)) N(s) is taken exactly: for a small z from the series in z with the iterated integrals of N, else from the
# particular solution y = -sum_q N^(q) / z^(q+1), which is a finite sum.


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
    # e^(z c) at the nodes
    sine, cosine = sine_cosine_of_lanes(load(data(a.radau.nodes), 0) * imaginary)
    size = load(data(a.decays), mode * NODES)
    factor_real, factor_imaginary = size * cosine, size * sine
    store(factor_real, factors, mode * 2 * NODES)
    store(factor_imaginary, factors, (mode * 2 + 1) * NODES)
    first = mode * 2 * SQUARE
    # a large z: the particular solution, a finite sum of the derivatives of the polynomial, less its value at the start
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
    # a small z: the series, as the finite sum would cancel
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


# Speeds that die out by themselves: that of the rotor by its motor, those of balls by their drag.
#
# With u' = r - rate u, r all else, and A the integrals over the nodes, the values at all nodes follow from the
# accelerations a that were found with the values v: u = u0 + h (1 + h rate A)^-1 A (a + rate (v - u0)). So the
# iteration need not find out how drag acts, and a step may be long against 1/rate. Where a rate is not exact, only the
# iteration takes longer.


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
    # balls of one rate share a matrix
    for row in range(1 + a.balls):
        known[row] = step * rates[row]
        if row > 1 and known[row] == known[row - 1]:
            places[row] = places[row - 1]
        else:
            places[row] = row * SQUARE
            _damped_rate(step, known[row], row * SQUARE, a)


@njit(**MERGED)
def _damped_rate(step: float, x: float, place: int, a: Any) -> None:
    """h (1 + x A)^-1 A from this place on."""
    matrices, determinant, solvers = data(a.radau.damped), data(a.radau.determinant), data(a.solvers)
    # determinant and adjoint of 1 + x A as polynomials in x (Horner), so no system is solved; four columns at once
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


# Modes of a rotor whose gyroscopic forces change them with the speed, known at several speeds: the bases.
#
# Between two of them the exponents drift in proportion to the speed, and the shapes are those of the basis in force;
# what this leaves out is among the forces. ``bases`` has for each speed, ascending and equally spaced: the speed, the
# exponents (2 K), what these gain per speed (2 K), the shapes and their inverse (2 K 2 K each). Room for the change
# from one to another follows.


OF_SPEED, OF_EXPONENTS = 0, 1
STAY_IN_BASIS = 0.6  # of the way between two bases: beyond it the next one is taken


@njit(**MERGED)
def stride(modes: int) -> int:
    """Length of a basis."""
    return 1 + 4 * modes + 8 * modes * modes


def room_of_change(modes: int) -> int:
    """Length of what follows the bases."""
    return 2 * modes * (2 * modes + NODES)


@njit(**MERGED)
def basis_at(a: Any) -> int:
    """Where the basis in force begins."""
    return int(a.held[BASIS]) * stride(a.modes)


@njit(**MERGED)
def drift(part: int, a: Any) -> float:
    """What a part of an exponent gains per speed."""
    if a.bases.size == 0:
        return 0.0
    return float(data(a.bases)[basis_at(a) + OF_EXPONENTS + 2 * a.modes + part])


@njit(**MERGED)
def _exponent(part: int, speed: float, a: Any) -> float:
    bases, at = data(a.bases), basis_at(a)
    place = at + OF_EXPONENTS + part
    return float(bases[place] + (speed - bases[at + OF_SPEED]) * bases[place + 2 * a.modes])


@njit(**APART)
def take_basis(amplitudes: Any) -> None:
    """Exponents, shapes and their inverse for the frozen speed; what is kept of the last step is written in them."""
    a = deref(amplitudes)
    if a.bases.size == 0:
        return
    # how many bases there are, and between which two the frozen speed is
    size, length, bases, speed = 2 * a.modes, stride(a.modes), data(a.bases), a.held[FROZEN]
    last = (a.bases.size - size * (size + NODES)) // length - 1
    room = (last + 1) * length
    way = 0.0
    if last > 0:
        way = (speed - bases[0]) / (bases[length] - bases[0])
    # stay in the basis in force unless the next one is clearly nearer, so that steps do not go to and fro
    near = a.held[BASIS]
    if not abs(way - near) <= STAY_IN_BASIS:
        near = float(min(max(int(way + 0.5), 0), last))
    if near != a.held[BASIS]:
        # another basis: what is known of the last step is written in its amplitudes
        before, known = a.held[FROZEN_BEFORE], a.held[BASIS] >= 0.0
        if known:
            _to_rates(1.0, before, a)
        a.held[BASIS] = near
        first = basis_at(a) + OF_EXPONENTS + 2 * size
        shapes, inverse = data(a.shapes), data(a.inverse)
        old, work = shapes, bases
        for i in range(size):
            for j in range(size):
                total = 0.0
                for k in range(size):
                    total += bases[first + size * size + i * size + k] * old[k * size + j]
                work[room + i * size + j] = total
        for i in range(size * size):
            shapes[i], inverse[i] = bases[first + i], bases[first + size * size + i]
        if known:
            _changed(data(a.amplitudes_before), room, a)
            _changed(data(a.forces_before), room, a)
            _to_rates(-1.0, before, a)
    # exponents at the frozen speed; all that was known for the old ones is to be found anew
    for part in range(size):
        a.exponents[part] = _exponent(part, speed, a)
    a.held[LENGTH_KNOWN] = a.held[DECAY_KNOWN] = math.nan


@njit(**MERGED)
def _to_rates(sign: float, speed: float, a: Any) -> None:
    """Add to the forces of the last step what the modes do by themselves, or take it away."""
    forces, amplitudes = data(a.forces_before), data(a.amplitudes_before)
    for mode in range(a.modes):
        one, other = 2 * mode * NODES, (2 * mode + 1) * NODES
        real, imaginary = sign * _exponent(2 * mode, speed, a), sign * _exponent(2 * mode + 1, speed, a)
        its, beside = load(amplitudes, one), load(amplitudes, other)
        store(load(forces, one) + its * real - beside * imaginary, forces, one)
        store(load(forces, other) + its * imaginary + beside * real, forces, other)


@njit(**MERGED)
def _changed(rows: Any, change: int, a: Any) -> None:
    """Rows of amplitudes in the new shapes."""
    size, numbers = 2 * a.modes, data(a.bases)
    first = change + size * size
    for i in range(size):
        total = all_lanes(0.0)
        for j in range(size):
            total += load(rows, j * NODES) * numbers[change + i * size + j]
        store(total, numbers, first + i * NODES)
    for i in range(size):
        store(load(numbers, first + i * NODES), rows, i * NODES)

"""The eight Radau nodes of a step and all matrices over them, worked out with sixty digits.

A polynomial N of degree seven is known by its values at the nodes c_i, which are fractions of the step; c_8 = 1. A matrix stands
column by column: eight numbers for every node j, one for each node i.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.system import Floats, vector_type
from autobalancer.kernels.wide import NODES

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


radau_type = types.NamedTuple([vector_type] * 9 + [types.float64] + [vector_type] * 2, Radau)
_Numbers = list[Decimal]


@cache
def radau() -> Radau:
    """See above."""
    with localcontext() as context:
        context.prec = DIGITS
        nodes = _nodes()
        basis = [_lagrange(nodes, j) for j in range(NODES)]
        with_zero = [Decimal(0), *nodes]
        around = [_lagrange(with_zero, j) for j in range(NODES + 1)]
        integrals, pieces = [], basis
        for _ in range(TERMS):
            pieces = [_integral(one) for one in pieces]
            integrals.append(_table(pieces, nodes))
        slopes, starts, pieces = [], [], basis
        for _ in range(NODES):
            slopes.append(_table(pieces, nodes))
            starts.append([_at(one, Decimal(0)) for one in pieces])
            pieces = [_slope(one) for one in pieces]
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

"""Explicit Runge-Kutta pairs as numbers: one layout for all, so that one stepper serves all.

The last main stage is the derivative at the new point (first same as last), its weights are the solution's.
The dense output is a polynomial in the step fraction x: ``y(x) = y0 + h sum_s k_s sum_j P[s, j] x^(j+1)``.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.polynomial import Polynomial

from autobalancer.kernels.integrators import dormand_prince_8 as dp8
from autobalancer.kernels.system import Floats, matrix_type, vector_type


class Tableau(NamedTuple):
    """One pair. ``s`` main stages, ``s + e`` stages in all, dense output of degree ``d``."""

    main: int  # s
    total: int  # s + e
    order: int  # exponent of the error estimate: error ~ h^order
    nodes: Floats  # (s + e,)
    weights: Floats  # (s + e, s + e) strictly lower triangular
    error: Floats  # (2, s) estimate and, if the pair has one, its lower-order correction
    dense: Floats  # (s + e, d)


tableau_type = types.NamedTuple(
    [types.int64, types.int64, types.int64, vector_type, matrix_type, matrix_type, matrix_type], Tableau
)


@cache
def tsitouras() -> Tableau:
    """Tsitouras 2011, 5(4) with seven stages and free fourth-order dense output."""
    c = [0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0]
    rows = [
        [],
        [0.161],
        [-0.008480655492356989, 0.335480655492357],
        [2.8971530571054935, -6.359448489975075, 4.3622954328695815],
        [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525],
        [5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383],
        [0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774],
    ]
    error = [
        -0.00178001105222577714,
        -0.0008164344596567469,
        0.007880878010261995,
        -0.1447110071732629,
        0.5823571654525552,
        -0.45808210592918697,
        0.015151515151515152,
    ]
    dense = [
        [1.0, -2.763706197274826, 2.9132554618219126, -1.0530884977290216],
        [0.0, 0.13169999999999998, -0.2234, 0.1017],
        [0.0, 3.9302962368947516, -5.941033872131505, 2.490627285651253],
        [0.0, -12.411077166933676, 30.33818863028232, -16.548102889244902],
        [0.0, 37.50931341651104, -88.1789048947664, 47.37952196281928],
        [0.0, -27.896526289197286, 65.09189467479366, -34.87065786149661],
        [0.0, 1.5, -4.0, 2.5],
    ]
    return _pack(7, 5, c, rows, [error, [0.0] * 7], dense)


@cache
def dormand_prince_8() -> Tableau:
    """Dormand-Prince 8(5,3), twelve stages and three more for the seventh-order dense output."""
    main, total = 13, 16
    rows = [list(row) for row in dp8.A]
    rows[12] = list(dp8.B)  # the first twelve stages make the solution; the thirteenth is taken there
    # nested form of the source: x (F0 + (1-x)(F1 + x (F2 + (1-x)(F3 + ...)))), F linear in the stages
    solution, first, last = np.zeros(total), np.zeros(total), np.zeros(total)
    solution[:12] = dp8.B
    first[0] = last[12] = 1.0
    terms = [solution, first - solution, 2.0 * solution - first - last, *(np.asarray(row) for row in dp8.D)]
    x, basis, dense = Polynomial([0.0, 1.0]), Polynomial([1.0]), np.zeros((total, 7))
    for number, term in enumerate(terms):
        basis = basis * (x if number % 2 == 0 else 1.0 - x)
        shape = basis.coef[1:]
        dense[:, : shape.size] += np.outer(term, shape)
    return _pack(main, 8, list(dp8.C), rows, [list(dp8.E5), list(dp8.E3)], dense.tolist())


def _pack(
    main: int, order: int, c: list[float], rows: list[list[float]], error: list[list[float]], dense: list[list[float]]
) -> Tableau:
    total = len(rows)
    weights = np.zeros((total, total))
    for number, row in enumerate(rows):
        weights[number, : len(row)] = row
    estimate = np.zeros((2, main))
    for number, line in enumerate(error):
        estimate[number, : len(line)] = line
    return Tableau(main, total, order, np.array(c), weights, estimate, np.array(dense))

"""Explicit Runge-Kutta pairs as numbers: one layout for all, so that one stepper serves all.

The last main stage is the derivative at the new point (first same as last), its weights are the solution's.
The dense output is a polynomial in the step fraction x: ``y(x) = y0 + h sum_s k_s sum_j P[s, j] x^(j+1)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from autobalancer.kernels.integrators import dormand_prince_8 as dp8
from autobalancer.kernels.system import Floats, Matrix, vector_type


class Tableau(NamedTuple):
    """One pair: ``main`` stages, ``total`` stages with those for the dense output of degree ``degree``.

    All sums over stages stand in one sparse matrix: row s makes the argument of stage s, row ``total`` the error
    estimate, row ``total + 1`` its lower-order correction (perhaps empty), and from ``total + 2`` on the
    coefficients of x, x^2, ... of the dense output.
    """

    main: int
    total: int
    degree: int
    order: int  # exponent of the error estimate: error ~ h^order
    nodes: Floats  # (total,)
    first: NDArray[np.int64]  # (rows + 1,) where the entries of a row begin
    columns: NDArray[np.int64]  # the stage of each entry; ascending in a row, because the latest stage comes last
    values: Floats  # its weight

    @property
    def dense(self) -> Matrix:
        """Weight of each stage in each power of x in the dense output, (total, degree)."""
        return self.matrix[self.total + 2 :].T

    @property
    def matrix(self) -> Matrix:
        """All rows in full, (total + 2 + degree, total)."""
        full = np.zeros((self.first.size - 1, self.total))
        rows = np.repeat(np.arange(self.first.size - 1), np.diff(self.first))
        full[rows, self.columns] = self.values
        return full


_places = types.Array(types.int64, 1, "C")
tableau_type = types.NamedTuple([types.int64] * 4 + [vector_type, _places, _places, vector_type], Tableau)


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
    return _pack(7, 5, c, [*rows, error, [], *np.transpose(dense)])


@cache
def dormand_prince_8() -> Tableau:
    """Dormand-Prince 8(5,3), twelve stages and three more for the seventh-order dense output."""
    total = len(dp8.C)
    rows = [*dp8.A[:12], dp8.B, *dp8.A[13:]]  # twelve stages make the solution; the thirteenth is taken there
    # nested form of the source: x (F0 + (1-x)(F1 + x (F2 + (1-x)(F3 + ...)))), F linear in the stages
    solution, first, last = np.zeros(total), np.zeros(total), np.zeros(total)
    solution[:12] = dp8.B
    first[0] = last[12] = 1.0
    terms = [solution, first - solution, 2.0 * solution - first - last, *(np.asarray(row) for row in dp8.D)]
    x, basis, dense = Polynomial([0.0, 1.0]), Polynomial([1.0]), np.zeros((7, total))
    for number, term in enumerate(terms):
        basis = basis * (x if number % 2 == 0 else 1.0 - x)
        shape = basis.coef[1:]
        dense[: shape.size] += np.outer(shape, term)
    return _pack(13, 8, list(dp8.C), [*rows, dp8.E5, dp8.E3, *dense])


def _pack(main: int, order: int, nodes: list[float], rows: list[Sequence[float]]) -> Tableau:
    entries = [[(column, value) for column, value in enumerate(row) if value != 0.0] for row in rows]
    flat = [entry for row in entries for entry in row]
    return Tableau(
        main=main,
        total=len(nodes),
        degree=len(rows) - len(nodes) - 2,
        order=order,
        nodes=np.array(nodes, np.float64),
        first=np.cumsum([0, *(len(row) for row in entries)]),
        columns=np.array([column for column, _ in flat], np.int64),
        values=np.array([value for _, value in flat], np.float64),
    )

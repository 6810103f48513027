"""Explicit Runge-Kutta pairs as numbers: one layout for all, so that one stepper serves all.

The last main stage is the derivative at the new point (first same as last), its weights are the solution's.
The dense output is a polynomial in the step fraction x: ``y(x) = y0 + h sum_s k_s sum_j P[s, j] x^(j+1)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from autobalancer.kernels.compiler.numba_struct import passed_by_address, struct_type
from autobalancer.kernels.system import Floats, Integers, Matrix, tuple_type


@passed_by_address
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
    first: Integers  # (rows + 1,) where the entries of a row begin
    columns: Integers  # the stage of each entry; ascending in a row, because the latest stage comes last
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


tableau_type = struct_type(tuple_type(Tableau))


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
    error = [-0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629]
    error += [0.5823571654525552, -0.45808210592918697, 0.015151515151515152]
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
    total = len(C)
    # nested form of the source: x (F0 + (1-x)(F1 + x (F2 + (1-x)(F3 + ...)))), F linear in the stages
    solution, first, last = np.zeros(total), np.zeros(total), np.zeros(total)
    solution[:12] = A[12]  # twelve stages make the solution; the thirteenth is taken there
    first[0] = last[12] = 1.0
    terms = [solution, first - solution, 2.0 * solution - first - last, *np.array(D)]
    x, basis, dense = Polynomial([0.0, 1.0]), Polynomial([1.0]), np.zeros((7, total))
    for number, term in enumerate(terms):
        basis = basis * (x if number % 2 == 0 else 1.0 - x)
        shape = basis.coef[1:]
        dense[: shape.size] += np.outer(shape, term)
    return _pack(13, 8, C, [*A, E5, E3, *dense])


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


# Coefficients of the Dormand-Prince 8(5,3) pair with its seventh-order dense output.
#
# Hairer, Norsett, Wanner 1993, Solving Ordinary Differential Equations I, section II.10. Row i of ``A`` holds the
# weights of stage i, row 12 those of the solution, rows 13 to 15 the extra stages of the dense output; ``E5`` and ``E3`` are
# the weights of the two error estimates, ``D`` those of the four highest terms of the dense output.


def _numbers(text: str) -> list[list[float]]:
    return [[float(word) for word in row.split()] for row in text.split(";")]


(C,) = _numbers("""
    0 0.05260015195876773 0.0789002279381516 0.1183503419072274 0.2816496580927726 0.3333333333333333 0.25
      0.3076923076923077 0.6512820512820513 0.6 0.8571428571428571 1.0 1.0 0.1 0.2 0.7777777777777778
""")
A = _numbers("""
    0;
    0.05260015195876773;
    0.0197250569845379 0.0591751709536137;
    0.02958758547680685 0 0.08876275643042054;
    0.2413651341592667 0 -0.8845494793282861 0.924834003261792;
    0.037037037037037035 0 0 0.17082860872947386 0.12546768756682242;
    0.037109375 0 0 0.17025221101954405 0.06021653898045596 -0.017578125;
    0.03709200011850479 0 0 0.17038392571223998 0.10726203044637328 -0.015319437748624402 0.008273789163814023;
    0.6241109587160757 0 0 -3.3608926294469414 -0.868219346841726 27.59209969944671 20.154067550477894
      -43.48988418106996;
    0.47766253643826434 0 0 -2.4881146199716677 -0.590290826836843 21.230051448181193 15.279233632882423
      -33.28821096898486 -0.020331201708508627;
    -0.9371424300859873 0 0 5.186372428844064 1.0914373489967295 -8.149787010746927 -18.52006565999696
      22.739487099350505 2.4936055526796523 -3.0467644718982196;
    2.273310147516538 0 0 -10.53449546673725 -2.0008720582248625 -17.9589318631188 27.94888452941996
      -2.8589982771350235 -8.87285693353063 12.360567175794303 0.6433927460157636;
    0.054293734116568765 0 0 0 0 4.450312892752409 1.8915178993145003 -5.801203960010585 0.3111643669578199
      -0.1521609496625161 0.20136540080403034 0.04471061572777259;
    0.056167502283047954 0 0 0 0 0 0.25350021021662483 -0.2462390374708025 -0.12419142326381637 0.15329179827876568
      0.00820105229563469 0.007567897660545699 -0.008298;
    0.03183464816350214 0 0 0 0 0.028300909672366776 0.053541988307438566 -0.05492374857139099 0 0
      -0.00010834732869724932 0.0003825710908356584 -0.00034046500868740456 0.1413124436746325;
    -0.42889630158379194 0 0 0 0 -4.697621415361164 7.683421196062599 4.06898981839711 0.3567271874552811 0 0 0
      -0.0013990241651590145 2.9475147891527724 -9.15095847217987
""")
E3, E5 = _numbers("""
    -0.18980075407240762 0 0 0 0 4.450312892752409 1.8915178993145003 -5.801203960010585 -0.4226823213237919
      -0.1521609496625161 0.20136540080403034 0.02265179219836082 0;
    0.01312004499419488 0 0 0 0 -1.2251564463762044 -0.4957589496572502 1.6643771824549864 -0.35032884874997366
      0.3341791187130175 0.08192320648511571 -0.022355307863886294 0
""")
D = _numbers("""
    -8.428938276109013 0 0 0 0 0.5667149535193777 -3.0689499459498917 2.38466765651207 2.117034582445028
      -0.871391583777973 2.2404374302607883 0.6315787787694688 -0.08899033645133331 18.148505520854727
      -9.194632392478356 -4.436036387594894;
    10.427508642579134 0 0 0 0 242.28349177525817 165.20045171727028 -374.5467547226902 -22.113666853125306
      7.733432668472264 -30.674084731089398 -9.332130526430229 15.697238121770845 -31.139403219565178
      -9.35292435884448 35.81684148639408;
    19.985053242002433 0 0 0 0 -387.0373087493518 -189.17813819516758 527.8081592054236 -11.57390253995963
      6.8812326946963 -1.0006050966910838 0.7777137798053443 -2.778205752353508 -60.19669523126412 84.32040550667716
      11.99229113618279;
    -25.69393346270375 0 0 0 0 -154.18974869023643 -231.5293791760455 357.6391179106141 93.40532418362432
      -37.45832313645163 104.0996495089623 29.8402934266605 -43.53345659001114 96.32455395918828 -39.17726167561544
      -149.72683625798564
""")

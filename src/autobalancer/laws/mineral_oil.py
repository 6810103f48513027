"""Mineral oils of the ISO viscosity grades.

The grade (ISO 3448) fixes the viscosity at 40 degC. The second point comes from the viscosity index: an oil
of index 100 is the reference H of ASTM D2270 (ISO 2909), so its viscosity at 100 degC is a root of H = nu40.
Through both points goes the line of ASTM D341. The density follows API MPMS 11.1 (ASTM D1250).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError
from autobalancer.laws.viscosity import SHIFT_D341, double_log_through, viscosity_from_double_log

ISO_VG = {
    7: 6.8e-6, 10: 10e-6, 15: 15e-6, 22: 22e-6, 32: 32e-6, 46: 46e-6, 68: 68e-6, 100: 100e-6, 150: 150e-6,
    220: 220e-6, 320: 320e-6, 460: 460e-6, 680: 680e-6, 1000: 1000e-6, 1500: 1500e-6,
}  # fmt: skip
"""Grade to mid-point viscosity at 40 degC [m^2/s], ISO 3448. Grades 2, 3 and 5 fall below 2 mm^2/s at
100 degC, where the viscosity index is not defined, and are left out."""

LOWEST, HIGHEST = 273.15, 373.15
"""Temperatures for which the viscosity is offered [K]."""

# ASTM D2270: H = a Y^2 + b Y + c with Y in mm^2/s at 100 degC, each row from its first number up
_REFERENCE_H = (
    (2.0, 0.84155, 1.5521, -0.077), (3.8, 0.78571, 1.7929, -0.183), (4.4, 0.82143, 1.5679, 0.119),
    (5.0, 0.04985, 9.1613, -18.557), (6.4, 0.22619, 7.7369, -16.656), (7.0, 0.79762, -0.7321, 14.610),
    (7.7, 0.05794, 10.5156, -28.240), (9.0, 0.26665, 6.7015, -10.810), (12.0, 0.20073, 8.4658, -22.490),
    (15.0, 0.28889, 5.9741, -4.930), (18.0, 0.24504, 7.4160, -16.730), (22.0, 0.20323, 9.1267, -34.230),
    (28.0, 0.18411, 10.1015, -46.750), (40.0, 0.17029, 11.4866, -80.620), (55.0, 0.17130, 11.3680, -76.940),
    (70.0, 0.16840, 11.8500, -97.000),
)  # fmt: skip
_ENDS = tuple(row[0] for row in _REFERENCE_H[1:])


def reference_viscosity(at_100_degc: float) -> float:
    """Viscosity at 40 degC [m^2/s] of the oil of index 100 that has ``at_100_degc`` [m^2/s] at 100 degC.

    Raises ``QuestionError`` below 2 mm^2/s. Source: ASTM D2270, quantity H. The coefficients meet the printed
    table of the standard within 0.12 %.
    """
    y = at_100_degc * 1e6
    if not 2.0 - 1e-9 <= y < math.inf:
        raise QuestionError(
            f"given {at_100_degc!r} m^2/s at 100 degC; the viscosity index is defined from 2e-6 m^2/s up"
        )
    _, a, b, c = _REFERENCE_H[sum(y >= end for end in _ENDS)]
    return 1e-6 * (a * y * y + b * y + c)


def viscosity_at_100_degc(at_40_degc: float) -> float:
    """Viscosity at 100 degC [m^2/s] of the oil of index 100 with ``at_40_degc`` [m^2/s]; inverse of H.

    Raises ``QuestionError`` below H(2 mm^2/s) = 6.39 mm^2/s or above 5469 mm^2/s.
    """
    from scipy.optimize import brentq

    low, high = 2e-6, 150e-6
    if not reference_viscosity(low) <= at_40_degc <= reference_viscosity(high):
        raise QuestionError(
            f"given {at_40_degc!r} m^2/s at 40 degC; an oil of viscosity index 100 can have "
            f"{reference_viscosity(low):.3g} to {reference_viscosity(high):.3g} m^2/s there"
        )
    return float(brentq(lambda nu: reference_viscosity(nu) - at_40_degc, low, high, xtol=1e-16))


def iso_vg_viscosity(grade: int, temperature: npt.ArrayLike) -> Any:
    """Kinematic viscosity [m^2/s] of an oil of this ISO grade and viscosity index 100 at ``temperature`` [K].

    Of the shape of ``temperature``. Raises ``QuestionError`` for another grade or outside 0 to 100 degC.
    Source: ISO 3448, ASTM D2270, ASTM D341.
    """
    if grade not in ISO_VG:
        raise QuestionError(f"given the grade {grade!r}; ISO VG grades here are {', '.join(map(str, ISO_VG))}")
    t = np.asarray(temperature, float)
    if not bool(np.all((t >= LOWEST) & (t <= HIGHEST))):
        raise QuestionError(f"given {temperature!r} K; the oils are available from {LOWEST:g} to {HIGHEST:g} K")
    at_40 = ISO_VG[grade]
    line = double_log_through((313.15, at_40), (373.15, viscosity_at_100_degc(at_40)), shift=SHIFT_D341)
    return viscosity_from_double_log(t, *line, shift=SHIFT_D341)


def lubricating_oil_density(at_15_degc: float, temperature: npt.ArrayLike) -> Any:
    """Density [kg/m^3] at ``temperature`` [K] of a lubricating oil with ``at_15_degc`` [kg/m^3] at 15 degC.

    Of the shape of ``temperature``. Source: API MPMS 11.1 (ASTM D1250), lubricating oils, K1 = 0.6278.
    """
    expansion = 0.6278 / at_15_degc
    warmer = np.asarray(temperature, float) - 288.15
    return (at_15_degc * np.exp(-expansion * warmer * (1.0 + 0.8 * expansion * warmer)))[()]

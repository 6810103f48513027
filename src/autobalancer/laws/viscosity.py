"""Viscosity and density of liquids against temperature, and of mixtures of two oils.

The double logarithm of the viscosity falls linearly with the logarithm of the temperature (Walther
1931), here in the form of Spannan (2021), eq. (6.1), after Seeton (2006):

    log10(log10(nu + shift)) = P1 + P2 log10(T),    nu in mm^2/s, T in K, shift = 0.8 mm^2/s

ASTM D341 has the same form with a shift of 0.7 mm^2/s. Arguments and results are SI all the same.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError
from autobalancer.roots import root

SHIFT = 0.8e-6
"""Shift of Spannan (2021), eq. (6.1) [m^2/s]."""
SHIFT_D341 = 0.7e-6
"""Shift of ASTM D341 for oils above 2 mm^2/s [m^2/s]."""


def viscosity_from_double_log(
    temperature: npt.ArrayLike, p1: npt.ArrayLike, p2: npt.ArrayLike, *, shift: float = SHIFT
) -> Any:
    """Kinematic viscosity [m^2/s] at ``temperature`` [K], of the broadcast shape of the arguments.

    ``p1``, ``p2`` are the dimensionless coefficients for mm^2/s and K. Source: Spannan (2021), eq. (6.1).
    """
    line = np.asarray(p1, float) + np.asarray(p2, float) * np.log10(np.asarray(temperature, float))
    return (1e-6 * 10.0 ** (10.0**line) - shift)[()]


def double_log_through(
    first: tuple[float, float], second: tuple[float, float], *, shift: float = SHIFT
) -> tuple[float, float]:
    """P1 and P2 of the line through two points ``(temperature [K], viscosity [m^2/s])``.

    Raises ``QuestionError`` for equal temperatures, or if a viscosity plus the shift does not exceed
    1 mm^2/s, where the double logarithm ends.
    """
    (t1, nu1), (t2, nu2) = first, second
    z1, z2 = _double_log(nu1, shift), _double_log(nu2, shift)
    if t1 <= 0.0 or t2 <= 0.0 or t1 == t2:
        raise QuestionError(f"given the temperatures {t1!r} K and {t2!r} K; two different ones above 0 K are needed")
    p2 = (z2 - z1) / math.log10(t2 / t1)
    return z1 - p2 * math.log10(t1), p2


def double_log_from_slope(temperature: float, viscosity: float, p2: float, *, shift: float = SHIFT) -> float:
    """P1 of the line of slope ``p2`` through one point, ``viscosity`` [m^2/s] at ``temperature`` [K]."""
    return _double_log(viscosity, shift) - p2 * math.log10(temperature)


def blend_viscosity(
    fraction: npt.ArrayLike,
    first: tuple[float, float],
    second: tuple[float, float],
    *,
    density: float | None = None,
) -> Any:
    """Kinematic viscosity of a mixture of two liquids [m^2/s], of the shape of ``fraction``.

    Parameters
    ----------
    fraction
        Share of the first liquid, 0 to 1.
    first, second
        ``(viscosity [m^2/s], density [kg/m^3])`` of the two liquids.
    density
        Density of the mixture [kg/m^3]; by default the mean of the two, as the source takes it. With the
        default the law misses the pure liquids by the ratio of their density to the mean.

    Source: Spannan (2021), eq. (6.7), after Zhmud (2014).
    """
    (nu1, rho1), (nu2, rho2) = first, second
    w = np.asarray(fraction, float)
    if not bool(np.all((w >= 0.0) & (w <= 1.0))):
        raise QuestionError(f"given the fraction {fraction!r}; it must be from 0 to 1")
    mean = 0.5 * (rho1 + rho2) if density is None else density
    return (np.exp(w * math.log(nu1 * rho1) + (1.0 - w) * math.log(nu2 * rho2)) / mean)[()]


def blend_fraction(
    viscosity: float, first: tuple[float, float], second: tuple[float, float], *, density: float | None = None
) -> float:
    """Share of the first liquid in a mixture of the wanted ``viscosity`` [m^2/s]; inverse of the law above.

    Raises ``QuestionError`` if no mixture has it. Source: Spannan (2021), eq. (6.8).
    """
    ends = sorted(float(blend_viscosity(w, first, second, density=density)) for w in (0.0, 1.0))
    if ends[0] == ends[1] or not ends[0] <= viscosity <= ends[1]:
        raise QuestionError(
            f"given a viscosity of {viscosity!r} m^2/s; mixtures of these liquids have {ends[0]:.4g} to "
            f"{ends[1]:.4g} m^2/s in this law; take other liquids"
        )
    (nu1, rho1), (nu2, rho2) = first, second
    mean = 0.5 * (rho1 + rho2) if density is None else density
    return math.log(viscosity * mean / (nu2 * rho2)) / math.log(nu1 * rho1 / (nu2 * rho2))


def expanded_density(density: float, expansion: float, temperature: npt.ArrayLike, *, reference: float = 298.15) -> Any:
    """Density [kg/m^3] at ``temperature`` [K] of a liquid that has ``density`` at ``reference``.

    ``expansion`` is the coefficient of volume expansion [1/K]: the volume grows linearly, the mass stays.
    """
    return (density / (1.0 + expansion * (np.asarray(temperature, float) - reference)))[()]


def _double_log(viscosity: float, shift: float) -> float:
    if not 1e-6 < viscosity + shift < math.inf:
        raise QuestionError(
            f"given a viscosity of {viscosity!r} m^2/s; the double logarithm needs more than {1e-6 - shift:.2g} m^2/s"
        )
    return math.log10(math.log10((viscosity + shift) * 1e6))


# Viscosity and density of glycerol-water mixtures.
#
# Viscosity: Cheng (2008), Ind. Eng. Chem. Res. 47, 3285, eqs. (6), (21), (22) and those of the weight in (6); all
# fractions, 0 to 100 degC. Density: Volk and Kähler (2018), Exp. Fluids 59:75, with contraction on mixing, fitted from
# 15 to 30 degC and used here over the range of the viscosity.


LOWEST, HIGHEST = 273.15, 373.15
"""Range of the viscosity law [K]."""


def glycerol_dynamic_viscosity(mass_fraction: npt.ArrayLike, temperature: npt.ArrayLike) -> Any:
    """Dynamic viscosity [Pa s] of a mixture with this mass fraction of glycerol at ``temperature`` [K].

    Shapes broadcast. Raises ``QuestionError`` outside 0 to 1 or 0 to 100 degC. Source: Cheng (2008).
    """
    w, t = _checked(mass_fraction, temperature)
    water = 1.790e-3 * np.exp((-1230.0 - t) * t / (36100.0 + 360.0 * t))
    glycerol = 12.100 * np.exp((-1233.0 + t) * t / (9900.0 + 70.0 * t))
    a = 0.705 - 0.0017 * t
    b = (4.9 + 0.036 * t) * a**2.5
    weight = 1.0 - w + a * b * w * (1.0 - w) / (a * w + b * (1.0 - w))
    return (water**weight * glycerol ** (1.0 - weight))[()]


def glycerol_density(mass_fraction: npt.ArrayLike, temperature: npt.ArrayLike) -> Any:
    """Density [kg/m^3] of a mixture with this mass fraction of glycerol at ``temperature`` [K].

    Shapes broadcast. Raises ``QuestionError`` outside 0 to 1 or 0 to 100 degC.
    Source: Volk and Kähler (2018).
    """
    w, t = _checked(mass_fraction, temperature)
    water, glycerol = _pure_densities(t)
    separate = 1.0 / (w / glycerol + (1.0 - w) / water)
    depth = 1.78e-6 * t**2 - 1.82e-4 * t + 1.41e-2
    contraction = 1.0 + depth * np.maximum(np.sin(np.pi * w**1.31), 0.0) ** 0.81
    return (separate * contraction)[()]


def glycerol_mass_fraction(volume_fraction: npt.ArrayLike, temperature: npt.ArrayLike = 293.15) -> Any:
    """Mass fraction of glycerol from the volumes of the two liquids before mixing, at ``temperature`` [K].

    Raises ``QuestionError`` outside 0 to 1 or 0 to 100 degC.
    """
    v, t = _checked(volume_fraction, temperature)
    water, glycerol = _pure_densities(t)
    return (v * glycerol / (v * glycerol + (1.0 - v) * water))[()]


def _pure_densities(celsius: Any) -> tuple[Any, Any]:
    water = 1000.0 * (1.0 - (np.abs(celsius - 3.98) / 615.0) ** 1.71)
    return water, 1273.3 - 0.6121 * celsius


def _checked(fraction: npt.ArrayLike, temperature: npt.ArrayLike) -> tuple[Any, Any]:
    w, t = np.asarray(fraction, float), np.asarray(temperature, float)
    if not bool(np.all((w >= 0.0) & (w <= 1.0))):
        raise QuestionError(f"given the glycerol fraction {fraction!r}; it must be from 0 to 1")
    if not bool(np.all((t >= LOWEST) & (t <= HIGHEST))):
        raise QuestionError(f"given {temperature!r} K; the law holds from {LOWEST:g} to {HIGHEST:g} K (0 to 100 degC)")
    return w, t - 273.15


# Viscosity and density of water and of air at atmospheric pressure.


WATER_RANGE = (273.15, 373.15)
"""Range of the water laws used here [K]."""
AIR_RANGE = (200.0, 400.0)
"""Range in which the two laws for air are used here [K]."""
ATMOSPHERE = 101325.0
"""Standard atmospheric pressure [Pa]."""


def water_dynamic_viscosity(temperature: npt.ArrayLike) -> Any:
    """Dynamic viscosity of water at 0.1 MPa [Pa s].

    ``temperature`` in K, 0 to 100 degC, else ``QuestionError``. Source: Pátek, Hrubý, Klomfar, Součková and
    Harvey (2009), J. Phys. Chem. Ref. Data 38, 21; also IAPWS SR6-08.
    """
    theta = _within(temperature, WATER_RANGE, "water") / 300.0
    terms = ((280.68, -1.9), (511.45, -7.7), (61.131, -19.6), (0.45903, -40.0))
    return (1e-6 * sum(a * theta**b for a, b in terms))[()]


def water_density(temperature: npt.ArrayLike) -> Any:
    """Density of water at one atmosphere [kg/m^3].

    ``temperature`` in K, 0 to 100 degC, else ``QuestionError``.
    Source: Kell (1975), J. Chem. Eng. Data 20, 97, eq. (16).
    """
    t = _within(temperature, WATER_RANGE, "water") - 273.15
    powers = (999.83952, 16.945176, -7.9870401e-3, -46.170461e-6, 105.56302e-9, -280.54253e-12)
    return (sum(c * t**i for i, c in enumerate(powers)) / (1.0 + 16.879850e-3 * t))[()]


def air_dynamic_viscosity(temperature: npt.ArrayLike) -> Any:
    """Dynamic viscosity of air [Pa s]; ``temperature`` in K, 200 to 400 K, else ``QuestionError``.

    Source: Sutherland's law with the constants of the U.S. Standard Atmosphere (1976), eq. (51).
    """
    t = _within(temperature, AIR_RANGE, "air")
    return (1.458e-6 * t**1.5 / (t + 110.4))[()]


def air_density(temperature: npt.ArrayLike, *, pressure: float = ATMOSPHERE) -> Any:
    """Density of dry air as an ideal gas [kg/m^3].

    ``temperature`` in K, 200 to 400 K, else ``QuestionError``; ``pressure`` in Pa.
    Source: U.S. Standard Atmosphere (1976), gas constant 287.053 J/(kg K).
    """
    return (pressure / (287.053 * _within(temperature, AIR_RANGE, "air")))[()]


def _within(temperature: npt.ArrayLike, limits: tuple[float, float], name: str) -> Any:
    t = np.asarray(temperature, float)
    if not bool(np.all((t >= limits[0]) & (t <= limits[1]))):
        raise QuestionError(f"given {temperature!r} K; {name} is available from {limits[0]:g} to {limits[1]:g} K")
    return t


# Mineral oils of the ISO viscosity grades.
#
# The grade (ISO 3448) fixes the viscosity at 40 degC. The second point comes from the viscosity index: an oil of index
# 100 is the reference H of ASTM D2270 (ISO 2909), so its viscosity at 100 degC is a root of H = nu40. Through both
# points goes the line of ASTM D341. The density follows API MPMS 11.1 (ASTM D1250).


ISO_VG = {
    7: 6.8e-6, 10: 10e-6, 15: 15e-6, 22: 22e-6, 32: 32e-6, 46: 46e-6, 68: 68e-6, 100: 100e-6, 150: 150e-6,
    220: 220e-6, 320: 320e-6, 460: 460e-6, 680: 680e-6, 1000: 1000e-6, 1500: 1500e-6,
}  # fmt: skip
"""Grade to mid-point viscosity at 40 degC [m^2/s], ISO 3448. Grades 2, 3 and 5 fall below 2 mm^2/s at
100 degC, where the viscosity index is not defined, and are left out."""

COLDEST_OIL, HOTTEST_OIL = 273.15, 373.15
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
    low, high = 2e-6, 150e-6
    if not reference_viscosity(low) <= at_40_degc <= reference_viscosity(high):
        raise QuestionError(
            f"given {at_40_degc!r} m^2/s at 40 degC; an oil of viscosity index 100 can have "
            f"{reference_viscosity(low):.3g} to {reference_viscosity(high):.3g} m^2/s there"
        )
    return root(lambda nu: reference_viscosity(nu) - at_40_degc, low, high, xtol=1e-16)


def iso_vg_viscosity(grade: int, temperature: npt.ArrayLike) -> Any:
    """Kinematic viscosity [m^2/s] of an oil of this ISO grade and viscosity index 100 at ``temperature`` [K].

    Of the shape of ``temperature``. Raises ``QuestionError`` for another grade or outside 0 to 100 degC.
    Source: ISO 3448, ASTM D2270, ASTM D341.
    """
    if grade not in ISO_VG:
        raise QuestionError(f"given the grade {grade!r}; ISO VG grades here are {', '.join(map(str, ISO_VG))}")
    t = np.asarray(temperature, float)
    if not bool(np.all((t >= COLDEST_OIL) & (t <= HOTTEST_OIL))):
        raise QuestionError(
            f"given {temperature!r} K; the oils are available from {COLDEST_OIL:g} to {HOTTEST_OIL:g} K"
        )
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

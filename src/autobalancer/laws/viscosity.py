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

SHIFT = 0.8e-6
"""Shift of Spannan (2021), eq. (6.1) [m^2/s]."""
SHIFT_D341 = 0.7e-6
"""Shift of ASTM D341 for oils above 2 mm^2/s [m^2/s]."""
COLD, HOT = 311.15, 372.15
"""Temperatures of the viscosity-temperature coefficient [K]: 38 and 99 degC. Spannan (2021) prints 311 and
372 K, but the printed P1 and P2 follow only from the untruncated values."""


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


def vtc(p1: npt.ArrayLike, p2: npt.ArrayLike) -> Any:
    """Viscosity-temperature coefficient 1 - nu(99 degC) / nu(38 degC), dimensionless; smaller is steadier."""
    return 1.0 - viscosity_from_double_log(HOT, p1, p2) / viscosity_from_double_log(COLD, p1, p2)


def double_log_from_vtc(viscosity: float, coefficient: float, *, temperature: float = 298.15) -> tuple[float, float]:
    """P1 and P2 from one viscosity [m^2/s] at ``temperature`` [K] and the viscosity-temperature coefficient.

    Of the two solutions it takes the flatter one, the other belongs to no liquid. Raises ``QuestionError`` if
    no line has this coefficient, naming the largest one. Source: Spannan (2021), section 6.
    """
    from scipy.optimize import brentq

    z = _double_log(viscosity, SHIFT)

    def p1_of(p2: Any) -> Any:
        return z - p2 * math.log10(temperature)

    slopes = np.linspace(0.0, -12.0, 1201)
    values = vtc(p1_of(slopes), slopes)
    top = int(np.argmax(values))
    if not 0.0 <= coefficient <= values[top]:
        raise QuestionError(
            f"given a viscosity-temperature coefficient of {coefficient!r}; a liquid of {viscosity:g} m^2/s "
            f"at {temperature:g} K can have 0 to {values[top]:.3f} in this law"
        )
    p2 = float(brentq(lambda slope: float(vtc(p1_of(slope), slope)) - coefficient, slopes[top], 0.0, xtol=1e-13))
    return float(p1_of(p2)), p2


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

"""Viscosity and density of glycerol-water mixtures.

Viscosity: Cheng (2008), Ind. Eng. Chem. Res. 47, 3285, eqs. (6), (21), (22) and those of the weight in (6);
all fractions, 0 to 100 degC. Density: Volk and Kähler (2018), Exp. Fluids 59:75, with contraction on mixing,
fitted from 15 to 30 degC and used here over the range of the viscosity.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError

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

"""Viscosity and density of water and of air at atmospheric pressure."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError

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

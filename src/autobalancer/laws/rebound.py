"""Restitution: what an impact leaves of the speed, as metal yields and in a film of fluid; and the damper that leaves it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST = 0.01  # restitution below which a contact would be too stiff


def damping_ratio(restitution: float) -> float:
    """Damping ratio of a spring and a damper that never pull, from the ratio of the speeds after and before.

    Below exp(-2) it is above one. A ratio under 1 % counts as 1 %, which takes a damping ratio of about five.
    """
    if restitution >= 1.0:
        return 0.0
    wanted, low, high = max(restitution, LEAST), 0.0, 20.0
    while low < (middle := 0.5 * (low + high)) < high:  # to the last digit; the rebound falls as the ratio grows
        low, high = (middle, high) if rebound(middle) > wanted else (low, middle)
    return high


def rebound(ratio: float) -> float:
    """Ratio of the speeds after and before, for a damping ratio.

    The contact ends where the force is zero, before the spring is long again (Schwager and Pöschel 2007, equations 9, 13):
    ln e = -z/sqrt(1 - z^2) (pi - atan2(2 z sqrt(1 - z^2), 1 - 2 z^2)), for z > 1 -2 z/sqrt(z^2 - 1) arcosh(z).
    """
    if abs(ratio - 1.0) < 1e-9:
        return math.exp(-2.0)
    root = math.sqrt(abs(1.0 - ratio * ratio))
    if ratio > 1.0:
        return math.exp(-2.0 * ratio / root * math.acosh(ratio))
    return math.exp(-ratio / root * (math.pi - math.atan2(2.0 * ratio * root, 1.0 - 2.0 * ratio * ratio)))


def hertz_damping_ratio(restitution: float) -> float:
    """The number a of a damper a sqrt(m k) d^(1/4) d' beside F = k d^(3/2) that leaves this share of the speed.

    The same as for a spring but for the factor sqrt(5) in place of 2 (Antypov and Elliott 2011), the end of the contact where
    the force is zero included: in d^(5/4) and a time of its own the motion is that of the spring and its damper.
    """
    return math.sqrt(5.0) * damping_ratio(restitution)


def yielding_factor(speed: Any, yield_speed: float, exponent: float = 0.25) -> Floats:
    """Restitution over that of slow impacts, (yield_speed/v)^exponent above the ``yield_speed`` (m/s), 1 below.

    The exponent 1/4 follows where the whole contact has yielded (Johnson 1985, section 11.5). The formula of Thornton (1997)
    tends to 1.18 (v_y/v)^(1/4): the ``yield_speed`` that agrees with it at high speed is 1.97 of his v_y, :func:`first_yield`.
    """
    speed = np.asarray(speed, np.float64)
    return np.asarray((yield_speed / np.maximum(speed, yield_speed)) ** exponent, np.float64)


def first_yield(yield_stress: float, reduced_modulus: float, density: float) -> float:
    """Speed at which a ball that hits a flat wall begins to yield, m/s: 1.56 sqrt(Y^5/(E*^4 rho)) (Thornton 1997).

    ``yield_stress`` is the contact pressure at first yield (Pa), 1.6 times the yield strength in tension by von Mises;
    ``reduced_modulus`` E* (Pa), ``density`` of the ball (kg/m^3).
    """
    # kinetic energy m v^2/2 = 8/15 E* sqrt(R) d^(5/2) at the depth where the pressure 2 E* sqrt(d/R)/pi reaches Y
    root = 0.5 * math.pi * yield_stress / reduced_modulus  # sqrt(d/R)
    return float(math.sqrt(0.8 * reduced_modulus / (math.pi * density)) * root**2.5)


def stokes_number(speed: Any, mass: float, radius: float, viscosity: float) -> Any:
    """St = m v/(6 pi mu a^2) of bodies that approach at the ``speed`` v (m/s) in a fluid of the dynamic ``viscosity`` mu (Pa s).

    ``mass`` and ``radius`` are reduced: 1/m = 1/m_1 + 1/m_2, 1/a = 1/a_1 + 1/a_2; of a ball at a wall its own, which gives
    rho d v/(9 mu) (Davis et al. 1986; Joseph et al. 2001).
    """
    return mass * speed / (6.0 * math.pi * viscosity * radius**2)


def wet_factor(stokes: Any, critical: float) -> Floats:
    """Restitution in a fluid over the dry one at these ``stokes`` numbers, 1 - St_c/St; none below the ``critical`` one.

    From lubrication theory (Davis et al. 1986; Barnocky and Davis 1988). Measured: no rebound below St of about 10, that of a dry
    impact above 500 (Joseph et al. 2001; Gondret et al. 2002).
    """
    stokes = np.asarray(stokes, np.float64)
    return np.asarray(1.0 - critical / np.maximum(stokes, critical), np.float64)


def slowest_rebound(critical: float, mass: float, radius: float, viscosity: float) -> float:
    """The speed below which bodies in a fluid do not rebound, m/s: that of the ``critical`` Stokes number."""
    return critical / float(stokes_number(1.0, mass, radius, viscosity))

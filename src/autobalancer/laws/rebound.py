"""Restitution of a contact with a damper that never pulls."""

from __future__ import annotations

import math

from scipy.optimize import brentq

LEAST = 0.01  # restitution below which a contact would be too stiff


def damping_ratio(restitution: float) -> float:
    """Damping ratio of a spring and a damper that never pull, from the ratio of the speeds after and before.

    Below exp(-2) it is above one. A ratio under 1 % counts as 1 %, which takes a damping ratio of about five.
    """
    if restitution >= 1.0:
        return 0.0
    return float(brentq(lambda z: rebound(z) - max(restitution, LEAST), 0.0, 20.0, xtol=1e-14))


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

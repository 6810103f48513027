"""The law of a contact of a cylinder, along a line or over its end.

As between balls by Pakuła (2021): the whole elastic force in approach, R^2 of it in separation, friction that always slides, a
rolling moment; each jump at velocity zero is a slope that one step resolves. Friction of an end is that of a disc with even
pressure: mu F where it slides, 2/3 mu F r where it turns, and an ellipse between (Howe and Cutkosky 1996), so that force and
moment together take energy, whatever the motion.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from autobalancer.kernels.chamber.contact import SLIDING, TINY, TURNING, Vector
from autobalancer.kernels.chamber.vectors import dot, times
from autobalancer.kernels.flags import MERGED, njit

DISC = 2.0 / 3.0  # lever of friction under a disc that turns, over its radius
HEAVIER = 3.0  # lightness of a cylinder at its surface, over that of its middle
SPUN = 2.0  # mass times square of the radius, over the inertia of a cylinder


class Press(NamedTuple):
    """Normal force."""

    normal: float
    lost: float  # power
    held: float  # energy


class Side(NamedTuple):
    """Friction along a line."""

    across: float  # force
    along: float  # along the axis
    lost: float


class End(NamedTuple):
    """Friction of an end."""

    force: Vector
    moment: float  # about the axis
    lost: float


class Roll(NamedTuple):
    """Rolling resistance."""

    moment: float
    lost: float


@njit(**MERGED)
def pressed(run, contact, load, energy, approach, lightness):
    """Normal force where the elastic one is ``load`` and its springs hold ``energy``."""
    kept = contact.restitution_squared
    share = 0.5 + approach / (TURNING * run.step * load * lightness + TINY)
    normal = load * (kept + (1.0 - kept) * min(max(share, 0.0), 1.0))
    return Press(normal, (normal - kept * load) * approach, kept * energy)


@njit(**MERGED)
def _slope(run, slow, force, lightness):
    """Sliding speed below which friction is in proportion to it."""
    return max(slow, SLIDING * run.step * force * HEAVIER * lightness)


@njit(**MERGED)
def side_rubs(run, friction, slow, normal, across, along, lightness):
    """Friction on a cylinder that slides with these velocities at its line of contact."""
    square = across * across + along * along
    pull = friction * normal / max(sqrt(square), _slope(run, slow, friction * normal, lightness))
    return Side(-pull * across, -pull * along, pull * square)


@njit(**MERGED)
def end_rubs(run, friction, slow, normal, rate, spin, radius, lightness):
    """Friction on the end of a cylinder that slides with ``rate`` in its plane and turns with ``spin``."""
    lever = DISC * radius
    square = dot(rate, rate) + lever * lever * spin * spin
    pull = friction * normal / max(sqrt(square), _slope(run, slow, friction * normal, lightness))
    return End(times(-pull, rate), -pull * lever * lever * spin, pull * square)


@njit(**MERGED)
def rolls(run, contact, normal, spin, radius, lightness):
    """Rolling resistance against the relative ``spin``."""
    arm, inverse = contact.rolling_arm, 1.0 / radius
    least = max(contact.slow * inverse, SLIDING * run.step * arm * normal * SPUN * lightness * inverse * inverse)
    moment = arm * normal / max(abs(spin), least)
    return Roll(-moment * spin, moment * spin * spin)

"""What the balancers have to balance."""

from __future__ import annotations

from cmath import rect
from typing import Annotated

from pydantic import model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Angle, CoupleMoment, Length, Mass, Ratio, Time, UnbalanceMoment
from autobalancer.machine.station import Place


class Schedule(Part):
    """How an unbalance changes in time: a factor, piecewise linear over time and constant outside.

    Two equal times are a jump: blade loss at 5 s is ``time = [5, 5], factor = [0, 1]``.
    """

    time: Annotated[tuple[Time, ...], Listed] = key("must not decrease; the same time twice is a jump")
    factor: Annotated[tuple[Ratio, ...], Listed] = key(
        "multiplies the moment; as many as times, linear in between, constant outside"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Schedule:
        if not self.time:
            raise ValueError("time: given an empty list; give at least one time")
        if len(self.time) != len(self.factor):
            raise ValueError(
                f"given {len(self.time)} times and {len(self.factor)} factors; give the same number of both"
            )
        if any(b < a for a, b in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("time: must not decrease")
        if any(a == c for a, c in zip(self.time, self.time[2:], strict=False)):
            raise ValueError("time: the same time is given three times; a jump needs it twice")
        return self


LARGEST_TILT = 0.5  # rad; the equations are those of small tilts


class Unbalance(Part):
    """A point unbalance (its moment, or mass and radius) or a couple unbalance, at an angle in the rotor.

    A point unbalance sits at a ``station``: a position along the axis, or the name of one of the machine's stations;
    needless on a planar rotor, and for a couple on a rigid one. The mass belongs to the mass of the rotor; a change in
    time moves the moment only. ``couple`` is the product of inertia: two unbalances U a distance L apart and opposite
    are U L, at the angle of the one at greater z. A principal axis tilted by chi has (J_t - J_p) chi, and
    ``misalignment`` is that chi.
    """

    moment: UnbalanceMoment | None = key("mass times radius; instead of `mass` and `radius`", None, symbol="U")
    mass: Mass | None = key("a part of the mass of the rotor, not in addition to it", None)
    radius: Length | None = key("distance of this mass from the shaft", None)
    couple: CoupleMoment | None = key(
        "product of inertia in place of a point unbalance, at the angle of its part at greater $z$; not on a planar rotor",
        None,
    )
    misalignment: Angle | None = key(
        r"angle $\chi$ of the principal axis, a couple $(J_t - J_p) \chi$; on a rigid rotor only", None, symbol=r"\chi"
    )
    angle: Angle = key("in the rotor, from the zero mark", 0.0)
    station: Place | None = key(
        "where on the axis: a position, or the name of a station; not needed on a planar rotor", None
    )
    schedule: Schedule | None = key("how it changes in time; without one it is constant", None)

    @model_validator(mode="after")
    def _one_way(self) -> Unbalance:
        given = [self.moment, self.mass if self.mass is not None else self.radius, self.couple, self.misalignment]
        if sum(entry is not None for entry in given) != 1 or (self.mass is None) != (self.radius is None):
            raise ValueError("give either 'moment', or 'mass' and 'radius', or 'couple', or 'misalignment'")
        if self.misalignment is not None and abs(self.misalignment) > LARGEST_TILT:
            raise ValueError(
                f"misalignment: given {self.misalignment:g} rad; must be at most {LARGEST_TILT} rad, a small angle"
            )
        return self

    @property
    def is_couple(self) -> bool:
        """Whether it is a pure couple."""
        return self.couple is not None or self.misalignment is not None

    @property
    def size(self) -> float:
        """The moment m0 eps0 at factor one, kg m; 0 of a couple."""
        return float(self.moment) if self.moment is not None else float(self.mass or 0.0) * float(self.radius or 0.0)

    @property
    def vector(self) -> complex:
        """The moment at factor one as a vector in the rotor, m0 eps0 e^(i alpha), kg m; 0 of a couple."""
        return rect(self.size, self.angle)

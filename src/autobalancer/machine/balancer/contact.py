"""What happens where a ball meets another ball, a partition, or its race."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Angle, Position, Quantity, Ratio
from autobalancer.machine.rebound import Rebound

ContactStiffness = Annotated[float, Quantity("N/m", positive=True)]
SlipSpeed = Annotated[float, Quantity("m/s", positive=True)]


class Contact(Part):
    """Balls of one race that meet rebound with the ratio ``restitution`` of their speeds; they keep their order.

    Contact is rigid: an impact takes no time, and balls that press on each other move as one. With a ``stiffness`` along the
    race a spring and a damper that never pull act between them, and no rebound counts as 1 %; so they do with a friction of 0.9
    or more, where a contact lasts about a twentieth of a turn.

    ``friction`` acts between rolling balls that press on each other, full where they slip much faster than ``slip_speed``
    (Spannan 2021, 5.6). Without it that is a thousandth of the speed of the wall at the greatest speed of the machine.
    """

    restitution: Ratio = key("speed after over speed before, 0 to 1; with a stiffness 0 is replaced by 1 %")
    rebound: Rebound | None = key(
        "how restitution falls with the speed of impacts and in a fluid; without it it is constant", None
    )
    stiffness: ContactStiffness | None = key("along the race; without it contact is rigid", None)
    friction: Ratio = key("coefficient between rolling balls in contact; for resolved balls use `ball_friction`", 0.0)
    slip_speed: SlipSpeed | None = key(
        "friction is fully developed at much faster slip; by default a thousandth of the speed of the wall", None
    )

    @model_validator(mode="after")
    def _possible(self) -> Contact:
        if self.restitution > 1.0:
            raise ValueError(f"restitution: given {self.restitution:g}; must be between 0 and 1")
        if self.slip_speed is not None and self.friction == 0.0:
            raise ValueError(
                "slip_speed: has no effect without friction between the balls; give 'friction' or leave it out"
            )
        return self


class Friction(Part):
    """Dry friction between ball and race.

    ``rolling_resistance`` is the arm of the wall force over the ball radius, a/r_b (Spannan 2021, 5.8-5.14): it acts against
    the motion along the race with the torque (a/r_b) F_N eps. ``adherence``: a ball at rest on its race stays there while
    less than ``adherence`` F_N is needed to hold it. Of a pendulum both are coefficients of its bearing, which rubs at the
    ``bearing_radius`` r_B: (adherence F_N r_B) holds it.
    """

    rolling_resistance: Ratio = key(
        "$a/r_b$, lever arm of the wall force over the ball radius; of a pendulum the friction coefficient of its "
        "bearing",
        0.0,
        symbol=r"\mu",
    )
    adherence: Ratio | None = key(
        "greatest force that holds a ball at rest, over the wall force; by default the rolling resistance", None
    )

    @model_validator(mode="after")
    def _possible(self) -> Friction:
        if self.rolling_resistance >= 1.0:
            raise ValueError(
                f"rolling_resistance: given {self.rolling_resistance:g}; it is a lever arm over the ball radius, far below 1"
            )
        if self.adherence is not None and self.adherence < self.rolling_resistance:
            raise ValueError(
                f"adherence: given {self.adherence:g}; must not be less than the rolling resistance, "
                f"{self.rolling_resistance:g}"
            )
        return self

    @property
    def holding(self) -> float:
        """The coefficient of adherence; that of rolling resistance if none is given."""
        return float(self.rolling_resistance if self.adherence is None else self.adherence)


class Harmonic(Part):
    """One wave of a race's radius: ``amplitude`` cos(order (phi - angle)), phi counted in the rotor."""

    order: int = key("waves around the race: 1 shifts it, 2 is an oval; up to 60")
    amplitude: Position = key("of the orbit radius")
    angle: Angle = key("of a crest, in the rotor", 0.0)

    @model_validator(mode="after")
    def _possible(self) -> Harmonic:
        if not 1 <= self.order <= 60:
            raise ValueError(f"order: given {self.order}; must be between 1 and 60 (2 is an oval)")
        return self


class Roundness(Part):
    """A measured profile: deviations of the radius at equal steps of the angle over one turn, from ``angle`` on."""

    deviations: Annotated[tuple[Position, ...], Listed] = key(
        "of the radius, at least 8 at equal steps over one turn; the first is not repeated"
    )
    angle: Angle = key("of the first deviation, in the rotor", 0.0)
    harmonics: int = key("number of waves that are kept; 1 to 60, and fewer than half the points", 12)

    @model_validator(mode="after")
    def _closed(self) -> Roundness:
        count = len(self.deviations)
        if count < 8:
            raise ValueError(f"deviations: given {count}; give at least 8 over the turn, without repeating the first")
        if not 1 <= self.harmonics <= min(60, (count - 1) // 2):
            raise ValueError(
                f"harmonics: given {self.harmonics}; {count} points carry 1 to {min(60, (count - 1) // 2)}"
            )
        steps = [abs(b - a) for a, b in zip(self.deviations, self.deviations[1:], strict=False)]
        gap = abs(self.deviations[0] - self.deviations[-1])
        if gap > 5.0 * max(max(steps), 1e-12):
            raise ValueError(
                f"deviations: the profile is not closed: it jumps by {gap:g} m from its last point to its first, "
                f"but by {max(steps):g} m at most elsewhere; give a whole turn"
            )
        return self


class Partitions(Part):
    """Thin walls across the race that divide it into ``count`` equal parts; the first wall stands at ``angle``."""

    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = key("equal parts")
    angle: Angle = key("of the first wall, in the rotor", 0.0)

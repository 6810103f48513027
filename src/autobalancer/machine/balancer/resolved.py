"""Balls that are followed in the plane of their race, with a spin, in place of being guided along it."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Angle, Listed, Offset, Part, Position, Quantity, Ratio, key
from autobalancer.machine.plugins import Leaf, OneOf
from autobalancer.machine.rebound import Rebound

# What happens where a ball meets another ball, a partition, or its race.


ContactStiffness = Annotated[float, Quantity("N/m", positive=True)]
Restitution = Annotated[float, Quantity("", non_negative=True, most=1.0)]
SlipSpeed = Annotated[float, Quantity("m/s", positive=True)]


class Contact(Part):
    """Balls of one race that meet rebound with the ratio ``restitution`` of their speeds; they keep their order.

    Contact is rigid (Moreau 1988; Júdice and Pires 1994): an impact takes no time, and balls that press on each other move as
    one. With a ``stiffness`` along the race a spring and a damper that never pull act between them, and no rebound counts as
    1 %; so they do with a friction of 0.9 or more, where a contact lasts about a twentieth of a turn.

    ``friction`` acts between rolling balls that press on each other, full where they slip much faster than ``slip_speed``
    (Spannan 2021, 5.6). Without it that is a thousandth of the speed of the wall at the greatest speed of the machine.
    """

    restitution: Restitution = key("speed after over speed before; with a stiffness 0 is replaced by 1 %")
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
        if self.slip_speed is not None and self.friction == 0.0:
            raise ValueError(
                "slip_speed: has no effect without friction between the balls; give 'friction' or leave it out"
            )
        return self


# How a race brakes a ball: what a friction law is.


class FrictionLaw(Leaf):
    """The coefficient of friction of a ball over its velocity: of a resolved one by its slip on the walls, of a guided one, which
    rolls, along its race; its rolling resistance stands for sliding friction then, and it does not know what presses.

    A leaf of this family is one class with this static method, which is compiled when it is first used; ``at`` is the slip
    (fields of ``SLIP`` in kernels/records.py), ``own`` has the keys of the leaf that are numbers.

    ``coefficient(at, own) -> float``
        Friction over the force of the wall, with the sign of the slip ``at.slip``, which it opposes; zero without slip,
        and smooth.
    """

    family: ClassVar[str] = "friction"
    one: ClassVar[str] = "friction law"
    current: ClassVar[int] = 1

    def unfit(self, sliding: float) -> str:
        """What is wrong with it beside this coefficient of sliding friction or rolling; empty if nothing is."""
        return ""


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
    rolling_law: Annotated[FrictionLaw, OneOf(FrictionLaw)] | None = key(
        "how the rolling resistance of guided balls depends on their velocity along the race; without it not at all",
        None,
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
        if self.rolling_law is not None and self.rolling_resistance == 0.0:
            raise ValueError("rolling_law: changes the 'rolling_resistance'; give that, or leave it out")
        if self.rolling_law is not None and (wrong := self.rolling_law.unfit(self.rolling_resistance)):
            raise ValueError(f"rolling_law.{wrong}")
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


Modulus = Annotated[float, Quantity("Pa", positive=True)]
ContactDamping = Annotated[float, Quantity("N*s/m", non_negative=True)]


class ResolvedContact(Part):
    """Contact of a ball with the walls of its race (Spannan 2021, section 5.1).

    ``stiffness``: linear spring (5.3); or ``reduced_modulus``: Hertz (Tsuji et al. 1992), F = k d^(3/2), the modulus of both
    bodies together, 1/E* = sum (1 - nu^2)/E. ``restitution``: speeds after and before a head-on bounce, less than 0.01 counts
    as that; or ``damping`` of the linear damper.

    ``sliding_friction`` mu, full where the contact slips much faster than ``slip_speed`` (5.6), by the ``friction_law``
    ``coulomb`` unless another one is given, such as ``stribeck`` with more friction at the onset of sliding (5.7). The race's
    ``friction`` brings rolling resistance and adherence; ``rest_speed`` is the speed below which a ball counts as at rest, and
    ``adherence_stiffness`` that of the spring that holds it, by default the 1 N/mm of Spannan (2021), section 5.1.3.

    ``floor_friction``: of the floor of the annulus under a ball that the wall does not carry, on a vertical axis. It rolls there
    where this suffices; with the ``floor_motion`` *sliding* it does not turn, as in the source.
    ``ball_friction``: between balls that meet, and at partitions. ``start_gap``: distance from the wall at the start.
    """

    stiffness: ContactStiffness | None = key("linear spring of wall and ball; this or `reduced_modulus`", None)
    reduced_modulus: Modulus | None = key(
        r"Hertz: $1/E^* = \sum (1 - \nu^2)/E$ of both bodies; this or `stiffness`", None
    )
    restitution: Restitution | None = key("speed after over speed before a head-on bounce; this or `damping`", None)
    rebound: Rebound | None = key(
        "how restitution falls with the speed of impacts and in a fluid; without it it is constant", None
    )
    damping: ContactDamping | None = key("of a linear damper beside the linear spring; this or `restitution`", None)
    sliding_friction: Ratio = key("coefficient of friction of wall and ball")
    slip_speed: SlipSpeed = key("friction is fully developed at much faster slip")
    friction_law: Annotated[FrictionLaw, OneOf(FrictionLaw)] | None = key(
        "how friction of wall and ball depends on the slip; without it `coulomb`", None
    )
    rest_speed: SlipSpeed | None = key(
        "slower balls count as at rest; required by rolling resistance and adherence", None
    )
    adherence_stiffness: ContactStiffness = key("of the spring that holds a ball at rest", 1000.0)
    floor_friction: Ratio = key("under a ball that is not carried by the wall, on a vertical axis", 0.0)
    floor_motion: Literal["rolling", "sliding"] = key(
        "whether floor friction also turns the ball, so that it rolls where this suffices", "rolling"
    )
    ball_friction: Ratio = key("between balls that meet, and at partitions", 0.0)
    start_gap: Offset = key("of each ball from the wall at time zero", 0.0)

    @model_validator(mode="after")
    def _one_law(self) -> ResolvedContact:
        if (self.stiffness is None) == (self.reduced_modulus is None):
            raise ValueError("give either 'stiffness' (linear spring) or 'reduced_modulus' (Hertz)")
        if (self.restitution is None) == (self.damping is None):
            raise ValueError("give either 'restitution' or 'damping'")
        if self.damping is not None and self.stiffness is None:
            raise ValueError("damping: requires the linear 'stiffness'; with 'reduced_modulus' give 'restitution'")
        if self.rebound is not None and self.restitution is None:
            raise ValueError("rebound: changes the 'restitution' of the walls; give that in place of 'damping'")
        return self

    @model_validator(mode="after")
    def _one_friction(self) -> ResolvedContact:
        if self.friction_law is not None and (wrong := self.friction_law.unfit(self.sliding_friction)):
            raise ValueError(f"friction_law.{wrong}")
        return self

"""Balls that are followed in the plane of their race, with a spin, in place of being guided along it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from autobalancer.machine.balancer.contact import ContactStiffness, SlipSpeed
from autobalancer.machine.balancer.friction_law import FrictionLaw
from autobalancer.machine.leaves import OneOf
from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Offset, Quantity, Ratio
from autobalancer.machine.rebound import Rebound

Modulus = Annotated[float, Quantity("Pa", positive=True)]
ContactDamping = Annotated[float, Quantity("N*s/m", non_negative=True)]


class ResolvedContact(Part):
    """Contact of a ball with the walls of its race (Spannan 2021, section 5.1).

    ``stiffness``: linear spring (5.3); or ``reduced_modulus``: Hertz, F = k d^(3/2), the modulus of both bodies together,
    1/E* = sum (1 - nu^2)/E. ``restitution``: speeds after and before a head-on bounce, less than 0.01 counts as that;
    or ``damping`` of the linear damper.

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
    restitution: Ratio | None = key("speed after over speed before a head-on bounce; this or `damping`", None)
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
        if self.restitution is not None and self.restitution > 1.0:
            raise ValueError(f"restitution: given {self.restitution:g}; must be between 0 and 1")
        return self

    @model_validator(mode="after")
    def _one_friction(self) -> ResolvedContact:
        if self.friction_law is not None and (wrong := self.friction_law.unfit(self.sliding_friction)):
            raise ValueError(f"friction_law.{wrong}")
        return self

"""How balls touch each other and the walls."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Offset, Positive, Quantity, Ratio
from autobalancer.machine.rebound import Rebound

Fraction = Annotated[float, Quantity("", positive=True, most=1.0)]
Coefficient = Annotated[float, Quantity("", non_negative=True, most=5.0)]
Modulus = Annotated[float, Quantity("Pa", positive=True)]
HertzStiffness = Annotated[float, Quantity("N/m^1.5", positive=True)]
SlipSpeed = Annotated[float, Quantity("m/s", positive=True)]


class _Elastic(Part):
    """Stiffness k of F = k d^1.5: one for all contacts, or by Hertz from the material of balls and walls."""

    stiffness: HertzStiffness | None = key("$k$ in $k d^{3/2}$ of all contacts; this or `youngs_modulus`", None)
    youngs_modulus: Modulus | None = key(
        "of balls and walls: stiffness by Hertz for each pair; this or `stiffness`", None
    )
    poisson_ratio: Ratio = key("of balls and walls, at most 0.5; only with `youngs_modulus`", 0.3)
    restitution: Fraction = key("speed after over speed before")
    rebound: Rebound | None = key(
        "how restitution falls with the speed of impacts and in a fluid; without it it is constant", None
    )
    friction: Coefficient = key("coefficient of sliding friction, of all contacts unless `ball_friction` is given")
    ball_friction: Coefficient | None = key("the same of balls on balls; by default that of the walls", None)
    rolling_arm: Offset = key("$f$: rolling resistance is a moment $f F$ against the relative spin", 0.0)
    slip_speed: SlipSpeed = key("sliding speed below which friction falls to zero in proportion", 1e-3)

    @model_validator(mode="after")
    def _one_stiffness(self) -> _Elastic:
        if (self.stiffness is None) == (self.youngs_modulus is None):
            raise ValueError("give either 'stiffness' (of all contacts) or 'youngs_modulus'")
        if self.poisson_ratio > 0.5:
            raise ValueError(f"poisson_ratio: given {self.poisson_ratio:g}; must be at most 0.5")
        return self


class RestitutionContact(_Elastic):
    """Pakuła (2021): k d^1.5 in approach, R^2 k d^1.5 in separation, R that of the impact; sliding friction at all times.

    ``slip_speed`` is the sliding speed below which friction falls to zero in proportion.
    """

    law: Literal["restitution"] = "restitution"


class HistoryContact(_Elastic):
    """Hertz with viscous damping and a tangential spring that remembers, so that balls can stick.

    ``shear_ratio`` is the tangential over the normal stiffness; by default that of Mindlin, 2 (1 - nu)/(2 - nu).
    """

    law: Literal["history"] = "history"
    shear_ratio: Positive | None = key(
        r"tangential over normal stiffness; without it that of Mindlin, $2(1-\nu)/(2-\nu)$", None
    )


ChamberContact = Annotated[RestitutionContact | HistoryContact, Field(discriminator="law")]

"""How the restitution of a contact depends on the speed of an impact and on the fluid between the bodies."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

from pydantic import model_validator

from autobalancer.errors import MachineError
from autobalancer.machine.part import Listed, Part, Positive, Quantity, key

ImpactSpeed = Annotated[float, Quantity("m/s", positive=True)]
Share = Annotated[float, Quantity("", positive=True, most=1.0)]
Exponent = Annotated[float, Quantity("", positive=True, most=0.9)]


class Rebound(Part):
    """What impacts leave of their speed, over the ``restitution`` of the contact, which is that of slow and dry ones.

    Dry: above ``yield_speed`` restitution falls as (yield_speed/v)^exponent (Johnson 1985, section 11.5); or a table of
    ``factors`` at ``speeds``, between them linear, beyond them constant.

    In a fluid: 1 - St_c/St of the dry restitution is left, and nothing below the ``critical_stokes`` number St_c (Barnocky and
    Davis 1988), measured as about 10 (Joseph et al. 2001). St = m v/(6 pi mu a^2) with reduced mass and radius, of a ball at a
    wall rho d v/(9 mu); mu is the viscosity of the fluid in the race or chamber.
    """

    yield_speed: ImpactSpeed | None = key(
        "impact speed above which restitution falls, as the material yields; this or a table", None
    )
    exponent: Exponent = key("of this fall; 1/4 where the whole contact has yielded", 0.25)
    speeds: Annotated[tuple[ImpactSpeed, ...], Listed] = key("impact speeds of the table, ascending", ())
    factors: Annotated[tuple[Share, ...], Listed] = key("restitution at these speeds over that of slow impacts", ())
    critical_stokes: Positive | None = key(
        "Stokes number of an impact below which balls in a fluid do not rebound, about 10; without it the fluid has no effect",
        None,
    )

    @model_validator(mode="after")
    def _one_way(self) -> Rebound:
        if self.yield_speed is not None and (self.speeds or self.factors):
            raise ValueError("give either 'yield_speed' or a table of 'speeds' and 'factors', not both")
        if self.yield_speed is None and not self.factors and not self.speeds and self.critical_stokes is None:
            raise ValueError("says nothing; give 'yield_speed', 'speeds' and 'factors', or 'critical_stokes'")
        if self.yield_speed is None and "exponent" in self.model_fields_set:
            raise ValueError("exponent: has no effect without 'yield_speed'; give that too, or leave it out")
        return self

    @model_validator(mode="after")
    def _table(self) -> Rebound:
        if len(self.speeds) != len(self.factors):
            raise ValueError(
                f"factors: given {len(self.factors)} for {len(self.speeds)} speeds; give one factor for each speed"
            )
        for i, (one, other) in enumerate(pairwise(self.speeds)):
            if other <= one:
                message = f"given {other:g} m/s after {one:g} m/s; the speeds of the table must ascend"
                raise MachineError.of("Rebound", [(("speeds", i + 1), message)])
        left = [v * f for v, f in zip(self.speeds, self.factors, strict=True)]
        for i, (one, other) in enumerate(pairwise(left)):
            if other <= one:
                here, before = (f"{self.factors[k]:g} at {self.speeds[k]:g} m/s" for k in (i + 1, i))
                least = one / self.speeds[i + 1]
                message = (
                    f"given {here} after {before}; a faster impact must leave more speed, so it must be more than "
                    f"{least:.4g}"
                )
                raise MachineError.of("Rebound", [(("factors", i + 1), message)])
        return self

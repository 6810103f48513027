"""A bearing that becomes stiffer as it deflects: a cubic spring, a clearance with a stop behind it, or a law of your own."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

from pydantic import model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Offset, Position, Quantity, SpringRate

CubicStiffness = Annotated[float, Quantity("N/m^3", non_negative=True)]
Offsets = Annotated[tuple[Offset, ...], Listed]
Forces = Annotated[tuple[Annotated[float, Quantity("N", non_negative=True)], ...], Listed]


class Hardening(Part):
    """A central force beside the linear spring of a bearing, for runs.

    At the distance r from the middle of the bearing ``cubic_stiffness`` pulls with k r³ towards it; a stop with
    ``contact_stiffness`` k does so with k (r - ``clearance``) where r exceeds the clearance. ``force`` over ``distance``
    is any other law, measured or computed; between its points it is a monotone cubic. It has no loss of its own.
    Theories of small motions take the stiffness that it has where the rotor rests, and say so.
    """

    cubic_stiffness: CubicStiffness = key("force over the third power of the distance", 0.0)
    clearance: Offset | None = key("free way in every direction, before the stop is reached", None)
    contact_stiffness: SpringRate | None = key("of the stop; needed with a `clearance`", None)
    distance: Offsets | None = key("from the middle, of a law of your own; must increase", None)
    force: Forces | None = key("towards the middle at each `distance`; must not fall", None)
    center: tuple[Position, Position] = key(
        "x and y of the middle of the bearing, from where the rotor rests", (0.0, 0.0)
    )

    @model_validator(mode="after")
    def _there(self) -> Hardening:
        if (self.clearance is None) != (self.contact_stiffness is None):
            lacking = "clearance" if self.clearance is None else "contact_stiffness"
            raise ValueError(f"{lacking}: missing; a stop needs 'clearance' and 'contact_stiffness'")
        if self.distance is None and self.force is None and self.clearance is None and self.cubic_stiffness == 0.0:
            others = "a 'clearance' with its 'contact_stiffness', or a 'force' over 'distance'"
            raise ValueError(f"cubic_stiffness: missing; give it, {others}")
        self._refuse_odd_table()
        return self

    def _refuse_odd_table(self) -> None:
        if (self.distance is None) != (self.force is None):
            lacking = "distance" if self.distance is None else "force"
            raise ValueError(f"{lacking}: missing; a law of your own needs 'distance' and 'force'")
        if self.distance is None or self.force is None:
            return
        if len(self.distance) != len(self.force):
            raise ValueError(
                f"force: given {len(self.force)} values for {len(self.distance)} distances; give one for each"
            )
        if len(self.force) < 2:
            raise ValueError("distance: give at least two; for one stiffness use that of the spring beside it")
        for name, values, equal in (("distance", self.distance, False), ("force", self.force, True)):
            for number, (one, other) in enumerate(pairwise(values), 2):
                if other < one or (other == one and not equal):
                    must = "must not fall" if equal else "must increase"
                    raise ValueError(f"{name}: entry {number} is {other:.6g} after {one:.6g}; the values {must}")
        if self.distance[0] == 0.0 and self.force[0] != 0.0:
            raise ValueError(f"force: given {self.force[0]:.6g} N at distance 0; it must be 0 there")

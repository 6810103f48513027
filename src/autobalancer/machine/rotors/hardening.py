"""A bearing that becomes stiffer as it deflects: a cubic spring, or a clearance with a stop behind it."""

from __future__ import annotations

from typing import Annotated

from pydantic import model_validator

from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Offset, Position, Quantity, SpringRate

CubicStiffness = Annotated[float, Quantity("N/m^3", non_negative=True)]


class Hardening(Part):
    """A central force beside the linear spring of a bearing, for runs.

    At the distance r from the middle of the bearing ``cubic_stiffness`` pulls with k r³ towards it; a stop with
    ``contact_stiffness`` k does so with k (r - ``clearance``) where r exceeds the clearance. It has no loss of its own.
    Theories of small motions leave it out, and say so.
    """

    cubic_stiffness: CubicStiffness = key("force over the third power of the distance", 0.0)
    clearance: Offset | None = key("free way in every direction, before the stop is reached", None)
    contact_stiffness: SpringRate | None = key("of the stop; needed with a `clearance`", None)
    center: tuple[Position, Position] = key(
        "x and y of the middle of the bearing, from where the rotor rests", (0.0, 0.0)
    )

    @model_validator(mode="after")
    def _there(self) -> Hardening:
        if (self.clearance is None) != (self.contact_stiffness is None):
            lacking = "clearance" if self.clearance is None else "contact_stiffness"
            raise ValueError(f"{lacking}: missing; a stop needs 'clearance' and 'contact_stiffness'")
        if self.clearance is None and self.cubic_stiffness == 0.0:
            raise ValueError("cubic_stiffness: missing; give it, or a 'clearance' with its 'contact_stiffness'")
        return self

"""A rigid body fixed to a shaft."""

from __future__ import annotations

from typing import Annotated

from pydantic import model_validator

from autobalancer.machine.part import Label, Part, key
from autobalancer.machine.quantity import Mass, Position, Quantity

OwnInertia = Annotated[float, Quantity("kg*m^2", non_negative=True)]


class Disk(Part):
    """A rigid body fixed to the shaft at ``position``; inertias about its mass center, 0 of a point mass.

    ``offset`` is the distance of its mass center from there along the axis, positive towards the right end, carried by
    a rigid arm. ``extent`` is how far the body reaches from there, as a pair (from, to); places on it that lie beyond the
    ends of the shaft, or that name it as their ``body``, move with it.
    """

    name: Label = key("for stations that name it as their body", "")
    position: Position = key("where it is fixed to the shaft, from the left end")
    mass: Mass = key("without balls", symbol="m")
    transverse_inertia: OwnInertia = key("about a diameter through its mass center", symbol="J_t")
    polar_inertia: OwnInertia = key("about the axis", symbol="J_p")
    offset: Position = key("from its position to its mass center, positive towards the right end", 0.0)
    extent: tuple[Position, Position] = key("how far the body reaches from its position, from and to", (0.0, 0.0))

    @model_validator(mode="after")
    def _possible(self) -> Disk:
        if self.polar_inertia > 2.0 * self.transverse_inertia * (1.0 + 1e-9):
            raise ValueError(
                f"polar_inertia: given {self.polar_inertia:g} kg m^2; no body has more than twice its transverse inertia, "
                f"{2.0 * self.transverse_inertia:g} kg m^2 here"
            )
        if self.extent[0] > self.extent[1]:
            raise ValueError(f"extent: given {self.extent[0]:g} m to {self.extent[1]:g} m; the smaller one comes first")
        return self

    @property
    def reach(self) -> tuple[float, float]:
        """Positions along the shaft's axis from where to where the body is, m."""
        arm = (0.0, float(self.offset), float(self.extent[0]), float(self.extent[1]))
        return float(self.position) + min(arm), float(self.position) + max(arm)

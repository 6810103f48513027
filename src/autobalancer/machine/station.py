"""Places along the axis of a rotor."""

from __future__ import annotations

from typing import Annotated, Any

from autobalancer.machine.part import Name, Part, Position, Quantity, key


class PlaceQuantity(Quantity):
    """A position along the axis, or the name of a station."""

    def one(self, value: Any) -> Any:
        """The position, m, or the name as it is."""
        if isinstance(value, str) and value.strip()[:1] not in set("+-.0123456789"):
            if not value.strip():
                raise ValueError("given an empty text; give a position along the axis, or the name of a station")
            return value
        return super().one(value)

    @property
    def words(self) -> str:
        """What may be given."""
        return "m, or the name of a station"


Place = Annotated[float | str, PlaceQuantity("m")]


class Station(Part):
    """A named plane across the rotor, to put balancers and unbalances in and to look at.

    ``position`` is along the axis: from the mass center of a rigid rotor, from the left (or upper) end of a shaft, from
    the origin of a rig. In a rig with several bodies ``body`` says which one.
    """

    name: Name = key("given once; balancers, unbalances, forces and results refer to it")
    position: Position = key(
        "along the axis, from the mass center of a rigid rotor, the left end of a shaft, the origin of a rig"
    )
    body: str | None = key("name of a body of a rig or of a disk on a shaft, if the position alone is ambiguous", None)

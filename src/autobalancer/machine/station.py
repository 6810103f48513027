"""Places along the axis of a rotor."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import PlainValidator

from autobalancer.machine.part import Name, Part, Position, quantity

_position = quantity("m").func


def _place(value: Any) -> float | str:
    if isinstance(value, str) and value.strip()[:1] not in set("+-.0123456789"):
        if not value.strip():
            raise ValueError("given an empty text; give a position along the axis, or the name of a station")
        return value
    position: float = _position(value)  # type: ignore[call-arg]
    return position


Place = Annotated[float | str, PlainValidator(_place)]


class Station(Part):
    """A named plane across the rotor, to put balancers and unbalances in and to look at.

    ``position`` is along the axis: from the mass center of a rigid rotor, from the left (or upper) end of a shaft, from
    the origin of a rig. In a rig with several bodies ``body`` says which one.
    """

    name: Name
    position: Position
    body: str | None = None

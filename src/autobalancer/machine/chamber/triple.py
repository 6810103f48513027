"""Quantities along the three axes: x along the rotor, y and z across it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import PlainValidator

from autobalancer.machine.part import quantity


def triple(unit: str, *, positive: bool = False, non_negative: bool = False) -> PlainValidator:
    """Validator of three quantities in ``unit``, along x, y and z."""
    single = quantity(unit, positive=positive, non_negative=non_negative).func

    def read(value: Any) -> Any:
        if not isinstance(value, (list, tuple)) or len(value) != 3:
            given = f"{len(value)} values" if isinstance(value, (list, tuple)) else repr(value)
            raise ValueError(f"given {given}; give three, along x (the rotor), y and z")
        return tuple(single(entry) for entry in value)  # type: ignore[call-arg]

    return PlainValidator(read)


Triple = tuple[float, float, float]
Place3 = Annotated[Triple, triple("m")]
Stiffness3 = Annotated[Triple, triple("N/m", non_negative=True)]
Damping3 = Annotated[Triple, triple("N*s/m", non_negative=True)]
Inertia3 = Annotated[Triple, triple("kg*m^2", positive=True)]
Acceleration3 = Annotated[Triple, triple("m/s^2")]

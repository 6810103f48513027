"""A quantity that a key of a machine holds: its unit, its bounds, and how it is read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from autobalancer.units import shortened, to_si

Shape = Literal["one", "one or a pair", "three"]


@dataclass(frozen=True, repr=False)
class Quantity:
    """Reads a number in the SI ``unit``, or a text with a unit, and refuses what is out of bounds.

    ``most`` is the greatest value allowed. ``shape`` says how many numbers there are: one, one or a pair along x and y,
    or three along x, y and z. Stands in ``Annotated[float, Quantity("kg", positive=True)]``.
    """

    unit: str
    positive: bool = False
    non_negative: bool = False
    most: float = math.inf
    shape: Shape = "one"

    def __call__(self, value: Any) -> Any:
        """One number, or a tuple of numbers, in SI."""
        if self.shape == "three":
            if not isinstance(value, (list, tuple)) or len(value) != 3:
                given = f"{len(value)} values" if isinstance(value, (list, tuple)) else repr(value)
                raise ValueError(f"given {given}; give three, along x (the rotor), y and z")
        elif self.shape == "one" or not isinstance(value, (list, tuple)):
            return self.one(value)
        elif len(value) != 2:
            raise ValueError(f"given {len(value)} values; give one, or two (along x and y)")
        return tuple(self.one(entry) for entry in value)

    def one(self, value: Any) -> Any:
        """A single number in SI."""
        number = to_si(value, self.unit)
        if math.isfinite(self.most) and not (self._within(number) and number <= self.most):
            low = "greater than 0 and at most" if self.positive else "between 0 and"
            raise ValueError(f"given {number:g}; must be {low} {self.most:g}")
        if self.positive and not number > 0.0:
            raise ValueError(f"given {shortened(value)}; must be greater than zero")
        if not self._within(number):
            raise ValueError(f"given {shortened(value)}; must not be negative")
        wrong = plausible(number, self.unit, self.positive)
        if wrong:
            raise ValueError(f"given {shortened(value)}; {wrong}")
        return number

    def _within(self, number: float) -> bool:
        return number > 0.0 if self.positive else number >= 0.0 if self.non_negative else True

    def __repr__(self) -> str:
        return f"Quantity({self.words!r})"

    @property
    def words(self) -> str:
        """Unit and bounds, such as ``kg, > 0``."""
        unit = self.unit.replace("*", " ").replace("^2", "²").replace("^3", "³") or "number"
        low = ", > 0" if self.positive else ", ≥ 0" if self.non_negative else ""
        high = f", ≤ {self.most:g}" if math.isfinite(self.most) else ""
        single = f"{unit}{low}{high}"
        return {
            "one": single,
            "one or a pair": f"{single}; one, or a pair along x and y",
            "three": f"three of {single}",
        }[self.shape]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        number: dict[str, Any] = {"type": "number"}
        if self.positive:
            number["exclusiveMinimum"] = 0
        elif self.non_negative:
            number["minimum"] = 0
        if math.isfinite(self.most):
            number["maximum"] = self.most
        single: dict[str, Any] = {"anyOf": [number, {"type": "string"}], "unit": self.unit}
        count = {"one": 0, "one or a pair": 2, "three": 3}[self.shape]
        several = {"type": "array", "items": single, "minItems": count, "maxItems": count}
        return {"one": single, "one or a pair": {"anyOf": [single, several]}, "three": several}[self.shape]


Mass = Annotated[float, Quantity("kg", positive=True)]
Length = Annotated[float, Quantity("m", positive=True)]
Offset = Annotated[float, Quantity("m", non_negative=True)]
Position = Annotated[float, Quantity("m")]
Angle = Annotated[float, Quantity("rad")]
Speed = Annotated[float, Quantity("rad/s")]
Acceleration = Annotated[float, Quantity("rad/s^2", positive=True)]
Velocity = Annotated[float, Quantity("m/s")]
Time = Annotated[float, Quantity("s", non_negative=True)]
Duration = Annotated[float, Quantity("s", positive=True)]
Stiffness = Annotated[float | tuple[float, float], Quantity("N/m", positive=True, shape="one or a pair")]
ForceSize = Annotated[float, Quantity("N", positive=True)]
Rate = Annotated[float, Quantity("rad/s", positive=True)]
ShearRate = Annotated[float, Quantity("1/s", positive=True)]
MagneticMoment = Annotated[float, Quantity("A*m^2", positive=True)]
SpringRate = Annotated[float, Quantity("N/m", positive=True)]
Damping = Annotated[float | tuple[float, float], Quantity("N*s/m", non_negative=True, shape="one or a pair")]
Torque = Annotated[float, Quantity("N*m")]
AngularDamping = Annotated[float, Quantity("N*m*s", non_negative=True)]
UnbalanceMoment = Annotated[float, Quantity("kg*m", non_negative=True)]
Inertia = Annotated[float, Quantity("kg*m^2", positive=True)]
MassInertia = Annotated[float, Quantity("kg*m^2", non_negative=True)]
CoupleMoment = Annotated[float, Quantity("kg*m^2", non_negative=True)]
Density = Annotated[float, Quantity("kg/m^3", positive=True)]
Viscosity = Annotated[float, Quantity("m^2/s", positive=True)]
Temperature = Annotated[float, Quantity("K", positive=True)]
Gravity = Annotated[float, Quantity("m/s^2", non_negative=True)]
Ratio = Annotated[float, Quantity("", non_negative=True)]
Positive = Annotated[float, Quantity("", positive=True)]


# How large and how small a quantity of a machine can be: bounds that no machine comes near.
#
# Beyond them a value is a slip, and numbers made of it leave the range in which a computer works.


SMALLEST = 1e-30  # of what must be greater than zero, in SI
LARGEST = 1e30
BOUNDS = {  # SI unit: smallest of what must be greater than zero, largest
    "kg": (1e-18, 1e15),
    "m": (1e-9, 1e6),
    "rad": (SMALLEST, 1e6),
    "rad/s": (SMALLEST, 1e9),
    "s": (1e-15, 1e12),
    "m/s": (SMALLEST, 1e9),
    "m/s^2": (SMALLEST, 1e12),
    "kg/m^3": (1e-18, 1e9),
    "m^2/s": (1e-15, 1e9),
    "K": (1e-3, 1e6),
    "": (SMALLEST, 1e15),
}


def plausible(number: float, unit: str, positive: bool) -> str:
    """What is wrong with the size of a quantity in the SI ``unit``; nothing if it is within its bounds."""
    low, high = BOUNDS.get(unit, (SMALLEST, LARGEST))
    if abs(number) > high:
        return f"must not be larger than {high:g} {unit}".rstrip()
    if positive and number < low:
        return f"must not be smaller than {low:g} {unit}".rstrip()
    return ""

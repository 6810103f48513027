"""Plain names of quantities, such as ``viscosity``, and what an axis calls a parameter: text, unit and symbol of its key."""

from __future__ import annotations

from typing import NamedTuple

from autobalancer.machine import DiscoidalDrag, DragTorque
from autobalancer.machine.balancer import Balls, Fluid, Friction
from autobalancer.machine.part import Part, quantity_of, symbol_of
from autobalancer.machine.path import dimension_of_path, label_of_path, symbol_at, unit_at
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.unbalance import Unbalance

TOGETHER = "&"  # joins quantities and paths that change in proportion


class PlainName(NamedTuple):
    """What a quantity is called, and the key from which unit and symbol come."""

    text: str
    part: type[Part]
    key: str

    @property
    def unit(self) -> str:
        """SI, empty for a plain number."""
        quantity = quantity_of(self.part, self.key)
        return quantity.unit if quantity is not None else ""


QUANTITIES = {
    "viscosity": PlainName("kinematic viscosity of the fluid", Fluid, "viscosity"),
    "drag": PlainName("drag torque of a ball over its speed", DragTorque, "beta"),
    "ball_mass": PlainName("mass of a ball", Balls, "mass"),
    "ball_diameter": PlainName("diameter of a ball", Balls, "diameter"),
    "count": PlainName("number of balls", Balls, "count"),
    "unbalance": PlainName("unbalance", Unbalance, "moment"),
    "damping": PlainName("damping of the supports", PlanarRotor, "damping"),
    "stiffness": PlainName("stiffness of the supports", PlanarRotor, "stiffness"),
    "temperature": PlainName("temperature of the fluid", Fluid, "temperature"),
    "plateau": PlainName("drag coefficient at high Reynolds numbers", DiscoidalDrag, "plateau"),
    "rolling_resistance": PlainName("rolling resistance of the balls", Friction, "rolling_resistance"),
}


def parts_of(name: str) -> list[str]:
    """The quantities and paths that change together under one name."""
    return [part.strip() for part in name.split(TOGETHER)]


def text_of(name: str) -> str:
    """What a person calls a quantity or path."""
    first, *others = parts_of(name)
    if others:
        return f"{text_of(first)} (in proportion: {', '.join(map(text_of, others))})"
    if name in QUANTITIES:
        return QUANTITIES[name].text
    return "rotor speed" if name == "speed" else label_of_path(name)


def named_unit(name: str) -> str:
    """SI unit of a quantity or path, of several the first; empty for a plain number and where no machine has such an entry."""
    name, *_ = parts_of(name)
    if name in QUANTITIES:
        return QUANTITIES[name].unit
    return "rad/s" if name == "speed" else unit_at(name)


def axis_attributes(name: str) -> dict[str, str]:
    """Attributes of a coordinate along which a parameter changes: ``long_name``, ``units`` and, if it has one, ``symbol``."""
    found = {"long_name": text_of(name), "units": named_unit(name).replace("*", " ")}
    known = QUANTITIES.get(name)
    symbol = "" if len(parts_of(name)) > 1 else symbol_of(known.part, known.key) if known else symbol_at(name)
    return {**found, "symbol": symbol} if symbol else found


def dimension_of(name: str) -> str:
    """The name of a quantity or path as a dimension of a dataset."""
    return "_and_".join(map(dimension_of_path, parts_of(name)))

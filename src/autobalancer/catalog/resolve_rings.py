"""From the rings of liquid of a machine to their numbers."""

from __future__ import annotations

import math

from autobalancer.catalog.resolve import fluid_numbers
from autobalancer.errors import CatalogError
from autobalancer.laws.liquid.ring import Ring
from autobalancer.machine import Machine
from autobalancer.machine.liquid_ring import LiquidRing
from autobalancer.machine.part import ImpossiblePart


def rings_of(machine: Machine) -> tuple[Ring, ...]:
    """The rings of a machine.

    Raises
    ------
    MachineError
        If a fluid is unknown, or a mass of liquid does not fit into its ring.
    """
    return tuple(_ring(part, number) for number, part in enumerate(machine.liquid_rings))


def _ring(part: LiquidRing, number: int) -> Ring:
    where = ("liquid_rings", number)
    try:
        density, _ = fluid_numbers(part.fluid)
    except CatalogError as error:
        raise ImpossiblePart("Machine", [((*where, "fluid", "name"), str(error))]) from None
    radius, height = float(part.radius), float(part.height)
    width = math.inf if part.width is None else float(part.width)
    if part.layer is not None:
        return Ring(radius, height, float(part.layer), density, width)
    liquid = float(part.liquid or 0.0)
    inner = max(radius - width, 0.0)
    most = math.pi * density * height * (radius**2 - inner**2)
    if liquid >= most:
        text = f"given {liquid:.4g} kg, but the ring holds {most:.4g} kg; must be less, because only a free surface balances"
        raise ImpossiblePart("Machine", [((*where, "liquid"), text)])
    surface = math.sqrt(radius**2 - liquid / (math.pi * density * height))
    return Ring(radius, height, radius - surface, density, width)

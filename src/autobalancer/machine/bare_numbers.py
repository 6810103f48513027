"""Numbers without a unit that are so large or so small in SI that another unit was surely in mind.

They stand within the bounds of what is possible, so a note says how they were read. A text with a unit is never asked.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from autobalancer.errors import spell
from autobalancer.machine.part import Part, Range, quantity_of
from autobalancer.units import Given, from_si

USUAL = {  # SI unit: smallest and largest number that passes without a note, and the unit that people have in mind
    "rad/s": (0.0, 300.0, "rpm"),
    "rad": (0.0, 2.0 * math.pi, "deg"),
    "m": (0.0, 2.0, "mm"),
    "kg": (0.0, 10_000.0, "g"),
    "kg*m": (0.0, 0.1, "g*mm"),
    "kg/m^3": (100.0, math.inf, "g/cm^3"),
    "m^2/s": (0.0, 0.01, "mm^2/s"),
    "K": (150.0, 1000.0, "degC"),
    "N/m": (100.0, math.inf, "kN/m"),
}
PRESSURE = "GPa or MPa"  # of steel on steel: 2.5 GPa, 2500 MPa
OF_KEYS = {  # the same of single keys, in place of those above; a gas may have a low density
    ("PlanarRotor", "damping_ratio"): (0.0, 1.0, "%"),
    ("Balls", "mass"): (0.0, 1.0, "g"),
    ("Balls", "diameter"): (0.0, 0.1, "mm"),
    ("FreeBalls", "mass"): (0.0, 1.0, "g"),
    ("FreeBalls", "diameter"): (0.0, 0.1, "mm"),
    ("Unbalance", "mass"): (0.0, 10.0, "g"),
    ("Unbalance", "couple"): (0.0, 0.1, "kg*mm^2"),
    ("Race", "orbit_radius"): (0.0, 1.0, "mm"),
    ("Race", "race_radius"): (0.0, 1.0, "mm"),
    ("Race", "eccentricity"): (0.0, 0.01, "um"),
    ("Harmonic", "amplitude"): (0.0, 0.01, "um"),
    ("DragTorque", "beta"): (0.0, 0.1, "mN*m*s"),
    ("Fluid", "density"): (0.01, math.inf, "g/cm^3"),
    ("Limits", "peak_deflection"): (0.0, 0.1, "mm"),
    ("Limits", "residual_vibration"): (0.0, 0.1, "mm"),
    ("Limits", "contact_pressure"): (1e6, math.inf, PRESSURE),
    ("Space", "wall"): (0.0, 0.1, "mm"),
    ("Candidates", "orbit_radius"): (0.0, 1.0, "mm"),
    ("Candidates", "ball_diameter"): (0.0, 0.1, "mm"),
}
ECHOED = {"rad/s": "rpm", "rad": "deg", "K": "degC"}  # units in which a slip is seen at once
LISTED = 5
Place = tuple[str | int, ...]


def bare_numbers(machine: Part) -> tuple[str, ...]:
    """Sentences on how numbers without a unit were read where that is hardly meant; of a list only the first."""
    bare_numbers = list(_odd(machine, ()))
    more = (f"and {len(bare_numbers) - LISTED} more numbers without a unit that are hardly meant in SI",)
    return tuple(bare_numbers[:LISTED]) + (more if len(bare_numbers) > LISTED else ())


def _odd(part: Part, path: Place) -> Iterator[str]:
    for key in type(part).model_fields:
        if key not in part.model_fields_set:
            continue
        entries = _entries(getattr(part, key), (*path, key))
        for place, entry in entries:
            if isinstance(entry, Part):
                yield from _odd(entry, place)
        held = quantity_of(type(part), key)
        if held is None:
            continue
        low, high, meant = OF_KEYS.get((type(part).__name__, key)) or USUAL.get(held.unit, (0.0, math.inf, ""))
        for place, entry in entries:
            if _outside(entry, low, high):
                yield _read_as(spell(place), float(entry), held.unit, meant)
                break


def _entries(value: Any, path: Place) -> list[tuple[Place, Any]]:
    """A value, or those of a list or a range, with their places."""
    if isinstance(value, Range) and value.low is not value.high:
        return [((*path, "from"), value.low), ((*path, "to"), value.high)]
    value = value.low if isinstance(value, Range) else value
    return (
        [((*path, number), entry) for number, entry in enumerate(value)]
        if isinstance(value, tuple)
        else [(path, value)]
    )


def _outside(value: Any, low: float, high: float) -> bool:
    if not isinstance(value, (int, float)) or isinstance(value, (bool, Given)):
        return False
    return value != 0.0 and not low <= abs(value) <= high


def _read_as(place: str, number: float, unit: str, meant: str) -> str:
    shown = f"{number:.10g}"
    if meant == PRESSURE:
        meant = "GPa" if abs(number) < 100.0 else "MPa"
    if not unit:
        return f'{place} = {shown} was read as {100.0 * number:.5g} %; write it with its unit, "{shown} {meant}" if that is meant'
    also = f", which is {from_si(number, unit, ECHOED[unit]):.5g} {ECHOED[unit]}" if unit in ECHOED else ""
    return (
        f"{place} = {shown} was read in {unit}{also}, since a number without a unit is SI; "
        f'write it with its unit, "{shown} {meant}" if that is meant'
    )

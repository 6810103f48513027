"""How large and how small a quantity of a machine can be: bounds that no machine comes near.

Beyond them a value is a slip, and numbers made of it leave the range in which a computer works.
"""

from __future__ import annotations

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

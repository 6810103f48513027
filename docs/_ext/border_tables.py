"""Border speeds of the discoidal rig, computed when the pages are built."""

from __future__ import annotations

import math
from pathlib import Path

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.catalog.resolve import resolve
from autobalancer.machine import Machine

MACHINES = Path(__file__).resolve().parents[1] / "machines"
ANGLES = (95.0, 110.0, 120.0, 125.0, 130.0, 133.0, 135.0, 140.0, 150.0, 170.0)  # deg
OILS = (0.65, 1, 2, 5, 10, 20, 50)  # mm^2/s


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {"borders_over_oil.md": borders_over_oil(), "borders_over_unbalance.md": borders_over_unbalance()}


def borders_over_oil() -> str:
    """All border speeds of the rig for oils of the catalog."""
    machine = ab.load_machine(MACHINES / "thin_oil.toml")
    text = "| silicone oil | S | averaged border | exact border | exact border, worst case | release speed |\n"
    text += "|---|---|---|---|---|---|\n"
    for oil in OILS:
        found = ab.check(with_value_at(machine, "balancers[1].races[1].fluid.name", f"silicone oil {oil:g}"))
        speeds = {border.name: border.speed for border in found.borders}
        names = ("averaged border", "exact border", "exact border, worst case", "release speed")
        cells = [f"{oil:g} mm²/s", f"{found.sommerfeld_number:.3g}", *(_speed(speeds[name]) for name in names)]
        text += f"| {' | '.join(cells)} |\n"
    return text


def borders_over_unbalance() -> str:
    """Exact border of the rig with thin oil, over the unbalance that two balls balance."""
    machine = ab.load_machine(MACHINES / "thin_oil.toml")
    machines = (machine, _balls_of_table_6_4(machine))
    numbers = [ab.check(one).sommerfeld_number for one in machines]
    text = f"| balls at | unbalance, g mm | exact border, S = {numbers[0]:.3g} | exact border, S = {numbers[1]:.3g} |\n"
    text += "|---|---|---|---|\n"
    for angle in ANGLES:
        share = -2.0 * math.cos(math.radians(angle))
        sizes = [share * resolve(one)[0].moment for one in machines]
        speeds = [_exact(one, size) for one, size in zip(machines, sizes, strict=True)]
        text += f"| ±{angle:g}° | {1e6 * sizes[0]:.0f} | {speeds[0]} | {speeds[1]} |\n"
    return text


def _balls_of_table_6_4(machine: Machine) -> Machine:
    """The same drag, but the ball mass of the source: effective in another oil, and without virtual mass."""
    (race,) = machine.balancers[0].races
    balls = {"count": 2, "mass": "6.656 g", "diameter": "12.3 mm"}
    drag = {"law": "viscous", "damping": resolve(machine)[0].drag}
    changed = {"orbit_radius": race.orbit_radius, "drag": drag, "balls": [balls]}
    return with_value_at(machine, "balancers[1].races", [changed])


def _exact(machine: Machine, unbalance: float) -> str:
    speeds = {border.name: border.speed for border in ab.stability.borders(machine, unbalance)}
    return _speed(speeds["exact border"])


def _speed(speed: float) -> str:
    return f"{speed:.4g} rad/s" if math.isfinite(speed) else "never"

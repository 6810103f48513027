"""``autobalancer check`` for a machine whose balls move freely in chambers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from autobalancer.cli.terminal.words import note
from autobalancer.cli.terminal.words import speed_text as _speed
from autobalancer.machine.chamber import ChamberMachine

if TYPE_CHECKING:
    from autobalancer.simulation.chamber.summary import ChamberFilling


def check_chamber(described: ChamberMachine, as_json: bool, as_csv: bool) -> None:
    """Print its masses, critical speeds, unbalance, filling, capability, contact time and step."""
    from autobalancer.cli.terminal.output import print_csv, print_json
    from autobalancer.cli.terminal.sheet import Facts
    from autobalancer.simulation.chamber.summary import chamber_summary

    found = chamber_summary(described)
    if as_json:
        print_json(found.as_dict())
        return
    table = Facts(found.name)
    table.add_row("body", {"fixed": "fixed", "planar": "moves in its plane", "free": "free"}[found.freedom])
    table.add_row("mass", f"{found.total_mass:.6g} kg with balls, rotor {found.rotor_mass:.6g} kg")
    for speed, ratio in zip(found.critical_speeds, found.damping_ratios, strict=True):
        table.add_row("critical speed", f"{_speed(speed)}, damping ratio {100 * ratio:.3g} %")
    couple = f", couple {found.couple_unbalance * 1e9:.5g} g mm²" if found.couple_unbalance else ""
    table.add_row("unbalance", f"{found.unbalance * 1e6:.5g} g mm{couple}")

    def told(filling: ChamberFilling) -> str:
        small, large = 1e3 * filling.smallest_diameter, 1e3 * filling.largest_diameter
        size = f"{large:.4g} mm" if math.isclose(small, large) else f"{small:.4g} to {large:.4g} mm"
        enough = f", {filling.capability / found.unbalance:.3g} times the unbalance" if found.unbalance else ""
        one = filling.balls == 1
        return (
            f"{filling.balls} {'ball' if one else 'balls'} of {size}, {filling.ball_mass:.4g} kg{'' if one else ' together'}\n"
            f"{1e3 * filling.depth:.4g} mm deep, {_room(filling)}\n"
            f"capability {filling.capability * 1e6:.5g} g mm{enough}"
        )

    for filling in found.chambers:
        table.add_row(f"chamber {filling.chamber}", told(filling))
    table.add_row("friction", f"{found.friction:g}; too little, or too few balls, and they stay at the bottom")
    table.add_row("shortest contact", f"{1e6 * found.contact_time:.4g} us at 4 m/s")
    steps = f", {found.duration / found.step:.3g} steps in {found.duration:g} s" if found.duration else ""
    table.add_row("step", f"{1e6 * found.step:.4g} us{steps}")
    table.add_row("highest speed", _speed(found.highest_speed))
    if as_csv:
        print_csv(table.columns())
        return
    table.print()
    for warning in found.warnings:
        note(warning)


def _room(filling: ChamberFilling) -> str:
    """Balls of mixed sizes may be more than there is room for of the largest."""
    share = "" if filling.balls > filling.room else f": {100 * filling.balls / filling.room:.3g} % filled"
    return f"room for {filling.room} of {1e3 * filling.largest_diameter:.4g} mm{share}"

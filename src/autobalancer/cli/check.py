"""``autobalancer check``: what can be said of a machine before it runs."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import typer

LISTED = 4  # critical speeds that are shown


def check(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers in SI for a program.")] = False,
) -> None:
    """Check a machine file and print its masses, critical speeds, capability, drag and border speeds.

    Of a machine with deep chambers: filling, contact time and step in place of drag and borders.

    Example: autobalancer check examples/machines/discoidal.toml
    """
    from autobalancer import summary
    from autobalancer.files.machine_file import read_machine
    from autobalancer.machine.chamber import ChamberMachine

    described = read_machine(machine)
    if isinstance(described, ChamberMachine):
        from autobalancer.cli.check_chamber import check_chamber

        check_chamber(described, as_json)
        return
    found = summary(described)
    if as_json:
        typer.echo(json.dumps(_finite(found.as_dict()), indent=2))
        return
    from rich.console import Console
    from rich.table import Table

    from autobalancer.cli.friction import friction_rows
    from autobalancer.cli.service import service_rows

    table = Table(title=found.name, show_header=False, title_justify="left", min_width=60)
    table.add_column(style="bold")
    table.add_column()
    table.add_row("axis", found.axis)
    table.add_row("mass", f"{found.total_mass:.6g} kg with balls, {found.rotor_mass:.6g} kg without")
    names: tuple[str, ...] = ("along x and y, ",) if len(found.critical_speeds) == 1 else ("along x, ", "along y, ")
    if found.rotor != "planar":
        names = tuple("" for _ in found.critical_speeds)
    rows = list(zip(names, found.critical_speeds, found.damping_ratios, strict=True))
    for name, speed, ratio in rows[:LISTED]:
        table.add_row("critical speed", f"{_speed(speed)}, {name}damping ratio {100 * ratio:.3g} %")
    if len(rows) > LISTED:
        table.add_row("", f"and {len(rows) - LISTED} more from {_speed(rows[LISTED][1])} on; see autobalancer modes")
    table.add_row(
        "unbalance", f"{found.unbalance * 1e6:.5g} g mm" + (" (greatest over time)" if found.unbalance_varies else "")
    )
    if found.service is not None:
        for row in service_rows(found.service):
            table.add_row(*row)
    for race in found.races:
        share = race.capability / found.unbalance if found.unbalance else math.inf
        enough = f", {share:.3g} times the unbalance" if found.unbalance else ""
        table.add_row(
            f"balancer {race.balancer}, race {race.race}",
            f"{race.balls} {'ball' if race.balls == 1 else 'balls'}, "
            f"{race.ball_mass * 1e3:.5g} g ({race.effective_mass * 1e3:.5g} g effective), "
            f"taking {math.degrees(race.occupied_angle):.4g} deg\n"
            f"capability {race.capability * 1e6:.5g} g mm{enough}\n"
            f"drag beta {', '.join(f'{beta:.4g}' for beta in race.drag)} N m s",
        )
    for plane in found.stations:
        table.add_row(
            f"plane {plane.name}",
            f"needs {plane.required * 1e6:.5g} g mm for rest at {_speed(plane.speed)}, "
            f"capability {plane.capability * 1e6:.5g} g mm",
        )
    if found.friction is not None:
        for row in friction_rows(found.friction):
            table.add_row(*row)
    if found.borders:
        if not math.isnan(found.sommerfeld_number):
            table.add_row("S", f"{found.sommerfeld_number:.4g}   (m eps w_c)^2 / (b beta)")
        for border in found.borders:
            table.add_row(border.name, _speed(border.speed) + (f"   ({border.note})" if border.note else ""))
    else:
        table.add_row("border speeds", f"none: {found.no_borders_because}")
    if found.highest_speed is not None:
        table.add_row("highest speed", _speed(found.highest_speed))
    console = Console(soft_wrap=False)
    console.print(table)
    for warning in found.warnings:
        console.print(f"[yellow]note:[/yellow] {warning}")


def _speed(speed: float) -> str:
    if math.isnan(speed):
        return "none"
    if math.isinf(speed):
        return "never"
    return f"{speed:.5g} rad/s = {speed * 30 / math.pi:.5g} rpm"


def _finite(value: object) -> object:
    """JSON has no infinity and no nan: they become texts."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "never" if value > 0 else "none"
    return value

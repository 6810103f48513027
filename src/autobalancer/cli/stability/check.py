"""``autobalancer check``: what can be said of a machine before it runs."""

from __future__ import annotations

import math

from autobalancer.cli.terminal.options import Csv, Json, MachineFile, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note
from autobalancer.cli.terminal.words import speed_text as _speed

LISTED = 4  # critical speeds that are shown


def check(
    machine: MachineFile,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Check a machine file and print its masses, critical speeds, capability, drag and border speeds.

    Of a machine with deep chambers: filling, contact time and step in place of drag and borders.

    Example: autobalancer check discoidal.toml
    """
    from autobalancer.cli.stability.friction import friction_rows, settled_rows
    from autobalancer.cli.stability.service import service_rows
    from autobalancer.cli.terminal.output import one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import Facts
    from autobalancer.files.machine_file import read_machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.stability.summary.summary import summary

    one_form(as_json, as_csv)
    described = read_machine(machine)
    if isinstance(described, ChamberMachine):
        from autobalancer.cli.stability.check_chamber import check_chamber

        check_chamber(described, as_json, as_csv)
        return
    found = summary(described)
    if as_json:
        print_json(found.as_dict())
        return
    table = Facts(found.name)
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
    most = " (greatest over time)" if found.unbalance_varies else ""
    several = len(described.unbalances) > 1 or any(part.is_couple for part in described.unbalances)
    what = ", vector sum of the point unbalances" * several
    table.add_row("unbalance", f"{found.unbalance * 1e6:.5g} g mm{what}{most}")
    if found.service is not None:
        for row in service_rows(found.service):
            table.add_row(*row)
    for race in found.races:
        share = race.capability / found.unbalance if found.unbalance else math.inf
        enough = f", {share:.3g} times the unbalance" if found.unbalance and not found.stations else ""
        table.add_row(
            f"balancer {race.balancer}, race {race.race}",
            f"{race.balls} {'ball' if race.balls == 1 else 'balls'}, "
            f"{race.ball_mass * 1e3:.5g} g ({race.effective_mass * 1e3:.5g} g effective), "
            f"taking {math.degrees(race.occupied_angle):.4g} deg\n"
            f"capability {race.capability * 1e6:.5g} g mm{enough}\n"
            f"drag beta {', '.join(f'{beta:.4g}' for beta in race.drag)} N m s",
        )
    for plane in found.stations:
        enough = f", {plane.capability / plane.required:.3g} times as much" if plane.required > 0.0 else ""
        table.add_row(
            f"plane {plane.name}",
            f"needs {plane.required * 1e6:.5g} g mm{most} for rest at {_speed(plane.speed)}, "
            f"capability {plane.capability * 1e6:.5g} g mm{enough}",
        )
    if found.friction is not None:
        for row in friction_rows(found.friction):
            table.add_row(*row)
    if found.friction_settled is not None:
        for row in settled_rows(found.friction_settled):
            table.add_row(*row)
    if found.off_center is not None and found.off_center.sentence:
        table.add_row("race eccentricity", found.off_center.sentence)
    if found.borders:
        if not math.isnan(found.sommerfeld_number):
            table.add_row("S", f"{found.sommerfeld_number:.4g}   (m eps w_c)^2 / (b beta)")
        for border in found.borders:
            said = _speed(border.speed) + (f"   ({border.note})" if border.note else "")
            table.add_row(border.name, said if border.known else f"not known: {border.note}")
    else:
        table.add_row("border speeds", f"none: {found.no_borders_because}")
    if found.highest_speed is not None:
        table.add_row("highest speed", _speed(found.highest_speed))
    if as_csv:
        print_csv(table.columns())
        return
    table.print()
    for warning in found.warnings:
        note(warning)

"""``autobalancer check``: what can be said of a machine before it runs."""

from __future__ import annotations

from autobalancer.cli.terminal.options import Csv, Json, MachineFile, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, speed_text


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
    from autobalancer.cli.terminal.output import one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import Facts
    from autobalancer.either_kind import check as known
    from autobalancer.patience import looking_for

    one_form(as_json, as_csv)
    found = known(machine, looking_for)
    if as_json:
        print_json(found.as_dict())
        return
    table = Facts(found.name)
    for row in found.rows(speed_text):
        table.add_row(*row)
    if as_csv:
        print_csv(table.columns())
        return
    table.print()
    for warning in found.warnings:
        note(warning)

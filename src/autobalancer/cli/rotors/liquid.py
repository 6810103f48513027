"""``autobalancer liquid-response``: the unbalance response of a rotor with rings partly filled with liquid."""

from __future__ import annotations

from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, speed_text

COUNT = 401  # speeds in a range that gives no count


def liquid_response(
    machine: MachineFile,
    speeds: Annotated[str, typer.Option(help='"from:to" or "from:to:count", such as "100 rpm:1000 rpm:400".')],
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print how far a rotor whose balancers are rings of liquid deflects in a steady whirl, with the liquid and without.

    Example: autobalancer liquid-response liquid_ring.toml \\
      --speeds "100 rpm:1000 rpm:400" --plot liquid.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import speed_range
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    found = ab.rotor.liquid_response(machine, speed_range("--speeds", speeds, COUNT))
    files.save(found, lambda: ab.plot.liquid_response(found, speed_unit=speed_unit))
    if as_json:
        values = {str(name): found[name].values for name in (*found.coords, *found.data_vars)}
        numbers = {key: value for key, value in found.attrs.items() if isinstance(value, float)}
        print_json({"machine": str(machine), **numbers, **values})
        return
    if as_csv:
        print_csv(found.columns(speed_unit))
        return
    print_facts(found.rows(speed_text), str(found.attrs["title"]))
    print_sheet(found.columns(speed_unit))
    for remark in found.remarks():
        note(remark)
    files.say()

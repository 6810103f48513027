"""``autobalancer equivalent-planar``: the planar oscillator that replaces a rotor at the plane of its balls."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, say, speed_sign, speed_text


def equivalent(
    machine: MachineFile,
    station: Annotated[
        str | None, typer.Option(help="Station or position; by default that of the first balancer.")
    ] = None,
    method: Annotated[str, typer.Option(help="modal, or static: stiffness at the race.")] = "modal",
    frequency: Annotated[
        str, typer.Option(help="critical (turning with the rotor) or natural (at rest).")
    ] = "critical",
    out: Annotated[
        list[Path] | None,
        typer.Option(help="The planar machine as .toml, the numbers as .nc, .csv or .json. May be repeated."),
    ] = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Find the planar oscillator that stands for a rotor at the plane of its balls, and say how far it holds.

    Example: autobalancer equivalent-planar rigid_rotor.toml \\
      --out planar.toml
    """
    from autobalancer.cli.terminal.output import MACHINE, RESULT, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.equivalent_planar import equivalent_planar

    one_form(as_json, as_csv)
    files = Files(out, plot, (*MACHINE, *RESULT))
    described = load_race_machine(machine)
    names = {entry.name for entry in described.stations}
    place = station if station is None or station in names else float(quantity("--station", station, "m"))
    found = equivalent_planar(described, place, method=method, frequency=frequency)  # type: ignore[arg-type]
    data = found.data
    files.save(data, lambda: ab.plot.equivalent_planar(data), machine=found.machine)
    rows = []
    for way in data["way"].values:
        for direction in data["direction"].values:
            one = data.sel(way=way, direction=direction)
            rows.append({"way": str(way), "direction": str(direction)} | {key: float(one[key]) for key in _KEYS})
    if as_json:
        print_json({"oscillators": rows, "description": found.machine.description})
        return
    if as_csv:
        print_csv(data.columns(speed_sign()))
        return
    print_sheet(data.columns(speed_sign()), f"{described.name}: the planar oscillator in its place")
    for row in rows:
        held = _holds(row)
        if row["way"] == method and not held:
            note(
                f"the {method} oscillator along {row['direction']} does not hold anywhere near its critical speed; "
                f"look at --plot, and at --method {'static' if method == 'modal' else 'modal'}"
            )
        if row["way"] == method and held:
            say(f"{method} along {row['direction']}, the one taken, holds {held}")
    if data.attrs["ignores"]:
        note(f"ignores {data.attrs['ignores']}")
    say(found.machine.description)
    files.say()


_KEYS = ("stiffness", "mass", "damping", "critical_speed", "damping_ratio", "valid_from", "valid_to")


def _holds(row: dict[str, Any]) -> str:
    if math.isnan(row["valid_from"]) or math.isnan(row["valid_to"]):
        return ""
    return f"from {speed_text(row['valid_from'])} to {speed_text(row['valid_to'])}"

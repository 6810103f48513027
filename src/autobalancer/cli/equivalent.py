"""``autobalancer equivalent``: the planar oscillator that replaces a rotor at the plane of its balls."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import typer


def equivalent(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    station: Annotated[
        str | None, typer.Option(help="Station or position; by default that of the first balancer.")
    ] = None,
    method: Annotated[str, typer.Option(help="static (stiffness at the race) or modal.")] = "static",
    frequency: Annotated[
        str, typer.Option(help="critical (turning with the rotor) or natural (at rest).")
    ] = "critical",
    out: Annotated[Path | None, typer.Option(help="Write the planar machine to this file.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: both receptances and their deviation.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers in SI for a program.")] = False,
) -> None:
    """Find the planar oscillator that stands for a rotor at the plane of its balls, and say how far it holds.

    Example: autobalancer equivalent rig.toml --out planar.toml
    """
    from autobalancer.files.machine_file import load_machine, save_machine
    from autobalancer.rotordynamics.equivalent_planar import equivalent_planar
    from autobalancer.units import to_si

    described = load_machine(machine)
    names = {entry.name for entry in described.stations}
    place = station if station is None or station in names else float(to_si(station, "m"))
    found = equivalent_planar(described, place, method=method, frequency=frequency)  # type: ignore[arg-type]
    if out is not None:
        save_machine(found.machine, out)
    if plot is not None:
        from autobalancer.plots.equivalent_planar import plot_equivalent_planar
        from autobalancer.plots.save import save_picture

        save_picture(plot_equivalent_planar(found.data), plot)
    data = found.data
    rows = []
    for way in data["way"].values:
        for direction in data["direction"].values:
            one = data.sel(way=way, direction=direction)
            keys = ("stiffness", "mass", "damping", "critical_speed", "damping_ratio", "valid_from", "valid_to")
            rows.append({"way": str(way), "direction": str(direction)} | {key: float(one[key]) for key in keys})
    if as_json:
        clean = [
            {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()} for row in rows
        ]
        typer.echo(json.dumps({"oscillators": clean, "description": found.machine.description}, indent=2))
        return
    for row in rows:
        mark = "->" if row["way"] == method else "  "
        typer.echo(
            f"{mark} {row['way']:6} {row['direction']}: k {row['stiffness']:.6g} N/m, M {row['mass']:.5g} kg, "
            f"b {row['damping']:.4g} N s/m, holds from {row['valid_from']:.4g} to {row['valid_to']:.4g} rad/s"
        )
    typer.echo(found.machine.description)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")

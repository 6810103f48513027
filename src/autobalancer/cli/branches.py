"""``autobalancer branches``: steady states and periodic motions along a parameter."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer


def branches(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    start: Annotated[str, typer.Option("--from", help='Begin of the range, such as "55 rad/s".')],
    end: Annotated[str, typer.Option("--to", help="End of the range; may be the lower one.")],
    parameter: Annotated[
        str, typer.Option(help="speed, unbalance, drag, viscosity, ball_mass, damping, stiffness, or a path.")
    ] = "speed",
    speed: Annotated[str, typer.Option(help="Rotor speed where it is not the parameter.")] = "",
    state: Annotated[
        str, typer.Option(help="Where to begin: balanced, coincident, 'in line', stalled or all.")
    ] = "balanced",
    switch: Annotated[bool, typer.Option(help="Go on along what branches off.")] = True,
    orbits: Annotated[bool, typer.Option(help="Follow periodic motions born at Hopf points.")] = True,
    out: Annotated[Path | None, typer.Option(help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the table and the picture.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers in SI for a program.")] = False,
) -> None:
    """Follow the states in which the balls rest, and their periodic motions, and list where they are born or lose stability.

    Example: autobalancer branches examples/machines/discoidal.toml --from "40 rad/s" --to "110 rad/s" --state all
    --plot branches.png
    """
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer.plots.branches import plot_branches
    from autobalancer.plots.save import save_picture
    from autobalancer.results.store import save_run
    from autobalancer.stability.branches import branches as ask
    from autobalancer.units import option_to_si

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("branch", total=1.0)
        found = ask(
            machine,
            parameter,
            _quantity(start),
            _quantity(end),
            speed=option_to_si(speed, "rad/s") if speed else None,
            from_state=state,  # type: ignore[arg-type]
            switch=switch,
            orbits=orbits,
            progress=lambda number, share: bar.update(task, description=f"branch {number}", completed=share),
        )
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_branches(found, speed_unit=speed_unit), plot)
    if as_json:
        answer = {
            "machine": str(machine),
            "parameter": parameter,
            "ignores": found.attrs["ignores"],
            "branches": _branches(found),
            "special": _special(found),
        }
        typer.echo(json.dumps(answer, indent=2))
        return
    _print(found, speed_unit)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _quantity(text: str) -> float | str:
    """A bare number is SI; everything else has a unit."""
    try:
        return float(text)
    except ValueError:
        return text


def _branches(found: Any) -> list[dict[str, Any]]:
    import numpy as np

    from autobalancer.stability.tables import stable_ranges

    rows = []
    for number, ended in enumerate(found.attrs["branch_ends"], 1):
        part = found.isel(point=np.flatnonzero(found["branch"].values == number))
        names, counts = np.unique(part["name"].values, return_counts=True)
        rows.append(
            {
                "branch": number,
                "kind": str(part["kind"].values[0]),
                "name": str(names[np.argmax(counts)]),
                "from": float(part["parameter"].values[0]),
                "to": float(part["parameter"].values[-1]),
                "ended": ended,
                "stable": stable_ranges(found, number),
            }
        )
    return rows


def _special(found: Any) -> list[dict[str, Any]]:
    import math

    names = (
        "special_parameter",
        "special_frequency",
        "lyapunov_coefficient",
        "special_deflection_max",
        "special_period",
    )
    rows = []
    for i in range(found.sizes["special"]):
        row = {"type": str(found["special_type"].values[i]), "branch": int(found["special_branch"].values[i])}
        row["criticality"] = str(found["criticality"].values[i])
        numbers = {name.removeprefix("special_"): float(found[name].values[i]) for name in names}
        rows.append({**row, **{key: value if math.isfinite(value) else None for key, value in numbers.items()}})
    return rows


def _print(found: Any, speed_unit: str) -> None:
    from rich.console import Console
    from rich.table import Table

    from autobalancer.plots.quantity_axis import axis_unit

    unit = axis_unit(found["parameter"], speed_unit)
    sign = f" ({unit.sign})" if unit.sign else ""

    def shown(value: float | None) -> str:
        return "" if value is None else f"{value * unit.factor:.6g}"

    ignores = f"; ignores {found.attrs['ignores']}" if found.attrs["ignores"] else ""
    table = Table(
        title=f"{found.attrs['machine_name']}: branches along {found['parameter'].attrs['long_name']}{ignores}"
    )
    for name in ("", "motion", f"from{sign}", f"to{sign}", "ended", "not unstable"):
        table.add_column(name)
    for row in _branches(found):
        span = ", ".join(f"{shown(a)} to {shown(b)}" for a, b in row["stable"]) or "never"
        table.add_row(str(row["branch"]), row["name"], shown(row["from"]), shown(row["to"]), row["ended"], span)
    points = Table(title="special points")
    for name in ("branch", "what", f"at{sign}", "frequency (rad/s)", "Lyapunov coefficient"):
        points.add_column(name)
    for row in _special(found):
        what = f"{row['type']}, {row['criticality']}" if row["criticality"] else row["type"]
        frequency, lyapunov = (
            "" if row[key] is None else f"{row[key]:.5g}" for key in ("frequency", "lyapunov_coefficient")
        )
        points.add_row(str(row["branch"]), what, shown(row["parameter"]), frequency, lyapunov)
    console = Console()
    console.print(table)
    if found.sizes["special"]:
        console.print(points)

"""``autobalancer branches``: steady states and periodic motions along a parameter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit

if TYPE_CHECKING:
    from autobalancer.cli.terminal.sheet import Column

DOUBLING = "period doubling"
FEW = 3  # period doublings of a branch that are listed unasked


def branches(
    machine: MachineFile,
    over: Annotated[str, typer.Option(help='"NAME=from:to", such as "speed=55 rad/s:110 rad/s"; also downwards.')],
    speed: Annotated[str, typer.Option(help='Rotor speed where it is not the parameter, such as "1200 rpm".')] = "",
    state: Annotated[
        str,
        typer.Option(
            help="Where to begin: balanced, mixed, coincident, 'in line', spread, stalled, 'partly stalled' or all."
        ),
    ] = "balanced",
    switch: Annotated[bool, typer.Option(help="Go on along what branches off.")] = True,
    orbits: Annotated[bool, typer.Option(help="Follow periodic motions born at Hopf points.")] = True,
    every: Annotated[
        bool, typer.Option("--all", help=f"List all period doublings of a branch, not only {FEW}.")
    ] = False,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Follow the states in which the balls rest, and their periodic motions, and list where they begin or lose stability.

    A NAME is speed, unbalance, drag, viscosity, ball_mass, damping, stiffness, or a path such as rotor.damping. Names
    joined by & change in proportion: "ball_mass & drag".

    Example: autobalancer branches discoidal.toml \\
      --over "speed=40 rad/s:110 rad/s" --state all --plot branches.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import named, optional, unit_of
    from autobalancer.files.machine_file import load_machine
    from autobalancer.plots.stability.branches import plot_branches
    from autobalancer.stability.diagrams.branches import branches as ask
    from autobalancer.units.ranges import ends

    one_form(as_json, as_csv)
    files = Files(out, plot)
    described = load_machine(machine)
    parameter, span = named("--over", over, "from:to")
    start, end = ends("--over", span, unit_of("--over", parameter, described))
    with progress_bar("branch") as update:
        found = ask(
            described,
            parameter,
            start,
            end,
            speed=optional("--speed", speed, "rad/s"),
            from_state=state,  # type: ignore[arg-type]
            switch=switch,
            orbits=orbits,
            progress=lambda number, share: update(share, 1.0, description=f"branch {number}"),
        )
    files.save(found, lambda: plot_branches(found, speed_unit=speed_unit))
    if as_json:
        rows = {"branches": _branches(found), "special": _special(found)}
        about = {"machine": str(machine), "parameter": parameter, "ignores": found.attrs["ignores"]}
        print_json({**about, **rows})
        return
    if as_csv:
        print_csv(_branch_columns(found, speed_unit))
        return
    _print(found, speed_unit, every)
    files.say()


def _branches(found: Any) -> list[dict[str, Any]]:
    import numpy as np

    from autobalancer.stability.diagrams.tables import stable_ranges

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
                "lowest": float(part["parameter"].min()),
                "highest": float(part["parameter"].max()),
                "ended": ended,
                "stable": stable_ranges(found, number),
            }
        )
    return rows


def _special(found: Any) -> list[dict[str, Any]]:
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


def _branch_columns(found: Any, speed_unit: str) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.results.display_units import axis_unit

    unit, rows = axis_unit(found["parameter"], speed_unit), _branches(found)

    def shown(value: float) -> str:
        return f"{value * unit.factor:.6g}"

    def span(stable: list[tuple[float, float]]) -> str:
        ends = sorted(sorted(pair) for pair in stable)
        parts = [shown(a) if shown(a) == shown(b) else f"{shown(a)} to {shown(b)}" for a, b in ends]
        return ", ".join(parts) or "nowhere"

    ends = [[row[key] * unit.factor for row in rows] for key in ("lowest", "highest")]
    return [
        Column("branch", [row["branch"] for row in rows]),
        Column("motion", [row["name"] for row in rows], wraps=True),
        Column("lowest", ends[0], unit.sign, ".6g"),
        Column("highest", ends[1], unit.sign, ".6g"),
        Column("stable or marginal", [span(row["stable"]) for row in rows], unit.sign, wraps=True),
        Column("ended", [row["ended"] for row in rows], wraps=True),
    ]


def _point_columns(found: Any, speed_unit: str, rows: list[dict[str, Any]]) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.results.display_units import axis_unit

    unit = axis_unit(found["parameter"], speed_unit)
    what = [f"{row['type']}, {row['criticality']}" if row["criticality"] else row["type"] for row in rows]
    return [
        Column("branch", [row["branch"] for row in rows]),
        Column("what", what),
        Column("at", [row["parameter"] * unit.factor for row in rows], unit.sign, ".6g"),
        Column("frequency", [row["frequency"] for row in rows], "rad/s"),
        Column("Lyapunov coefficient", [row["lyapunov_coefficient"] for row in rows]),
    ]


def _print(found: Any, speed_unit: str, every: bool) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.cli.terminal.words import say

    ignores = f"; ignores {found.attrs['ignores']}" if found.attrs["ignores"] else ""
    title = f"{found.attrs['machine_name']}: branches along {found['parameter'].attrs['long_name']}{ignores}"
    print_sheet(_branch_columns(found, speed_unit), title)
    rows = _special(found)
    shown = rows if every else _without_cascades(rows)
    if shown:
        print_sheet(_point_columns(found, speed_unit, shown), "special points")
    if len(shown) < len(rows):
        say(f"{len(rows) - len(shown)} more {DOUBLING}s are not shown; --all lists them")


def _without_cascades(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The first period doublings of each branch, and everything else."""
    kept, seen = [], dict[int, int]()
    for row in rows:
        if row["type"] == DOUBLING:
            seen[row["branch"]] = seen.get(row["branch"], 0) + 1
        if row["type"] != DOUBLING or seen[row["branch"]] <= FEW:
            kept.append(row)
    return kept

"""``autobalancer branches``: steady states and periodic motions along a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit

if TYPE_CHECKING:
    from autobalancer.stability.diagrams.answers import Branches

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
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.diagrams.branches import branches as ask
    from autobalancer.units.ranges import ends

    one_form(as_json, as_csv)
    files = Files(out, plot)
    described = load_race_machine(machine)
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
    files.save(found, lambda: ab.plot.branches(found, speed_unit=speed_unit))
    if as_json:
        rows = {"branches": found.branch_rows(), "special": found.special_rows()}
        about = {"machine": str(machine), "parameter": parameter, "ignores": found.attrs["ignores"]}
        missing = {"not_followed": said} if (said := found.not_followed()) else {}
        print_json({**about, **missing, **rows})
        return
    if as_csv:
        print_csv(found.columns(speed_unit))
        return
    _print(found, speed_unit, every)
    files.say()


def _print(found: Branches, speed_unit: str, every: bool) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.cli.terminal.words import say

    print_sheet(found.columns(speed_unit), found.heading())
    rows = found.special_rows()
    shown = rows if every else _without_cascades(rows)
    if shown:
        print_sheet(found.special_columns(shown, speed_unit), "special points")
    if len(shown) < len(rows):
        say(f"{len(rows) - len(shown)} more {DOUBLING}s are not shown; --all lists them")
    for line in found.not_followed():
        say(line)


def _without_cascades(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The first period doublings of each branch, and everything else."""
    kept, seen = [], dict[int, int]()
    for row in rows:
        if row["type"] == DOUBLING:
            seen[row["branch"]] = seen.get(row["branch"], 0) + 1
        if row["type"] != DOUBLING or seen[row["branch"]] <= FEW:
            kept.append(row)
    return kept

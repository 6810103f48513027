"""``autobalancer eigenvalues``: eigenvalues of a steady state over the speed."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Annotated, get_args

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit

if TYPE_CHECKING:
    import numpy as np


COUNT = 401  # speeds in a range that gives no count


def stability(
    machine: MachineFile,
    speeds: Annotated[
        str,
        typer.Option(
            help='"from:to" or "from:to:count", or one speed; by default from half to three times the critical speeds that the '
            "machine reaches, and at least up to its highest speed."
        ),
    ] = "",
    state: Annotated[
        str,
        typer.Option(help="balanced, coincident, 'in line', mixed: at some stations at rest, or spread: by forces."),
    ] = "balanced",
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; by default that of the machine.')] = "",
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Say in which speed ranges a steady state is stable, exactly: eigenvalues, or multipliers on anisotropic supports.

    Example: autobalancer eigenvalues discoidal.toml \\
      --speeds "500 rpm:1500 rpm:200" --plot s.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, speed_range
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.states.questions import Kind, eigenvalues
    from autobalancer.stability.states.ranges import ranges

    one_form(as_json, as_csv)
    files = Files(out, plot)
    if state not in get_args(Kind):
        raise QuestionError(f"--state: given {state!r}; must be balanced, mixed, coincident, 'in line' or spread")
    described = load_race_machine(machine)
    chosen = speed_range("--speeds", speeds, COUNT) if speeds else _usual(machine)
    size = optional("--unbalance", unbalance, "kg*m")
    with progress_bar("speeds") as update:
        found = eigenvalues(
            described,
            [float(speed) for speed in chosen],
            state=state,  # type: ignore[arg-type]
            unbalance=size,
            progress=update,
        )
    located = cache(lambda: ranges(described, found, size))
    files.save(found, lambda: ab.plot.eigenvalues(found, speed_unit=speed_unit, ranges=located()))
    missing = [float(w) for w in found.attrs["speeds_without_state"]]
    if as_json:
        names = ("speed", "growth_rate", "verdict", "leading_motion")
        rows = [
            dict(zip(names, row, strict=True))
            for row in zip(*(found[name].values.tolist() for name in names), strict=True)
        ]
        print_json(
            {
                "machine": str(machine),
                "state": state,
                "ignores": found.attrs["ignores"],
                "rows": rows,
                "speeds_without_state": missing,
            }
        )
        return
    table = located().columns(speed_unit)
    if as_csv:
        print_csv(table)
        return
    ignores = f"; ignores {found.attrs['ignores']}" if found.attrs["ignores"] else ""
    print_sheet(table, f"{described.name}: {state} state{ignores}")
    if missing:
        typer.echo(f"no such state at {len(missing)} of the speeds")
    files.say()


def _usual(machine: object) -> np.ndarray:
    import numpy as np

    from autobalancer.errors import QuestionError
    from autobalancer.stability.summary.summary import summary

    about = summary(machine)  # type: ignore[arg-type]
    critical = about.critical_speeds
    if not critical:
        raise QuestionError("--speeds: this rotor has no critical speed to choose a range by; give one")
    # bending speeds far above all that the machine runs at say nothing
    reached = [w for w in critical if w <= (about.highest_speed or math.inf)] or [min(critical)]
    return np.linspace(0.5 * min(critical), max(3.0 * max(reached), about.highest_speed or 0.0), COUNT)

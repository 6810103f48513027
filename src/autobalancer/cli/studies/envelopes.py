"""``autobalancer envelopes``: how far a machine goes on its way up, as percentiles over many runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, Seed, SpeedUnit, Unit
from autobalancer.cli.terminal.words import speed_sign


def envelopes(
    file: Annotated[Path, typer.Argument(help="Study file, or a machine file, whose balls start anywhere.")],
    members: Annotated[int, typer.Option(min=2, help="How many runs.")] = 100,
    point: Annotated[int, typer.Option(min=1, help="Of the grid of a study.")] = 1,
    coast_down: Annotated[
        bool, typer.Option("--coast-down", help="The rotor comes down again, as fast as it went up.")
    ] = False,
    seed: Seed = 0,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run a machine many times and say which deflection 5, 25, 50, 75 and 95 % of the runs stay below, over the time.

    Example: autobalancer envelopes discoidal.toml --members 40 --coast-down --plot fan.png
    """
    import autobalancer as ab
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.results.export import plain_json

    one_form(as_json, as_csv)
    files = Files(out, plot)
    with progress_bar("runs") as update:
        found = ab.envelopes(file, members=members, point=point, coast_down=coast_down, seed=seed, progress=update)
    files.save(found, lambda: ab.plot.envelopes(found, speed_unit=speed_unit))
    columns = found.columns(speed_sign())
    if as_json:
        print_json({"file": str(file), **plain_json({column.head: column.values for column in columns})})
    elif as_csv:
        print_csv(columns)
    else:
        print_sheet(columns)
        files.say()

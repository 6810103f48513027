"""``autobalancer measures``: the measures of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, Settling, SpeedUnit, Unit


def measures(
    result: Annotated[Path, typer.Argument(help="Result file, or folder of a run in an archive.")],
    last: Annotated[
        str, typer.Option(help="Deep chamber: time at the end that is the steady state; by default a tenth of the run.")
    ] = "",
    settling_from: Settling = "run-up",
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the measures of a result: one number of the run, or one for each ball, place, plane, support, link or stage.

    Example: autobalancer measures stall.nc
    """
    from autobalancer.cli.terminal.output import one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.either_kind import measures as measured
    from autobalancer.results.open_run import open_run

    one_form(as_json, as_csv)
    asked: dict[str, Any] = {"last": quantity("--last", last, "s")} if last else {}
    asked |= {"settling_from": settling_from} if settling_from != "run-up" else {}
    found = measured(open_run(result), **asked)
    if as_json:
        print_json({"result": str(result), "measures": {str(name): found[name].values for name in found}})
    elif as_csv:
        print_csv(found.columns(speed_unit))
    else:
        print_sheet(found.columns(speed_unit), found.heading())

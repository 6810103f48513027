"""``autobalancer compare``: several machines side by side, or a run and what was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, Seed, SpeedUnit, Unit


def compare(
    machines: Annotated[
        list[Path],
        typer.Argument(
            help="Machine files, in the order of the table. Or a run (.nc) and a file of signals, orders or ball angles."
        ),
    ],
    at: Annotated[
        list[str] | None,
        typer.Option(help='Speed at which the deflection is wanted too, such as "40 rad/s". May be repeated.'),
    ] = None,
    duration: Annotated[str, typer.Option(help='Such as "60 s"; by default that of each machine.')] = "",
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-7,
    seed: Seed = 0,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run several machines and put side by side what each run left, and from which speed on it balances.

    Of a run (.nc) and a measurement: the same curves and the same measures of both.

    Example: autobalancer compare variant_plain.toml variant_pins.toml \\
      --at "40 rad/s" --plot variants.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.cli.terminal.words import note
    from autobalancer.studies.compare import compare as compared

    one_form(as_json, as_csv)
    files = Files(out, plot)
    if machines[0].suffix.lower() == ".nc":
        _overlay(machines, seed, files, speed_unit, as_json, as_csv)
        return
    runs = [path for path in machines if path.suffix.lower() == ".nc"]
    if runs:
        raise ab.errors.QuestionError(f"{runs[0]}: a run comes first, and then what was measured")
    with progress_bar("machines") as update:
        found = compared(
            machines,
            at=[quantity("--at", speed, "rad/s") for speed in at or ()],
            duration=optional("--duration", duration, "s"),
            tolerance=tolerance,
            seed=seed,
            progress=update,
        )
    files.save(found, lambda: ab.plot.comparison(found))
    columns = found.columns(speed_unit)
    if as_json:
        print_json({str(name): part.values for name, part in found.variables.items() if "bin" not in part.dims})
        return
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, found.heading())
    for remark in found.remarks():
        note(remark)
    files.say()


def _overlay(given: list[Path], seed: int, files: Any, speed_unit: str, as_json: bool, as_csv: bool) -> None:
    from autobalancer.cli.terminal.output import print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.cli.terminal.words import note
    from autobalancer.measurement.comparison.opened import load_measured

    if len(given) != 2:
        raise ab.errors.QuestionError(
            "compare: after a run give one measurement: a table of signals or orders, or an .nc file"
        )
    run = ab.load_run(given[0])
    found = ab.compare(run, load_measured(given[1]), seed=seed)
    files.save(found, lambda: ab.plot.overlay(found, speed_unit=speed_unit))
    columns = found.columns(speed_unit)
    if as_json:
        names = (name for name, part in found.variables.items() if not {"time", "order_time"} & set(part.dims))
        print_json({str(name): found[name].values for name in names} | {"notes": found.remarks()})
        return
    if as_csv:
        print_csv(columns)
        return
    print_facts(found.facts(), found.heading())
    if found.sizes["measure"]:
        print_sheet(columns)
    for text in found.remarks():
        note(text)
    files.say()

"""``autobalancer study``: what varies and how it scatters, from a file, run until enough is known."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say, speed_sign

ALSO = ("balanced", "balanced_before", "steps", "drawn_again")  # are drawn, too, where a study has them


def study(
    file: Annotated[Path, typer.Argument(help="Study file (TOML).", metavar="STUDY")],
    folder: Annotated[
        Path | None,
        typer.Option(help="Where finished parts are kept; by default the name of the file with _parts here."),
    ] = None,
    sensitivity: Annotated[
        str,
        typer.Option(
            help="Also say which scatter drives that of this quantity, such as peak_deflection. --plot shows that then."
        ),
    ] = "",
    quantity: Annotated[
        str,
        typer.Option(
            help="What the picture of --plot shows, such as settling_time; by default the share of balanced runs."
        ),
    ] = "balanced",
    scheduler: Annotated[
        str, typer.Option(help='Address of a Dask scheduler whose workers run the members, such as "tcp://host:8786".')
    ] = "",
    workers: Annotated[int, typer.Option(min=0, help="Threads; 0 for one each core.")] = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="Result file: .nc, .csv or .json; by default the name of the file with .nc here."),
    ] = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run a machine many times with values from a grid and from distributions, as a study file says.

    Finished parts are kept in a folder: after Ctrl-C or a crash the same command goes on, with the same numbers.

    Example: autobalancer study oil_study.toml --sensitivity peak_deflection
    """
    import autobalancer as ab
    from autobalancer.cli.terminal.exit_codes import stop_code
    from autobalancer.cli.terminal.output import Files, file_to_read, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.results.export import plain_json

    def drawn(found: Any) -> Any:
        if sensitivity:
            return ab.plot.sensitivity(ab.sensitivity(found, sensitivity))
        return ab.plot.study(found, quantity, speed_unit=speed_unit)

    one_form(as_json, as_csv)
    file_to_read(file)
    _refuse_unknown(file, {"sensitivity": sensitivity, "quantity": quantity if plot is not None else ""})
    files = Files(out if out is not None else Path(f"{file.stem}.nc"), plot)
    with progress_bar("members") as update:
        found = ab.study(
            file,
            folder=folder if folder is not None else Path(f"{file.stem}_parts"),
            scheduler=scheduler or None,
            workers=workers or None,
            progress=update,
            keep_on_interrupt=True,
        )
    files.save(found, lambda: drawn(found))
    driven = ab.sensitivity(found, sensitivity) if sensitivity else None
    shown = found if driven is None else driven
    if as_json:
        print_json(
            {"study": str(file), **plain_json({column.head: column.values for column in shown.columns(speed_sign())})}
        )
    elif as_csv:
        print_csv(shown.columns(speed_sign()))
    else:
        print_sheet(found.columns(speed_sign()))
        for line in found.remarks():
            if not line.startswith("interrupted"):  # said below, with what to do here
                say(line, indent="  ")
        if driven is not None:
            say(driven.heading())
            print_sheet(driven.columns())
            for line in driven.remarks():
                say(line, indent="  ")
        files.say()
    if found.attrs["stopped_by"] == "interrupted":
        typer.echo("interrupted; the same command goes on", err=True)
        raise typer.Exit(stop_code())


def _refuse_unknown(file: Path, asked: dict[str, str]) -> None:
    """Refuse quantities that the study will not have, before it runs."""
    from autobalancer.errors import QuestionError
    from autobalancer.studies.study.outputs import quantity_kind
    from autobalancer.studies.study.reading import read_study

    results = read_study(file).results
    for option, name in asked.items():
        if name and name not in ALSO:
            try:
                quantity_kind(name, results)
            except QuestionError as reason:
                raise QuestionError(f"--{option}: {reason}") from None

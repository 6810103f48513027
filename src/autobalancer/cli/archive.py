"""``autobalancer archive``: what is in a folder of runs, which of them, and one of them as a file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any

import typer


def archive(
    folder: Annotated[Path, typer.Argument(help="Folder of the archive.")],
    where: Annotated[str, typer.Option(help='Condition, such as "friction >= 0.5 and balls in [8, 9]".')] = "",
    show: Annotated[
        list[str] | None,
        typer.Option(help="Column of the table; give several. By default parameters and the main measures."),
    ] = None,
    export: Annotated[str, typer.Option(help="Name of a run to write as one result file.")] = "",
    out: Annotated[
        Path | None, typer.Option(help="With --export: the file, .nc; by default the name of the run here.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of --y over --x: png, svg or pdf.")] = None,
    x: Annotated[str, typer.Option(help="Value along the axis of the picture.")] = "balls",
    y: Annotated[str, typer.Option(help="Value of the picture.")] = "vertical_amplitude",
    by: Annotated[str, typer.Option(help="Value that tells the curves apart.")] = "",
    log: Annotated[bool, typer.Option(help="Logarithmic scale of y.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print every value in SI for a program.")] = False,
) -> None:
    """List the runs of an archive, choose among them, draw their measures, or take one out.

    Example: autobalancer archive runs --where "friction >= 0.5" --plot a.png --x balls --y vertical_amplitude --by friction
    """
    from autobalancer.errors import QuestionError
    from autobalancer.results.archive import Archive

    if not folder.is_dir():
        raise QuestionError(f"{folder}: no such folder; archives are made by autobalancer study with --archive")
    if (folder / "run.json").exists():
        raise QuestionError(f"{folder}: is one run; its archive is {folder.parent}, and autobalancer plot draws it")
    held = Archive(folder)
    if export:
        typer.echo(f"written: {held.export(export, out if out is not None else Path(f'{export}.nc'))}")
        return
    table = held.runs(where)
    if plot is not None:
        from autobalancer.plots.chamber_study import plot_catalogue
        from autobalancer.plots.save import save_picture

        save_picture(plot_catalogue(table, x, y, by or None, log=log), plot)
    rows = [
        {"run": str(name), **{str(key): table[key].values[i] for key in table.data_vars}}
        for i, name in enumerate(table["run"].values)
    ]
    if as_json:
        typer.echo(json.dumps([{key: _plain(value) for key, value in row.items()} for row in rows], indent=1))
        return
    _print(rows, show or MAIN)
    if plot is not None:
        typer.echo(f"written: {plot}")


MAIN = ["state", "balls", "friction", "layers", "vertical_amplitude", "vertical_peak", "settling_time", "share_carried"]


def _print(rows: list[dict[str, Any]], columns: list[str]) -> None:
    from rich.console import Console
    from rich.table import Table

    from autobalancer.errors import QuestionError

    known = {key for row in rows for key in row}
    unknown = [name for name in columns if name not in known] if columns is not MAIN else []
    if rows and unknown:
        raise QuestionError(f"show: given {unknown[0]!r}; the runs have {', '.join(sorted(known))}")
    shown = [name for name in columns if name in known]
    table = Table()
    for name in ("run", *shown):
        table.add_column(name.replace("_", " "), overflow="fold")
    for row in rows:
        table.add_row(row["run"], *[_text(row[name]) for name in shown])
    console = Console()
    console.print(table)
    console.print(f"{len(rows)} runs")


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    return "-" if math.isnan(float(value)) else f"{float(value):.4g}"


def _plain(value: Any) -> Any:
    if isinstance(value, str):
        return value
    return float(value) if math.isfinite(float(value)) else None

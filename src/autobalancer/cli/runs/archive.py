"""``autobalancer chamber archive``: what is in a folder of runs, which of them, and one of them as a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.cli.terminal.sheet import Column


def archive(
    folder: Annotated[Path, typer.Argument(help="Folder of the archive.")],
    where: Annotated[str, typer.Option(help='Condition, such as "friction >= 0.5 and balls in [8, 9]".')] = "",
    show: Annotated[
        list[str] | None,
        typer.Option(help="Column of the table. May be repeated. By default parameters and the main measures."),
    ] = None,
    export: Annotated[str, typer.Option(help="Name of a run to write as one result file.")] = "",
    out: Annotated[
        Path | None, typer.Option(help="With --export: the file, .nc; by default the name of the run here.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of --y over --x: .png, .svg or .pdf.")] = None,
    x: Annotated[str, typer.Option(help="Value along the axis of the picture.")] = "balls",
    y: Annotated[str, typer.Option(help="Value of the picture.")] = "vertical_amplitude",
    by: Annotated[str, typer.Option(help="Value that tells the curves apart.")] = "",
    log: Annotated[bool, typer.Option(help="Logarithmic scale of y.")] = False,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """List the runs of an archive, choose among them, draw their measures, or take one out.

    Example: autobalancer chamber archive runs --where "friction >= 0.5" \\
      --plot a.png --x balls --y vertical_amplitude --by friction
    """
    from autobalancer.cli.terminal.output import RESULT, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.results.archive.folder import Archive

    one_form(as_json, as_csv)
    if out is not None and not export:
        raise QuestionError("--out: is the file of --export; name the run to write")
    files = Files(out, plot, RESULT)
    if not folder.is_dir():
        raise QuestionError(f"{folder}: no such folder; archives are made by autobalancer chamber with --archive")
    if (folder / "run.json").exists():
        raise QuestionError(f"{folder}: is one run; its archive is {folder.parent}, and autobalancer plot draws it")
    held = Archive(folder)
    if not held.names():
        raise QuestionError(f"{folder}: holds no runs; archives are made by autobalancer chamber with --archive")
    if export:
        typer.echo(f"written: {held.export(export, out if out is not None else Path(f'{export}.nc'))}")
        return
    table = held.runs(where)
    if plot is not None:
        from autobalancer.plots.drawing.save import save_picture

        save_picture(ab.plot.chamber_archive(table, x, y, by or None, log=log), plot)
    if as_json:
        names = [str(key) for key in table.data_vars]
        rows = zip(table["run"].values, *(table[key].values for key in names), strict=True)
        print_json([dict(zip(("run", *names), row, strict=True)) for row in rows])
        return
    columns = _columns(table, show)
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns)
    typer.echo(f"{table.sizes['run']} runs")
    files.say()


MAIN = ["state", "balls", "friction", "layers", "vertical_amplitude", "vertical_peak", "settling_time", "share_carried"]
SHOWN = {"m": ("µm", 1e6), "kg m": ("g mm", 1e6), "rad": ("deg", 180.0 / math.pi)}


def _columns(table: xr.Dataset, asked: list[str] | None) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.errors import QuestionError

    known = [str(key) for key in table.data_vars]
    unknown = [name for name in asked or () if name not in known]
    if table.sizes["run"] and unknown:
        raise QuestionError(f"--show: given {unknown[0]!r}; the runs have {', '.join(sorted(known))}")
    columns = [Column("run", [str(name) for name in table["run"].values])]
    for name in (name for name in asked or MAIN if name in known):
        unit, factor = SHOWN.get(
            str(table[name].attrs.get("units", "")), (str(table[name].attrs.get("units", "")), 1.0)
        )
        values: list[Any] = [value if isinstance(value, str) else float(value) * factor for value in table[name].values]
        columns.append(Column(name.replace("_", " "), values, "" if unit == "1" else unit, ".4g"))
    return columns

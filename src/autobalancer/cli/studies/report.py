"""``autobalancer report``: a machine on pages that can be signed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import Json, MachineFile, Seed


def report(
    machine: MachineFile,
    out: Annotated[
        Path | None,
        typer.Option(help="The report: .html or .pdf; by default the machine's name with _report.html here."),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option(help="Result file of 'autobalancer study' of this machine, or of 'autobalancer design'."),
    ] = None,
    grade: Annotated[str, typer.Option(help='Balance quality that is asked for, such as "G 2.5" or 2.5 (mm/s).')] = "",
    measured: Annotated[
        Path | None, typer.Option(help="What was measured during the run-up: as for 'compare'.")
    ] = None,
    starts: Annotated[int, typer.Option(min=0, help="Random starts of the balls; 0 for none.")] = 200,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Write a report of a machine: what it is, what it does, how sure that is, as one HTML file or a PDF.

    Example: autobalancer report discoidal.toml --grade "G 2.5" --out discoidal.pdf
    """
    import autobalancer as ab
    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.progress import progress_bar

    path = out if out is not None else Path(f"{machine.stem}_report.html")
    with progress_bar("pages") as update:
        ab.report(
            machine,
            path,
            study=study,
            grade=grade or None,
            measured=measured,
            starts=starts,
            seed=seed,
            progress=update,
        )
    if as_json:
        print_json({"machine": str(machine), "report": str(path)})
    else:
        typer.echo(f"written: {path}")

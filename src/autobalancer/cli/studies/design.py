"""``autobalancer design``: the balancer for a rotor, from a specification file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import Csv, Json, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say, speed_sign


def design(
    file: Annotated[Path, typer.Argument(help="Specification file (TOML).", metavar="SPEC")],
    folder: Annotated[
        Path | None,
        typer.Option(help="Where finished runs are kept; by default the name of the file with _parts here."),
    ] = None,
    machines: Annotated[
        int, typer.Option(min=0, help="Machine files of so many designs, the best first, under the name of the file.")
    ] = 1,
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
    """Find the balancer for a rotor: which race, how many balls, which fluid, with which margins.

    Finished runs are kept in a folder: after Ctrl-C or a crash the same command goes on, with the same numbers.

    Example: autobalancer design centrifuge_design.toml --plot front.png
    """
    import autobalancer as ab
    from autobalancer.cli.terminal.output import Files, file_to_read, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.files.machine_file import save_machine

    one_form(as_json, as_csv)
    file_to_read(file)
    files = Files(out if out is not None else Path(f"{file.stem}.nc"), plot)
    made = Files([Path(f"{file.stem}_{place}.toml") for place in range(1, machines + 1)], allowed=(".toml",))
    parts = folder if folder is not None else Path(f"{file.stem}_parts")
    with _said_when_stopped(parts), progress_bar("runs") as update:
        found = ab.design(
            file,
            folder=parts,
            workers=workers or None,
            progress=update,
        )
    files.save(found, lambda: ab.plot.design(found))
    made.out = made.out[: found.best().sizes["design"]]
    for place, path in enumerate(made.out, start=1):
        save_machine(ab.designed_machine(found, place), path)
    if as_json:
        print_json({str(name): found[name].values for name in found.in_si().variables})
    elif as_csv:
        print_csv(found.columns(speed_sign()))
    else:
        print_facts(found.facts(), found.heading())
        print_sheet(found.columns(speed_sign()))
        for line in found.remarks():
            say(line, indent="  ")
        files.say()
        made.say()


@contextmanager
def _said_when_stopped(parts: Path) -> Iterator[None]:
    """Says where the finished runs are, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        if parts.is_dir():
            where = f"interrupted; finished runs are kept in {parts}, and the same command goes on"
            typer.secho(where, fg="yellow", err=True)
        raise

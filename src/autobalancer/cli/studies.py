"""Commands that run studies and decide by them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, Seed, SpeedUnit, Unit
from autobalancer.cli.terminal.sheet import say, speed_sign

# ``autobalancer study``: what varies and how it scatters, from a file, run until enough is known.


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
    from autobalancer.cli.terminal.command import Files, file_to_read, one_form, print_csv, print_json
    from autobalancer.cli.terminal.group import stop_code
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.results.export import plain_json

    def drawn(found: Any) -> Any:
        if sensitivity:
            return ab.plot.sensitivity(ab.sensitivity(found, sensitivity))
        return ab.plot.study(found, quantity, speed_unit=speed_unit)

    one_form(as_json, as_csv)
    file_to_read(file)
    _refuse_before(file, sensitivity, quantity if plot is not None else "")
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


def _refuse_before(file: Path, sensitivity: str, drawn: str) -> None:
    """Refuse quantities that the study will not have, and answers that it cannot give, before it runs."""
    from autobalancer.errors import QuestionError
    from autobalancer.studies.study.chunk import quantity_kind
    from autobalancer.studies.study.reading import read_study
    from autobalancer.studies.study.sensitivity import refuse_without_sensitivity

    asked = read_study(file)
    for option, name in (("sensitivity", sensitivity), ("quantity", drawn)):
        if name and name not in ALSO:
            try:
                quantity_kind(name, asked.results)
            except QuestionError as reason:
                raise QuestionError(f"--{option}: {reason}") from None
    if sensitivity:
        try:
            refuse_without_sensitivity(asked)
        except QuestionError as reason:
            raise QuestionError(f"{file}: {reason}") from None
    elif drawn and len(asked.grid) > 2:
        raise QuestionError(
            f"--plot: the grid of {file} has {len(asked.grid)} parameters, and two can be drawn; run it without --plot, and draw "
            "parts of it in Python with .where"
        )


# ``autobalancer design``: the balancer for a rotor, from a specification file.


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
    from autobalancer.cli.terminal.command import Files, file_to_read, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress_bar import progress_bar
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


# ``autobalancer envelopes``: how far a machine goes on its way up, as percentiles over many runs.


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
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress_bar import progress_bar
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


# ``autobalancer report``: a machine on pages that can be signed.


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
    from autobalancer.cli.terminal.command import print_json
    from autobalancer.cli.terminal.progress_bar import progress_bar

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

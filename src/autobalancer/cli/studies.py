"""Commands that run studies and decide by them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import (
    MACHINE,
    Also,
    Files,
    Reply,
    as_plain,
    command,
    file_to_read,
    said_when_stopped,
)
from autobalancer.cli.terminal.options import MachineFile
from autobalancer.cli.terminal.sheet import speed_sign
from autobalancer.errors import QuestionError

Folder = Annotated[Path | None, "Where finished parts are kept; by default the name of the file with _parts here."]

# ``autobalancer study``: what varies and how it scatters, from a file, run until enough is known.


ALSO = ("balanced", "balanced_before", "steps", "drawn_again")  # are drawn, too, where a study has them


@command("study", take="scheduler workers", draw="", out=".nc", unit="speed", bar="members")
def study(
    file: Annotated[Path, typer.Argument(help="Study file (TOML).", metavar="STUDY")],
    folder: Folder = None,
    sensitivity: Annotated[
        str, "Also say which scatter drives that of this quantity, such as peak_deflection. --plot shows that then."
    ] = "",
    quantity: Annotated[
        str, "What the picture of --plot shows, such as settling_time; by default the share of balanced runs."
    ] = "balanced",
    files: Any = None,
    **options: Any,
) -> Reply:
    """Run a machine many times with values from a grid and from distributions, as a study file says.

    Finished parts are kept in a folder: after Ctrl-C or a crash the same command goes on, with the same numbers.

    Example: autobalancer study oil_study.toml --sensitivity peak_deflection
    """
    file_to_read(file)
    _refuse_before(file, sensitivity, quantity if files.plot is not None else "")
    parts = folder if folder is not None else Path(f"{file.stem}_parts")
    found = ab.study(file, folder=parts, keep_on_interrupt=True, **options)
    driven = ab.sensitivity(found, sensitivity) if sensitivity else None
    columns = found.columns(speed_sign()) if driven is None else driven.columns()

    def draw() -> Any:
        if driven is not None:
            return ab.plot.sensitivity(driven)
        return ab.plot.study(found, quantity, speed_unit=speed_sign())

    lines = [line for line in found.remarks() if not line.startswith("interrupted")]  # said with what to do here
    return Reply(
        found,
        {"study": str(file), **{column.head: column.values for column in columns}},
        "",
        (),
        columns,
        brief=driven is not None,
        more=[("", found.columns(speed_sign())), (driven.heading(), columns)] if driven is not None else [],
        lines=[*lines, *(driven.remarks() if driven is not None else ())],
        notes=(),
        draw=draw,
        outcome="interrupted" if found.attrs["stopped_by"] == "interrupted" else "",
        stopped="the same command goes on",
    )


def _refuse_before(file: Path, sensitivity: str, drawn: str) -> None:
    """Refuse quantities that the study will not have, and answers that it cannot give, before it runs."""
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


@command("design", take="workers", draw="design", out=".nc", unit="speed", bar="runs")
def design(
    file: Annotated[Path, typer.Argument(help="Specification file (TOML).", metavar="SPEC")],
    folder: Folder = None,
    machines: Annotated[
        int, typer.Option(min=0, help="Machine files of so many designs, the best first, under the name of the file.")
    ] = 1,
    **options: Any,
) -> Reply:
    """Find the balancer for a rotor: which race, how many balls, which fluid, with which margins.

    Finished runs are kept in a folder: after Ctrl-C or a crash the same command goes on, with the same numbers.

    Example: autobalancer design centrifuge_design.toml --plot front.png
    """
    file_to_read(file)
    made = [Files(Path(f"{file.stem}_{place}.toml"), allowed=MACHINE) for place in range(1, machines + 1)]
    parts = folder if folder is not None else Path(f"{file.stem}_parts")
    with said_when_stopped(f"finished runs are kept in {parts}, and the same command goes on", parts):
        found = ab.design(file, folder=parts, **options)
    written = made[: found.best().sizes["design"]]
    also = [Also(each, machine=ab.designed_machine(found, place)) for place, each in enumerate(written, start=1)]
    return Reply(found, as_plain(found.in_si()), lines=found.remarks(), notes=(), also=also)


# ``autobalancer envelopes``: how far a machine goes on its way up, as percentiles over many runs.


@command("envelopes", take="members point coast_down seed", draw="envelopes", unit="speed", bar="runs")
def envelopes(
    file: Annotated[Path, typer.Argument(help="Study file, or a machine file, whose balls start anywhere.")],
    **options: Any,
) -> Reply:
    """Run a machine many times and say which deflection 5, 25, 50, 75 and 95 % of the runs stay below, over the time.

    Example: autobalancer envelopes discoidal.toml --members 40 --coast-down --plot fan.png
    """
    found = ab.envelopes(file, **options)
    columns = found.columns(speed_sign())
    return Reply(found, {column.head: column.values for column in columns}, "", (), columns, notes=())


# ``autobalancer report``: a machine on pages that can be signed.


@command("report", take="starts seed", out=None, csv=False, bar="pages")
def report(
    machine: MachineFile,
    out: Annotated[
        Path | None, "The report: .html or .pdf; by default the machine's name with _report.html here."
    ] = None,
    study: Annotated[
        Path | None, "Result file of 'autobalancer study' of this machine, or of 'autobalancer design'."
    ] = None,
    grade: Annotated[str | None, 'Balance quality that is asked for, such as "G 2.5" or 2.5 (mm/s).'] = None,
    measured: Annotated[Path | None, "What was measured during the run-up: as for 'compare'."] = None,
    **options: Any,
) -> Reply:
    """Write a report of a machine: what it is, what it does, how sure that is, as one HTML file or a PDF.

    Example: autobalancer report discoidal.toml --grade "G 2.5" --out discoidal.pdf
    """
    path = out if out is not None else Path(f"{machine.stem}_report.html")
    ab.report(machine, path, study=study, grade=grade, measured=measured, **options)
    return Reply(None, {"report": str(path)}, code=f"written: {path}")

"""Commands that run a machine many times, or several machines: how the runs end, side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import (
    MACHINE,
    Files,
    FurtherFiles,
    Reply,
    as_plain,
    command,
    file_to_read,
    on_interrupt,
)
from autobalancer.cli.terminal.options import In, MachineFile, Seed
from autobalancer.cli.terminal.sheet import sheet_si, speed_sign
from autobalancer.errors import QuestionError

QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)
SURE = "95 %: the share of very many {} is in this interval with a probability of 95 %"

TOPIC = "Many runs"  # where the help of autobalancer lists the commands below


# ``autobalancer ensemble``: thousands of run-ups of one machine, and how they end.


@command(
    "ensemble",
    take="seeds seed duration:s tolerance settling_from workers",
    draw=True,
    out="_ensemble.nc",
    unit="speed",
    bar="members",
)
def ensemble(
    machine: MachineFile,
    column: Annotated[
        list[str] | None, 'What varies: "NAME=values", such as "drag=1e-4,2e-4 N*m*s"; may be repeated.'
    ] = None,
    table: Annotated[Path | None, "Text file with a column for each name; its first line has names and units."] = None,
    measures: Annotated[
        str, 'What to find of each member, such as "verdict,settling_time"; "all", or "none": only the ends.'
    ] = "all",
    record: Annotated[
        bool, typer.Option("--record-impossible", help="Note members that no machine can be, and run the others.")
    ] = False,
    **options: Any,
) -> Reply:
    """Run a machine thousands of times, each time with its own numbers, and count how the runs end.

    A NAME is a plain name such as viscosity, a path such as rotor.mass, ball_angle[1], ball_speed[1] or seed.
    All columns have the same length, or one value for all. Ctrl-C keeps the members that are done.

    Example: autobalancer ensemble stall_and_release.toml \\
      --column "drag=1e-4,2e-4 N*m*s" --seeds 10 --plot ensemble.png
    """
    from autobalancer.files.machine_file import load_race_machine

    if column and table is not None:
        raise QuestionError("--column, --table: give columns here or in a table, not both")
    described = load_race_machine(machine)
    columns = dict(_column(described, text) for text in column or ())
    names = [name.strip() for name in measures.split(",") if name.strip()]
    found = ab.ensemble(
        described,
        table if table is not None else columns or None,
        measures={"all": None, "none": []}.get(measures.strip(), names),
        impossible="record" if record else "refuse",
        keep_on_interrupt=True,
        **options,
    )
    numbers = {"members": found.sizes["member"], "seed": options["seed"], **_numbers(found)}
    return Reply(
        found,
        numbers,
        "",
        (),
        lines=[SURE.format("members"), *found.remarks()],
        notes=(),
        outcome="interrupted" if found.attrs["outcome"] == "interrupted" else "",
        stopped="the members that were done are kept",
    )


def _column(machine: Any, text: str) -> tuple[str, list[Any]]:
    """The name and the values of an option, read with the unit of the name."""
    from autobalancer.cli.terminal.options import named_range
    from autobalancer.studies.ensemble.columns import SEED, unit_of_column
    from autobalancer.units.quantity import listed, whole_numbers

    name, values = named_range("--column", text)
    if name == SEED:
        return name, list(whole_numbers("--column", values))
    return name, [float(value) for value in listed("--column", values, unit_of_column(machine, name))]


def _numbers(found: Any) -> dict[str, Any]:
    """Shares, and quantiles of the measures, SI."""
    shares = found.shares()
    ends = {
        str(end): {name: float(shares[name].sel(end=end)) for name in ("count", "share", "share_low", "share_high")}
        for end in shares["end"].values
    }
    measures = [name for name in found.data_vars if found[name].dims == ("member",) and found[name].dtype.kind == "f"]
    spread = {
        str(name): dict(zip(map(str, QUANTILES), found.quantiles(name, QUANTILES).tolist(), strict=True))
        for name in measures
    }
    return {"share": ends, "quantile": spread}


# ``autobalancer basin``: which end state follows from which start.


WORST = {
    "vibration": "the greatest vibration,",
    "peak_deflection": "the greatest deflection on the way (all balance),",
    "final_deflection": "the greatest deflection at its end,",
}


@command(
    "basin", take="random seed acceleration:rad/s^2 hold:s", draw=True, unit="speed", bar="runs", topic="Stability"
)
def basin(
    machine: MachineFile,
    speed: Annotated[float, In("rad/s"), 'Final rotor speed, such as "1200 rpm".'],
    x: Annotated[str, 'Starts along x: "NAME=from:to:count"; see below.'] = "",
    y: Annotated[str, "Starts along y, in the same form."] = "",
    worst: Annotated[Path | None, "Machine file (.toml) of the worst random start, to run it again."] = None,
    **options: Any,
) -> Reply:
    """Run a machine from many starts and say in percent where it ends.

    A NAME is ball_angle[1], ball_speed[1] or the same of another ball, or acceleration.
    On several planes each plane has an end state and a residual of its own.
    With gravity across the axis an end is the verdict on a run.
    So it is in run-ups from random starts.

    Example: autobalancer basin discoidal.toml \\
      --speed "1200 rpm" --random 50 --acceleration "10 rad/s^2" \\
      --plot basin.png --worst worst.toml
    """
    from autobalancer.results.verdict import NO_VERDICT, NOT_SETTLED
    from autobalancer.studies.random_starts import worst_start

    again, random, seed = Files(worst, allowed=MACHINE), options["random"], options["seed"]
    if worst is not None and not random:
        raise QuestionError("--worst: the worst is one of random starts; give their number, such as --random 50")
    axes = dict(_axis(option, text) for option, text in (("--x", x), ("--y", y)) if text)
    found = ab.basin(machine, speed, axes or None, **options)
    shares = {str(name): float(found["share"].sel(end=name)) for name in found["end"].values}
    runs, overlapping = int(found["state"].size), int(found.attrs.get("overlapping", 0))
    left = _end_values(found)
    drawn = {"seed": seed, "worst_start": _worst(found)} if random else {"overlapping_starts": overlapping}
    late = [word for word in (NO_VERDICT, NOT_SETTLED) if shares.get(word)]
    changing = f"runs with the end {' or '.join(map(repr, late))} still change; give a longer --hold" if late else ""
    ignored = f"ignores {found.attrs['ignores']}" if found.attrs.get("ignores") else ""
    lines = [SURE.format("starts")] if random else []
    lines += [_counted(runs, overlapping, seed if random else None), *found.left()]
    lines += [_worst_line(found)] if random else []
    code = ""
    if worst is not None:
        own = f" --seed {int(found['seed'][int(found.attrs['worst'])])}" if "seed" in found else ""
        code = f"run it again: autobalancer simulate {worst}{own}"
    return Reply(
        found,
        {"runs": runs, **drawn, "share": shares, **left},
        "",
        (),
        lines=lines,
        code=code,
        notes=[text for text in (changing, *left["remarks"], ignored) if text],
        also=[FurtherFiles(again, found, machine=worst_start(found) if worst is not None else None)],
    )


def _counted(runs: int, overlapping: int, seed: int | None) -> str:
    if seed is not None:
        return f"{runs} runs, random starts of seed {seed}; none puts balls on top of each other"
    if overlapping:
        return f"{runs} starts; {overlapping} of them put balls on top of each other and are not counted in the shares"
    return f"{runs} starts"


def _worst(found: Any) -> dict[str, Any]:
    """The worst start: its number, counted from 1, by which quantity, and this, m."""
    place, name = int(found.attrs["worst"]), str(found.attrs["worst_by"])
    return {"number": place + 1, "by": name, "value": float(found[name][place])}


def _worst_line(found: Any) -> str:
    from autobalancer.results.display_units import length_text

    worst, count = _worst(found), int(found["state"].size)
    return f"worst start: number {worst['number']} of {count}, with {WORST[worst['by']]} {length_text(worst['value'])}"


def _end_values(found: Any) -> dict[str, Any]:
    """What the ends leave, SI."""

    def plain(name: str) -> Any:
        return found[name].values.tolist()

    quantiles, of = [str(float(q)) for q in found["quantile"].values], found["quantile_starts"]
    left: dict[str, Any] = {
        "quantile_starts": {"count": int(of), "of": int(of.attrs["of"]), "which": of.attrs["long_name"]},
        "residual_unbalance": dict(zip(quantiles, plain("residual_quantile"), strict=True)),
        "unbalance": plain("unbalance"),
        "released": str(found.attrs["released"]),
        "remarks": found.attrs["remarks"],
    }
    if "verdict_share" in found:
        left["verdict_share"] = dict(zip(found["verdict"].values.tolist(), plain("verdict_share"), strict=True))
    if found.planes():
        left["planes"] = found.planes()
    for name in ("moving_share", "stalled_share", "residual_starts"):
        if name in found:
            left[name] = plain(name)
    for name in ("deflection", "vibration", "peak"):
        if f"{name}_quantile" in found:
            left[name] = dict(zip(quantiles, plain(f"{name}_quantile"), strict=True))
            left[f"{name}_without_balls"] = plain(f"{name}_without_balls")
    return left


def _axis(option: str, text: str) -> tuple[str, list[float]]:
    from autobalancer.cli.terminal.options import named_range
    from autobalancer.stability.basins import unit_of_axis
    from autobalancer.units.quantity import range_values

    name, span = named_range(option, text)
    return name, [float(value) for value in range_values(option, span, unit_of_axis(name))]


# ``autobalancer compare``: several machines side by side, or a run and what was measured.


@command(draw=True, unit="speed", topic="Files and results")
def compare(
    machines: Annotated[
        list[Path],
        typer.Argument(
            help="Machine files, in the order of the table. Or a run (.nc) and a file of signals, orders or ball angles."
        ),
    ],
    at: Annotated[
        list[float] | None,
        In("rad/s"),
        'Speed at which the deflection is wanted too, such as "40 rad/s". May be repeated.',
    ] = None,
    duration: Annotated[float | None, In("s"), 'Such as "60 s"; by default that of each machine.'] = None,
    tolerance: Annotated[float, "Relative error per step."] = 1e-8,
    seed: Seed = 0,
) -> Reply:
    """Run several machines and put side by side what each run left, and from which speed on it balances.

    Of a run (.nc) and a measurement: the same curves and the same measures of both.

    Example: autobalancer compare variant_plain.toml variant_pins.toml \\
      --at "40 rad/s" --plot variants.png
    """
    from autobalancer.cli.terminal.progress_bar import progress_bar

    if machines[0].suffix.lower() == ".nc":
        return _overlay(machines, seed)
    runs = [path for path in machines if path.suffix.lower() == ".nc"]
    if runs:
        raise QuestionError(f"{runs[0]}: a run comes first, and then what was measured")
    with progress_bar("machines") as update:
        found: Any = ab.compare(
            machines, at=at or [], duration=duration, tolerance=tolerance, seed=seed, progress=update
        )
    numbers = {str(name): part.values for name, part in found.variables.items() if "bin" not in part.dims}
    return Reply(found, numbers, facts=())


def _overlay(paths: list[Path], seed: int) -> Reply:
    """A run and a measurement."""
    if len(paths) != 2:
        raise QuestionError("compare: after a run give one measurement: a table of signals or orders, or an .nc file")
    from autobalancer.measurement.run_up_fit import load_measured

    found: Any = ab.compare(ab.load_run(paths[0]), load_measured(paths[1]), seed=seed)
    names = (name for name, part in found.variables.items() if not {"time", "order_time"} & set(part.dims))
    return Reply(
        found,
        {str(name): found[name].values for name in names} | {"notes": found.remarks()},
        columns=found.columns(speed_sign()) if found.sizes["measure"] else [],
    )


# Commands that run studies and decide by them.


Folder = Annotated[Path | None, "Where finished parts are kept; by default the name of the file with _parts here."]

# ``autobalancer study``: what varies and how it scatters, from a file, run until enough is known.


FURTHER_COLUMNS = ("balanced", "balanced_before", "steps", "drawn_again")  # are drawn, too, where a study has them


@command("study", take="scheduler workers", draw=True, out=".nc", unit="speed", bar="members")
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
            return ab.plot.answer(driven)
        return ab.plot.answer(found, quantity=quantity, speed_unit=speed_sign())

    lines = [line for line in found.remarks() if not line.startswith("interrupted")]  # said with what to do here
    return Reply(
        found,
        {"study": str(file), **sheet_si(columns)},
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
    from autobalancer.studies.study.study import refuse_without_sensitivity
    from autobalancer.studies.study.study_file import read_study

    asked = read_study(file)
    for option, name in (("sensitivity", sensitivity), ("quantity", drawn)):
        if name and name not in FURTHER_COLUMNS:
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


@command("design", take="workers", draw=True, out=".nc", unit="speed", bar="runs")
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
    with on_interrupt(f"finished runs are kept in {parts}, and the same command goes on", parts):
        found = ab.design(file, folder=parts, **options)
    written = made[: found.best().sizes["design"]]
    also = [
        FurtherFiles(each, machine=ab.designed_machine(found, place)) for place, each in enumerate(written, start=1)
    ]
    return Reply(found, as_plain(found.in_si()), lines=found.remarks(), notes=(), also=also)


# ``autobalancer envelopes``: how far a machine goes on its way up, as percentiles over many runs.


@command("envelopes", take="members point coast_down seed", draw=True, unit="speed", bar="runs")
def envelopes(
    file: Annotated[Path, typer.Argument(help="Study file, or a machine file, whose balls start anywhere.")],
    **options: Any,
) -> Reply:
    """Run a machine many times and say which deflection 5, 25, 50, 75 and 95 % of the runs stay below, over the time.

    Example: autobalancer envelopes discoidal.toml --members 40 --coast-down --plot fan.png
    """
    found = ab.envelopes(file, **options)
    return Reply(found, heading="", facts=(), notes=())


# ``autobalancer report``: a machine on pages that can be signed.


@command("report", take="grade starts seed", out=None, csv=False, bar="pages", topic="Files and results")
def report(
    machine: MachineFile,
    out: Annotated[
        Path | None, "The report: .html or .pdf; by default the machine's name with _report.html here."
    ] = None,
    study: Annotated[
        Path | None, "Result file of 'autobalancer study' of this machine, or of 'autobalancer design'."
    ] = None,
    measured: Annotated[Path | None, "What was measured during the run-up: as for 'compare'."] = None,
    **options: Any,
) -> Reply:
    """Write a report of a machine: what it is, what it does, how sure that is, as one HTML file or a PDF.

    Example: autobalancer report discoidal.toml --grade "G 2.5" --out discoidal.pdf
    """
    path = out if out is not None else Path(f"{machine.stem}_report.html")
    ab.report(machine, path, study=study, measured=measured, **options)
    return Reply(None, {"report": str(path)}, code=f"written: {path}")

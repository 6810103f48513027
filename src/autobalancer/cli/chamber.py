"""``autobalancer chamber``: questions to a deep chamber that take many runs, or one long one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, Seed, optional, quantity
from autobalancer.units.quantity import listed, whole

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.tables import Column


app = typer.Typer(
    help="Studies of machines with deep chambers: amplitudes over balls and friction, the best design, reactions, step size.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

Step = Annotated[str, typer.Option(help='Of the integration, such as "1e-6 s"; by default from the contact time.')]
Last = Annotated[str, typer.Option(help="Time at the end that is the steady state; by default a tenth.")]


@app.command()
def amplitudes(
    machine: Annotated[Path, typer.Argument(help="Machine file with one deep chamber.")],
    balls: Annotated[
        str, typer.Option(help='Numbers of balls in the deep chamber, such as "3,5,8,20"; none for none.')
    ],
    friction: Annotated[str, typer.Option(help='Coefficients, such as "0.3,0.5,0.7".')],
    duration: Annotated[str, typer.Option(help='Of each run, such as "20 s".')],
    single: Annotated[
        str, typer.Option(help="Numbers of balls in the single layer; by default the same, none for none.")
    ] = "",
    archive: Annotated[Path | None, typer.Option(help="Folder that keeps all runs; a stopped study goes on.")] = None,
    step: Step = "",
    last: Last = "",
    seeds: Annotated[int, typer.Option(min=1, help="Fillings for each point; pictures show mean and range.")] = 1,
    workers: Annotated[int, typer.Option(min=0, help="Threads; 0 for one each core.")] = 0,
    out: Outs = None,
    plot: Plot = None,
    means: Annotated[Path | None, typer.Option(help="Picture of the means over the optimal ranges.")] = None,
    carried: Annotated[
        Path | None, typer.Option(help="Picture of the share of balls carried over friction, for each number.")
    ] = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Vibration over number of balls and friction at equal total mass, deep chamber against single layer.

    Without --out the result is written here, under the machine's name with _amplitudes.nc.

    Example: autobalancer chamber amplitudes deep_chamber.toml \\
      --balls 3,8,20,50 --single 3,5,8,10 --friction 0.3,0.5,0.7 \\
      --duration "20 s" --archive runs --plot amplitudes.png
    """
    from autobalancer.errors import QuestionError
    from autobalancer.studies.chamber_study import optimal_means

    deep = [] if balls == "none" else whole("--balls", balls)
    other = [] if single == "none" else whole("--single", single) if single else deep
    if not deep and not other:
        raise QuestionError("--balls, --single: given none for both; give numbers of balls for one of them")
    counts = {layer: numbers for layer, numbers in (("deep", deep), ("single", other)) if numbers}
    one_form(as_json, as_csv)
    files = Files(out or Path(f"{machine.stem}_amplitudes.nc"), plot)
    others = [Files(plot=path) for path in (means, carried)]
    with asked_of(machine), bar("runs") as update, said_when_stopped(archive is not None):
        found = ab.chamber.amplitudes(
            chamber_machine(machine),
            counts,
            listed("--friction", friction, ""),
            duration=quantity("--duration", duration, "s"),
            layers=list(counts),
            archive=archive,
            step=optional("--step", step, "s"),
            seeds=range(seeds),
            last=optional("--last", last, "s"),
            workers=workers or None,
            progress=update,
        )
    files.save(found, lambda: ab.plot.chamber_amplitudes(found))
    others[0].save(found, lambda: ab.plot.chamber_optimal_means(optimal_means(found)))
    others[1].save(found, lambda: ab.plot.chamber_carried(found))
    _say_what_failed(found)
    if as_json:
        print_json({str(name): found[name].values for name in found.variables})
    elif as_csv:
        from autobalancer.results.export import result_csv

        typer.echo(result_csv(found), nl=False)
    else:
        for one in (files, *others):
            one.say()


@app.command()
def reactions(
    machine: Annotated[Path, typer.Argument(help="Machine file with chambers.")],
    duration: Annotated[str, typer.Option(help='Such as "20 s".')],
    archive: Annotated[Path, typer.Option(help="Folder that keeps the run; the same command goes on after a stop.")],
    name: Annotated[str, typer.Option(help="Name of the run; by default that of the file.")] = "",
    step: Step = "",
    seed: Seed = 0,
    last: Last = "",
    height: Annotated[
        str, typer.Option(help="Height of the axis over the supports: draws the body of the source let go.")
    ] = "",
    until: Annotated[str, typer.Option(help="Time after which reactions do not drive the body that is let go.")] = "",
    out: Annotated[Path, typer.Option(help="Folder of the pictures.")] = Path("."),
    as_json: Json = False,
) -> None:
    """One run into an archive, with pictures: history, energy, collisions, reactions, arrangement of the balls.

    Example: autobalancer chamber reactions deep_chamber.toml \\
      --duration "20 s" --archive runs --height "0.2 m" --out pictures
    """
    from autobalancer.plots.drawing.style import save_picture
    from autobalancer.results.archive import Archive
    from autobalancer.results.unconstrained_body import pakula_body
    from autobalancer.studies.chamber_study import archived_run

    with bar("thousandths of the run") as update, said_when_stopped():
        run = archived_run(
            Archive(archive),
            name or machine.stem,
            chamber_machine(machine),
            duration=quantity("--duration", duration, "s"),
            step=optional("--step", step, "s"),
            seed=seed,
            last=optional("--last", last, "s"),
            progress=lambda now, end: update(round(1000.0 * now / end), 1000),
        )
    samples = run.samples().load()
    body = pakula_body(quantity("--height", height, "m")) if height else None
    pictures = {
        "history": ab.plot.chamber_run(samples),
        "energy": ab.plot.chamber_energy(samples),
        "collisions": ab.plot.chamber_collisions(samples),
        "bearings": ab.plot.chamber_bearing_forces(samples),
        "reactions": ab.plot.chamber_reactions(samples, body, until=optional("--until", until, "s")),
        "arrangement": ab.plot.chamber_arrangement(samples),
    }
    made = [save_picture(figure, out / f"{run.name}_{kind}.png") for kind, figure in pictures.items()]
    if as_json:
        outcome, measured = run.note.outcome, run.note.measures
        print_json({"run": str(run.path), **outcome, "seed": seed, "measures": measured, "pictures": made})
        return
    typer.echo(f"run {run.name}: {run.note.outcome['outcome_text']}, seed {seed}, in {run.path}")
    for path in made:
        typer.echo(f"written: {path}")


@app.command("step-size")
def step_size(
    stiffness_over_mass: Annotated[float, typer.Option(help="k/m of a ball in m^-0.5 s^-2.")] = 1e10,
    speeds: Annotated[str, typer.Option(help="Relative speeds.")] = "4,6,8,10 m/s",
    steps: Annotated[str, typer.Option(help="Steps of the integration.")] = "1e-4,1e-5,1e-6,1e-7 s",
    restitution: Annotated[float, typer.Option(help="1 for elastic balls.")] = 1.0,
    phases: Annotated[int, typer.Option(min=1, help="Collisions for each speed and step.")] = 200,
    scheme: Annotated[str, typer.Option(help="runge_kutta or velocity_verlet.")] = "runge_kutta",
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Energy error of a fixed step in a central collision, for contacts that begin anywhere in a step.

    Example: autobalancer chamber step-size --stiffness-over-mass 3e9 --plot steps.png
    """
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.tables import Column

    one_form(as_json, as_csv)
    files = Files(out, plot)
    with bar("collisions") as update:
        found = ab.chamber.step_size(
            listed("--speeds", speeds, "m/s"),
            listed("--steps", steps, "s"),
            stiffness_over_mass=stiffness_over_mass,
            restitution=restitution,
            phases=phases,
            scheme=scheme,
            progress=update,
        )
    files.save(found, lambda: ab.plot.chamber_step_size(found))
    if as_json:
        print_json({str(name): found[name].values for name in found.variables})
        return
    cells = [(float(speed), float(step)) for speed in found["relative_speed"] for step in found["step"]]
    columns = [
        Column("relative speed", [speed for speed, _ in cells], "m/s", "g"),
        Column("step", [step for _, step in cells], "s", "g"),
    ]
    for name in ("least", "greatest", "root_mean_square"):
        sizes = [100.0 * float(found[name].sel(relative_speed=speed, step=step)) for speed, step in cells]
        columns.append(Column(name.replace("_", " "), sizes, "%", ".3g"))
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "energy error of a collision")
    files.say()


def chamber_machine(path: Path) -> Any:
    """The machine of a file with deep chambers."""
    from autobalancer.files.machine_file import load_chamber_machine

    return load_chamber_machine(path)


@contextmanager
def asked_of(path: Path) -> Iterator[None]:
    """While it lasts, an error of the machine names the file in place of the word "machine"."""
    from autobalancer.errors import QuestionError

    try:
        yield
    except QuestionError as refused:
        of_machine, mark, reason = str(refused).partition("machine: ")
        if of_machine or not mark:
            raise
        raise QuestionError(f"{path}: {reason}") from None


def bar(text: str) -> Any:
    """A progress bar that is told (done, in all)."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    from autobalancer.cli.terminal.progress_bar import progress_bar

    return progress_bar(text, BarColumn(), MofNCompleteColumn(), TextColumn(text), TimeRemainingColumn())


def _say_what_failed(found: Any) -> None:
    """The points without a result, with the reason; an error where no point has one."""
    from autobalancer.errors import QuestionError
    from autobalancer.studies.chamber_study import NOT_ASKED

    table = found["outcome"].to_series()
    asked = table[table != NOT_ASKED]
    failed = asked[asked != "finished"]
    if len(failed) == len(asked):
        raise QuestionError(f"no point of the study has a result; the first one: {failed.iloc[0]}")
    for place, reason in failed.items():
        where = ", ".join(f"{name} {value}" for name, value in zip(table.index.names, place, strict=True))
        typer.secho(f"no result at {where}: {reason}", fg="yellow", err=True)


@contextmanager
def said_when_stopped(kept: bool = True) -> Iterator[None]:
    """Says what an interruption leaves."""
    try:
        yield
    except KeyboardInterrupt:
        goes_on = "the archive keeps what was computed, and the same command goes on"
        typer.secho(f"interrupted; {goes_on if kept else 'nothing is kept without --archive'}", fg="yellow", err=True)
        raise


@app.command()
def design(
    machine: Annotated[Path, typer.Argument(help="Machine file with one deep chamber.")],
    duration: Annotated[str, typer.Option(help='Of each full run, such as "16 s".')],
    balls: Annotated[str, typer.Option(help='Numbers of balls, such as "5,8,12,20".')] = "",
    diameter: Annotated[str, typer.Option(help='Of a ball, such as "20,25,30 mm".')] = "",
    total_mass: Annotated[
        str, typer.Option(help='Of all balls, such as "0.8,1,1.5 kg"; instead of the diameter.')
    ] = "",
    density: Annotated[str, typer.Option(help='Of the balls, such as "7800,14900 kg/m^3".')] = "",
    friction: Annotated[str, typer.Option(help='Coefficients, such as "0.3,0.5,0.7".')] = "",
    ball_friction: Annotated[
        str, typer.Option(help="The same of balls on balls; by default that of the machine.")
    ] = "",
    viscosity: Annotated[
        str, typer.Option(help='Dynamic, of a fluid, such as "0,10,100 mPa*s"; 0 is a dry chamber.')
    ] = "",
    fluid_density: Annotated[str, typer.Option(help='Of the fluid, such as "900 kg/m^3".')] = "",
    fill: Annotated[str, typer.Option(help='Share of the chamber that the fluid fills, such as "0.6".')] = "",
    unbalance: Annotated[
        str, typer.Option(help='For which a design must work, such as "30,60 kg*mm"; by default that of the machine.')
    ] = "",
    limit: Annotated[
        list[str] | None,
        typer.Option(help='Such as "vibration=20 um", "settling_time=10 s" or "pick_up=0.9". May be repeated.'),
    ] = None,
    short: Annotated[str, typer.Option(help="Of a short run; by default half as long as a full one.")] = "",
    last: Annotated[str, typer.Option(help="Time at the end that is the steady state; by default a tenth.")] = "",
    fillings: Annotated[int, typer.Option(min=1, help="Of each design that gets full runs.")] = 5,
    finalists: Annotated[int, typer.Option(min=1, help="Designs that get full runs.")] = 4,
    around: Annotated[
        list[str] | None,
        typer.Option(
            help='Also run the best design with a quantity changed, such as "unbalance=0.2". May be repeated.'
        ),
    ] = None,
    archive: Annotated[Path | None, typer.Option(help="Folder that keeps all runs; a stopped search goes on.")] = None,
    workers: Annotated[int, typer.Option(min=0, help="Threads; 0 for one each core.")] = 0,
    best: Annotated[Path | None, typer.Option(help="Machine file of the best design, .toml.")] = None,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """The designs that balance best within limits: closed forms first, then short runs, then full runs of the few best.

    Without --out the result is written here, under the machine's name with _designs.nc.

    Example: autobalancer chamber design deep_chamber.toml --duration "16 s" \\
      --balls 5,8,12,20 --total-mass "0.8,1,1.5 kg" --friction 0.5,0.7 \\
      --limit "vibration=30 um" --archive runs --best best.toml --plot designs.png
    """
    from autobalancer.files.machine_file import save_machine

    one_form(as_json, as_csv)
    files = Files(out or Path(f"{machine.stem}_designs.nc"), plot)
    made = Files(best, allowed=(".toml",))
    shelf = {
        "balls": balls,
        "diameter": diameter,
        "total_mass": total_mass,
        "density": density,
        "friction": friction,
        "ball_friction": ball_friction,
        "viscosity": viscosity,
        "fluid_density": fluid_density,
        "fill": fill,
    }
    limits = dict(_pair("--limit", text, "vibration=20 um") for text in limit or ())
    changes = {
        name: quantity("--around", text, "")
        for name, text in (_pair("--around", text, "unbalance=0.2") for text in around or ())
    }
    described = chamber_machine(machine)
    with asked_of(machine), bar("runs") as update, said_when_stopped(archive is not None):
        found = ab.chamber.design(
            described,
            {name: text for name, text in shelf.items() if text},
            limits,
            duration=quantity("--duration", duration, "s"),
            short=optional("--short", short, "s"),
            last=optional("--last", last, "s"),
            unbalances=unbalance or None,
            fillings=fillings,
            finalists=finalists,
            archive=archive,
            workers=workers or None,
            progress=update,
        )
    files.save(found, lambda: ab.plot.chamber_designs(found))
    if best is not None:
        save_machine(ab.chamber.designed_machine(found), best)
    changed = None
    if changes:
        with bar("runs around the best one") as update, said_when_stopped(archive is not None):
            changed = ab.chamber.design_sensitivity(
                found, changes, archive=archive, workers=workers or None, progress=update
            )
    if as_json:
        answer = {str(name): found[name].values for name in found.variables}
        print_json(
            answer if changed is None else {**answer, "around": {str(n): changed[n].values for n in changed.variables}}
        )
    elif as_csv:
        print_csv(found.columns())
    else:
        _show(found, changed)
        files.say()
        made.say()


@app.command()
def bounds(
    machine: Annotated[Path, typer.Argument(help="Machine file with one deep chamber.")],
    as_json: Json = False,
) -> None:
    """What the balls of a deep chamber can do at best, from closed forms, without a run.

    Example: autobalancer chamber bounds deep_chamber.toml
    """
    from autobalancer.cli.terminal.sheet import print_facts, speed_text

    with asked_of(machine):
        found = ab.chamber.bounds(chamber_machine(machine))
    if as_json:
        print_json(found.as_dict())
        return
    print_facts(found.rows(speed_text), found.name)


def _pair(option: str, text: str, sample: str) -> tuple[str, str]:
    from autobalancer.errors import QuestionError

    name, mark, value = (part.strip() for part in text.partition("="))
    if not (name and mark and value):
        raise QuestionError(f'{option}: given {text!r}; write it as NAME=VALUE, such as "{sample}"')
    return name, value


def _show(found: xr.Dataset, changed: xr.Dataset | None) -> None:
    from rich.text import Text

    from autobalancer.cli.terminal.progress_bar import Console
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    answer: Sequence[xr.Dataset] = (found,) if changed is None else (found, changed)
    for one in answer:
        print_facts(one.facts(), one.heading())
        print_sheet(one.columns())
        for text in one.remarks():
            Console(highlight=False).print(Text(text))


@app.command()
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
    from autobalancer.cli.terminal.command import RESULT, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.results.archive import Archive
    from autobalancer.results.folder_store import has_note

    one_form(as_json, as_csv)
    if out is not None and not export:
        raise QuestionError("--out: is the file of --export; name the run to write")
    files = Files(out, plot, RESULT)
    if not folder.is_dir():
        raise QuestionError(f"{folder}: no such folder; archives are made by autobalancer chamber with --archive")
    if has_note(folder):
        raise QuestionError(f"{folder}: is one run; its archive is {folder.parent}, and autobalancer plot draws it")
    held = Archive(folder)
    if not held.names():
        raise QuestionError(f"{folder}: holds no runs; archives are made by autobalancer chamber with --archive")
    if export:
        typer.echo(f"written: {held.export(export, out if out is not None else Path(f'{export}.nc'))}")
        return
    table = held.runs(where)
    if plot is not None:
        from autobalancer.plots.drawing.style import save_picture

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
    from autobalancer.errors import QuestionError
    from autobalancer.tables import Column

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

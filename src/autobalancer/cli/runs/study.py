"""``autobalancer chamber``: questions to a deep chamber that take many runs, or one long one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, Seed
from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
from autobalancer.cli.terminal.quantities import optional, quantity
from autobalancer.units.ranges import listed, whole

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
    from autobalancer.studies.chamber_means import optimal_means

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
    from autobalancer.plots.drawing.save import save_picture
    from autobalancer.results.archive.folder import Archive
    from autobalancer.results.chamber.unconstrained import pakula_body
    from autobalancer.studies.chamber_runs import archived_run

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
        outcome, measured = run.note["outcome"], run.note.get("measures", {})
        print_json({"run": str(run.path), **outcome, "seed": seed, "measures": measured, "pictures": made})
        return
    typer.echo(f"run {run.name}: {run.note['outcome']['outcome_text']}, seed {seed}, in {run.path}")
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
    from autobalancer.cli.terminal.sheet import Column, print_sheet

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

    from autobalancer.cli.terminal.progress import progress_bar

    return progress_bar(text, BarColumn(), MofNCompleteColumn(), TextColumn(text), TimeRemainingColumn())


def _say_what_failed(found: Any) -> None:
    """The points without a result, with the reason; an error where no point has one."""
    from autobalancer.errors import QuestionError
    from autobalancer.studies.chamber_many import NOT_ASKED

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

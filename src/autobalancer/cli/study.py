"""``autobalancer study``: questions to a deep chamber that take many runs, or one long one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.command import Command

app = typer.Typer(
    help="Studies of machines with deep chambers: amplitudes over balls and friction, reactions, step size.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

Plot = Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")]
Step = Annotated[str, typer.Option(help='Of the integration, such as "1e-6 s"; by default from the contact time.')]
Last = Annotated[str, typer.Option(help="Time at the end that is the steady state; by default a tenth.")]


@app.command(cls=Command)
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
    out: Annotated[
        Path | None, typer.Option(help="Result file; by default the machine's name with _amplitudes.nc.")
    ] = None,
    plot: Plot = None,
    means: Annotated[Path | None, typer.Option(help="Picture of the means over the optimal ranges.")] = None,
    carried: Annotated[
        Path | None, typer.Option(help="Picture of the share of balls carried over friction, for each number.")
    ] = None,
) -> None:
    """Vibration over number of balls and friction at equal total mass, deep chamber against single layer.

    Example: autobalancer study amplitudes deep_chamber.toml --balls 3,8,20,50 --single 3,5,8,10 --friction 0.3,0.5,0.7
    --duration "20 s" --archive runs --plot amplitudes.png
    """
    from autobalancer.plots.chamber_study import plot_amplitudes, plot_carried, plot_optimal_means
    from autobalancer.plots.save import save_picture
    from autobalancer.results.store import save_run
    from autobalancer.safe_file import ready_to_write
    from autobalancer.studies.chamber_amplitudes import chamber_amplitudes
    from autobalancer.studies.chamber_means import optimal_means
    from autobalancer.units import option_to_si

    deep = [] if balls == "none" else _whole("balls", balls)
    other = [] if single == "none" else _whole("single", single) if single else deep
    counts = {layer: numbers for layer, numbers in (("deep", deep), ("single", other)) if numbers}
    out = out if out is not None else Path(f"{machine.stem}_amplitudes.nc")
    ready_to_write(out)
    with _bar("runs") as update, _said_when_stopped(archive is not None):
        found = chamber_amplitudes(
            _chamber_machine(machine),
            counts,
            _numbers("friction", friction),
            duration=option_to_si(duration, "s"),
            layers=list(counts),
            archive=archive,
            step=option_to_si(step, "s") if step else None,
            seeds=list(range(seeds)),
            last=option_to_si(last, "s") if last else None,
            workers=workers or None,
            progress=update,
        )
    save_run(found, out, rescue=True)
    typer.echo(f"written: {out}")
    _say_what_failed(found)
    for path, draw in (
        (plot, plot_amplitudes),
        (means, lambda study: plot_optimal_means(optimal_means(study))),
        (carried, plot_carried),
    ):
        if path is not None:
            typer.echo(f"written: {save_picture(draw(found), path)}")


@app.command(cls=Command)
def reactions(
    machine: Annotated[Path, typer.Argument(help="Machine file with chambers.")],
    duration: Annotated[str, typer.Option(help='Such as "20 s".')],
    archive: Annotated[Path, typer.Option(help="Folder that keeps the run; the same command goes on after a stop.")],
    name: Annotated[str, typer.Option(help="Name of the run; by default that of the file.")] = "",
    step: Step = "",
    seed: Annotated[int, typer.Option(help="Of the filling.")] = 0,
    last: Last = "",
    height: Annotated[
        str, typer.Option(help="Height of the axis over the supports: draws the body of the source let go.")
    ] = "",
    until: Annotated[str, typer.Option(help="Time after which reactions do not drive the body that is let go.")] = "",
    out: Annotated[Path, typer.Option(help="Folder of the pictures.")] = Path("."),
) -> None:
    """One run into an archive, with pictures: history, energy, collisions, reactions, arrangement of the balls.

    Example: autobalancer study reactions deep_chamber.toml --duration "20 s" --archive runs --height "0.2 m" --out pictures
    """
    from autobalancer.plots.chamber_arrangement import plot_arrangement
    from autobalancer.plots.chamber_history import plot_chamber_run, plot_collisions, plot_energy
    from autobalancer.plots.chamber_reactions import plot_bearing_forces, plot_reactions
    from autobalancer.plots.save import save_picture
    from autobalancer.results.archive import Archive
    from autobalancer.results.chamber_unconstrained import pakula_body
    from autobalancer.studies.chamber_runs import archived_run
    from autobalancer.units import option_to_si

    with _bar("thousandths of the run") as update, _said_when_stopped():
        run = archived_run(
            Archive(archive),
            name or machine.stem,
            _chamber_machine(machine),
            duration=option_to_si(duration, "s"),
            step=option_to_si(step, "s") if step else None,
            seed=seed,
            last=option_to_si(last, "s") if last else None,
            progress=lambda now, end: update(round(1000.0 * now / end), 1000),
        )
    samples = run.samples().load()
    body = pakula_body(option_to_si(height, "m")) if height else None
    pictures = {
        "history": plot_chamber_run(samples),
        "energy": plot_energy(samples),
        "collisions": plot_collisions(samples),
        "bearings": plot_bearing_forces(samples),
        "reactions": plot_reactions(samples, body, until=option_to_si(until, "s") if until else None),
        "arrangement": plot_arrangement(samples),
    }
    typer.echo(f"run {run.name}: {run.note['outcome']['outcome_text']}, in {run.path}")
    for kind, figure in pictures.items():
        typer.echo(f"written: {save_picture(figure, out / f'{run.name}_{kind}.png')}")


@app.command("step-size", cls=Command)
def step_size(
    stiffness_over_mass: Annotated[float, typer.Option(help="k/m of a ball in m^-0.5 s^-2.")] = 1e10,
    speeds: Annotated[str, typer.Option(help="Relative speeds in m/s.")] = "4,6,8,10",
    steps: Annotated[str, typer.Option(help="Steps in s.")] = "1e-4,1e-5,1e-6,1e-7",
    restitution: Annotated[float, typer.Option(help="1 for elastic balls.")] = 1.0,
    phases: Annotated[int, typer.Option(min=1, help="Collisions for each speed and step.")] = 200,
    scheme: Annotated[str, typer.Option(help="runge_kutta or velocity_verlet.")] = "runge_kutta",
    plot: Plot = None,
) -> None:
    """Energy error of a fixed step in a central collision, for contacts that begin anywhere in a step.

    Example: autobalancer study step-size --stiffness-over-mass 3e9 --plot steps.png
    """
    from rich.console import Console
    from rich.table import Table

    from autobalancer.plots.chamber_study import plot_step_sizes
    from autobalancer.plots.save import save_picture
    from autobalancer.studies.step_size import step_size_study

    with _bar("collisions") as update:
        found = step_size_study(
            _numbers("speeds", speeds),
            _numbers("steps", steps),
            stiffness_over_mass=stiffness_over_mass,
            restitution=restitution,
            phases=phases,
            scheme=scheme,
            progress=update,
        )
    table = Table("relative speed (m/s)", "step (s)", "least (%)", "greatest (%)", "root mean square (%)")
    for speed in found["relative_speed"].values:
        for step in found["step"].values:
            cell = found.sel(relative_speed=speed, step=step)
            sizes = [f"{100.0 * float(cell[name]):.3g}" for name in ("least", "greatest", "root_mean_square")]
            table.add_row(f"{speed:g}", f"{step:g}", *sizes)
    Console().print(table)
    if plot is not None:
        typer.echo(f"written: {save_picture(plot_step_sizes(found), plot)}")


def _chamber_machine(path: Path) -> Any:
    from autobalancer.files.machine_file import load_chamber_machine

    return load_chamber_machine(path)


def _numbers(name: str, text: str) -> list[float]:
    from autobalancer.errors import QuestionError

    try:
        return [float(piece) for piece in text.split(",")]
    except ValueError:
        raise QuestionError(f"{name}: given {text!r}; write numbers with commas between them") from None


def _whole(name: str, text: str) -> list[int]:
    from autobalancer.errors import QuestionError

    values = _numbers(name, text)
    if any(value != round(value) or value < 1 for value in values):
        raise QuestionError(f"{name}: given {text!r}; must be whole numbers from 1 on")
    return [round(value) for value in values]


class _bar:
    """A progress bar that is told (done, in all)."""

    def __init__(self, text: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (BarColumn(), MofNCompleteColumn(), TextColumn(text), TimeRemainingColumn())
        self.progress = Progress(*columns, console=Console(stderr=True), transient=True)
        self.task = self.progress.add_task(text, total=None)

    def __enter__(self) -> Any:
        self.progress.start()
        return lambda done, total: self.progress.update(self.task, completed=done, total=total)

    def __exit__(self, *_: object) -> None:
        self.progress.stop()


def _say_what_failed(found: Any) -> None:
    """The points without a result, with the reason; an error where no point has one."""
    from autobalancer.errors import QuestionError
    from autobalancer.studies.chamber_grid import NOT_ASKED

    table = found["outcome"].to_series()
    asked = table[table != NOT_ASKED]
    failed = asked[asked != "finished"]
    if len(failed) == len(asked):
        raise QuestionError(f"no point of the study has a result; the first one: {failed.iloc[0]}")
    for place, reason in failed.items():
        where = ", ".join(f"{name} {value}" for name, value in zip(table.index.names, place, strict=True))
        typer.secho(f"no result at {where}: {reason}", fg="yellow", err=True)


@contextmanager
def _said_when_stopped(kept: bool = True) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        goes_on = "the archive keeps what was computed, and the same command goes on"
        typer.secho(f"interrupted; {goes_on if kept else 'nothing is kept without --archive'}", fg="yellow", err=True)
        raise

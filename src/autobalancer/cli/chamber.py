"""``autobalancer chamber``: questions to a deep chamber that take many runs, or one long one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Files, FurtherFiles, Reply, command, on_interrupt
from autobalancer.cli.terminal.options import In, Listed, Seed
from autobalancer.cli.terminal.sheet import speed_text
from autobalancer.errors import QuestionError
from autobalancer.units.quantity import whole_numbers

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.tables import Column

Chambers = Annotated[Path, typer.Argument(help="Machine file with one deep chamber.")]
Step = Annotated[float | None, In("s"), 'Of the integration, such as "1e-6 s"; by default from the contact time.']
Last = Annotated[float | None, In("s"), "Time at the end that is the steady state; by default a tenth."]
RESUME_TEXT = "the archive keeps what was computed, and the same command goes on"
LOST = "nothing is kept without --archive"
PICTURES = ("history", "energy", "collisions", "bearings", "reactions", "arrangement")  # of one run

TOPIC = "chamber"  # where the help of autobalancer lists the commands below


@command("chamber.amplitudes", take="archive last:s workers", draw=True, out="_amplitudes.nc", bar="runs")
def amplitudes(
    machine: Chambers,
    balls: Annotated[str, 'Numbers of balls in the deep chamber, such as "3,5,8,20"; none for none.'],
    friction: Annotated[Any, Listed(""), 'Coefficients, such as "0.3,0.5,0.7".'],
    duration: Annotated[float, In("s"), 'Of each run, such as "20 s".'],
    single: Annotated[str, "Numbers of balls in the single layer; by default the same, none for none."] = "",
    step: Step = None,
    seeds: Annotated[int, typer.Option(min=1, help="Fillings for each point; pictures show mean and range.")] = 1,
    means: Annotated[Path | None, "Picture of the means over the optimal ranges."] = None,
    carried: Annotated[Path | None, "Picture of the share of balls carried over friction, for each number."] = None,
    **options: Any,
) -> Reply:
    """Vibration over number of balls and friction at equal total mass, deep chamber against single layer.

    Example: autobalancer chamber amplitudes deep_chamber.toml \\
      --balls 3,8,20,50 --single 3,5,8,10 --friction 0.3,0.5,0.7 \\
      --duration "20 s" --archive runs --plot amplitudes.png
    """
    from autobalancer.results.store import result_csv
    from autobalancer.studies.chamber_study import OPTIMAL, optimal_means

    deep = [] if balls == "none" else whole_numbers("--balls", balls)
    other = [] if single == "none" else whole_numbers("--single", single) if single else deep
    if not deep and not other:
        raise QuestionError("--balls, --single: given none for both; give numbers of balls for one of them")
    counts = {layer: numbers for layer, numbers in (("deep", deep), ("single", other)) if numbers}
    for layer, numbers in counts.items() if means is not None else ():
        low, high = OPTIMAL[layer]
        if not any(low <= number <= high for number in numbers):
            raise QuestionError(
                f"--means: means are over {low} to {high} balls ({layer}), and none of {numbers} is among them"
            )
    of_means, of_shares = (Files(plot=path) for path in (means, carried))
    how: dict[str, Any] = {"duration": duration, "layers": list(counts), "step": step, "seeds": range(seeds), **options}
    with on_interrupt(RESUME_TEXT if "archive" in options else LOST):
        found = ab.chamber.amplitudes(machine, counts, friction, **how)
    _print_failed_points(found)
    pictures = (
        FurtherFiles(of_means, draw=lambda: ab.plot.answer(optimal_means(found))),
        FurtherFiles(of_shares, draw=lambda: ab.plot.answer(found, "carried")),
    )
    return Reply(found, facts=(), csv=result_csv(found), also=pictures)


@command("chamber.archived_run", out=None, csv=False, bar="run")
def reactions(
    machine: Annotated[Path, typer.Argument(help="Machine file with chambers.")],
    duration: Annotated[float, In("s"), 'Such as "20 s".'],
    archive: Annotated[Path, "Folder that keeps the run; the same command goes on after a stop."],
    name: Annotated[str, "Name of the run; by default that of the file."] = "",
    step: Step = None,
    seed: Seed = 0,
    last: Last = None,
    height: Annotated[
        float | None, In("m"), "Height of the axis over the supports: draws the body of the source let go."
    ] = None,
    until: Annotated[float | None, In("s"), "Time after which reactions do not drive the body that is let go."] = None,
    out: Annotated[Path, "Folder of the pictures."] = Path("."),
    **options: Any,
) -> Reply:
    """One run into an archive, with pictures: history, energy, collisions, reactions, arrangement of the balls.

    Example: autobalancer chamber reactions deep_chamber.toml \\
      --duration "20 s" --archive runs --height "0.2 m" --out pictures
    """
    from autobalancer.plots.style import save_picture
    from autobalancer.results.unconstrained_body import pakula_body
    from autobalancer.safe_file import ready_to_write

    update, name = options["progress"], name or machine.stem
    ready_to_write(*(out / f"{name}_{kind}.png" for kind in PICTURES))
    body = pakula_body(height) if height else None
    with on_interrupt(RESUME_TEXT):
        run = ab.chamber.archived_run(
            ab.chamber.Archive(archive),
            name,
            machine,
            duration=duration,
            step=step,
            seed=seed,
            last=last,
            progress=lambda now, end: update(round(1000.0 * now / end), 1000),
        )
    samples = run.samples().load()
    figures = (
        ab.plot.chamber_run(samples),
        ab.plot.answer(samples, "energy"),
        ab.plot.answer(samples, "collisions"),
        ab.plot.answer(samples, "bearings"),
        ab.plot.answer(samples, "reactions", body=body, until=until),
        ab.plot.chamber_arrangement(samples),
    )
    made = [save_picture(figure, out / f"{name}_{kind}.png") for kind, figure in zip(PICTURES, figures, strict=True)]
    outcome, measured = run.note.outcome, run.note.measures
    return Reply(
        None,
        {"run": str(run.path), **outcome, "seed": seed, "measures": measured, "pictures": made},
        lines=[f"run {run.name}: {outcome['outcome_text']}, seed {seed}, in {run.path}"],
        code="\n".join(f"written: {path}" for path in made),
    )


@command("chamber.step_size", take="restitution phases scheme", draw=True, bar="collisions")
def step_size(
    stiffness_over_mass: Annotated[float, "k/m of a ball in m^-0.5 s^-2."] = 1e10,
    speeds: Annotated[Any, Listed("m/s"), "Relative speeds."] = "4,6,8,10 m/s",
    steps: Annotated[Any, Listed("s"), "Steps of the integration."] = "1e-4,1e-5,1e-6,1e-7 s",
    **options: Any,
) -> Reply:
    """Energy error of a fixed step in a central collision, for contacts that begin anywhere in a step.

    Example: autobalancer chamber step-size --stiffness-over-mass 3e9 --plot steps.png
    """
    from autobalancer.tables import Column

    found = ab.chamber.step_size(speeds, steps, stiffness_over_mass=stiffness_over_mass, **options)
    table = found[["least", "greatest", "root_mean_square"]].stack(cell=("relative_speed", "step"))
    columns = [
        Column("relative speed", table["relative_speed"].values, "m/s", "g"),
        Column("step", table["step"].values, "s", "g"),
        *(
            Column(str(name).replace("_", " "), 100.0 * part.values, "%", ".3g")
            for name, part in table.data_vars.items()
        ),
    ]
    return Reply(found, columns=columns, facts=())


def _print_failed_points(found: Any) -> None:
    """The points without a result, with the reason; an error where no point has one."""
    from autobalancer.studies.chamber_study import NOT_ASKED

    table = found["outcome"].to_series()
    asked = table[table != NOT_ASKED]
    failed = asked[asked != "finished"]
    if len(failed) == len(asked):
        raise QuestionError(f"no point of the study has a result; the first one: {failed.iloc[0]}")
    for place, reason in failed.items():
        where = ", ".join(f"{name} {value}" for name, value in zip(table.index.names, place, strict=True))
        typer.secho(f"no result at {where}: {reason}", fg="yellow", err=True)


@command("chamber.design_sensitivity", take="place workers", out="_around.nc", bar="runs")
def sensitivity(
    designs: Annotated[Path, typer.Argument(help="Result file of 'autobalancer design' of a deep chamber.")],
    change: Annotated[list[str], typer.Argument(help='Quantity and share, such as "unbalance=0.2".')],
    archive: Annotated[
        Path | None, "Folder of the search, whose runs are not repeated; what was stopped goes on."
    ] = None,
    **options: Any,
) -> Reply:
    """Run a design again with each of several quantities a little smaller and larger.

    Example: autobalancer chamber sensitivity deep_chamber_design.nc unbalance=0.2 --archive deep_chamber_design_parts
    """
    from autobalancer.cli.terminal.options import quantity

    pairs = [text.partition("=") for text in change]
    for text, (name, _, value) in zip(change, pairs, strict=True):
        if not (name and value):
            raise QuestionError(f'CHANGE: given {text!r}; write it as NAME=VALUE, such as "unbalance=0.2"')
    changes = {name.strip(): quantity("CHANGE", value.strip(), "") for name, _, value in pairs}
    with on_interrupt(RESUME_TEXT if archive is not None else LOST):
        return Reply(ab.chamber.design_sensitivity(ab.load_run(designs), changes, archive=archive, **options))


@command(out=None, csv=False)
def bounds(machine: Chambers) -> Reply:
    """What the balls of a deep chamber can do at best, from closed forms, without a run.

    Example: autobalancer chamber bounds deep_chamber.toml
    """
    found = ab.chamber.bounds(machine)
    return Reply(found, found.as_dict(), heading=found.name, facts=found.rows(speed_text))


@command(out=None, draw=True)
def archive(
    folder: Annotated[Path, typer.Argument(help="Folder of the archive.")],
    where: Annotated[str, 'Condition, such as "friction >= 0.5 and balls in [8, 9]".'] = "",
    show: Annotated[
        list[str] | None, "Column of the table. May be repeated. By default parameters and the main measures."
    ] = None,
    export: Annotated[str, "Name of a run to write as one result file."] = "",
    out: Annotated[Path | None, "With --export: the file, .nc; by default the name of the run here."] = None,
    x: Annotated[str, "Value along the axis of the picture of --plot."] = "balls",
    y: Annotated[str, "Value of the picture."] = "vertical_amplitude",
    by: Annotated[str, "Value that tells the curves apart."] = "",
    log: Annotated[bool, "Logarithmic scale of y."] = False,
) -> Reply:
    """List the runs of an archive, choose among them, draw their measures, or take one out.

    Example: autobalancer chamber archive runs --where "friction >= 0.5" \\
      --plot a.png --x balls --y vertical_amplitude --by friction
    """
    from autobalancer.results.folder_store import has_note

    if out is not None and not export:
        raise QuestionError("--out: is the file of --export; name the run to write")
    Files(out)
    if not folder.is_dir():
        raise QuestionError(f"{folder}: no such folder; archives are made by autobalancer chamber with --archive")
    if has_note(folder):
        raise QuestionError(f"{folder}: is one run; its archive is {folder.parent}, and autobalancer plot draws it")
    held = ab.chamber.Archive(folder)
    if not held.names():
        raise QuestionError(f"{folder}: holds no runs; archives are made by autobalancer chamber with --archive")
    if export:
        path = held.export(export, out if out is not None else Path(f"{export}.nc"))
        return Reply(None, {"written": str(path)}, code=f"written: {path}")
    table = held.runs(where)
    names = [str(key) for key in table.data_vars]
    rows = zip(table["run"].values, *(table[key].values for key in names), strict=True)
    return Reply(
        table,
        [dict(zip(("run", *names), row, strict=True)) for row in rows],
        "",
        (),
        _columns(table, show),
        lines=[f"{table.sizes['run']} runs"],
        notes=(),
        draw=lambda: ab.plot.answer(table, x=x, y=y, by=by or None, log=log),
    )


MAIN = ["state", "balls", "friction", "layers", "vertical_amplitude", "vertical_peak", "settling_time", "share_carried"]


def _columns(table: xr.Dataset, asked: list[str] | None) -> list[Column]:
    from autobalancer.results.display_units import measure_unit
    from autobalancer.tables import Column

    known = [str(key) for key in table.data_vars]
    unknown = [name for name in asked or () if name not in known]
    if table.sizes["run"] and unknown:
        raise QuestionError(f"--show: given {unknown[0]!r}; the runs have {', '.join(sorted(known))}")
    columns = [Column("run", [str(name) for name in table["run"].values])]
    for name in (name for name in asked or MAIN if name in known):
        unit = str(table[name].attrs.get("units", ""))
        unit, factor = measure_unit(unit) if unit != "1" else ("", 1.0)
        values: list[Any] = [value if isinstance(value, str) else float(value) * factor for value in table[name].values]
        columns.append(Column(name.replace("_", " "), values, unit, ".4g"))
    return columns

"""``autobalancer simulate``: one run-up, with a progress bar, kept even if interrupted."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Files, print_csv, print_json
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Plot, Seed, Settling, SpeedUnit, Unit
from autobalancer.cli.terminal.sheet import note as print_note
from autobalancer.cli.terminal.sheet import say, speed_number, speed_sign, speed_text
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    from autobalancer.cli.terminal.progress_bar import Console
    from autobalancer.machine import Machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.results.verdict import Verdict


def run(
    context: typer.Context,
    machine: MachineFile,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Result file: .nc, or a table as .csv or .json; by default the machine's name with .nc here."
        ),
    ] = None,
    duration: Annotated[str, typer.Option(help='Such as "20 s"; by default run.duration of the file.')] = "",
    samples: Annotated[int, typer.Option(help="States kept at equal times; 0 for none.")] = 4001,
    envelope: Annotated[int, typer.Option(help="Bins of the deflection envelope; 0 for none.")] = 1000,
    last_revolutions: Annotated[int, typer.Option(help="Revolutions kept in full at the end of the run.")] = 10,
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-8,
    method: Annotated[
        str,
        typer.Option(
            help="auto, dormand_prince_8, tsitouras or exponential_collocation; of a deep chamber verlet or runge_kutta."
        ),
    ] = "auto",
    step: Annotated[str, typer.Option(help="Deep chamber: of the integration; by default from the contact time.")] = "",
    sample: Annotated[str, typer.Option(help="Deep chamber: time between samples; by default 1 ms.")] = "",
    seed: Seed = 0,
    mass_spread: Annotated[
        float, typer.Option(help="Relative difference in mass of equal balls that pass through each other.")
    ] = 1e-6,
    max_steps: Annotated[
        int, typer.Option(min=1, help="The run ends after so many steps, with exit code 5.")
    ] = 100_000_000,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run a machine file and write a result file. Ctrl-C, or SIGTERM, ends the run and keeps what was computed.

    The exit code is 0 for a run that finished or was ended by an event, 3 if the motion left all bounds, 4 if the step became too
    small, 5 if the steps were spent, 130 after Ctrl-C and 143 after SIGTERM; 2 for an error that you can fix.

    Example: autobalancer simulate stall_and_release.toml \\
      --out stall.nc
    """
    from autobalancer.api import verdict
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.group import leave_with
    from autobalancer.cli.terminal.options import optional
    from autobalancer.cli.terminal.progress_bar import Console, Patience, of_time, progress_bar
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.simulation.record import Envelope, LastRevolutions, Samples

    one_form(as_json, as_csv)
    out = out if out is not None else Path(f"{machine.stem}.nc")
    files = Files(out)
    described = load_machine(machine)
    context.with_resource(_arrays_of_numpy())
    if isinstance(described, ChamberMachine):
        run_chamber(context, described, files)
        return
    if step or sample:
        raise QuestionError("--step, --sample: are for deep chambers; balls in races take --tolerance and --samples")
    console = Console(stderr=True)
    wishes: list[Any] = []
    if samples:
        wishes.append(Samples(samples))
    if envelope:
        wishes.append(Envelope(envelope))
    if last_revolutions:
        wishes.append(LastRevolutions(last_revolutions))
    from autobalancer.api import simulate

    patience = Patience(console)
    with progress_bar(described.name) as update:

        def progress(now: float, end: float) -> None:
            of_time(update)(now, end)
            patience.look(now, end)

        result = simulate(
            described,
            duration=optional("--duration", duration, "s"),
            save=wishes,
            tolerance=tolerance,
            method=method,  # type: ignore[arg-type]  # the function says which there are
            seed=seed,
            mass_spread=mass_spread,
            keep_on_interrupt=True,
            max_steps=max_steps,
            progress=progress,
        )
    files.save(result)
    held = None
    if result.attrs["outcome"] == "finished" and result.sizes.get("ball", 0):
        end = float(result.attrs["end_time"])
        held = simulate(described, hold_balls=True, duration=end, save=[Envelope(), LastRevolutions()])
    found = verdict(result, held)
    numbers = _measured(result)
    if as_json:
        answer = {
            "result": str(out),
            **{key: result.attrs[key] for key in ("outcome", "outcome_text", "end_time", "steps")},
            "seed": seed,
            "verdict": found.as_dict(),
            "measures": {str(name): numbers[name].values for name in numbers},
        }
        print_json(answer)
    elif as_csv:
        print_csv(numbers.columns(speed_sign()))
    else:
        print_verdict(found, Console())
        say_seed(described, seed)
        say(f"{result.attrs['outcome']}: {result.attrs['outcome_text']} ({result.attrs['steps']} steps)")
        files.say()
    leave_with(result.attrs["outcome"])


def _measured(result: Any) -> Any:
    """The measures; none of a run that kept nothing, or ended at once."""
    from autobalancer.api import measures
    from autobalancer.errors import QuestionError
    from autobalancer.results.answers.measured import Measured

    try:
        return measures(result)
    except QuestionError:
        return Measured()


@contextmanager
def _arrays_of_numpy() -> Iterator[None]:
    """Let xarray take every array as one of NumPy: it loads dask and Pint to ask, which takes half a second.

    Only where this command is the first to load xarray: a process that does more may have such arrays.
    """
    if "xarray" in sys.modules:
        yield
        return
    modules: dict[str, Any] = sys.modules
    strangers = {"dask", "pint"} - modules.keys()
    modules.update(dict.fromkeys(strangers))  # what is None there cannot be imported
    try:
        from xarray.namedarray.pycompat import array_type

        array_type("dask")  # xarray remembers that it is not there
        array_type("pint")
        if "pint" in strangers:
            del modules["pint"]  # a unit may need it
        yield
    finally:
        for name in strangers & {name for name, module in modules.items() if module is None}:
            del modules[name]


# ``autobalancer simulate`` for a machine whose balls move freely in chambers.


RACES_ONLY = ("samples", "envelope", "last_revolutions", "tolerance")
SHOWN = (
    *("vertical_amplitude", "vertical_synchronous", "vertical_peak", "settling_time", "share_carried"),
    *("residual_unbalance", "hardest_contact", "energy_error"),
)


def run_chamber(context: typer.Context, described: ChamberMachine, files: Files) -> None:
    """Run it with the options of ``autobalancer simulate`` and write a result file. Ctrl-C keeps what was computed."""
    from autobalancer.cli.terminal.group import leave_with
    from autobalancer.cli.terminal.progress_bar import Console, of_time, progress_bar
    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.results.display_units import measure_unit
    from autobalancer.simulation.chamber import simulate_chamber
    from autobalancer.simulation.chamber.verdict import chamber_verdict
    from autobalancer.tables import Column

    question = _question(context)
    with progress_bar(described.name) as update:
        result = simulate_chamber(
            described,
            **question,
            keep_on_interrupt=True,
            progress=of_time(update),
        )
    files.save(result)
    outcome = {key: result.attrs[key] for key in ("outcome", "outcome_text", "step")}
    found, reason = _measures(result)
    verdict = chamber_verdict(result) if found else None
    shown = [(text, value, *measure_unit(unit)) for value, unit, text in found.values()]
    if context.params["as_json"]:
        numbers = {name: value for name, (value, _, _) in found.items()}
        said = verdict.as_dict() if verdict is not None else None
        about = {"result": str(files.out[0]), **outcome, "seed": context.params["seed"]}
        print_json({**about, "verdict": said, "measures": numbers})
    elif context.params["as_csv"]:
        numbers_shown = [None if value is None else value * factor for _, value, _, factor in shown]
        named, signs = [text for text, *_ in shown], [sign for _, _, sign, _ in shown]
        print_csv([Column("measure", named), Column("value", numbers_shown), Column("unit", signs)])
    else:
        if verdict is not None:
            print_verdict(verdict, Console())
        say(f"{outcome['outcome']}: {outcome['outcome_text']} (steps of {outcome['step']:.3g} s)")
        say(f"filled at random, seed {context.params['seed']}")
        rows = [("rotor speed at the end", speed_text(float(result["speed"][-1])))]
        rows += [
            (text, "-" if value is None else f"{value * factor:.5g} {sign}")
            for name, (text, value, sign, factor) in zip(found, shown, strict=True)
            if name != "residual_unbalance"  # which is in the verdict
        ]
        print_facts(rows)
        if reason:
            say(f"no measures: {reason}")
        files.say()
    leave_with(result.attrs["outcome"])


def _question(context: typer.Context) -> dict[str, Any]:
    """What ``simulate_chamber`` is asked; options that only balls in races have are refused."""
    from autobalancer.cli.terminal.options import quantity

    given = {
        name: value
        for name, value in context.params.items()
        if getattr(context.get_parameter_source(name), "name", "DEFAULT") != "DEFAULT"
    }
    for name in RACES_ONLY:
        if name in given:
            raise QuestionError(
                f"--{name.replace('_', '-')}: is for balls in races; a deep chamber takes --step and --sample, the time "
                "between samples, and keeps them all"
            )
    times: dict[str, Any] = {
        name: quantity(f"--{name}", given[name], "s") for name in ("duration", "step", "sample") if given.get(name)
    }
    return {**times, **{name: given[name] for name in ("method", "seed") if name in given}}


def _measures(result: Any) -> tuple[dict[str, tuple[float | None, str, str]], str]:
    """Value, unit and text of the main measures; or why there are none."""
    import math

    from autobalancer.api import measures

    try:
        found = measures(result)
    except QuestionError as reason:
        return {}, str(reason)
    told = {}
    for name in SHOWN:
        if name in found:
            value = float(found[name])
            told[name] = (
                value if math.isfinite(value) else None,
                found[name].attrs["units"],
                found[name].attrs["long_name"],
            )
    return told, ""


# What is said of balls that start at random.


def say_seed(machine: Machine, seed: int) -> None:
    """Say that a run is one sample, where balls have no start angles."""
    groups = [group for balancer in machine.balancers for race in balancer.races for group in race.balls]
    if any(group.start_angles is None for group in groups):
        print_note(f"the start angles of the balls are random, seed {seed}: this is one sample; try others with --seed")


# A verdict on the terminal and as JSON.


COLORS = {"balanced": "green", "partly balanced": "yellow", "no verdict": "yellow", "not settled yet": "yellow"}


def print_verdict(found: Verdict, console: Console) -> None:
    """The headline, a table that fits the terminal, and notes."""
    from rich.table import Table

    from autobalancer.results.verdict import verdict_lines

    head, rows, notes = verdict_lines(found, _speed)
    console.print(head, style=f"bold {COLORS.get(found.word, 'red')}", highlight=False)
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for label, text in rows:
        table.add_row(label, text)
    console.print(table, highlight=False)
    for note in notes:
        console.note(note)


def _speed(speed: float) -> str:
    from autobalancer.results.number_text import significant

    return f"{significant(float(speed_number(speed, '.10g')))} {speed_sign()}"


# ``autobalancer measures``: the measures of a result file.


def measures(
    result: Annotated[Path, typer.Argument(help="Result file, or folder of a run in an archive.")],
    last: Annotated[
        str, typer.Option(help="Deep chamber: time at the end that is the steady state; by default a tenth of the run.")
    ] = "",
    settling_from: Settling = "run-up",
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the measures of a result: one number of the run, or one for each ball, place, plane, support, link or stage.

    Example: autobalancer measures stall.nc
    """
    from autobalancer.api import measures as measured
    from autobalancer.cli.terminal.command import one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.results.run_argument import open_run

    one_form(as_json, as_csv)
    asked: dict[str, Any] = {"last": quantity("--last", last, "s")} if last else {}
    asked |= {"settling_from": settling_from} if settling_from != "run-up" else {}
    found = measured(open_run(result), **asked)
    if as_json:
        print_json({"result": str(result), "measures": {str(name): found[name].values for name in found}})
    elif as_csv:
        print_csv(found.columns(speed_unit))
    else:
        print_sheet(found.columns(speed_unit), found.heading())


# ``autobalancer stepped-response``: the response measured at one speed after the other, kept even if interrupted.


def stepped(
    machine: MachineFile,
    speeds: Annotated[str, typer.Option(help='"from:to:count", such as "600 rpm:5500 rpm:300", or one speed.')],
    dwell: Annotated[str, typer.Option(help='Time at a speed before it is measured, such as "6 s".')],
    window: Annotated[str, typer.Option(help='Length of the measurement, such as "1 s".')],
    direction: Annotated[str, typer.Option(help="up, down or both.")] = "up",
    start: Annotated[
        str, typer.Option(help="carried: on from the speed before; fixed: each from the start state.")
    ] = "carried",
    acceleration: Annotated[
        str, typer.Option(help='Way to the next speed, such as "10 rad/s^2"; by default at once.')
    ] = "",
    station: Annotated[
        list[str] | None, typer.Option(help="Name of a station to average over; by default all.")
    ] = None,
    settle: Annotated[
        float | None, typer.Option(help="Measure again until amplitudes change less, such as 0.01.")
    ] = None,
    longest: Annotated[str, typer.Option(help='With --settle: longest time at a speed, such as "60 s".')] = "",
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-7,
    seed: Seed = 0,
    mass_spread: Annotated[
        float, typer.Option(help="Relative difference in mass of equal balls that pass through each other.")
    ] = 1e-6,
    out: Annotated[
        Path | None, typer.Option(help="Result file (.nc); by default the machine's name with _stepped.nc here.")
    ] = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Hold a speed, let transients die, measure, go to the next. Ctrl-C keeps what was measured; the same call goes on.

    Example: autobalancer stepped-response discoidal.toml \\
      --speeds "400 rpm:900 rpm:20" --dwell "5 s" --window "1 s" --plot s.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.group import stop_code
    from autobalancer.cli.terminal.options import optional, quantity, speed_range
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.files.machine_file import load_race_machine

    one_form(as_json, as_csv)
    out = out if out is not None else Path(f"{machine.stem}_stepped.nc")
    files = Files(out, plot, (".nc",))
    described = load_race_machine(machine)
    chosen = speed_range("--speeds", speeds)
    held, measured = quantity("--dwell", dwell, "s"), quantity("--window", window, "s")
    rate, most = optional("--acceleration", acceleration, "rad/s^2"), optional("--longest", longest, "s")
    from autobalancer.plots.drawing.style import save_picture
    from autobalancer.studies.stepped_response import stepped_response

    with progress_bar("speeds") as update:
        found = stepped_response(
            machine,
            chosen,
            dwell=held,
            window=measured,
            direction=direction,  # type: ignore[arg-type]
            start=start,  # type: ignore[arg-type]
            acceleration=rate,
            stations=station or None,
            settle=settle,
            longest=most,
            tolerance=tolerance,
            seed=seed,
            mass_spread=mass_spread,
            store=out,
            keep_on_interrupt=True,
            progress=update,
        )
    if plot is not None:
        save_picture(ab.plot.stepped_response(found, speed_unit=speed_unit), plot)
    if as_json:
        keys = ("speed", "direction", "amplitude", "greatest_mean_deflection", "motion")
        numbers = {key: found[key].values for key in keys if key in found.variables}
        about = {"result": str(out), "outcome": found.attrs["outcome"], "seed": seed}
        print_json({**about, **numbers, "outcomes": found["outcome"].values})
    elif as_csv:
        print_csv(found.columns(speed_sign()))
    else:
        for text in found.greatest(speed_text):
            typer.echo(text)
        for text in found.attrs["remarks"]:
            print_note(text)
        say_seed(described, seed)
        files.say()
    if found.attrs["outcome"] == "interrupted":
        typer.echo(f"interrupted; the same command goes on from {out}.parts", err=True)
        raise typer.Exit(stop_code())

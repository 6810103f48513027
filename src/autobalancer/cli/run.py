"""Commands that run a machine once: ``simulate``, ``measures`` of its result, and ``stepped-response``."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Reply, command
from autobalancer.cli.terminal.options import In, MachineFile, Seed, Settling, Speeds
from autobalancer.cli.terminal.sheet import speed_number, speed_sign, speed_text
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    from autobalancer.machine import Machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.results.verdict import Verdict


Spread = Annotated[float, "Relative difference in mass of equal balls that pass through each other."]


# ``autobalancer simulate``: one run, with a progress bar, kept even if interrupted.


@command(out=".nc", unit="speed", topic="First 3")
def simulate(
    context: typer.Context,
    machine: MachineFile,
    duration: Annotated[float | None, In("s"), 'Such as "20 s"; by default run.duration of the file.'] = None,
    samples: Annotated[int, "States kept at equal times; 0 for none."] = 4001,
    envelope: Annotated[int, "Bins of the deflection envelope; 0 for none."] = 1000,
    last_revolutions: Annotated[int, "Revolutions kept in full at the end of the run."] = 10,
    tolerance: Annotated[float, "Relative error per step."] = 1e-8,
    method: Annotated[
        str, "auto, dormand_prince_8, tsitouras or exponential_collocation; of a deep chamber verlet or runge_kutta."
    ] = "auto",
    step: Annotated[
        float | None, In("s"), "Deep chamber: of the integration; by default from the contact time."
    ] = None,
    sample: Annotated[float | None, In("s"), "Deep chamber: time between samples; by default 1 ms."] = None,
    seed: Seed = 0,
    mass_spread: Spread = 1e-6,
    max_steps: Annotated[
        int, typer.Option(min=1, help="The run ends after so many steps, with exit code 5.")
    ] = 100_000_000,
    files: Any = None,
) -> Reply:
    """Run a machine file and write a result file. Ctrl-C, or SIGTERM, ends the run and keeps what was computed.

    The exit code is 0 for a run that finished or was ended by an event, 3 if the motion left all bounds, 4 if the step became too
    small, 5 if the steps were spent, 130 after Ctrl-C and 143 after SIGTERM; 2 for an error that you can fix.

    Example: autobalancer simulate stall_and_release.toml \\
      --out stall.nc
    """
    from autobalancer.cli.terminal.progress_bar import Console, Patience, progress_bar
    from autobalancer.simulation import held_run

    described = ab.load_machine(machine)
    context.with_resource(_arrays_of_numpy())
    kept: Any = ((samples, ab.Samples), (envelope, ab.Envelope), (last_revolutions, ab.LastRevolutions))
    wished = {
        "save": [kind(count) for count, kind in kept if count],
        "tolerance": tolerance,
        "method": None if method == "auto" else method,
        "mass_spread": mass_spread,
        "max_steps": max_steps,
        "step": step,
        "sample": sample,
    }
    options: Any = _known(context, described, wished)
    patience = Patience(Console(stderr=True))
    with progress_bar(described.name) as update:

        def progress(now: float, end: float) -> None:
            update(now, end, now=f"{now:.4g} s of {end:.4g} s")
            patience.look(now, end)

        result = ab.simulate(
            described, duration=duration, seed=seed, keep_on_interrupt=True, progress=progress, **options
        )
    files.save(result)  # before its verdict, for which the machine runs with its balls held
    about = result.attrs
    found, numbers = ab.verdict(result, held_run(described, result)), _measured(result)
    answer = {
        "result": str(files.out[0]),
        **{key: about[key] for key in ("outcome", "outcome_text", "end_time", "steps", "step") if key in about},
        "seed": seed,
        "verdict": found.as_dict(),
        "measures": {str(name): numbers[name].values for name in numbers},
    }
    steps = f"{about['steps']} steps" if "steps" in about else f"steps of {about['step']:.3g} s"
    return Reply(
        result,
        answer,
        facts=_main(numbers),
        columns=numbers.columns(speed_sign()),
        show=lambda: print_verdict(found),
        notes=seed_notes(described, seed),
        last=f"{about['outcome']}: {about['outcome_text']} ({steps})",
        outcome=about["outcome"],
    )


OF_SAVE = ("samples", "envelope", "last_revolutions")
TAKE = {
    "balls in races": "balls in races take --tolerance and --samples",
    "deep chambers": "a deep chamber takes --step and --sample, the time between samples, and keeps them all",
}
MAIN = (
    *("vertical_amplitude", "vertical_synchronous", "vertical_peak", "share_carried", "hardest_contact"),
    "energy_error",
)  # measures that are no part of a verdict


def _known(context: typer.Context, machine: Machine | ChamberMachine, wished: dict[str, Any]) -> dict[str, Any]:
    """What ``simulate`` takes for this kind of machine; what was given and is for another kind is refused."""
    from autobalancer.machine_kinds import arguments_of, machine_kind

    kind = machine_kind(machine)
    known = arguments_of(kind["simulate"])
    for name in wished.keys() | set(OF_SAVE):
        source = getattr(context.get_parameter_source(name), "name", "DEFAULT")
        if source != "DEFAULT" and ("save" if name in OF_SAVE else name) not in known:
            raise QuestionError(f"--{name.replace('_', '-')}: is not for {kind.words}; {TAKE[kind.words]}")
    return {name: value for name, value in wished.items() if name in known and value is not None}


def _main(numbers: Any) -> list[tuple[str, str]]:
    """Meaning and value of the measures that a person asks for beside the verdict."""
    from autobalancer.results.display_units import measure_unit

    facts = []
    for value in (numbers[name] for name in MAIN if name in numbers):
        sign, factor = measure_unit(value.attrs["units"])
        facts.append((value.attrs["long_name"], f"{float(value) * factor:.5g} {sign}"))
    return facts


def _measured(result: Any) -> Any:
    """The measures; none of a run that kept nothing, or ended at once."""
    from autobalancer.api import run_measures
    from autobalancer.errors import QuestionError
    from autobalancer.results.answers.answer import Answer

    try:
        return run_measures(result)
    except QuestionError:
        return Answer({}, attrs={"answer": "Measured"})


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


# What is said of balls that start at random.


def seed_notes(machine: Machine | ChamberMachine, seed: int) -> list[str]:
    """That a run is one sample, where balls have no start angles, or no places in their chambers."""
    if chambers := getattr(machine, "chambers", ()):
        what, places = "the filling of the chambers is", [group.positions for one in chambers for group in one.balls]
    else:
        races = [race for balancer in getattr(machine, "balancers", ()) for race in balancer.races]
        what, places = "the start angles of the balls are", [g.start_angles for race in races for g in race.balls]
    if all(place is not None for place in places):
        return []
    return [f"{what} random, seed {seed}: this is one sample; try others with --seed"]


# A verdict on the terminal and as JSON.


COLORS = {"balanced": "green", "partly balanced": "yellow", "no verdict": "yellow", "not settled yet": "yellow"}


def print_verdict(found: Verdict) -> None:
    """The headline, a table that fits the terminal, and notes."""
    from rich.table import Table

    from autobalancer.cli.terminal.progress_bar import Console
    from autobalancer.results.verdict import verdict_lines

    console = Console()
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
    from autobalancer.results.display_units import significant

    return f"{significant(float(speed_number(speed, '.10g')))} {speed_sign()}"


# ``autobalancer run-measures``: the measures of a result file.


@command(out=None, unit="speed", topic="Files and results")
def run_measures(
    result: Annotated[Path, typer.Argument(help="Result file, or folder of a run in an archive.")],
    last: Annotated[
        float | None,
        In("s"),
        "Deep chamber: time at the end that is the steady state; by default a tenth of the run.",
    ] = None,
    settling_from: Settling = "run-up",
) -> Reply:
    """Print the measures of a result: one number of the run, or one for each ball, place, plane, support, link or stage.

    Example: autobalancer run-measures stall.nc
    """
    from autobalancer.results.run_argument import open_run

    asked: dict[str, Any] = {"last": last} if last is not None else {}
    asked |= {"settling_from": settling_from} if settling_from != "run-up" else {}
    found = ab.run_measures(open_run(result), **asked)
    return Reply(found, {"measures": {str(name): found[name].values for name in found}})


# ``autobalancer stepped-response``: the response measured at one speed after the other, kept even if interrupted.


@command(
    "stepped_response",
    take="dwell:s window:s stations* direction start acceleration:rad/s^2 settle longest:s tolerance seed",
    draw=True,
    out=None,
    unit="speed",
    bar="speeds",
    topic="Many runs",
)
def stepped_response(
    machine: MachineFile,
    speeds: Annotated[Any, Speeds(), '"from:to:count", such as "600 rpm:5500 rpm:300", or one speed.'],
    compare: Annotated[
        bool, typer.Option("--compare/--no-compare", help="Whether the machine is measured without balls, too.")
    ] = True,
    mass_spread: Spread = 1e-6,
    out: Annotated[Path | None, "Result file (.nc); by default the machine's name with _stepped.nc here."] = None,
    **options: Any,
) -> Reply:
    """Hold a speed, let transients die, measure, go to the next. Ctrl-C keeps what was measured; the same call goes on.

    Example: autobalancer stepped-response discoidal.toml \\
      --speeds "400 rpm:900 rpm:20" --dwell "5 s" --window "1 s" --plot s.png
    """
    from autobalancer.cli.terminal.command import Files
    from autobalancer.files.machine_file import load_race_machine

    path = out if out is not None else Path(f"{machine.stem}_stepped.nc")
    kept, described = Files(path, allowed=(".nc",)), load_race_machine(machine)
    found = ab.stepped_response(
        machine,
        speeds,
        without_balls=compare,
        mass_spread=mass_spread,
        store=path,
        keep_on_interrupt=True,
        **options,
    )
    keys = ("speed", "direction", "amplitude", "amplitude_without_balls", "greatest_mean_deflection", "motion")
    numbers = {key: found[key].values for key in keys if key in found.variables}
    about = {"result": str(path), "outcome": found.attrs["outcome"], "seed": options["seed"]}
    return Reply(
        found,
        {**about, **numbers, "outcomes": found["outcome"].values},
        "",
        (),
        found.columns(speed_sign()),
        brief=True,
        lines=found.greatest(speed_text),
        notes=[*found.attrs["remarks"], *seed_notes(described, options["seed"])],
        written=kept,
        outcome="interrupted" if found.attrs["outcome"] == "interrupted" else "",
        stopped=f"the same command goes on from {path}.parts",
    )


# ``autobalancer export``: the machine for other programs.


@command(out=None, csv=False, topic="Files and results")
def export(
    machine: MachineFile,
    out: Annotated[Path, "NAME.fmu, or a folder for a library in C with its sources."],
    part: Annotated[
        str, "machine; or balancer: its balls alone, for a shaft that the other program moves."
    ] = "machine",
    drive: Annotated[str, "own: that of the machine; speed or torque: given from outside."] = "own",
    fmi: Annotated[str, "Version of an FMU: 2.0 or 3.0."] = "2.0",
    duration: Annotated[float | None, In("s"), 'Such as "20 s"; by default run.duration of the file.'] = None,
    tolerance: Annotated[float, "Relative error per step."] = 1e-8,
    seed: Seed = 0,
) -> Reply:
    """Write a machine for other programs: an FMU, or a library in C. Neither needs Python where it runs.

    The steps are those of "simulate --method dormand_prince_8", to the last bit on the same computer,
    or to rounding with resolved balls or forces.

    Example: autobalancer export two_plane_rotor.toml --out two_planes.fmu
    """
    described: Any = ab.load_machine(machine)
    kept: Any = {"part": part, "drive": drive, "fmi": fmi, "duration": duration, "tolerance": tolerance, "seed": seed}
    written = ab.export(described, out, **kept)
    bounded = [one for one in written.parameters if math.isfinite(one.greatest - one.least)]
    facts = [
        ("for", ", ".join(written.systems)),
        ("can be changed", ", ".join(one.name for one in written.parameters) or "nothing"),
        (
            "only within (SI)",
            "\n".join(f"{one.name}: {one.least:.4g} to {one.greatest:.4g}" for one in bounded) or "nothing",
        ),
        ("fixed", ", ".join(written.fixed) or "nothing else"),
        ("outputs", ", ".join(written.outputs)),
    ]
    plain = {
        **written._asdict(),
        "path": str(written.path),
        "parameters": [one._asdict() for one in written.parameters],
    }
    return Reply(
        None, plain, f"{described.name}: {written.path}", facts, lines=[written.missing] if written.missing else []
    )

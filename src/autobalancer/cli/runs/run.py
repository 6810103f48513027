"""``autobalancer simulate``: one run-up, with a progress bar, kept even if interrupted."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Seed, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, say, speed_sign


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
    from autobalancer.cli.runs.starts import say_seed
    from autobalancer.cli.runs.verdict_table import print_verdict
    from autobalancer.cli.terminal.console import Console
    from autobalancer.cli.terminal.exit_codes import leave_with
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.patience import Patience
    from autobalancer.cli.terminal.progress import of_time, progress_bar
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.either_kind import verdict
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples

    one_form(as_json, as_csv)
    out = out if out is not None else Path(f"{machine.stem}.nc")
    files = Files(out)
    described = load_machine(machine)
    context.with_resource(_arrays_of_numpy())
    if isinstance(described, ChamberMachine):
        from autobalancer.cli.runs.run_chamber import run_chamber

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
    from autobalancer.either_kind import simulate

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
        for key in ("flow_text", "coincidence_text"):
            if key in result.attrs:
                note(result.attrs[key])
        say_seed(described, seed)
        say(f"{result.attrs['outcome']}: {result.attrs['outcome_text']} ({result.attrs['steps']} steps)")
        files.say()
    leave_with(result.attrs["outcome"])


def _measured(result: Any) -> Any:
    """The measures; none of a run that kept nothing, or ended at once."""
    from autobalancer.either_kind import measures
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

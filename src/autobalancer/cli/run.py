"""``autobalancer run``: one run-up, with a progress bar, kept even if interrupted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer


def run(
    context: typer.Context,
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    out: Annotated[Path | None, typer.Option(help="Result file; by default the machine's name with .nc here.")] = None,
    duration: Annotated[str, typer.Option(help='Such as "20 s"; by default run.duration of the file.')] = "",
    samples: Annotated[int, typer.Option(help="States kept at equal times; 0 for none.")] = 4001,
    envelope: Annotated[int, typer.Option(help="Bins of the deflection envelope; 0 for none.")] = 1000,
    last_revolutions: Annotated[int, typer.Option(help="Revolutions kept in full at the end of the run.")] = 10,
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-8,
    method: Annotated[
        str, typer.Option(help="dormand_prince_8 or tsitouras; of a deep chamber verlet or runge_kutta.")
    ] = "dormand_prince_8",
    step: Annotated[str, typer.Option(help="Deep chamber: of the integration; by default from the contact time.")] = "",
    sample: Annotated[str, typer.Option(help="Deep chamber: time between samples; by default 1 ms.")] = "",
    seed: Annotated[int, typer.Option(help="For balls without start angles; of the filling of a chamber.")] = 0,
    mass_spread: Annotated[
        float, typer.Option(help="Relative difference in mass of equal balls that pass through each other.")
    ] = 1e-6,
    max_steps: Annotated[
        int, typer.Option(min=1, help="The run ends after so many steps, with exit code 5.")
    ] = 100_000_000,
    as_json: Annotated[bool, typer.Option("--json", help="Print the measures for a program.")] = False,
) -> None:
    """Run a machine file and write a result file. Ctrl-C, or SIGTERM, ends the run and keeps what was computed.

    The exit code is 0 for a run that finished or was ended by an event, 3 if the motion left all bounds, 4 if the step became too
    small, 5 if the steps were spent, 130 after Ctrl-C and 143 after SIGTERM; 2 for something you can mend.

    Example: autobalancer run examples/machines/stall_and_release.toml --out stall.nc
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from autobalancer import save_run, verdict
    from autobalancer.cli.exit_codes import leave_with
    from autobalancer.cli.patience import Patience
    from autobalancer.cli.printable import plain
    from autobalancer.cli.verdict_table import json_ready, print_verdict
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import read_machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.safe_file import ready_to_write
    from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples
    from autobalancer.units import option_to_si

    described = read_machine(machine)
    out = out if out is not None else Path(f"{machine.stem}.nc")
    ready_to_write(out)
    if isinstance(described, ChamberMachine):
        from autobalancer.cli.run_chamber import run_chamber

        run_chamber(context, described, out)
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
    _say_if_first(console)
    from autobalancer import simulate

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[now]}"),
        TimeRemainingColumn(),
    )
    patience = Patience(console)
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(plain(described.name), total=1.0, now="")

        def progress(time: float, end: float) -> None:
            bar.update(task, completed=time / end, now=f"{time:.4g} s of {end:.4g} s")
            patience.look(time, end)

        result = simulate(
            described,
            duration=option_to_si(duration, "s") if duration else None,
            save=wishes,
            tolerance=tolerance,
            method=method,  # type: ignore[arg-type]
            seed=seed,
            mass_spread=mass_spread,
            keep_on_interrupt=True,
            max_steps=max_steps,
            progress=progress,
        )
    save_run(result, out, rescue=True)
    held = None
    if result.attrs["outcome"] == "finished" and result.sizes.get("ball", 0):
        end = float(result.attrs["end_time"])
        held = simulate(described, hold_balls=True, duration=end, save=[Envelope(), LastRevolutions()])
    found = verdict(result, held)
    if as_json:
        numbers = _measured(result)
        answer = {
            "result": str(out),
            **{key: result.attrs[key] for key in ("outcome", "outcome_text", "end_time", "steps")},
            "verdict": found.as_dict(),
            "measures": {str(name): numbers[name].values.tolist() for name in numbers},
        }
        typer.echo(json.dumps(json_ready(answer), indent=2))
    else:
        shown = Console()
        print_verdict(found, shown)
        for key in ("flow_text", "coincidence_text"):
            if key in result.attrs:
                shown.print(f"[yellow]note:[/yellow] {result.attrs[key]}")
        shown.print(f"{result.attrs['outcome']}: {result.attrs['outcome_text']} ({result.attrs['steps']} steps)")
        shown.print(f"result: {out}")
    leave_with(result.attrs["outcome"])


def _measured(result: Any) -> Any:
    """The measures; none of a run that kept nothing, or ended at once."""
    from autobalancer import measures
    from autobalancer.errors import QuestionError

    try:
        return measures(result)
    except QuestionError:
        return {}


def _say_if_first(console: Any) -> None:
    """Compiling takes half a minute once; say so before it starts."""
    from autobalancer.kernels.cache import compiled_before

    if not compiled_before():
        console.print("compiling the equations; this happens once and takes less than a minute ...")

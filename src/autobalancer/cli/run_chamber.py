"""``autobalancer run`` for a machine whose balls move freely in chambers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from autobalancer.machine.chamber import ChamberMachine


def run_chamber(machine: ChamberMachine, duration: float | None, seed: int, out: Path, as_json: bool) -> None:
    """Run, save and say how it ended."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from autobalancer.results.store import save_run
    from autobalancer.simulation.chamber.run import simulate_chamber

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[now]}"), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(machine.name, total=1.0, now="")
        result = simulate_chamber(
            machine,
            duration=duration,
            seed=seed,
            keep_on_interrupt=True,
            progress=lambda time, end: bar.update(task, completed=time / end, now=f"{time:.4g} s of {end:.4g} s"),
        )
    save_run(result, out)
    if as_json:
        answer = {key: result.attrs[key] for key in ("outcome", "outcome_text", "step")}
        typer.echo(json.dumps({"result": str(out), **answer}, indent=2))
    else:
        typer.echo(f"{result.attrs['outcome']}: {result.attrs['outcome_text']} (step {result.attrs['step']:.3g} s)")
        typer.echo(
            f"energy error {float(result['energy_error'][-1]):.3g} J; final speed {float(result['speed'][-1]):.5g} rad/s"
        )
        typer.echo(f"result: {out}")
    if result.attrs["outcome"] == "interrupted":
        raise typer.Exit(130)

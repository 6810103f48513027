"""``autobalancer run`` for a machine whose balls move freely in chambers."""

from __future__ import annotations

import json
from pathlib import Path

import typer

from autobalancer.machine.chamber import ChamberMachine


def run_chamber(described: ChamberMachine, duration: float | None, seed: int, out: Path, as_json: bool) -> None:
    """Run it with samples every millisecond and write a result file. Ctrl-C keeps what was computed."""
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer.results.store import save_run
    from autobalancer.simulation.chamber import simulate_chamber

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(described.name, total=1.0)
        result = simulate_chamber(
            described,
            duration=duration,
            seed=seed,
            keep_on_interrupt=True,
            progress=lambda time, end: bar.update(task, completed=time / end),
        )
    save_run(result, out)
    names = ("speed", "work_motor", "loss_contact", "loss_friction", "loss_rolling", "loss_supports", "energy_error")
    last = {name: float(result[name][-1]) for name in names}
    outcome = {key: result.attrs[key] for key in ("outcome", "outcome_text", "step")}
    if as_json:
        typer.echo(json.dumps({"result": str(out), **outcome, "at_the_end": last}, indent=2))
    else:
        typer.echo(f"{outcome['outcome']}: {outcome['outcome_text']} (steps of {outcome['step']:.3g} s)")
        for name, value in last.items():
            typer.echo(f"{result[name].attrs['long_name']}: {value:.5g} {result[name].attrs['units']}")
        typer.echo(f"result: {out}")
    if result.attrs["outcome"] == "interrupted":
        raise typer.Exit(130)

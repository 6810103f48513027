"""``autobalancer run`` for a machine whose balls move freely in chambers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import typer

from autobalancer.errors import QuestionError
from autobalancer.machine.chamber import ChamberMachine

RACES_ONLY = ("samples", "envelope", "last_revolutions", "tolerance", "max_steps")
SHOWN = (
    *("vertical_amplitude", "vertical_synchronous", "vertical_peak", "settling_time", "share_carried"),
    *("residual_unbalance", "hardest_contact", "energy_error"),
)
SCALE = {"m": ("µm", 1e6), "kg m": ("g mm", 1e6), "1": ("%", 100.0)}


def run_chamber(context: typer.Context, described: ChamberMachine, out: Path) -> None:
    """Run it with the options of ``autobalancer run`` and write a result file. Ctrl-C keeps what was computed."""
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer.cli.exit_codes import leave_with
    from autobalancer.cli.printable import plain
    from autobalancer.cli.verdict_table import json_ready, print_verdict
    from autobalancer.results.store import save_run
    from autobalancer.simulation.chamber import simulate_chamber
    from autobalancer.simulation.chamber.verdict import chamber_verdict

    question = _question(context)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(plain(described.name), total=1.0)
        result = simulate_chamber(
            described,
            **question,
            keep_on_interrupt=True,
            progress=lambda time, end: bar.update(task, completed=time / end),
        )
    save_run(result, out, rescue=True)
    outcome = {key: result.attrs[key] for key in ("outcome", "outcome_text", "step")}
    found, reason = _measures(result)
    verdict = chamber_verdict(result) if found else None
    if context.params["as_json"]:
        numbers = {name: value for name, (value, _, _) in found.items()}
        told = verdict.as_dict() if verdict is not None else None
        typer.echo(
            json.dumps(json_ready({"result": str(out), **outcome, "verdict": told, "measures": numbers}), indent=2)
        )
    else:
        if verdict is not None:
            print_verdict(verdict, Console())
        typer.echo(f"{outcome['outcome']}: {outcome['outcome_text']} (steps of {outcome['step']:.3g} s)")
        typer.echo(f"rotor speed at the end: {float(result['speed'][-1]):.5g} rad/s")
        for value, unit, text in found.values():
            sign, factor = SCALE.get(unit, (unit, 1.0))
            typer.echo(f"{text}: {'-' if value is None else f'{value * factor:.5g} {sign}'}")
        if reason:
            typer.echo(f"no measures: {reason}")
        typer.echo(f"result: {out}")
    leave_with(result.attrs["outcome"])


def _question(context: typer.Context) -> dict[str, Any]:
    """What ``simulate_chamber`` is asked; options that only balls in races have are refused."""
    from autobalancer.units import option_to_si

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
        name: option_to_si(given[name], "s") for name in ("duration", "step", "sample") if given.get(name)
    }
    return {**times, **{name: given[name] for name in ("method", "seed") if name in given}}


def _measures(result: Any) -> tuple[dict[str, tuple[float | None, str, str]], str]:
    """Value, unit and text of the main measures; or why there are none."""
    import math

    from autobalancer.results.chamber_measures import chamber_measures

    try:
        found = chamber_measures(result)
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

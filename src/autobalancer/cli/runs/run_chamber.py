"""``autobalancer simulate`` for a machine whose balls move freely in chambers."""

from __future__ import annotations

from typing import Any

import typer

from autobalancer.cli.terminal.output import Files, print_csv, print_json
from autobalancer.cli.terminal.words import say, speed_text
from autobalancer.errors import QuestionError
from autobalancer.machine.chamber import ChamberMachine

RACES_ONLY = ("samples", "envelope", "last_revolutions", "tolerance")
SHOWN = (
    *("vertical_amplitude", "vertical_synchronous", "vertical_peak", "settling_time", "share_carried"),
    *("residual_unbalance", "hardest_contact", "energy_error"),
)


def run_chamber(context: typer.Context, described: ChamberMachine, files: Files) -> None:
    """Run it with the options of ``autobalancer simulate`` and write a result file. Ctrl-C keeps what was computed."""
    from autobalancer.cli.runs.verdict_table import print_verdict
    from autobalancer.cli.terminal.console import Console
    from autobalancer.cli.terminal.exit_codes import leave_with
    from autobalancer.cli.terminal.progress import of_time, progress_bar
    from autobalancer.cli.terminal.sheet import Column, print_facts
    from autobalancer.results.display_units import measure_unit
    from autobalancer.simulation.chamber import simulate_chamber
    from autobalancer.simulation.chamber.verdict import chamber_verdict

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
    from autobalancer.cli.terminal.quantities import quantity

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

    from autobalancer.either_kind import measures

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

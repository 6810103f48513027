"""``autobalancer stability``: eigenvalues of a steady state over the speed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    import xarray as xr


def stability(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speeds: Annotated[
        str,
        typer.Option(
            help='"from:to:count", such as "500 rpm:3000 rpm:200", or one speed; by default from half to three times '
            "the critical speeds that the machine reaches."
        ),
    ] = "",
    state: Annotated[
        str, typer.Option(help="balanced, coincident, 'in line', or mixed: at some stations at rest.")
    ] = "balanced",
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; by default that of the machine.')] = "",
    out: Annotated[Path | None, typer.Option(help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the picture.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers in SI for a program.")] = False,
) -> None:
    """Say in which speed ranges a steady state is stable, exactly: eigenvalues, or multipliers on anisotropic supports.

    Example: autobalancer stability examples/machines/discoidal.toml --speeds "500 rpm:1500 rpm:200" --plot s.png
    """
    import numpy as np
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer import save_run, summary
    from autobalancer.cli.ranges import speed_range
    from autobalancer.errors import QuestionError
    from autobalancer.plots.save import save_picture
    from autobalancer.plots.stability import plot_stability
    from autobalancer.stability.states import eigenvalues
    from autobalancer.units import option_to_si

    if state not in ("balanced", "mixed", "coincident", "in line"):
        raise QuestionError(f"--state: given {state!r}; must be balanced, mixed, coincident or 'in line'")
    if speeds:
        chosen = speed_range(speeds)
    else:
        about = summary(machine)
        critical = about.critical_speeds
        if not critical:
            raise QuestionError("--speeds: this rotor has no critical speed to choose a range by; give one")
        # bending speeds far above all that the machine runs at say nothing
        reached = [w for w in critical if w <= (about.highest_speed or math.inf)] or [min(critical)]
        chosen = np.linspace(0.5 * min(critical), 3.0 * max(reached), 401)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("speeds")
        found = eigenvalues(
            machine,
            [float(speed) for speed in chosen],
            state=state,  # type: ignore[arg-type]
            unbalance=option_to_si(unbalance, "kg*m") if unbalance else None,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_stability(found, speed_unit=speed_unit), plot)
    if as_json:
        rows = [
            {"speed": float(w), "growth_rate": float(rate), "verdict": str(word), "leading_motion": str(text)}
            for w, rate, word, text in zip(
                found["speed"],
                found["growth_rate"],
                found["verdict"].values,
                found["leading_motion"].values,
                strict=True,
            )
        ]
        missing = [float(w) for w in found.attrs["speeds_without_state"]]
        typer.echo(
            json.dumps(
                {
                    "machine": str(machine),
                    "state": state,
                    "ignores": found.attrs["ignores"],
                    "rows": rows,
                    "speeds_without_state": missing,
                }
            )
        )
        return
    for line in _ranges(found):
        typer.echo(line)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _ranges(found: xr.Dataset) -> list[str]:
    """One line for every run of speeds with one verdict."""
    speeds, verdicts, motions = (found[name].values for name in ("speed", "verdict", "leading_motion"))
    rates = found["growth_rate"].values
    lines, first = [], 0
    for i in range(1, len(speeds) + 1):
        if i == len(speeds) or verdicts[i] != verdicts[first]:
            ends = " to ".join(f"{w * 30 / math.pi:.5g}" for w in dict.fromkeys((speeds[first], speeds[i - 1])))
            worst = first + int(rates[first:i].argmax())
            lines.append(
                f"{ends} rpm: {verdicts[first]}, growth rate at most {rates[worst]:.4g} 1/s ({motions[worst]})"
            )
            first = i
    if found.attrs["ignores"]:
        lines = [f"{line}; ignores {found.attrs['ignores']}" for line in lines]
    missing = found.attrs["speeds_without_state"]
    if len(missing):
        lines.append(f"no such state at {len(missing)} of the speeds")
    return lines

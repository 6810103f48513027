"""``autobalancer basin``: which end state follows from which start."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.errors import QuestionError


def basin(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speed: Annotated[str, typer.Option(help='Final rotor speed, such as "1200 rpm".')],
    axis: Annotated[
        list[str] | None,
        typer.Option(help='One or two axes "name=from:to:count", e.g. "ball_angle[1]=-180 deg:180 deg:200".'),
    ] = None,
    random: Annotated[int, typer.Option(help="Instead of axes: number of random starts.")] = 0,
    seed: Annotated[int, typer.Option(help="For random starts.")] = 0,
    hold: Annotated[str, typer.Option(help='Longest time at the final speed, such as "30 s".')] = "",
    out: Annotated[Path | None, typer.Option(help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the picture.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the shares for a program.")] = False,
) -> None:
    """Run a machine from many starts and tell in percent where it ends.

    Example: autobalancer basin examples/machines/discoidal.toml --speed "1200 rpm" --random 500 --plot basin.png
    """
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer import basin as ask
    from autobalancer import plot_basin, save_run
    from autobalancer.plots.save import save_picture
    from autobalancer.units import option_to_si

    axes = dict(_axis(text) for text in axis or [])
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("runs")
        found = ask(
            machine,
            option_to_si(speed, "rad/s"),
            axes or None,
            random=random,
            seed=seed,
            hold=option_to_si(hold, "s") if hold else None,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    shares = {str(name): float(found["share"].sel(end=name)) for name in found["end"].values}
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_basin(found, speed_unit=speed_unit), plot)
    if as_json:
        answer = {"machine": str(machine), "runs": int(found["state"].size), "share": shares, **_left(found)}
        typer.echo(json.dumps(answer, indent=2))
        return
    for name, share in shares.items():
        if share > 0.0:
            typer.echo(f"{name:>24}  {100 * share:6.2f} %")
    for line in _lines(_left(found)):
        typer.echo(line)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _left(found: Any) -> dict[str, Any]:
    """What the ends leave, SI; nan becomes None."""

    def plain(name: str) -> Any:
        values = found[name].values
        return float(values) if values.ndim == 0 else [None if v != v else float(v) for v in values]

    quantiles = [str(float(q)) for q in found["quantile"].values]
    return {
        "verdict_share": dict(zip(found["verdict"].values.tolist(), plain("verdict_share"), strict=True)),
        "residual_unbalance": dict(zip(quantiles, plain("residual_quantile"), strict=True)),
        "deflection": dict(zip(quantiles, plain("deflection_quantile"), strict=True)),
        "unbalance": plain("unbalance"),
        "deflection_without_balls": plain("deflection_without_balls"),
        "note": str(found.attrs.get("friction_text", "")),
    }


def _lines(left: dict[str, Any]) -> list[str]:
    from autobalancer.results.number_text import length_text, moment_text

    words = ", ".join(f"{word} {100 * share:.3g} %" for word, share in left["verdict_share"].items() if share > 0.0)
    lines = [f"verdict: {words}"] if words else []
    for name, text, key, whole in (
        ("residual unbalance", moment_text, "residual_unbalance", "unbalance"),
        ("deflection", length_text, "deflection", "deflection_without_balls"),
    ):
        middle, often, most = left[key].values()
        if middle is not None:
            lines.append(
                f"{name} of the balls at rest: median {text(middle)}, 95 % below {text(often)}, "
                f"at most {text(most)}; without balls {text(left[whole])}"
            )
    return [*lines, f"note: {left['note']}"] if left["note"] else lines


def _axis(text: str) -> tuple[str, list[float]]:
    import numpy as np

    from autobalancer.units import option_to_si

    name, _, span = text.partition("=")
    parts = span.split(":")
    unit = "rad" if "angle" in name else "rad/s" if "speed" in name else "rad/s^2"
    if len(parts) != 3 or not parts[2].strip().isdigit() or int(parts[2]) < 1:
        raise QuestionError(
            f"--axis: given {text!r}; write it as name=from:to:count, e.g. 'ball_angle[1]=-180 deg:180 deg:50'"
        )
    low, high = (option_to_si(part, unit) for part in parts[:2])
    return name.strip(), [float(v) for v in np.linspace(low, high, int(parts[2]))]

"""``autobalancer borders``: the border speeds of a machine, over a parameter, and the least viscosity for a speed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.check import _finite, _speed


def borders(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; by default the largest of the machine.')] = "",
    windows_up_to: Annotated[str, typer.Option(help="Also list all stable speed ranges up to this speed.")] = "",
    over: Annotated[
        str, typer.Option(help='Parameter, such as unbalance or viscosity, or "name=from:to:count[:log]".')
    ] = "",
    only: Annotated[
        str, typer.Option(help='Only these, with commas between: "release speed, capture speed" are found fast.')
    ] = "",
    up_to: Annotated[
        str, typer.Option(help="Highest speed of the run-up, for release and capture; else that of the drive.")
    ] = "",
    minimum_viscosity_at: Annotated[str, typer.Option(help='Least viscosity for this speed, "1200 rpm".')] = "",
    minimum_drag_at: Annotated[str, typer.Option(help="Least drag for this speed.")] = "",
    out: Annotated[Path | None, typer.Option(help="With --over: result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="With --over: picture, png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the picture.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers in SI for a program.")] = False,
) -> None:
    """Print averaged border, exact border, release and capture speed, each under its name and with what there is to say.

    Example: autobalancer borders examples/machines/discoidal.toml --over unbalance --plot borders.png
    --minimum-viscosity-at "1200 rpm"
    """
    from autobalancer.cli.friction import friction_rows
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_machine
    from autobalancer.stability.borders import border_speeds
    from autobalancer.stability.held import held_by_friction
    from autobalancer.stability.ignored import ignored_at_rest, ignored_by_stalled
    from autobalancer.stability.windows import stable_windows
    from autobalancer.units import option_to_si

    if (out is not None or plot is not None) and not over:
        raise QuestionError("borders: --out and --plot show the borders over a parameter; name it with --over")
    if over and out is None and plot is None and not as_json:
        raise QuestionError(f"--over {over}: say where the curve goes with --plot or --out, or print it with --json")
    described = load_machine(machine)
    size = option_to_si(unbalance, "kg*m") if unbalance else None
    names = _names(only)
    answer: dict[str, Any] = {
        "borders": [vars(border) for border in border_speeds(described, size, only=names, up_to=up_to or None)],
    }
    held = held_by_friction(described, unbalance=size)
    answer["friction"] = held.as_dict()
    if windows_up_to:
        found = stable_windows(described, option_to_si(windows_up_to, "rad/s"), unbalance=size)
        answer["stable_windows"] = {"windows": [list(pair) for pair in found.windows], "note": found.note}
    answer["ignores"] = {"balls at rest": ignored_at_rest(described), "stalled balls": ignored_by_stalled(described)}
    answer |= _minima(described, minimum_viscosity_at, minimum_drag_at, size, names)
    if over:
        answer["over"] = _curve(described, over, (names, up_to), out, plot, speed_unit)
    if as_json:
        typer.echo(json.dumps(_finite({"machine": str(machine), **answer}), indent=2))
        return
    _print(described.name, answer)
    for name, text in friction_rows(held):
        typer.echo(f"{name}: {text}")
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _names(only: str) -> tuple[str, ...]:
    """ "exact border, worst case" has a comma of its own."""
    from autobalancer.stability.borders import NAMES

    left, found = only, []
    for name in sorted(NAMES, key=len, reverse=True):
        if name in left:
            found.append(name)
            left = left.replace(name, "")
    return tuple(found) if not left.strip(" ,") else (left.strip(" ,"),)


def _minima(
    machine: Any, viscosity_at: str, drag_at: str, unbalance: float | None, names: tuple[str, ...]
) -> dict[str, Any]:
    from autobalancer.stability.minimum import minimum_drag, minimum_viscosity
    from autobalancer.units import option_to_si

    found: dict[str, Any] = {}
    for key, text, ask in (("viscosity", viscosity_at, minimum_viscosity), ("drag", drag_at, minimum_drag)):
        if text:
            speed = option_to_si(text, "rad/s")
            found[f"minimum_{key}"] = {
                "speed": float(speed),
                **{name: ask(machine, speed, name, unbalance=unbalance) for name in _asked(machine, names)},
            }
    return found


def _asked(machine: Any, names: tuple[str, ...]) -> list[str]:
    from autobalancer.stability.borders import border_speeds

    kinds = ("exact border", "exact border, worst case", "averaged border", "release speed", "capture speed")
    there = {border.name for border in border_speeds(machine, only=names) if not math.isnan(border.speed)}
    return [name for name in kinds if name in there]


def _curve(
    machine: Any, over: str, which: tuple[tuple[str, ...], str], out: Path | None, plot: Path | None, speed_unit: str
) -> dict[str, Any]:
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer import save_run
    from autobalancer.cli.ranges import axis_range
    from autobalancer.plots.border_curve import plot_border_curve
    from autobalancer.plots.save import save_picture
    from autobalancer.stability.borders_over import border_curve

    name, _, text = over.partition("=")
    values = axis_range("--over", name.strip(), text) if text else _usual(name.strip())
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name)
        found = border_curve(
            machine,
            name.strip(),
            values,
            only=which[0],
            up_to=which[1] or None,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_border_curve(found, speed_unit=speed_unit), plot)
    return {str(key): found[key].values.tolist() for key in (*found.dims, *found.data_vars)}


def _usual(name: str) -> Any:
    """Values for a parameter that was named without any: viscosities of the catalog; nothing for others."""
    import numpy as np

    return np.geomspace(0.2e-6, 200e-6, 121) if name == "viscosity" else None


def _print(name: str, answer: dict[str, Any]) -> None:
    typer.secho(name, bold=True)
    width = max(len(border["name"]) for border in answer["borders"])
    for border in answer["borders"]:
        note = f"   ({border['note']})" if border["note"] else ""
        typer.echo(f"{border['name']:<{width}}   {_speed(border['speed'])}{note}")
    if "stable_windows" in answer:
        spans = [f"{_speed(low)}  to  {_speed(high)}" for low, high in answer["stable_windows"]["windows"]]
        note = f"   ({answer['stable_windows']['note']})" if answer["stable_windows"]["note"] else ""
        typer.echo(f"stable windows: {'; '.join(spans) or 'none'}{note}")
    for key, factor, unit in (("viscosity", 1e6, "mm^2/s"), ("drag", 1.0, "N m s")):
        if f"minimum_{key}" in answer:
            found = dict(answer[f"minimum_{key}"])
            typer.echo(f"least {key} for {_speed(found.pop('speed'))} and above:")
            for which, value in found.items():
                ignored = answer["ignores"][
                    "stalled balls" if which in ("release speed", "capture speed") else "balls at rest"
                ]
                says = f"   (ignores {', '.join(ignored)})" if ignored else ""
                typer.echo(f"  {which}: {_amount(value * factor, unit)}{says}")


def _amount(value: float, unit: str) -> str:
    return "none is enough" if math.isinf(value) else "any" if value == 0.0 else f"{value:.4g} {unit}"

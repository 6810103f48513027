"""``autobalancer borders``: the border speeds of a machine, over a parameter, and the least viscosity for a speed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.stability.maps.answers import BorderCurve


def borders(
    machine: MachineFile,
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; by default the largest of the machine.')] = "",
    windows: Annotated[
        bool, typer.Option("--windows", help="Also list all stable speed ranges up to --up-to.")
    ] = False,
    over: Annotated[
        str, typer.Option(help='Borders over a parameter, "NAME=from:to:count[:log]"; unbalance and viscosity alone.')
    ] = "",
    only: Annotated[
        str, typer.Option(help='Only these, with commas between: "release speed, capture speed" are found fast.')
    ] = "",
    up_to: Annotated[
        str, typer.Option(help="Highest speed, for release, capture and --windows; by default that of the drive.")
    ] = "",
    minimum_viscosity_at: Annotated[str, typer.Option(help='Least viscosity for this speed, "1200 rpm".')] = "",
    minimum_drag_at: Annotated[str, typer.Option(help="Least drag for this speed.")] = "",
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the averaged border, the exact border, the release speed and the capture speed, each with its notes.

    With --over also as a table over a parameter, which --out and --plot write.

    Example: autobalancer borders discoidal.toml \\
      --over unbalance --plot borders.png --minimum-viscosity-at "1200 rpm"
    """
    from autobalancer.assembly.terms import unknown
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError, RangeWarning, unwarned
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.friction.held import held_by_friction
    from autobalancer.stability.maps.speeds import NAMES, theory_of
    from autobalancer.stability.summary.rows import friction_rows

    one_form(as_json, as_csv)
    if (out or plot is not None) and not over:
        raise QuestionError("borders: --out and --plot show the borders over a parameter; name it with --over")
    files = Files(out, plot)
    size, top = optional("--unbalance", unbalance, "kg*m"), optional("--up-to", up_to, "rad/s")
    described = load_race_machine(machine)
    names = _names(only)
    answer: dict[str, Any] = {
        "borders": [vars(border) for border in ab.stability.borders(described, size, only=names, up_to=top)],
    }
    held = held_by_friction(described, unbalance=size)
    answer["friction"] = held.as_dict()
    if windows:
        answer["stable_windows"] = _windows(described, top, size)
    answer["ignores"] = {name: unknown(described, theory_of(name)) for name in names or NAMES}
    with unwarned(RangeWarning):  # which says what is ignored, as the lines of these numbers do
        answer |= _minima(described, minimum_viscosity_at, minimum_drag_at, size, names)
    curve = _curve(described, over, names, top) if over else None
    if curve is not None:
        files.save(curve, lambda: ab.plot.border_curve(curve, speed_unit=speed_unit))
        answer["over"] = {str(key): curve[key].values for key in (*curve.dims, *curve.data_vars)}
    if as_json:
        print_json({"machine": str(machine), **answer})
        return
    table = _columns(answer["borders"]) if curve is None else curve.columns(speed_sign())
    if as_csv:
        print_csv(table)
        return
    _print(described.name, answer)
    for name, text in friction_rows(held, speed_text, brief=True):
        say(f"{name}: {text}", indent="  ")
    if curve is not None:
        print_sheet(table, f"over {curve[str(next(iter(curve.dims)))].attrs['long_name']}")
    files.say()


def _windows(machine: Any, top: float | None, unbalance: float | None) -> dict[str, Any]:
    from autobalancer.errors import QuestionError
    from autobalancer.stability.maps.windows import stable_windows
    from autobalancer.stability.summary.summary import summary

    highest = top if top is not None else summary(machine).highest_speed
    if highest is None:
        raise QuestionError("--windows: the drive has no highest speed; give one with --up-to")
    found = stable_windows(machine, highest, unbalance=unbalance)
    return {"up_to": highest, "windows": [list(pair) for pair in found.windows], "note": found.note}


def _names(only: str) -> tuple[str, ...]:
    """ "exact border, worst case" has a comma of its own."""
    from autobalancer.stability.maps.speeds import NAMES

    left, found = only, []
    for name in sorted(NAMES, key=len, reverse=True):
        if name in left:
            found.append(name)
            left = left.replace(name, "")
    return tuple(found) if not left.strip(" ,") else (left.strip(" ,"),)


def _minima(
    machine: Any, viscosity_at: str, drag_at: str, unbalance: float | None, names: tuple[str, ...]
) -> dict[str, Any]:
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.stability.maps.minimum import minimum_drag, minimum_viscosity

    found: dict[str, Any] = {}
    for key, text, ask in (("viscosity", viscosity_at, minimum_viscosity), ("drag", drag_at, minimum_drag)):
        if text:
            speed = quantity(f"--minimum-{key}-at", text, "rad/s")
            found[f"minimum_{key}"] = {
                "speed": float(speed),
                **{name: ask(machine, speed, name, unbalance=unbalance) for name in _asked(machine, names)},
            }
    return found


def _asked(machine: Any, names: tuple[str, ...]) -> list[str]:

    kinds = ("exact border", "exact border, worst case", "averaged border", "release speed", "capture speed")
    there = {border.name for border in ab.stability.borders(machine, only=names) if not math.isnan(border.speed)}
    return [name for name in kinds if name in there]


def _curve(machine: Any, over: str, names: tuple[str, ...], top: float | None) -> BorderCurve:
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import named, parameter_values
    from autobalancer.stability.maps.curve import border_curve

    name, span = named("--over", over)
    values = parameter_values("--over", over, machine)[1] if span else _usual(name)
    with progress_bar(name) as update:
        return border_curve(machine, name, values, only=names, up_to=top, progress=update)


def _usual(name: str) -> Any:
    """Values for a parameter that was named without any: viscosities of the catalog; nothing for others."""
    import numpy as np

    return np.geomspace(0.2e-6, 200e-6, 121) if name == "viscosity" else None


def _columns(borders: list[dict[str, Any]]) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    return [
        Column("border", [border["name"] for border in borders]),
        Column("speed", [_number(border["speed"]) for border in borders], speed_sign()),
        Column("note", [border["note"] for border in borders], wraps=True),
    ]


def _number(speed: float) -> float | str | None:
    """What a table shows of a border: *never* is a statement, too."""
    if math.isnan(speed):
        return None
    return "never" if math.isinf(speed) else float(speed_number(speed, ".10g"))


def _print(name: str, answer: dict[str, Any]) -> None:
    typer.secho(name, bold=True)
    width = max((len(border["name"]) for border in answer["borders"]), default=0)
    for border in answer["borders"]:
        typer.echo(f"{border['name']:<{width}}   {speed_text(border['speed']) if border['known'] else 'not known'}")
        if border["note"]:
            say(border["note"], indent="  ", first="  ")
    if "stable_windows" in answer:
        windows = answer["stable_windows"]
        typer.echo(f"stable up to {speed_text(windows['up_to'])}:{'' if windows['windows'] else ' nowhere'}")
        for low, high in windows["windows"]:
            typer.echo(f"  {speed_text(low)} to {speed_text(high)}")
        if windows["note"]:
            say(windows["note"], indent="  ", first="  ")
    for key, factor, unit in (("viscosity", 1e6, "mm^2/s"), ("drag", 1.0, "N m s")):
        if f"minimum_{key}" in answer:
            found = dict(answer[f"minimum_{key}"])
            typer.echo(f"least {key} for {speed_text(found.pop('speed'))} and above:")
            for which, value in found.items():
                ignored = ", ".join(answer["ignores"][which])
                says = f"   (ignores {ignored})" if ignored else ""
                say(f"  {which}: {_amount(value * factor, unit)}{says}", indent="    ")


def _amount(value: float, unit: str) -> str:
    return "none is enough" if math.isinf(value) else "any" if value == 0.0 else f"{value:.4g} {unit}"

"""``autobalancer annulus-flow``: how the fluid in a race follows the rotor."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    from autobalancer.cli.terminal.sheet import Column


def flow(
    machine: MachineFile,
    speed: Annotated[
        str, typer.Option(help='A constant speed, such as "1200 rpm", in place of the profile of the machine.')
    ] = "",
    initial_speed: Annotated[
        str, typer.Option(help='Speed of the fluid before time zero, such as "0 rpm" for an impulsive start.')
    ] = "",
    duration: Annotated[str, typer.Option(help='Such as "20 s"; by default run.duration of the file.')] = "",
    time: Annotated[list[str] | None, typer.Option(help='Time of a field, such as "0.5 s"; may be repeated.')] = None,
    model: Annotated[str, typer.Option(help="auto, modes, chebyshev or azimuthal.")] = "auto",
    points: Annotated[str, typer.Option(help='Intervals in radial and axial direction, such as "24x32".')] = "",
    error: Annotated[float, typer.Option(help="Of the speed at the orbit over the greatest speed.")] = 1e-3,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Solve the flow in the annulus of a race and say how far the fluid lags behind the rotor.

    Example: autobalancer annulus-flow discoidal.toml \\
      --speed "60 rad/s" --initial-speed "0 rpm" --duration "2 s" \\
      --time "0.1 s" --plot flow.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import of_time, progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity
    from autobalancer.flow.question import annulus_flow

    one_form(as_json, as_csv)
    files = Files(out, plot)
    with progress_bar("flow") as update:
        found = annulus_flow(
            machine,
            optional("--speed", speed, "rad/s"),
            duration=optional("--duration", duration, "s"),
            initial_speed=optional("--initial-speed", initial_speed, "rad/s"),
            times=[quantity("--time", text, "s") for text in time or []],
            model=model,  # type: ignore[arg-type]
            points=_points(points),
            error=error,
            balancer=balancer,
            race=race,
            progress=of_time(update),
        )
    files.save(found, lambda: ab.plot.flow(found, speed_unit=speed_unit))
    if as_json:
        print_json({"machine": str(machine), **_numbers(found)})
        return
    if as_csv:
        print_csv(_columns(found))
        return
    _print(found)
    files.say()


def _points(text: str) -> tuple[int, int] | None:
    from autobalancer.errors import QuestionError

    if not text:
        return None
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise QuestionError(f"--points: given {text!r}; write radial and axial intervals, such as 24x32")
    return int(parts[0]), int(parts[1])


def _columns(found: Any) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    names = {"speed": "rotor", "fluid_speed": "fluid at the orbit", "diffusion_speed": "fluid by diffusion alone"}
    speeds = [
        Column(head, [float(speed_number(w, ".10g")) for w in found[name].values], speed_sign())
        for name, head in names.items()
    ]
    return [Column("time", found["time"].values, "s"), *speeds]


def _print(found: Any) -> None:
    from autobalancer.cli.terminal.words import note
    from autobalancer.flow.result import flow_notes

    a = found.attrs
    lag_at_end = float(found["speed"][-1] - found["fluid_speed"][-1])
    for name, text in (
        ("model", f"{a['model']}: {a['model_reason']}"),
        ("annulus", f"{1e3 * a['inner']:.5g} to {1e3 * a['outer']:.5g} mm, {1e3 * a['height']:.4g} mm high"),
        ("orbit radius", f"{1e3 * a['orbit_radius']:.5g} mm"),
        ("Ekman number", f"{a['ekman_number']:.3g}, at the greatest speed"),
        ("greatest lag", speed_text(a["greatest_lag"], ".4g")),
        ("lag at the end", speed_text(lag_at_end, ".4g")),
        ("spin-up time", f"{a['spin_up_time']:.4g} s" if math.isfinite(a["spin_up_time"]) else "not reached"),
    ):
        say(f"{name:<16}{text}", indent=" " * 16)
    for text in flow_notes(found):
        note(text)


def _numbers(found: Any) -> dict[str, Any]:
    keys = ("model", "model_reason", "ekman_number", "greatest_lag", "points", "steps", "inner", "outer", "height")
    answer = {key: found.attrs[key] for key in keys}
    for key in ("spin_up_time", "uncertainty"):
        answer[key] = found.attrs[key] if math.isfinite(found.attrs[key]) else None
    answer |= {name: found[name].values.tolist() for name in ("time", "speed", "fluid_speed", "diffusion_speed")}
    return answer

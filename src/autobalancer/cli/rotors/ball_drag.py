"""``autobalancer ball-drag``: the drag of a ball in its race, from the equations of the fluid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot
from autobalancer.cli.terminal.words import say

if TYPE_CHECKING:
    from autobalancer.cli.terminal.sheet import Column

SHOWN = ("cd_re", "drag_coefficient", "lift", "through_flow")


def ball_drag(
    machine: MachineFile,
    gap: Annotated[str, typer.Option(help='Between ball and outer wall, such as "1 um": what their roughness leaves.')],
    reynolds: Annotated[
        list[float] | None,
        typer.Option(help="Reynolds number; may be repeated, ascending. 0: no inertia of the fluid."),
    ] = None,
    motion: Annotated[str, typer.Option(help="rolling or sliding.")] = "rolling",
    ball_ahead: Annotated[
        str, typer.Option(help='Distance of an equal ball ahead along the orbit, such as "15 mm".')
    ] = "",
    mesh_gap: Annotated[
        float | None, typer.Option(help="Gap of the mesh in ball radii; by default 0.02, or the gap if wider.")
    ] = None,
    fineness: Annotated[float, typer.Option(help="2 halves all elements.")] = 1.0,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Compute the drag of a ball in its race by finite elements, and the lines of the machine file that use it.

    Needs pip install "autobalancer\\[drag]". A few seconds for each Reynolds number up to 30, a minute at 100.

    Example: autobalancer ball-drag discoidal.toml --gap "1 um" \\
      --reynolds 0 --reynolds 10 --plot ball.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import of_time, progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity
    from autobalancer.flow.ball.question import ball_drag as solved

    one_form(as_json, as_csv)
    files = Files(out, plot)
    numbers = {} if reynolds is None else {"reynolds": reynolds}
    with progress_bar("flow") as update:
        found = solved(
            machine,
            **numbers,
            gap=quantity("--gap", gap, "m"),
            motion=motion,
            ball_ahead=optional("--ball-ahead", ball_ahead, "m"),
            mesh_gap=mesh_gap,
            fineness=fineness,
            balancer=balancer,
            race=race,
            progress=of_time(update),
        )
    files.save(found, lambda: ab.plot.ball_drag(found))
    if as_json:
        names = ("reynolds", *(name for name in found.data_vars if found[name].dims == ("reynolds",)))
        print_json(
            {"machine": str(machine), **_numbers(found), **{name: found[name].values.tolist() for name in names}}
        )
    elif as_csv:
        print_csv(_columns(found))
    else:
        _print(found)
        files.say()


def _numbers(found: Any) -> dict[str, Any]:
    return {key: found.attrs[key] for key in ("gap", "mesh_gap", "mesh_error", "elements", "cd_re_per_decade", "drag")}


def _columns(found: Any) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    heads = {"cd_re": "c_d Re", "drag_coefficient": "c_d", "lift": "lift/(mu r U)", "through_flow": "mean flow/U"}
    first = Column("Re", found["reynolds"].values)
    return [first, *(Column(heads[name], found[name].values) for name in SHOWN)]


def _print(found: Any) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet

    a = found.attrs
    for name, text in (
        ("gap", f"{1e6 * a['gap']:.4g} um; ten times less adds {a['cd_re_per_decade']:.3g} to c_d Re"),
        ("mesh", f"{a['elements']} elements, gap of {a['mesh_gap']:.3g} ball radii"),
        ("error", f"a mesh 1.5 times coarser differs by {100.0 * a['mesh_error']:.2g} %"),
    ):
        say(f"{name:<6}{text}", indent=" " * 6)
    print_sheet(_columns(found))
    say("in the machine file:")
    typer.echo(a["drag"])

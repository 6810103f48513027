"""``autobalancer sheared-drag``: the drag of a ball in a fluid that thins or thickens."""

from __future__ import annotations

from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot


def sheared_drag(
    machine: MachineFile,
    velocity: Annotated[
        list[str], typer.Option(help='Of the ball along its walls, such as "0.5 m/s"; may be repeated, ascending.')
    ],
    mesh_gap: Annotated[float, typer.Option(help="Between ball and outer wall, ball radii.")] = 0.02,
    motion: Annotated[str, typer.Option(help="rolling or sliding.")] = "rolling",
    fineness: Annotated[float, typer.Option(help="2 halves all elements.")] = 1.0,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Compute the slow drag of a ball in a sheared fluid, and the effective rate of shear at_ball for the machine file.

    Needs pip install "autobalancer\\[drag]". Some seconds for each velocity.

    Example: autobalancer sheared-drag thinning_fluid.toml \\
      --velocity "0.1 m/s" --velocity "1 m/s" --plot drag.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import of_time, progress_bar
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.cli.terminal.words import note

    one_form(as_json, as_csv)
    files = Files(out, plot)
    with progress_bar("flow") as update:
        found = ab.flow.sheared_drag(
            machine,
            [quantity("--velocity", text, "m/s") for text in velocity],
            mesh_gap=mesh_gap,
            motion=motion,
            fineness=fineness,
            balancer=balancer,
            race=race,
            progress=of_time(update),
        )
    files.save(found, lambda: ab.plot.sheared_drag(found))
    if as_json:
        values = {str(name): found[name].values for name in (*found.coords, *found.data_vars)}
        numbers = {key: found.attrs[key] for key in ("at_ball", "greatest_error", "mesh_gap", "mesh_error", "elements")}
        print_json({"machine": str(machine), **numbers, **values})
        return
    if as_csv:
        print_csv(found.columns())
        return
    print_facts(found.facts(), str(found.attrs["title"]))
    print_sheet(found.columns())
    for remark in found.remarks():
        note(remark)
    files.say()

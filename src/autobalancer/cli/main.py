"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.group import Group


class Commands(Group):
    """All commands and groups of commands: a module of this folder, and the name of the function or group in it."""

    places = {
        "check": "stability.check.check",
        "simulate": "runs.run.run",
        "example": "files.example.example",
        "keys": "files.keys.keys",
        "measures": "runs.measures.measures",
        "plot": "runs.plot.plot",
        "animate": "runs.animate.animate",
        "eigenvalues": "stability.eigenvalues.stability",
        "borders": "stability.borders.borders",
        "map": "stability.stability_map.map_",
        "branches": "stability.branches.branches",
        "basin": "runs.basin.basin",
        "ensemble": "runs.ensemble.ensemble",
        "study": "studies.study.study",
        "design": "studies.design.design",
        "report": "studies.report.report",
        "envelopes": "studies.envelopes.envelopes",
        "compare": "runs.compare.compare",
        "receptance": "rotors.receptance.receptance",
        "stepped-response": "runs.stepped.stepped",
        "modes": "rotors.modes.modes",
        "response": "rotors.response.response",
        "torsional-modes": "rotors.torsion.torsional_modes",
        "torsional-response": "rotors.torsion.torsional_response",
        "liquid-response": "rotors.liquid.liquid_response",
        "annulus-flow": "rotors.flow.flow",
        "ball-drag": "rotors.ball_drag.ball_drag",
        "sheared-drag": "rotors.sheared_drag.sheared_drag",
        "equilibrium-angle": "rotors.angle.angle",
        "identify": "rotors.identify.identify",
        "rubber": "rotors.rubber.rubber",
        "equivalent-planar": "rotors.equivalent.equivalent",
        "app": "files.bench.app",
        "catalog": "files.catalog.app",
        "measure": "measured.group.app",
        "chamber": "runs.study.app",
    }


app = typer.Typer(
    name="autobalancer",
    cls=Commands,
    help="Automatic ball balancers: describe the machine, simulate it, see what the balls do.",
    epilog="The files in the examples are written by: autobalancer example --all",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


def _say_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"autobalancer {version('autobalancer')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Print the version and stop.")
    ] = False,
    load: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Execute a Python file with forces, joints, laws of drag, friction or shear of your own; machine files may then "
            "name them. Stands before the command and may be repeated.",
        ),
    ] = None,
) -> None:
    """Automatic ball balancers: describe the machine, simulate it, see what the balls do."""
    if load:
        from autobalancer.files.own_leaves import load as load_file

        for file in load:
            load_file(file)

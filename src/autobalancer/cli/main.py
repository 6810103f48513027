"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.group import Group


class Commands(Group):
    """All commands by topic: a module of this folder, and the name of the function or group of commands in it."""

    topics = {
        "First": {
            "example": "samples.example",
            "check": "stability.check",
            "simulate": "run.simulate",
            "plot": "pictures.plot",
            "animate": "pictures.animate",
            "borders": "stability.borders",
        },
        "Files and results": {
            "keys": "samples.keys",
            "catalog": "catalog.app",
            "run-measures": "run.run_measures",
            "compare": "many_runs.compare",
            "report": "many_runs.report",
            "app": "samples.app",
        },
        "Stability": {
            "eigenvalues": "stability.eigenvalues",
            "map": "stability.map_",
            "branches": "stability.branches",
            "basin": "many_runs.basin",
        },
        "Many runs, and decisions by them": {
            "ensemble": "many_runs.ensemble",
            "study": "many_runs.study",
            "envelopes": "many_runs.envelopes",
            "design": "many_runs.design",
            "stepped-response": "run.stepped_response",
        },
        "Rotor": {
            "modes": "rotor.modes",
            "campbell": "rotor.campbell",
            "response": "rotor.response",
            "torsional-modes": "rotor.torsional_modes",
            "torsional-response": "rotor.torsional_response",
            "liquid-response": "rotor.liquid_response",
            "equivalent-planar": "rotor.equivalent_planar",
        },
        "Fluid in a race": {
            "annulus-flow": "rotor.annulus_flow",
            "ball-drag": "rotor.ball_drag",
            "equilibrium-angle": "rotor.equilibrium_angle",
        },
        "From measurements": {
            "measure": "measured.app",
            "receptance": "identify.receptance",
            "identify": "identify.identify",
            "rubber": "measured.rubber",
        },
        "Deep chambers": {"chamber": "chamber.app"},
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
        from autobalancer.files.own_plugins import load as load_file

        for file in load:
            load_file(file)

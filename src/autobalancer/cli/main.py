"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.group import Group


class Commands(Group):
    """Topics and groups of commands; a command says its own in its decorator."""

    topics = {
        "First": {},
        "Files and results": {"catalog": "Look up bearings, ball materials, friction, fluids and published rigs."},
        "Stability": {},
        "Many runs": {},
        "Rotor": {},
        "Fluid in a race": {},
        "From measurements": {"measure": "From measured signals and films to numbers with their uncertainty."},
        "Deep chambers": {
            "chamber": "Studies of machines with deep chambers: amplitudes over balls and friction, the best design, "
            "reactions, step size."
        },
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
        from autobalancer.machine.plugins import load as load_file

        for file in load:
            load_file(file)

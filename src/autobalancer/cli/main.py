"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.group import Group

app = typer.Typer(
    name="autobalancer",
    cls=Group,
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
    from autobalancer.files.own_leaves import load as load_file

    for file in load or []:
        load_file(file)


from autobalancer.cli.files import bench, catalog, example, keys  # noqa: E402
from autobalancer.cli.measured import group  # noqa: E402
from autobalancer.cli.rotors import (  # noqa: E402
    angle,
    ball_drag,
    equivalent,
    flow,
    identify,
    liquid,
    modes,
    receptance,
    response,
    rubber,
    sheared_drag,
    torsion,
)
from autobalancer.cli.runs import (  # noqa: E402
    animate,
    archive,
    basin,
    compare,
    design,
    ensemble,
    measures,
    plot,
    run,
    stepped,
    study,
)
from autobalancer.cli.stability import borders, branches, check, eigenvalues, stability_map  # noqa: E402
from autobalancer.cli.studies import design as design_file  # noqa: E402
from autobalancer.cli.studies import envelopes, report  # noqa: E402
from autobalancer.cli.studies import study as study_file  # noqa: E402

app.command()(check.check)
app.command("simulate")(run.run)
app.command()(example.example)
app.command()(keys.keys)
app.command()(measures.measures)
app.command()(plot.plot)
app.command()(animate.animate)
app.command("eigenvalues")(eigenvalues.stability)
app.command()(borders.borders)
app.command("map")(stability_map.map_)
app.command()(branches.branches)
app.command()(basin.basin)
app.command()(ensemble.ensemble)
app.command()(study_file.study)
app.command()(design_file.design)
app.command()(report.report)
app.command()(envelopes.envelopes)
app.command()(compare.compare)
app.command()(receptance.receptance)
app.command("stepped-response")(stepped.stepped)
app.command()(modes.modes)
app.command()(response.response)
app.command("torsional-modes")(torsion.torsional_modes)
app.command("torsional-response")(torsion.torsional_response)
app.command("liquid-response")(liquid.liquid_response)
app.command("annulus-flow")(flow.flow)
app.command("ball-drag")(ball_drag.ball_drag)
app.command("sheared-drag")(sheared_drag.sheared_drag)
app.command("equilibrium-angle")(angle.angle)
app.command()(identify.identify)
app.command()(rubber.rubber)
app.command("equivalent-planar")(equivalent.equivalent)
app.command("app")(bench.app)
app.add_typer(catalog.app, name="catalog")
app.add_typer(group.app, name="measure")
app.add_typer(study.app, name="chamber")
study.app.command()(design.design)
study.app.command()(design.bounds)
study.app.command()(archive.archive)

"""The commands of ``autobalancer``."""

from __future__ import annotations

import typer

from autobalancer.cli.command import Command
from autobalancer.cli.group import Group

app = typer.Typer(
    name="autobalancer",
    cls=Group,
    help="Automatic ball balancers: describe the machine, simulate it, see what the balls do.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
)

from autobalancer.cli import (  # noqa: E402
    angle,
    animate,
    archive,
    basin,
    borders,
    branches,
    catalog,
    check,
    equivalent,
    flow,
    identify,
    modes,
    plot,
    receptance,
    response,
    run,
    stability,
    stability_map,
    stepped,
    study,
)

app.command(cls=Command)(check.check)
app.command(cls=Command)(run.run)
app.command(cls=Command)(plot.plot)
app.command(cls=Command)(animate.animate)
app.command(cls=Command)(stability.stability)
app.command(cls=Command)(borders.borders)
app.command("map", cls=Command)(stability_map.map_)
app.command(cls=Command)(branches.branches)
app.command(cls=Command)(basin.basin)
app.command(cls=Command)(receptance.receptance)
app.command(cls=Command)(stepped.stepped)
app.command(cls=Command)(modes.modes)
app.command(cls=Command)(response.response)
app.command(cls=Command)(flow.flow)
app.command(cls=Command)(angle.angle)
app.command(cls=Command)(identify.identify)
app.command(cls=Command)(equivalent.equivalent)
app.add_typer(catalog.app, name="catalog")
app.command(cls=Command)(archive.archive)
app.add_typer(study.app, name="study")

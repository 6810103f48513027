"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from autobalancer.cli.command import Command
from autobalancer.errors import AutobalancerError, CacheWarning, RangeWarning


class _Group(TyperGroup):
    """Exit code 2 and one readable message for everything a user can get wrong; warnings without lines of code."""

    def invoke(self, ctx: Any) -> Any:
        try:
            with warnings.catch_warnings():
                others = warnings.showwarning

                def show(message: Any, category: type[Warning], *place: Any) -> None:
                    if issubclass(category, (RangeWarning, CacheWarning)):
                        typer.secho(f"note: {message}", fg="yellow", err=True)
                    else:
                        others(message, category, *place)

                warnings.showwarning = show  # type: ignore[assignment]
                return super().invoke(ctx)
        except AutobalancerError as error:
            typer.secho(f"autobalancer: {error}", fg="red", err=True)
            sys.exit(2)


app = typer.Typer(
    name="autobalancer",
    cls=_Group,
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

"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from autobalancer.errors import AutobalancerError, RangeWarning


class _Group(TyperGroup):
    """Exit code 2 and one readable message for everything a user can get wrong; warnings without lines of code."""

    def invoke(self, ctx: Any) -> Any:
        try:
            with warnings.catch_warnings():
                others = warnings.showwarning

                def show(message: Any, category: type[Warning], *place: Any) -> None:
                    if issubclass(category, RangeWarning):
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

app.command()(check.check)
app.command()(run.run)
app.command()(plot.plot)
app.command()(animate.animate)
app.command()(stability.stability)
app.command()(borders.borders)
app.command("map")(stability_map.map_)
app.command()(branches.branches)
app.command()(basin.basin)
app.command()(receptance.receptance)
app.command()(stepped.stepped)
app.command()(modes.modes)
app.command()(response.response)
app.command()(flow.flow)
app.command()(angle.angle)
app.command()(identify.identify)
app.command()(equivalent.equivalent)
app.add_typer(catalog.app, name="catalog")
app.command()(archive.archive)
app.add_typer(study.app, name="study")

"""The commands of ``autobalancer`` and the one place where an error becomes an exit code."""

from __future__ import annotations

import sys
from typing import Any

import typer
from typer.core import TyperGroup

from autobalancer.errors import AutobalancerError


class _Group(TyperGroup):
    """Exit code 2 and one readable message for everything a user can get wrong."""

    def invoke(self, ctx: Any) -> Any:
        try:
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

from autobalancer.cli import animate, basin, catalog, check, plot, run  # noqa: E402

app.command()(check.check)
app.command()(run.run)
app.command()(plot.plot)
app.command()(animate.animate)
app.command()(basin.basin)
app.add_typer(catalog.app, name="catalog")

"""``autobalancer measure``: the group and its commands; a new command is a file here and a line below."""

from __future__ import annotations

import typer

from autobalancer.cli.measured import record, signals

app = typer.Typer(
    name="measure",
    help="From measured signals and films to numbers with their uncertainty.",
    no_args_is_help=True,
)
app.command()(signals.signals)
app.command()(record.record)

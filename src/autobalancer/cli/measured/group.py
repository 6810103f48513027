"""``autobalancer measure``: the group and its commands; a new command is a file here and a line below."""

from __future__ import annotations

import typer

from autobalancer.cli.measured import (
    balance,
    balls,
    motion,
    orders,
    race,
    record,
    rubber_loops,
    signals,
    spectrum,
    trial,
)

app = typer.Typer(
    name="measure",
    help="From measured signals and films to numbers with their uncertainty.",
    no_args_is_help=True,
)
app.command()(signals.signals)
app.command()(orders.orders)
app.command()(spectrum.spectrum)
app.command("order-map")(spectrum.order_map)
app.command()(motion.damping)
app.command()(motion.orbit)
app.command()(motion.envelope)
app.command()(record.record)
app.command()(balance.balance)
app.command("four-run")(balance.four_run)
app.command("run-down")(balance.run_down)
app.command("trial-mass")(trial.trial_mass)
app.command("split-mass")(trial.split_mass)
app.command("race-shape")(race.race_shape)
app.command("rest-friction")(race.rest_friction)
app.command("drag-from-lag")(race.drag_from_lag)
app.command("rubber-signals")(rubber_loops.rubber_signals)
app.command()(balls.balls)
app.command()(balls.film)

"""``autobalancer measure orders``: amplitude and phase of orders of the speed."""

from __future__ import annotations

from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.measured.given import (
    PHASE,
    READING,
    TURNING,
    Chosen,
    Phase,
    Reading,
    SignalFile,
    Turning,
    with_angle,
)
from autobalancer.cli.terminal.blocks import in_blocks
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, SpeedUnit, Unit


@in_blocks
def orders(
    file: SignalFile,
    order: Annotated[str, typer.Option("--orders", help="Orders of the speed, such as 1,2.")] = "1",
    channel: Chosen = None,
    method: Annotated[str, typer.Option(help="fit or vold-kalman.")] = "fit",
    revolutions: Annotated[float, typer.Option(help="Window of the fit.")] = 4.0,
    bandwidth: Annotated[str, typer.Option(help='Of the Vold-Kalman filter, such as "2 Hz".')] = "",
    slow_roll: Annotated[str, typer.Option(help='Subtract the run-out found in this time, such as "0:4 s".')] = "",
    reading: Reading = READING,
    turning: Turning = TURNING,
    phase: Phase = PHASE,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Amplitude and phase of orders of the speed in a measured run-up or run-down, with their uncertainty.

    Example: autobalancer measure orders run_up_signals.csv --slow-roll "0:4 s" \\
      --plot orders.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.units.ranges import listed

    one_form(as_json, as_csv)
    files = Files(out, plot)
    numbers = listed("--orders", order, "")
    with progress_bar("orders") as update:
        signals = with_angle(reading.signals(file), turning, phase)
        found = ab.measure.orders(
            signals,
            numbers,
            channels=channel,
            method=method,  # type: ignore[arg-type]
            revolutions=revolutions,
            bandwidth=bandwidth or None,
            slow_roll=slow_roll or None,
            progress=update,
        )
    files.save(found, lambda: ab.plot.orders(found, speed_unit=speed_unit))
    columns = found.columns(speed_unit)
    if as_json:
        names = ("amplitude", "phase", "amplitude_deviation", "phase_deviation", "bias")
        grid = {name: found[name].values for name in ("order", "channel", "units", "time", "speed")}
        print_json(grid | {name: found[name].values for name in names} | {"method": found.attrs["method"]})
    elif as_csv:
        print_csv(columns)
    else:
        print_facts(found.facts(), found.heading())
        print_sheet(columns)
        files.say()

"""``autobalancer measure spectrum`` and ``order-map``: amplitudes over the frequency, and over the speed."""

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
    tacho_of,
    with_angle,
)
from autobalancer.cli.terminal.blocks import in_blocks
from autobalancer.cli.terminal.options import Csv, FrequencyUnit, Json, Outs, Plot, SpeedUnit, Unit


@in_blocks
def spectrum(
    file: SignalFile,
    channel: Chosen = None,
    window: Annotated[str, typer.Option(help="hann, flattop, blackmanharris or boxcar.")] = "hann",
    resolution: Annotated[str, typer.Option(help='Between the frequencies, such as "0.5 Hz".')] = "",
    natural: Annotated[
        list[str] | None,
        typer.Option(help='Natural frequency by which lines are named, such as "9.6 Hz". May be repeated.'),
    ] = None,
    reading: Reading = READING,
    turning: Turning = TURNING,
    out: Outs = None,
    plot: Plot = None,
    frequency_unit: FrequencyUnit = SpeedUnit.HZ,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Averaged spectrum of signals at one speed, and the lines in it with their names: orders, subsynchronous lines of balls.

    Example: autobalancer measure spectrum run_up_signals.csv --start "12 s" \\
      --plot spectrum.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    known = [float(quantity("--natural", text, "rad/s")) for text in natural or []]
    signals = reading.signals(file)
    if tacho_of(signals, turning.tacho):
        signals = with_angle(signals, turning)
    found = ab.measure.spectrum(signals, channel, window=window, resolution=resolution or None, natural=known)
    files.save(found, lambda: ab.plot.spectrum(found, frequency_unit=frequency_unit))
    columns = found.columns(frequency_unit)
    if as_json:
        names = (
            "channel",
            "frequency",
            "amplitude",
            "density",
            "line_channel",
            "line_frequency",
            "line_frequency_deviation",
            "line_amplitude",
            "line_amplitude_deviation",
            "line_name",
        )
        print_json({name: found[name].values for name in names} | {"speed": found.attrs["speed"]})
    elif as_csv:
        print_csv(columns)
    else:
        print_facts(found.facts(), found.heading())
        print_sheet(columns)
        files.say()


@in_blocks
def order_map(
    file: SignalFile,
    channel: Annotated[str, typer.Option(help="Of the signals; by default the first vibration.")] = "",
    over: Annotated[str, typer.Option(help="order or frequency.")] = "order",
    highest: Annotated[float, typer.Option(help="With --over order: the highest order.")] = 5.0,
    revolutions: Annotated[float, typer.Option(help="In a window.")] = 16.0,
    reading: Reading = READING,
    turning: Turning = TURNING,
    phase: Phase = PHASE,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
) -> None:
    """Amplitude over the speed and over order or frequency, of a measured run-up or run-down.

    Example: autobalancer measure order-map run_up_signals.csv --channel x \\
      --plot map.png
    """
    from autobalancer.cli.terminal.output import Files, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.sheet import print_facts

    files = Files(out, plot)
    most = highest if over == "order" else None
    with progress_bar("map") as update:
        signals = with_angle(reading.signals(file), turning, phase)
        found = ab.measure.order_map(
            signals,
            channel,
            over=over,  # type: ignore[arg-type]
            highest=most,
            revolutions=revolutions,
            progress=update,
        )
    files.save(found, lambda: ab.plot.order_map(found, speed_unit=speed_unit))
    if as_json:
        print_json({str(name): found[name].values for name in found.variables})
        return
    print_facts(found.facts(), found.heading())
    files.say()

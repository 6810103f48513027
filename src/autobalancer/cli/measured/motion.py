"""``autobalancer measure damping``, ``orbit`` and ``envelope``: a decay, the path of a shaft, the extent of a vibration."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.measured.given import (
    READING,
    TURNING,
    Chosen,
    Reading,
    SignalFile,
    Turning,
    tacho_of,
    with_angle,
)
from autobalancer.cli.terminal.blocks import in_blocks
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note


@in_blocks
def damping(
    file: SignalFile,
    channel: Annotated[str, typer.Option(help="Of the signals; by default the only vibration.")] = "",
    modes: Annotated[int, typer.Option(help="Number of decaying oscillations.")] = 1,
    reading: Reading = READING,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Frequency and damping of a measured decay, with their standard deviations, from the greatest value or --start on.

    Example: autobalancer measure damping decay_signals.csv --plot decay.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import Column, print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    found = ab.measure.damping(reading.signals(file), channel, modes=modes)
    files.save(found, lambda: ab.plot.damping(found))
    hertz, percent = 0.5 / math.pi, 100.0
    columns = [
        Column("mode", found["mode"].values.tolist()),
        Column("frequency", found["frequency"].values * hertz, "Hz", ".6g"),
        Column("+-", found["frequency_uncertainty"].values * hertz, "Hz", ".2g"),
        Column("damping ratio", found["damping_ratio"].values * percent, "%", ".5g"),
        Column("+-", found["damping_ratio_uncertainty"].values * percent, "%", ".2g"),
        Column("decay rate", found["decay_rate"].values, "1/s", ".5g"),
        Column("logarithmic decrement", found["logarithmic_decrement"].values, "", ".4g"),
    ]
    if as_json:
        print_json({str(name): found[name].values for name in found.data_vars if found[name].dims == ("mode",)})
    elif as_csv:
        print_csv(columns)
    else:
        print_sheet(columns, str(found.attrs["title"]))
        for text in filter(None, str(found.attrs["warnings"]).split("\n")):
            note(text)
        files.say()


@in_blocks
def orbit(
    file: SignalFile,
    x: Annotated[str, typer.Option(help="Channel along x; by default the only one with this direction.")] = "",
    y: Annotated[str, typer.Option(help="Channel along y.")] = "",
    at: Annotated[str, typer.Option(help='Instant in the middle of the orbit, such as "8 s".')] = "",
    order: Annotated[str, typer.Option("--orders", help="Orders of the speed, such as 1,2.")] = "1,2",
    revolutions: Annotated[float, typer.Option(help="That are drawn, and from which orders are fitted.")] = 4.0,
    reading: Reading = READING,
    turning: Turning = TURNING,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """The orbit of a shaft as measured, and the ellipses of its orders.

    Example: autobalancer measure orbit run_up_signals.csv --at "9 s" \\
      --plot orbit.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import Column, print_sheet
    from autobalancer.cli.terminal.words import say, speed_text
    from autobalancer.units.ranges import listed

    one_form(as_json, as_csv)
    files = Files(out, plot)
    signals = with_angle(reading.signals(file), turning)
    wanted: Any = tuple(listed("--orders", order, ""))
    found = ab.measure.orbit(signals, x, y, at=at or None, revolutions=revolutions, orders=wanted)
    files.save(found, lambda: ab.plot.measured_orbit(found, speed_unit=speed_unit))
    um = {name: 1e6 * found[name].values for name in ("semi_major", "semi_minor", "forward", "backward")}
    columns = [
        Column("order", found["order"].values.tolist(), form="g"),
        *(Column(name.replace("_", "-"), values, "µm", ".4g") for name, values in um.items()),
        Column("tilt", found["tilt"].values * 180.0 / math.pi, "deg", ".1f"),
    ]
    if as_json:
        names = [str(name) for name in found.data_vars if found[name].dims == ("order",)]
        print_json({name: found[name].values for name in ("order", *names)} | {"speed": found.attrs["speed"]})
    elif as_csv:
        print_csv(columns)
    else:
        print_sheet(columns, str(found.attrs["title"]))
        say(f"speed {speed_text(found.attrs['speed'])}")
        files.say()


@in_blocks
def envelope(
    file: SignalFile,
    revolutions: Annotated[float, typer.Option(help="Of a bin; at least one.")] = 1.0,
    bin_length: Annotated[str, typer.Option(help='In place of revolutions, such as "50 ms".')] = "",
    channel: Chosen = None,
    reading: Reading = READING,
    turning: Turning = TURNING,
    out: Outs = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Least and greatest value of a vibration in each turn, and where it is widest.

    Example: autobalancer measure envelope run_up_signals.csv --out turns.csv
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import Column, print_sheet
    from autobalancer.results.display_units import speed_axis

    one_form(as_json, as_csv)
    files = Files(out)
    signals = reading.signals(file)
    if not bin_length or tacho_of(signals, turning.tacho):
        signals = with_angle(signals, turning)
    found = ab.measure.envelope(signals, channel, revolutions=revolutions, bin_length=bin_length or None)
    files.save(found.transpose("bin", "channel").assign_coords(bin=list(range(1, found.sizes["bin"] + 1))))
    widest = (found["envelope_high"] - found["envelope_low"]).argmax("bin")
    columns = [
        Column("channel", found["channel"].values.tolist()),
        Column("least", found["envelope_low"].isel(bin=widest).values, "", ".4g"),
        Column("greatest", found["envelope_high"].isel(bin=widest).values, "", ".4g"),
        Column("unit", found["units"].values.tolist()),
        Column("at", found["envelope_time"].isel(bin=widest).values, "s", ".5g"),
    ]
    if "envelope_speed" in found:
        unit = speed_axis(speed_unit)
        columns += [Column("speed", found["envelope_speed"].isel(bin=widest).values * unit.factor, unit.sign, ".5g")]
    if as_json:
        print_json({str(name): part.values for name, part in found.variables.items()})
    elif as_csv:
        print_csv(columns)
    else:
        print_sheet(columns, f"{found.attrs['title']}: where each channel is widest, of {found.sizes['bin']} bins")
        files.say()

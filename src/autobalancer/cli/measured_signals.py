"""``autobalancer measure signals``: what is in a file of measured signals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, FrequencyUnit, Json, Outs, Plot, Seed, SpeedUnit, Unit, in_blocks
from autobalancer.cli.terminal.sheet import note

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.results.answers.answer import Answer


# Options of the commands that read measured signals, and the signals that they describe.


SignalFile = Annotated[
    Path, typer.Argument(help="Table with units in its column names, .uff, .wav, .npz, .mat, or a result file (.nc).")
]
Channels = Annotated[
    Path | None, typer.Option(help="TOML file that says what the columns are; by default NAME.channels.toml beside.")
]
Chosen = Annotated[list[str] | None, typer.Option("--channel", help="Use this channel. May be repeated.")]
Rate = Annotated[str, typer.Option(help='Sampling rate where the file has no time, such as "2 kHz".')]
Resample = Annotated[str, typer.Option(help='Bring uneven samples to this rate, such as "2 kHz".')]
Start = Annotated[str, typer.Option(help='Use the file from here, such as "1 s".')]
End = Annotated[str, typer.Option(help='Use it up to here, such as "12 s".')]
Tacho = Annotated[str, typer.Option(help="Channel of the tacho; by default the only one.")]
PulsesOption = Annotated[int, typer.Option(help="Marks of the tacho on a turn, evenly spaced.")]
Edge = Annotated[str, typer.Option(help="Which edge of a pulse counts: rising or falling.")]
Index = Annotated[str, typer.Option(help="Channel with one pulse a turn, where the tacho has several.")]
TachoAngle = Annotated[str, typer.Option(help='Where the tacho looks at the shaft, from the x axis: "90 deg".')]


@dataclass(frozen=True)
class Reading:
    """How the file of signals is read."""

    channels: Channels = None
    rate: Rate = ""
    resample: Resample = ""
    start: Start = ""
    end: End = ""

    def signals(self, file: Path) -> xr.Dataset:
        """Read it."""
        from autobalancer.cli.terminal.options import optional
        from autobalancer.measurement.signals.load import load_signals

        return load_signals(
            file,
            self.channels,
            rate=self.rate or None,
            resample=self.resample or None,
            start=optional("--start", self.start, "s"),
            end=optional("--end", self.end, "s"),
        )


@dataclass(frozen=True)
class Turning:
    """What says how the rotor turns."""

    tacho: Tacho = ""
    pulses: PulsesOption = 1


@dataclass(frozen=True)
class Phase:
    """What says where the rotor is at an instant, so that phases have a meaning."""

    edge: Edge = "rising"
    tacho_angle: TachoAngle = ""
    index: Index = ""


READING, TURNING, PHASE = Reading(), Turning(), Phase()  # as they are unless something is asked


def with_angle(signals: xr.Dataset, turning: Turning, phase: Phase = PHASE) -> xr.Dataset:
    """Signals with the angle of the rotor, from their tacho if they have none yet."""
    from autobalancer.cli.terminal.options import optional
    from autobalancer.measurement.orders.angle import rotor_angle

    if "rotor_angle" in signals:
        return signals
    looks = optional("--tacho-angle", phase.tacho_angle, "rad")
    return rotor_angle(
        signals, turning.tacho, pulses=turning.pulses, edge=phase.edge, tacho_angle=looks, index=phase.index
    )


def tacho_of(signals: xr.Dataset, tacho: str) -> bool:
    """Whether the signals have a tacho, or one was named."""
    return bool(tacho) or any(entry.attrs.get("quantity") == "tacho" for entry in signals.data_vars.values())


@in_blocks
def signals(
    file: SignalFile,
    reading: Reading = READING,
    to: Annotated[str, typer.Option(help="Make displacement, velocity or acceleration of the vibrations.")] = "",
    corner: Annotated[str, typer.Option(help='High pass where that integrates, such as "2 Hz".')] = "",
    channel: Chosen = None,
    out: Outs = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Read measured signals, check them, list their channels, and write them in another form or as another quantity.

    Example: autobalancer measure signals run_up_signals.csv --out run_up.nc
    """
    from autobalancer.cli.terminal.output import SIGNALS, Files, one_form
    from autobalancer.errors import QuestionError

    one_form(as_json, as_csv)
    if (corner or channel) and not to:
        raise QuestionError("--corner, --channel: say with --to what the vibrations are to become")
    files = Files(out, allowed=SIGNALS)
    found = reading.signals(file)
    if to:
        found = ab.measure.converted(found, to, corner=corner or None, channels=channel)
    files.save(found)
    tell_signals(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


# An answer of the group on the screen: its facts, its table, its remarks; or as JSON or CSV.


def tell(found: Answer, as_json: bool, as_csv: bool) -> None:
    """Print it in the form that was asked for."""
    from autobalancer.cli.terminal.output import one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.results.export import plain_json

    one_form(as_json, as_csv)
    if as_json:
        values = {str(name): entry.values.tolist() for name, entry in found.variables.items()}
        print_json(plain_json(values | {"remarks": list(found.remarks())}))
    elif as_csv:
        print_csv(found.columns())
    else:
        if found.facts():
            print_facts(list(found.facts()), found.heading())
        print_sheet(found.columns(), "" if found.facts() else found.heading())
        for text in found.remarks():
            note(text)


def tell_signals(found: xr.Dataset, as_json: bool, as_csv: bool) -> None:
    """Print the channels of signals, not their samples, in the form that was asked for."""
    from autobalancer.cli.terminal.output import print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    if as_json:
        about = {"sampling_rate": found.attrs["sampling_rate"], "samples": found.sizes["time"]}
        print_json(about | {"channels": {str(name): entry.attrs for name, entry in found.data_vars.items()}})
    elif as_csv:
        print_csv(found.columns())
    else:
        print_facts(found.facts(), found.heading())
        print_sheet(found.columns())


# ``autobalancer measure spectrum`` and ``order-map``: amplitudes over the frequency, and over the speed.


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
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
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
    from autobalancer.cli.terminal.progress_bar import progress_bar
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


# ``autobalancer measure orders``: amplitude and phase of orders of the speed.


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
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.units.quantity import listed

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


# ``autobalancer measure damping``, ``orbit`` and ``envelope``: a decay, the path of a shaft, the extent of a
# vibration.


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
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.tables import Column

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
    from autobalancer.cli.terminal.sheet import print_sheet, say, speed_text
    from autobalancer.tables import Column
    from autobalancer.units.quantity import listed

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
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.results.display_units import speed_axis
    from autobalancer.tables import Column

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


# ``autobalancer measure record``: a run as a logger would have measured it.


FORM = "QUANTITY:PLACE:DIRECTION:NOISE"


def record(
    run: Annotated[Path, typer.Argument(help="Result of a run with enough samples (.nc).")],
    sensor: Annotated[
        list[str],
        typer.Option(
            help=f"A sensor as {FORM}, such as displacement:laser:x:40 dB or acceleration::30. The place, the direction "
            "(x, y or degrees from x) and the noise (a standard deviation or dB) may be left out. May be repeated."
        ),
    ],
    rate: Annotated[str, typer.Option(help='Sampling rate, such as "5 kHz".')],
    pulses: Annotated[int, typer.Option(help="Pulses of the tacho in a turn; 0 for no tacho.")] = 1,
    start: Annotated[str, typer.Option(help='Begin with this time of the run, such as "1 s".')] = "",
    end: Annotated[str, typer.Option(help='End with it, such as "3 s".')] = "",
    seed: Seed = 0,
    out: Outs = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Make a logger file of a run: sensors with noise, and a tacho.

    Example: autobalancer measure record stall.nc --sensor "displacement::x:40 dB" \\
      --rate "2 kHz" --out logger.csv
    """
    from autobalancer.cli.terminal.options import optional
    from autobalancer.cli.terminal.output import SIGNALS, Files, one_form

    one_form(as_json, as_csv)
    files = Files(out, allowed=SIGNALS)
    sensors = [_sensor(text) for text in sensor]
    tacho = [ab.measure.Tacho(pulses=pulses)] if pulses else []
    found = ab.measure.record(
        ab.load_run(run),
        [*sensors, *tacho],
        rate,
        start=optional("--start", start, "s"),
        end=optional("--end", end, "s"),
        seed=seed,
    )
    files.save(found)
    tell_signals(found, as_json, as_csv)
    if not (as_json or as_csv):
        for text in found.remarks():
            note(text)
        files.say()


def _sensor(text: str) -> ab.measure.Sensor:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) > len(FORM.split(":")):
        raise ab.errors.QuestionError(f"--sensor: given {text!r}; write {FORM}, such as displacement:laser:x:40 dB")
    quantity, place, direction, noise = (parts + [""] * 3)[:4]
    return ab.measure.Sensor(quantity, place, direction or "x", noise=noise or 0.0)  # type: ignore[arg-type]


# ``autobalancer measure rubber-signals``: rubber of a machine file from recorded force and deflection.


def rubber_signals(
    records: Annotated[
        list[Path],
        typer.Argument(help="Signals with a deflection and a force, such as time \\[s], deflection \\[mm], force [N]."),
    ],
    frequency: Annotated[str | None, typer.Option(help="Of the motion; by default that of the deflection.")] = None,
    law: Annotated[str, typer.Option(help="Of the friction elements: elastoplastic or endochronic.")] = "elastoplastic",
    viscous: Annotated[bool, typer.Option("--viscous/--no-viscous", help="With a viscous part.")] = True,
    out: Annotated[Path | None, typer.Option(help="The lines of a machine file, as .toml.")] = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Rubber that softens with the amplitude, from recorded hysteresis loops to the lines of a machine file.

    Example: autobalancer measure rubber-signals rubber_signals.csv --out rubber.toml --plot rubber.png
    """
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.output import MACHINE, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.plots.drawing.style import save_picture
    from autobalancer.plots.measured.rubber import rubber as picture
    from autobalancer.safe_file import write_text_safely
    from autobalancer.tables import Column

    one_form(as_json, as_csv)
    files = Files(out, plot, MACHINE)
    w = None if frequency is None else float(quantity("--frequency", frequency, "rad/s"))
    points = ab.measure.rubber_signals(records, frequency=w)
    found = ab.measure.rubber(points, law=law, viscous=viscous)  # type: ignore[arg-type]
    if out is not None:
        write_text_safely(out, found.toml())
    if plot is not None:
        save_picture(picture(found), plot)
    columns = [
        Column("frequency", points.frequency / 6.283185307179586, "Hz", ".4g"),
        Column("amplitude", 1e3 * points.amplitude, "mm", ".4g"),
        Column("K'", 1e-3 * points.stiffness, "kN/m", ".4g"),
        Column("+-", 1e-3 * points.stiffness_uncertainty, "kN/m", ".2g"),
        Column("K''", 1e-3 * points.loss, "kN/m", ".4g"),
        Column("+-", 1e-3 * points.loss_uncertainty, "kN/m", ".2g"),
        Column("K' fitted", 1e-3 * found.fitted.real, "kN/m", ".4g"),
        Column("K'' fitted", 1e-3 * found.fitted.imag, "kN/m", ".4g"),
    ]
    if as_json:
        print_json(
            {"points": {f"{c.head} [{c.unit}]": list(map(float, c.values)) for c in columns}, "lines": found.toml()}
        )
        return
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "Loops, and the rubber that was fitted to them")
    for text in found.remarks:
        note(text)
    files.say()

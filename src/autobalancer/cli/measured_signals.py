"""``autobalancer measure signals``: what is in a file of measured signals."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import MACHINE, SIGNALS, Reply, command
from autobalancer.cli.terminal.options import In, Listed
from autobalancer.cli.terminal.sheet import speed_sign
from autobalancer.tables import Column

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.results.answers.rubber import RubberFit


# Options of the commands that read measured signals, and the signals that they describe.


SignalFile = Annotated[
    Path, typer.Argument(help="Table with units in its column names, .uff, .wav, .npz, .mat, or a result file (.nc).")
]
Chosen = Annotated[list[str] | None, typer.Option("--channel", help="Use this channel. May be repeated.")]
Orders = Annotated[str, Listed(""), typer.Option("--orders", help="Orders of the speed, such as 1,2.")]


@dataclass(frozen=True)
class Reading:
    """How the file of signals is read."""

    channels: Annotated[
        Path | None, "TOML file that says what the columns are; by default NAME.channels.toml beside."
    ] = None
    rate: Annotated[str | None, 'Sampling rate where the file has no time, such as "2 kHz".'] = None
    resample: Annotated[str | None, 'Bring uneven samples to this rate, such as "2 kHz".'] = None
    start: Annotated[float | None, In("s"), 'Use the file from here, such as "1 s".'] = None
    end: Annotated[float | None, In("s"), 'Use it up to here, such as "12 s".'] = None

    def signals(self, file: Path) -> xr.Dataset:
        """Read it."""
        return ab.measure.load_signals(
            file, self.channels, rate=self.rate, resample=self.resample, start=self.start, end=self.end
        )


@dataclass(frozen=True)
class Turning:
    """What says how the rotor turns."""

    tacho: Annotated[str, "Channel of the tacho; by default the only one."] = ""
    pulses: Annotated[int, "Marks of the tacho on a turn, evenly spaced."] = 1


@dataclass(frozen=True)
class Phase:
    """What says where the rotor is at an instant, so that phases have a meaning."""

    edge: Annotated[str, "Which edge of a pulse counts: rising or falling."] = "rising"
    tacho_angle: Annotated[
        float | None, In("rad"), 'Where the tacho looks at the shaft, from the x axis: "90 deg".'
    ] = None
    index: Annotated[str, "Channel with one pulse a turn, where the tacho has several."] = ""


READING, TURNING, PHASE = Reading(), Turning(), Phase()  # as they are unless something is asked


def with_angle(signals: xr.Dataset, turning: Turning, phase: Phase = PHASE) -> xr.Dataset:
    """Signals with the angle of the rotor, from their tacho if they have none yet."""
    if "rotor_angle" in signals:
        return signals
    how: Any = {"edge": phase.edge, "tacho_angle": phase.tacho_angle, "index": phase.index}
    return ab.measure.rotor_angle(signals, turning.tacho, pulses=turning.pulses, **how)


def tacho_of(signals: xr.Dataset, tacho: str) -> bool:
    """Whether the signals have a tacho, or one was named."""
    return bool(tacho) or any(entry.attrs.get("quantity") == "tacho" for entry in signals.data_vars.values())


@command(allowed=SIGNALS)
def signals(
    file: SignalFile,
    reading: Reading = READING,
    to: Annotated[str, "Make displacement, velocity or acceleration of the vibrations."] = "",
    corner: Annotated[str | None, 'High pass where that integrates, such as "2 Hz".'] = None,
    channel: Chosen = None,
) -> Reply:
    """Read measured signals, check them, list their channels, and write them in another form or as another quantity.

    Example: autobalancer measure signals run_up_signals.csv --out run_up.nc
    """
    if (corner or channel) and not to:
        raise ab.errors.QuestionError("--corner, --channel: say with --to what the vibrations are to become")
    found = reading.signals(file)
    return channels_of(ab.measure.converted(found, to, corner=corner, channels=channel) if to else found)


def channels_of(found: xr.Dataset) -> Reply:
    """Signals as a reply: their channels, not their samples."""
    about = {"sampling_rate": found.attrs["sampling_rate"], "samples": found.sizes["time"]}
    return Reply(found, about | {"channels": {str(name): entry.attrs for name, entry in found.data_vars.items()}})


# ``autobalancer measure spectrum`` and ``order-map``: amplitudes over the frequency, and over the speed.


@command("measure.spectrum", take="window resolution:Hz", draw="spectrum", unit="frequency")
def spectrum(
    file: SignalFile,
    channel: Chosen = None,
    natural: Annotated[
        list[float] | None,
        In("rad/s"),
        'Natural frequency by which lines are named, such as "9.6 Hz". May be repeated.',
    ] = None,
    reading: Reading = READING,
    turning: Turning = TURNING,
    **options: Any,
) -> Any:
    """Averaged spectrum of signals at one speed, and the lines in it with their names: orders, subsynchronous lines of balls.

    Example: autobalancer measure spectrum run_up_signals.csv --start "12 s" \\
      --plot spectrum.png
    """
    signals = reading.signals(file)
    if tacho_of(signals, turning.tacho):
        signals = with_angle(signals, turning)
    return ab.measure.spectrum(signals, channel, natural=natural or [], **options)


@command("measure.order_map", take="channel over revolutions", draw="order_map", unit="speed", bar="map", csv=False)
def order_map(
    file: SignalFile,
    highest: Annotated[float, "With --over order: the highest order."] = 5.0,
    reading: Reading = READING,
    turning: Turning = TURNING,
    phase: Phase = PHASE,
    **options: Any,
) -> Reply:
    """Amplitude over the speed and over order or frequency, of a measured run-up or run-down.

    Example: autobalancer measure order-map run_up_signals.csv --channel x \\
      --plot map.png
    """
    signals = with_angle(reading.signals(file), turning, phase)
    found = ab.measure.order_map(signals, highest=highest if options["over"] == "order" else None, **options)
    return Reply(found, columns=[])


# ``autobalancer measure orders``: amplitude and phase of orders of the speed.


@command("measure.orders", take="method revolutions bandwidth:Hz slow_roll", draw="orders", unit="speed", bar="orders")
def orders(
    file: SignalFile,
    order: Orders = "1",
    channel: Chosen = None,
    reading: Reading = READING,
    turning: Turning = TURNING,
    phase: Phase = PHASE,
    **options: Any,
) -> Any:
    """Amplitude and phase of orders of the speed in a measured run-up or run-down, with their uncertainty.

    Example: autobalancer measure orders run_up_signals.csv --slow-roll "0:4 s" \\
      --plot orders.png
    """
    signals = with_angle(reading.signals(file), turning, phase)
    return ab.measure.orders(signals, order, channels=channel, **options)  # type: ignore[arg-type]


# ``autobalancer measure damping``, ``orbit`` and ``envelope``: a decay, the path of a shaft, the extent of a
# vibration.


@command("measure.damping", take="channel modes", draw="damping")
def damping(file: SignalFile, reading: Reading = READING, **options: Any) -> Any:
    """Frequency and damping of a measured decay, with their standard deviations, from the greatest value or --start on.

    Example: autobalancer measure damping decay_signals.csv --plot decay.png
    """
    return ab.measure.damping(reading.signals(file), **options)


@command("measure.orbit", take="x y at:s revolutions", draw="measured_orbit", unit="speed")
def orbit(
    file: SignalFile,
    orders: Orders = "1,2",
    reading: Reading = READING,
    turning: Turning = TURNING,
    **options: Any,
) -> Any:
    """The orbit of a shaft as measured, and the ellipses of its orders.

    Example: autobalancer measure orbit run_up_signals.csv --at "9 s" \\
      --plot orbit.png
    """
    return ab.measure.orbit(with_angle(reading.signals(file), turning), orders=tuple(orders), **options)  # type: ignore[arg-type]


@command("measure.envelope", take="revolutions bin_length:s", unit="speed")
def envelope(
    file: SignalFile,
    channel: Chosen = None,
    reading: Reading = READING,
    turning: Turning = TURNING,
    **options: Any,
) -> Reply:
    """Least and greatest value of a vibration in each turn, and where it is widest.

    Example: autobalancer measure envelope run_up_signals.csv --out turns.csv
    """
    signals = reading.signals(file)
    if not options.get("bin_length") or tacho_of(signals, turning.tacho):
        signals = with_angle(signals, turning)
    found = ab.measure.envelope(signals, channel, **options).transpose("bin", "channel")
    found = found.assign_coords(bin=list(range(1, found.sizes["bin"] + 1)))
    widest = (found["envelope_high"] - found["envelope_low"]).argmax("bin")
    at, found.attrs["title"] = found.isel(bin=widest), f"{found.attrs['title']}: where each channel is widest"
    columns = [Column("channel", found["channel"].values.tolist()), at.texts("units", "unit")]
    for name, head, unit in (("low", "least", ""), ("high", "greatest", ""), ("time", "at", "s")):
        columns.append(Column(head, at[f"envelope_{name}"].values, unit))
    if "envelope_speed" in found:
        columns.append(at.scaled("envelope_speed", "speed", speed_sign()))
    return Reply(found, columns=columns, facts=())


# ``autobalancer measure record``: a run as a logger would have measured it.


FORM = "QUANTITY:PLACE:DIRECTION:NOISE"


@command("measure.record", take="seed", allowed=SIGNALS)
def record(
    run: Annotated[Path, typer.Argument(help="Result of a run with enough samples (.nc).")],
    sensor: Annotated[
        list[str],
        f"A sensor as {FORM}, such as displacement:laser:x:40 dB or acceleration::30. The place, the direction (x, y or "
        "degrees from x) and the noise (a standard deviation or dB) may be left out. May be repeated.",
    ],
    rate: Annotated[str, 'Sampling rate, such as "5 kHz".'],
    pulses: Annotated[int, "Pulses of the tacho in a turn; 0 for no tacho."] = 1,
    start: Annotated[float | None, In("s"), 'Begin with this time of the run, such as "1 s".'] = None,
    end: Annotated[float | None, In("s"), 'End with it, such as "3 s".'] = None,
    **options: Any,
) -> Reply:
    """Make a logger file of a run: sensors with noise, and a tacho.

    Example: autobalancer measure record stall.nc --sensor "displacement::x:40 dB" \\
      --rate "2 kHz" --out logger.csv
    """
    sensors = [_sensor(text) for text in sensor]
    tacho = [ab.measure.Tacho(pulses=pulses)] if pulses else []
    found = ab.measure.record(ab.load_run(run), [*sensors, *tacho], rate, start=start, end=end, **options)
    return channels_of(found)


def _sensor(text: str) -> ab.measure.Sensor:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) > len(FORM.split(":")):
        raise ab.errors.QuestionError(f"--sensor: given {text!r}; write {FORM}, such as displacement:laser:x:40 dB")
    quantity, place, direction, noise = (parts + [""] * 3)[:4]
    return ab.measure.Sensor(quantity, place, direction or "x", noise=noise or 0.0)  # type: ignore[arg-type]


# ``autobalancer measure rubber-signals``: rubber of a machine file from recorded force and deflection.


@command("measure.rubber", take="law viscous", draw="rubber", allowed=MACHINE)
def rubber_signals(
    records: Annotated[
        list[Path],
        typer.Argument(help="Signals with a deflection and a force, such as time \\[s], deflection \\[mm], force [N]."),
    ],
    frequency: Annotated[float | None, In("rad/s"), "Of the motion; by default that of the deflection."] = None,
    **options: Any,
) -> Reply:
    """Rubber that softens with the amplitude, from recorded hysteresis loops to the lines of a machine file.

    Example: autobalancer measure rubber-signals rubber_signals.csv --out rubber.toml --plot rubber.png
    """
    found = ab.measure.rubber(ab.measure.rubber_signals(records, frequency=frequency), **options)
    return rubber_found(found)


def rubber_found(found: RubberFit) -> Reply:
    """Fitted rubber as a reply: its elements and how they meet the points, written as lines of a machine file."""
    points, fitted, law = found.points, found.fitted, found.law
    names = ("name", "frequency", "amplitude", "stiffness", "loss", "fitted_stiffness", "fitted_loss")
    values = (points.names, points.frequency, points.amplitude, points.stiffness, points.loss, fitted.real, fitted.imag)
    numbers = {
        "elastic": law.elastic,
        "viscous": law.viscous,
        "law": law.law,
        "friction": [{"stiffness": k, "breakaway_amplitude": a} for k, a in law.friction],
        "maxwell": [{"stiffness": k, "relaxation_time": t} for k, t in law.maxwell],
        "points": [dict(zip(names, row, strict=True)) for row in zip(*values, strict=True)],
        "remarks": list(found.remarks),
        "lines": found.toml(),
    }
    deviation = abs(fitted.real / points.stiffness - 1.0).max()
    return Reply(
        found, numbers, machine=found.toml(), lines=[f"stiffness of the points within {100.0 * deviation:.2g} %"]
    )


# ``autobalancer rubber``: rubber that softens with the amplitude, from measured loops and resonances.


@command("measure.rubber", take="law spacing viscous", draw="rubber", allowed=MACHINE)
def rubber(
    tables: Annotated[
        list[Path],
        typer.Argument(
            help="Loops: frequency [Hz], amplitude \\[mm], stiffness \\[kN/m], damping [N s/m]. Resonances: mass \\[kg] and "
            "decay rate [1/s] in place of the last two. Perhaps motion, line or circle."
        ),
    ],
    relaxation_time: Annotated[
        list[float] | None, In("s"), 'Of a Maxwell element, such as "5 ms". May be repeated.'
    ] = None,
    **options: Any,
) -> Reply:
    """Fit rubber that softens with the amplitude to hysteresis loops and to resonances at several amplitudes.

    Example: autobalancer rubber rubber_loops.csv --out rubber.toml
    """
    return rubber_found(ab.measure.rubber(tables, relaxation_times=relaxation_time or [], **options))

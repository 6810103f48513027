"""Commands for measured signals and films: the group ``measure``, and ``rubber``."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import MACHINE, SIGNALS, Reply, command
from autobalancer.cli.terminal.options import In, Listed, MachineFile
from autobalancer.cli.terminal.sheet import speed_sign
from autobalancer.tables import Column, whole_degrees

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.results.answers.kinds import RubberFit

TOPIC = "measure"  # where the help of autobalancer lists the commands below


# Options of the commands that read measured signals, and the signals that they describe.


SignalFile = Annotated[
    Path,
    typer.Argument(
        help="Table with units in its column names, .uff, .lvm, .tdms, .h5, .mat, .npz, .wav, or a result (.nc)."
    ),
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


@command("measure.spectrum", take="window resolution:Hz", draw=True, unit="frequency")
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


@command("measure.order_map", take="channel over revolutions", draw=True, unit="speed", bar="map", csv=False)
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


@command("measure.orders", take="method revolutions bandwidth:Hz slow_roll", draw=True, unit="speed", bar="orders")
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


@command("measure.damping", take="channel modes", draw=True)
def damping(file: SignalFile, reading: Reading = READING, **options: Any) -> Any:
    """Frequency and damping of a measured decay, with their standard deviations, from the greatest value or --start on.

    Example: autobalancer measure damping decay_signals.csv --plot decay.png
    """
    return ab.measure.damping(reading.signals(file), **options)


@command("measure.orbit", take="x y at:s revolutions", draw=True, unit="speed")
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
    from autobalancer.results.answers.answer import Shown

    signals = reading.signals(file)
    if not options.get("bin_length") or tacho_of(signals, turning.tacho):
        signals = with_angle(signals, turning)
    found = ab.measure.envelope(signals, channel, **options).transpose("bin", "channel")
    found = found.assign_coords(bin=list(range(1, found.sizes["bin"] + 1)))
    widest = (found["envelope_high"] - found["envelope_low"]).argmax("bin")
    at, found.attrs["title"] = found.isel(bin=widest), f"{found.attrs['title']}: where each channel is widest"
    columns = [Column("channel", found["channel"].values.tolist()), *at.shown("", Shown("units", "unit"))]
    for name, head, unit in (("low", "least", ""), ("high", "greatest", ""), ("time", "at", "s")):
        columns.append(Column(head, at[f"envelope_{name}"].values, unit))
    if "envelope_speed" in found:
        columns += at.shown(speed_sign(), Shown("envelope_speed", "speed"))
    return Reply(found, columns=columns, facts=())


# ``autobalancer measure record``: a run as a logger would have measured it.


FORM = "QUANTITY:PLACE:DIRECTION:NOISE"


@command("measure.record", take="start:s end:s seed", allowed=SIGNALS)
def record(
    run: Annotated[Path, typer.Argument(help="Result of a run with enough samples (.nc).")],
    sensor: Annotated[
        list[str],
        f"A sensor as {FORM}, such as displacement:laser:x:40 dB or acceleration::30. The place, the direction (x, y or "
        "degrees from x) and the noise (a standard deviation or dB) may be left out. May be repeated.",
    ],
    rate: Annotated[str, 'Sampling rate, such as "5 kHz".'],
    pulses: Annotated[int, "Pulses of the tacho in a turn; 0 for no tacho."] = 1,
    **options: Any,
) -> Reply:
    """Make a logger file of a run: sensors with noise, and a tacho.

    Example: autobalancer measure record stall.nc --sensor "displacement::x:40 dB" \\
      --rate "2 kHz" --out logger.csv
    """
    sensors = [_sensor(text) for text in sensor]
    tacho = [ab.measure.Tacho(pulses=pulses)] if pulses else []
    return channels_of(ab.measure.record(ab.load_run(run), [*sensors, *tacho], rate, **options))


def _sensor(text: str) -> ab.measure.Sensor:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) > len(FORM.split(":")):
        raise ab.errors.QuestionError(f"--sensor: given {text!r}; write {FORM}, such as displacement:laser:x:40 dB")
    quantity, place, direction, noise = (parts + [""] * 3)[:4]
    return ab.measure.Sensor(quantity, place, direction or "x", noise=noise or 0.0)  # type: ignore[arg-type]


# ``autobalancer measure rubber-signals``: rubber of a machine file from recorded force and deflection.


@command("measure.rubber", take="law viscous", draw=True, allowed=MACHINE)
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
    return rubber_reply(found)


def rubber_reply(found: RubberFit) -> Reply:
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


@command(
    "measure.rubber",
    take="law spacing viscous",
    draw=True,
    allowed=MACHINE,
    topic="From measurements",
)
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
    return rubber_reply(ab.measure.rubber(tables, relaxation_times=relaxation_time or [], **options))


# ``autobalancer measure balance``, ``four-run``, ``run-down``: unbalance and corrections from readings.


EvenHoles = Annotated[int | None, "Split each correction over so many evenly spaced holes."]
StockMasses = Annotated[list[str] | None, "That there is for the holes. May be repeated."]
MostHoles = Annotated[int | None, "Holes that may be used with given masses, 3 unless given."]
RunsFile = Annotated[Path, typer.Argument(help="Runs with their masses and readings, .toml.")]


@command("measure.balance", take="goal planes* deviation", draw=True)
def balance(
    file: RunsFile,
    largest: Annotated[str | None, 'Greatest correction mass, such as "20 g".'] = None,
    influence: Annotated[
        Path | None,
        "Influence coefficients of an earlier job: its answer (.nc) or its runs (.toml); one run is enough then.",
    ] = None,
    runout: Annotated[
        list[str] | None, 'Slow-roll vector that is subtracted, such as "bearing 1: 3 um @ 45 deg". May be repeated.'
    ] = None,
    holes: EvenHoles = None,
    mass: StockMasses = None,
    most: MostHoles = None,
    **options: Any,
) -> Any:
    """Correction masses from runs without and with trial masses, or from one run and known influence coefficients.

    Example: autobalancer measure balance two_plane_job.toml --largest "5 g" --plot balance.png
    """
    vectors = [_runout(one) for one in runout] if runout else None
    options |= _split(holes, mass, most)
    return ab.measure.balance(file, largest=largest, influence=influence, runout=vectors, **options)


def _split(holes: int | None, mass: list[str] | None, most: int | None) -> dict[str, Any]:
    """Arguments of the split of corrections."""
    return {"holes": holes if most is None else {"holes": holes, "most": most}, "stock": mass}


def _runout(text: str) -> Any:
    """A sensor, an amplitude and a phase: ``bearing 1: 3 um @ 45 deg``."""
    sensor, _, vector = text.rpartition(":")
    amplitude, mark, phase = vector.partition("@")
    if not mark:
        raise ab.errors.QuestionError(
            f"runout: given {text!r}; must be SENSOR: AMPLITUDE @ PHASE, such as '1: 3 um @ 45 deg'"
        )
    vector_of: Any = ab.measure.Reading
    return vector_of(amplitude.strip(), phase.strip(), sensor.strip() or "1")


@command("measure.four_run", take="both deviation", draw=True)
def four_run(
    file: RunsFile, holes: EvenHoles = None, mass: StockMasses = None, most: MostHoles = None, **options: Any
) -> Any:
    """Correction in one plane from amplitudes alone: one run without and three with a trial mass.

    Example: autobalancer measure four-run four_runs.toml --plot circles.png
    """
    return ab.measure.four_run(file, **_split(holes, mass, most), **options)


@command("measure.unbalance_from_run_down", draw=True)
def run_down(
    machine: MachineFile,
    file: Annotated[
        Path,
        typer.Argument(
            help="Table: speed \\[rpm], place, direction, amplitude \\[um], phase \\[deg], perhaps amplitude deviation \\[um]; "
            "or orders of this package (.nc)."
        ),
    ],
    plane: Annotated[
        list[str] | None, "Whose unbalance is asked for: a station, or a position such as 0.1 (m). May be repeated."
    ] = None,
) -> Any:
    """Unbalance of all planes from one run-down and a model of the rotor.

    Example: autobalancer measure run-down two_plane_rotor.toml run_down_orders.csv --plane lower --plane upper
    """
    return ab.measure.unbalance_from_run_down(machine, file, planes=[_place(one) for one in plane] if plane else None)


def _place(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


# ``autobalancer measure trial-mass`` and ``split-mass``: before and after a balancing job.


@command("measure.trial_mass", take="radius:m speed:rad/s grade running", out=None, csv=False)
def trial_mass(
    rotor_mass: Annotated[float | None, In("kg"), 'Of the rotor, such as "20 kg".'] = None,
    machine: Annotated[Path | None, "Machine file, as a model."] = None,
    reading: Annotated[str | None, 'Without trial mass, such as "0.1 mm" (peak).'] = None,
    phase: Annotated[float | None, In("rad"), "Of this reading, lead over the mark."] = None,
    **options: Any,
) -> Reply:
    """How large a trial mass should be, and where it should go.

    Example: autobalancer measure trial-mass --radius "100 mm" --speed "1500 rpm" --rotor-mass "20 kg"
    """
    plan = ab.measure.trial_mass(rotor_mass=rotor_mass, machine=machine, reading=reading, phase=phase, **options)
    size = f"{1e3 * plan.mass:.3g} g at a radius of {1e3 * plan.radius:.4g} mm ({1e6 * plan.unbalance:.4g} g mm)"
    facts = [("mass", size), ("from", plan.rule), ("pulls with", f"{plan.force:.3g} N at this speed")]
    if not isnan(plan.angle):
        facts.append(("place", f"{whole_degrees(plan.angle)} deg from the mark, in the sense of rotation"))
    if not isnan(plan.change):
        facts.append(("changes the reading by", f"{100.0 * plan.change:.3g} %"))
    return Reply(plan, heading="Trial mass", facts=facts)


@command("measure.split_mass", take="largest most", out=None, csv=False)
def split_mass(
    mass: Annotated[str, typer.Argument(help='Wanted, such as "15 g" or "900 g*mm".')],
    angle: Annotated[float, In("rad"), typer.Argument(help='Of it, such as "40 deg".')],
    holes: Annotated[int, "Evenly spaced ones."],
    first: Annotated[Any, In("rad"), "Angle of one of them."] = "0 deg",
    available: Annotated[list[str] | None, typer.Option("--mass", help="That there is. May be repeated.")] = None,
    **options: Any,
) -> Reply:
    """Split a correction over holes: exactly, or as near as the masses that there are can come.

    Example: autobalancer measure split-mass "15 g" "40 deg" --holes 6
    """
    found = ab.measure.split_mass(mass, angle, holes=holes, first=first, masses=available or None, **options)
    sign, factor = ("g", 1e3) if found.unit == "kg" else ("g mm", 1e6)
    columns = [
        Column("hole at", [degrees(at) % 360.0 for at in found.angles], "deg", ".4g"),
        Column("mass", [factor * part for part in found.masses], sign, ".4g"),
    ]
    left = f"left: {factor * found.residual:.3g} {sign} at {whole_degrees(found.residual_angle)} deg"
    if available and found.residual > 0.0:
        left += f", the least with up to {options.get('most', 3)} holes; --most allows more"
    return Reply(found, columns=columns, lines=[left])


# ``autobalancer measure balls`` and ``measure film``: balls of a film, and a film of a run.


@command(
    "measure.track_balls",
    take="first_speed:rad/s first_ball_speed:rad/s critical_speed:rad/s",
    draw=True,
    bar="pictures",
)
def balls(
    film: Annotated[Path, typer.Argument(help="Film (.mp4 and others), or a photograph (.png, .jpg).")],
    setup: Annotated[Path, "TOML file with race, balls and marks."],
    frame_rate: Annotated[
        float | None, In("Hz"), 'Of the camera, such as "240 Hz"; by default what the film says.'
    ] = None,
    files: Any = None,
    **options: Any,
) -> Any:
    """Follow the balls of a race through a film, or read their angles from a photograph.

    Example: autobalancer measure balls film.mp4 --setup film.toml --out film.nc
    """
    known = ab.measure.load_film_setup(setup)
    if film.suffix.lower() not in (".png", ".jpg", ".jpeg"):
        return ab.measure.track_balls(film, known, frame_rate=frame_rate, **options)
    del options["progress"]
    if files.plot or frame_rate or any(options.values()):
        raise ab.errors.QuestionError(f"{film}: is a photograph; --plot, --frame-rate and the speeds are for films")
    return ab.measure.photographed_angles(film, known)


@command("measure.render_film", take="start:s end:s seed race", out=None, csv=False, bar="pictures")
def film(
    run: Annotated[Path, typer.Argument(help="Result of a run with enough samples (.nc).")],
    out: Annotated[Path, "The film, as .mp4; its set-up is written beside it as .toml."],
    tilt: Annotated[Any, In("rad"), "Angle between the lens and the axis of the rotor."] = "0 deg",
    turning: Annotated[bool, typer.Option("--turning", help="The camera turns with the rotor.")] = False,
    frame_rate: Annotated[Any, In("Hz"), "Of the camera."] = "240 Hz",
    exposure: Annotated[Any, In("s"), "How long the shutter is open."] = "0.2 ms",
    stroboscope: Annotated[bool, typer.Option("--stroboscope", help="One flash and picture a turn.")] = False,
    noise: Annotated[float, "Standard deviation of a pixel, share of full scale."] = 0.01,
    lost: Annotated[float, "Share of the pictures that are lost."] = 0.0,
    size: Annotated[str, "Of the picture, COLUMNSxROWS."] = "1280x720",
    **options: Any,
) -> Reply:
    """Film a race of a run as a camera would see it: perspective, blur, light, noise, marks.

    Example: autobalancer measure film stall.nc --out film.mp4 --tilt "30 deg" \\
      --end "0.1 s" --size 480x360
    """
    from autobalancer.measurement.film.setup import save_film_setup

    (columns, rows), race = _size(size), options["race"]
    camera = ab.measure.film_camera(run, tilt=tilt, width=columns, height=rows, turning=turning, race=race)
    how = ab.measure.Exposure(
        frame_rate=frame_rate, time=exposure, stroboscope="turn" if stroboscope else "", noise=noise, lost=lost
    )
    known, beside = ab.measure.film_setup(run, camera, race=race), out.with_suffix(".toml")
    _refuse_other_file(beside)
    made = ab.measure.render_film(run, out, camera=camera, exposure=how, **options)
    save_film_setup(known, beside)
    return Reply(
        made,
        {"film": str(out), "setup": str(out.with_suffix(".toml")), "pictures": made.time.size},
        columns=[],
        lines=[
            f"{made.time.size} pictures from {made.time[0]:.6g} s to {made.time[-1]:.6g} s",
            f"film: {out}",
            f"set-up: {out.with_suffix('.toml')}",
        ],
    )


def _refuse_other_file(path: Path) -> None:
    """Refuse a place for a set-up that cannot be written, or where something else is, such as a machine."""
    from autobalancer.safe_file import ready_to_write

    ready_to_write(path)
    if path.exists():
        try:
            ab.measure.load_film_setup(path)
        except ab.errors.AutobalancerError:
            raise ab.errors.QuestionError(
                f"{path}: is there and no set-up of a film, which is written beside the film; give --out another name"
            ) from None


def _size(text: str) -> tuple[int, int]:
    columns, cross, rows = text.lower().partition("x")
    if not (cross and columns.strip().isdecimal() and rows.strip().isdecimal()):
        raise ab.errors.QuestionError(f"--size: given {text!r}; write COLUMNSxROWS, such as 1280x720")
    return int(columns), int(rows)


# ``autobalancer measure race-shape``, ``rest-friction``, ``drag-from-lag``: races and balls from measurements.


@command("measure.race_shape", take="waves", draw=True, allowed=MACHINE)
def race_shape(
    file: Annotated[Path, typer.Argument(help="Table: angle \\[deg], and radius \\[mm] or deviation \\[um].")],
    center: Annotated[
        str, "Around what it was measured: the axis of the rotor, or a setup whose eccentricity goes."
    ] = "axis",
    **options: Any,
) -> Reply:
    """Roundness, eccentricity and waves of a race from its measured profile, for a machine file.

    Example: autobalancer measure race-shape race_profile.csv --out waves.toml --plot waves.png
    """
    found = ab.measure.race_shape(file, center=center, **options)  # type: ignore[arg-type]
    return Reply(found, machine=found.machine_lines())


@command("measure.rest_friction", take="speed:rad/s", draw=True, out=None, csv=False)
def rest_friction(
    machine: MachineFile,
    file: Annotated[
        Path, typer.Argument(help="Table: angle \\[deg] of each rest, from the place opposite the unbalance.")
    ],
    **options: Any,
) -> Reply:
    """Adherence between a ball and its race from where it came to rest in many run-ups.

    Example: autobalancer measure rest-friction one_ball_run_up.toml rest_positions.csv --speed "1200 rpm"
    """
    found = ab.measure.rest_friction(machine, file, **options)
    low, high = degrees(found.width_low), degrees(found.width_high)
    middle = f"{degrees(found.middle):.3g} +- {degrees(found.middle_deviation):.2g} deg from the balanced place"
    facts = [
        ("adherence", f"{found.adherence:.4g}, from {found.low:.4g} to {found.high:.4g} with 95 %"),
        ("rests lie within", f"{degrees(found.width):.4g} deg, from {low:.4g} to {high:.4g} deg with 95 %"),
        ("middle", middle),
        ("rests", str(len(found.angles))),
    ]
    return Reply(found, heading="Friction from rest positions", facts=facts)


@command("measure.drag_from_lag", take="rolling", out=None, csv=False)
def drag_from_lag(
    machine: MachineFile,
    file: Annotated[
        Path, typer.Argument(help="Table: time \\[s], rotor speed \\[rpm], ball speed \\[rpm], both in space.")
    ],
    **options: Any,
) -> Reply:
    """Drag and rolling resistance of a ball from how far it lags behind the rotor in a run-up.

    Example: autobalancer measure drag-from-lag one_ball_run_up.toml ball_lag.csv
    """
    found = ab.measure.drag_from_lag(machine, file, **options)
    facts = [
        ("drag", f"{found.drag:.4g} +- {found.drag_deviation:.2g} N m s"),
        ("rolling resistance", f"{found.rolling_resistance:.4g} +- {found.rolling_resistance_deviation:.2g}"),
        ("correlation of both", f"{found.correlation:.3g}"),
        ("left of the speed", f"{found.scatter:.3g} rad/s"),
    ]
    return Reply(found, heading="Drag from the lag of a ball", facts=facts)

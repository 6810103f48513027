"""Sensors on a simulated machine: what a logger would have written of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import xarray as xr
from scipy.interpolate import BSpline, make_interp_spline
from scipy.signal import butter, sosfilt, sosfilt_zi

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.measurement.signals import Channel, hertz_argument, signals
from autobalancer.random_numbers import generator
from autobalancer.results.time_series import of_a_run
from autobalancer.units import argument

# A run of a machine as a logger would have measured it.


MOST = 50_000_000  # samples of a channel


@of_a_run()
def record(
    run: xr.Dataset,
    sensors: Sequence[Sensor | Tacho],
    sampling_rate: float | str,
    *,
    start: float | str | None = None,
    end: float | str | None = None,
    seed: int = 0,
) -> xr.Dataset:
    """Measure a run with sensors, as a logger would.

    Between the samples of the run its motion is a spline of degree 5, whose derivatives are velocity and acceleration. The run
    must have enough samples for that; otherwise the number that it needs is given. Displacements count as those of the run do,
    from the rest position; accelerations are without gravity.

    Parameters
    ----------
    run
        From :func:`autobalancer.simulate`, with ``Samples``.
    sensors
        :class:`Sensor` and :class:`Tacho`, one for each channel.
    sampling_rate
        Hz, or a text such as "5 kHz".
    start, end
        Part of the run, s; by default all of it.
    seed
        Of the noise and of lost pulses. A channel keeps its noise if others are added behind it.

    Returns
    -------
    xarray.Dataset
        Signals, as :func:`autobalancer.measure.signals` makes them; ``uncertainty`` of a channel is the standard deviation of its
        noise.

    Raises
    ------
    QuestionError
        If a place is not in the run, two channels have one name, the run kept too few samples, or the part is not within the run.
    """
    if not sensors:
        raise QuestionError("record: sensors: given none; give at least one")
    rate = hertz_argument("sampling_rate", sampling_rate)
    time = _times(run, rate, start, end)
    angle = np.asarray(make_interp_spline(sampled(run), run["rotor_angle"].values, k=DEGREE)(time), np.float64)
    channels: dict[str, Channel] = {}
    for number, sensor in enumerate(sensors):
        random = generator(seed, number)
        name = sensor.name if isinstance(sensor, Tacho) else sensor.channel
        if name in channels:
            raise QuestionError(f"record: two channels are called {name!r}; give them names of their own")
        if isinstance(sensor, Tacho):
            words = f"tacho, {sensor.pulses} pulse{'s' * (sensor.pulses > 1)} in a turn"
            channels[name] = Channel(
                pulses(sensor, time, angle, random), "tacho", "", sensor.angle, words, sensor.noise or None
            )
            continue
        true = motion(run, sensor, time)(time)
        values = read(sensor, true, angle, rate, random)
        noise = uncertainty_of(sensor, true, rate)
        channels[name] = Channel(
            values, sensor.quantity, sensor.place, sensor.along, uncertainty=noise if noise else None
        )
    record = signals(time, channels, origin=f"run of {run.attrs.get('machine_name', 'a machine')}")
    record.attrs |= {"machine": run.attrs["machine"]} if "machine" in run.attrs else {}
    return record


def _times(run: xr.Dataset, rate: float, start: float | str | None, end: float | str | None) -> np.ndarray:
    known = sampled(run)
    begin = known[0] if start is None else argument("start", start, "s")
    stop = known[-1] if end is None else argument("end", end, "s")
    if not known[0] <= begin < stop <= known[-1] * (1.0 + 1e-12):
        raise QuestionError(
            f"record: given {begin:g} s to {stop:g} s; must ascend within the samples of the run, "
            f"{known[0]:g} s to {known[-1]:g} s"
        )
    count = math.floor((stop - begin) * rate * (1.0 + 1e-12)) + 1
    if count > MOST:
        raise QuestionError(
            f"record: {count} samples of a channel; take a lower rate or a part of the run (at most {MOST})"
        )
    return np.asarray(np.minimum(begin + np.arange(count) / rate, known[-1]), np.float64)


# What a sensor makes of a true value, and what a tacho makes of turning marks.


RISE = 2.0  # samples in which a pulse rises, so that its instant can be read between samples
WIDTH = 0.2  # of the time between pulses
LEAST = 8  # samples between two pulses


def read(sensor: Sensor, true: Floats, rotor_angle: Floats, rate: float, random: np.random.Generator) -> Floats:
    """Readings of the true values, both (time,) at ``rate`` (Hz).

    Raises
    ------
    QuestionError
        If the corner of its filter is not below half of the sampling rate, or a ratio to the noise is no number.
    """
    seen = true.copy()
    for order, size, at in sensor.runout:
        seen = seen + float(size) * np.cos(order * (rotor_angle + at - sensor.angle))
    seen = filtered(sensor, seen, rate) * sensor.sensitivity + float(sensor.offset)
    seen = seen + noise_of(sensor, seen, rate) * random.standard_normal(seen.size)
    if sensor.step:
        seen = np.round(seen / float(sensor.step)) * float(sensor.step)
    return np.asarray(np.clip(seen, -float(sensor.limit), float(sensor.limit)), np.float64)


def noise_of(sensor: Sensor, seen: Floats, rate: float) -> float:
    """Standard deviation of the noise of each reading."""
    if sensor.decibels:
        try:
            ratio = float(sensor.decibels)
        except ValueError:
            raise QuestionError(
                f"sensor: noise: given {sensor.noise!r}; give a number of dB, such as '40 dB'"
            ) from None
        return float(np.std(seen) * 10.0 ** (-ratio / 20.0))
    return sensor.noise_density * math.sqrt(0.5 * rate) if sensor.noise_density else float(sensor.noise)


def uncertainty_of(sensor: Sensor, seen: Floats, rate: float) -> float:
    """Standard deviation of a reading: noise and steps."""
    return math.hypot(noise_of(sensor, seen, rate), float(sensor.step) / math.sqrt(12.0))


def filtered(sensor: Sensor, values: Floats, rate: float) -> Floats:
    """Behind its filter, which has been on for long."""
    if sensor.low_pass is None:
        return values
    corner = float(sensor.low_pass)
    if not corner < 0.5 * rate:
        raise QuestionError(
            f"sensor: low_pass: given {corner:g} Hz; must be below half of the sampling rate, {rate:g} Hz"
        )
    stages = butter(2, corner, fs=rate, output="sos")
    return np.asarray(sosfilt(stages, values, zi=sosfilt_zi(stages) * values[0])[0], np.float64)


def pulses(tacho: Tacho, time: Floats, rotor_angle: Floats, random: np.random.Generator) -> Floats:
    """Voltage of a tacho over ``time``, (time,).

    Raises
    ------
    QuestionError
        If pulses come too fast for the sampling rate.
    """
    step = float(time[1] - time[0])
    edges, gaps = passages(tacho, time, rotor_angle)
    if gaps.size and gaps.min() < LEAST * step:
        raise QuestionError(
            f"record: {tacho.name}: {tacho.pulses} pulses in a turn come every {gaps.min():.3g} s; sample at "
            f"{LEAST / gaps.min():.0f} Hz or faster, or take fewer pulses"
        )
    kept = random.random(edges.size) >= tacho.missing
    edges = edges + float(tacho.jitter) * random.standard_normal(edges.size)
    ascending = np.argsort(edges[kept])
    edges, width = edges[kept][ascending], WIDTH * gaps[kept][ascending]
    noise = tacho.noise * random.standard_normal(time.size)
    if not edges.size:
        return noise
    rise = RISE * step
    last = np.searchsorted(edges, time + 0.5 * rise) - 1
    since = time - edges[np.maximum(last, 0)]
    width = np.maximum(width, 2.0 * rise)[np.maximum(last, 0)]
    up, down = np.clip(0.5 + since / rise, 0.0, 1.0), np.clip(0.5 + (width - since) / rise, 0.0, 1.0)
    return np.asarray(tacho.level * np.where(last >= 0, np.minimum(up, down), 0.0) + noise, np.float64)


def passages(tacho: Tacho, time: Floats, rotor_angle: Floats) -> tuple[Floats, Floats]:
    """When marks pass the tacho, and the time from each to the next one at the speed of then, s."""
    marks = (rotor_angle - math.radians(tacho.angle)) * tacho.pulses / (2.0 * math.pi)
    whole = np.floor(marks)
    rows = np.flatnonzero(np.diff(whole) != 0.0)
    wanted = np.maximum(whole[rows], whole[rows + 1])
    rate = np.gradient(marks, time)
    slope, bend = rate[rows], (rate[rows + 1] - rate[rows]) / (time[rows + 1] - time[rows])
    ahead = (wanted - marks[rows]) / (marks[rows + 1] - marks[rows]) * (time[rows + 1] - time[rows])
    ahead = ahead + 0.5 * bend / np.where(slope == 0.0, np.inf, slope) * ahead * (time[rows + 1] - time[rows] - ahead)
    return time[rows] + ahead, 1.0 / np.maximum(np.abs(slope), 1e-300)


# Sensors and tachos as they are mounted, with what they do to a signal.


Quantity = Literal["displacement", "velocity", "acceleration", "force"]
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "force": "N"}
DEGREES = math.pi / 180.0


@dataclass(frozen=True)
class Sensor:
    """One sensor in one direction. Numbers are SI; texts may have a unit.

    Parameters
    ----------
    quantity
        displacement, velocity or acceleration of the rotor in space, or force of the rotor on a support.
    place
        Name of a station or plane, for a force of a support; by default the reference station, or the only support.
    direction
        "x", "y", or an angle from x in degrees.
    name
        Of the channel; by default made of quantity, place and direction.
    noise
        Standard deviation of white noise, or a signal-to-noise ratio such as "40 dB", that of the root mean squares of signal
        and noise over the whole record.
    noise_density
        Of white noise in its place, SI unit per root of Hz, one-sided.
    sensitivity
        Reading over true value: 1.02 reads 2 % too much.
    offset
        Added to every reading.
    limit
        Readings beyond plus or minus this are clipped.
    runout
        Of the surface that a displacement sensor sees: (order, amplitude, angle of its highest point in the rotor, rad) of each
        part.
    step
        Smallest difference of readings; 0 for none.
    low_pass
        Corner frequency (Hz) of a Butterworth filter of order 2 in front of the logger; its lag is in the signal.
    """

    quantity: Quantity
    place: str = ""
    direction: str | float = "x"
    name: str = ""
    noise: float | str = 0.0
    noise_density: float = 0.0
    sensitivity: float = 1.0
    offset: float | str = 0.0
    limit: float | str = math.inf
    runout: Sequence[tuple[int, float | str, float]] = ()
    step: float | str = 0.0
    low_pass: float | str | None = None

    def __post_init__(self) -> None:
        one_of("sensor: quantity", self.quantity, *get_args(Quantity))
        unit = UNITS[self.quantity]
        for key in ("offset", "limit", "step"):
            object.__setattr__(self, key, argument(f"sensor: {key}", getattr(self, key), unit))
        if not self.decibels:
            object.__setattr__(self, "noise", argument("sensor: noise", self.noise, unit))
        if self.runout and self.quantity != "displacement":
            raise QuestionError(f"sensor: runout is seen by a displacement sensor only, not by one of {self.quantity}")
        parts = tuple((order, argument("sensor: runout", size, "m"), float(at)) for order, size, at in self.runout)
        object.__setattr__(self, "runout", parts)
        corner = None if self.low_pass is None else hertz_argument("low_pass", self.low_pass)
        object.__setattr__(self, "low_pass", corner)
        self._check()

    def _check(self) -> None:
        noise = 0.0 if self.decibels else float(self.noise)
        for key, value in (("noise", noise), ("noise_density", self.noise_density), ("step", float(self.step))):
            if not (math.isfinite(value) and value >= 0.0):
                raise QuestionError(f"sensor: {key}: given {value:g}; must not be negative")
        if not (math.isfinite(self.sensitivity) and self.sensitivity != 0.0):
            raise QuestionError(
                f"sensor: sensitivity: given {self.sensitivity:g}; it is reading over true value, about 1"
            )
        if not math.isfinite(float(self.offset)) or not float(self.limit) > 0.0:
            raise QuestionError("sensor: the offset must be finite and the limit greater than zero")
        if (bool(self.noise) or self.decibels != "") and self.noise_density:
            raise QuestionError("sensor: give noise or noise_density, not both")
        self.angle  # noqa: B018 - refuses an impossible direction

    @property
    def decibels(self) -> str:
        """The number before "dB" where the noise is given so, else empty."""
        text = str(self.noise).strip() if isinstance(self.noise, str) else ""
        return text[:-2].strip() if text.lower().endswith("db") else ""

    @property
    def angle(self) -> float:
        """Of the direction from x, rad."""
        if self.direction in ("x", "y"):
            return 0.0 if self.direction == "x" else 0.5 * math.pi
        try:
            angle = float(self.direction)
        except ValueError:
            angle = math.nan
        if not math.isfinite(angle):
            raise QuestionError(
                f"sensor: direction: given {self.direction!r}; must be x, y or a number of degrees from x"
            )
        return angle * DEGREES

    @property
    def along(self) -> str | float:
        """The direction as signals have it."""
        return self.direction if self.direction in ("x", "y") else float(self.direction)

    @property
    def channel(self) -> str:
        """Name of the channel."""
        along = self.along if isinstance(self.along, str) else f"{self.along:g}_deg".replace("-", "minus_")
        return self.name or "_".join(part.replace(" ", "_") for part in (self.quantity, self.place, along) if part)


@dataclass(frozen=True)
class Tacho:
    """A pulse each time a mark of the rotor passes.

    Parameters
    ----------
    pulses
        In one turn. The first mark is the zero mark of the rotor.
    angle
        Where the tacho stands, degrees from x.
    missing
        Share of pulses that are lost, at random.
    jitter
        Standard deviation of the instant of a pulse, s.
    level
        Of a pulse above zero, V.
    noise
        Standard deviation of white noise, V.
    name
        Of the channel.
    """

    pulses: int = 1
    angle: float = 0.0
    missing: float = 0.0
    jitter: float | str = 0.0
    level: float = 5.0
    noise: float = 0.0
    name: str = "tacho"

    def __post_init__(self) -> None:
        if isinstance(self.pulses, bool) or not isinstance(self.pulses, int) or self.pulses < 1:
            raise QuestionError(f"tacho: pulses: given {self.pulses!r}; must be a whole number from 1")
        object.__setattr__(self, "jitter", argument("tacho: jitter", self.jitter, "s"))
        if not 0.0 <= self.missing < 1.0:
            raise QuestionError(f"tacho: missing: given {self.missing:g}; must be a share from 0 to less than 1")
        numbers = (float(self.jitter), self.noise, self.level, self.angle)
        if not all(map(math.isfinite, numbers)) or min(numbers[:2]) < 0.0 or self.level <= 0.0:
            raise QuestionError("tacho: jitter and noise must not be negative, and the level must be greater than zero")


# Motions and forces between the samples of a run: splines, and how far they can be trusted.


DEGREE = 5
ORDER = {"displacement": 0, "velocity": 1, "acceleration": 2, "force": 0}  # derivatives in time
PER_TURN = 16  # samples in a turn of the rotor at least
ALLOWED = (
    0.01  # of the signal: what half of the samples may be wrong by; of all of them it is less by 2^(6 - derivatives)
)
WINDOWS = 20  # in each of which that is asked
QUIET = 1e-3  # of the whole signal: a window with less is not judged
STILL = 1e-6  # of the motion across: a signal with less, such as rounding errors, is not judged


@dataclass(frozen=True)
class Motion:
    """A quantity along a direction between the samples of a run, and its spline."""

    spline: BSpline

    def __call__(self, time: Floats) -> Floats:
        """At these times, s."""
        return np.asarray(self.spline(time), np.float64)


def sampled(run: xr.Dataset) -> Floats:
    """Times of the samples of a run, s.

    Raises
    ------
    QuestionError
        If it kept too few of them.
    """
    times = np.asarray(run["time"].values, np.float64) if "rotor_angle" in run else np.zeros(0)
    if times.size < 4 * DEGREE:
        raise QuestionError(
            f"record: the run kept {times.size} samples over time; run it with save=Samples(count), "
            f"with at least {PER_TURN} samples in each turn of the rotor"
        )
    return times


def motion(run: xr.Dataset, sensor: Sensor, time: Floats) -> Motion:
    """What a sensor would see, without what is wrong with the sensor itself.

    Raises
    ------
    QuestionError
        If the place is not in the run, or the samples between ``time[0]`` and ``time[-1]`` are too far apart.
    """
    times = sampled(run)
    x, y = _vectors(run, sensor)
    values = x * math.cos(sensor.angle) + y * math.sin(sensor.angle)
    order = ORDER[sensor.quantity]
    spline = _spline(times, values, order)
    first, last = np.searchsorted(times, (time[0], time[-1]))
    inside = slice(max(int(first) - 1, 0), int(last) + 2)
    _check_turns(run, times, inside)
    across = _spline(times, y * math.cos(sensor.angle) - x * math.sin(sensor.angle), order)(times)
    if spline(times).std() > STILL * across.std():
        _check_halves(times, values, spline, order, inside, sensor.channel)
    return Motion(spline)


def _spline(times: Floats, values: Floats, order: int) -> BSpline:
    spline = make_interp_spline(times, values, k=DEGREE)
    return spline.derivative(order) if order else spline


def at_samples(run: xr.Dataset, sensor: Sensor, time: Floats) -> Floats:
    """A displacement or force at samples of the run, as they are; ``time`` (s) is among their times."""
    x, y = _vectors(run, sensor)
    rows = np.searchsorted(run["time"].values, time - 1e-12 * (1.0 + abs(time)))
    return np.asarray((x * math.cos(sensor.angle) + y * math.sin(sensor.angle))[rows], np.float64)


def _vectors(run: xr.Dataset, sensor: Sensor) -> tuple[Floats, Floats]:
    """x and y of the place over the samples."""
    if sensor.quantity == "force":
        names, prefix, dimension = list(map(str, run["support"].values)), "support_force_", "support"
        if not sensor.place and len(names) == 1:
            return run[f"{prefix}x"].values[:, 0], run[f"{prefix}y"].values[:, 0]
        if sensor.place in names:
            row = names.index(sensor.place)
            return run[f"{prefix}x"].values[:, row], run[f"{prefix}y"].values[:, row]
        raise QuestionError(_unknown(sensor, names, dimension))
    if not sensor.place:
        return run["x"].values, run["y"].values
    for dimension in ("station", "plane"):
        names = list(map(str, run[dimension].values)) if f"{dimension}_x" in run else []
        if sensor.place in names:
            row = names.index(sensor.place)
            return run[f"{dimension}_x"].values[:, row], run[f"{dimension}_y"].values[:, row]
    raise QuestionError(_unknown(sensor, places_of(run), "place"))


def places_of(run: xr.Dataset) -> list[str]:
    """Names of the stations and planes whose motion the samples of a run have."""
    return [str(n) for dimension in ("station", "plane") if f"{dimension}_x" in run for n in run[dimension].values]


def place_of_sensor(run: xr.Dataset, sensor: Sensor) -> str:
    """The place of the run that a sensor sees: its own, without one the reference station; empty where there is one only."""
    if sensor.place or sensor.quantity == "force" or len(places_of(run)) < 2:
        return sensor.place
    return str(run.attrs.get("reference_station", ""))


def _unknown(sensor: Sensor, names: list[str], what: str) -> str:
    known = ", ".join(map(repr, dict.fromkeys(names)))
    given = f"its place is {sensor.place!r}" if sensor.place else "it has no place"
    if not known:
        return f"sensor {sensor.channel!r}: {given}, but no {what} of the run has a name; leave it out"
    return f"sensor {sensor.channel!r}: {given}; the {what}s of the run are {known}; give it one of these"


def _check_turns(run: xr.Dataset, times: Floats, inside: slice) -> None:
    speed = float(np.abs(run["speed"].values[inside]).max())
    step = float(np.diff(times[inside]).max())
    if speed * step > 2.0 * math.pi / PER_TURN:
        count = math.ceil(float(np.ptp(times)) * speed * PER_TURN / (2.0 * math.pi)) + 1
        raise QuestionError(
            _too_few(times, count, f"{2.0 * math.pi / (speed * step):.3g} samples in a turn of the rotor")
        )


def _check_halves(times: Floats, values: Floats, whole: BSpline, order: int, inside: slice, name: str) -> None:
    """Whether every second sample would nearly do, in every part of the record."""
    half = _spline(times[::2], values[::2], order)
    odd = times[inside][1:-1]
    odd = odd[(odd > times[2 * DEGREE]) & (odd < times[-1 - 2 * DEGREE])]
    if odd.size < WINDOWS:
        return
    true = whole(odd)
    off, size = half(odd) - true, true - true.mean()
    parts = np.array_split(np.arange(odd.size), WINDOWS)
    wrong = np.array([np.sqrt(np.mean(off[part] ** 2)) for part in parts])
    great = np.array([np.sqrt(np.mean(size[part] ** 2)) for part in parts])
    judged = great > QUIET * np.sqrt(np.mean(size**2))
    if not judged.any():
        return
    share = float((wrong[judged] / great[judged]).max())
    if share > ALLOWED:
        more = (share / ALLOWED) ** (1.0 / (DEGREE + 1 - order))
        why = f"what {name} sees changes too fast between them"
        raise QuestionError(_too_few(times, math.ceil(1.1 * more * times.size), why))


def _too_few(times: Floats, count: int, why: str) -> str:
    return (
        f"record: the run kept {times.size} samples, too few: {why}; "
        f"simulate it with save=Samples({count}) (--samples {count}) or more, for {np.ptp(times):g} s"
    )

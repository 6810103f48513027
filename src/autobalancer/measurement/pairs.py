"""What was measured beside what a run gives in its place, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.balancing.run_down import UNITS, Orders, first_orders
from autobalancer.measurement.sensors import ORDER, Sensor, at_samples, motion, place_of_sensor, places_of, sampled
from autobalancer.measurement.tracking import WINDOW, filtered_orders, fitted_orders
from autobalancer.random_numbers import generator
from autobalancer.results.measure_table import MEASURES, needed
from autobalancer.results.run_arrays import Balls, Bins, Recorded, bins_of, whirls_of
from autobalancer.results.signals import Signals
from autobalancer.results.time_series import wrapped
from autobalancer.rotordynamics.parameter_fit import Rows, Search, Trial
from autobalancer.simulation.record import Samples, SampleTimes
from autobalancer.simulation.run import simulate_races

WRONG = 100.0  # ratio of sizes from which on a unit is probably wrong


@dataclass(frozen=True, eq=False)
class Pair:
    """One channel or ball, measured and simulated, over the times of the measurement.

    Attributes
    ----------
    measured
        With its standard deviations.
    simulated
        SI; angles are those within half a turn of the measured ones.
    free_offset
        Whether the zero of the sensor is not known, so that a mean deviation says nothing.
    place
        Of the run, with which it is compared; empty where it has one only, and of balls.
    """

    measured: Stated
    simulated: Floats
    free_offset: bool = False
    place: str = ""

    @property
    def shifted(self) -> Floats:
        """Simulated, with the mean of the measurement where the zero of the sensor is not known."""
        offset = float((self.measured.values - self.simulated).mean()) if self.free_offset else 0.0
        return np.asarray(self.simulated + offset, np.float64)


def pairs(run: xr.Dataset, measured: xr.Dataset, dense: bool = True) -> list[Pair]:
    """All channels or balls of a measurement with what the run has in their place.

    Parameters
    ----------
    run
        With samples; the times of the measurement are those of the run.
    measured
        Signals, or ball angles of a film.
    dense
        Whether samples of the run are anywhere; otherwise they are at the times of the measurement.

    Raises
    ------
    QuestionError
        If a place is not in the run, or it has fewer balls.
    """
    pairs = stated(measured)
    if is_film(measured):
        return _of_balls(run, pairs)
    return [_of_channel(run, measured[pair.name], pair, dense) for pair in pairs]


def sensor_of(entry: xr.DataArray) -> Sensor:
    """The sensor that a channel is from."""
    direction = entry.attrs.get("direction", "")
    place = str(entry.attrs.get("place", ""))
    return Sensor(entry.attrs["quantity"], place, "x" if direction == "" else direction, str(entry.name))


def scale_doubt(pair: Pair) -> str:
    """What is said where measured and simulated differ by a factor that is probably one of units; else empty."""
    if pair.measured.unit == "rad":
        return ""
    sizes = [_size(values - values.mean() * pair.free_offset) for values in (pair.measured.values, pair.simulated)]
    return size_doubt(pair.measured.name, pair.measured.unit, sizes[0], sizes[1], "root mean square")


def size_doubt(name: str, unit: str, measured: float, simulated: float, what: str = "greatest") -> str:
    """The same of two sizes."""
    if measured < WRONG * simulated and simulated < WRONG * measured:
        return ""
    ratio = measured / simulated if simulated > 0.0 else np.inf
    factor = f"{ratio:.3g} times" if ratio > 1.0 else f"1/{1.0 / ratio:.3g} of" if ratio > 0.0 else "nothing beside"
    return (
        f"{name}: the measured signal ({what} {measured:.3g} {unit}) is {factor} the simulated one; is its unit right, such as "
        "mm for m?"
    )


def place_doubt(run: xr.Dataset, sensors: list[Sensor], names: list[str]) -> str:
    """What is said where sensors have no place and the run has several; else empty."""
    open_ones = [
        name for sensor, name in zip(sensors, names, strict=True) if not sensor.place and place_of_sensor(run, sensor)
    ]
    if not open_ones:
        return ""
    many = len(open_ones) > 1
    return (
        f"{', '.join(open_ones)}: the measurement does not say where {'these were' if many else 'this was'} measured, so "
        f"{'they are' if many else 'it is'} compared with {run.attrs['reference_station']!r}, the reference station of the run; "
        f"it has {', '.join(dict.fromkeys(map(repr, places_of(run))))}"
    )


def _size(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _of_channel(run: xr.Dataset, entry: xr.DataArray, value: Stated, dense: bool) -> Pair:
    sensor = sensor_of(entry)
    between = dense or ORDER[sensor.quantity] > 0
    simulated = motion(run, sensor, value.time)(value.time) if between else at_samples(run, sensor, value.time)
    return Pair(value, simulated, sensor.quantity != "force", place_of_sensor(run, sensor))


def _of_balls(run: xr.Dataset, values: list[Stated]) -> list[Pair]:
    if "ball_angle_in_rotor" not in run:
        raise QuestionError("the run has no samples of its balls; run it with save=Samples(count)")
    known, clock = run["ball_angle_in_rotor"].values.T, run["time"].values
    if len(known) < len(values):
        raise QuestionError(f"{len(values)} balls were measured; the run has {len(known)}")
    simulated = [[np.interp(value.time, clock, angle) for angle in known] for value in values]
    cost = np.array(
        [[np.abs(wrapped(s - value.values)).sum() for s in row] for value, row in zip(values, simulated, strict=True)]
    )
    twins = linear_sum_assignment(cost)[1]  # balls look alike
    return [
        Pair(value, np.asarray(value.values + wrapped(row[twin] - value.values), np.float64))
        for value, row, twin in zip(values, simulated, twins, strict=True)
    ]


# What a measurement states: every channel or ball with its values and their standard deviations.


ANGLE = "ball_angle"


class Stated(NamedTuple):
    """Values of one channel or ball at times (s) with one standard deviation of each, nan where not known; (time,)."""

    name: str
    unit: str
    time: Floats
    values: Floats
    deviation: Floats


def is_film(measured: xr.Dataset) -> bool:
    """Whether these are ball angles over time."""
    return ANGLE in measured and set(measured[ANGLE].dims) == {"time", "ball"}


def motions_of(measured: xr.Dataset) -> list[str]:
    """Names of the channels that a run has, too."""
    return [str(name) for name, entry in measured.data_vars.items() if entry.attrs.get("quantity") in ORDER]


def stated(measured: xr.Dataset) -> list[Stated]:
    """All channels of motions and forces, or the balls of a film where they were seen.

    Raises
    ------
    QuestionError
        If it is no such measurement.
    """
    if is_film(measured):
        return _balls(measured)
    if not isinstance(measured, Signals) or not motions_of(measured):
        raise QuestionError(
            "measured: give signals with a displacement, velocity, acceleration or force, from ab.measure.load_signals, "
            "or the ball angles of a film"
        )
    time = np.asarray(measured["time"].values, np.float64)
    return [
        Stated(
            name,
            str(measured[name].attrs["units"]),
            time,
            np.asarray(measured[name].values, np.float64),
            np.full(time.size, float(measured[name].attrs.get("uncertainty", np.nan))),
        )
        for name in motions_of(measured)
    ]


def _balls(measured: xr.Dataset) -> list[Stated]:
    time = np.asarray(measured["time"].values, np.float64)
    angles = np.asarray(measured[ANGLE].transpose("ball", "time").values, np.float64)
    sure, seen = np.full(angles.shape, np.nan), np.isfinite(angles)
    if (name := f"{ANGLE}_deviation") in measured:
        sure = measured[name].broadcast_like(measured[ANGLE]).transpose("ball", "time").values
    if "seen" in measured:
        seen &= measured["seen"].transpose("ball", "time").values.astype(bool)
    names = measured["ball"].values if "ball" in measured.coords else np.arange(1, len(angles) + 1)
    return [
        Stated(f"ball {name}", "rad", time[row], angle[row], deviation[row])
        for name, row, angle, deviation in zip(names, seen, angles, sure, strict=True)
    ]


# The measures of a run from what was measured, as far as it suffices, and the same of the run as the sensors would see
# it.


DRAWS = 20  # of the noise
FLAT = 0.1  # sine of the angle between two sensors, below which they count as one
OF_REST = ("final_ball_angle_to_unbalance",)  # needs an unbalance, which a film does not see


class Row(NamedTuple):
    """One measure: of what, measured, of the run as the sensors see it, and one standard deviation by their noise; SI."""

    name: str
    unit: str
    of: str
    measured: float
    simulated: float
    deviation: float


def measure_rows(
    run: xr.Dataset, measured: xr.Dataset, pairs: list[Pair], seed: int, turned: xr.Dataset | None
) -> tuple[list[Row], list[str]]:
    """The measures that can be computed from the pairs, and why the others cannot.

    ``turned`` has the measured speed over its time, held before the first pulse and after the last; without a tacho it is taken
    to be that of the run.
    """
    if pairs[0].measured.unit == "rad":
        return _of_film(run, measured, pairs, seed)
    place = str(run.attrs.get("reference_station", ""))
    sensors = [sensor_of(measured[pair.measured.name]) for pair in pairs]
    here = [k for k, sensor in enumerate(sensors) if sensor.quantity == "displacement" and sensor.place in ("", place)]
    angles = np.array([sensors[k].angle for k in here])
    if len(here) < 2 or np.abs(np.sin(angles - angles[0])).max() < FLAT:
        return [], [
            f"no measures of the deflection: they need displacements in two directions at the reference station {place!r}"
        ]
    across = np.linalg.pinv(np.column_stack([np.cos(angles), np.sin(angles)]))
    time = pairs[here[0]].measured.time
    of_run = np.interp(time, run["time"].values, run["speed"].values)
    own = of_run if turned is None else np.interp(time, turned["time"].values, turned["speed"].values)

    def recorded(values: list[Floats], seen: bool) -> Recorded:
        x, y = across @ np.array(values)
        speed = own if seen else of_run
        data = xr.Dataset({"deflection": ("time", np.hypot(x, y)), "speed": ("time", speed)}, {"time": time})
        return Recorded(float(time[-1]), True, whirls_of(run), bins_of(data))

    rows = _rows([pairs[k] for k in here], recorded, "bins", seed)
    return rows, ["no measures of balls, supports and residual unbalance: they are not in signals of displacement"]


def _of_film(run: xr.Dataset, measured: xr.Dataset, pairs: list[Pair], seed: int) -> tuple[list[Row], list[str]]:
    """Of the motion of the balls; frames in which one was not seen are bridged."""
    time = np.asarray(measured["time"].values, np.float64)
    if time.size < 2:
        return [], ["no measures: one picture says where balls are, and not how they move"]
    speed = np.interp(time, run["time"].values, run["speed"].values)

    def recorded(values: list[Floats], _seen: bool) -> Recorded:
        angle = np.array(
            [np.interp(time, pair.measured.time, np.unwrap(one)) for pair, one in zip(pairs, values, strict=True)]
        ).T
        rate = np.gradient(angle, time, axis=0)
        empty = Bins(*[np.zeros(0)] * 6)
        balls = Balls(float(time[0]), time, speed, angle, rate)
        return Recorded(float(time[-1]), True, whirls_of(run), empty, balls)

    return _rows(pairs, recorded, "balls", seed), ["no measures of the deflection: a film of balls does not show it"]


def _rows(pairs: list[Pair], recorded: Callable[[list[Floats], bool], Recorded], known: str, seed: int) -> list[Row]:
    """Of the measures that need nothing else than what is ``known``; without deviation where a sensor states none.

    ``recorded`` is told whether the values are the measured ones.
    """
    random = generator(seed)
    stated = all(np.isfinite(pair.measured.deviation).any() for pair in pairs)
    true = recorded([pair.measured.values - (pair.shifted - pair.simulated) for pair in pairs], True)
    draws = []
    for _ in range(DRAWS):
        noise = [np.nan_to_num(pair.measured.deviation) * random.standard_normal(pair.simulated.size) for pair in pairs]
        draws.append(recorded([pair.simulated + part for pair, part in zip(pairs, noise, strict=True)], False))
    rows = []
    for measure in MEASURES:
        if measure.made_of or set(needed(measure)) != {known} or measure.name in OF_REST:
            continue
        seen = np.array([np.atleast_1d(measure.of(draw)) for draw in draws], np.float64)
        values = np.atleast_1d(measure.of(true))
        for k, value in enumerate(values):
            several = [pairs[k].measured.name] if measure.along else [""]
            known_draws = seen[:, k][np.isfinite(seen[:, k])]
            mean = float(known_draws.mean()) if known_draws.size > DRAWS // 2 else math.nan
            spread = float(known_draws.std(ddof=1)) if stated and known_draws.size > DRAWS // 2 else math.nan
            rows.append(Row(measure.name, measure.unit, several[0], float(value), mean, spread))
    return rows


def measure_table(rows: list[Row]) -> xr.Dataset:
    """Rows as arrays over ``measure``."""

    def words(texts: list[str]) -> NDArray[np.object_]:
        return np.array(texts, dtype=object)

    return xr.Dataset(
        {
            "measured_value": ("measure", np.array([row.measured for row in rows], np.float64)),
            "simulated_value": ("measure", np.array([row.simulated for row in rows], np.float64)),
            "value_deviation": ("measure", np.array([row.deviation for row in rows], np.float64)),
            "measure_of": ("measure", words([row.of for row in rows])),
            "measure_unit": ("measure", words([row.unit for row in rows])),
        },
        {"measure": words([row.name for row in rows])},
    )


# Orders that were measured beside those of a run, tracked by the same method.


PER_TURN = 32  # samples of the run in a turn of the rotor
MOST = 2_000_000  # samples
NEAR = 1e-3  # relative difference of speeds that are one
DIFFERENT = 0.02  # relative difference of speeds at one time, above which a note says so
DRAWS_OF_NOISE = 50  # of the noise


class TrackingOptions(NamedTuple):
    """All orders that are tracked, and the revolutions of the window, or the bandwidth of the filter (Hz)."""

    orders: Floats
    revolutions: float
    bandwidth: float


class Tracks(NamedTuple):
    """Of a run: times and speeds of its samples, the angle there, and what each channel sees, (channel, time)."""

    time: Floats
    speed: Floats
    angle: Floats
    seen: Floats

    def whole(self, how: TrackingOptions) -> NDArray[np.bool_]:
        """Samples about which there is a whole window."""
        half = np.pi * how.revolutions
        return np.asarray((self.angle >= self.angle[0] + half) & (self.angle <= self.angle[-1] - half))


def is_orders(measured: xr.Dataset) -> bool:
    """Whether these are amplitudes and phases of orders."""
    return {"amplitude", "phase"} <= set(measured.data_vars) and "speed" in measured.variables


def order_curves(run: xr.Dataset, measured: xr.Dataset, seed: int) -> tuple[xr.Dataset, list[str]]:
    """First orders of both over ``channel`` and ``order_time``, the greatest amplitudes as measures, and notes.

    Raises
    ------
    QuestionError
        If no order is within the run, or a place is not in it.
    """
    known = first_orders(measured, "compare", biased=False)
    names = [str(one) for one in measured["channel"].values] if "channel" in measured.coords else _names(known)
    tracks, how = _tracks(run, known), _tracking_options(measured)
    times = known.times if np.isfinite(known.times).all() else _passages(tracks, known.speeds, how)
    simulated = _tracked(tracks, times, how)
    inside = np.isfinite(simulated).all(axis=1)
    if inside.sum() < 2:
        speeds = tracks.speed.min(), tracks.speed.max()
        raise QuestionError(
            f"compare: {inside.sum()} of {inside.size} orders are within the run, which has {tracks.time[0]:.5g} s to "
            f"{tracks.time[-1]:.5g} s and {speeds[0]:.5g} to {speeds[1]:.5g} rad/s, and half a window from its ends"
        )
    notes = []
    if not inside.all():
        notes.append(f"{(~inside).sum()} of {inside.size} points are not within the run, or too near to its ends")
    known, times, simulated = known.at(np.flatnonzero(inside)), times[inside], simulated[inside]
    passed = np.interp(times, tracks.time, tracks.speed)
    units = [UNITS[quantity] for quantity in known.quantities]
    sizes = [(float(np.abs(one).max(axis=0)[c])) for c in range(len(names)) for one in (known.readings, simulated)]
    doubts = [size_doubt(n, u, a, b) for n, u, a, b in zip(names, units, sizes[::2], sizes[1::2], strict=True)]
    rows = [row for c in range(len(names)) for row in _peaks(known, simulated, passed, c, names[c], units[c], seed)]
    sensors = _sensors(known)
    places = [place_of_sensor(run, sensor) for sensor in sensors]
    data = _arrays(known, names, units, times, simulated, passed).merge(measure_table(rows))
    data["place"] = "channel", np.array(places, dtype=object)
    if measured.sizes.get("order", 1) > 1:
        notes.append("of several orders the first was compared")
    off = float(np.abs(passed / known.speeds - 1.0).max())
    if off > DIFFERENT:
        notes.append(
            f"the measured speed differs from that of the run by up to {100 * off:.3g} %; give the run its profile"
        )
    return data, [*filter(None, [place_doubt(run, sensors, names), *doubts]), *notes]


def orders_of_a_run(machine: Machine, measured: xr.Dataset, known: Orders) -> NDArray[np.complex128]:
    """First orders (time, channel) of a run of a machine, with its drive and start, at the times of the measured ones.

    They are tracked as the measured ones were; nan where the run does not come so far.
    """
    how, last = _tracking_options(measured), int(known.times.argmax())
    window = 2.0 * np.pi / known.speeds[last] * how.revolutions if how.revolutions else 2.0 / how.bandwidth
    duration = float(known.times[last] + 0.6 * window)
    count = int(np.ceil(duration * known.speeds.max() / (2.0 * np.pi) * PER_TURN)) + 1
    run = simulate_races(machine, duration=duration, save=Samples(count), tolerance=TOLERANCE, progress=QUIET)
    if run.attrs["outcome"] != "finished":
        return np.full(known.readings.shape, np.nan, np.complex128)
    return _tracked(_tracks(run, known), known.times, how)


def _names(known: Orders) -> list[str]:
    return [f"{way:.4g} deg at {place}" for place, way in zip(known.places, np.degrees(known.directions), strict=True)]


def _tracking_options(measured: xr.Dataset) -> TrackingOptions:
    """How orders were tracked; by default with the local fit."""
    about = measured.attrs
    every = np.atleast_1d(measured["order"].values) if "order" in measured.coords else np.ones(1)
    if "bandwidth" in about:
        return TrackingOptions(every, 0.0, float(about["bandwidth"]))
    return TrackingOptions(every, float(about.get("window_revolutions", WINDOW)), 0.0)


def _tracks(run: xr.Dataset, known: Orders) -> Tracks:
    clock = sampled(run)
    fastest = float(np.abs(run["speed"].values).max())
    count = int(min(MOST, np.ceil((clock[-1] - clock[0]) * fastest / (2.0 * np.pi) * PER_TURN))) + 2
    time = np.linspace(clock[0], clock[-1], max(count, clock.size))
    seen = np.array([motion(run, sensor, time)(time) for sensor in _sensors(known)])
    angle, speed = (np.interp(time, run["time"].values, run[name].values) for name in ("rotor_angle", "speed"))
    return Tracks(time, speed, angle, seen)


def _sensors(known: Orders) -> list[Sensor]:
    return [
        Sensor(quantity, str(place), float(np.degrees(way)))  # type: ignore[arg-type]
        for place, way, quantity in zip(known.places, known.directions, known.quantities, strict=True)
    ]


def _passages(tracks: Tracks, speeds: Floats, how: TrackingOptions) -> Floats:
    """When the run has each speed for the last time with a whole window about it, s; nan where never."""
    rows = np.flatnonzero(tracks.whole(how))
    speed, passages = tracks.speed[rows], np.full(speeds.size, np.nan)
    for k, wanted in enumerate(speeds):
        away = speed - wanted
        passed = np.flatnonzero((away[1:] * away[:-1] <= 0.0) | (np.abs(away[1:]) < NEAR * wanted))
        if passed.size:
            a, b = passed[-1], passed[-1] + 1
            share = 1.0 if away[a] * away[b] >= 0.0 else away[a] / (away[a] - away[b])
            passages[k] = tracks.time[rows[a]] + share * (tracks.time[rows[b]] - tracks.time[rows[a]])
    return passages


def _tracked(tracks: Tracks, times: Floats, how: TrackingOptions) -> NDArray[np.complex128]:
    """First orders of the run at these times, (time, channel); nan where there is no whole window."""
    tracked = np.full((times.size, len(tracks.seen)), np.nan, np.complex128)
    inside = tracks.time[tracks.whole(how)]
    if not inside.size:
        return tracked
    rows = np.flatnonzero((times >= inside[0]) & (times <= inside[-1]))
    if how.bandwidth:
        rate = 1.0 / float(tracks.time[1] - tracks.time[0])
        every = filtered_orders(tracks.angle, tracks.seen, how.orders, how.bandwidth, rate).amplitude
        first = every[int(np.argmin(np.abs(how.orders - 1.0)))]
        tracked[rows] = np.array([np.interp(times[rows], tracks.time, one) for one in first]).T
        return tracked
    centers = np.interp(times[rows], tracks.time, tracks.angle)
    every = fitted_orders(tracks.angle, tracks.seen, how.orders, centers, how.revolutions).amplitude
    tracked[rows] = every[int(np.argmin(np.abs(how.orders - 1.0)))].T
    return tracked


def _peaks(
    known: Orders, simulated: NDArray[np.complex128], passed: Floats, c: int, name: str, unit: str, seed: int
) -> list[Row]:
    """Greatest amplitude and its speed, of the run (which has the speeds ``passed``) with the noise of the readings."""
    random = generator(seed, c)
    parts = [np.nan_to_num(one[:, c]) for one in (known.deviations, known.across)]
    shape = (DRAWS_OF_NOISE, known.speeds.size)
    noise = parts[0] * random.standard_normal(shape) + 1j * parts[1] * random.standard_normal(shape)
    drawn = np.abs(simulated[:, c] + noise)
    at = drawn.argmax(axis=1)
    rows = []
    measured = int(np.abs(known.readings[:, c]).argmax())
    for what, sign, seen, values in (
        ("peak_amplitude", unit, abs(known.readings[measured, c]), drawn[np.arange(DRAWS_OF_NOISE), at]),
        ("peak_amplitude_speed", "rad/s", known.speeds[measured], passed[at]),
    ):
        rows.append(Row(what, sign, name, float(seen), float(values.mean()), float(values.std(ddof=1))))
    return rows


def _arrays(
    known: Orders,
    names: list[str],
    units: list[str],
    times: Floats,
    simulated: NDArray[np.complex128],
    passed: Floats,
) -> xr.Dataset:
    both = ("channel", "order_time")
    away = simulated - known.readings
    size = np.abs(known.readings)
    entries = {
        "order_amplitude": (both, size.T),
        "order_amplitude_deviation": (both, known.deviations.T),
        "order_phase": (both, np.angle(known.readings).T),
        "order_phase_deviation": (both, np.arctan2(known.across, size).T),
        "order_amplitude_simulated": (both, np.abs(simulated).T),
        "order_phase_simulated": (both, np.angle(simulated).T),
        "order_speed": ("order_time", known.speeds, {"units": "rad/s"}),
        "order_speed_simulated": ("order_time", passed, {"units": "rad/s"}),
        "units": ("channel", np.array(units, dtype=object)),
        "rms_measured": ("channel", np.sqrt((size**2).mean(axis=0))),
        "rms_away": ("channel", np.sqrt((np.abs(away) ** 2).mean(axis=0))),
        "rms_expected": ("channel", np.sqrt((known.deviations**2 + known.across**2).mean(axis=0))),
    }
    coordinates = {"channel": np.array(names, dtype=object), "order_time": ("order_time", times, {"units": "s"})}
    return xr.Dataset(entries, coordinates)


# A measured run-up as something that a machine is fitted to: each trial of the fit is simulated.


MOST_SAMPLES = 20_000  # samples of a channel; of more every second, third, ... is taken
QUIET: Any = False  # no bar
OF_RUNS = Search(step=1e-4, accuracy=1e-6, central=False, error=1e-6)  # as exact as they are
TOLERANCE = 1e-9  # of runs, so that their differences are smooth


@dataclass(frozen=True, eq=False)
class MeasuredRunUp:
    """Signals or ball angles of one run-up, for :func:`autobalancer.rotor.identify`.

    Time zero of the measurement is that of a run of the machine, whose drive and start are those of the test. Every sample counts
    with the standard deviation of its noise, which is taken as white. The offset of a sensor of motion is free.

    Parameters
    ----------
    measured
        Signals with the ``uncertainty`` of each channel, or ball angles with their ``ball_angle_deviation``.
    seed
        Of the runs, for what the machine leaves to chance.
    label
        In reports.
    times
        Also at these times (s) the run is sampled, those of other measurements of the same run-up: they share it.
    """

    measured: xr.Dataset
    seed: int = 0
    label: str = "run-up"
    times: Sequence[float] = ()
    search: ClassVar[Search] = OF_RUNS

    def __post_init__(self) -> None:
        step = -(-self.measured.sizes.get("time", 1) // MOST_SAMPLES)
        thin = self.measured.isel(time=slice(None, None, step)) if step > 1 else self.measured
        object.__setattr__(self, "measured", thin)
        for one in stated(thin):
            if not (np.isfinite(one.deviation).all() and (one.deviation > 0.0).all()):
                raise QuestionError(
                    f"{self.label}: the noise of {one.name!r} is not known; give its standard deviation, as the attribute "
                    "'uncertainty' of a channel or as ball_angle_deviation of a film"
                )
        if not thin["time"].values[0] >= 0.0:
            raise QuestionError(f"{self.label}: it begins before the run, at {thin['time'].values[0]:.6g} s")

    def rows(self) -> Rows:
        """See :class:`~autobalancer.rotordynamics.parameter_fit.Measurement`."""
        result = stated(self.measured)
        values, error = (np.concatenate([one[k] for one in result]) for k in (3, 4))
        units = "/".join(sorted({one.unit for one in result}))
        return Rows(self.label, "run-up", units, values, error, np.full(values.size, np.nan))

    def predict(self, trial: Trial) -> Floats:
        """See :class:`~autobalancer.rotordynamics.parameter_fit.Measurement`."""
        pairs = self.pairs(trial)
        return np.concatenate([pair.shifted for pair in pairs]) if pairs else np.full(self.rows().measured.size, np.nan)

    def pairs(self, trial: Trial) -> list[Pair]:
        """Measured beside simulated; nothing if the run does not come to its end."""
        run = self._run(trial)
        return pairs(run, self.measured, dense=False) if run.attrs["outcome"] == "finished" else []

    def doubts(self, trial: Trial) -> list[str]:
        """What is probably wrong with its units."""
        return list(filter(None, map(scale_doubt, self.pairs(trial))))

    def _run(self, trial: Trial) -> xr.Dataset:
        time = np.unique(np.concatenate([self.measured["time"].values, self.times]))
        key = (self.seed, time.tobytes())
        if key not in trial.runs:
            save = SampleTimes(time)  # type: ignore[arg-type]
            trial.runs[key] = simulate_races(
                trial.machine, duration=float(time[-1]), save=save, tolerance=TOLERANCE, seed=self.seed, progress=QUIET
            )
        return trial.runs[key]

    def residual(self, predicted: Floats) -> Floats:
        """See :class:`~autobalancer.rotordynamics.parameter_fit.Measurement`."""
        rows = self.rows()
        return np.asarray((predicted - rows.measured) / rows.error, np.float64)

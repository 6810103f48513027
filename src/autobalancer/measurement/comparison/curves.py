"""Orders that were measured beside those of a run, tracked by the same method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.balancing.run_down import UNITS, Orders, given_orders
from autobalancer.measurement.comparison.pairs import (
    Pair,
    Row,
    measure_table,
    pairs,
    place_doubt,
    scale_doubt,
    size_doubt,
    stated,
)
from autobalancer.measurement.orders.tracking import WINDOW, filtered_orders, fitted_orders
from autobalancer.measurement.sensors import Sensor, motion, place_seen, sampled
from autobalancer.random_numbers import generator
from autobalancer.rotordynamics.identification.fit import Search
from autobalancer.rotordynamics.identification.measurements import Rows, Trial
from autobalancer.simulation.record import Samples, SampleTimes
from autobalancer.simulation.run import simulate_races

Floats = NDArray[np.float64]
PER_TURN = 32  # samples of the run in a turn of the rotor
MOST = 2_000_000  # samples
NEAR = 1e-3  # relative difference of speeds that are one
DIFFERENT = 0.02  # relative difference of speeds at one time, above which a note says so
DRAWS = 50  # of the noise


class How(NamedTuple):
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

    def whole(self, how: How) -> NDArray[np.bool_]:
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
    known = given_orders(measured, "compare", biased=False)
    names = [str(one) for one in measured["channel"].values] if "channel" in measured.coords else _names(known)
    tracks, how = _tracks(run, known), _how(measured)
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
    places = [place_seen(run, sensor) for sensor in sensors]
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
    how, last = _how(measured), int(known.times.argmax())
    window = 2.0 * np.pi / known.speeds[last] * how.revolutions if how.revolutions else 2.0 / how.bandwidth
    duration = float(known.times[last] + 0.6 * window)
    count = int(np.ceil(duration * known.speeds.max() / (2.0 * np.pi) * PER_TURN)) + 1
    run = simulate_races(machine, duration=duration, save=Samples(count), tolerance=TOLERANCE, progress=QUIET)
    if run.attrs["outcome"] != "finished":
        return np.full(known.readings.shape, np.nan, np.complex128)
    return _tracked(_tracks(run, known), known.times, how)


def _names(known: Orders) -> list[str]:
    return [f"{way:.4g} deg at {place}" for place, way in zip(known.places, np.degrees(known.directions), strict=True)]


def _how(measured: xr.Dataset) -> How:
    """How orders were tracked; by default with the local fit."""
    about = measured.attrs
    every = np.atleast_1d(measured["order"].values) if "order" in measured.coords else np.ones(1)
    if "bandwidth" in about:
        return How(every, 0.0, float(about["bandwidth"]))
    return How(every, float(about.get("window_revolutions", WINDOW)), 0.0)


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


def _passages(tracks: Tracks, speeds: Floats, how: How) -> Floats:
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


def _tracked(tracks: Tracks, times: Floats, how: How) -> NDArray[np.complex128]:
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
    shape = (DRAWS, known.speeds.size)
    noise = parts[0] * random.standard_normal(shape) + 1j * parts[1] * random.standard_normal(shape)
    drawn = np.abs(simulated[:, c] + noise)
    at = drawn.argmax(axis=1)
    rows = []
    measured = int(np.abs(known.readings[:, c]).argmax())
    for what, sign, seen, values in (
        ("peak_amplitude", unit, abs(known.readings[measured, c]), drawn[np.arange(DRAWS), at]),
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
        """See :class:`~autobalancer.rotordynamics.identification.measurements.Measurement`."""
        result = stated(self.measured)
        values, error = (np.concatenate([one[k] for one in result]) for k in (3, 4))
        units = "/".join(sorted({one.unit for one in result}))
        return Rows(self.label, "run-up", units, values, error, np.full(values.size, np.nan))

    def predict(self, trial: Trial) -> Floats:
        """See :class:`~autobalancer.rotordynamics.identification.measurements.Measurement`."""
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
        """See :class:`~autobalancer.rotordynamics.identification.measurements.Measurement`."""
        rows = self.rows()
        return np.asarray((predicted - rows.measured) / rows.error, np.float64)

"""A run of a machine as a logger would have measured it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import butter, sosfilt, sosfilt_zi

from autobalancer.errors import QuestionError
from autobalancer.measurement.sensors.motion import DEGREE, motion, sampled
from autobalancer.measurement.sensors.sensor import Sensor, Tacho, hertz
from autobalancer.measurement.signals.form import Channel, signals
from autobalancer.random_numbers import generator
from autobalancer.results.of_a_run import of_a_run
from autobalancer.units import argument

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
    rate = hertz("sampling_rate", sampling_rate)
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
    found = signals(time, channels, origin=f"run of {run.attrs.get('machine_name', 'a machine')}")
    found.attrs |= {"machine": run.attrs["machine"]} if "machine" in run.attrs else {}
    return found


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


Floats = NDArray[np.float64]
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

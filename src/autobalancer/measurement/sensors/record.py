"""A run of a machine as a logger would have measured it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.interpolate import make_interp_spline

from autobalancer.errors import QuestionError
from autobalancer.measurement.sensors.motion import DEGREE, motion, sampled
from autobalancer.measurement.sensors.reading import pulses, read, uncertainty_of
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

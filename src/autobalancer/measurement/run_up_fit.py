"""Fit a machine to a measured run-up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field
from scipy.stats import norm

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.text_files import TABLES, read_table
from autobalancer.machine import Machine
from autobalancer.machine.part import Amount, Angle, Label, Listed, Speed, Time, key
from autobalancer.measurement.balancing.run_down import (
    EXAMPLE,
    UNITS,
    Orders,
    ReadingErrors,
    channel_response,
    first_orders,
    follows_speed,
    load_orders,
)
from autobalancer.measurement.load_signals import load_signals
from autobalancer.measurement.orbit import SLOW
from autobalancer.measurement.pairs import OF_RUNS, MeasuredRunUp, is_film, orders_of_a_run, size_doubt
from autobalancer.results.signals import Signals
from autobalancer.results.store import load_run
from autobalancer.rotordynamics.identify import Identification, identify
from autobalancer.rotordynamics.measurement_file import Entry, MeasurementFile, read_measurements
from autobalancer.rotordynamics.parameter_fit import (
    EXACT,
    Bounds,
    FreeParameter,
    Loss,
    Measurement,
    Rows,
    Search,
    Trial,
)
from autobalancer.safe_file import as_path
from autobalancer.units import argument

COVERED = 0.95


def fit_run_up(
    machine: Machine | str | Path,
    measured: xr.Dataset | Sequence[xr.Dataset],
    parameters: Sequence[FreeParameter] | Mapping[str, Bounds],
    *,
    loss: Loss = "linear",
    starts: int = 1,
    seed: int = 0,
) -> Identification:
    """Find parameters with which a simulated run-up is the measured one.

    Every trial is a run of the machine with its drive and its start, sampled as the logger did. The sum of the squares of all
    deviations, each over its standard deviation, becomes least; the covariance is that of the least squares.

    Parameters
    ----------
    machine
        Where the fit begins; its drive and its start are those of the test.
    measured
        Signals with the ``uncertainty`` of each channel, or ball angles with their ``ball_angle_deviation``; or several of them
        of one run-up. Times are those of the run.
    parameters
        As ``free`` of :func:`autobalancer.rotor.identify`.
    loss, starts
        As there.
    seed
        Of the runs, and of the starts.

    Returns
    -------
    Identification
        As of :func:`autobalancer.rotor.identify`; ``data`` has over ``parameter`` also ``interval_low`` and ``interval_high``,
        which enclose the true value with 95 %, if the model is right and the noise white and as stated. ``data.attrs["notes"]``
        say which parameters cannot be told apart.

    Raises
    ------
    QuestionError
        If the noise is not known, a place is not in the machine, or there are fewer samples than parameters.
    """
    given = [measured] if isinstance(measured, xr.Dataset) else list(measured)
    if not given:
        raise QuestionError("fit_run_up: measured: given none; give signals, or ball angles of a film")
    names = ["run-up"] if len(given) == 1 else [f"run-up, measurement {number}" for number in range(1, len(given) + 1)]
    times = np.unique(np.concatenate([MeasuredRunUp(one).measured["time"].values for one in given]))
    parts = [MeasuredRunUp(one, seed, name, times.tolist()) for one, name in zip(given, names, strict=True)]
    values = sum(part.rows().measured.size for part in parts)
    if values <= len(parameters):
        raise QuestionError(f"fit_run_up: {values} measured values for {len(parameters)} parameters; give more values")
    run_up = identify(machine, parameters, parts, loss=loss, starts=starts, seed=seed)
    wide = float(norm.ppf(0.5 + 0.5 * COVERED)) * run_up.data["uncertainty"]
    for name, sign, text in (("interval_low", -1.0, "lower"), ("interval_high", 1.0, "upper")):
        run_up.data[name] = run_up.data["value"] + sign * wide
        run_up.data[name].attrs = {"long_name": f"{text} end of the interval of 95 %, SI"}
    return run_up


# Amplitude and phase over the speed as something that a machine is fitted to, by its steady response or by its run-up.


@dataclass(frozen=True, eq=False)
class MeasuredOrders:
    """Amplitude and phase of the first order, for :func:`autobalancer.rotor.identify`.

    A machine gives its unbalance response in their place, along the measured speed over the time and through the same window; the
    steady one where only speeds are known or rubber softens, so that the run-up must be slow. Or the orders of a simulated
    run-up, tracked alike.
    Of tracked orders those points count whose noise is independent; in a response what the window probably takes away is part of
    the deviation.

    Parameters
    ----------
    orders
        From :func:`autobalancer.measure.orders`, or amplitude and phase over ``speed`` and ``channel``; or the path of such a
        result (.nc) or of a table, see :func:`load_orders`.
    error
        Standard deviation where none is stated: in percent of each amplitude, such as "2 %", or in their unit.
    balls
        Whether the masses of the balls are on the rotor, without unbalance of their own.
    ball_angles
        Angles of all balls in the rotor, rad, where they rest during the test: with mass and unbalance of the balls.
    lowest, highest
        Speeds that are used, rad/s or texts.
    steady
        Otherwise each trial is a run with the drive and the start of the machine, and the times of the orders are those of the
        run; its balls move, and ``balls`` and ``ball_angles`` are not used.
    label
        In reports.
    """

    orders: xr.Dataset | str | Path
    error: float | str | None = None
    balls: bool = False
    ball_angles: Sequence[float | str] | None = None
    lowest: float | str = 0.0
    highest: float | str = np.inf
    label: str = "orders"
    steady: bool = True

    @property
    def search(self) -> Search:
        """As exact as responses and runs are."""
        return EXACT if self.steady else OF_RUNS

    @cached_property
    def data(self) -> xr.Dataset:
        """The orders, read if a path was given."""
        return self.orders if isinstance(self.orders, xr.Dataset) else load_measured(self.orders)

    @cached_property
    def known(self) -> Orders:
        """As arrays."""
        orders = first_orders(self.data, self.label, biased=self.steady)
        low, high = (argument(name, getattr(self, name), "rad/s") for name in ("lowest", "highest"))
        inside = (orders.speeds >= low) & (orders.speeds <= high)
        if not inside.any():
            raise QuestionError(
                f"{self.label}: no speed from {low:g} to {high:g} rad/s was measured; there are {orders.speeds.min():.5g} to "
                f"{orders.speeds.max():.5g} rad/s"
            )
        if not (self.steady or np.isfinite(orders.times).all()):
            raise QuestionError(
                f"{self.label}: orders over the speed have no times of a run-up; leave out steady=False"
            )
        return orders.at(inside)

    @cached_property
    def deviations(self) -> tuple[Floats, Floats]:
        """Standard deviations along and across the complex amplitudes, (S, C), without those that readings share."""
        known = self.known
        along = np.sqrt(np.maximum(known.deviations**2 - known.shared**2, 0.0))
        across = np.fmax(along, np.sqrt(np.maximum(known.across_of_noise**2 - known.shared**2, 0.0)))
        if self.error is not None:
            there = np.isfinite(along) & (along > 0.0)
            along, across = (np.where(there, one, self._error()) for one in (along, across))
        if not all(np.isfinite(one).all() and (one > 0.0).all() for one in (along, across)):
            raise QuestionError(
                f"{self.label}: the deviation of the amplitudes is not known; give error, such as '2 %', or a column "
                "'amplitude deviation'"
            )
        return along, across

    def _error(self) -> Floats:
        size = np.abs(self.known.readings)
        text = str(self.error).strip()
        if text.endswith("%"):
            return np.asarray(size * float(argument("error", text[:-1], "")) / 100.0)
        units = {UNITS[quantity] for quantity in self.known.quantities}
        if len(units) > 1:
            raise QuestionError(f"{self.label}: error: channels have several units; give it in percent, such as '2 %'")
        return np.full(size.shape, float(argument("error", self.error, units.pop())))

    def rows(self) -> Rows:
        """See :class:`~autobalancer.rotordynamics.parameter_fit.Measurement`."""
        known, size = self.known, np.abs(self.known.readings)
        wide = self._errors.widening()
        along, across = (deviation * more for deviation, more in zip(self.deviations, wide, strict=True))
        names = [self._channel(c) for c in range(len(known.places))]
        parts = tuple(f"{name}, {what}" for what in ("amplitude", "phase") for name in names for _ in known.speeds)
        error = np.concatenate([along.T.ravel(), np.arctan2(across, size).T.ravel()])
        units = ", ".join([*dict.fromkeys(UNITS[quantity] for quantity in known.quantities), "rad"])
        speed = np.tile(known.speeds, 2 * len(names))
        return Rows(self.label, "orders", units, _flat(known.readings), error, speed, parts)

    def _channel(self, number: int) -> str:
        place, way = self.known.places[number], np.degrees(self.known.directions[number])
        along = {0.0: "x", 90.0: "y"}.get(round(float(way), 6), f"{way:.4g} deg")
        return f"{along} at {place}" if place != "" else along

    def predict(self, trial: Trial) -> Floats:
        """See :class:`~autobalancer.rotordynamics.parameter_fit.Measurement`."""
        if self.steady:
            options: dict[str, Any] = {"balls": self.balls, "ball_angles": self.ball_angles}
            values = _flat(channel_response(trial.machine, self.known, None, self.label, **options))
        else:
            values = _flat(orders_of_a_run(trial.machine, self.data, self.known))
        half = values.size // 2
        measured = _flat(self.known.readings)[half:]
        values[half:] = measured + (values[half:] - measured + np.pi) % (2.0 * np.pi) - np.pi
        return values

    def residual(self, predicted: Floats) -> Floats:
        """Along and across the measured amplitudes, in standard deviations; what a channel shares counts once."""
        size, phase = (part.reshape(-1, self.known.speeds.size).T for part in np.split(predicted, 2))
        return self._errors.white(size * np.exp(1j * phase) - self.known.readings)

    @cached_property
    def _errors(self) -> ReadingErrors:
        return ReadingErrors(self.known, *self.deviations)

    def doubts(self, trial: Trial) -> list[str]:
        """What is probably wrong with the unit of a channel."""
        count = len(self.known.places)
        seen, given = (np.split(one, 2)[0].reshape(count, -1) for one in (self.predict(trial), self.rows().measured))
        units = [UNITS[quantity] for quantity in self.known.quantities]
        doubts = [
            size_doubt(f"{self.label}, {self._channel(c)}", units[c], float(given[c].max()), float(seen[c].max()))
            for c in range(count)
        ]
        return list(filter(None, doubts))

    def notes(self, trial: Trial) -> list[str]:
        """Whether the measured speed was followed; if not, whether it changed too fast for a steady response."""
        known = self.known
        if not self.steady:
            return []
        if follows_speed(trial.machine, known):
            return [f"{self.label}: the response is followed along the measured speed"]
        text = f"{self.label}: compared with the steady response"
        roots = trial.motions(float(np.median(known.speeds)), self.balls).eigenvalue
        passed = roots[(roots.imag > known.speeds.min()) & (roots.imag < known.speeds.max())]
        if not passed.size:
            return [text]
        decay, rpm = float(np.abs(passed.real).min()), 30.0 / np.pi
        if known.speeds.size < 2 or not np.isfinite(known.times).all():
            slow = f"{SLOW * decay**2 * rpm:.3g} rpm/s"
            return [
                f"{text}, which is right at constant speeds or below {slow}; of a faster run-up give orders over time"
            ]
        growth = float(np.abs(np.gradient(known.speeds, known.times)).max())
        if growth <= SLOW * decay**2:
            return [text]
        fast = f"{growth * rpm:.3g} rpm/s, {growth / decay**2:.2g} of the squared decay rate"
        return [f"{text}, but the speed changes fast, by up to {fast}: take steady = false"]


def _flat(values: NDArray[np.complex128]) -> Floats:
    """Amplitudes of channel after channel, then phases."""
    return np.concatenate([np.abs(values).T.ravel(), np.angle(values).T.ravel()])


# Whatever was measured, from its file.


def load_measured(path: str | Path) -> xr.Dataset:
    """Read whatever was measured: a result of this package, a table of orders over the speed, or signals.

    Parameters
    ----------
    path
        A result (.nc); a table with speed, amplitude and phase, see :func:`load_orders`; or a file of
        signals, see :func:`autobalancer.measure.load_signals`.

    Returns
    -------
    xarray.Dataset
        As these functions return it.

    Raises
    ------
    ResultError
        If the file cannot be read as any of them.
    """
    path = as_path(path)
    if path.suffix.lower() == ".nc":
        return load_run(path)
    return load_orders(path) if _has_orders(path) else load_signals(path)


def _has_orders(path: Path) -> bool:
    """Whether it is a table with speed, amplitude and phase, and no time."""
    if path.suffix.lower() not in TABLES:
        return False
    try:
        heads = set(read_table(path, EXAMPLE).heads)
    except ResultError:
        return False  # the reader of signals says what is wrong
    return {"speed", "amplitude", "phase"} <= heads and "time" not in heads


# Measurement files with all that a machine can be fitted to: also orders, signals and films, which they name.


def load_measurements(path: str | Path) -> tuple[list[FreeParameter], list[Measurement]]:
    """Read a measurement file.

    Parameters
    ----------
    path
        A TOML file with the lists ``parameters``, ``modes``, ``critical_speeds``, ``stiffnesses``, ``known``, ``responses``,
        ``orders`` and ``run_ups``; their keys are those of
        :class:`~autobalancer.rotordynamics.parameter_fit.FreeParameter`, of the classes in
        :mod:`autobalancer.rotordynamics.parameter_fit`, of ``MeasuredOrders`` and of ``MeasuredRunUp``. An
        ``error`` is a quantity or a text in percent of the value. A ``file`` is beside the TOML file: the table of a response;
        orders as table or result (.nc); signals, or the ball angles of a film (.nc), of a run-up.

    Returns
    -------
    list, list
        Free parameters and measurements, for :func:`~autobalancer.rotordynamics.identify.identify`.

    Raises
    ------
    QuestionError
        If the file or an entry cannot be read; the message names the key.
    ResultError
        If a table or a result cannot be read.
    """
    free, measurements = read_measurements(path, RunUpFile)
    return free, _sharing(measurements)


def _sharing(measurements: list[Measurement]) -> list[Measurement]:
    """Run-ups with the same seed are one run, sampled for all of them."""
    times = {measurement.seed: np.zeros(0) for measurement in measurements if isinstance(measurement, MeasuredRunUp)}
    for measurement in measurements:
        if isinstance(measurement, MeasuredRunUp):
            times[measurement.seed] = np.union1d(times[measurement.seed], measurement.measured["time"].values)
    return [
        replace(measurement, times=times[measurement.seed].tolist())
        if isinstance(measurement, MeasuredRunUp)
        else measurement
        for measurement in measurements
    ]


class OrdersEntry(Entry):
    """Amplitude and phase of the first order over the speed."""

    file: Label = key("orders beside this file, as a table or as a result (.nc)")
    error: Amount | None = key(
        "standard deviation where none is stated", None, value="in the unit of the amplitudes, or percent of them"
    )
    balls: bool = key("whether the masses of the balls are on the rotor, without unbalance of their own", False)
    ball_angles: tuple[Angle, ...] | None = key("of all balls in the rotor, where they rest during the test", None)
    lowest: Speed = key("that is used", 0.0)
    highest: Speed | None = key("that is used", None)
    steady: bool = key("`false`: each trial is a run with the drive and the start of the machine", True)
    label: Label | None = key("in reports; the file unless given", None)

    def measurement(self, folder: Path) -> Measurement:
        """See :class:`~autobalancer.rotordynamics.measurement_file.Entry`."""
        measured = MeasuredOrders(folder / self.file, label=self.label or self.file, **self._rest("file", "label"))
        measured.rows()
        return measured


class RunUpEntry(Entry):
    """A run-up: signals with their noise, or the ball angles of a film."""

    file: Label = key("the result (.nc) beside this file")
    start: Time | None = key("of what is used", None)
    end: Time | None = key("of what is used", None)
    seed: Annotated[int, Field(strict=True, ge=0)] = key("of the runs; those with the same seed are one run", 0)
    label: Label | None = key("in reports; the file unless given", None)

    def measurement(self, folder: Path) -> Measurement:
        """See :class:`~autobalancer.rotordynamics.measurement_file.Entry`."""
        given = load_measured(folder / self.file)
        if not (is_film(given) or isinstance(given, Signals)):
            raise QuestionError(
                f"{self.file} has neither signals nor ball angles of a film; orders stand under [[orders]], other results are "
                "no measurement of a run-up",
                ("file",),
            )
        time = given["time"].values
        low, high = (float(end if one is None else one) for one, end in ((self.start, time[0]), (self.end, time[-1])))
        return MeasuredRunUp(_part(given, low, high, self.file), self.seed, self.label or self.file)


def _part(given: xr.Dataset, low: float, high: float, name: str) -> xr.Dataset:
    time = given["time"].values
    dataset = given.isel(time=(time >= low) & (time <= high))
    if dataset.sizes["time"] < 2:
        raise QuestionError(f"{name}: nothing from {low:g} s to {high:g} s; it has {time[0]:g} s to {time[-1]:g} s")
    return dataset


class RunUpFile(MeasurementFile):
    """What is free, and what was measured, orders and run-ups, too."""

    orders: Annotated[tuple[OrdersEntry, ...], Listed] = key("amplitude and phase over the speed", ())
    run_ups: Annotated[tuple[RunUpEntry, ...], Listed] = key("runs, sample by sample", ())

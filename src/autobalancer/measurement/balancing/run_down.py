"""Unbalance of all planes from one run-down and a model of the rotor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.text_files import Table, read_table
from autobalancer.machine import Machine, Unbalance
from autobalancer.measurement.balancing.balance import polar_deviations
from autobalancer.measurement.noise_density import independent
from autobalancer.measurement.signals import quantity_of
from autobalancer.measurement.tracking import passed_at, window_of_fit
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.rotordynamics.natural_modes import rotor_of
from autobalancer.rotordynamics.response import response, rubber_of
from autobalancer.safe_file import as_path

OWNER = "run-down"
INSEPARABLE, POOR = 1e8, 50.0  # condition numbers beyond which planes cannot be, and are hardly, told apart
OWN = 1e-3  # least share of a deviation that a reading has for itself
MOST_WAVES = 600  # of which errors of the rotor angle are made
FAR = 3.0  # chi square of each reading beyond which the model does not describe the rotor


def unbalance_from_run_down(
    machine: Machine | str | Path,
    orders: xr.Dataset | str | Path,
    *,
    planes: Sequence[str | float] | None = None,
    lowest: float = 0.0,
    highest: float = np.inf,
) -> Answer:
    """Unbalance vectors of several planes that explain what sensors saw over the speed, by weighted least squares.

    The model of the rotor takes the place of trial runs: it says what an unbalance in each plane does at each sensor and speed.
    Speeds near several critical speeds tell planes apart.

    Parameters
    ----------
    machine
        Any rotor; its own unbalances and the unbalance of its balls are ignored, their masses are in.
    orders
        Amplitude and phase of the first order over ``speed`` and ``channel``: ``amplitude`` (SI), ``phase`` (rad, lead of the
        vibration over the mark) and perhaps ``amplitude_deviation`` and ``phase_deviation``; with ``place`` (a station or a
        position, m), ``direction`` (``x``, ``y`` or degrees from x) and ``quantity`` of each channel. Or a table, see
        :func:`load_orders`.
    planes
        Stations or positions (m) whose unbalance is asked for; by default all stations of the machine, else the plane of its
        first balancer.
    lowest, highest
        Speeds that are used, rad/s.

    Returns
    -------
    Answer
        Over ``plane``: ``unbalance`` (kg m) and ``unbalance_angle`` (rad) with one standard ``_deviation`` each, and
        ``covariance`` over both parts; over ``combination``: ``combination_deviation`` (kg m), that of combinations of all
        planes, the worst known first, and ``weight``, ``weight_phase`` of each plane in them; over ``speed`` and ``channel``
        what was ``measured`` and ``fitted``.

    Raises
    ------
    QuestionError
        If channels or speeds are missing, or planes cannot be told apart; it names the combination.
    """
    machine = balls_in_races(machine)
    requested = _planes(machine, planes)
    known = _used(first_orders(orders), lowest, highest)
    # what a unit unbalance in each plane does at each speed and channel, (S C, P)
    loads: list[Any] = [1.0 if plane is None else (Unbalance(moment=1.0, station=plane),) for plane in requested]
    columns = [channel_response(machine, known, load, OWNER, balls=True).ravel() for load in loads]
    rows = np.stack(columns, axis=1)
    values, spread, given = _flat(known)
    weighted = rows / spread[:, None]
    size = np.linalg.norm(weighted, axis=0)
    if not (size > 0.0).all():
        raise QuestionError(
            f"{OWNER}: unbalance in plane {requested[int(np.argmin(size))]!r} moves no sensor of these; leave it out"
        )
    _, singular, turned = np.linalg.svd(weighted / size, full_matrices=False)
    condition = float(singular[0] / singular[-1]) if singular.size == len(requested) and singular[-1] > 0.0 else np.inf
    if values.size < len(requested) or condition > INSEPARABLE:
        raise QuestionError(
            f"{OWNER}: planes {', '.join(map(str, requested))} cannot be told apart by {values.size} readings: "
            f"{_words(turned[-1] / size, requested)} "
            "moves no sensor. Ask for fewer planes, or use more speeds and sensors"
        )
    errors = _errors(known, spread, given)
    shape = known.readings.shape
    parts = np.column_stack([errors.white(turn * row.reshape(shape)) for turn in (1.0, 1.0j) for row in rows.T])
    both = np.linalg.lstsq(parts, errors.white(known.readings), rcond=None)[0]
    unbalance = both[: len(requested)] + 1j * both[len(requested) :]
    freedom = values.size - len(requested)
    miss = (
        float((errors.white((values - rows @ unbalance).reshape(shape)) ** 2).sum()) / 2.0
    )  # of each of two directions
    chi = miss / freedom if freedom > 0 else 1.0
    more = chi if not given else max(1.0, chi)
    covariance = more * np.linalg.inv(parts.T @ parts)
    return _dataset(
        machine, known, requested, unbalance, covariance, rows, condition, chi if given else np.nan, turned, size
    )


def _planes(machine: Machine, planes: Sequence[str | float] | None) -> list[str | float | None]:
    if planes is not None:
        if not len(planes):
            raise QuestionError(f"{OWNER}: planes: given none; name at least one")
        return list(planes)
    return [station.name for station in machine.stations] or [None]


def _used(known: Orders, lowest: float, highest: float) -> Orders:
    inside = (known.speeds >= lowest) & (known.speeds <= highest)
    if not inside.any():
        raise QuestionError(f"{OWNER}: no speed from {lowest:g} to {highest:g} rad/s was measured")
    return known.at(inside)


def _flat(known: Orders) -> tuple[Complexes, Floats, bool]:
    """Readings, deviations (those that are missing as equal shares of the greatest reading), and whether all were given."""
    values, spread = known.readings.ravel(), known.deviations.ravel()
    given = bool(np.isfinite(spread).all() and (spread > 0.0).all())
    return values, spread if given else np.full(values.size, float(np.abs(values).max()) or 1.0), given


def _errors(known: Orders, spread: Floats, given: bool) -> ReadingErrors:
    """Of readings with known deviations what each has for itself and what they share; else the same for all."""
    if not given:
        alike = spread.reshape(known.readings.shape)
        return ReadingErrors(replace(known, shared=np.zeros_like(known.shared), edge=0.0), alike, alike)
    along, across = (
        np.sqrt(np.maximum(one**2 - known.shared**2, (OWN * one) ** 2))
        for one in (known.deviations, known.across_of_noise)
    )
    return ReadingErrors(known, along, np.fmax(along, across))


def _words(vector: Complexes, planes: list[str | float | None]) -> str:
    v = vector.conj()
    v = v / v[int(np.argmax(np.abs(v)))]
    parts = [
        f"{abs(one):.2g} in {'the plane of the balancer' if plane is None else plane} at {np.degrees(np.angle(one)):.0f} deg"
        for one, plane in zip(v, planes, strict=True)
        if abs(one) > 0.03
    ]
    return " with ".join(parts)


def _dataset(
    machine: Machine, known: Orders, planes: list[str | float | None], result: Any, covariance: Any, rows: Complexes,
    condition: float, chi: float, turned: Complexes, size: Floats,
) -> Answer:  # fmt: skip
    sizes, angles = polar_deviations(result, covariance)
    (along, one), (other, across) = (np.hsplit(part, 2) for part in np.vsplit(covariance, 2))
    spread, vectors = np.linalg.eigh(0.5 * (along + across + 1j * (other - one)))  # of both parts alike
    names = ["plane of the first balancer" if plane is None else str(plane) for plane in planes]
    shape = known.readings.shape
    fitted = (rows @ result).reshape(shape)
    over, both = ("plane",), ("speed", "channel")
    data: dict[str, tuple[Any, Any, str, str]] = {
        "unbalance": (over, np.abs(result), "unbalance", "kg m"),
        "unbalance_deviation": (over, sizes, "its standard deviation", "kg m"),
        "unbalance_angle": (over, np.angle(result), "angle of the unbalance in the rotor", "rad"),
        "unbalance_angle_deviation": (over, angles, "its standard deviation", "rad"),
        "covariance": (("component", "other_component"), covariance, "covariance, real parts of all planes first", "kg^2 m^2"),
        "combination_deviation": (("combination",), np.sqrt(np.maximum(spread[::-1], 0.0)), "standard deviation of a "
        "combination", "kg m"),
        "weight": (("combination", "plane"), np.abs(vectors[:, ::-1].T), "weight of a plane in a combination", "1"),
        "weight_phase": (("combination", "plane"), np.angle(vectors[:, ::-1].T), "angle of this weight", "rad"),
        "measured": (both, np.abs(known.readings), "amplitude measured", ""),
        "measured_phase": (both, np.angle(known.readings), "its phase", "rad"),
        "fitted": (both, np.abs(fitted), "amplitude of the model with these unbalances", ""),
        "fitted_phase": (both, np.angle(fitted), "its phase", "rad"),
        "deviation": (both, known.deviations, "standard deviation of the reading", ""),
    }  # fmt: skip
    answer = xr.Dataset(
        {name: (dims, values, {"long_name": text, "units": unit}) for name, (dims, values, text, unit) in data.items()},
        {
            "plane": np.array(names, dtype=object),
            "speed": ("speed", known.speeds, {"long_name": "rotor speed", "units": "rad/s"}),
            "place": ("channel", np.array([str(place) for place in known.places], dtype=object)),
            "direction": (
                "channel",
                np.array(known.directions, dtype=float),
                {"long_name": "angle from x", "units": "rad"},
            ),
            "quantity": ("channel", np.array(known.quantities, dtype=object)),
        },
    )
    left = float(np.linalg.norm(fitted - known.readings) / np.linalg.norm(known.readings))
    warnings = []
    if condition > POOR:
        warnings.append(
            f"planes are hardly told apart (condition number {condition:.3g}): {_words(turned[-1] / size, planes)} is "
            "known worst; more "
            "speeds, through another critical speed, or more sensors help"
        )
    if np.isfinite(chi) and chi > FAR:
        warnings.append(
            f"the model does not describe the rotor within the deviations of the readings (chi square {chi:.3g} for "
            "each); fit it first "
            "with rotor.identify. The uncertainty contains what is left, not what is wrong with the model"
        )
    answer.attrs = {
        "title": f"Unbalance from a run-down: {machine.name}", **provenance(), "machine_name": machine.name,
        "condition": condition, "left_over": left, "warnings": "\n".join(warnings),
    }  # fmt: skip
    return Answer.of(answer, "PlaneUnbalances")


# Amplitude and phase over the speed: from a table, or from a dataset of orders.


EXAMPLE = "speed [rpm], place, direction, amplitude [um], phase [deg], amplitude deviation [um]"
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
SAME = 1e-6  # relative difference of speeds that are one


def load_orders(path: str | Path) -> xr.Dataset:
    """Read amplitude and phase of the first order over the speed.

    Parameters
    ----------
    path
        A table with the columns ``speed``, ``place`` (a station, or a position in m), ``direction`` (x, y, or degrees from x),
        ``amplitude`` (of a displacement, velocity or acceleration), ``phase`` (lead of the vibration over the mark) and perhaps
        ``amplitude deviation``; one line for each speed and sensor.

    Returns
    -------
    xarray.Dataset
        ``amplitude``, ``phase``, ``amplitude_deviation`` over ``speed`` and ``channel``, SI; ``place``, ``direction`` and
        ``quantity`` of each channel.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is missing or cannot be read.
    QuestionError
        If a sensor has no line at some speed; it names both.
    """
    table = read_table(as_path(path), EXAMPLE)
    quantity = _quantity(table)
    speed, amplitude = table.numbers("speed", "rad/s"), table.numbers("amplitude", UNITS[quantity])
    phase = table.numbers("phase", "rad")
    spread = np.full(speed.size, np.nan)
    if "amplitude deviation" in table.heads:
        spread = table.numbers("amplitude deviation", UNITS[quantity])
    channels = list(zip(table.texts("place"), table.texts("direction"), strict=True))
    names = list(dict.fromkeys(channels))
    speeds = np.unique(speed)
    speeds = speeds[np.r_[True, np.diff(speeds) > SAME * speeds[1:]]]
    data = np.full((3, speeds.size, len(names)), np.nan)
    for n, channel in enumerate(channels):
        at = int(np.argmin(np.abs(speeds - speed[n]))), names.index(channel)
        if not np.isnan(data[(0, *at)]):
            line = table.lines[n][0]
            raise QuestionError(
                f"{table.place}, line {line}: {' '.join(channel)} has two lines at this speed; keep one"
            )
        data[(slice(None), *at)] = amplitude[n], phase[n], spread[n]
    missing = np.argwhere(np.isnan(data[0]))
    if missing.size:
        s, c = missing[0]
        raise QuestionError(
            f"{table.place}: {' '.join(names[c])} has no line at {speeds[s] * 30.0 / np.pi:.5g} rpm; all sensors need all speeds"
        )
    both = ("speed", "channel")
    return xr.Dataset(
        {
            "amplitude": (both, data[0], {"units": UNITS[quantity], "long_name": "amplitude"}),
            "phase": (both, data[1], {"units": "rad", "long_name": "lead of the vibration over the mark"}),
            "amplitude_deviation": (both, data[2], {"units": UNITS[quantity], "long_name": "standard deviation"}),
        },
        {
            "speed": ("speed", speeds, {"units": "rad/s", "long_name": "rotor speed"}),
            "place": ("channel", np.array([name[0] for name in names], dtype=object)),
            "direction": ("channel", np.array([name[1] for name in names], dtype=object)),
            "quantity": ("channel", np.array([quantity] * len(names), dtype=object)),
        },
        {"source": str(path)},
    )


def _quantity(table: Table) -> str:
    if "amplitude" not in table.heads:
        raise ResultError(
            f"{table.place}: no column 'amplitude' with a unit; the first line must name the columns, such as: {EXAMPLE}"
        )
    written = table.heads["amplitude"][1]
    quantity = quantity_of("", written)
    if quantity in UNITS:
        return quantity
    raise ResultError(f"{table.place}: amplitude in {written!r}; must be a displacement, a velocity or an acceleration")


# Of a bias the share by which readings still differ from a response through the same window: the window leaves out the image at
# minus the frequency, which free vibrations have after a passage (noise-free run-ups, 1 to 4 squared decay rates a second).
UNLIKE = 0.2


def first_orders(orders: xr.Dataset | str | Path, owner: str = "run-down", biased: bool = True) -> Orders:
    """First orders of a dataset, of its file or of a table, as arrays; of tracked ones those whose noise is independent.

    What the window or the filter probably takes away is part of the deviations, if what they are compared with is without it;
    where that is followed along the speed and passed through the same window, only the share in which both differ.

    Raises
    ------
    QuestionError
        If a variable, a place or a direction is missing.
    """
    from autobalancer.results.store import load_run

    if not isinstance(orders, xr.Dataset):
        orders = load_run(orders) if Path(orders).suffix.lower() == ".nc" else load_orders(orders)
    course = passed = None
    tracked = {"window_revolutions", "bandwidth"} & set(orders.attrs)  # and not measured at one speed after the other
    if tracked and "time" in orders.dims and "speed" in orders.variables and orders.sizes["time"] > 3:
        course = np.asarray(orders["time"].values, float), np.asarray(orders["speed"].values, float)
        if not ((np.diff(course[0]) > 0.0).all() and (course[1] > 0.0).all()):
            course = None
    # of neighboring values of a filter only those that share no noise count
    about = orders.attrs
    orders = independent(orders)
    times = (
        np.asarray(orders["time"].values, float)
        if "time" in orders.dims
        else np.full(orders.sizes.get("speed", 0), np.nan)
    )
    if course is not None:
        passed = _passed(*course, np.searchsorted(course[0], times), about)
    # the first order alone is that of unbalance
    if "order" in orders.dims:
        if 1.0 not in orders["order"].values:
            raise QuestionError(f"{owner}: the orders have no order 1, which is that of unbalance; track it, too")
        orders = orders.sel(order=1.0)
    if "time" in orders.dims and "speed" in orders.variables:
        orders = orders.reset_coords(drop=False).set_coords(["place", "direction", "quantity"]).swap_dims(time="speed")
    for name in ("amplitude", "phase", "speed", "place", "direction"):
        if name not in orders.variables:
            raise QuestionError(
                f"{owner}: the orders have no {name!r}; it must be there over speed and channel, or of each channel"
            )
    # amplitudes and phases at all speeds
    found = orders.transpose("speed", "channel", ...)
    amplitude, phase = found["amplitude"].values, found["phase"].values
    if not (np.isfinite(amplitude).all() and np.isfinite(phase).all()):
        s = int(np.argwhere(~np.isfinite(amplitude * phase))[0][0])
        raise QuestionError(
            f"{owner}: no amplitude and phase at {float(found['speed'][s]) * 30.0 / np.pi:.5g} rpm; leave this speed out"
        )
    # deviations along the amplitude, with what the window takes, and across it, with those of the phase
    spread = found["amplitude_deviation"].values if "amplitude_deviation" in found else np.full(amplitude.shape, np.nan)
    if biased and "bias" in found:
        spread = np.hypot(spread, (1.0 if passed is None else UNLIKE) * found["bias"].values)
    across = spread
    if "phase_deviation" in found:
        across = np.fmax(spread, amplitude * found["phase_deviation"].values)
    quantities = found["quantity"].values if "quantity" in found.variables else ["displacement"] * amplitude.shape[1]
    for quantity in quantities:
        if quantity not in UNITS:
            raise QuestionError(f"{owner}: quantity {str(quantity)!r}; must be one of {', '.join(UNITS)}")
    return Orders(
        times,
        np.asarray(found["speed"].values, float),
        amplitude * np.exp(1j * phase),
        np.asarray(spread, float),
        np.asarray(across, float),
        tuple(map(_place, found["place"].values)),
        tuple(_direction(way, owner) for way in found["direction"].values),
        tuple(map(str, quantities)),
        np.asarray(found["runout_deviation"].values if "runout_deviation" in found else np.zeros(amplitude.shape[1])),
        course,
        passed,
        float(about.get("edge_deviation", 0.0)),
        int(about.get("pulses_of_a_turn", 1)),
        float(about.get("angle_bandwidth", np.inf)),
    )


def _passed(time: Floats, speed: Floats, rows: NDArray[np.intp], about: dict[str, Any]) -> Floats:
    """What the tracking makes of amplitudes over the time at some of its instants, (row, time)."""
    if "bandwidth" in about:
        return passed_at(rows, time.size, float(about["bandwidth"]) * float(time[-1] - time[0]) / (time.size - 1))
    angle = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))]
    return window_of_fit(angle, rows, float(about["window_revolutions"]))


def _place(place: Any) -> str | float:
    try:
        return float(place)
    except ValueError:
        return str(place)


def _direction(direction: Any, owner: str) -> float:
    """Angle from x, rad."""
    text = str(direction).strip()
    if text in ("x", "y"):
        return 0.0 if text == "x" else 0.5 * np.pi
    try:
        return float(np.radians(float(text)))
    except ValueError:
        raise QuestionError(f"{owner}: direction {text!r}; must be x, y, or an angle from x in degrees") from None


# What sensors read at each speed, and what they see of a machine in steady motion.


@dataclass(frozen=True)
class Orders:
    """Complex amplitudes (S, C) with their lead over the mark, standard deviations along and across them, and channels.

    Times are nan where orders are over the speed. ``shared`` is the part of the deviations that is one and the same error of all
    speeds of a channel, (C,): that of the run-out that was subtracted. ``course`` has times and speeds of the whole run-up or
    run-down, along which a linear rotor is followed; ``passed`` is what the window or filter of the tracking makes of a response
    there, (S, time). ``edge`` is the standard deviation of a pulse of the tacho (s), of which a turn has so many ``pulses``, and
    ``band`` the frequency (Hz) up to which the rotor angle follows their errors.
    """

    times: Floats
    speeds: Floats
    readings: Complexes
    deviations: Floats
    across: Floats
    places: tuple[Any, ...]
    directions: tuple[Any, ...]
    quantities: tuple[str, ...]
    shared: Floats
    course: tuple[Floats, Floats] | None = None
    passed: Floats | None = None
    edge: float = 0.0
    pulses: int = 1
    band: float = np.inf

    @property
    def timed(self) -> bool:
        """Whether errors of the rotor angle are known one by one, as :class:`ReadingErrors` counts them."""
        return bool(self.edge > 0.0 and np.isfinite(self.times).all())

    @property
    def across_of_noise(self) -> Floats:
        """Those across without what errors of the rotor angle do, where they are counted by themselves."""
        return self.deviations if self.timed else self.across

    def at(self, rows: NDArray[Any]) -> Orders:
        """Some of the speeds."""
        names = ["times", "speeds", "readings", "deviations", "across", *["passed"] * (self.passed is not None)]
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


@dataclass(frozen=True)
class ReadingErrors:
    """Errors of readings: independent ones along and across each, (S, C), those of the rotor angle, and what a channel shares."""

    known: Orders
    along: Floats
    across: Floats

    def white(self, away: Complexes) -> Floats:
        """Deviations (S, C) from the readings as independent ones of variance one: along, channel by channel, then across."""
        turned = away * np.exp(-1j * np.angle(self.known.readings))
        rest = np.concatenate([(turned.real / self.along).T.ravel(), (turned.imag / self.across).T.ravel()])
        ways, less = self._shared
        return np.asarray(rest + ways @ (less * (ways.T @ rest)))

    def widening(self) -> Floats:
        """By how much errors of the angle make the deviations along and across larger, (2, S, C)."""
        wide = np.hypot(1.0, np.linalg.norm(self._of_angle, axis=1))
        return np.asarray(wide.reshape(2, -1, self.known.speeds.size).swapaxes(1, 2))

    @cached_property
    def _shared(self) -> tuple[Floats, Floats]:
        """Orthonormal ways in which errors move several readings, and by how much each is made less to have a variance of one."""
        seen, count = [self._of_angle], len(self.known.speeds)
        for c in np.flatnonzero(self.known.shared > 0.0):
            phase, rows = np.angle(self.known.readings[:, c]), slice(c * count, (c + 1) * count)
            own = np.zeros((2, self.known.readings.size, 2))
            for part, turned, deviation in zip(
                own, (phase, phase + 0.5 * np.pi), (self.along, self.across), strict=True
            ):
                part[rows] = np.column_stack([np.cos(turned), np.sin(turned)])
                part[rows] *= (self.known.shared[c] / deviation[:, c])[:, None]
            seen.append(own.reshape(-1, 2))
        errors = np.concatenate(seen, axis=1)
        squares, turns = np.linalg.eigh(errors.T @ errors)
        there = squares > 1e-9
        sizes = np.sqrt(squares[there])
        return errors @ turns[:, there] / sizes, 1.0 / np.hypot(1.0, sizes) - 1.0

    @cached_property
    def _of_angle(self) -> Floats:
        """What independent errors of variance one of the rotor angle do to the readings, in standard deviations (reading, error).

        The smooth angle has slow errors of the pulses. Where it is late, a machine that follows it is pushed late: they differ by
        the response to the load times i times the error. Errors are sums of waves up to the frequencies that the smooth angle
        follows; besides, all pulses are late by the same where the turns take nearly the same number of samples.
        """
        known = self.known
        time, speed, edge, pulses, band = known.times, known.speeds, known.edge, known.pulses, known.band
        if not known.timed:
            return np.zeros((2 * known.readings.size, 0))
        passed = np.ptp(2.0 * np.pi / (pulses * speed)) / (
            np.sqrt(12.0) * edge
        )  # samples by which the pulses of a turn move
        moved = [1j * (edge * speed / (1.0 + passed))[:, None, None] * known.readings[:, :, None]]
        if time.size > 1:
            whole = 1.2 * np.ptp(time)
            highest = min(3.0 * band, 0.5 * (time.size - 1) / np.ptp(time), 0.5 * MOST_WAVES / whole)
            rate = 2.0 * np.pi * np.arange(max(2, int(highest * whole) + 1)) / whole
            share = 2.0 / (whole * (1.0 + (rate / (2.0 * np.pi * band)) ** 6))
            share[0] *= 0.5
            size = edge * np.sqrt(2.0 * np.pi / pulses * speed[:, None] * share)[:, None]
            up, down = (
                _shifted(known.readings, speed, way * rate) * np.exp(1j * way * np.outer(time - time[0], rate))[:, None]
                for way in (1.0, -1.0)
            )
            moved += [0.5j * size * (up + down), 0.5 * size * (up - down)]
        turned = np.exp(-1j * np.angle(known.readings))[:, :, None] * np.concatenate(moved, axis=2)
        parts = (
            part.swapaxes(0, 1)
            for part in (turned.real / self.along[:, :, None], turned.imag / self.across[:, :, None])
        )
        return np.asarray(np.concatenate([part.reshape(-1, turned.shape[2]) for part in parts]))


def _shifted(readings: NDArray[np.complex128], speed: Floats, rate: Floats) -> NDArray[np.complex128]:
    """What a load of unchanged size gives that turns faster by so much (W,): of readings (S, C) a part of the run-up later.

    Parts reach from one turning point of the speed to the next, and no further. (S, C, W).
    """
    shifted = np.empty((*readings.shape, rate.size), np.complex128)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(speed)))) + 1
    for part in map(np.asarray, np.split(np.arange(speed.size), turns)):
        order = part[np.argsort(speed[part])]
        there = np.clip(speed[part, None] + rate, speed[order[0]], speed[order[-1]])
        for c, row in enumerate(readings[order].T):
            seen = np.interp(there, speed[order], row.real) + 1j * np.interp(there, speed[order], row.imag)
            shifted[part, c] = seen * (speed[part, None] / there) ** 2
    return shifted


def follows_speed(machine: Machine, known: Orders) -> bool:
    """Whether the response is followed along the measured speed; that of softening rubber is the steady one."""
    return known.course is not None and rubber_of(*rotor_of(machine, balls=False)) is None


def channel_response(machine: Machine, known: Orders, unbalance: Any, owner: str, **options: Any) -> Complexes:
    """Complex amplitudes (S, C) of the response to an unbalance, followed along the course of the speed where that is known.

    Raises
    ------
    QuestionError
        If a channel has no place, and the machine has several.
    """
    places: list[Any] = list(dict.fromkeys(known.places))
    if "" in places and (len(places) > 1 or len(machine.stations) > 1):
        raise QuestionError(
            f"{owner}: channel {known.places.index('') + 1} has no place; name the station at which it was measured"
        )
    speeds, back = np.unique(known.speeds, return_inverse=True)
    passed = None
    if known.course is not None and follows_speed(machine, known):  # a resonance is late when the speed changes
        options["time"], speeds = known.course
        passed = known.passed
    result = np.empty((known.speeds.size, len(known.places)), complex)
    stations = None if places == [""] else places
    for quantity in dict.fromkeys(known.quantities):
        kind_of_all: Any = quantity
        seen: xr.Dataset = response(machine, speeds, stations, unbalance, quantity=kind_of_all, **options)
        both = [(seen[f"{k}_real"] + 1j * seen[f"{k}_imag"]).values for k in "xy"]
        x, y = (one[back] if passed is None else passed @ one for one in both)
        for c, (place, way, kind) in enumerate(zip(known.places, known.directions, known.quantities, strict=True)):
            if kind == quantity:
                s = places.index(place)
                result[:, c] = x[:, s] * np.cos(way) + y[:, s] * np.sin(way)
    return result

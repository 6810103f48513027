"""A run and a measurement of the same machine, side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, RangeWarning, unwarned
from autobalancer.measurement.pairs import (
    Pair,
    is_film,
    is_orders,
    measure_rows,
    measure_table,
    order_curves,
    pairs,
    place_doubt,
    scale_doubt,
    sensor_of,
)
from autobalancer.measurement.signals import Channel, signals
from autobalancer.measurement.tacho import rotor_angle
from autobalancer.measurement.tracking import orders
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.time_series import of_a_run

DIFFERENT = 0.02  # relative difference of speeds at one time, above which a note says so


@of_a_run(called="compare")
def overlay(run: xr.Dataset, measured: xr.Dataset, *, seed: int = 0, **tacho: Any) -> Answer:
    """Put a measurement beside a run: the same curves and the same measures of both.

    Times of the measurement are those of the run; a photograph is from its end. Each channel is compared with what its sensor
    would have seen of the run, ball angles with those of the run, whole turns not counted and balls of equal look matched. With a
    tacho the first order of every channel is tracked in both by the same method. So are orders that were tracked before: at their
    times, or where they are over ``speed`` when the run has that speed for the last time. Measures are those of
    :func:`autobalancer.run_measures` for which the measurement suffices, of orders the greatest amplitudes; those of the run are
    computed from the same samples with the noise of the sensors, so that noise changes both alike.

    Parameters
    ----------
    run
        From :func:`autobalancer.simulate`, with samples.
    measured
        Signals, orders, or ball angles of a film or a photograph.
    seed
        Of the noise with which the run is measured.
    **tacho
        Keywords of :func:`autobalancer.measure.rotor_angle`.

    Returns
    -------
    Answer
        Over ``channel`` and ``time``: ``measured``, ``simulated``, ``deviation`` (one standard deviation of the measurement; SI);
        over ``channel`` ``place`` (of the run, with which it is compared), ``rms_away`` and ``rms_expected`` from that
        deviation; over ``measure`` ``measured_value``, ``simulated_value`` and ``value_deviation``; of orders and with a
        tacho ``order_amplitude`` and ``order_phase`` of both.
        ``attrs["notes"]`` say which measures there cannot be, and what looks wrong.

    Raises
    ------
    QuestionError
        If times do not meet, a place is not in the run, or it kept too few samples.
    """
    if "time" not in run or not run.sizes.get("time") or "rotor_angle" not in run:
        raise QuestionError("compare: the run kept no samples over time; run it with save=Samples(count)")
    if is_orders(measured):
        if tacho:
            raise QuestionError(f"compare: orders have their speed already; leave out {', '.join(tacho)}")
        return _titled(run, *order_curves(run, measured, seed))
    part = _together(run, _at_the_end(run, measured))
    result = pairs(run, part)
    rows, notes = measure_rows(run, part, result, seed, _turned(part, tacho))
    sensors = [] if is_film(part) else [sensor_of(part[pair.measured.name]) for pair in result]
    where = place_doubt(run, sensors, [pair.measured.name for pair in result][: len(sensors)])
    notes = [*filter(None, [where, *map(scale_doubt, result)]), *notes]
    ordered, more = _orders(run, part, result, tacho)
    data = _curves(run, part, result).merge(ordered).merge(measure_table(rows))
    return _titled(run, data, [*notes, *more])


def _together(run: xr.Dataset, measured: xr.Dataset) -> xr.Dataset:
    """The part of a measurement within the time of a run.

    Raises
    ------
    QuestionError
        If there are fewer than two samples of it, of a film or a photograph none.
    """
    t, known = measured["time"].values, run["time"].values
    inside = (t >= known[0] - 1e-9) & (t <= known[-1] + 1e-9)
    if inside.sum() < (1 if is_film(measured) else 2):
        raise QuestionError(
            f"the measurement is from {t[0]:.6g} s to {t[-1]:.6g} s, the run from {known[0]:.6g} s to {known[-1]:.6g} s; "
            "they have no time in common"
        )
    return measured.isel(time=inside)


def _at_the_end(run: xr.Dataset, measured: xr.Dataset) -> xr.Dataset:
    """A photograph, whose ball angles have no time, as a film of one picture at the end of the run; else as it is."""
    if "ball_angle" not in measured or set(measured["ball_angle"].dims) != {"ball"}:
        return measured
    kept = measured[[name for name in ("ball_angle", "ball_angle_deviation") if name in measured]]
    return kept.expand_dims(time=run["time"].values[-1:])


def _titled(run: xr.Dataset, data: xr.Dataset, notes: list[str]) -> Answer:
    name = run.attrs.get("machine_name", "a machine")
    about = {"title": f"Run and measurement of {name}", "machine_name": name, "notes": notes}
    return Answer.of(data.assign_attrs(provenance() | about), "Overlay")


def _curves(run: xr.Dataset, part: xr.Dataset, pairs: list[Pair]) -> xr.Dataset:
    time = np.asarray(part["time"].values, np.float64)

    def table(values: list[Floats]) -> Floats:
        grid = np.full((len(pairs), time.size), np.nan)
        for row, pair, one in zip(grid, pairs, values, strict=True):
            row[np.searchsorted(time, pair.measured.time)] = one
        return grid

    both = ("channel", "time")
    away = [pair.shifted - pair.measured.values for pair in pairs]
    about = {"long_name": "one standard deviation of the measurement, SI"}
    entries: dict[str, Any] = {
        "measured": (both, table([pair.measured.values for pair in pairs]), {"long_name": "measured, SI"}),
        "simulated": (both, table([pair.shifted for pair in pairs]), {"long_name": "of the run, SI"}),
        "deviation": (both, table([pair.measured.deviation for pair in pairs]), about),
        "units": ("channel", np.array([pair.measured.unit for pair in pairs], dtype=object)),
        "rms_measured": ("channel", [_rms(p.measured.values - p.measured.values.mean()) for p in pairs]),
        "rms_away": ("channel", [_rms(one) for one in away]),
        "rms_expected": ("channel", [_rms(pair.measured.deviation) for pair in pairs]),
        "speed": ("time", np.interp(time, run["time"].values, run["speed"].values), {"units": "rad/s"}),
    }
    entries["place"] = "channel", np.array([pair.place for pair in pairs], dtype=object)
    names = np.array([pair.measured.name for pair in pairs], dtype=object)
    return xr.Dataset(entries, {"channel": names, "time": ("time", time, {"units": "s", "long_name": "time"})})


def _has_tacho(part: xr.Dataset) -> bool:
    return any(data_var.attrs.get("quantity") in ("tacho", "angle") for data_var in part.data_vars.values())


def _turned(part: xr.Dataset, tacho: dict[str, Any]) -> xr.Dataset | None:
    """The measured speed, if it was measured."""
    if is_film(part) or not _has_tacho(part):
        return None
    try:
        with unwarned(RangeWarning):  # it is said where orders are tracked
            return rotor_angle(part, **tacho)
    except QuestionError:
        return None


def _orders(
    run: xr.Dataset, part: xr.Dataset, pairs: list[Pair], tacho: dict[str, Any]
) -> tuple[xr.Dataset, list[str]]:
    """The first order of both; nothing without a tacho."""
    if not _has_tacho(part):
        return xr.Dataset(), [] if pairs[0].measured.unit == "rad" else ["no orders: the measurement has no tacho"]
    names = [pair.measured.name for pair in pairs]
    try:
        seen = orders(part, channels=names, **tacho).sel(order=1.0)
        time = np.asarray(part["time"].values, np.float64)
        angle = np.interp(time, run["time"].values, run["rotor_angle"].values)
        channels = {p.measured.name: Channel(p.simulated, str(part[p.measured.name].attrs["quantity"])) for p in pairs}
        known = orders(signals(time, {**channels, "rotor": Channel(angle, "angle")}), channels=names).sel(order=1.0)
    except QuestionError as reason:
        return xr.Dataset(), [f"no orders: {reason}"]
    inside = (seen["time"] >= known["time"].values[0]) & (seen["time"] <= known["time"].values[-1])
    seen = seen.isel(time=inside.values)
    at, speed = seen["time"].values, np.interp(seen["time"].values, known["time"].values, known["speed"].values)
    whirl = known["amplitude"].values * np.exp(1j * known["phase"].values)
    like = np.array([np.interp(at, known["time"].values, row) for row in whirl])
    notes = []
    off = float(np.abs(seen["speed"].values / speed - 1.0).max()) if at.size else 0.0
    if off > DIFFERENT:
        notes.append(
            f"the measured speed differs from that of the run by up to {100 * off:.3g} %; give the run its profile"
        )
    both = ("channel", "order_time")
    return xr.Dataset(
        {
            "order_amplitude": (both, seen["amplitude"].values),
            "order_amplitude_deviation": (both, seen["amplitude_deviation"].values),
            "order_phase": (both, seen["phase"].values),
            "order_phase_deviation": (both, seen["phase_deviation"].values),
            "order_amplitude_simulated": (both, np.abs(like)),
            "order_phase_simulated": (both, np.angle(like)),
            "order_speed": ("order_time", seen["speed"].values, {"units": "rad/s"}),
            "order_speed_simulated": ("order_time", speed, {"units": "rad/s"}),
        },
        {"order_time": at},
    ), notes


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")

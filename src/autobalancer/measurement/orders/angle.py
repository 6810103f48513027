"""Angle and speed of the rotor from a tacho, an encoder or a measured speed."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.measurement.orders.pulses import crossings, odd_remarks, repaired
from autobalancer.measurement.orders.smooth_angle import smooth_angle
from autobalancer.results.labels import LABELS
from autobalancer.results.signals.signals import BLOCK, LONG, Samples, Signals, pieces
from autobalancer.units import argument

Floats = NDArray[np.float64]
Held = Floats | Samples
LIKELY = ("puls", "phasor", "tach", "drehzahl", "trig", "once", "marke")  # in names of channels that may be a tacho


def with_rotor_angle(signals: xr.Dataset, **tacho: Any) -> xr.Dataset:
    """The signals with ``rotor_angle``, ``speed`` and ``rotor_angle_deviation``: of a tacho, or of an angle that was measured.

    A measured angle is taken as exact, its slope is the speed; raises as :func:`rotor_angle`.
    """
    if "rotor_angle" not in signals:
        return rotor_angle(signals, **tacho)
    if {"speed", "rotor_angle_deviation"} <= set(signals):
        return signals
    angle, time = signals["rotor_angle"].values, signals["time"].values
    missing = {"speed": np.gradient(angle, time), "rotor_angle_deviation": np.zeros_like(angle)}
    units = {"speed": "rad/s", "rotor_angle_deviation": "rad"}
    return signals.assign(
        {
            name: ("time", values, {"units": units[name], "quantity": "speed" if name == "speed" else "angle"})
            for name, values in missing.items()
            if name not in signals
        }
    )


def rotor_angle(
    signals: xr.Dataset,
    tacho: str = "",
    *,
    pulses: int = 1,
    threshold: float | None = None,
    hysteresis: float | None = None,
    edge: str = "rising",
    tacho_angle: float | str | None = None,
    index: str = "",
    repair: bool = True,
) -> xr.Dataset:
    """Find angle and speed of the rotor, and add them to the signals.

    The instants of the pulses are those at which the signal crosses its threshold. A spline of degree five with little jerk
    is fitted to the angle over the time; cross-validation says how much it is smoothed, so that it follows a rotor that
    changes its speed quickly, and not the jitter of the pulses.

    Parameters
    ----------
    signals
        From ``ab.measure.load_signals`` or ``ab.measure.signals``.
    tacho
        Name of the channel; by default the only one with the quantity tacho. A channel with the quantity angle is taken as
        it is.
    pulses
        Marks on a turn, evenly spaced.
    threshold, hysteresis
        In the unit of the channel; by default the middle of the pulses and three tenths of their height.
    edge
        Which edge of a pulse counts: rising or falling.
    tacho_angle
        Direction in which the sensor looks at the shaft, from the x axis (rad, or a text such as "90 deg"); the zero mark is
        there when its pulse comes. By default the direction of its channel, else the x axis.
    index
        Channel with one pulse a turn, that of the zero mark, beside a tacho of several pulses. Without it none of these is
        known to be the zero mark: phases are then known up to multiples of a turn over the number of pulses, and a warning
        says so.
    repair
        Count on where a pulse is missing or comes twice; a warning says when. Otherwise such a signal is refused.

    Returns
    -------
    xarray.Dataset
        The signals between the first and the last pulse with ``rotor_angle`` (rad, from the x axis to the mark), ``speed``
        (rad/s) and ``rotor_angle_deviation`` (rad, one standard deviation) over ``time``. ``attrs``: ``pulse_jitter`` (s,
        one standard deviation), ``missing_pulses`` and ``extra_pulses`` (s).

    Raises
    ------
    QuestionError
        If there is no such channel, it has no pulses or too few, or more than a tenth of them is odd.
    """
    name = _chosen(signals, tacho)
    if signals[name].attrs["quantity"] == "angle":
        return _measured_angle(signals, name)
    if isinstance(pulses, bool) or not isinstance(pulses, (int, np.integer)) or pulses < 1:
        raise QuestionError(f"pulses: given {pulses!r}; must be a whole number from 1")
    if edge not in ("rising", "falling"):
        raise QuestionError(f"edge: given {edge!r}; must be rising or falling")
    t = signals["time"].values
    found = repaired(
        crossings(t, signals[name], threshold=threshold, hysteresis=hysteresis, falling=edge == "falling"),
        repair=repair,
    )
    smooth = smooth_angle(found.times, np.asarray(2.0 * math.pi / pulses * found.counts, np.float64))
    first, last = np.searchsorted(t, found.times[0]), np.searchsorted(t, found.times[-1], side="right")
    inside = signals.isel(time=slice(int(first), int(last)))
    time = inside["time"].values
    if time.size < 8:
        raise QuestionError("tacho: fewer than 8 samples between the first and the last pulse")
    turning = smooth.spline.derivative()
    speed = _over(time, turning)
    for _, part in pieces(speed):
        if not (part > 0.0).all():
            _, i = min((float(one.min()), begin + int(one.argmin())) for begin, one in pieces(speed))
            raise QuestionError(
                f"tacho: the speed is not above zero at {time[i]:.6g} s; use a piece in which the rotor turns"
            )
    remarks = [*odd_remarks(found), *_left_out(t, found.times)]
    zero = 0.0
    if index:
        zero = _at_index(signals, index, smooth.spline, time)
    elif pulses > 1:
        remarks.append(
            f"tacho: none of its {pulses} pulses a turn is known to be the zero mark; phases are known up to multiples of "
            f"{360.0 / pulses:.4g} deg. Name a channel with one pulse a turn as index"
        )
    for text in remarks:
        warn(text, RangeWarning)
    attrs = {
        "pulse_jitter": smooth.jitter,
        "missing_pulses": found.missing.tolist(),
        "extra_pulses": found.extra.tolist(),
    }
    start = _looks(signals[name]) if tacho_angle is None else argument("tacho_angle", tacho_angle, "rad")
    turned = _over(time, lambda at: start + (smooth.spline(at) - zero))
    return _with(inside, turned, speed, _over(time, smooth.deviation), remarks, attrs)


def _over(time: Floats, function: Callable[[Floats], Floats]) -> Floats | Samples:
    """A function of the time; of a long record its values are computed when they are asked for."""

    def piece(first: int, end: int) -> Floats:
        parts = [function(time[at : min(at + BLOCK, end)]) for at in range(first, max(end, first + 1), BLOCK)]
        return np.asarray(np.concatenate(parts), np.float64)

    return Samples(time.size, piece) if time.size > LONG else piece(0, time.size)


def _chosen(signals: xr.Dataset, tacho: str) -> str:
    if not isinstance(signals, Signals):
        raise QuestionError("rotor_angle: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    if tacho and tacho in signals:
        return tacho
    by = {
        word: [str(n) for n, v in signals.data_vars.items() if v.attrs.get("quantity") == word]
        for word in ("tacho", "angle")
    }
    there = ", ".join(map(str, signals.data_vars))
    if tacho:
        raise QuestionError(f"tacho: no channel {tacho!r}; there are {there}")
    found = by["tacho"] or by["angle"]
    if len(found) != 1:
        what = f"several, {', '.join(found)}; choose one by tacho='{found[0]}'" if found else f"none; there are {there}"
        likely = next((str(n) for n, v in signals.data_vars.items() if _pulses(str(n), v)), "")
        if likely and not found:
            what += f". If {likely!r} is the tacho, say tacho='{likely}' (--tacho {shlex.quote(likely)})"
        raise QuestionError(f"tacho: of the channels with the quantity tacho or angle there is {what}")
    return found[0]


def _pulses(name: str, channel: xr.DataArray) -> bool:
    """Whether a channel is called like one with the pulses of a rotor, and may be one."""
    return channel.attrs.get("quantity") == "voltage" and any(word in name.lower() for word in LIKELY)


def _left_out(t: Floats, pulses: Floats) -> list[str]:
    """What of a record lies before the first or after the last pulse, where that is more than turns in which none was due."""
    ends = (
        (pulses[0] - t[0], pulses[1] - pulses[0], f"first pulse comes at {pulses[0]:.4g} s", "before"),
        (t[-1] - pulses[-1], pulses[-1] - pulses[-2], f"last pulse comes at {pulses[-1]:.4g} s", "after"),
    )
    whole = t[-1] - t[0]
    return [
        f"tacho: its {words}; the {gap:.4g} s {side} it, {100.0 * gap / whole:.3g} % of the record, are left out"
        for gap, turn, words, side in ends
        if gap > 2.0 * turn
    ]


def _at_index(signals: xr.Dataset, index: str, spline: BSpline, time: Floats) -> float:
    """Mean angle, within a turn, at which the pulses of the zero mark come, rad."""
    if index not in signals:
        raise QuestionError(f"index: no channel {index!r}; there are {', '.join(map(str, signals.data_vars))}")
    instants = crossings(signals["time"].values, signals[index])
    instants = instants[(instants >= time[0]) & (instants <= time[-1])]
    if not instants.size:
        raise QuestionError(f"index: no pulse of {index!r} while the tacho turns")
    places = np.exp(1j * spline(instants))
    if abs(places.mean()) < 0.9:
        raise QuestionError(
            f"index: the pulses of {index!r} come at many angles; is the number of pulses of the tacho right?"
        )
    return float(np.angle(places.mean()))


def _looks(channel: xr.DataArray) -> float:
    """Direction of a sensor from the x axis, rad; zero where it is not known."""
    direction = channel.attrs.get("direction", "")
    return 0.5 * math.pi * (direction == "y") if isinstance(direction, str) else math.radians(float(direction))


def _measured_angle(signals: xr.Dataset, name: str) -> xr.Dataset:
    """An angle that was measured itself, wrapped or not."""
    t, angle = signals["time"].values, np.unwrap(signals[name].values)
    speed = np.gradient(angle, t)
    if not (speed > 0.0).all():
        raise QuestionError(
            f"{name}: the angle does not grow at {t[int(np.argmin(speed))]:.6g} s; it must, in every step"
        )
    sure = float(signals[name].attrs.get("uncertainty", 0.0))
    return _with(signals.drop_vars([name]), angle, speed, np.full(t.size, sure), [], {})


def _with(
    signals: xr.Dataset, angle: Held, speed: Held, deviation: Held, remarks: list[str], attrs: dict[str, object]
) -> xr.Dataset:
    entries = {
        "rotor_angle": (angle, LABELS["rotor_angle"].long_name, "rad", "angle"),
        "speed": (speed, LABELS["speed"].long_name, "rad/s", "speed"),
        "rotor_angle_deviation": (deviation, "standard deviation of the rotor angle", "rad", "angle"),
    }
    added = {
        name: (
            "time",
            values.variable() if isinstance(values, Samples) else values,
            {"long_name": text, "units": unit, "quantity": quantity},
        )
        for name, (values, text, unit, quantity) in entries.items()
    }
    doubts = [text for text in (str(signals.attrs.get("warnings", "")), *remarks) if text]
    return Signals.of(signals.assign(added).assign_attrs(attrs | {"warnings": "\n".join(doubts)}))

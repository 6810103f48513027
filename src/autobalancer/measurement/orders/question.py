"""What a vibration does in each order of the speed: the public question."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.angle import rotor_angle
from autobalancer.measurement.orders.fitted import Tracked, fitted_orders
from autobalancer.measurement.orders.runout import subtracted
from autobalancer.measurement.orders.vold_kalman import bias_of, filtered_orders
from autobalancer.measurement.signals.unit_words import hertz_argument
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.orders import Orders
from autobalancer.results.signals.signals import Signals

Floats = NDArray[np.float64]
Method = Literal["fit", "vold-kalman"]
WINDOW = 4.0  # revolutions
A_TURN, MOST = 4, 4000  # points of a turn, and in all
VIBRATIONS = ("displacement", "velocity", "acceleration", "force", "torque", "voltage", "pressure")


def orders(
    signals: xr.Dataset,
    orders: float | Sequence[float] = (1.0,),
    *,
    channels: str | Sequence[str] | None = None,
    method: Method = "fit",
    revolutions: float = WINDOW,
    bandwidth: float | str | None = None,
    slow_roll: Any = None,
    **tacho: Any,
) -> xr.Dataset:
    """Amplitude and phase of orders of the rotor speed, over the time of a run-up or run-down.

    The vibration is the sum of amplitude times cos(order times rotor angle + phase): the phase is the lead of the vibration
    over the zero mark, which is at the x axis when the rotor angle is zero.

    Parameters
    ----------
    signals
        From ``ab.measure.load_signals`` with a tacho, or from ``ab.measure.rotor_angle``.
    orders
        One or several, such as 1, 2 or 0.5; they are separated from one another.
    channels
        Names; by default all vibrations.
    method
        ``"fit"``: in a window of some revolutions, weighted by Hann, the complex amplitudes are fitted as polynomials of
        second degree of the rotor angle, so that a resonance is not flattened. ``"vold-kalman"``: smooth amplitudes at every
        sample, with a bandwidth.
    revolutions
        Width of the window of the fit.
    bandwidth
        Of the Vold–Kalman filter between the points at -3 dB, Hz; by default a tenth of the lowest rotation frequency, at
        least 1 Hz.
    slow_roll
        Interval of time (s, a pair or a text such as ``"0:1.5 s"``) in which the rotor turns slowly: what the sensors show
        there at speed zero is run-out of the shaft, and is subtracted. Or orders that were measured at slow roll.
    **tacho
        Keywords of :func:`~autobalancer.measure.rotor_angle`, where the signals have no angle yet.

    Returns
    -------
    xarray.Dataset
        Over (order, channel, time): ``amplitude`` (SI), ``phase`` (rad), ``amplitude_deviation`` and ``phase_deviation``
        (one standard deviation, from what the orders leave of the signal and from the angle), ``bias`` (SI; what the window
        or the filter probably takes away). Over time: ``speed``; over channel: ``units``, ``quantity``, ``place``,
        ``direction``.

    Raises
    ------
    QuestionError
        If there is no tacho, an order is not above zero or beyond half of the sampling rate, or the window is longer than
        the signals.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("orders: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    if "rotor_angle" not in signals:
        signals = rotor_angle(signals, **tacho)
    elif tacho:
        raise QuestionError(f"orders: the signals have their angle already; leave out {', '.join(tacho)}")
    asked = _Asked(_orders(orders, signals), vibrations(signals, channels), method, revolutions)
    if method == "fit":
        at, tracked, bias, how = _by_fit(signals, asked)
    elif method == "vold-kalman":
        at, tracked, bias, how = _by_filter(signals, asked, bandwidth)
    else:
        raise QuestionError(f"method: given {method!r}; must be 'fit' or 'vold-kalman'")
    found = _dataset(signals, asked, at, tracked, bias, how)
    return found if slow_roll is None else subtracted(found, slow_roll)


@dataclass(frozen=True, eq=False)
class _Asked:
    orders: Floats
    channels: list[str]
    method: str
    revolutions: float


def _by_fit(signals: xr.Dataset, asked: _Asked) -> tuple[Floats, Tracked, Floats, dict[str, Any]]:
    angle, values = signals["rotor_angle"].values, _values(signals, asked)
    half, turns = math.pi * asked.revolutions, float(np.ptp(angle)) / (2.0 * math.pi)
    least = 1.5 / min(1.0, float(asked.orders.min()))
    if not least <= asked.revolutions < turns:
        raise QuestionError(
            f"revolutions: given {asked.revolutions:g}; must be from {least:g} to less than the {turns:.1f} that were measured"
        )
    step = max(2.0 * math.pi / A_TURN, (float(np.ptp(angle)) - 2.0 * half) / MOST)
    centers = np.arange(angle[0] + half, angle[-1] - half, step)
    tracked = fitted_orders(angle, values, asked.orders, centers, asked.revolutions)
    narrow = fitted_orders(angle, values, asked.orders, centers, asked.revolutions / math.sqrt(2.0))
    bias = 4.0 / 3.0 * np.abs(tracked.amplitude - narrow.amplitude)  # of fourth order in the width
    text = f"local fit of second degree over {asked.revolutions:g} revolutions"
    how = {"method": text, "window_revolutions": asked.revolutions}
    return np.interp(centers, angle, signals["time"].values), tracked, np.asarray(bias), how


def _by_filter(
    signals: xr.Dataset, asked: _Asked, bandwidth: float | str | None
) -> tuple[Floats, Tracked, Floats, dict[str, Any]]:
    speed, rate = signals["speed"].values, float(signals.attrs["sampling_rate"])
    lowest = float(speed.min() * asked.orders.min()) / (2.0 * math.pi)
    width = max(1.0, 0.1 * lowest) if bandwidth is None else hertz_argument("bandwidth", bandwidth)
    if width > 0.2 * rate:
        raise QuestionError(
            f"bandwidth: given {width:g} Hz; must be below a fifth of the sampling rate, {0.2 * rate:.4g} Hz"
        )
    tracked = filtered_orders(signals["rotor_angle"].values, _values(signals, asked), asked.orders, width, rate)
    bias = bias_of(tracked.amplitude, width / rate)
    every = max(1, -(-speed.size // MOST))
    thin = Tracked(tracked.amplitude[..., ::every], tracked.deviation[..., ::every], tracked.residual[..., ::every])
    text = f"Vold-Kalman filter of two poles, bandwidth {width:.4g} Hz"
    return signals["time"].values[::every], thin, bias[..., ::every], {"method": text, "bandwidth": width}


def _values(signals: xr.Dataset, asked: _Asked) -> Floats:
    return np.array([signals[name].values for name in asked.channels])


def _orders(given: float | Sequence[float], signals: xr.Dataset) -> Floats:
    found = np.unique(np.atleast_1d(np.asarray(given, np.float64)))
    if not found.size or not np.isfinite(found).all() or found[0] <= 0.0:
        raise QuestionError(f"orders: given {given!r}; must be numbers above zero")
    highest = found[-1] * float(signals["speed"].max()) / (2.0 * math.pi)
    if highest > 0.5 * signals.attrs["sampling_rate"]:
        raise QuestionError(
            f"orders: order {found[-1]:g} reaches {highest:.4g} Hz, beyond half of the sampling rate of "
            f"{signals.attrs['sampling_rate']:.4g} Hz"
        )
    return found


def vibrations(signals: xr.Dataset, given: str | Sequence[str] | None) -> list[str]:
    """Names of the vibrations that were chosen, by default all.

    Raises
    ------
    QuestionError
        If there is none, or not the one that was named.
    """
    there = [str(name) for name, entry in signals.data_vars.items() if entry.attrs.get("quantity") in VIBRATIONS]
    if given is None:
        if not there:
            raise QuestionError(f"channels: none of {', '.join(map(str, signals.data_vars))} is a vibration")
        return there
    asked = [given] if isinstance(given, str) else list(given)
    for name in asked:
        if name not in there:
            raise QuestionError(f"channels: no vibration {name!r}; there are {', '.join(there)}")
    return asked


def _dataset(
    signals: xr.Dataset, asked: _Asked, at: Floats, tracked: Tracked, bias: Floats, how: dict[str, Any]
) -> Orders:
    t = signals["time"].values
    speed, sure = (np.interp(at, t, signals[name].values) for name in ("speed", "rotor_angle_deviation"))
    size = np.abs(tracked.amplitude)
    with np.errstate(divide="ignore", invalid="ignore"):
        phase_deviation = np.minimum(tracked.deviation / size, math.pi / math.sqrt(3.0))
    phase_deviation = np.hypot(phase_deviation, asked.orders[:, None, None] * sure)
    dims = ("order", "channel", "time")
    found = xr.Dataset(
        {
            "amplitude": (dims, size, {"long_name": "amplitude of the order"}),
            "phase": (dims, np.angle(tracked.amplitude), {"long_name": "lead over the zero mark", "units": "rad"}),
            "amplitude_deviation": (dims, tracked.deviation, {"long_name": "standard deviation of the amplitude"}),
            "phase_deviation": (
                dims,
                phase_deviation,
                {"long_name": "standard deviation of the phase", "units": "rad"},
            ),
            "bias": (dims, bias, {"long_name": "what the window or filter probably takes away"}),
            "residual": (dims[1:], tracked.residual, {"long_name": "standard deviation of what the orders leave"}),
        },
        {
            "order": ("order", asked.orders, {"long_name": "order of the rotor speed", "units": "1"}),
            "channel": ("channel", asked.channels, {"long_name": "channel"}),
            "time": ("time", at, {"long_name": "time", "units": "s"}),
            "speed": ("time", speed, {"long_name": "rotor speed", "units": "rad/s"}),
        },
    )
    for key in ("units", "quantity", "place", "direction"):
        words = [str(signals[name].attrs.get(key, "")) for name in asked.channels]
        found = found.assign_coords({key: ("channel", words)})
    head = {"title": f"orders of {signals.attrs.get('origin') or 'signals'}", **how}
    more = {"origin": signals.attrs.get("origin", ""), "warnings": signals.attrs.get("warnings", "")}
    return Orders.of(found.assign_attrs(head | more | provenance()))

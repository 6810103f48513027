"""Maps of the amplitude over the speed: order maps from signals at equal angles, spectrograms from signals at equal times."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import get_window

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.angle import with_rotor_angle
from autobalancer.measurement.orders.question import vibrations
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals

Floats = NDArray[np.float64]
MOST = 400  # windows
DENSEST = 4096  # samples of a turn


def order_map(
    signals: xr.Dataset,
    channel: str = "",
    *,
    over: Literal["order", "frequency"] = "order",
    highest: float | None = None,
    revolutions: float = 16.0,
    window: str = "hann",
    **tacho: Any,
) -> xr.Dataset:
    """Amplitude over the speed, and over the order or the frequency.

    Parameters
    ----------
    signals
        A run-up or run-down with a tacho.
    channel
        By default the first vibration.
    over
        ``"order"``: the signal is brought to equal angles of the rotor, so that an order is a line whatever the speed does
        within a window. ``"frequency"``: windows of equal time, in which a natural frequency is a line.
    highest
        Order or frequency (rad/s) up to which it goes; by default order 5, and five times the greatest speed.
    revolutions
        In a window; for the frequency at the mean speed. Orders are resolved to 1/revolutions.
    window
        Of the transform.
    **tacho
        Keywords of :func:`~autobalancer.measure.rotor_angle`, where the signals have no angle yet.

    Returns
    -------
    xarray.Dataset
        ``amplitude`` (SI, of a sinusoid) over (time, order) or (time, frequency), with ``speed`` over time;
        ``attrs["window"]`` and ``attrs["window_revolutions"]`` say what was asked for.

    Raises
    ------
    QuestionError
        If the signals are shorter than a window, or there is no tacho or channel.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("order_map: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    if over not in ("order", "frequency"):
        raise QuestionError(f"over: given {over!r}; must be 'order' or 'frequency'")
    signals = with_rotor_angle(signals, **tacho)
    name = vibrations(signals, channel or None)[0]
    turns = float(np.ptp(signals["rotor_angle"].values)) / (2.0 * math.pi)
    if not 1.0 <= revolutions < turns:
        raise QuestionError(
            f"revolutions: given {revolutions:g}; must be from 1 to less than the {turns:.1f} that were measured"
        )
    if over == "order":
        along, axis, amplitude = _orders(signals, name, highest or 5.0, revolutions, window)
        unit, text = "1", "order of the rotor speed"
    else:
        top = highest or 5.0 * float(signals["speed"].max())
        along, axis, amplitude = _frequencies(signals, name, top, revolutions, window)
        unit, text = "rad/s", "frequency"
    time, speed = signals["time"].values, signals["speed"].values
    found = xr.Dataset(
        {
            "amplitude": (
                ("time", over),
                amplitude,
                {"long_name": f"amplitude of {name}", "units": signals[name].attrs["units"]},
            )
        },
        {
            "time": ("time", along, {"long_name": "time", "units": "s"}),
            over: (over, axis, {"long_name": text, "units": unit}),
            "speed": ("time", np.interp(along, time, speed), {"long_name": "rotor speed", "units": "rad/s"}),
        },
        {
            "title": f"map of {name} of {signals.attrs.get('origin') or 'signals'}",
            "channel": name,
            "window": window,
            "window_revolutions": float(revolutions),
            **provenance(),
        },
    )
    return Labeled.of(found)


def at_equal_angles(signals: xr.Dataset, name: str, per_turn: int) -> tuple[Floats, Floats, Floats]:
    """Angles (rad), instants (s) and values of a channel at equal angles of the rotor, by splines of degree five."""
    time, angle = signals["time"].values, signals["rotor_angle"].values
    step = 2.0 * math.pi / per_turn
    equal = step * np.arange(math.ceil(angle[0] / step), math.floor(angle[-1] / step) + 1)
    instants = np.clip(make_interp_spline(angle, time, k=3)(equal), time[0], time[-1])
    values = make_interp_spline(time, signals[name].values, k=5)(instants)
    return equal, np.asarray(instants, np.float64), np.asarray(values, np.float64)


def _orders(
    signals: xr.Dataset, name: str, highest: float, revolutions: float, window: str
) -> tuple[Floats, Floats, Floats]:
    """So many samples a turn that nothing that was sampled in time is folded."""
    slowest = float(signals["speed"].min()) / (2.0 * math.pi)
    per_turn = int(np.clip(math.ceil(signals.attrs["sampling_rate"] / slowest), 8 * highest, DENSEST))
    _, instants, values = at_equal_angles(signals, name, per_turn)
    length = round(revolutions * per_turn)
    middles, amplitude = _windows(values, length, window)
    order = np.arange(amplitude.shape[1]) / (length / per_turn)
    kept = order <= highest
    return instants[middles], order[kept], amplitude[:, kept]


def _frequencies(
    signals: xr.Dataset, name: str, highest: float, revolutions: float, window: str
) -> tuple[Floats, Floats, Floats]:
    rate = float(signals.attrs["sampling_rate"])
    length = round(revolutions * 2.0 * math.pi * rate / float(signals["speed"].mean()))
    if length >= signals.sizes["time"]:
        raise QuestionError(f"revolutions: a window of {length / rate:.3g} s is longer than the signals")
    middles, amplitude = _windows(signals[name].values, length, window)
    frequency = 2.0 * math.pi * rate * np.arange(amplitude.shape[1]) / length
    kept = frequency <= highest
    return signals["time"].values[middles], frequency[kept], amplitude[:, kept]


def _windows(values: Floats, length: int, window: str) -> tuple[NDArray[np.int64], Floats]:
    """Middles of windows that overlap by seven eighths, or less where there would be too many, and their amplitudes."""
    step = max(1, length // 8, (values.size - length) // MOST)
    starts = np.arange(0, values.size - length + 1, step)
    weights = get_window(window, length)
    pieces = np.lib.stride_tricks.sliding_window_view(values, length)[starts]
    lines = np.fft.rfft((pieces - pieces.mean(axis=1, keepdims=True)) * weights, axis=1)
    return starts + length // 2, np.asarray(2.0 * np.abs(lines) / weights.sum(), np.float64)

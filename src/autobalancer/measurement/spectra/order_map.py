"""Maps of the amplitude over the speed: order maps from signals at equal angles, spectrograms from signals at equal times."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import get_window

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.angle import with_rotor_angle
from autobalancer.measurement.orders.question import vibrations
from autobalancer.patience import Progress, shows_progress, silent
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals, at_samples, extremes, places, together

Floats = NDArray[np.float64]
MOST = 400  # windows
DENSEST = 4096  # samples of a turn
MARGIN = 64  # samples beside a piece, beyond which a spline forgets where it began


@shows_progress
def order_map(
    signals: xr.Dataset,
    channel: str = "",
    *,
    over: Literal["order", "frequency"] = "order",
    highest: float | None = None,
    revolutions: float = 16.0,
    window: str = "hann",
    progress: Progress | Literal[False] | None = None,
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
    progress
        Called with (windows that are done, all of them). ``None`` shows a bar where a person is looking, ``False`` none.
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
    begin, end = (float(signals["rotor_angle"][k]) for k in (0, -1))
    turns = (end - begin) / (2.0 * math.pi)
    done = progress if callable(progress) else silent
    if not 1.0 <= revolutions < turns:
        raise QuestionError(
            f"revolutions: given {revolutions:g}; must be from 1 to less than the {turns:.1f} that were measured"
        )
    if over == "order":
        along, axis, amplitude = _orders(signals, name, highest or 5.0, (revolutions, window), done)
        unit, text = "1", "order of the rotor speed"
    else:
        top = highest or 5.0 * extremes(signals["speed"])[1]
        along, axis, amplitude = _frequencies(signals, name, top, (revolutions, window), done)
        unit, text = "rad/s", "frequency"
    time = signals["time"].values
    speed = at_samples(signals["speed"], (along - time[0]) * (time.size - 1) / (time[-1] - time[0]))
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
            "speed": ("time", speed, {"long_name": "rotor speed", "units": "rad/s"}),
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


def _orders(
    signals: xr.Dataset, name: str, highest: float, how: tuple[float, str], progress: Progress
) -> tuple[Floats, Floats, Floats]:
    """So many samples a turn that nothing that was sampled in time is folded, by splines of degree five."""
    revolutions, window = how
    angle, time, values = signals["rotor_angle"], signals["time"].values, signals[name]
    slowest = extremes(signals["speed"])[0] / (2.0 * math.pi)
    per_turn = int(np.clip(math.ceil(signals.attrs["sampling_rate"] / slowest), 8 * highest, DENSEST))
    step = 2.0 * math.pi / per_turn
    lowest, last = math.ceil(float(angle[0]) / step), math.floor(float(angle[-1]) / step)
    length = round(revolutions * per_turn)
    order = np.arange(length // 2 + 1) / (length / per_turn)
    kept = order <= highest
    starts = _starts(last + 1 - lowest, length)
    near = places(angle, step * (lowest + starts + np.array([[0], [length]])))
    instants = []

    def piece(first: int, end: int) -> Floats:
        equal = step * (lowest + np.arange(first, end))
        low, high = (int(ends[np.searchsorted(starts, k)]) for ends, k in ((near[0], first), (near[1], end - length)))
        part = slice(max(0, low - MARGIN), high + MARGIN)
        turned, t = angle[part].values, time[part]
        at = np.clip(make_interp_spline(turned, t, k=3)(equal), t[0], t[-1])
        middles = starts[(starts >= first) & (starts + length <= end)] + length // 2 - first
        instants.append(at[middles])
        return np.asarray(make_interp_spline(t, values[part].values, k=5)(at), np.float64)

    amplitude = _windows(piece, starts, length, window, kept, progress)
    return np.concatenate(instants), order[kept], amplitude


def _frequencies(
    signals: xr.Dataset, name: str, highest: float, how: tuple[float, str], progress: Progress
) -> tuple[Floats, Floats, Floats]:
    revolutions, window = how
    rate, time, values = float(signals.attrs["sampling_rate"]), signals["time"].values, signals[name]
    mean = float(signals["rotor_angle"][-1] - signals["rotor_angle"][0]) / float(time[-1] - time[0])
    length = round(revolutions * 2.0 * math.pi * rate / mean)
    if length >= signals.sizes["time"]:
        raise QuestionError(f"revolutions: a window of {length / rate:.3g} s is longer than the signals")
    frequency = 2.0 * math.pi * rate * np.arange(length // 2 + 1) / length
    kept = frequency <= highest
    starts = _starts(time.size, length)
    amplitude = _windows(lambda first, end: values[first:end].values, starts, length, window, kept, progress)
    return time[starts + length // 2], frequency[kept], amplitude


def _starts(size: int, length: int) -> NDArray[np.int64]:
    """Where windows begin that overlap by seven eighths, or less where there would be too many."""
    return np.arange(0, size - length + 1, max(1, length // 8, (size - length) // MOST))


def _windows(
    piece: Callable[[int, int], Floats],
    starts: NDArray[np.int64],
    length: int,
    window: str,
    kept: NDArray[np.bool_],
    progress: Progress,
) -> Floats:
    """Amplitudes in windows, those of the lines that are kept; the signal is asked for a block at a time."""
    weights, rows = get_window(window, length), []
    for group in together(starts, starts + length):
        first, end = int(starts[group][0]), int(starts[group][-1]) + length
        views = np.lib.stride_tricks.sliding_window_view(piece(first, end), length)[starts[group] - first]
        lines = np.fft.rfft((views - views.mean(axis=1, keepdims=True)) * weights, axis=1)[:, kept]
        rows.append(2.0 * np.abs(lines) / weights.sum())
        progress(group.stop, starts.size)
    return np.asarray(np.concatenate(rows), np.float64)

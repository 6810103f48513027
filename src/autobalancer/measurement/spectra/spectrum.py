"""Averaged spectra of measured signals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.optimize import brentq
from scipy.signal import get_window, welch
from scipy.special import gammaincinv

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.question import vibrations
from autobalancer.measurement.signals.unit_words import hertz_argument
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals
from autobalancer.results.signals.spectrum import Spectrum

Floats = NDArray[np.float64]
WINDOWS = ("hann", "flattop", "blackmanharris", "boxcar")
LINES = 400  # of a segment, by default
STEADY = 0.02  # share by which the speed may change for its orders to be named


def spectrum(
    signals: xr.Dataset,
    channels: str | Sequence[str] | None = None,
    *,
    window: str = "hann",
    resolution: float | str | None = None,
    natural: Sequence[float] = (),
) -> xr.Dataset:
    """Amplitudes over the frequency, averaged over segments that overlap by half, and the lines in them.

    Parameters
    ----------
    signals
        Measured at one speed; with the angle of the rotor (``ab.measure.rotor_angle``) or a tacho lines are named by their
        order.
    channels
        Names; by default all vibrations.
    window
        hann, flattop (amplitudes of lines within 0.1 %, wide), blackmanharris or boxcar.
    resolution
        Between the frequencies, Hz; by default four hundred lines up to half of the sampling rate.
    natural
        Natural frequencies (rad/s) by which lines may be named.

    Returns
    -------
    xarray.Dataset
        Over (channel, frequency): ``amplitude`` (SI, of a sinusoid) and ``density`` (mean square a hertz). Over ``line``:
        what stands at least four times above the noise about it: ``line_channel``, ``line_frequency`` (rad/s),
        ``line_amplitude``, each with ``..._deviation`` (one standard deviation, from that noise), ``line_name``.
        ``attrs``: ``window``, ``resolution`` and ``noise_bandwidth`` (Hz), ``averages``,
        ``density_deviation`` (one relative standard deviation of a density), ``speed`` (rad/s, nan where it is not known or not
        steady).

    Raises
    ------
    QuestionError
        If there is no such channel or window, or the signals are too short for the resolution.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("spectrum: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    if window not in WINDOWS:
        raise QuestionError(f"window: given {window!r}; must be one of {', '.join(WINDOWS)}")
    names = vibrations(signals, channels)
    rate, count = float(signals.attrs["sampling_rate"]), signals.sizes["time"]
    length = min(2 * LINES, count) if resolution is None else round(rate / hertz_argument("resolution", resolution))
    if not 16 <= length <= count:
        raise QuestionError(
            f"resolution: {rate / length:.4g} Hz needs {length / rate:.4g} s in a segment; the signals have "
            f"{count / rate:.4g} s (from pulse to pulse of a tacho); give {1.0001 * rate / count:.4g} Hz or more"
        )
    weights = get_window(window, length)
    values = np.array([signals[name].values for name in names])
    frequency, power = welch(values, rate, weights, length, length // 2, detrend="linear", scaling="spectrum")
    amplitude = np.sqrt(2.0 * power)
    bandwidth = rate * float((weights**2).sum() / weights.sum() ** 2)
    averages = 1 + (count - length) // (length - length // 2)
    speed = steady_speed(signals)
    lines = [found_lines(2.0 * math.pi * frequency, row, weights, averages) for row in amplitude]
    how = {"window": window, "resolution": rate / length, "noise_bandwidth": bandwidth, "averages": averages}
    how |= {"density_deviation": 1.0 / math.sqrt(max(1.0, 0.95 * averages)), "speed": speed}
    return _dataset(signals, names, 2.0 * math.pi * frequency, amplitude, power / bandwidth, lines, how, natural)


def steady_speed(signals: xr.Dataset) -> float:
    """Mean speed (rad/s); nan where it is not known or changes by more than two percent."""
    if "speed" not in signals:
        return math.nan
    speed = signals["speed"].values
    return float(speed.mean()) if np.ptp(speed) <= STEADY * speed.mean() else math.nan


def _dataset(
    signals: xr.Dataset,
    names: list[str],
    frequency: Floats,
    amplitude: Floats,
    density: Floats,
    lines: list[Lines],
    how: dict[str, Any],
    natural: Sequence[float],
) -> Spectrum:
    dims = ("channel", "frequency")
    near = 2.0 * math.pi * how["resolution"]
    texts = [text for one in lines for text in named_lines(one.frequency, one.amplitude, how["speed"], natural, near)]
    every = Lines(*(np.concatenate(parts) for parts in zip(*lines, strict=True)))
    of = [name for name, one in zip(names, lines, strict=True) for _ in one.frequency]
    found = xr.Dataset(
        {
            "amplitude": (dims, amplitude, {"long_name": "amplitude of a sinusoid"}),
            "density": (dims, density, {"long_name": "mean square a hertz", "units_form": "{}^2/Hz"}),
            "line_channel": ("line", np.array(of, dtype=object), {"long_name": "channel of the line"}),
            "line_frequency": ("line", every.frequency, {"long_name": "frequency of the line", "units": "rad/s"}),
            "line_frequency_deviation": (
                "line",
                every.frequency_deviation,
                {"long_name": "standard deviation of the frequency of the line", "units": "rad/s"},
            ),
            "line_amplitude": ("line", every.amplitude, {"long_name": "amplitude of the line"}),
            "line_amplitude_deviation": (
                "line",
                every.amplitude_deviation,
                {"long_name": "standard deviation of the amplitude of the line"},
            ),
            "line_name": ("line", np.array(texts, dtype=object), {"long_name": "what it is"}),
        },
        {
            "channel": ("channel", names, {"long_name": "channel"}),
            "frequency": ("frequency", frequency, {"long_name": "frequency", "units": "rad/s"}),
            "units": ("channel", [str(signals[name].attrs.get("units", "")) for name in names]),
        },
        {"title": f"spectrum of {signals.attrs.get('origin') or 'signals'}", **how, **provenance()},
    )
    return Spectrum.of(found)


# Lines of a spectrum: where they are, how large, and what they may come from.


ABOVE = 4.0  # times the noise about it
ABOUT = 41  # frequencies from which the noise is judged
MOST = 12  # lines of a channel, the strongest
LEAST = 1e-3  # of the strongest
DRIFT = 2  # lowest frequencies, which lose what is subtracted as drift
SURE = 3.0  # deviations
SIDE_LINES = 5  # on each side of the speed


class Lines(NamedTuple):
    """Lines of one channel, ascending: frequency (rad/s) and amplitude, each with one standard deviation."""

    frequency: Floats
    frequency_deviation: Floats
    amplitude: Floats
    amplitude_deviation: Floats


def found_lines(frequency: Floats, amplitude: Floats, weights: Floats, averages: int = 1) -> Lines:
    """Lines that stand above the noise about them.

    The place between two frequencies is that at which the transform of the window has the ratio of the two amplitudes, and the
    amplitude is corrected by its height there, so that neither depends on where the line falls. Deviations follow from the
    noise about a line, with what neighbors and segments have in common; the
    leakage of a boxcar counts as noise.

    Parameters
    ----------
    frequency, amplitude
        Of the spectrum, rad/s, ascending from zero.
    weights
        Of the window.
    averages
        Of how many segments that overlap by half the spectrum is the mean.
    """
    noise = np.zeros_like(amplitude)
    noise[DRIFT:] = median_filter(amplitude[DRIFT:], ABOUT, mode="mirror")  # the lowest have lost their drift
    inner = amplitude[1:-1]
    peaks = 1 + np.flatnonzero((inner > amplitude[:-2]) & (inner >= amplitude[2:]) & (inner > ABOVE * noise[1:-1]))
    peaks = peaks[(peaks >= DRIFT) & (amplitude[peaks] > LEAST * amplitude.max())]
    peaks = np.sort(peaks[np.argsort(-amplitude[peaks])][:MOST])
    step = float(frequency[1] - frequency[0])
    median = math.sqrt(2.0 * float(gammaincinv(averages, 0.5)) / averages)  # of noise over its deviation
    found = []
    for k in peaks:
        side = 1 if amplitude[k + 1] >= amplitude[k - 1] else -1
        offset, to_offset, size, to_size = _line(float(amplitude[k]), float(amplitude[k + side]), weights)
        spread = float(noise[k]) / median
        unsure, size_unsure = (spread * _spread(parts, offset, weights, averages) for parts in (to_offset, to_size))
        if abs(amplitude[k + 1] - amplitude[k - 1]) < SURE * spread:  # the line may be on the other side
            unsure = math.hypot(unsure, 2.0 * offset)
        found.append((frequency[k] + side * offset * step, unsure * step, size, size_unsure))
    return Lines(*np.array(found, np.float64).reshape(-1, 4).T)


def _line(high: float, beside: float, weights: Floats) -> tuple[float, Floats, float, Floats]:
    """Offset of a line from the higher of two amplitudes, and its own, each with its derivatives by the two."""
    ratio = beside / high
    offset = _offset(ratio, weights)
    height, other = _height(offset, weights), _height(1.0 - offset, weights)
    slope = _slope(offset, weights)
    steep = -(_slope(1.0 - offset, weights) * height + other * slope) / height**2  # of the ratio, over the offset
    to_offset = np.array([-ratio, 1.0]) / (high * steep)
    return offset, to_offset, high / height, np.array([1.0 / height, 0.0]) - high * slope / height**2 * to_offset


def _spread(parts: Floats, offset: float, weights: Floats, averages: int) -> float:
    """Deviation of a sum of two neighboring amplitudes over that of one, in the mean of segments that overlap by half."""
    turns = 2j * math.pi * (np.arange(weights.size) / weights.size - 0.5)
    seen = weights * (parts[0] * np.exp(offset * turns) + parts[1] * np.exp((offset - 1.0) * turns))
    half = weights.size // 2
    power = float((np.abs(seen) ** 2).sum())
    shared = float((seen[half:] * seen[: weights.size - half].conj()).sum().real)
    mean = (power + 2.0 * (1.0 - 1.0 / averages) * shared) / averages
    return math.sqrt(mean / float((weights**2).sum()))


def _slope(offset: float, weights: Floats) -> float:
    """Of :func:`_height`."""
    return (_height(offset + 1e-4, weights) - _height(offset - 1e-4, weights)) / 2e-4


def _height(offset: float, weights: Floats) -> float:
    """Transform of the window so many frequencies beside its middle, over that at the middle; real, as seen from there."""
    turns = 2.0 * math.pi * offset * (np.arange(weights.size) / weights.size - 0.5)
    return float((weights * np.cos(turns)).sum() / weights.sum())


def _offset(ratio: float, weights: Floats) -> float:
    def miss(offset: float) -> float:
        return _height(1.0 - offset, weights) - ratio * _height(offset, weights)

    if miss(0.0) >= 0.0:
        return 0.0
    return float(brentq(miss, 0.0, 0.5, xtol=1e-9)) if miss(0.5) > 0.0 else 0.5


def named_lines(frequency: Floats, amplitude: Floats, speed: float, natural: Sequence[float], near: float) -> list[str]:
    """A name for each line.

    Multiples of the speed are orders. The strongest other line below the speed is called subsynchronous: in a balancer it is
    the speed of balls that do not turn with the rotor, or a whirl. Its multiples, its mirror at the speed, and other lines as far
    apart, which the beat of both makes, are named after it.

    Parameters
    ----------
    frequency, amplitude
        Of the lines; rad/s.
    speed
        Of the rotor, rad/s; nan if it is not known.
    natural
        Natural frequencies, rad/s.
    near
        So near are two frequencies the same, rad/s.
    """
    names = [_natural(f, natural, near) for f in frequency]
    if not math.isfinite(speed):
        return names
    orders = np.rint(frequency / speed)
    synchronous = (np.abs(frequency - orders * speed) <= near) & (orders > 0)
    slow = np.flatnonzero((frequency < speed - near) & ~synchronous)
    first = float(frequency[slow[np.argmax(amplitude[slow])]]) if slow.size else math.nan
    found = []
    for f, order, exact, text in zip(frequency, orders, synchronous, names, strict=True):
        if exact:
            own = f"order {order:g}"
        elif f == first:
            own = f"subsynchronous, {f / speed:.3f} of the speed: balls that turn at {f:.4g} rad/s, or a whirl"
        elif math.isfinite(first):
            own = _of_the_first(float(f), first, speed, near)
        else:
            own = f"{f / speed:.3f} of the speed"
        found.append("; ".join(part for part in (own, text) if part))
    return found


def _of_the_first(f: float, first: float, speed: float, near: float) -> str:
    multiple = round(f / first)
    if multiple > 1 and abs(f - multiple * first) <= near:
        return f"{multiple} times the subsynchronous line"
    if abs(f - (speed - first)) <= near:
        return "speed less that line"
    if abs(f - speed - first) <= near:
        return "speed and that line together"
    beat = speed - first
    away = round((f - speed) / beat)
    if abs(f - speed - away * beat) <= near and abs(away) <= SIDE_LINES:
        if away == 1:
            return "mirror of the subsynchronous line"
        return f"speed {'+' if away > 0 else '-'} {abs(away)} times its difference from that line"
    return f"{f / speed:.3f} of the speed"


def _natural(f: float, natural: Sequence[float], near: float) -> str:
    close = [value for value in natural if abs(value - f) <= 2.0 * near]
    return f"near the natural frequency {min(close, key=lambda v: abs(v - f)):.4g} rad/s" if close else ""

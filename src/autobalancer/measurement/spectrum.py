"""Averaged spectra of measured signals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.linalg import lstsq
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.optimize import least_squares
from scipy.signal import get_window, welch
from scipy.special import gammaincinv

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, RangeWarning, one_of, warn
from autobalancer.measurement.signals import hertz_argument
from autobalancer.measurement.tacho import with_rotor_angle
from autobalancer.measurement.tracking import vibrations
from autobalancer.progress import Progress, shows_progress, silent
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.results.labels import labeled
from autobalancer.results.signals import Signals, Spectrum, at_samples, extremes, merged_windows, places
from autobalancer.roots import root

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
    signals = Signals.given(signals, "spectrum")
    one_of("window", window, *WINDOWS)
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
    lines = [detect_lines(2.0 * math.pi * frequency, row, weights, averages) for row in amplitude]
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
    texts = [text for line in lines for text in line_names(line.frequency, line.amplitude, how["speed"], natural, near)]
    every = Lines(*(np.concatenate(parts) for parts in zip(*lines, strict=True)))
    of = [name for name, line in zip(names, lines, strict=True) for _ in line.frequency]
    dataset = labeled(
        {
            "amplitude": (dims, amplitude, "amplitude of a sinusoid"),
            "density": (dims, density, "mean square a hertz"),
            "line_channel": ("line", np.array(of, dtype=object), "channel of the line"),
            "line_name": ("line", np.array(texts, dtype=object), "what it is"),
            **{
                f"line_{name}{ending}": ("line", getattr(every, name + ending), f"{of}{name} of the line", *unit)
                for name, *unit in (("frequency", "rad/s"), ("amplitude",))
                for ending, of in (("", ""), ("_deviation", "standard deviation of the "))
            },
        },
        {
            "channel": ("channel", names, "channel"),
            "frequency": ("frequency", frequency, "frequency", "rad/s"),
            "units": ("channel", [str(signals[name].attrs.get("units", "")) for name in names]),
        },
        {"title": f"spectrum of {signals.attrs.get('origin') or 'signals'}", **how, **provenance()},
    )
    dataset["density"].attrs["units_form"] = "{}^2/Hz"
    return Spectrum.of(dataset)


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


def detect_lines(frequency: Floats, amplitude: Floats, weights: Floats, averages: int = 1) -> Lines:
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
    lines = []
    for k in peaks:
        side = 1 if amplitude[k + 1] >= amplitude[k - 1] else -1
        offset, to_offset, size, to_size = _line(float(amplitude[k]), float(amplitude[k + side]), weights)
        spread = float(noise[k]) / median
        unsure, size_unsure = (spread * _spread(parts, offset, weights, averages) for parts in (to_offset, to_size))
        if abs(amplitude[k + 1] - amplitude[k - 1]) < SURE * spread:  # the line may be on the other side
            unsure = math.hypot(unsure, 2.0 * offset)
        lines.append((frequency[k] + side * offset * step, unsure * step, size, size_unsure))
    return Lines(*np.array(lines, np.float64).reshape(-1, 4).T)


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
    return root(miss, 0.0, 0.5, xtol=1e-9) if miss(0.5) > 0.0 else 0.5


def line_names(frequency: Floats, amplitude: Floats, speed: float, natural: Sequence[float], near: float) -> list[str]:
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
    lines = []
    for f, order, exact, text in zip(frequency, orders, synchronous, names, strict=True):
        if exact:
            own = f"order {order:g}"
        elif f == first:
            own = f"subsynchronous, {f / speed:.3f} of the speed: balls that turn at {f:.4g} rad/s, or a whirl"
        elif math.isfinite(first):
            own = _of_the_first(float(f), first, speed, near)
        else:
            own = f"{f / speed:.3f} of the speed"
        lines.append("; ".join(part for part in (own, text) if part))
    return lines


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


# Maps of the amplitude over the speed: order maps from signals at equal angles, spectrograms from signals at equal
# times.


MOST_WINDOWS = 400  # windows
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
    signals = Signals.given(signals, "order_map")
    one_of("over", over, "order", "frequency")
    signals = with_rotor_angle(signals, **tacho)
    name = vibrations(signals, channel or None)[0]
    begin, end = (float(signals["rotor_angle"][k]) for k in (0, -1))
    turns = (end - begin) / (2.0 * math.pi)
    done = progress if callable(progress) else silent
    if not 1.0 <= revolutions < turns:
        raise QuestionError(
            f"revolutions: given {revolutions:g}; must be from 1 to less than the {turns:.1f} that were measured"
        )
    # over orders the windows have equal angles of the rotor, over frequencies equal times
    if over == "order":
        along, axis, amplitude = _orders(signals, name, highest or 5.0, (revolutions, window), done)
        unit, text = "1", "order of the rotor speed"
    else:
        top = highest or 5.0 * extremes(signals["speed"])[1]
        along, axis, amplitude = _frequencies(signals, name, top, (revolutions, window), done)
        unit, text = "rad/s", "frequency"
    time = signals["time"].values
    # the speed in the middle of each window
    speed = at_samples(signals["speed"], (along - time[0]) * (time.size - 1) / (time[-1] - time[0]))
    dataset = labeled(
        {"amplitude": (("time", over), amplitude, f"amplitude of {name}", signals[name].attrs["units"])},
        {
            "time": ("time", along, "time", "s"),
            over: (over, axis, text, unit),
            "speed": ("time", speed, "rotor speed", "rad/s"),
        },
        {
            "title": f"map of {name} of {signals.attrs.get('origin') or 'signals'}",
            "channel": name,
            "window": window,
            "window_revolutions": float(revolutions),
            **provenance(),
        },
    )
    return Labeled.of(dataset)


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
    return np.arange(0, size - length + 1, max(1, length // 8, (size - length) // MOST_WINDOWS))


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
    for group in merged_windows(starts, starts + length):
        first, end = int(starts[group][0]), int(starts[group][-1]) + length
        views = np.lib.stride_tricks.sliding_window_view(piece(first, end), length)[starts[group] - first]
        lines = np.fft.rfft((views - views.mean(axis=1, keepdims=True)) * weights, axis=1)[:, kept]
        rows.append(2.0 * np.abs(lines) / weights.sum())
        progress(group.stop, starts.size)
    return np.asarray(np.concatenate(rows), np.float64)


# Displacement, velocity and acceleration into one another, over the frequency.


POWERS = {"displacement": 0, "velocity": 1, "acceleration": 2}
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
ORDER = 4  # of the high pass


def converted(
    signals: xr.Dataset, to: str, *, corner: float | str | None = None, channels: str | Sequence[str] | None = None
) -> xr.Dataset:
    """Turn vibrations into displacement, velocity or acceleration.

    Each is divided by or multiplied with i w in the frequency domain. When it is divided, a high pass that does not shift
    the phase, (f/corner)^4 / (1 + (f/corner)^4), keeps drift and noise at low frequencies out; an amplitude at four times
    the corner is then too small by 0.4 %. Within some periods of the corner from both ends the result is not reliable.

    Parameters
    ----------
    signals
        From ``ab.measure.load_signals`` or ``ab.measure.signals``.
    to
        ``"displacement"``, ``"velocity"`` or ``"acceleration"``.
    corner
        Of the high pass, Hz, or a text; needed to make a velocity of an acceleration, or a displacement of either.
    channels
        Names; by default all vibrations of the other two quantities.

    Returns
    -------
    xarray.Dataset
        The signals with these channels changed; their attribute ``corner`` (Hz) says the high pass, zero if there is none.

    Raises
    ------
    QuestionError
        If there is no such channel, or the corner is missing or at less than four periods of it in the signals.
    """
    signals = Signals.given(signals, "converted")
    one_of("to", to, *POWERS)
    there = [str(n) for n, v in signals.data_vars.items() if v.attrs.get("quantity") in POWERS]
    requested = there if channels is None else [channels] if isinstance(channels, str) else list(channels)
    for name in requested:
        if name not in there:
            raise QuestionError(f"channels: no motion {name!r}; there are {', '.join(there) or 'none'}")
    low = 0.0 if corner is None else hertz_argument("corner", corner)
    length = signals.sizes["time"] / float(signals.attrs["sampling_rate"])
    spectrum = signals.copy()
    for name in requested:
        attrs = dict(signals[name].attrs)
        power = POWERS[to] - POWERS[str(attrs["quantity"])]
        if power == 0:
            continue
        if power < 0 and not low * length >= 4.0:
            what = f"given {low:g} Hz" if low else "missing"
            raise QuestionError(
                f"corner: {what}; to make a {to} of the {attrs['quantity']} {name!r} give one "
                f"of at least {4.0 / length:.3g} Hz, four periods in the signals"
            )
        values = _turned(signals[name].values, float(signals.attrs["sampling_rate"]), power, low if power < 0 else 0.0)
        attrs |= {"quantity": to, "units": UNITS[to], "corner": low if power < 0 else 0.0}
        attrs["long_name"] = str(attrs["long_name"]).replace(str(signals[name].attrs["quantity"]), to)
        attrs.pop("uncertainty", None)
        spectrum[name] = ("time", values, attrs)
    return Signals.of(spectrum)


def _turned(values: Floats, rate: float, power: int, corner: float) -> Floats:
    """Times (i w)^power; the ends are continued by their mirror images through the end points, so that there is no jump."""
    size = values.size
    line = np.linspace(values[0], values[-1], size)
    rest = values - line if power > 0 else values - values.mean()
    whole = np.concatenate([2.0 * rest[0] - rest[:0:-1], rest, 2.0 * rest[-1] - rest[-2::-1]])
    frequency = np.fft.rfftfreq(whole.size, 1.0 / rate)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = (2j * math.pi * frequency) ** power
        if corner:
            ratio = (frequency / corner) ** ORDER
            factor = factor * ratio / (1.0 + ratio)
    factor[0] = 0.0
    slope = (values[-1] - values[0]) * rate / (size - 1) if power == 1 else 0.0
    return np.asarray(
        np.fft.irfft(np.fft.rfft(whole) * factor, whole.size)[size - 1 : 2 * size - 1] + slope, np.float64
    )


# Frequency and decay rate of a motion that was left to itself.


PARTS, SPARE = (1, 2, 4), (1, 3)  # beginnings of the signal; poles more than asked, one for what the mean leaves
MOST_SAMPLES, WIDEST = 1200, 300  # samples and columns of the matrix of which the first guess is made
PLAIN = 5.0  # standard deviations of its amplitude by which a mode must stand out of the noise
BINS = 12  # on each side of a frequency, from which the noise there is judged
OUTLIER = 3.0  # from how many standard deviations of the scatter on a sample counts less


def decay_rate(
    time: Sequence[float] | Floats, signal: Sequence[float] | Floats, modes: int = 1, *, robust: bool = True
) -> xr.Dataset:
    """Fit decaying oscillations, offset + sum a e^(-d t) cos(w t + phase), to a measured decay.

    Parameters
    ----------
    time
        Of the samples, s, ascending at equal steps.
    signal
        Deflection, velocity or acceleration, in any unit.
    modes
        Number of oscillations.
    robust
        Whether outliers are given less weight (soft L1 loss).

    Returns
    -------
    xarray.Dataset
        Over ``mode``, the strongest first: ``frequency`` (w, damped, rad/s), ``decay_rate`` (d, 1/s), ``damping_ratio``,
        ``logarithmic_decrement`` (2 pi d / w), ``amplitude`` and ``phase`` (rad) at the first sample, and
        ``frequency_uncertainty``, ``decay_rate_uncertainty``, ``damping_ratio_uncertainty``, ``amplitude_uncertainty``,
        ``phase_uncertainty`` (standard deviations from the scatter); over ``time``: ``signal`` and ``fitted``. ``attrs``:
        ``offset``, ``scatter`` (standard deviation), ``warnings`` (modes that are hardly more than noise).

    Raises
    ------
    QuestionError
        If the samples are too few, not finite or not at equal steps, or hold no such oscillation.
    """
    t, y = np.asarray(time, np.float64), np.asarray(signal, np.float64)
    if isinstance(modes, bool) or not isinstance(modes, (int, np.integer)) or modes < 1:
        raise QuestionError(f"decay_rate: modes: given {modes!r}; must be a whole number from 1")
    least = 8 * modes + 8
    if t.ndim != 1 or t.shape != y.shape or t.size < least:
        raise QuestionError(
            f"decay_rate: given {t.size} times and {y.size} values; give the same number of both, at least {least}"
        )
    if not (np.isfinite(t).all() and np.isfinite(y).all()):
        raise QuestionError(
            "decay_rate: a time or value is not finite; leave such samples out at the ends, or fill them"
        )
    steps = np.diff(t)
    if not steps[0] > 0.0 or np.abs(steps - steps.mean()).max() > 1e-3 * steps.mean():
        raise QuestionError("decay_rate: times must ascend at equal steps; interpolate the signal first")
    clock = t - t[0]
    size = float(np.ptp(y))
    if size == 0.0:
        raise QuestionError("decay_rate: the signal is constant; there is nothing to fit")
    start = _poles(y / size, clock, modes)
    refined = _refined(y / size, clock, start, robust)
    return _decay_dataset(t, y, clock, size, refined)


def _poles(y: Floats, clock: Floats, modes: int) -> Complexes:
    """First guess: of pencils of the whole signal and of shorter beginnings, where fast decays are not yet noise, the best."""
    thin = max(1, int(np.ceil(y.size / MOST_SAMPLES)))
    while thin > 1 and _highest(y, clock) > 0.4 * np.pi / (thin * (clock[1] - clock[0])):
        thin //= 2
    y, step = y[::thin][:MOST_SAMPLES], thin * float(clock[1] - clock[0])
    y = y - y.mean()
    times = np.asarray(np.arange(y.size) * step, np.float64)
    whole = _pencil(y, step, modes, 1)
    pencils = [whole]
    if modes > 1 and whole.size:
        sizes = [(y.size // part, more) for part in PARTS for more in SPARE]
        pencils += [_pencil(y[:size], step, modes, more) for size, more in sizes if size > 16 * modes]
    guesses = [poles for poles in pencils if poles.size == modes]
    if not guesses:
        raise QuestionError(
            f"decay_rate: the signal holds {whole.size} oscillations, not {modes}; ask for fewer, or give a longer piece"
        )
    left = [np.linalg.norm(y - design @ lstsq(design, y)[0]) for design in (_design(times, guess) for guess in guesses)]
    return guesses[int(np.argmin(left))]


def _pencil(y: Floats, step: float, modes: int, more: int) -> Complexes:
    """The strongest poles of the upper half plane by the matrix pencil (Hua and Sarkar 1990), of so many ``more`` than asked."""
    columns = max(2 * modes + 2, min(y.size // 3, WIDEST))
    rows = np.lib.stride_tricks.sliding_window_view(y, columns)
    order = min(2 * modes + more, columns - 1)
    basis = np.linalg.eigh(rows.T @ rows)[1][:, -order:]
    roots = np.linalg.eigvals(np.linalg.pinv(basis[:-1]) @ basis[1:])
    poles = np.log(roots[np.abs(roots) > 0.0].astype(np.complex128)) / step
    poles = poles[(poles.imag > 1e-6 / (y.size * step)) & (poles.imag < 0.999 * np.pi / step)]
    poles = np.minimum(poles.real, -1e-9) + 1j * poles.imag
    design = _design(np.asarray(np.arange(y.size) * step, np.float64), poles)
    parts = lstsq(design, y)[0]
    strength = np.hypot(parts[1::2], parts[2::2])
    return np.asarray(poles[np.argsort(-strength)][:modes])


def _highest(y: Floats, clock: Floats) -> float:
    """The highest frequency with a tenth of the largest line, rad/s."""
    lines = np.abs(np.fft.rfft(y - y.mean()))
    frequency = 2.0 * np.pi * np.fft.rfftfreq(y.size, float(clock[1] - clock[0]))
    return float(frequency[np.flatnonzero(lines > 0.1 * lines.max())[-1]])


def _design(clock: Floats, poles: Complexes) -> Floats:
    """Offset, and two quadratures of each oscillation: (samples, 1 + 2 modes)."""
    waves = np.exp(np.outer(clock, poles))
    columns = [np.ones_like(clock)]
    for wave in waves.T:
        columns += [wave.real, -wave.imag]
    return np.array(columns).T


def _refined(y: Floats, clock: Floats, start: Complexes, robust: bool) -> tuple[Floats, Floats, Floats]:
    """Unknowns [offset, (real, imaginary amplitude), (decay, frequency)...], their deviations, the residuals."""
    count = start.size
    linear = lstsq(_design(clock, start), y)[0]
    begin = np.concatenate([linear, -start.real, start.imag])

    def poles(u: Floats) -> Complexes:
        return np.asarray(-u[1 + 2 * count : 1 + 3 * count] + 1j * u[1 + 3 * count :])

    def residuals(u: Floats) -> Floats:
        return np.asarray(_design(clock, poles(u)) @ u[: 1 + 2 * count] - y)

    def jacobian(u: Floats) -> Floats:
        design = _design(clock, poles(u))
        waves = (u[1 : 1 + 2 * count : 2] + 1j * u[2 : 2 + 2 * count : 2]) * np.exp(np.outer(clock, poles(u)))
        moving = clock[:, None] * waves
        return np.hstack([design, -moving.real, -moving.imag])

    how = {"jac": jacobian, "x_scale": "jac", "method": "trf", "xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
    result = least_squares(residuals, begin, max_nfev=200, **how)
    weight = np.ones_like(y)
    if robust:
        spread = 1.4826 * float(np.median(np.abs(result.fun - np.median(result.fun))))
        if spread > 1e-13:
            result = least_squares(residuals, result.x, loss="soft_l1", f_scale=OUTLIER * spread, max_nfev=200, **how)
            weight = (1.0 + (result.fun / (OUTLIER * spread)) ** 2) ** -0.5
    u = np.asarray(result.x)
    scaled = np.sqrt(weight)[:, None] * jacobian(u)
    variance = float((weight * result.fun**2).sum() / (y.size - u.size))
    norm = np.linalg.norm(scaled, axis=0)
    inverse = np.linalg.pinv((scaled / norm).T @ (scaled / norm))
    own = np.maximum(np.diag(inverse), 0.0) * variance
    takes = (inverse @ (scaled / norm).T) * np.sqrt(weight)  # of each sample, (unknown, sample)
    lines = np.abs(np.fft.rfft(takes, 2 * y.size, axis=1)) ** 2
    power = np.abs(np.fft.rfft(np.where(weight > 0.5, result.fun, 0.0) * np.hanning(y.size), 2 * y.size)) ** 2
    power /= float((np.hanning(y.size) ** 2).sum())
    near = 2 * BINS + 1  # lines of the spectrum, of which the mean is the noise there
    smooth = uniform_filter1d(power, near, mode="nearest")
    colored = (lines * smooth).sum(axis=1) / y.size
    return u, np.asarray(np.sqrt(np.maximum(own, colored)) / norm), np.asarray(result.fun)


def _decay_dataset(
    t: Floats, y: Floats, clock: Floats, size: float, found: tuple[Floats, Floats, Floats]
) -> xr.Dataset:
    u, spread, residuals = found
    count = (u.size - 1) // 4
    parts = u[1 : 1 + 2 * count : 2] + 1j * u[2 : 2 + 2 * count : 2]
    order = np.argsort(-np.abs(parts))
    decay, frequency = u[1 + 2 * count : 1 + 3 * count], u[1 + 3 * count :]
    decay_spread, frequency_spread = spread[1 + 2 * count : 1 + 3 * count], spread[1 + 3 * count :]
    of_parts = np.hypot(parts.real * spread[1 : 1 + 2 * count : 2], parts.imag * spread[2 : 2 + 2 * count : 2])
    of_parts = of_parts / np.maximum(np.abs(parts), 1e-300)
    natural = np.hypot(decay, frequency)
    of_ratio = np.hypot(decay_spread * frequency, decay * frequency_spread) * frequency / natural**3
    of_phase = np.minimum(of_parts / np.maximum(np.abs(parts), 1e-300), np.pi / np.sqrt(3.0))
    # of each quantity its values and their standard uncertainties
    entries = {
        "frequency": (frequency, frequency_spread, "natural frequency, damped", "rad/s"),
        "decay_rate": (decay, decay_spread, "decay rate", "1/s"),
        "damping_ratio": (decay / natural, of_ratio, "damping ratio", ""),
        "amplitude": (size * np.abs(parts), size * of_parts, "amplitude at the first sample", ""),
        "phase": (np.angle(parts), of_phase, "phase at the first sample", "rad"),
    }
    decrement = (2.0 * np.pi * decay / frequency)[order]
    about = "standard uncertainty of the {}"
    result = labeled(
        {key: ("mode", numbers[order], text, unit) for key, (numbers, _, text, unit) in entries.items()}
        | {"logarithmic_decrement": ("mode", decrement, "logarithmic decrement", "")}
        | {
            f"{key}_uncertainty": ("mode", unsure[order], about.format(key.replace("_", " ")), unit)
            for key, (_, unsure, _, unit) in entries.items()
        }
        | {"signal": ("time", y, "measured"), "fitted": ("time", y + size * residuals, "fitted")},
        {"mode": ("mode", np.arange(1, count + 1)), "time": ("time", t)},
    )
    result["time"].attrs["units"] = "s"
    doubts = _doubts(result)
    for text in doubts:
        warn(text, RangeWarning)
    result.attrs = {
        "title": "Decay of a free motion",
        **provenance(),
        "offset": float(size * u[0]),
        "scatter": float(size * np.sqrt((residuals**2).sum() / (y.size - u.size))),
        "warnings": "\n".join(doubts),
    }
    return Labeled.of(result)


def _doubts(dataset: xr.Dataset) -> list[str]:
    """Modes that are hardly more than noise."""
    size, sure = dataset["amplitude"].values, dataset["amplitude_uncertainty"].values
    return [
        f"mode {k + 1} at {dataset['frequency'].values[k] / (2.0 * np.pi):.4g} Hz is hardly more than noise: its amplitude is "
        "only "
        f"{size[k] / sure[k]:.2g} times its standard deviation; ask for fewer modes"
        for k in np.flatnonzero(size < PLAIN * sure)
    ]

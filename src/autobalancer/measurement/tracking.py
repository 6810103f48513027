"""What a vibration does in each order of the speed: the public question."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.ndimage import maximum_filter1d, median_filter
from scipy.signal import firwin, kaiserord, upfirdn

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, RangeWarning, one_of, warn
from autobalancer.measurement.noise_density import densities, independent
from autobalancer.measurement.signals import hertz_argument
from autobalancer.measurement.tacho import with_rotor_angle
from autobalancer.memory import refuse_beyond_memory
from autobalancer.progress import Progress, shows_progress, silent
from autobalancer.results.answers.answer import provenance
from autobalancer.results.labels import labeled
from autobalancer.results.signals import LONG, Orders, Signals, at_samples, extremes, merged_windows, places
from autobalancer.units.quantity import ends_argument

Method = Literal["fit", "vold-kalman"]
WINDOW = 4.0  # revolutions
A_TURN, MOST = 4, 4000  # points of a turn, and in all
REACH = 8.0  # periods in the window beside an order beyond which noise does not matter
FOLDED = 120.0  # dB by which frequencies are weaker that a slower rate folds
FLAT, WIDER = 0.03, 8  # bias over the greatest amplitude above which a note says so; bandwidths that are tried
GRID, FRAMES = 120, 6  # points at which the noise is judged; frames of the record, at least
MATTERS = 0.01  # of an amplitude: a line that makes it less uncertain has no note
BEYOND = 6.0  # twice the variance of its parts is the mean square of noise; so much is taken from that of a bias
# times the noise about it, a line; times the variance without, at so many points, a note
LINE, DOUBT, ROWS = 5.0, 4.0, 5
VIBRATIONS = ("displacement", "velocity", "acceleration", "force", "torque", "voltage", "pressure")


@shows_progress
def orders(
    signals: xr.Dataset,
    orders: float | Sequence[float] = (1.0,),
    *,
    channels: str | Sequence[str] | None = None,
    method: Method = "fit",
    revolutions: float = WINDOW,
    bandwidth: float | str | None = None,
    slow_roll: Any = None,
    progress: Progress | Literal[False] | None = None,
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
        least 1 Hz, and up to all of it where the amplitude changes so fast that its bias is above 1.5 % of the greatest.
    slow_roll
        Interval of time (s, a pair or a text such as ``"0:1.5 s"``) in which the rotor turns slowly: what the sensors show
        there at speed zero is run-out of the shaft, and is subtracted. Or orders that were measured at slow roll.
    progress
        Called with (windows that are done, all of them). ``None`` shows a bar where a person is looking, ``False`` none.
    **tacho
        Keywords of :func:`~autobalancer.measure.rotor_angle`, where the signals have no angle yet.

    Returns
    -------
    xarray.Dataset
        Over (order, channel, time): ``amplitude`` (SI), ``phase`` (rad), ``amplitude_deviation`` and ``phase_deviation``
        (one standard deviation, from the noise near the orders and from the angle), ``bias`` (SI; what the window or the
        filter probably takes away). Over time: ``speed``; over channel: ``units``, ``quantity``, ``place``,
        ``direction``.

    Raises
    ------
    QuestionError
        If there is no tacho, an order is not above zero or beyond half of the sampling rate, or the window is longer than
        the signals.
    """
    signals = Signals.given(signals, "orders")
    if "rotor_angle" in signals and tacho:
        raise QuestionError(f"orders: the signals have their angle already; leave out {', '.join(tacho)}")
    signals = with_rotor_angle(signals, **tacho)
    # a local fit says how sure it is at each speed; the filter follows faster changes
    requested = _Request(_orders(orders, signals), vibrations(signals, channels), method, revolutions)
    if method == "fit":
        dataset = _by_fit(signals, requested, progress if callable(progress) else silent)
    else:
        one_of("method", method, "fit", "vold-kalman")
        dataset = _by_filter(signals, requested, bandwidth)
    return dataset if slow_roll is None else subtracted(dataset, slow_roll)


@dataclass(frozen=True, eq=False)
class _Request:
    orders: Floats
    channels: list[str]
    method: str
    revolutions: float


def _by_fit(signals: xr.Dataset, requested: _Request, progress: Progress) -> Orders:
    begin, end = (float(signals["rotor_angle"][k]) for k in (0, -1))
    half, turns = math.pi * requested.revolutions, (end - begin) / (2.0 * math.pi)
    least = 1.5 / min(1.0, float(requested.orders.min()))
    if not least <= requested.revolutions < turns:
        raise QuestionError(
            f"revolutions: given {requested.revolutions:g}; must be from {least:g} to less than the {turns:.1f} that were "
            "measured"
        )
    step = max(2.0 * math.pi / A_TURN, (end - begin - 2.0 * half) / MOST)
    centers = np.arange(begin + half, end - half, step)
    tracked, narrow, middles = _fitted(signals, requested, centers, progress)
    bent = 4.0 / 3.0 * (tracked.amplitude - narrow.amplitude)  # the bias is of fourth order in the width
    text = f"local fit of second degree over {requested.revolutions:g} revolutions"
    how = {"method": text, "window_revolutions": requested.revolutions}
    reach = requested.orders[-1] + REACH / requested.revolutions
    ratio = np.linspace(0.0, reach, 1 + math.ceil(16.0 * requested.revolutions * reach))
    shares = [
        passed_by_fit(requested.orders, width, ratio)
        for width in (requested.revolutions, requested.revolutions / math.sqrt(2.0))
    ]
    shares[1] = 4.0 / 3.0 * (shares[0] - shares[1])

    def passes(frequency: Floats, rotation: Floats) -> Floats:
        at = frequency / rotation[:, None]
        return np.array([[np.interp(at, ratio, row, right=0.0) for row in share] for share in shares])

    longest = requested.revolutions * 2.0 * math.pi / extremes(signals["speed"])[0]
    deviation, unsure, notes = _sure(signals, requested, (centers, tracked), passes, longest)
    bias = np.sqrt(np.maximum(0.0, np.abs(bent) ** 2 - BEYOND * unsure**2))
    return _dataset(signals, requested, middles, tracked, (deviation, bias), how, notes)


def _fitted(
    signals: xr.Dataset, requested: _Request, centers: Floats, progress: Progress
) -> tuple[Tracked, Tracked, Floats]:
    """Amplitudes in windows about angles, in windows half as large in area, and the instants there; a block at a time."""
    angle, time = signals["rotor_angle"], signals["time"].values
    half, items, middles = math.pi * requested.revolutions, [], []
    starts, ends = places(angle, centers + np.array([[-half], [half]]))
    for group in merged_windows(starts, ends):
        part = slice(max(0, int(starts[group][0]) - 1), int(ends[group][-1]) + 1)
        turned, seen = angle[part].values, _values(signals, requested, part)
        widths = (requested.revolutions, requested.revolutions / math.sqrt(2.0))
        items.append([fitted_orders(turned, seen, requested.orders, centers[group], width) for width in widths])
        middles.append(np.interp(centers[group], turned, time[part]))
        progress(group.stop, centers.size)
    wide, narrow = (
        Tracked(*(np.concatenate(parts, axis=-1) for parts in zip(*side, strict=True)))
        for side in zip(*items, strict=True)
    )
    return wide, narrow, np.concatenate(middles)


def _by_filter(signals: xr.Dataset, requested: _Request, bandwidth: float | str | None) -> Orders:
    signals, full = _slower(signals, requested), float(signals.attrs["sampling_rate"])
    rate = float(signals.attrs["sampling_rate"])
    # bandwidth: as asked, else a tenth of the lowest order, and wider where the amplitude changes too fast for it
    lowest = extremes(signals["speed"])[0] * float(requested.orders.min()) / (2.0 * math.pi)
    width = max(1.0, 0.1 * lowest) if bandwidth is None else hertz_argument("bandwidth", bandwidth)
    if width > 0.2 * rate:
        raise QuestionError(
            f"bandwidth: given {width:g} Hz; must be below a fifth of the sampling rate, {0.2 * rate:.4g} Hz"
        )
    widest = width if bandwidth is not None else max(width, min(lowest, 0.2 * rate))
    angle = signals["rotor_angle"].values

    def passes(frequency: Floats, rotation: Floats) -> Floats:
        away = frequency - requested.orders[:, None, None] * rotation[:, None]
        return np.array([share(away, width, rate) for share in (passed_by_filter, noise_in_bias)])

    # until the bias is small against the amplitude
    for _ in range(WIDER):
        tracked = filtered_orders(angle, _values(signals, requested), requested.orders, width, rate)
        bent = bias_of(tracked.amplitude, width / rate)
        deviation, unsure, notes = _sure(signals, requested, (angle, tracked), passes, 2.0 / width)
        bias = np.sqrt(np.maximum(0.0, bent**2 - BEYOND * unsure**2))
        flat = float((bias.max(axis=2) / np.maximum(np.abs(tracked.amplitude).max(axis=(0, 2)), 1e-300)).max())
        if flat < 0.5 * FLAT or width >= widest:
            break
        width = min(widest, width * float(np.clip((4.0 * flat / FLAT) ** 0.25, 1.2, 3.0)))
    # at both ends the filter knows one side only
    sample = np.arange(angle.size)
    more = one_sided(np.minimum(sample, sample[::-1]) * width / rate)
    deviation, bias = deviation * more, bias * more**2
    # no more points than anybody can look at
    every = max(1, -(-angle.size // MOST))
    thin = Tracked(tracked.amplitude[..., ::every], tracked.residual[..., ::every])
    slower = f", of the signals at {rate:.4g} Hz" * (rate < full)
    how = {"method": f"Vold-Kalman filter of two poles, bandwidth {width:.4g} Hz{slower}", "bandwidth": width}
    return _dataset(
        signals,
        requested,
        signals["time"].values[::every],
        thin,
        (deviation[..., ::every], bias[..., ::every]),
        how,
        notes,
    )


def _slower(signals: xr.Dataset, requested: _Request) -> xr.Dataset:
    """A long record at five times the highest frequency that its orders need, by a filter that is even about each sample.

    What would be folded to these frequencies is a millionth (120 dB) of itself, and they are as they were to the same share.
    """
    size, rate = signals.sizes["time"], float(signals.attrs["sampling_rate"])
    # the highest frequency that matters, and how many samples may become one
    highest = (
        (requested.orders[-1] + REACH / max(1.0, requested.revolutions))
        * extremes(signals["speed"])[1]
        / (2.0 * math.pi)
    )
    every = int(0.2 * rate / highest)
    if size > LONG and every > 1:
        # a low-pass filter that is even about each sample, so that no phase shifts
        taps, shape = kaiserord(FOLDED, 1.2 / every)
        half = every * -(-taps // (2 * every))
        weights = firwin(2 * half + 1, 1.0 / every, window=("kaiser", shape))
        starts = np.arange(0, size - 2 * half, every)
        rows = []
        for group in merged_windows(starts, starts + 2 * half + 1):
            part = slice(int(starts[group][0]), int(starts[group][-1]) + 2 * half + 1)
            passed = upfirdn(weights, _values(signals, requested, part), 1, every, axis=1)[:, 2 * half // every :]
            rows.append(passed[:, : starts[group].size])
        slow = signals.isel(time=slice(half, half + int(starts[-1]) + 1, every)).drop_vars(signals.data_vars)
        for name in ("rotor_angle", "speed", "rotor_angle_deviation"):
            slow[name] = signals[name][half : half + int(starts[-1]) + 1 : every].load()
        for name, values in zip(requested.channels, np.concatenate(rows, axis=1), strict=True):
            slow[name] = ("time", values, signals[name].attrs)
        signals = slow.assign_attrs(sampling_rate=rate / every)
    # is there room for the band matrix?
    unknowns = 2 * requested.orders.size
    held = 2 * (2 * unknowns + 1) + 4 * len(requested.channels)  # the band, twice, and what it gives
    cure = "; take the fit, a piece of the record, or fewer orders"
    refuse_beyond_memory("orders: vold-kalman", signals.sizes["time"], "samples", 8.0 * unknowns * held, cure)
    return signals


def _sure(
    signals: xr.Dataset,
    requested: _Request,
    tracked: tuple[Floats, Tracked],
    passes: Callable[[Floats, Floats], Floats],
    longest: float,
) -> tuple[Floats, Floats, list[str]]:
    """Deviations that the noise near the orders gives to amplitudes at angles of the rotor, and notes.

    ``passes`` says how much of noise at frequencies (Hz) the amplitude of each order takes up at speeds of rotation (Hz), and
    perhaps how much another number does whose deviations are wanted, too; ``longest`` (s) is the longest piece of which an
    amplitude is made.
    """
    centers, result = tracked
    rate = float(signals.attrs["sampling_rate"])
    first, last = (int(k) for k in places(signals["rotor_angle"], centers[[0, -1]]))
    angle, speed = (signals[name][first : last + 1] for name in ("rotor_angle", "speed"))

    # speed at any sample, in turns a second
    def turning(samples: Floats) -> Floats:
        return at_samples(speed, samples) / (2.0 * math.pi)

    # the signals without the orders that were found
    def rest(begin: int, end: int) -> Floats:
        turned, left = angle[begin:end].values, _values(signals, requested, slice(first + begin, first + end))
        for n, order in enumerate(requested.orders):
            wave = np.exp(1j * order * turned)
            for c, amplitude in enumerate(result.amplitude[n]):
                at = np.interp(turned, centers, amplitude.real) + 1j * np.interp(turned, centers, amplitude.imag)
                left[c] -= (at * wave).real
        return left

    # how much of the noise that way of estimating lets pass, at an order and over the frequency
    step = float(centers[-1] - centers[0]) / max(1, centers.size - 1) / (2.0 * math.pi)  # revolutions

    def left(frequency: Floats, samples: Floats) -> Floats:
        rotation = turning(samples)
        away = frequency / rotation[:, None] - requested.orders[:, None, None]
        return np.asarray((1.0 - (passes(frequency, rotation)[0] * np.sinc(step * away) ** 2).sum(axis=0)) ** 2)

    # density of the rest over frequency and time, then what of it passes: the variance of the amplitudes
    times = np.unique(np.linspace(0, angle.size - 1, min(GRID, centers.size)).astype(int)).astype(np.float64)
    length = int(np.clip(2.0 * longest * rate, 16, max(16, angle.size // FRAMES)))
    highest = (requested.orders[-1] + REACH / max(1.0, requested.revolutions)) * extremes(speed)[1] / (2.0 * math.pi)
    end = last + 1 - first
    frequency, density = densities(
        lambda a, b: rest(a, min(b, end)), end, rate, length, times, left, min(highest, 0.5 * rate)
    )
    rotation, grid = turning(times), at_samples(angle, times)
    every = passes(frequency, rotation) ** 2 * frequency[1]
    taken = every[0]
    variance = np.einsum("ntf,ctf->nct", taken, density)
    # a line that stands out of it is no noise but another vibration: it is named
    smooth = np.minimum(density, LINE * median_filter(density, (1, 1, 9), mode="nearest"))
    size = np.abs(result.amplitude[..., np.searchsorted(centers, grid).clip(max=centers.size - 1)])
    lines = variance > np.maximum(DOUBT * np.einsum("ntf,ctf->nct", taken, smooth), (MATTERS * size) ** 2)
    notes = []
    for n, c in np.argwhere(lines.sum(axis=2) >= ROWS):
        rows = np.flatnonzero(lines[n, c])
        most = int(rows[np.argmax(variance[n, c, rows])])
        within = taken[n, most] > 0.01 * taken[n, most].max()
        top = int(np.argmax(within * density[c, most]))
        about = slice(max(0, top - 1), top + 2)
        hum = float(np.average(frequency[about], weights=density[c, most, about]))
        speeds = rotation[rows[[0, -1]]]
        notes.append(
            f"{requested.channels[c]}: a vibration at about {hum:.3g} Hz, which is no order, lies within the window of order "
            f"{requested.orders[n]:g} from {60.0 * speeds.min():.4g} to {60.0 * speeds.max():.4g} rpm; the deviations there "
            "contain it. More revolutions, or less bandwidth, may keep it out"
        )

    def deviations(squares: Floats) -> Floats:
        return np.array(
            [[np.exp(np.interp(centers, grid, 0.5 * np.log(row + 1e-300))) for row in rows] for rows in squares]
        )

    other = np.einsum("ntf,ctf->nct", every[-1], density)
    return deviations(variance), deviations(other), notes


def _flattened(requested: _Request, tracked: Tracked, bias: Floats, how: dict[str, Any]) -> list[str]:
    """Notes on orders whose greatest amplitude the window or the filter makes much too small."""
    cure = "more bandwidth" if "bandwidth" in how else "fewer revolutions"
    share = bias.max(axis=2) / np.maximum(np.abs(tracked.amplitude).max(axis=(0, 2)), 1e-300)
    return [
        f"{requested.channels[c]}: the amplitude of order {requested.orders[n]:g} changes so fast that it is wrong by up to "
        "about "
        f"{100.0 * share[n, c]:.2g} % of the greatest; take {cure}, or a slower run-up"
        for n, c in np.argwhere(share > FLAT)
    ]


def _values(signals: xr.Dataset, requested: _Request, part: slice = slice(None)) -> Floats:
    return np.array([signals[name][part].values for name in requested.channels])


def _orders(values: float | Sequence[float], signals: xr.Dataset) -> Floats:
    orders = np.unique(np.atleast_1d(np.asarray(values, np.float64)))
    if not orders.size or not np.isfinite(orders).all() or orders[0] <= 0.0:
        raise QuestionError(f"orders: given {values!r}; must be numbers above zero")
    highest = orders[-1] * extremes(signals["speed"])[1] / (2.0 * math.pi)
    if highest > 0.5 * signals.attrs["sampling_rate"]:
        raise QuestionError(
            f"orders: order {orders[-1]:g} reaches {highest:.4g} Hz, beyond half of the sampling rate of "
            f"{signals.attrs['sampling_rate']:.4g} Hz"
        )
    return orders


def vibrations(signals: xr.Dataset, values: str | Sequence[str] | None) -> list[str]:
    """Names of the vibrations that were chosen, by default all.

    Raises
    ------
    QuestionError
        If there is none, or not the one that was named.
    """
    there = [str(name) for name, entry in signals.data_vars.items() if entry.attrs.get("quantity") in VIBRATIONS]
    if values is None:
        if not there:
            own = [str(name) for name in signals.data_vars if not str(name).startswith(("rotor_angle", "speed"))]
            left = "; ".join(line for line in str(signals.attrs.get("warnings", "")).split("\n") if "left out" in line)
            words = f"none of {', '.join(own)} is a vibration" + f" ({left})" * bool(left)
            raise QuestionError(f"channels: {words}; say of the others what they are with channels (--channels)")
        return there
    requested = [values] if isinstance(values, str) else list(values)
    for name in requested:
        one_of("channels: vibration", name, *there)
    return requested


def _dataset(
    signals: xr.Dataset,
    requested: _Request,
    at: Floats,
    tracked: Tracked,
    errors: tuple[Floats, Floats],
    how: dict[str, Any],
    notes: list[str],
) -> Orders:
    deviation, bias = errors
    notes = [*notes, *_flattened(requested, tracked, bias, how)]
    for text in notes:
        warn(text, RangeWarning)
    t = signals["time"].values
    index = (at - t[0]) * (t.size - 1) / (t[-1] - t[0])
    speed, sure = (at_samples(signals[name], index) for name in ("speed", "rotor_angle_deviation"))
    size = np.abs(tracked.amplitude)
    with np.errstate(divide="ignore", invalid="ignore"):
        phase_deviation = np.minimum(deviation / size, math.pi / math.sqrt(3.0))
    phase_deviation = np.hypot(phase_deviation, requested.orders[:, None, None] * sure)
    dims = ("order", "channel", "time")
    dataset = labeled(
        {
            "amplitude": (dims, size, "amplitude of the order"),
            "phase": (dims, np.angle(tracked.amplitude), "lead over the zero mark", "rad"),
            "amplitude_deviation": (dims, deviation, "standard deviation of the amplitude"),
            "phase_deviation": (dims, phase_deviation, "standard deviation of the phase", "rad"),
            "bias": (dims, bias, "what the window or filter probably takes away"),
            "residual": (dims[1:], tracked.residual, "standard deviation of what the orders leave"),
        },
        {
            "order": ("order", requested.orders, "order of the rotor speed", "1"),
            "channel": ("channel", requested.channels, "channel"),
            "time": ("time", at, "time", "s"),
            "speed": ("time", speed, "rotor speed", "rad/s"),
        },
    )
    for key in ("units", "quantity", "place", "direction"):
        words = [str(signals[name].attrs.get(key, "")) for name in requested.channels]
        dataset = dataset.assign_coords({key: ("channel", words)})
    head = {"title": f"orders of {signals.attrs.get('origin') or 'signals'}", **how}
    doubts = "\n".join(filter(None, [str(signals.attrs.get("warnings", "")), *notes]))
    more = {"origin": signals.attrs.get("origin", ""), "warnings": doubts}
    if "pulse_jitter" in signals.attrs:  # a pulse is no better known than to a sample, even if all are off by the same
        step = float(t[-1] - t[0]) / (t.size - 1)
        more["edge_deviation"] = max(float(signals.attrs["pulse_jitter"]), step / math.sqrt(12.0))
        more |= {key: signals.attrs[key] for key in ("pulses_of_a_turn", "angle_bandwidth")}
    return Orders.of(dataset.assign_attrs(head | more | provenance()))


# Run-out of a shaft: what displacement sensors see although nothing vibrates, found at slow roll and subtracted.


SPREADS = (1.3, 1.7)  # ratios of speeds from which parts that grow with the second and the fourth power are told apart
STEADY = 1.05  # a ratio below which not even the first of them can be told
SLOW = 1.5  # times the slowest speed of the record, above which nobody rolls slowly
LEAST = 4  # points


def subtracted(orders: Orders, slow_roll: Any) -> Orders:
    """Orders without run-out.

    Within the interval the complex amplitude is R + D w² + E w⁴ of the speed w: unbalance below the resonance grows in even
    powers, and what is left at speed zero, R, is run-out. Where the speed changes less, the last terms are left out; where
    it hardly changes, points of the record up to 1.7 times that speed are fitted, too. Without such points, R is the mean.
    The deviation of R contains the noise of the points that are independent, and how far R would move with one more
    term, or what the next speed shows, by the square of the speed. All points share this error of R,
    ``runout_deviation``; it is part of the deviation of each of them.

    Parameters
    ----------
    orders
        Orders with run-out.
    slow_roll
        Interval of time, s, or orders measured at slow roll.

    Raises
    ------
    QuestionError
        If the interval holds fewer than four points or is not where the rotor is slow, the record has hardly any faster
        speed, or the other orders lack a channel or an order.
    """
    if isinstance(slow_roll, xr.Dataset):
        slow, where = _matching(orders, slow_roll), "of its own measurement"
    else:
        start, end = ends_argument("slow_roll", slow_roll, "s")
        at = orders["time"].values
        slow = orders.isel(time=(at >= start) & (at <= end))
        where = f"from {start:g} s to {end:g} s"
    if slow.sizes["time"] < LEAST:
        span = f"{orders['time'].values[0]:.4g} s to {orders['time'].values[-1]:.4g} s"
        raise QuestionError(f"slow_roll: {slow.sizes['time']} points {where}; the orders have {span}")
    _refuse_fast(orders, slow, where)
    speed, values, noise = _points(slow)
    count, low, high = independent(slow).sizes["time"], speed.min(), speed.max()
    if high <= SPREADS[0] * low:  # what grows with the speed is told by the next speeds
        faster = orders.isel(time=orders["speed"].values > high)
        near = faster.isel(time=faster["speed"].values <= SPREADS[1] * low)
        if near.sizes["time"]:
            pairs = zip((speed, values, noise), _points(near), strict=True)
            speed, values, noise = (np.concatenate(pair) for pair in pairs)
            count += independent(near).sizes["time"]
            where += f", with the growth of the vibration up to {speed.max() * 30.0 / np.pi:.4g} rpm"
    grows = sum(speed.max() > ratio * low for ratio in SPREADS)
    runout, spread = _at_speed_zero(speed, values, noise, 1 + grows, count)
    if speed.max() > STEADY * low and speed.size > LEAST:
        spread = np.hypot(spread, np.abs(_at_speed_zero(speed, values, noise, 2 + grows, speed.size)[0] - runout))
    if not grows:
        fast, seen, _ = _points(faster.isel(time=faster["speed"].values > SPREADS[0] * low))
        k = np.argmin(fast)
        spread = np.hypot(spread, np.abs(seen[k] - runout) / ((fast[k] / speed.mean()) ** 2 - 1.0))
    shape = slow["amplitude"].shape[:2]
    return _without(orders, runout.reshape(shape), spread.reshape(shape), where)


def _refuse_fast(orders: Orders, slow: xr.Dataset, where: str) -> None:
    """Where vibration would be taken for run-out: beside the slowest speed that lasts, or if no speed is faster."""
    speeds, here = orders["speed"].values, slow["speed"].values
    lasting = np.sort(independent(orders)["speed"].values)[:LEAST].max()
    text = f"slow_roll: {where} the rotor turns at {here.mean() * 30.0 / np.pi:.4g} rpm"
    if here.min() > SLOW * lasting:
        slowest, fast = speeds.argmin(), np.flatnonzero(speeds > SLOW * lasting)
        ends = fast[fast < slowest].max(initial=-1) + 1, fast[fast > slowest].min(initial=speeds.size) - 1
        begin, end = orders["time"].values[list(ends)]
        raise QuestionError(
            f"{text}, but at {speeds.min() * 30.0 / np.pi:.4g} rpm and little more from {begin:.4g} s to {end:.4g} s: vibration "
            "would be subtracted as run-out; give this interval, in which it turns slowest"
        )
    if max(speeds.max(), here.max()) <= SPREADS[0] * here.min():
        raise QuestionError(
            f"{text}, and the record goes to {speeds.max() * 30.0 / np.pi:.4g} rpm: vibration cannot be told from run-out; "
            "give a record with slow roll and faster speeds, or orders that were measured more slowly"
        )


def _points(orders: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speeds, and at each the complex amplitudes of all orders and channels and their deviations (point, column)."""
    values = orders["amplitude"].values * np.exp(1j * orders["phase"].values)
    speed, noise = orders["speed"].values, orders["amplitude_deviation"].values
    return speed, values.reshape(-1, speed.size).T, noise.reshape(-1, speed.size).T


def _at_speed_zero(
    speed: np.ndarray, values: np.ndarray, noise: np.ndarray, terms: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """R of each column of ``values`` (point, column), and one standard deviation of its parts if ``count`` points count."""
    design = ((speed / speed.max()) ** 2)[:, None] ** np.arange(terms)
    parts, *_ = np.linalg.lstsq(design.astype(np.complex128), values, rcond=None)
    rest = (np.abs(values - design @ parts) ** 2).sum(axis=0) / (2.0 * max(1, speed.size - terms))
    own = np.linalg.inv(design.T @ design)[0, 0] * speed.size / max(1, count)
    return parts[0], np.sqrt(own * np.maximum(rest, (noise**2).mean(axis=0)))


def _without(orders: Orders, runout: np.ndarray, spread: np.ndarray, where: str) -> Orders:
    left = orders["amplitude"].values * np.exp(1j * orders["phase"].values) - runout[:, :, None]
    before, size = orders["amplitude_deviation"].values, np.abs(left)
    deviation = np.hypot(before, spread[:, :, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        added = np.minimum(deviation / size, np.pi / np.sqrt(3.0))
        of_angle = orders["phase_deviation"].values ** 2 - (before / orders["amplitude"].values) ** 2
    orders = orders.copy()
    for name, values in (
        ("amplitude", size),
        ("phase", np.angle(left)),
        ("amplitude_deviation", deviation),
        ("phase_deviation", np.sqrt(added**2 + np.maximum(0.0, of_angle))),
    ):
        orders[name] = (orders[name].dims, values, orders[name].attrs)
    each = ("order", "channel")
    found = {
        "runout_amplitude": (each, np.abs(runout), "run-out that was subtracted"),
        "runout_deviation": (each, spread, "standard deviation of its parts, which all points share"),
        "runout_phase": (each, np.angle(runout), "its lead over the mark", "rad"),
    }
    return Orders.of(orders.assign(labeled(found)).assign_attrs(runout=f"subtracted, found at slow roll {where}"))


def _matching(orders: Orders, slow: xr.Dataset) -> xr.Dataset:
    if "amplitude" not in slow or "order" not in slow.coords:
        raise QuestionError("slow_roll: give an interval of time, or orders from ab.measure.orders")
    for name in ("order", "channel"):
        lacking = [value for value in orders[name].values if value not in slow[name].values]
        if lacking:
            raise QuestionError(f"slow_roll: its orders lack {name} {lacking[0]}")
    return slow.sel(order=orders["order"].values, channel=orders["channel"].values)


# Orders by a local fit: computed order tracking in which the amplitude may change within the window.


SPREAD = 2  # degree of the polynomial that every amplitude is within the window


class Tracked(NamedTuple):
    """Complex amplitudes u = Re(a e^(i n angle)), (order, channel, point)."""

    amplitude: Complexes
    residual: Floats  # (channel, point): standard deviation of what the orders leave in the window


def fitted_orders(
    angle: Floats, values: Floats, orders: Floats, centers: Floats, revolutions: float, degree: int = SPREAD
) -> Tracked:
    """Amplitudes at given angles of the rotor.

    In a window of ``revolutions`` about each, weighted by Hann, the signal is fitted by the sum of a drift and of all
    orders, whose complex amplitudes are polynomials of the angle. With degree 0 this is the windowed Fourier transform over
    the angle, whose amplitude is the mean over the window; degree 2 removes what a resonance curve bends within it, and
    leaves a bias of fourth order.

    Parameters
    ----------
    angle
        Of the rotor at the samples, rad; (time,), ascending.
    values
        Samples, (channel, time).
    orders
        (order,).
    centers
        Angles at which amplitudes are wanted, rad; their windows lie within the samples.
    """
    half = np.pi * revolutions
    shape = (orders.size, values.shape[0], centers.size)
    amplitude, residual = np.empty(shape, np.complex128), np.empty(shape[1:])
    for k, center in enumerate(centers):
        first, last = np.searchsorted(angle, [center - half, center + half])
        s = (angle[first:last] - center) / half
        weight = np.cos(0.5 * np.pi * s) ** 2
        design = _design(s, angle[first:last], orders, degree)
        weighted = design * weight[:, None]
        inverse = np.linalg.inv(weighted.T @ design)
        y = values[:, first:last]
        result = (y @ weighted) @ inverse  # (channel, unknown)
        rest = y - result @ design.T
        free = weight.sum() * (1.0 - design.shape[1] / max(last - first, design.shape[1] + 1))
        variance = (weight * rest**2).sum(axis=1) / free
        at = degree + 1 + 2 * (degree + 1) * np.arange(orders.size)
        amplitude[:, :, k] = (result[:, at] - 1j * result[:, at + 1]).T
        residual[:, k] = np.sqrt(variance)
    return Tracked(amplitude, residual)


def _design(s: Floats, angle: Floats, orders: Floats, degree: int) -> Floats:
    """Drift, then for each order cosine and sine times 1, then times s, ...: (samples, unknowns)."""
    powers = s[None, :] ** np.arange(degree + 1)[:, None]
    columns = list(powers)
    for order in orders:
        cosine, sine = np.cos(order * angle), np.sin(order * angle)
        for power in powers:
            columns += [power * cosine, power * sine]
    return np.asarray(columns, np.float64).T


def passed_by_fit(orders: Floats, revolutions: float, ratio: Floats, degree: int = SPREAD) -> Floats:
    """Share of a wave of so many periods a revolution (ratio,) that each amplitude of :func:`fitted_orders` takes up.

    (order, ratio); near one where the wave has the frequency of the order, zero at some revolutions' inverse from it.
    """
    half = np.pi * revolutions
    points = int(2 * np.ceil(8 * revolutions * max(4.0, float(np.max(ratio, initial=0.0))))) + 1
    s = np.linspace(-1.0, 1.0, points)
    design = _design(s, half * s, orders, degree)
    weighted = design * (np.cos(0.5 * np.pi * s) ** 2)[:, None]
    at = degree + 1 + 2 * (degree + 1) * np.arange(orders.size)
    rows = np.linalg.solve(weighted.T @ design, weighted.T)
    even, odd = rows[at], rows[at + 1]
    turns = half * np.outer(s, ratio)
    return np.asarray(0.5 * (even @ np.cos(turns) + odd @ np.sin(turns)), np.float64)


def window_of_fit(angle: Floats, rows: NDArray[np.intp], revolutions: float, degree: int = SPREAD) -> Floats:
    """Weights (row, angle) with which an amplitude given at angles enters that of :func:`fitted_orders` at some of these."""
    half, window = np.pi * revolutions, np.zeros((rows.size, angle.size))
    for k, row in enumerate(rows):
        first, last = np.searchsorted(angle, [angle[row] - half, angle[row] + half])
        s = (angle[first:last] - angle[row]) / half
        weighted = np.cos(0.5 * np.pi * s) * s ** np.arange(degree + 1)[:, None]
        window[k, first:last] = np.linalg.pinv(weighted.T)[0] * np.cos(0.5 * np.pi * s)
    return window


# Orders by the Vold–Kalman filter of the second generation: smooth complex amplitudes, several orders at once.


POLES = 2  # second differences of the amplitude are small


def filtered_orders(
    angle: Floats, values: Floats, orders: Floats, bandwidth: float, rate: float, poles: int = POLES
) -> Tracked:
    """Amplitudes at every sample.

    Sought are amplitudes a_n with the least sum of squares of the samples less the sum of Re(a_n e^(i n angle)), and of the
    differences of order ``poles`` of a_n times a weight r, Vold and Leuridan (1993), Tuma (2005). A slow change of the
    amplitude with the frequency f passes as 1/(1 + 2 r² (2 - 2 cos(2 pi f/rate))^poles); r is such that this is 1/sqrt(2) at
    half of the bandwidth.

    Parameters
    ----------
    angle
        Of the rotor at the samples, rad; (time,).
    values
        Samples, (channel, time).
    orders
        (order,).
    bandwidth
        Between the points at -3 dB, Hz.
    rate
        Samples in a second, Hz.
    poles
        1, 2 or 3.
    """
    weight = structural_weight(bandwidth / rate, poles)
    count, size = 2 * orders.size, angle.size
    waves = np.empty((size, count))
    for k, order in enumerate(orders):
        waves[:, 2 * k], waves[:, 2 * k + 1] = np.cos(order * angle), -np.sin(order * angle)
    band = _band(waves, weight, poles)
    right = values[:, :, None] * waves[None, :, :]
    unknown = solveh_banded(band, right.reshape(values.shape[0], size * count).T, lower=True, overwrite_ab=True)
    found = unknown.T.reshape(values.shape[0], size, count)
    rest = values - (found * waves[None, :, :]).sum(axis=2)
    amplitude = (found[:, :, 0::2] + 1j * found[:, :, 1::2]).transpose(2, 0, 1)
    residual = np.sqrt(_smoothed(rest**2, max(3, round(rate / bandwidth))))
    return Tracked(amplitude, residual)


def structural_weight(share: float, poles: int) -> float:
    """Square of r for a bandwidth that is ``share`` of the sampling rate."""
    return float(0.5 * (math.sqrt(2.0) - 1.0) / (2.0 - 2.0 * math.cos(math.pi * share)) ** poles)


def passed_by_filter(away: Floats, bandwidth: float, rate: float, poles: int = POLES) -> Floats:
    """Share of a wave so many hertz beside an order that its amplitude takes up."""
    turned = 2.0 - 2.0 * np.cos(2.0 * np.pi * np.clip(away / rate, -0.5, 0.5))
    return np.asarray(1.0 / (1.0 + 2.0 * structural_weight(bandwidth / rate, poles) * turned**poles))


def _band(waves: Floats, weight: float, poles: int) -> Floats:
    """Lower band of the normal matrix: (bandwidth + 1, samples times unknowns)."""
    size, count = waves.shape
    band = np.zeros((count * poles + 1, size, count))
    for a in range(count):
        for b in range(a + 1):
            band[a - b, :, b] += waves[:, a] * waves[:, b]
    signs = np.array([(-1.0) ** k * math.comb(poles, k) for k in range(poles + 1)])
    for i in range(poles + 1):
        for j in range(i + 1):
            rows = slice(j, size - poles + j)
            band[count * (i - j), rows, :] += weight * signs[i] * signs[j]
    return np.asarray(band.reshape(count * poles + 1, size * count), np.float64)


def _smoothed(squares: Floats, width: int) -> Floats:
    """Mean over ``width`` samples on the last axis, of those that are there."""
    width = min(width, squares.shape[1])
    sums = np.concatenate([np.zeros((squares.shape[0], 1)), np.cumsum(squares, axis=1)], axis=1)
    index = np.arange(squares.shape[1])
    low, high = np.maximum(0, index - width // 2), np.minimum(squares.shape[1], index + width - width // 2)
    return np.asarray((sums[:, high] - sums[:, low]) / (high - low), np.float64)


def bias_of(amplitude: NDArray[np.complex128], share: float, poles: int = POLES) -> Floats:
    """What the filter probably takes from amplitudes, as it does from what it gave; (..., time).

    With the share G that passes, 1 - G of the true amplitude is missing, and of the tracked one it is (1 - G) + (1 - G)² up to
    the third power. Of a beat the greatest within the inverse bandwidth counts.
    """
    step, size = max(1, round(0.1 / share)), amplitude.shape[-1]  # neighbors have a ripple at twice the rotation
    thin = np.arange(0, size, step)
    if thin.size <= 2 * poles:
        return np.zeros(amplitude.shape)
    band = _band(np.ones((thin.size, 1)), 2.0 * structural_weight(share * step, poles), poles)
    rows = amplitude[..., thin].reshape(-1, thin.size).T

    def lost(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.asarray(values - solveh_banded(band, values, lower=True))

    once = lost(rows)
    bent = maximum_filter1d(np.abs(once + lost(once)).T, max(1, round(1.0 / (share * step))), axis=-1)
    bias = np.array([np.interp(np.arange(size), thin, row) for row in bent])
    return np.asarray(bias.reshape(amplitude.shape), np.float64)


def passed_at(rows: NDArray[np.intp], size: int, share: float, poles: int = POLES) -> Floats:
    """Weights (row, sample) with which an amplitude given at samples enters that of the filter at some of them."""
    band = _band(np.ones((size, 1)), 2.0 * structural_weight(min(share, 1.0), poles), poles)
    whole = np.zeros((size, rows.size))
    whole[rows, np.arange(rows.size)] = 1.0
    return np.asarray(solveh_banded(band, whole, lower=True, overwrite_b=True).T)


def one_sided(away: Floats) -> Floats:
    """How many times more noise an amplitude has near an end, so far from it in inverses of the bandwidth.

    There the filter sees one side only. Of a slow change it misses up to the square of that times what :func:`bias_of` says.
    """
    grid = np.linspace(0.0, 1.0, 51)
    squares = (passed_at(np.append(np.arange(51), 250), 501, 0.02) ** 2).sum(axis=1)
    return np.asarray(np.interp(away, grid, np.sqrt(squares[:51] / squares[51])))


def noise_in_bias(away: Floats, bandwidth: float, rate: float, poles: int = POLES) -> Floats:
    """How much of noise, so many hertz beside an order, :func:`bias_of` takes for bias."""
    passed = passed_by_filter(away, bandwidth, rate, poles)
    return passed * (1.0 - passed) * (2.0 - passed)

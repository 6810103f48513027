"""The noise of a measured signal near a frequency: what is fitted to it takes up the noise there, not that of all frequencies.

Noise of real signals is not white: it drifts, it hums, and an acceleration that became a displacement has the more of it the
lower the frequency. Its density comes from what a fit leaves of the signal. Where the fit itself takes noise away, that is
known, and divided out.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError

NEAR = (3.0, 10.0, 30.0)  # frames in time from which on others count much less
LEAST, SHOWN = (
    1.5,
    0.2,
)  # frames in which all noise at a frequency is left, below which its neighbors tell; share that is left
MOST = 300  # frames
OF_WINDOW = 0.345  # of the window: the area of the autocorrelation of the local fit of second degree, weighted by Hann
OF_BANDWIDTH = 0.963  # over the bandwidth: the same of 1 / (1 + (f / f0)^4), which is at -3 dB at half of the bandwidth
HANN = np.array([1.0, 4.0, 1.0]) / 6.0  # power of its transform at three neighboring frequencies


def densities(
    rest: Callable[[int, int], Floats],
    size: int,
    rate: float,
    length: int,
    times: Floats,
    left: Callable[[Floats, Floats], Floats],
    highest: float,
) -> tuple[Floats, Floats]:
    """Mean square of the noise a hertz, over the frequency and the time.

    Parameters
    ----------
    rest
        What a fit leaves of the signal from one sample to before another, (channel, sample).
    size
        Samples of the signal.
    rate
        Hz.
    length
        Samples of a frame, weighted by Hann; frames overlap by half.
    times
        In samples, at which the density is wanted: of frames nearby, (T,).
    left
        Share of the power of noise that the fit leaves at frequencies (Hz; F) and times (samples; M): (M, F).
    highest
        Hz, up to which it is wanted.

    Returns
    -------
    Frequencies in Hz (F,), and densities (channel, T, F).

    Raises
    ------
    QuestionError
        If the signal is shorter than a frame.
    """
    if size < length:
        raise QuestionError(
            "the window is as long as the signals, so that nothing says how noisy they are; give fewer revolutions"
        )
    # frames that overlap by half, a straight line taken from each, Hann's window
    last = max(0, size - length)
    starts = np.unique(np.linspace(0, last, min(MOST, 1 + -(-2 * last // length))).astype(int))
    window = np.hanning(length + 1)[:-1]
    frequency = np.asarray(np.fft.rfftfreq(length, 1.0 / rate), np.float64)
    frequency = frequency[: int(np.searchsorted(frequency, highest)) + 2]
    line = np.linspace(-1.0, 1.0, length)
    parts, share = [], np.empty((starts.size, frequency.size))
    for j, start in enumerate(starts):
        piece = rest(int(start), int(start) + length)
        slope = (piece @ line) / (line @ line)
        piece = (piece - piece.mean(axis=1, keepdims=True) - slope[:, None] * line) * window
        parts.append(np.abs(np.fft.rfft(piece, axis=1)[:, : frequency.size]) ** 2)
        within = left(frequency, start + length * np.array([0.25, 0.375, 0.5, 0.625, 0.75])).mean(axis=0)
        share[j] = np.convolve(np.pad(within, 1, mode="edge"), HANN, mode="valid")
    # power over the share that was left in; what is nearly all taken out tells nothing
    power = np.stack(parts, axis=1) * (2.0 / (rate * float((window**2).sum())))
    share[:, :2] = 0.0  # a straight line was taken away
    shown = share > SHOWN
    power = np.log(np.maximum(power, 1e-300) / np.where(shown, share, 1.0))
    # the level of a frame may follow the speed: it is taken out, so that frames can be compared
    usual = (power * shown).sum(axis=1) / np.maximum(shown.sum(axis=0), 1)
    level = ((power - usual[:, None]) * shown).sum(axis=2) / np.maximum(
        shown.sum(axis=1), 1
    )  # it may grow with the speed
    power -= level[:, :, None]
    share *= shown
    # for each time the weighted median over the frames near it: single bursts do not count
    logarithms = np.log(np.maximum(frequency, 0.5 * frequency[1]))
    ranks, rows = np.argsort(power, axis=1), np.sort(power, axis=1)
    local = np.array([np.interp(times, starts + 0.5 * length, one) for one in level]) - math.log(math.log(2.0))
    densities = np.empty((power.shape[0], times.size, frequency.size))
    for k, time in enumerate(times):
        known, weight = np.zeros(frequency.size), np.zeros(share.shape)
        for near in NEAR:  # where too little of the noise is left nearby, frames farther away tell
            every = 1.0 / (1.0 + ((time - starts - 0.5 * length) / (0.5 * near * length)) ** 4)
            weight = np.where(known < LEAST, every[:, None] * share, weight)
            known = weight.sum(axis=0)
        row = known >= LEAST
        row = row if row.any() else np.arange(frequency.size) >= 2
        for c, rank in enumerate(ranks):
            sums = np.cumsum(np.take_along_axis(weight, rank, axis=0), axis=0)
            middle = (sums < 0.5 * known).sum(axis=0)  # of lines that pass through a frequency it knows nothing
            middles = np.take_along_axis(rows[c], np.minimum(middle, starts.size - 1)[None], axis=0)[0]
            densities[c, k] = np.interp(logarithms, logarithms[row], middles[row]) + local[c, k]
    return frequency, np.exp(densities)


def independent(orders: xr.Dataset) -> xr.Dataset:
    """Points so far apart that as many independent readings would know as much as all points together.

    That distance is the area below the autocorrelation of the noise of an amplitude. With the local fit the autocorrelation is
    zero there, too. Orders of which it is not known how they were tracked, such as tables, are returned as they are.

    Parameters
    ----------
    orders
        From :func:`autobalancer.measure.orders`, over ``time``.
    """
    if "time" not in orders.dims or "speed" not in orders.variables:
        return orders
    time, speed = np.asarray(orders["time"].values, np.float64), np.asarray(orders["speed"].values, np.float64)
    if "window_revolutions" in orders.attrs:
        turns = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))] / (2.0 * np.pi)
        place = turns / (OF_WINDOW * float(orders.attrs["window_revolutions"]))
    elif "bandwidth" in orders.attrs:
        place = (time - time[:1]) * float(orders.attrs["bandwidth"]) / OF_BANDWIDTH
    else:
        return orders
    kept, last = [], -np.inf
    for row, at in enumerate(place):
        if at - last > 1.0 - 1e-9:
            kept.append(row)
            last = at
    return orders.isel(time=kept)

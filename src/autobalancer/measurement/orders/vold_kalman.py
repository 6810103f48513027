"""Orders by the Vold–Kalman filter of the second generation: smooth complex amplitudes, several orders at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.ndimage import maximum_filter1d

from autobalancer.measurement.orders.fitted import Tracked

Floats = NDArray[np.float64]
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
    step, size = (
        max(1, round(0.1 / share)),
        amplitude.shape[-1],
    )  # neighboring samples have a ripple at twice the rotation
    thin = np.arange(0, size, step)
    if thin.size <= 2 * poles:
        return np.zeros(amplitude.shape)
    band = _band(np.ones((thin.size, 1)), 2.0 * structural_weight(share * step, poles), poles)
    rows = amplitude[..., thin].reshape(-1, thin.size).T

    def lost(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.asarray(values - solveh_banded(band, values, lower=True))

    once = lost(rows)
    bent = maximum_filter1d(np.abs(once + lost(once)).T, max(1, round(1.0 / (share * step))), axis=-1)
    found = np.array([np.interp(np.arange(size), thin, row) for row in bent])
    return np.asarray(found.reshape(amplitude.shape), np.float64)


def passed_at(rows: NDArray[np.intp], size: int, share: float, poles: int = POLES) -> Floats:
    """Weights (row, sample) with which an amplitude given at samples enters that of the filter at some of them."""
    band = _band(np.ones((size, 1)), 2.0 * structural_weight(min(share, 1.0), poles), poles)
    whole = np.zeros((size, rows.size))
    whole[rows, np.arange(rows.size)] = 1.0
    return np.asarray(solveh_banded(band, whole, lower=True, overwrite_b=True).T)


def noise_in_bias(away: Floats, bandwidth: float, rate: float, poles: int = POLES) -> Floats:
    """How much of noise, so many hertz beside an order, :func:`bias_of` takes for bias."""
    passed = passed_by_filter(away, bandwidth, rate, poles)
    return passed * (1.0 - passed) * (2.0 - passed)

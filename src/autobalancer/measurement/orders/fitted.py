"""Orders by a local fit: computed order tracking in which the amplitude may change within the window."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
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
        found = (y @ weighted) @ inverse  # (channel, unknown)
        rest = y - found @ design.T
        free = weight.sum() * (1.0 - design.shape[1] / max(last - first, design.shape[1] + 1))
        variance = (weight * rest**2).sum(axis=1) / free
        at = degree + 1 + 2 * (degree + 1) * np.arange(orders.size)
        amplitude[:, :, k] = (found[:, at] - 1j * found[:, at + 1]).T
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
    half, found = np.pi * revolutions, np.zeros((rows.size, angle.size))
    for k, row in enumerate(rows):
        first, last = np.searchsorted(angle, [angle[row] - half, angle[row] + half])
        s = (angle[first:last] - angle[row]) / half
        weighted = np.cos(0.5 * np.pi * s) * s ** np.arange(degree + 1)[:, None]
        found[k, first:last] = np.linalg.pinv(weighted.T)[0] * np.cos(0.5 * np.pi * s)
    return found

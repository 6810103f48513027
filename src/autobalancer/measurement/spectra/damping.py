"""Damping from a decay, and from the width of a resonance."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.decay import decay_rate
from autobalancer.measurement.orders.question import vibrations
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.orders import Orders
from autobalancer.results.signals.signals import Signals
from autobalancer.units import optional_argument

Floats = NDArray[np.float64]
WAVES = 0.1  # standard deviation of what a fit leaves over that of the signal, from which on waves in it are doubtful
SURE = 3.0  # standard deviations
SLOW = 0.1  # growth of the speed over the square of the decay rate, above which a run-up widens the resonance


def damping(
    signals: xr.Dataset,
    channel: str = "",
    *,
    modes: int = 1,
    start: float | str | None = None,
    end: float | str | None = None,
    robust: bool = True,
) -> xr.Dataset:
    """Frequency and damping of a measured decay: the logarithmic decrement of all its samples at once.

    Parameters
    ----------
    signals
        With a decay, such as after a blow.
    channel
        By default the only vibration.
    modes
        Number of decaying oscillations.
    start, end
        Of the piece that is fitted, s; by default from the greatest value to the end.
    robust
        Whether outliers are given less weight.

    Returns
    -------
    xarray.Dataset
        As :func:`~autobalancer.measure.decay_rate`.

    Raises
    ------
    QuestionError
        If there are several vibrations and none is chosen, or the piece holds no such oscillation.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("damping: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    names = vibrations(signals, channel or None)
    if len(names) > 1:
        raise QuestionError(f"channel: there are several, {', '.join(names)}; choose one")
    time, values = signals["time"].values, signals[names[0]].values
    first, last = optional_argument("start", start, "s"), optional_argument("end", end, "s")
    if first is None:
        first = float(time[np.argmax(np.abs(values - np.median(values)))])
    kept = (time >= first) & (time <= (time[-1] if last is None else last))
    found = decay_rate(time[kept], values[kept], modes, robust=robust)
    doubts = _doubts(found)
    unit = {"units": str(signals[names[0]].attrs.get("units", ""))}
    for name in ("signal", "fitted", "amplitude", "amplitude_uncertainty"):
        found[name].attrs |= unit
    origin = signals.attrs.get("origin", "")
    return Labeled.of(
        found.assign_attrs(
            title=f"decay of {names[0]}" + f" of {origin}" * bool(origin), channel=names[0], warnings="\n".join(doubts)
        )
    )


def _doubts(found: xr.Dataset) -> list[str]:
    """Why a piece is probably no free decay: waves that the fit leaves, or a vibration that does not decay."""
    signal = found["signal"].values
    rest, size = signal - found["fitted"].values, float(np.std(signal))
    left, alike = float(np.std(rest)) / size, float(np.corrcoef(rest[1:], rest[:-1])[0, 1])
    doubts = []
    if left > WAVES and alike > 0.5:
        doubts.append(
            f"the fit leaves {100.0 * left:.3g} % of the signal, in waves and not as noise: the numbers are wrong if something "
            "still drives the vibration, or if there are more modes"
        )
    undamped = found["damping_ratio"].values < SURE * found["damping_ratio_uncertainty"].values
    if undamped.any():
        doubts.append("no damping is seen beyond its uncertainty: this is a vibration that is driven, not a decay")
    return doubts


def half_power(orders: xr.Dataset, channel: str = "", *, order: float = 1.0) -> xr.Dataset:
    """Damping ratio from the width of a resonance at half of its power.

    The amplitude over the speed is divided by the square of the speed, as unbalance excites; the damping ratio is
    (w2² - w1²)/(4 w0²) of the speeds w1 and w2 at which 1/sqrt(2) of the peak at w0 is left. It is right for small damping,
    one mode and a slow run-up; a fast one widens the peak, and a warning says so.

    Parameters
    ----------
    orders
        From ``ab.measure.orders``, through one resonance.
    channel
        By default the first.
    order
        Of the speed.

    Returns
    -------
    xarray.Dataset
        ``frequency`` (rad/s), ``damping_ratio``, ``damping_ratio_deviation`` (one standard deviation, from that of the
        amplitudes).

    Raises
    ------
    QuestionError
        If the amplitude does not fall to 1/sqrt(2) on both sides of the peak.
    """
    if not isinstance(orders, Orders):
        raise QuestionError("half_power: give orders, from ab.measure.orders")
    name = channel or str(orders["channel"].values[0])
    one = orders.sel(channel=name, order=order)
    w = one["speed"].values * order
    size, spread = one["amplitude"].values / w**2, one["amplitude_deviation"].values / w**2
    k = int(np.argmax(size))
    level = size[k] / math.sqrt(2.0)
    edges = [_edge(w, size, k, level, side) for side in (-1, 1)]
    if any(edge is None for edge in edges):
        raise QuestionError(
            f"half_power: the amplitude of {name!r} does not fall to 71 % on both sides of its peak at {w[k]:.4g} rad/s"
        )
    (low, low_slope, i), (high, high_slope, j) = (edge for edge in edges if edge is not None)
    ratio = (high**2 - low**2) / (4.0 * w[k] ** 2)
    sides = ((i, low_slope), (j, high_slope))
    at_edges = [math.hypot(spread[m], spread[k] / math.sqrt(2.0)) / abs(slope) for m, slope in sides]
    deviation = math.hypot(low * at_edges[0], high * at_edges[1]) / (2.0 * w[k] ** 2)
    growth = abs(float(np.gradient(one["speed"].values, one["time"].values)[k])) * order
    fast = growth / (ratio * w[k]) ** 2
    texts = (
        [f"the run-up is fast, {fast:.2g} of the squared decay rate: the damping is too great"] if fast > SLOW else []
    )
    entries = {
        "frequency": (float(w[k]), "frequency of the peak", "rad/s"),
        "damping_ratio": (ratio, "damping ratio", ""),
        "damping_ratio_deviation": (deviation, "standard deviation of the damping ratio", ""),
    }
    found = xr.Dataset(
        {key: ((), value, {"long_name": text, "units": unit}) for key, (value, text, unit) in entries.items()}
    )
    head = {"title": f"resonance of {name}", "warnings": "\n".join(texts)}
    return Labeled.of(found.assign_attrs(head | provenance()))


def _edge(w: Floats, size: Floats, k: int, level: float, side: int) -> tuple[float, float, int] | None:
    """Frequency at which the curve passes the level, its slope there, and the sample; None if it does not."""
    i = k
    while 0 <= i + side < w.size:
        if size[i + side] < level:
            slope = (size[i + side] - size[i]) / (w[i + side] - w[i])
            return float(w[i] + (level - size[i]) / slope), float(slope), i
        i += side
    return None

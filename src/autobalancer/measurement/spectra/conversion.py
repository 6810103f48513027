"""Displacement, velocity and acceleration into one another, over the frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.signals.unit_words import hertz_argument
from autobalancer.results.signals.signals import Signals

Floats = NDArray[np.float64]
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
    if not isinstance(signals, Signals):
        raise QuestionError("converted: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    if to not in POWERS:
        raise QuestionError(f"to: given {to!r}; must be one of {', '.join(POWERS)}")
    there = [str(n) for n, v in signals.data_vars.items() if v.attrs.get("quantity") in POWERS]
    asked = there if channels is None else [channels] if isinstance(channels, str) else list(channels)
    for name in asked:
        if name not in there:
            raise QuestionError(f"channels: no motion {name!r}; there are {', '.join(there) or 'none'}")
    low = 0.0 if corner is None else hertz_argument("corner", corner)
    length = signals.sizes["time"] / float(signals.attrs["sampling_rate"])
    found = signals.copy()
    for name in asked:
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
        found[name] = ("time", values, attrs)
    return Signals.of(found)


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

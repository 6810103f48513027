"""The one form of measured signals: channels over an even time, in SI, each with its quantity, place and direction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd  # type: ignore[import-untyped]
import xarray as xr
from numpy.typing import ArrayLike

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, UnitError
from autobalancer.results.answers.answer import provenance
from autobalancer.results.signals import LONG, Samples, Signals, pieces
from autobalancer.units import argument, column_factor
from autobalancer.units.trade import factor, without_suffix

UNITS = {  # SI units that a channel of each quantity may have
    "displacement": ("m",),
    "velocity": ("m/s",),
    "acceleration": ("m/s^2",),
    "force": ("N",),
    "torque": ("N m",),
    "tacho": ("V", "1"),
    "angle": ("rad",),
    "speed": ("rad/s",),
    "voltage": ("V",),
    "pressure": ("Pa",),
}
DIRECTIONS = ("", "x", "y", "z")
LEAST = 8  # samples
UNEVEN = 1e-3  # of a step; so far may an instant be from its place on the even grid


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured channel in SI.

    Attributes
    ----------
    values
        (time,); of a long record they may be ``Samples``, which stay in their file.
    quantity
        displacement, velocity, acceleration, force, torque, tacho, angle, speed, voltage or pressure.
    place
        Name of the station of the sensor, or empty.
    direction
        "x", "y", "z", an angle from x in degrees, or empty.
    long_name
        In words; by default the quantity with place and direction.
    uncertainty
        One standard deviation of a value, in its unit; ``None`` where it is not known.
    units
        SI unit; by default that of the quantity.
    """

    values: ArrayLike | Samples
    quantity: str
    place: str = ""
    direction: str | float = ""
    long_name: str = ""
    uncertainty: float | None = None
    units: str = ""


def signals(time: ArrayLike, channels: Mapping[str, Channel], *, origin: str = "", title: str = "") -> xr.Dataset:
    """Put measured channels into the form that every function of ``ab.measure`` takes.

    Parameters
    ----------
    time
        Instants of the samples, s, ascending at equal steps; (time,).
    channels
        By name, each with values, quantity, place and direction.
    origin
        Where they come from, such as the name of a file or of a run.
    title
        What they are; by default *signals* with their origin.

    Returns
    -------
    xarray.Dataset
        A variable for each channel over ``time``, with the attributes ``units``, ``quantity``, ``place``, ``direction``,
        ``long_name`` and perhaps ``uncertainty``; ``attrs``: ``sampling_rate`` (Hz) and ``origin``.

    Raises
    ------
    QuestionError
        If the times are not even, a value is not finite, or a quantity, unit or direction is not one of those above.
    """
    t = np.asarray(time, np.float64)
    _check_time(t)
    if not channels:
        raise QuestionError("signals: no channels; give at least one")
    rate = (t.size - 1) / float(t[-1] - t[0])
    held = pd.Index(t, copy=t.size <= LONG)
    dataset = xr.Dataset(coords={"time": ("time", held, {"long_name": "time", "units": "s"})})
    for name, channel in channels.items():
        values = _values(name, channel, t)
        held = values.variable() if isinstance(values, Samples) else values
        dataset[name] = ("time", held, _attributes(name, channel))
    head = {"title": title or f"signals of {origin}".removesuffix(" of "), "sampling_rate": rate, "origin": origin}
    return Signals.of(dataset.assign_attrs(head | provenance()))


def _check_time(t: Floats) -> None:
    if t.ndim != 1 or t.size < LEAST:
        raise QuestionError(f"signals: time: given {t.size} samples; give at least {LEAST}, in one dimension")
    if not np.isfinite(t).all():
        raise QuestionError(f"signals: time: sample {int(np.flatnonzero(~np.isfinite(t))[0]) + 1} is not finite")
    for first, part in pieces(t, 1):
        bad = np.flatnonzero(~(np.diff(part) > 0.0))
        if bad.size:
            i = first + int(bad[0])
            raise QuestionError(f"signals: time: must ascend; after {t[i]:.9g} s comes {t[i + 1]:.9g} s")
    for first, part in pieces(t):
        even = t[0] + (t[-1] - t[0]) * np.arange(first, first + part.size) / (t.size - 1)
        off = np.abs(part - even) * (t.size - 1) / (t[-1] - t[0])
        if off.max() > UNEVEN:
            i = int(np.argmax(off))
            raise QuestionError(
                f"signals: time: steps are not equal; at {part[i]:.9g} s a sample is {off[i]:.3g} of a step from its place; "
                "resample the signals first"
            )


def _values(name: str, channel: Channel, t: Floats) -> Floats | Samples:
    held = channel.values
    values = held if isinstance(held, Samples) else np.array(held, np.float64)
    if values.shape != t.shape:
        raise QuestionError(f"signals: channel {name!r}: {values.size} values for {t.size} times")
    for first, part in pieces(values):
        if not np.isfinite(part).all():
            i = first + int(np.flatnonzero(~np.isfinite(part))[0])
            raise QuestionError(f"signals: channel {name!r}: the value at {t[i]:.9g} s is not a finite number")
    return values


def _attributes(name: str, channel: Channel) -> dict[str, Any]:
    quantity, direction = channel.quantity, channel.direction
    if quantity not in UNITS:
        raise QuestionError(f"signals: channel {name!r}: quantity {quantity!r}; must be one of {', '.join(UNITS)}")
    units = channel.units or UNITS[quantity][0]
    if units not in UNITS[quantity]:
        raise QuestionError(
            f"signals: channel {name!r}: units {units!r}; a {quantity} is given in {' or '.join(UNITS[quantity])}"
        )
    if isinstance(direction, str) and direction not in DIRECTIONS:
        raise QuestionError(
            f"signals: channel {name!r}: direction {direction!r}; must be x, y, z, a number of degrees from x, or empty"
        )
    where = f" of {channel.place}" * bool(channel.place)
    along = "" if direction == "" else f" along {direction}" if isinstance(direction, str) else f" at {direction:g}°"
    known = {} if channel.uncertainty is None else {"uncertainty": float(channel.uncertainty)}
    return {
        "units": units,
        "quantity": quantity,
        "place": channel.place,
        "direction": direction if isinstance(direction, str) else float(direction),
        "long_name": channel.long_name or f"{quantity}{where}{along}",
        **known,
    }


# Units as loggers write them.


TACHO = ("tacho", "encoder", "trigger", "mark", "keyphasor", "pulse")


def factor_to(unit: str, si: str) -> float:
    """How many ``si`` one ``unit`` is.

    Raises
    ------
    UnitError
        If it is no unit, or one of another dimension, or that of a value from peak to peak or an rms value, which samples of a
        waveform are not.
    """
    return column_factor(unit.strip(), "" if si == "1" else si)[0]


def hertz_argument(name: str, value: float | str) -> float:
    """A rate or frequency as a number in Hz or a text with a unit, in Hz; 1/s is Hz here, since no rotation is meant.

    Raises
    ------
    QuestionError
        If it is not above zero.
    """
    try:
        hertz_argument = argument(name, value, "1/s")
    except UnitError:
        hertz_argument = argument(name, value, "rad/s") / (2.0 * math.pi)
    if not 0.0 < hertz_argument < math.inf:
        raise QuestionError(f"{name}: given {value!r}; must be above zero")
    return hertz_argument


def quantity_of(name: str, unit: str) -> str:
    """The quantity that has this unit; a voltage of a column called tacho, trigger, ... is that of a tacho. Empty if none has.

    A unit g is that of an acceleration. Of 1/s, and of a unit with ``pp`` or ``rms``, it is what it would be if it were complete,
    so that :func:`factor_to` can say what is missing.
    """
    unit = without_suffix(unit.strip())[0]
    if not unit.strip():
        return "tacho" if is_tacho(name) else ""
    try:
        quantity = next((quantity for quantity, (si, *_) in UNITS.items() if factor(unit, si) is not None), "")
        if not quantity and factor(unit, "1/s") is not None:
            return "speed"
    except UnitError:
        return ""
    return "voltage" if quantity == "tacho" and not is_tacho(name) else quantity


def is_tacho(name: str) -> bool:
    """Whether a column is probably that of a tacho, by its name."""
    return any(word in name.lower() for word in TACHO)

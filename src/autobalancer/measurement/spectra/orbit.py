"""Orbits of a shaft: as measured, and of one order."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.angle import with_rotor_angle
from autobalancer.measurement.orders.fitted import fitted_orders
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals
from autobalancer.units import optional_argument

Floats = NDArray[np.float64]
POINTS = 181  # of a turn
RIGHT = 5.0  # degrees by which a right angle may be off
LEAST = 0.3  # sine of the angle between two sensors
NAMED = 3  # pairs that a message names


def orbit(
    signals: xr.Dataset,
    x: str = "",
    y: str = "",
    *,
    at: float | str | None = None,
    revolutions: float = 4.0,
    orders: tuple[float, ...] = (1.0, 2.0),
) -> xr.Dataset:
    """The orbit about an instant, as measured and filtered to each order and to all of them.

    Parameters
    ----------
    signals
        With two displacements along different lines and a tacho.
    x, y
        Names of the channels; by default the only two at one place at right angles. Where they look along other directions
        than x and y, their motion is turned to these axes.
    at
        Instant, s; by default the middle.
    revolutions
        That are drawn, and from which the orders are fitted.
    orders
        Of the speed.

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``x``, ``y`` without their means (m); over (order, turned), one turn: ``filtered_x``, ``filtered_y``;
        over order: ``semi_major``, ``semi_minor`` (negative if it whirls backward), ``tilt`` of the major axis (rad),
        ``forward`` and ``backward`` circles (m). ``attrs``: ``speed``.

    Raises
    ------
    QuestionError
        If there are not two such channels, they look along one line, or the window is not within the signals.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("orbit: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    x, y = _pair(signals, x, y)
    signals = with_rotor_angle(signals)
    time, angle = signals["time"].values, signals["rotor_angle"].values
    instant = optional_argument("at", at, "s")
    center = float(np.interp(0.5 * (time[0] + time[-1]) if instant is None else instant, time, angle))
    half = math.pi * revolutions
    if revolutions < 2.0 or center - half < angle[0] or center + half > angle[-1]:
        low, high = np.interp([angle[0] + half, angle[-1] - half], angle, time)
        raise QuestionError(
            f"at: with {revolutions:g} revolutions, at least 2, it must be from {low:.4g} s to {high:.4g} s"
        )
    values = _along_axes(signals, x, y)
    wanted = np.array(sorted(orders), np.float64)
    tracked = fitted_orders(angle, values, wanted, np.array([center]), revolutions).amplitude[:, :, 0]
    inside = np.abs(angle - center) <= half
    turned = np.linspace(0.0, 2.0 * math.pi, POINTS)
    waves = tracked[:, :, None] * np.exp(1j * wanted[:, None, None] * turned)
    forward, backward = 0.5 * (tracked[:, 0] + 1j * tracked[:, 1]), 0.5 * np.conj(tracked[:, 0] - 1j * tracked[:, 1])
    own = {"long_name": "as measured, without the mean", "units": "m"}
    entries = {
        "semi_major": (np.abs(forward) + np.abs(backward), "semi-major axis", "m"),
        "semi_minor": (np.abs(forward) - np.abs(backward), "semi-minor axis, negative where it whirls backward", "m"),
        "tilt": (0.5 * np.angle(forward * backward), "direction of the major axis", "rad"),
        "forward": (np.abs(forward), "circle with the rotor", "m"),
        "backward": (np.abs(backward), "circle against it", "m"),
    }
    found = xr.Dataset(
        {key: ("order", numbers, {"long_name": text, "units": unit}) for key, (numbers, text, unit) in entries.items()},
        {
            "order": ("order", wanted, {"long_name": "order of the rotor speed", "units": "1"}),
            "turned": ("turned", turned, {"long_name": "angle of the rotor", "units": "rad"}),
            "time": ("time", time[inside], {"long_name": "time", "units": "s"}),
        },
    )
    for k, name in enumerate("xy"):
        found[name] = ("time", values[k, inside] - values[k, inside].mean(), own)
        found[f"filtered_{name}"] = (("order", "turned"), waves[:, k].real, {"long_name": "of one order", "units": "m"})
    speed = float(np.interp(center, angle, signals["speed"].values))
    head = {
        "title": f"orbit of {x} and {y} at {float(np.interp(center, angle, time)):.4g} s",
        "speed": speed,
        "revolutions": revolutions,
    }
    return Labeled.of(found.assign_attrs(head | provenance()))


def _pair(signals: xr.Dataset, x: str, y: str) -> tuple[str, str]:
    """The channels of an orbit: those that were named, else the only two at one place at right angles."""
    there = {str(n): _direction(v) for n, v in signals.data_vars.items() if v.attrs.get("quantity") == "displacement"}
    if not there:
        raise QuestionError(
            "orbit: the signals have no displacement; bring velocities or accelerations to displacements with "
            "ab.measure.converted(signals, 'displacement', corner='2 Hz')"
        )
    for word, given in (("x", x), ("y", y)):
        if given and given not in there:
            raise QuestionError(f"{word}: no displacement {given!r}; there are {', '.join(there)}")
    if x and y:
        return x, y
    either = 180.0 if x or y else 360.0  # without a name the second sensor is a quarter turn ahead of the first
    pairs = [
        (one, other)
        for one, other in permutations(there, 2)
        if (x or one) == one
        and (y or other) == other
        and _place(signals, one) == _place(signals, other)
        and abs(_turn(there[one], there[other]) % either - 90.0) < RIGHT
    ]
    if len(pairs) == 1:
        return pairs[0]
    if pairs:
        some = " or ".join(f"x='{one}', y='{other}'" for one, other in pairs[:NAMED])
        raise QuestionError(f"orbit: several pairs of displacements at right angles; name one, {some}")
    known = ", ".join(f"{name} ({'no direction' if way is None else f'{way:g} deg'})" for name, way in there.items())
    raise QuestionError(
        f"orbit: no two displacements at right angles at one place; there are {known}. Name both, x and y, or say their "
        "directions in the description of the channels"
    )


def _direction(channel: xr.DataArray) -> float | None:
    """Where a sensor looks, degrees from x; ``None`` where it is not known."""
    known = channel.attrs.get("direction", "")
    return {"x": 0.0, "y": 90.0}.get(known) if isinstance(known, str) else float(known)


def _place(signals: xr.Dataset, name: str) -> str:
    return str(signals[name].attrs.get("place", ""))


def _turn(one: float | None, other: float | None) -> float:
    return math.nan if one is None or other is None else other - one


def _along_axes(signals: xr.Dataset, x: str, y: str) -> Floats:
    """The motion along x and y from two sensors that look anywhere; a direction that is not known is that of the axis.

    Raises
    ------
    QuestionError
        If they look along nearly the same line.
    """
    values = np.array([signals[name].values for name in (x, y)], np.float64)
    ways = [_direction(signals[name]) for name in (x, y)]
    if None in ways:
        return values
    looks = np.radians(np.array(ways, np.float64))
    rows = np.column_stack([np.cos(looks), np.sin(looks)])  # what each sensor sees of x and y
    if abs(np.linalg.det(rows)) < LEAST:
        raise QuestionError(
            f"orbit: {x} and {y} look along {ways[0]:g} and {ways[1]:g} deg, nearly one line; take others"
        )
    return np.asarray(np.linalg.solve(rows, values), np.float64)

"""Orbits of a shaft: as measured, and of one order."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.angle import rotor_angle
from autobalancer.measurement.orders.fitted import fitted_orders
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals
from autobalancer.units import optional_argument

POINTS = 181  # of a turn


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
        With two displacements at right angles and a tacho.
    x, y
        Names of the channels; by default those with the directions x and y.
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
        If there are not two such channels, or the window is not within the signals.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("orbit: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    x, y = _pair(signals, x, y)
    if "rotor_angle" not in signals:
        signals = rotor_angle(signals)
    time, angle = signals["time"].values, signals["rotor_angle"].values
    instant = optional_argument("at", at, "s")
    center = float(np.interp(0.5 * (time[0] + time[-1]) if instant is None else instant, time, angle))
    half = math.pi * revolutions
    if revolutions < 2.0 or center - half < angle[0] or center + half > angle[-1]:
        low, high = np.interp([angle[0] + half, angle[-1] - half], angle, time)
        raise QuestionError(
            f"at: with {revolutions:g} revolutions, at least 2, it must be from {low:.4g} s to {high:.4g} s"
        )
    values = np.array([signals[name].values for name in (x, y)])
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
    there = [str(name) for name, v in signals.data_vars.items() if v.attrs.get("quantity") == "displacement"]
    found = []
    for given, direction in ((x, "x"), (y, "y")):
        fits = [name for name in there if signals[name].attrs.get("direction") == direction]
        if given and given not in there:
            raise QuestionError(f"{direction}: no displacement {given!r}; there are {', '.join(there) or 'none'}")
        if not there:
            raise QuestionError(
                "orbit: the signals have no displacement; bring velocities or accelerations to displacements with "
                "ab.measure.converted(signals, 'displacement', corner='2 Hz')"
            )
        if not given and len(fits) != 1:
            raise QuestionError(
                f"{direction}: {len(fits)} displacements along {direction}; name one of {', '.join(there) or 'none'}"
            )
        found.append(given or fits[0])
    return found[0], found[1]

"""Orbits of a shaft: as measured, and of one order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import permutations
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.measurement.spectrum import decay_rate
from autobalancer.measurement.tacho import with_rotor_angle
from autobalancer.measurement.tracking import fitted_orders, vibrations
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.results.labels import LABELS, labeled
from autobalancer.results.signals import Orders, Signals
from autobalancer.units import argument, optional_argument

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
    signals = Signals.given(signals, "orbit")
    x, y = _pair(signals, x, y)
    signals = with_rotor_angle(signals)
    time, angle = signals["time"].values, signals["rotor_angle"].values
    # whole revolutions around the instant, the middle of the record by default
    instant = optional_argument("at", at, "s")
    center = float(np.interp(0.5 * (time[0] + time[-1]) if instant is None else instant, time, angle))
    half = math.pi * revolutions
    if revolutions < 2.0 or center - half < angle[0] or center + half > angle[-1]:
        low, high = np.interp([angle[0] + half, angle[-1] - half], angle, time)
        raise QuestionError(
            f"at: with {revolutions:g} revolutions, at least 2, it must be from {low:.4g} s to {high:.4g} s"
        )
    # each order by least squares over the revolutions around the instant
    values = _along_axes(signals, x, y)
    wanted = np.array(sorted(orders), np.float64)
    tracked = fitted_orders(angle, values, wanted, np.array([center]), revolutions).amplitude[:, :, 0]
    inside = np.abs(angle - center) <= half
    turned = np.linspace(0.0, 2.0 * math.pi, POINTS)
    waves = tracked[:, :, None] * np.exp(1j * wanted[:, None, None] * turned)
    # two circles, with the rotor and against it, whose sum is the ellipse
    forward, backward = 0.5 * (tracked[:, 0] + 1j * tracked[:, 1]), 0.5 * np.conj(tracked[:, 0] - 1j * tracked[:, 1])
    sizes = np.abs(forward), np.abs(backward)
    minor = ("order", sizes[0] - sizes[1], "semi-minor axis, negative where it whirls backward", "m")
    own, both = "as measured, without the mean", ("order", "turned")
    moved = values[:, inside] - values[:, inside].mean(axis=1, keepdims=True)
    dataset = labeled(
        {
            "semi_major": ("order", sizes[0] + sizes[1], "semi-major axis", "m"),
            "semi_minor": minor,
            "tilt": ("order", 0.5 * np.angle(forward * backward), "direction of the major axis", "rad"),
            "forward": ("order", sizes[0], "circle with the rotor", "m"),
            "backward": ("order", sizes[1], "circle against it", "m"),
            **{name: ("time", row, own, "m") for name, row in zip("xy", moved, strict=True)},
            **{f"filtered_{name}": (both, waves[:, k].real, "of one order", "m") for k, name in enumerate("xy")},
        },
        {
            "order": ("order", wanted, "order of the rotor speed", "1"),
            "turned": ("turned", turned, "angle of the rotor", "rad"),
            "time": ("time", time[inside], "time", "s"),
        },
    )
    speed = float(np.interp(center, angle, signals["speed"].values))
    head = {
        "title": f"orbit of {x} and {y} at {float(np.interp(center, angle, time)):.4g} s",
        "speed": speed,
        "revolutions": revolutions,
    }
    return Labeled.of(dataset.assign_attrs(head | provenance()))


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


# The envelope of a measured run-up: least and greatest value in bins, named as in runs.


LEAST_BIN_SAMPLES = 4  # samples of a bin


def envelope(
    signals: xr.Dataset,
    channels: str | Sequence[str] | None = None,
    *,
    revolutions: float = 1.0,
    bin_length: float | str | None = None,
) -> xr.Dataset:
    """Least and greatest value of each channel in bins of so many revolutions, or of equal time.

    Parameters
    ----------
    signals
        With the angle of the rotor (``ab.measure.rotor_angle``), or a ``bin_length``.
    channels
        Names; by default all vibrations.
    revolutions
        Of a bin; at least one, so that a bin sees a whole turn.
    bin_length
        s, or a text; in place of revolutions.

    Returns
    -------
    xarray.Dataset
        Over bin: ``envelope_time`` (middle, s), ``envelope_end`` (s) and, with an angle, ``envelope_speed`` (rad/s); over
        (channel, bin): ``envelope_low`` and ``envelope_high`` (SI). The last bin is left out if it is not full.

    Raises
    ------
    QuestionError
        If there is neither an angle nor a length of bins, or bins have fewer than four samples.
    """
    signals = Signals.given(signals, "envelope")
    names, time = vibrations(signals, channels), signals["time"].values
    if bin_length is not None:
        numbers = np.floor((time - time[0]) / argument("bin_length", bin_length, "s") + 1e-9)
    elif "rotor_angle" not in signals:
        raise QuestionError("envelope: the signals have no angle; use ab.measure.rotor_angle, or give bin_length")
    elif not revolutions >= 1.0:
        raise QuestionError(f"revolutions: given {revolutions!r}; must be at least 1")
    else:
        turned = signals["rotor_angle"].values - signals["rotor_angle"].values[0]
        numbers = np.floor(turned / (2.0 * math.pi * revolutions) + 1e-9)
    starts = np.flatnonzero(np.diff(numbers, prepend=-1.0))
    if starts.size < 2 or np.diff(starts).min() < LEAST_BIN_SAMPLES:
        raise QuestionError(
            f"envelope: there must be at least two bins of {LEAST_BIN_SAMPLES} samples; change their length"
        )
    ends = time[starts[1:]]
    low, high = (
        np.array([cut.reduceat(signals[name].values, starts)[:-1] for name in names])
        for cut in (np.minimum, np.maximum)
    )
    entries = {"envelope_time": 0.5 * (time[starts[:-1]] + ends), "envelope_end": ends}
    if "speed" in signals:
        entries["envelope_speed"] = signals["speed"].values[starts[1:]]
    both = ("channel", "bin")
    data: dict[str, Any] = {
        key: ("bin", values, LABELS[key].long_name, LABELS[key].units) for key, values in entries.items()
    }
    data |= {
        "envelope_low": (both, low, "least value in the bin"),
        "envelope_high": (both, high, "greatest value in the bin"),
    }
    coordinates = {"channel": ("channel", names), "units": ("channel", [signals[n].attrs["units"] for n in names])}
    title = f"envelope of {signals.attrs.get('origin') or 'signals'}"
    return Labeled.of(labeled(data, coordinates, {"title": title} | provenance()))


# Damping from a decay, and from the width of a resonance.


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
    signals = Signals.given(signals, "damping")
    names = vibrations(signals, channel or None)
    if len(names) > 1:
        raise QuestionError(f"channel: there are several, {', '.join(names)}; choose one")
    time, values = signals["time"].values, signals[names[0]].values
    first, last = optional_argument("start", start, "s"), optional_argument("end", end, "s")
    if first is None:
        first = float(time[np.argmax(np.abs(values - np.median(values)))])
    kept = (time >= first) & (time <= (time[-1] if last is None else last))
    rate = decay_rate(time[kept], values[kept], modes, robust=robust)
    doubts = _doubts(rate)
    unit = {"units": str(signals[names[0]].attrs.get("units", ""))}
    for name in ("signal", "fitted", "amplitude", "amplitude_uncertainty"):
        rate[name].attrs |= unit
    origin = signals.attrs.get("origin", "")
    of = f" of {origin}" * bool(origin)
    title = f"decay of {names[0]}{of}; amplitude and phase at {time[kept][0]:.5g} s"  # where the fit begins
    return Labeled.of(rate.assign_attrs(title=title, channel=names[0], warnings="\n".join(doubts)))


def _doubts(dataset: xr.Dataset) -> list[str]:
    """Why a piece is probably no free decay: waves that the fit leaves, or a vibration that does not decay."""
    signal = dataset["signal"].values
    rest, size = signal - dataset["fitted"].values, float(np.std(signal))
    left, alike = float(np.std(rest)) / size, float(np.corrcoef(rest[1:], rest[:-1])[0, 1])
    doubts = []
    if left > WAVES and alike > 0.5:
        doubts.append(
            f"the fit leaves {100.0 * left:.3g} % of the signal, in waves and not as noise: the numbers are wrong if something "
            "still drives the vibration, or if there are more modes"
        )
    undamped = dataset["damping_ratio"].values < SURE * dataset["damping_ratio_uncertainty"].values
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
    dataset = labeled(
        {
            "frequency": ((), float(w[k]), "frequency of the peak", "rad/s"),
            "damping_ratio": ((), ratio, "damping ratio", ""),
            "damping_ratio_deviation": ((), deviation, "standard deviation of the damping ratio", ""),
        }
    )
    head = {"title": f"resonance of {name}", "warnings": "\n".join(texts)}
    return Labeled.of(dataset.assign_attrs(head | provenance()))


def _edge(w: Floats, size: Floats, k: int, level: float, side: int) -> tuple[float, float, int] | None:
    """Frequency at which the curve passes the level, its slope there, and the sample; None if it does not."""
    i = k
    while 0 <= i + side < w.size:
        if size[i + side] < level:
            slope = (size[i + side] - size[i]) / (w[i + side] - w[i])
            return float(w[i] + (level - size[i]) / slope), float(slope), i
        i += side
    return None

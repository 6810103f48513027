"""Pictures of measured signals and orders: each asks a public function and draws what it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.app.view.packed import Packer
from autobalancer.errors import QuestionError
from autobalancer.measurement.orbit import damping, orbit
from autobalancer.measurement.spectrum import order_map, spectrum
from autobalancer.measurement.tacho import rotor_angle
from autobalancer.measurement.tracking import orders
from autobalancer.measurement.tracking import vibrations as vibrations_of
from autobalancer.plots.fits import overlay as overlay_picture
from autobalancer.plots.signals import damping as damping_picture
from autobalancer.plots.signals import measured_orbit
from autobalancer.plots.signals import order_map as map_picture
from autobalancer.plots.signals import orders as orders_picture
from autobalancer.plots.signals import spectrum as spectrum_picture
from autobalancer.plots.style import INK, ball_color
from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit, length_axis
from autobalancer.results.signals import Signals
from autobalancer.units import argument, optional_argument

TURNING = ("tacho", "angle")
FigureAndText = tuple[Callable[[], Any], str]  # how the picture is drawn, and what is said in words


@dataclass
class PictureOptions:
    """What a person may say of a picture; empty for what the functions take by themselves."""

    channel: str = ""
    orders: str = "1, 2"
    slow_roll: str = ""
    revolutions: str = ""
    pulses: str = "1"
    tacho_angle: str = ""
    start: str = ""
    end: str = ""

    def numbers(self) -> tuple[float, ...]:
        """The orders.

        Raises
        ------
        QuestionError
            If one is no number.
        """
        try:
            return tuple(float(word) for word in self.orders.replace(";", ",").split(",") if word.strip())
        except ValueError:
            raise QuestionError(f"orders: given {self.orders!r}; write numbers such as 1, 2") from None

    def turned(self, signals: xr.Dataset) -> xr.Dataset:
        """The signals with the angle of the rotor.

        Raises
        ------
        QuestionError
            If there is no tacho, or it has no pulses.
        """
        pulses = int(_number("pulses", self.pulses or "1"))
        return rotor_angle(signals, pulses=pulses, tacho_angle=self.tacho_angle.strip() or None)

    def piece(self, signals: xr.Dataset) -> xr.Dataset:
        """The part from ``start`` to ``end``.

        Raises
        ------
        QuestionError
            If it has hardly any samples.
        """
        time = signals["time"].values
        low, high = (optional_argument(key, getattr(self, key).strip() or None, "s") for key in ("start", "end"))
        inside = (time >= (-np.inf if low is None else low)) & (time <= (np.inf if high is None else high))
        if inside.sum() < 8:
            raise QuestionError(f"from, to: no samples there; there are {time[0]:.6g} s to {time[-1]:.6g} s")
        return Signals.of(signals.isel(time=inside))


def tracked(signals: xr.Dataset, asked: PictureOptions) -> xr.Dataset:
    """Amplitude and phase of the orders of all vibrations of one unit.

    Raises
    ------
    QuestionError
        If there is no tacho, or an order is not possible.
    """
    options: dict[str, Any] = {"slow_roll": asked.slow_roll.strip() or None}
    if asked.revolutions.strip():
        options["revolutions"] = _number("revolutions", asked.revolutions)
    return orders(asked.turned(signals), asked.numbers(), channels=_channels_of_unit(signals, asked.channel), **options)


def _of_orders(data: xr.Dataset, asked: PictureOptions) -> FigureAndText:
    found = tracked(asked.piece(data), asked)
    return lambda: orders_picture(found), found.told()


def _of_map(over: str) -> Callable[[xr.Dataset, PictureOptions], FigureAndText]:
    def of(data: xr.Dataset, asked: PictureOptions) -> FigureAndText:
        options: dict[str, Any] = {"over": over}
        if asked.revolutions.strip():
            options["revolutions"] = _number("revolutions", asked.revolutions)
        found = order_map(asked.turned(asked.piece(data)), asked.channel, **options)
        return lambda: map_picture(found, orders=asked.numbers()), ""

    return of


def _of_spectrum(data: xr.Dataset, asked: PictureOptions) -> FigureAndText:
    part = asked.piece(data)
    known = asked.turned(part) if turning(data) else part
    found = spectrum(known, _channels_of_unit(data, asked.channel))
    return lambda: spectrum_picture(found), found.told()


def _of_orbit(data: xr.Dataset, asked: PictureOptions) -> FigureAndText:
    options: dict[str, Any] = {"orders": asked.numbers()}
    if asked.revolutions.strip():
        options["revolutions"] = _number("revolutions", asked.revolutions)
    found = orbit(asked.turned(data), at=asked.start.strip() or None, **options)
    return lambda: measured_orbit(found), found.told()


def _of_decay(data: xr.Dataset, asked: PictureOptions) -> FigureAndText:
    found = damping(data, asked.channel, start=asked.start.strip() or None, end=asked.end.strip() or None)
    return lambda: damping_picture(found), found.told()


LOOKS: dict[str, tuple[str, Callable[[xr.Dataset, PictureOptions], FigureAndText]]] = {
    "orders": ("Orders over the speed", _of_orders),
    "map": ("Order map", _of_map("order")),
    "frequencies": ("Frequency map", _of_map("frequency")),
    "spectrum": ("Spectrum", _of_spectrum),
    "orbit": ("Orbit", _of_orbit),
    "damping": ("Damping of a decay", _of_decay),
}


def turning(signals: xr.Dataset) -> bool:
    """Whether the signals say how the rotor turns."""
    return any(one.attrs.get("quantity") in TURNING for one in signals.data_vars.values())


def vibrations(signals: xr.Dataset) -> list[str]:
    """Names of the vibrations; empty if there is none."""
    try:
        return vibrations_of(signals, None)
    except QuestionError:
        return []


def order_table(found: xr.Dataset) -> Callable[[], Any]:
    """The picture of orders from a table over the speed."""
    places = zip(found["place"].values, found["direction"].values, strict=True)
    names = [f"{way} at {place}" if str(place) else str(way) for place, way in places]
    both = ("order", "channel", "time")
    rows = {key: (both, found[key].transpose("channel", "speed").values[None]) for key in ("amplitude", "phase")}
    spread = found["amplitude_deviation"].transpose("channel", "speed").values[None]
    size = rows["amplitude"][1]
    rows |= {
        "amplitude_deviation": (both, np.nan_to_num(spread)),
        "phase_deviation": (both, np.nan_to_num(spread / size)),
    }
    units = [str(found["amplitude"].attrs.get("units", ""))] * len(names)
    known = xr.Dataset(
        rows,
        {"order": [1.0], "channel": names, "units": ("channel", units), "speed": ("time", found["speed"].values)},
        {"title": "orders", "method": "as in the table"},
    )
    return lambda: orders_picture(known)


def _channels_of_unit(signals: xr.Dataset, channel: str) -> list[str] | None:
    """The chosen channel, else all vibrations of the unit of the first."""
    if channel:
        return [channel]
    names = vibrations(signals)
    return [name for name in names if signals[name].attrs["units"] == signals[names[0]].attrs["units"]] or None


def _number(name: str, text: str) -> float:
    return float(argument(name, text.strip(), ""))


# A measurement beside a run of the archive, and the measured speed as the drive of a machine.


POINTS, SAMPLES = 60, 6000  # of a speed profile, and of the angle that it follows


def picture(found: Answer) -> Callable[[], Any]:
    """Both in one picture."""
    return lambda: overlay_picture(found)


def drive_of(measured: xr.Dataset, asked: PictureOptions) -> tuple[dict[str, Any], str]:
    """The measured turning of the rotor: a speed profile of a machine file, and the angle of the rotor at time zero.

    The speeds at some times, straight in between, are those whose angle is nearest to the measured one.

    Raises
    ------
    QuestionError
        If the measurement does not say how the rotor turned.
    """
    turned = asked.turned(measured)
    thin = slice(None, None, max(1, turned.sizes["time"] // SAMPLES))
    time, angle = turned["time"].values[thin], turned["rotor_angle"].values[thin]
    knots = np.linspace(time[0], time[-1], POINTS)
    parts = np.array([np.interp(time, knots, row) for row in np.eye(POINTS)]).T
    steps = 0.5 * np.diff(time)[:, None] * (parts[1:] + parts[:-1])
    turns = np.vstack([np.zeros(POINTS), np.cumsum(steps, axis=0)])
    first, *speeds = np.linalg.lstsq(np.column_stack([np.ones(time.size), turns]), angle, rcond=None)[0]
    begin = (first - speeds[0] * time[0] + np.pi) % (2.0 * np.pi) - np.pi
    profile = {
        "kind": "table",
        "time": [f"{t:.6g} s" for t in knots],
        "speed": [f"{max(w, 0.0):.8g} rad/s" for w in speeds],
    }
    return profile, f"{np.degrees(begin):.5g} deg"


# Measured signals as a block of bytes whose waveforms the browser draws and zooms.


WHOLE = 60_000  # samples of a channel that are sent as they are
BINS = 20_000  # of more samples least and greatest value are sent in so many bins
PANELS = 8


def wave_block(signals: xr.Dataset) -> bytes:
    """The channels of signals over time, those of one quantity in one panel.

    Raises
    ------
    QuestionError
        If there are no samples over time.
    """
    if "time" not in signals.dims:
        raise QuestionError("these are no signals over time")
    time = np.asarray(signals["time"].values, np.float64)
    out = Packer({"kind": "signals", "panels": []})
    out.add("time", time[[0, -1]], "float64")
    binned = time.size > WHOLE
    edges = np.unique(np.linspace(0, time.size, BINS + 1).astype(int))
    at = 0.5 * (time[edges[:-1]] + time[edges[1:] - 1]) if binned else time
    out.add("t", at, "float64")
    groups: dict[tuple[str, str], list[str]] = {}
    for name, one in signals.data_vars.items():
        if one.dims == ("time",):
            groups.setdefault((str(one.attrs.get("quantity", name)), str(one.attrs.get("units", ""))), []).append(
                str(name)
            )
    for (title, _), names in list(groups.items())[:PANELS]:
        most = max(float(np.abs(signals[name].values).max()) for name in names)
        lines: list[dict[str, Any]] = []
        for k, name in enumerate(names):
            one = signals[name]
            unit = length_axis(None, most or 1.0) if one.attrs.get("units") == "m" else axis_unit(one, "rpm")
            values = np.asarray(unit.shown(one.values), np.float64)
            line = {"name": name, "color": ball_color(k) if len(names) > 1 else INK, "t": "t"}
            cuts = {"high": np.maximum, "low": np.minimum} if binned else {"high": None}
            for key, cut in cuts.items():
                out.add(f"{key} {name}", values if cut is None else cut.reduceat(values, edges[:-1]))
                line[key] = f"{key} {name}"
            lines.append(line)
        out.head["panels"].append({"title": title, "unit": unit.sign, "lines": lines, "limits": None})
    return out.bytes

"""Pictures of measured signals and orders: each asks a public function and draws what it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.angle import rotor_angle
from autobalancer.measurement.orders.question import orders
from autobalancer.measurement.orders.question import vibrations as vibrations_of
from autobalancer.measurement.spectra.damping import damping
from autobalancer.measurement.spectra.orbit import orbit
from autobalancer.measurement.spectra.order_map import order_map
from autobalancer.measurement.spectra.spectrum import spectrum
from autobalancer.plots.signals.decay import damping as damping_picture
from autobalancer.plots.signals.decay import measured_orbit
from autobalancer.plots.signals.orders import orders as orders_picture
from autobalancer.plots.signals.spectrum import order_map as map_picture
from autobalancer.plots.signals.spectrum import spectrum as spectrum_picture
from autobalancer.results.signals.signals import Signals
from autobalancer.units import argument, optional_argument

TURNING = ("tacho", "angle")
Drawn = tuple[Callable[[], Any], str]  # how the picture is drawn, and what is said in words


@dataclass
class Asked:
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


def tracked(signals: xr.Dataset, asked: Asked) -> xr.Dataset:
    """Amplitude and phase of the orders of all vibrations of one unit.

    Raises
    ------
    QuestionError
        If there is no tacho, or an order is not possible.
    """
    options: dict[str, Any] = {"slow_roll": asked.slow_roll.strip() or None}
    if asked.revolutions.strip():
        options["revolutions"] = _number("revolutions", asked.revolutions)
    return orders(asked.turned(signals), asked.numbers(), channels=_alike(signals, asked.channel), **options)


def _of_orders(data: xr.Dataset, asked: Asked) -> Drawn:
    found = tracked(asked.piece(data), asked)
    return lambda: orders_picture(found), found.told()


def _of_map(over: str) -> Callable[[xr.Dataset, Asked], Drawn]:
    def of(data: xr.Dataset, asked: Asked) -> Drawn:
        options: dict[str, Any] = {"over": over}
        if asked.revolutions.strip():
            options["revolutions"] = _number("revolutions", asked.revolutions)
        found = order_map(asked.turned(asked.piece(data)), asked.channel, **options)
        return lambda: map_picture(found, orders=asked.numbers()), ""

    return of


def _of_spectrum(data: xr.Dataset, asked: Asked) -> Drawn:
    part = asked.piece(data)
    known = asked.turned(part) if turning(data) else part
    found = spectrum(known, _alike(data, asked.channel))
    return lambda: spectrum_picture(found), found.told()


def _of_orbit(data: xr.Dataset, asked: Asked) -> Drawn:
    options: dict[str, Any] = {"orders": asked.numbers()}
    if asked.revolutions.strip():
        options["revolutions"] = _number("revolutions", asked.revolutions)
    found = orbit(asked.turned(data), at=asked.start.strip() or None, **options)
    return lambda: measured_orbit(found), found.told()


def _of_decay(data: xr.Dataset, asked: Asked) -> Drawn:
    found = damping(data, asked.channel, start=asked.start.strip() or None, end=asked.end.strip() or None)
    return lambda: damping_picture(found), found.told()


LOOKS: dict[str, tuple[str, Callable[[xr.Dataset, Asked], Drawn]]] = {
    "orders": ("Orders over the speed", _of_orders),
    "map": ("Order map", _of_map("order")),
    "frequencies": ("Frequency map", _of_map("frequency")),
    "spectrum": ("Spectrum", _of_spectrum),
    "orbit": ("Orbit", _of_orbit),
    "damping": ("Damping of a decay", _of_decay),
}


def looked(data: xr.Dataset, name: str, asked: Asked) -> Drawn:
    """One of the pictures.

    Raises
    ------
    QuestionError
        If the signals do not suffice, in the words of the function that is asked.
    """
    return LOOKS[name][1](data, asked)


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


def _alike(signals: xr.Dataset, channel: str) -> list[str] | None:
    """The chosen channel, else all vibrations of the unit of the first."""
    if channel:
        return [channel]
    names = vibrations(signals)
    return [name for name in names if signals[name].attrs["units"] == signals[names[0]].attrs["units"]] or None


def _number(name: str, text: str) -> float:
    return float(argument(name, text.strip(), ""))

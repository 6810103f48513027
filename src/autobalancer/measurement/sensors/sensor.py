"""Sensors and tachos as they are mounted, with what they do to a signal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from autobalancer.errors import QuestionError
from autobalancer.units import argument

Quantity = Literal["displacement", "velocity", "acceleration", "force"]
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "force": "N"}
DEGREES = math.pi / 180.0


@dataclass(frozen=True)
class Sensor:
    """One sensor in one direction. Numbers are SI; texts may have a unit.

    Parameters
    ----------
    quantity
        displacement, velocity or acceleration of the rotor in space, or force of the rotor on a support.
    place
        Name of a station or plane, for a force of a support; by default the reference station, or the only support.
    direction
        "x", "y", or an angle from x in degrees.
    name
        Of the channel; by default made of quantity, place and direction.
    noise
        Standard deviation of white noise, or a signal-to-noise ratio such as "40 dB", that of the root mean squares of signal
        and noise over the whole record.
    noise_density
        Of white noise in its place, SI unit per root of Hz, one-sided.
    sensitivity
        Reading over true value: 1.02 reads 2 % too much.
    offset
        Added to every reading.
    limit
        Readings beyond plus or minus this are clipped.
    runout
        Of the surface that a displacement sensor sees: (order, amplitude, angle of its highest point in the rotor, rad) of each
        part.
    step
        Smallest difference of readings; 0 for none.
    low_pass
        Corner frequency (Hz) of a Butterworth filter of order 2 in front of the logger; its lag is in the signal.
    """

    quantity: Quantity
    place: str = ""
    direction: str | float = "x"
    name: str = ""
    noise: float | str = 0.0
    noise_density: float = 0.0
    sensitivity: float = 1.0
    offset: float | str = 0.0
    limit: float | str = math.inf
    runout: Sequence[tuple[int, float | str, float]] = ()
    step: float | str = 0.0
    low_pass: float | str | None = None

    def __post_init__(self) -> None:
        if self.quantity not in get_args(Quantity):
            raise QuestionError(
                f"sensor: quantity: given {self.quantity!r}; must be one of {', '.join(get_args(Quantity))}"
            )
        unit = UNITS[self.quantity]
        for key in ("offset", "limit", "step"):
            object.__setattr__(self, key, argument(f"sensor: {key}", getattr(self, key), unit))
        if not self.decibels:
            object.__setattr__(self, "noise", argument("sensor: noise", self.noise, unit))
        if self.runout and self.quantity != "displacement":
            raise QuestionError(f"sensor: runout is seen by a displacement sensor only, not by one of {self.quantity}")
        parts = tuple((order, argument("sensor: runout", size, "m"), float(at)) for order, size, at in self.runout)
        object.__setattr__(self, "runout", parts)
        object.__setattr__(self, "low_pass", None if self.low_pass is None else hertz("low_pass", self.low_pass))
        self._check()

    def _check(self) -> None:
        noise = 0.0 if self.decibels else float(self.noise)
        for key, value in (("noise", noise), ("noise_density", self.noise_density), ("step", float(self.step))):
            if not (math.isfinite(value) and value >= 0.0):
                raise QuestionError(f"sensor: {key}: given {value:g}; must not be negative")
        if not (math.isfinite(self.sensitivity) and self.sensitivity != 0.0):
            raise QuestionError(
                f"sensor: sensitivity: given {self.sensitivity:g}; it is reading over true value, about 1"
            )
        if not math.isfinite(float(self.offset)) or not float(self.limit) > 0.0:
            raise QuestionError("sensor: the offset must be finite and the limit greater than zero")
        if (bool(self.noise) or self.decibels != "") and self.noise_density:
            raise QuestionError("sensor: give noise or noise_density, not both")
        self.angle  # noqa: B018 - refuses an impossible direction

    @property
    def decibels(self) -> str:
        """The number before "dB" where the noise is given so, else empty."""
        text = str(self.noise).strip() if isinstance(self.noise, str) else ""
        return text[:-2].strip() if text.lower().endswith("db") else ""

    @property
    def angle(self) -> float:
        """Of the direction from x, rad."""
        if self.direction in ("x", "y"):
            return 0.0 if self.direction == "x" else 0.5 * math.pi
        try:
            found = float(self.direction)
        except ValueError:
            found = math.nan
        if not math.isfinite(found):
            raise QuestionError(
                f"sensor: direction: given {self.direction!r}; must be x, y or a number of degrees from x"
            )
        return found * DEGREES

    @property
    def along(self) -> str | float:
        """The direction as signals have it."""
        return self.direction if self.direction in ("x", "y") else float(self.direction)

    @property
    def channel(self) -> str:
        """Name of the channel."""
        along = self.along if isinstance(self.along, str) else f"{self.along:g}_deg".replace("-", "minus_")
        return self.name or "_".join(part.replace(" ", "_") for part in (self.quantity, self.place, along) if part)


@dataclass(frozen=True)
class Tacho:
    """A pulse each time a mark of the rotor passes.

    Parameters
    ----------
    pulses
        In one turn. The first mark is the zero mark of the rotor.
    angle
        Where the tacho stands, degrees from x.
    missing
        Share of pulses that are lost, at random.
    jitter
        Standard deviation of the instant of a pulse, s.
    level
        Of a pulse above zero, V.
    noise
        Standard deviation of white noise, V.
    name
        Of the channel.
    """

    pulses: int = 1
    angle: float = 0.0
    missing: float = 0.0
    jitter: float | str = 0.0
    level: float = 5.0
    noise: float = 0.0
    name: str = "tacho"

    def __post_init__(self) -> None:
        if isinstance(self.pulses, bool) or not isinstance(self.pulses, int) or self.pulses < 1:
            raise QuestionError(f"tacho: pulses: given {self.pulses!r}; must be a whole number from 1")
        object.__setattr__(self, "jitter", argument("tacho: jitter", self.jitter, "s"))
        if not 0.0 <= self.missing < 1.0:
            raise QuestionError(f"tacho: missing: given {self.missing:g}; must be a share from 0 to less than 1")
        numbers = (float(self.jitter), self.noise, self.level, self.angle)
        if not all(map(math.isfinite, numbers)) or min(numbers[:2]) < 0.0 or self.level <= 0.0:
            raise QuestionError("tacho: jitter and noise must not be negative, and the level must be greater than zero")


def hertz(name: str, value: float | str) -> float:
    """A frequency in cycles per second, of a number in Hz or a text with a unit.

    Raises
    ------
    QuestionError
        If it is not greater than zero.
    """
    found = argument(name, value, "rad/s") / (2.0 * math.pi) if isinstance(value, str) else argument(name, value, "Hz")
    if not (math.isfinite(found) and found > 0.0):
        raise QuestionError(f"{name}: given {found:g} Hz; must be greater than zero")
    return found

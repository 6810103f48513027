"""What shakes a machine from outside: motion of its base, and forces on its rotor."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Angle, Positive, Quantity, Speed, Time
from autobalancer.machine.station import Place

BaseAcceleration = Annotated[float, Quantity("m/s^2")]
BaseDisplacement = Annotated[float, Quantity("m", non_negative=True)]
Newton = Annotated[float, Quantity("N")]

PACE = "of a steady vibration, as turns of its own: 10 Hz is 62.83 rad/s; this or `order`"
ORDER = "cycles per turn of the rotor, any number above zero: 1 is synchronous; in place of a frequency"
PHASE = "at time zero; with an `order`, at rotor angle zero"
DIRECTION = "in space, from the x axis"
RECORD = "must increase; no excitation before the first and after the last time"
PUSHED = "where the force acts: a position, or the name of a station; not needed on a planar rotor"


def _one_pace(frequency: float | None, order: float | None) -> None:
    if (frequency is None) == (order is None):
        raise ValueError("give either 'frequency', or 'order' (per turn of the rotor)")


def _recorded(time: tuple[float, ...], values: tuple[float, ...], name: str) -> None:
    if len(time) < 2 or len(time) != len(values):
        raise ValueError(
            f"{name}: given {len(values)} values at {len(time)} times; give the same number of both, at least two"
        )
    if any(b <= a for a, b in pairwise(time)):
        raise ValueError("time: must increase")


class BaseMotion(Part):
    """The base moves to and fro along ``direction`` (from the x axis): amplitude cos(2 pi f t + phase).

    The amplitude is that of the ``acceleration`` or of the ``displacement``. Deflections are then relative to the base.
    """

    kind: Literal["base_motion"] = "base_motion"
    acceleration: BaseAcceleration | None = key("amplitude; this or `displacement`", None)
    displacement: BaseDisplacement | None = key("amplitude; requires a `frequency`", None)
    frequency: Speed | None = key(PACE, None)
    order: Positive | None = key(ORDER, None)
    phase: Angle = key(PHASE, 0.0)
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> BaseMotion:
        if (self.acceleration is None) == (self.displacement is None):
            raise ValueError("give either 'acceleration' or 'displacement'")
        _one_pace(self.frequency, self.order)
        if self.displacement is not None and self.frequency is None:
            raise ValueError("displacement: needs a fixed 'frequency'; give the 'acceleration' with an 'order'")
        return self


class RecordedBaseMotion(Part):
    """A measured acceleration of the base along ``direction``; zero outside its times."""

    kind: Literal["recorded_base_motion"] = "recorded_base_motion"
    time: Annotated[tuple[Time, ...], Listed] = key(RECORD)
    acceleration: Annotated[tuple[BaseAcceleration, ...], Listed] = key(
        "as many as times; a smooth curve goes through them"
    )
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _consistent(self) -> RecordedBaseMotion:
        _recorded(self.time, self.acceleration, "acceleration")
        return self


class HarmonicForce(Part):
    """A force on the rotor at a station, along ``direction`` in space: amplitude cos(2 pi f t + phase)."""

    kind: Literal["force"] = "force"
    station: Place | None = key(PUSHED, None)
    force: Newton = key("amplitude")
    frequency: Speed | None = key(PACE, None)
    order: Positive | None = key(ORDER, None)
    phase: Angle = key(PHASE, 0.0)
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> HarmonicForce:
        _one_pace(self.frequency, self.order)
        return self


class RecordedForce(Part):
    """A measured force on the rotor at a station; zero outside its times."""

    kind: Literal["recorded_force"] = "recorded_force"
    station: Place | None = key(PUSHED, None)
    time: Annotated[tuple[Time, ...], Listed] = key(RECORD)
    force: Annotated[tuple[Newton, ...], Listed] = key("as many as times; a smooth curve goes through them")
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _consistent(self) -> RecordedForce:
        _recorded(self.time, self.force, "force")
        return self


Excitation = Annotated[BaseMotion | RecordedBaseMotion | HarmonicForce | RecordedForce, Field(discriminator="kind")]

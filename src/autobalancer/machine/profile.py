"""Speed over time, as an engineer would say it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Acceleration, Duration, Positive, Speed, Time


class Constant(Part):
    """One speed for ever."""

    kind: Literal["constant"] = "constant"
    speed: Speed = key("from the start on")


class Ramp(Part):
    """From ``start`` to ``end`` at a steady rate within ``duration``, after an optional ``delay``; then constant."""

    kind: Literal["ramp"] = "ramp"
    start: Speed = key("before the ramp", 0.0)
    end: Speed = key("after the ramp")
    duration: Duration = key("of the ramp")
    delay: Time = key("before the ramp", 0.0)


class Table(Part):
    """Speeds at times, straight in between, constant outside. The times must increase."""

    kind: Literal["table"] = "table"
    time: Annotated[tuple[Time, ...], Listed] = key("must increase")
    speed: Annotated[tuple[Speed, ...], Listed] = key("as many as times, linear in between, constant outside")

    @model_validator(mode="after")
    def _consistent(self) -> Table:
        if not self.time:
            raise ValueError("time: the profile is empty; give at least one time and one speed")
        if len(self.time) != len(self.speed):
            raise ValueError(f"given {len(self.time)} times and {len(self.speed)} speeds; give the same number of both")
        if any(b <= a for a, b in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("time: must increase from entry to entry")
        return self


class Dwell(Part):
    """Hold each of ``speeds`` for ``hold``, and change between them at the rate ``acceleration``."""

    kind: Literal["dwell"] = "dwell"
    speeds: Annotated[tuple[Speed, ...], Field(min_length=1), Listed] = key(
        "one after the other; the first one from the start on"
    )
    hold: Duration = key("at each speed")
    acceleration: Acceleration = key("from one to the next, up or down")


class Hill(Part):
    """S-shaped run-up: start + (end - start) t^n / (half_time^n + t^n), half way at ``half_time``."""

    kind: Literal["hill"] = "hill"
    start: Speed = key("at time zero", 0.0)
    end: Speed = key("approached at late times")
    half_time: Duration = key("when half of the change is done")
    exponent: Positive = key("$n$, at least 1")

    @model_validator(mode="after")
    def _finite_jerk(self) -> Hill:
        if self.exponent < 1.0:
            raise ValueError(
                f"exponent: given {self.exponent:g}; must be at least 1, otherwise the initial acceleration is infinite"
            )
        return self


class Reduction(Part):
    """A run-up with a temporary reduction, which lets the balls find better places.

    Up to ``peak``, hold, down to ``reduced``, hold, up to ``end``; all changes at the rate ``acceleration``. With
    ``dwell`` it also waits at that speed on the way to ``peak``.
    """

    kind: Literal["reduction"] = "reduction"
    start: Speed = key("at time zero", 0.0)
    peak: Speed = key("first speed")
    reduced: Speed = key("second speed")
    end: Speed = key("last speed")
    acceleration: Acceleration = key("of all changes, up or down")
    hold_peak: Time = key("time at the first speed", 0.0)
    hold_reduced: Time = key("time at the second speed", 0.0)
    dwell: Speed | None = key("speed at which it waits on the way to the first speed", None)
    hold_dwell: Time = key("time at that speed", 0.0)

    @model_validator(mode="after")
    def _waits_somewhere(self) -> Reduction:
        if self.hold_dwell > 0.0 and self.dwell is None:
            raise ValueError("hold_dwell: needs 'dwell', the speed at which the rotor waits")
        return self


Profile = Annotated[Constant | Ramp | Table | Dwell | Hill | Reduction, Field(discriminator="kind")]

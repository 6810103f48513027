"""Speed over time, as an engineer would say it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Acceleration, Duration, Listed, Part, Positive, Speed, Time


class Constant(Part):
    """One speed for ever."""

    kind: Literal["constant"] = "constant"
    speed: Speed


class Ramp(Part):
    """From ``start`` to ``end`` at a steady rate within ``duration``, after an optional ``delay``; then constant."""

    kind: Literal["ramp"] = "ramp"
    start: Speed = 0.0
    end: Speed
    duration: Duration
    delay: Time = 0.0


class Table(Part):
    """Speeds at times, straight in between, constant outside. The times must increase."""

    kind: Literal["table"] = "table"
    time: Annotated[tuple[Time, ...], Listed]
    speed: Annotated[tuple[Speed, ...], Listed]

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
    speeds: Annotated[tuple[Speed, ...], Listed, Field(min_length=1)]
    hold: Duration
    acceleration: Acceleration


class Hill(Part):
    """S-shaped run-up: start + (end - start) t^n / (half_time^n + t^n), half way at ``half_time``."""

    kind: Literal["hill"] = "hill"
    start: Speed = 0.0
    end: Speed
    half_time: Duration
    exponent: Positive

    @model_validator(mode="after")
    def _finite_jerk(self) -> Hill:
        if self.exponent < 1.0:
            raise ValueError(
                f"exponent: given {self.exponent:g}; must be at least 1, otherwise the initial acceleration is infinite"
            )
        return self


class Reduction(Part):
    """A run-up with a temporary reduction, which lets the balls find better places.

    Up to ``peak``, hold, down to ``reduced``, hold, up to ``end``; all changes at the rate ``acceleration``.
    """

    kind: Literal["reduction"] = "reduction"
    start: Speed = 0.0
    peak: Speed
    reduced: Speed
    end: Speed
    acceleration: Acceleration
    hold_peak: Time = 0.0
    hold_reduced: Time = 0.0


Profile = Annotated[Constant | Ramp | Table | Dwell | Hill | Reduction, Field(discriminator="kind")]

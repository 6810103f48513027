"""Events: a quantity passes a level; the run notes it or ends there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autobalancer.errors import QuestionError
from autobalancer.kernels import events as kinds
from autobalancer.units import to_si

_KINDS = {
    "deflection": kinds.DEFLECTION,
    "speed": kinds.ROTOR_SPEED,
    "ball_speed_in_rotor": kinds.BALL_SPEED_IN_ROTOR,
    "ball_speed_in_space": kinds.BALL_SPEED_IN_SPACE,
    "fastest_ball_in_rotor": kinds.FASTEST_BALL,
}


@dataclass(frozen=True)
class Event:
    """The passage of ``quantity`` through ``level`` (SI).

    Parameters
    ----------
    quantity
        ``deflection``, ``speed``, ``ball_speed_in_rotor``, ``ball_speed_in_space`` (these two of one ``ball``, counted
        from 1) or ``fastest_ball_in_rotor`` (the greatest amount among all balls).
    level
        m or rad/s, or a text with a unit.
    direction
        Direction of the passage.
    ends_run
        Whether the run stops there.

    Raises
    ------
    QuestionError
        For an unknown quantity or a missing ball.
    """

    quantity: Literal["deflection", "speed", "ball_speed_in_rotor", "ball_speed_in_space", "fastest_ball_in_rotor"]
    level: float | str
    direction: Literal["rising", "falling", "both"] = "both"
    ends_run: bool = False
    ball: int | None = None

    def __post_init__(self) -> None:
        if self.quantity not in _KINDS:
            raise QuestionError(f"event: unknown quantity {self.quantity!r}; known: {', '.join(_KINDS)}")
        object.__setattr__(self, "level", to_si(self.level, "m" if self.quantity == "deflection" else "rad/s"))
        if self.quantity in ("ball_speed_in_rotor", "ball_speed_in_space") and self.ball is None:
            raise QuestionError(f"event on {self.quantity}: say which ball, counted from 1")

    @property
    def name(self) -> str:
        """For the result: ``speed rising through 250``."""
        ball = f" of ball {self.ball}" if self.ball is not None else ""
        way = "" if self.direction == "both" else f" {self.direction}"
        return f"{self.quantity}{ball}{way} through {float(self.level):g}"

    @property
    def numbers(self) -> tuple[int, int, float, int, int]:
        """Kind, ball, level, direction and end as the kernel wants them."""
        way = {"rising": 1, "falling": -1, "both": 0}[self.direction]
        return _KINDS[self.quantity], (self.ball or 0) - 1, float(self.level), way, int(self.ends_run)

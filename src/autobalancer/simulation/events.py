"""Events: a quantity passes a level; the run notes it or ends there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators.passages import GREATEST, LENGTH, SUM
from autobalancer.kernels.system import BALLS, SPEED, X, Y
from autobalancer.units import to_si

QUANTITIES = ("deflection", "speed", "ball_speed_in_rotor", "ball_speed_in_space", "fastest_ball_in_rotor")


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
        if self.quantity not in QUANTITIES:
            raise QuestionError(f"event: unknown quantity {self.quantity!r}; known: {', '.join(QUANTITIES)}")
        object.__setattr__(self, "level", to_si(self.level, "m" if self.quantity == "deflection" else "rad/s"))
        if self.quantity in ("ball_speed_in_rotor", "ball_speed_in_space") and self.ball is None:
            raise QuestionError(f"event on {self.quantity}: say which ball, counted from 1")

    @property
    def name(self) -> str:
        """For the result: ``speed rising through 250``."""
        ball = f" of ball {self.ball}" if self.ball is not None else ""
        way = "" if self.direction == "both" else f" {self.direction}"
        return f"{self.quantity}{ball}{way} through {float(self.level):g}"

    def quantity_of(self, balls: int) -> tuple[int, int, int]:
        """The quantity of a machine with so many balls, and its components of the state: kernels/integrators/passages.py."""
        own = BALLS + balls + (self.ball or 1) - 1
        return {
            "deflection": (LENGTH, X, Y),
            "speed": (SUM, SPEED, -1),
            "ball_speed_in_rotor": (SUM, own, -1),
            "ball_speed_in_space": (SUM, own, SPEED),
            "fastest_ball_in_rotor": (GREATEST, BALLS + balls, BALLS + 2 * balls),
        }[self.quantity]

    @property
    def way(self) -> int:
        """+1 for a rising passage, -1 for a falling one, 0 for both."""
        return {"rising": 1, "falling": -1, "both": 0}[self.direction]

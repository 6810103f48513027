"""What a solver records at every step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from autobalancer.flow.annulus import Floats

Progress = Callable[[float, float], None]


@dataclass
class Track:
    """Time, speed of the rotor and angular velocity of the fluid at the orbit (rad/s), step by step."""

    times: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    orbit: list[float] = field(default_factory=list)
    steps: int = 0
    rejected: int = 0

    def note(self, time: float, speed: float, lag: float) -> None:
        """One more instant; ``lag`` is relative to the rotor."""
        self.times.append(time)
        self.speeds.append(speed)
        self.orbit.append(speed + lag)

    def arrays(self) -> tuple[Floats, Floats, Floats]:
        """The same as arrays."""
        return np.array(self.times), np.array(self.speeds), np.array(self.orbit)

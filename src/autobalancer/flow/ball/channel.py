"""The race as a ball sees it: a channel, straight or bent, with the ball near its outer wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalancer.errors import MachineError
from autobalancer.flow.annulus import walls_of
from autobalancer.machine import Machine
from autobalancer.units import field_arguments


@dataclass(frozen=True)
class Channel:
    """A race of rectangular cross-section, seen from one of its balls.

    Parameters
    ----------
    ball_diameter
        m.
    width, height
        Of the cross-section: radially and along the axis, m.
    orbit_radius
        Of the ball centers, m; infinite if the channel is straight.
    length_per_ball
        Of the orbit, m. Balls push the fluid around a closed race, the less the longer it is for each of them; infinite if the
        fluid far away moves with the walls.

    Raises
    ------
    MachineError
        If the ball does not fit into the cross-section, or the orbit into the machine.
    """

    ball_diameter: float
    width: float
    height: float
    orbit_radius: float = math.inf
    length_per_ball: float = math.inf

    def __post_init__(self) -> None:
        field_arguments(self, ball_diameter="m", width="m", height="m", orbit_radius="m", length_per_ball="m")
        if not (self.ball_diameter > 0.0 and math.isfinite(self.ball_diameter)):
            raise MachineError(f"channel: given a ball diameter of {self.ball_diameter:g} m; must be positive")
        for name in ("width", "height"):
            length = getattr(self, name)
            if not (length > self.ball_diameter and math.isfinite(length)):
                raise MachineError(
                    f"channel: given a {name} of {1e3 * length:.4g} mm for a ball of {1e3 * self.ball_diameter:.4g} mm; "
                    "must be larger than the ball and finite"
                )
        if not self.orbit_radius + 0.5 * self.ball_diameter > self.width:
            raise MachineError(
                f"channel: given an orbit radius of {1e3 * self.orbit_radius:.4g} mm and a width of "
                f"{1e3 * self.width:.4g} mm, so the inner wall has no radius left; take a narrower race"
            )

        whole, length = 2.0 * math.pi * self.orbit_radius * (1.0 + 1e-9), self.length_per_ball
        if not self.ball_diameter < length or whole < length < math.inf:
            raise MachineError(
                f"channel: given {1e3 * self.length_per_ball:.4g} mm of orbit for each ball; must be more than its diameter, and "
                "at most the whole orbit, or infinite"
            )

    @property
    def ball_radius(self) -> float:
        """m."""
        return 0.5 * self.ball_diameter


def channel_of(machine: Machine, balancer: int = 1, race: int = 1) -> Channel:
    """The ``race`` of a ``balancer`` of ``machine``, counted from 1, as its largest ball sees it, all balls spread evenly."""
    walls = walls_of(machine, balancer, race)
    count = sum(group.count for group in machine.balancers[balancer - 1].races[race - 1].balls)
    length = 2.0 * math.pi * walls.orbit_radius / count
    return Channel(walls.ball_diameter, walls.outer - walls.inner, walls.height, walls.orbit_radius, length)

"""
A force of your own: felt in a part of the race
===============================================

A force on the balls is one class in one file: its keys, and its mathematics as functions of numbers. Here a strip of felt brakes
the balls where they roll over it, so that they leave the resonance earlier.
"""

# %%
# The class. ``at`` is the place of a ball in its race, ``own`` has the keys of the class that are numbers. The functions are
# compiled when they are first used, and called by the equations like those of the forces that come with the package. What a
# picture of the race shows of it is drawn by ``drawn``.

import cmath
import math
import warnings
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

import autobalancer as ab
from autobalancer.machine import Force, Quantity, key


class Felt(Force):
    """A strip of felt that brakes balls in a part of the race."""

    kind: Literal["felt"] = "felt"  # its word in machine files
    interface: ClassVar[int] = 1  # the version of the contract for which it was written
    drag: Annotated[float, Quantity("N*s/m", positive=True)] = key("braking force over speed on the felt")
    width: Annotated[float, Quantity("rad", positive=True)] = key("of the strip")
    angle: Annotated[float, Quantity("rad")] = key("of its middle in the rotor", 0.0)

    @staticmethod
    def force(at: Any, own: Any) -> tuple[float, float]:
        """N, on the ball, in axes that turn with the rotor; smooth at the ends of the strip."""
        away = math.atan2(at.y, at.x) - own.angle
        away -= 2.0 * math.pi * math.floor(away / (2.0 * math.pi) + 0.5)
        brake = own.drag / (1.0 + math.exp(40.0 * (abs(away) - 0.5 * own.width)))
        return -brake * at.vx, -brake * at.vy

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[list[complex]]:
        """Lines in m from the center of the race."""
        angles = self.angle + self.width * np.linspace(-0.5, 0.5, 60)
        zigzag = np.where(np.arange(60) % 2, 0.97, 1.03)
        return [[cmath.rect(orbit * r, angle) for r, angle in zip(zigzag, angles, strict=True)]]


# %%
# In Python an object of the class may stand in a machine. In a file it is ``kind = "felt"``, if the file with the class is
# loaded: ``autobalancer --load felt.py simulate machine.toml``, or ``ab.laws.load("felt.py")``.

warnings.simplefilter("ignore", ab.errors.RangeWarning)
plain = ab.example("discoidal")
forces = "balancers[1].races[1].forces"
braked = ab.with_parameter(plain, forces, [Felt(drag=0.5, width=np.pi / 3.0, angle=np.pi / 2.0)])
runs = {"without": ab.simulate(plain), "with felt": ab.simulate(braked)}

with ab.plot.style.look():
    figure = ab.plot.style.picture(7.5, 5.0)
    balls, rotor = figure.subplots(2, sharex=True)
    for (name, run), color in zip(runs.items(), ab.plot.style.BALLS, strict=False):
        balls.plot(run.time, run.ball_speed_in_rotor.mean("ball"), color=color, label=name)
        rotor.plot(run.envelope_time, 1e3 * run.envelope_high, color=color)
    balls.set(ylabel="slip of the balls (rad/s)", xlim=(40.0, 90.0))
    rotor.set(xlabel="time (s)", ylabel="deflection (mm)")
    ab.plot.style.heading(figure, "Two balls that roll over felt")
    ab.plot.style.legend(balls)

# %%
# The race at the end.

ab.plot.race(runs["with felt"])

# %%
# Where the balls reach the speed of the rotor for good.

freed = {}
for name, run in runs.items():
    slips = np.flatnonzero(np.abs(run.ball_speed_in_rotor.values).max(axis=1) > 1.0)
    freed[name] = float(run.speed[slips[-1]])
    print(f"{name}: at {freed[name]:.1f} rad/s")
assert freed["with felt"] < freed["without"] - 3.0

"""Filled balls come to rest on the bottom before the machine starts (Pakuła 2021, appendix 3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from autobalancer.assembly.chamber import assemble_chamber
from autobalancer.kernels.chamber.records import PROFILE, THETA
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.sampling import room_for

Array = Any
DECAY = 40.0  # 1/s: at which velocities of the balls fade, the same for light and heavy ones
FADE = 1e-3  # s: how often they are made to
SOFT, LONGEST = 1e-2, 2.0  # stiffness, over the real one, with which they fall, and how long that may last at most, s
HARD = 0.3  # s: the last part, with the real stiffness, lasts no longer
SLOW = 3e-3  # m/s: faster than this a ball is not at rest; slower ones creep, as friction that always slides lets them
LOOK = 0.02  # s


def settled(machine: ChamberMachine, positions: Array, step: float, waiting: Callable[[], Any] | None = None) -> Array:
    """Positions (n, 3) in the chambers after the balls have fallen and calmed down, with the rotor held.

    They fall with softer contacts, which allow longer steps. ``waiting`` is called every 20 ms of that time.
    """
    fallen = _fall(machine, positions, step * SOFT**-0.4, SOFT, LONGEST, waiting)
    return _fall(machine, fallen, step, 1.0, HARD, waiting)


def _fall(
    machine: ChamberMachine,
    positions: Array,
    step: float,
    soft: float,
    longest: float,
    waiting: Callable[[], Any] | None,
) -> Array:
    from autobalancer.kernels.chamber.verlet import start, verlet

    chamber = assemble_chamber(machine, positions, step)._replace(profile=PROFILE.rows(1))
    balls = chamber.balls
    for stiffness in (balls.race_stiffness, balls.flat_stiffness, balls.inner_stiffness, chamber.pair_stiffness):
        stiffness *= soft
    balls.velocity, balls.spin = 0.0, 0.0
    chamber.machine.driven, chamber.machine.free[0], chamber.body.rate[THETA] = 0, -1, 0.0
    start(chamber)
    every = max(round(FADE / step), 1)
    fading = float(np.exp(-DECAY * every * step))
    samples = room_for(chamber, round(LOOK / FADE), every)
    quiet = 0
    for _ in range(max(round(longest / LOOK), 1)):
        verlet(chamber, samples, fading)
        if waiting is not None:
            waiting()
        quiet = quiet + 1 if float(np.abs(samples.balls.velocity[-1]).max()) < SLOW else 0
        if quiet == 2:
            break
    return np.array(samples.balls.position[-1])

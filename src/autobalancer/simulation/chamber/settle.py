"""Filled balls come to rest on the bottom before the machine starts (Pakuła 2021, appendix 3)."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from autobalancer.assembly.chamber import assemble_chamber
from autobalancer.kernels.chamber import layout as at
from autobalancer.machine.chamber import ChamberMachine

Array = Any
DECAY = 40.0  # 1/s: at which velocities of the balls fade, the same for light and heavy ones
FADE = 1e-3  # s: how often they are made to
SOFT, LONGEST = 1e-2, 2.0  # stiffness, over the real one, with which they fall, and how long that may last at most, s
HARD = 0.3  # s: the last part, with the real stiffness, lasts no longer
SLOW = 3e-3  # m/s: faster than this a ball is not at rest; slower ones creep, as friction that always slides lets them
LOOK = 0.02  # s


def settled(machine: ChamberMachine, positions: Array, step: float) -> Array:
    """Positions (n, 3) in the chambers after the balls have fallen and calmed down, with the rotor held.

    They fall with softer contacts, which allow longer steps.
    """
    fallen = _fall(machine, positions, step * SOFT**-0.4, SOFT, LONGEST)
    return _fall(machine, fallen, step, 1.0, HARD)


def _fall(machine: ChamberMachine, positions: Array, step: float, soft: float, longest: float) -> Array:
    from autobalancer.kernels.chamber.samples import SAMPLE
    from autobalancer.kernels.chamber.verlet import verlet
    from autobalancer.simulation.chamber.march import evaluate_first

    advance: Any = verlet
    p = assemble_chamber(machine, positions, step)
    p.balls[:, [at.K_RACE, at.K_FLAT, at.K_INNER]] *= soft
    p.pair_stiffness *= soft
    p.number[at.DRIVEN] = 0.0
    p.profile = np.zeros((1, 2))
    p.active = np.array([-1], np.int64)
    p.balls[:, at.VEL : at.VEL + 6] = 0.0
    p.host[at.V + 6] = 0.0
    evaluate_first(p)
    every = max(round(FADE / step), 1)
    fading = float(np.exp(-DECAY * every * step))
    rows, balls, ledgers = np.zeros((1, SAMPLE)), np.zeros((1, len(positions), 9)), np.zeros((1, at.POWERS))
    quiet = 0
    for _ in range(max(round(longest / LOOK), 1)):
        for _ in range(round(LOOK / FADE)):
            advance(every, every, *[getattr(p, field.name) for field in fields(p)], rows, balls, ledgers)
            p.balls[:, at.VEL : at.VEL + 3] *= fading
        quiet = quiet + 1 if float(np.abs(balls[0, :, 3:6]).max()) < SLOW else 0
        if quiet == 2:
            break
    return balls[0, :, :3].copy()

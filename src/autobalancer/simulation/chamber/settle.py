"""Filled balls come to rest on the bottom before the machine starts (Pakuła 2021, appendix 3)."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from autobalancer.assembly.chamber import assemble_chamber
from autobalancer.kernels.chamber import layout as at
from autobalancer.machine.chamber import ChamberMachine

Array = Any
DECAY = 40.0  # 1/s: drag that calms the balls, over their mass
LONGEST = 1.5  # s
SLOW = 1e-3  # m/s: faster than this a ball is not at rest
LOOK = 0.02  # s


def settled(machine: ChamberMachine, positions: Array, step: float) -> Array:
    """Positions (n, 3) in the chambers after the balls have fallen and calmed down, with the rotor held."""
    from autobalancer.kernels.chamber.verlet import SAMPLE, verlet
    from autobalancer.simulation.chamber.march import evaluate_first

    p = assemble_chamber(machine, positions, step)
    p.number[at.DRIVEN] = 0.0
    p.profile = np.zeros((1, 2))
    p.active = np.array([-1], np.int64)
    p.host[at.V + 6] = 0.0
    for number in range(len(machine.chambers)):
        p.chambers[number, at.DRAG] += DECAY * p.balls[p.balls[:, at.CHAMBER] == number, at.MASS].mean()
    evaluate_first(p)
    every = max(round(LOOK / step), 1)
    rows, balls, ledgers = np.zeros((1, SAMPLE)), np.zeros((1, len(positions), 9)), np.zeros((1, at.POWERS))
    quiet = 0
    for _ in range(round(LONGEST / LOOK)):
        verlet(every, every, *[getattr(p, field.name) for field in fields(p)], rows, balls, ledgers)
        fastest = float(np.abs(balls[0, :, 3:6]).max())
        quiet = quiet + 1 if fastest < SLOW else 0
        if quiet == 2:
            break
    return balls[0, :, :3].copy()

"""The map over one revolution of a planar machine at constant speed, by the compiled equations."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.drive import steady
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import memory
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.system import BALLS, THETA, VX, VY, X, Y
from autobalancer.machine import Machine
from autobalancer.simulation.equations import PLANAR
from autobalancer.simulation.record import record_for
from autobalancer.stability.host.planar import Floats, Plane

TOLERANCE = 1e-13


class Turn:
    """The map over one revolution of a machine at constant speed, in axes at rest."""

    def __init__(self, machine: Machine, p: Plane, speed: float) -> None:
        self.assembly: Assembly = assemble(machine, rotating=False, contact=False, real=False)
        self.system = self.assembly.system._replace(drive=steady(speed, p.unbalance))
        self.speed, self.count = speed, p.moment.size
        self.period = 2.0 * math.pi / speed
        self.pair = tableaus.dormand_prince_8()
        scale = self.assembly.scale
        self.scale = np.concatenate([scale[[X, Y, VX, VY]], scale[BALLS:]])
        self.record = record_for((), (), self.assembly, self.period)

    def __call__(self, state: Floats, turns: int = 1) -> Floats:
        """The state after so many revolutions."""
        full = np.zeros(BALLS + 2 * self.count)
        full[[X, Y, VX, VY]], full[BALLS:] = state[:4], state[4:]
        run = memory(
            full,
            turns * self.period,
            TOLERANCE * self.assembly.scale,
            TOLERANCE * self.assembly.growing,
            total=self.pair.total,
            degree=self.pair.degree,
            longest=self.period,
        )
        run.state[THETA] = 0.0
        self.system.drive.now[0] = 0
        if advance(*PLANAR, self.system, self.pair, self.record, run, 10_000_000) != FINISHED:
            raise QuestionError(
                "steady state: the motion grows without limit within one revolution; the start is too far off"
            )
        return np.concatenate([run.state[[X, Y, VX, VY]], run.state[BALLS:]])

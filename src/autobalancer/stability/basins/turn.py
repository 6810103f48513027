"""The map over one revolution of a machine at constant speed, by the compiled equations."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.drive import steady
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.assembly.torsion.links import without_links
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import memory
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.system import SPEED, THETA
from autobalancer.machine import Machine
from autobalancer.simulation.equations import equations
from autobalancer.simulation.record import record_for
from autobalancer.stability.basins.unbalanced import steadily
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.stations import Stations

TOLERANCE = 1e-13


class Turn:
    """The map over one revolution of a machine at constant speed, in axes at rest.

    A planar machine counts with smooth races. States are those of the assembly without rotor angle and speed.
    """

    def __init__(self, machine: Machine, p: Plane | Stations, speed: float, angle: float = 0.0) -> None:
        self.assembly: Assembly = assemble(without_links(machine), rotating=False, contact=False, real=False)
        self.system = steadily(self.assembly.system, steady(speed, p.unbalance))
        self.speed, self.count, self.angle = speed, p.moment.size, angle
        self.period = 2.0 * math.pi / speed
        self.pair = tableaus.dormand_prince_8()
        self.kept = np.array([i for i in range(self.assembly.state.size) if i not in (THETA, SPEED)])
        self.scale = self.assembly.scale[self.kept]
        self.equations = equations(self.assembly).ready()
        self.record = record_for((), (), self.assembly, self.period)

    def __call__(self, state: Floats, turns: int = 1) -> Floats:
        """The state after so many revolutions."""
        full = np.zeros(self.assembly.state.size)
        full[self.kept], full[SPEED] = state, self.speed
        run = memory(
            full,
            turns * self.period,
            TOLERANCE * self.assembly.scale,
            TOLERANCE * self.assembly.growing,
            total=self.pair.total,
            degree=self.pair.degree,
            longest=self.period,
        )
        run.state[THETA] = self.angle
        self.system.drive.now[0] = 0
        if advance(*self.equations, self.system, self.pair, self.record, run, 10_000_000) != FINISHED:
            raise QuestionError(
                "steady state: the motion grows without limit within one revolution; the start is too far off"
            )
        return np.asarray(run.state[self.kept])

"""Whole states of a run, and what friction does meanwhile."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.integrators.tableau import dormand_prince_8
from autobalancer.machine import Machine
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import equations, memory_for


def states_of(machine: Machine, times: np.ndarray, *, tolerance: float = 1e-12) -> np.ndarray:
    """States (times, n) in axes at rest."""
    return states_from(assemble(machine, rotating=False), times, tolerance=tolerance)


def states_from(assembly: Assembly, times: np.ndarray, *, tolerance: float = 1e-12) -> np.ndarray:
    """States (times, n) of an assembled machine, from whatever state it has been given."""
    end = float(times[-1])
    record = record_for([SampleTimes(times.tolist())], (), assembly, end)
    pair = dormand_prince_8()
    memory = memory_for(assembly, end, tolerance, pair)
    assert advance(*equations(assembly), assembly.system, pair, record, memory, 10_000_000) == FINISHED
    return record.samples

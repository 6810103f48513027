"""Runs of the package as plain states, in axes at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tests.references.lagrange import to_space

from autobalancer.assembly.system import assemble
from autobalancer.kernels.integrators.integrator_state import Memory
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.integrators.tableau import Tableau, dormand_prince_8
from autobalancer.machine import Machine
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import PLANAR, memory_for


def states_at(
    machine: Machine,
    times: Sequence[float] | np.ndarray,
    *,
    tolerance: float = 1e-13,
    rotating: bool | None = None,
    pair: Tableau | None = None,
) -> np.ndarray:
    """States of the package at these times, (times, 6 + 2 n), in axes at rest."""
    return run_to(machine, times, tolerance=tolerance, rotating=rotating, pair=pair)[0]


def run_to(
    machine: Machine,
    times: Sequence[float] | np.ndarray,
    *,
    tolerance: float = 1e-13,
    rotating: bool | None = None,
    pair: Tableau | None = None,
) -> tuple[np.ndarray, Memory]:
    """The same, and the memory of the integration."""
    pair = pair or dormand_prince_8()
    assembly = assemble(machine, rotating=rotating)
    end = float(times[-1])
    record = record_for([SampleTimes(times)], [], assembly, end)
    memory = memory_for(assembly, end, tolerance, pair)
    assert advance(*PLANAR, assembly.system, pair, record, memory, 10**9) == FINISHED
    return (to_space(record.samples) if assembly.system.rotating else record.samples), memory

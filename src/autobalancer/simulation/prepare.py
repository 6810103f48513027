"""A machine made ready to run: assembled, with the lag of its fluids worked out before."""

from __future__ import annotations

from autobalancer.assembly.system import Assembly, assemble
from autobalancer.machine import Machine
from autobalancer.simulation.fluid_lag import fluid_lags


def prepare(
    machine: Machine,
    end: float | None,
    *,
    seed: int = 0,
    rotating: bool | None = None,
    mass_spread: float = 0.0,
    max_steps: int = 100_000_000,
) -> Assembly:
    """Like :func:`autobalancer.assembly.system.assemble`, with fluids that lag behind their chamber.

    ``end`` is the duration of the run; None where the speed is not that of the machine's drive. ``max_steps`` is for the runs
    that :func:`autobalancer.simulation.fluid_lag.fluid_lags` may need.

    Raises
    ------
    MachineError
        Also if the flow in a race cannot be worked out.
    """
    known = fluid_lags(machine, end, seed=seed, max_steps=max_steps)
    return assemble(machine, seed=seed, rotating=rotating, lags=known.lags, mass_spread=mass_spread)

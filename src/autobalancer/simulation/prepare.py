"""A machine made ready to run: assembled, with the lag of its fluids worked out before."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from autobalancer.assembly.fluid_numbers import Lag
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.errors import MachineError
from autobalancer.machine import Machine, PrescribedSpeed


def prepare(machine: Machine, end: float | None, *, seed: int = 0, rotating: bool | None = None) -> Assembly:
    """Like :func:`autobalancer.assembly.system.assemble`, with fluids that lag behind their chamber.

    ``end`` is the duration of the run, up to which a prescribed speed is known; None where the speed is not that of the
    machine's drive.

    Raises
    ------
    MachineError
        Also if the flow in a race cannot be worked out.
    """
    return assemble(machine, seed=seed, rotating=rotating, lags=fluid_lags(machine, end))


def fluid_lags(machine: Machine, end: float | None) -> dict[tuple[int, int], Lag]:
    """The lag of every fluid that has one, by balancer and race from 0."""
    found = {}
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            if race.fluid is not None and race.fluid.lag != "none":
                found[b, r] = _lag(machine, end, b, r, race.fluid.lag)
    return found


def _lag(machine: Machine, end: float | None, balancer: int, race: int, model: str) -> Lag:
    from autobalancer.flow.annulus import annulus_of
    from autobalancer.flow.relaxation import relaxation_modes

    annulus = annulus_of(machine, balancer + 1, race + 1)
    known = isinstance(machine.drive, PrescribedSpeed) and end is not None
    if model == "full" and not known:
        raise MachineError(
            f"balancers[{balancer + 1}].races[{race + 1}].fluid.lag: given 'full', but the flow can only be solved beforehand "
            "where the speed is prescribed; take 'modes'"
        )
    if known and model != "modes":
        assert isinstance(machine.drive, PrescribedSpeed)
        assert end is not None
        solver, times, lag = _solved(annulus, machine.drive.profile, end, "chebyshev" if model == "full" else "auto")
        if solver != "modes":
            return Lag(times=times, values=lag)
    modes = relaxation_modes(annulus)
    return Lag(rates=modes.rates, gains=modes.gains)


@lru_cache(maxsize=64)
def _solved(annulus, profile, end: float, model: str):  # type: ignore[no-untyped-def]
    """Solver, times and lag of a flow; the balls do not disturb it, so one solution serves all runs with this profile."""
    from autobalancer.flow.question import annulus_flow

    flow = annulus_flow(annulus, profile, duration=end, model=model, samples=2001)  # type: ignore[arg-type]
    lag = flow["speed"].values - flow["fluid_speed"].values
    return str(flow.attrs["model"]), np.asarray(flow["time"].values, np.float64), np.asarray(lag, np.float64)

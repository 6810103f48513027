"""One member run to its end, and what is kept of it."""

from __future__ import annotations

from typing import Any, NamedTuple

from autobalancer.assembly.contact.touches import ROOM, with_touches
from autobalancer.assembly.places import Places
from autobalancer.assembly.profile import unbalance_jumps
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import ACCEPTED
from autobalancer.kernels.integrators.runge_kutta import RUNNING, advance
from autobalancer.simulation.equations import equations
from autobalancer.simulation.fresh import memory_for
from autobalancer.simulation.impacts import Noted
from autobalancer.simulation.record import record_for
from autobalancer.simulation.sampling import Envelope, LastRevolutions
from autobalancer.studies.sweep_row import sweep_row


class Plan(NamedTuple):
    """How a member is run."""

    end: float  # s
    tolerance: float
    bins: int
    max_steps: int


def run_member(assembly: Assembly, places: Places, plan: Plan) -> dict[str, Any]:
    """Run a member; what it leaves as plain numbers and arrays: measures, outcome, verdict, steps, state at the end."""
    pair = tableaus.dormand_prince_8()
    record = record_for(
        [Envelope(plan.bins), LastRevolutions()], (), assembly, plan.end, unbalance_jumps(places.machine, plan.end)
    )
    memory = memory_for(assembly, plan.end, plan.tolerance, pair)
    start = assembly.state
    assembly, touches = with_touches(places.machine, assembly)
    noted, status, moving = Noted(touches), RUNNING, equations(assembly)
    while status == RUNNING and memory.counts[ACCEPTED] < plan.max_steps:
        budget = min(ROOM, plan.max_steps - int(memory.counts[ACCEPTED]))
        status = advance(*moving, assembly.system, pair, record, memory, budget)
        noted.take(assembly.system)
    row = sweep_row(status, assembly, places, record, memory, plan.end, noted.found())
    return row | {"steps": int(memory.counts[ACCEPTED]), "state": memory.state.copy(), "start": start}

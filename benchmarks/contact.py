"""What contact of guided balls costs: run-ups in which they meet, against the same machines without contact."""

from __future__ import annotations

from time import process_time
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels.integrators.integrator_state import EVALUATIONS
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.simulation.record import Envelope, record_for
from autobalancer.simulation.steppers import stepper_for
from benchmarks import measured
from benchmarks._run_up import MACHINE

RACE, LIMIT, END, TOLERANCE = "balancers[1].races[1].", 1.3, 20.0, 1e-6
SET = [(float(beta), mass) for beta in np.geomspace(5e-5, 5e-4, 8) for mass in (2e-3, 3e-3, 4e-3, 5e-3, 6e-3)]
# a contact that vibrates ten times as fast as the rotor; while it lasts, steps shrink as the inverse root of its stiffness
SOFT = {"restitution": float(np.exp(-2.0)), "stiffness": 1.1e4}


def bench() -> list[dict[str, Any]]:
    """40 run-ups of two balls over drag and unbalance: rigid contact, no contact, soft contact."""
    machines = [
        ab.with_parameter(
            ab.with_parameter(ab.load_machine(MACHINE), f"{RACE}drag.damping", beta), "unbalances[1].mass", mass
        )
        for beta, mass in SET
    ]
    soft = [ab.with_parameter(machine, f"{RACE}contact", SOFT) for machine in machines]
    sets = {
        "rigid": [assemble(machine) for machine in machines],
        "none": [assemble(machine, contact=False) for machine in machines],
        "soft": [assemble(machine) for machine in soft],
    }
    times, work = dict.fromkeys(sets, float("inf")), dict.fromkeys(sets, 0)
    for _ in range(4):
        for name, assemblies in sets.items():
            begin = process_time()
            work[name] = sum(_evaluations(assembly) for assembly in assemblies)
            times[name] = min(times[name], process_time() - begin)
    cost = times["rigid"] / times["none"]
    note = (
        f"{len(SET)} run-ups of {END:g} s at {TOLERANCE:g}: {times['rigid'] / len(SET):.3g} s each, evaluations "
        f"{work['rigid'] / work['none']:.3g} times those without contact; soft contact of "
        f"{SOFT['stiffness']:g} N/m {times['soft'] / times['none']:.3g} times the time, "
        f"{work['soft'] / work['none']:.3g} times the evaluations"
    )
    return [measured("contact_cost", cost, "1", note=note) | {"peer": f"limit {LIMIT:g}", "ratio": LIMIT / cost}]


def _evaluations(assembly: Assembly) -> int:
    stepper, record = stepper_for(assembly, END, TOLERANCE), record_for([Envelope()], (), assembly, END)
    assembly.system.drive.now[0] = 0
    assert stepper.advance(assembly.system, record, 10**7) == FINISHED
    return int(stepper.memory.counts[EVALUATIONS])

"""How much faster than real time rotors with balls run: a shaft of 20 elements, and a rigid rotor that tilts.

The whole of ``simulate`` is timed, with its assembly, reduction and recording.
"""

from __future__ import annotations

from pathlib import Path
from time import process_time
from typing import Any

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from benchmarks import measured

RIGID = Path(__file__).parents[1] / "examples" / "machines" / "two_plane_rotor.toml"
RUN_UP = {"kind": "ramp", "start": 0.0, "end": "4000 rpm", "duration": "60 s"}
SHAFT_GOAL, RIGID_GOAL = 1000.0, 2000.0


def bench() -> list[dict[str, Any]]:
    """Simulated seconds per second of processor time of one core, best of five runs, and against the goals."""
    rigid = with_value_at(ab.load_machine(RIGID), "drive.profile", RUN_UP)
    return [
        factor("cfrp_real_time_factor", rig("cfrp_rig"), 120.0, SHAFT_GOAL),
        factor("rigid_rotor_real_time_factor", rigid, 60.0, RIGID_GOAL),
    ]


def factor(name: str, machine: Machine, duration: float, goal: float) -> dict[str, Any]:
    """One row; its ratio is against the goal."""
    run = ab.simulate(machine, duration=duration)
    time = min(taken(machine, duration) for _ in range(5))
    value = duration / time
    balls, kept, pairs = run.sizes["ball"], run.attrs["modes_kept"], run.attrs["modes_in_all"]
    note = (
        f"run-up of {duration:g} s with {balls} balls, {kept} of {pairs} pairs of modes, "
        f"{run.attrs['steps']} steps, {run.attrs['outcome']}"
    )
    return measured(name, value, "1", note=note) | {"peer": f"goal {goal:g}", "ratio": value / goal}


def taken(machine: Machine, duration: float) -> float:
    """Processor time of one run, s."""
    start = process_time()
    ab.simulate(machine, duration=duration)
    return process_time() - start

"""What oil that lags, drag over all Reynolds numbers, rolling resistance, adherence and forces on balls cost in a run-up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.machine import Machine
from autobalancer.simulation.record import Envelope, Samples
from benchmarks import measured, seconds

MACHINE = Path(__file__).resolve().parent.parent / "examples" / "machines" / "discoidal.toml"
LIMIT = 3.0


def bench() -> list[dict[str, Any]]:
    """The run-up of the discoidal stand-in with two balls, 160 s; balls touch in all."""
    linear = ab.load_machine(MACHINE)
    full = full_physics(linear)
    save = (Samples(), Envelope())
    machines = (linear, full, with_neighbors(full), with_springs(linear))
    short, long, longest, pulled = (seconds(lambda m=m: ab.simulate(m, save=save), repeats=3) for m in machines)
    note = f"160 s of run-up: {long:.3g} s against {short:.3g} s; a ratio above 1 keeps to the limit of {LIMIT:g}"
    row = measured("full_physics_vs_linear", long / short, "1", note=note)
    note = f"the same with slipstream and friction between the balls: {longest:.3g} s"
    more = measured("full_physics_and_neighbors_vs_linear", longest / short, "1", note=note)
    note = (
        "radial springs, a force of one file, which guided balls feel in their wall force only: what calling it costs"
    )
    called = measured("force_vs_none", pulled / short, "1", note=note)
    return [row | {"peer": f"limit {LIMIT:g}", "ratio": LIMIT * short / long}, more, called]


def full_physics(machine: Machine) -> Machine:
    """The same machine with everything that brakes a real ball."""
    race = "balancers[1].races[1]"
    machine = with_value_at(machine, f"{race}.drag", {"law": "discoidal"})
    machine = with_value_at(machine, f"{race}.fluid.lag", "modes")
    return with_value_at(machine, f"{race}.friction", {"rolling_resistance": 0.005, "adherence": 0.006})


def with_neighbors(machine: Machine) -> Machine:
    """The same machine where balls also shield each other and rub."""
    race = "balancers[1].races[1]"
    machine = with_value_at(machine, f"{race}.slipstream", True)
    return with_value_at(machine, f"{race}.contact", {"restitution": 0.3, "friction": 0.2})


def with_springs(machine: Machine) -> Machine:
    """The same machine with a spring from the center of the race to each ball."""
    return with_value_at(
        machine, "balancers[1].races[1].forces", [{"kind": "radial_spring", "stiffness": 10.0, "free_length": 0.0}]
    )

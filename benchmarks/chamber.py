"""Balls free in three dimensions: time of a ball and step, and of a start-up, on one thread.

The balls of ``chamber_ns_per_ball_step_*`` are settled in the chamber of the reference machine and driven to 160 rad/s within
0.05 s; all terms of the contacts are on. The second half of the run counts: for 50 balls they turn with the rotor, for 1000
the pile is being carried up.
"""

from __future__ import annotations

from pathlib import Path
from time import process_time
from typing import Any

from autobalancer.files.machine_file import load_chamber_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from benchmarks import measured

MACHINE = Path(__file__).resolve().parent.parent / "examples" / "machines" / "deep_chamber.toml"
STEP = 1e-6  # s


def bench() -> list[dict[str, Any]]:
    """Three rows."""
    return [per_ball(50, 2.0, STEP), per_ball(1000, 0.06, 0.5 * STEP), start_up()]


def machine(count: int, speed: float) -> ChamberMachine:
    """The reference machine with so many balls of the same total mass, at a prescribed speed unless it is 0."""
    described = load_chamber_machine(MACHINE).model_dump(exclude_unset=True)
    described["chambers"][0]["balls"][0]["count"] = count
    if speed:
        rise = {"kind": "ramp", "start": 0.0, "end": speed, "duration": 0.05}
        described["drive"] = {"kind": "speed", "profile": rise}
    return ChamberMachine(**described)


def per_ball(count: int, duration: float, step: float) -> dict[str, Any]:
    """Processor time of a step over the number of balls, in the second half of a run."""
    given = machine(count, 160.0)
    held: list[Any] = []
    half = round(0.5 * duration / 1e-3)
    run = simulate_chamber(
        given, duration=0.5 * duration, step=step, chunk=half, on_chunk=lambda part, state: held.append(state)
    )
    begin = process_time()
    run = simulate_chamber(given, duration=duration, step=step, resume=held[-1])
    time = (process_time() - begin) / (half * round(1e-3 / run.step)) / count
    return measured(f"chamber_ns_per_ball_step_{count}", 1e9 * time, "ns", note=f"steps of {run.step:.3g} s")


def start_up() -> dict[str, Any]:
    """Processor time of 20 s of the reference machine with 50 balls; Pakuła (2021) needed 135 h for such a run."""
    begin = process_time()
    run = simulate_chamber(machine(50, 0.0), duration=20.0, step=STEP, keep=False)
    time = process_time() - begin
    error = float(run.energy_error[-1] / run.work_motor[-1])
    note = f"published: 135 h, {135 * 3600 / time:.0f} times as long; energy error {error:.0e} of the work"
    return measured("chamber_50_balls_20_s", time, "s", note=note)

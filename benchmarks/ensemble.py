"""Thousands of run-ups: members a second and core, against heyoka's batch mode, and end to end on two cores."""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine
from benchmarks import compared, measured
from benchmarks._run_up import END, GOAL, LADDER_BATCH, MACHINE, heyoka_equations, prepared

MEMBERS, SEED = 400, 7
DRAG, MASS = (5e-5, 5e-4), (2e-3, 6e-3)  # ranges of drag and unbalance, the latter as its mass
WHOLE = 100_000


def columns(count: int) -> dict[str, np.ndarray]:
    """Drag and unbalance of the members: equal ratios, and at random."""
    drawn = np.random.default_rng(SEED)
    return {"drag": np.geomspace(*DRAG, count), "unbalances[1].mass": drawn.uniform(*MASS, count)}


def without_contact() -> Machine:
    """The machine of the stall-and-release run-up with balls that pass through each other."""
    return ab.with_parameter(load_race_machine(MACHINE), "balancers[1].races[1].coincidence", True)


def end_error(machine: Machine, tolerance: float) -> float:
    """Greatest miss at the end of ten members: deflection on the way over its peak, ball angles at the end over a turn."""
    given = {name: values[:: MEMBERS // 10] for name, values in columns(MEMBERS).items()}
    rough, exact = (ab.ensemble(machine, given, tolerance=t) for t in (tolerance, 1e-13))
    peak = np.abs(rough["peak_deflection"] / exact["peak_deflection"] - 1.0)
    turned = np.abs(rough["ball_angle_to_unbalance"] - exact["ball_angle_to_unbalance"]) / (2.0 * np.pi)
    return float(np.median(np.maximum(peak, np.minimum(turned, 1.0 - turned).max("ball"))))


def chosen(machine: Machine) -> tuple[float, float]:
    """The loosest tolerance whose median error reaches the goal, and that error."""
    for tolerance in LADDER_BATCH:
        error = end_error(machine, tolerance)
        if error <= GOAL:
            break
    return tolerance, error


def bench() -> list[dict[str, Any]]:
    """Times of a core are those of the threads themselves, without what other programs take."""
    touching, passing = load_race_machine(MACHINE), without_contact()
    tolerance, error = chosen(touching)
    ab.ensemble(touching, columns(4), tolerance=tolerance)
    found = ab.ensemble(touching, columns(MEMBERS), tolerance=tolerance, workers=1)
    each = float(found.attrs["run_time_per_member"])
    note = (
        f"{MEMBERS} members, 20 s, contact and measures, tolerance {tolerance:.1e}, median error {error:.1e}, one core"
    )
    rows = [measured("ensemble_run_ups_per_s", 1.0 / each, "1/s", note=note)]
    rows.append(against_heyoka(passing))
    with tempfile.TemporaryDirectory() as folder:
        part = 20 * MEMBERS
        begin = perf_counter()
        kept = ab.ensemble(MACHINE, columns(part), tolerance=tolerance, workers=2)
        ab.save_run(kept, Path(folder) / "ensemble.nc")
        whole = (perf_counter() - begin) * WHOLE / part
    note = f"from the machine file to the result file on two cores; extrapolated from {part} members"
    return [*rows, measured("ensemble_1e5_s", whole, "s", note=note)]


def against_heyoka(machine: Machine) -> dict[str, Any]:
    """The same members without contact; heyoka at its best width without measures, ours with them."""
    tolerance, error = chosen(machine)
    ab.ensemble(machine, columns(4), tolerance=tolerance)
    ours = min(
        float(ab.ensemble(machine, columns(MEMBERS), tolerance=tolerance, workers=1).attrs["run_time_per_member"])
        for _ in range(3)
    )
    times = {(width, tight): heyoka_batch(width, tight) for width in (2, 4, 8) for tight in (1e-6, 1e-7)}
    (width, tight), theirs = min(times.items(), key=lambda one: one[1])
    note = (
        f"{MEMBERS} members without contact; ours with measures, tolerance {tolerance:.1e}, median error {error:.1e}; theirs "
        f"{width} at once, tol {tight:.0e}, without measures"
    )
    return compared("ensemble_vs_heyoka_batch", ours, "heyoka, batch mode", theirs, note=note)


def heyoka_batch(width: int, tolerance: float) -> float:
    """Seconds of a core for a member; compilation is not counted."""
    import heyoka as hy

    assembly = prepared(True)
    drag, radius = hy.par[2], float(load_race_machine(MACHINE).unbalances[0].radius or 0.0)
    system = heyoka_equations(assembly.system, True, drag=drag, unbalance=hy.par[3])
    state = np.repeat(assembly.state[:, None], width, axis=1)
    taylor = hy.taylor_adaptive_batch(system, state, tol=tolerance, pars=np.zeros((4, width)))
    segments, given = assembly.system.drive.segments, columns(MEMBERS)
    edges = [*segments.start.tolist()[1:], END]
    best = np.inf
    for _ in range(2):
        begin = thread_time()
        for first in range(0, MEMBERS, width):
            taylor.set_time(0.0)
            taylor.state[:] = state
            taylor.pars[2] = given["drag"][first : first + width]
            taylor.pars[3] = radius * given["unbalances[1].mass"][first : first + width]
            for row, right in zip(segments, edges, strict=True):
                taylor.pars[0], taylor.pars[1] = row.value - row.rate * row.start, row.rate
                taylor.propagate_until(right)
        best = min(best, (thread_time() - begin) / MEMBERS)
    return float(best)

"""Thousands of run-ups: members a second and core, against heyoka's batch mode, and end to end on two cores."""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.files.machine_file import load_race_machine
from autobalancer.kernels.system import BALLS
from autobalancer.machine import Machine
from autobalancer.simulation.steppers import Method
from benchmarks import compared, measured
from benchmarks._run_up import END, GOAL, LADDER_BATCH, MACHINE, heyoka_equations, prepared

MEMBERS, SEED = 400, 7
DRAG, MASS = (5e-5, 5e-4), (2e-3, 6e-3)  # ranges of drag and unbalance, the latter as its mass
WHOLE = 100_000
METHODS: tuple[Method, ...] = ("dormand_prince_8", "exponential_collocation")


def columns(count: int) -> dict[str, np.ndarray]:
    """Drag and unbalance of the members: equal ratios, and at random."""
    drawn = np.random.default_rng(SEED)
    return {"drag": np.geomspace(*DRAG, count), "unbalances[1].mass": drawn.uniform(*MASS, count)}


def without_contact() -> Machine:
    """The machine of the stall-and-release run-up with balls that pass through each other."""
    return ab.with_parameter(load_race_machine(MACHINE), "balancers[1].races[1].coincidence", True)


def end_error(machine: Machine, tolerance: float, method: Method) -> float:
    """Median over ten members of the greatest miss: deflection on the way over its peak, ball angles at the end over a turn."""
    given = {name: values[:: MEMBERS // 10] for name, values in columns(MEMBERS).items()}
    rough, exact = (
        ab.ensemble(machine, given, tolerance=t, method=m)
        for t, m in ((tolerance, method), (1e-13, "dormand_prince_8"))
    )
    peak = np.abs(rough["peak_deflection"] / exact["peak_deflection"] - 1.0)
    turned = np.abs(rough["ball_angle_to_unbalance"] - exact["ball_angle_to_unbalance"]) / (2.0 * np.pi)
    return float(np.median(np.maximum(peak, np.minimum(turned, 1.0 - turned).max("ball"))))


def chosen(machine: Machine, method: Method) -> tuple[float, float]:
    """The loosest tolerance whose median error reaches the goal, and that error."""
    for tolerance in LADDER_BATCH:
        error = end_error(machine, tolerance, method)
        if error <= GOAL:
            break
    return tolerance, error


def best(machine: Machine) -> tuple[float, str, float, str]:
    """Seconds of a core for a member with the faster method: those, the method, its tolerance, and what a note says of it."""
    found = []
    for method in METHODS:
        tolerance, error = chosen(machine, method)
        ab.ensemble(machine, columns(4), tolerance=tolerance, method=method)
        kept = ab.ensemble(machine, columns(MEMBERS), tolerance=tolerance, method=method, workers=1)
        text = f"{method}, tolerance {tolerance:.1e}, median error {error:.1e}"
        found.append((float(kept.attrs["run_time_per_member"]), method, tolerance, text))
    return min(found)


def bench() -> list[dict[str, Any]]:
    """Times of a core are those of the threads themselves, without what other programs take."""
    each, method, tolerance, text = best(load_race_machine(MACHINE))
    note = f"{MEMBERS} members, 20 s, with contact and measures, {text}, one core"
    rows = [measured("ensemble_run_ups_per_s", 1.0 / each, "1/s", note=note), against_heyoka(without_contact())]
    with tempfile.TemporaryDirectory() as folder:
        part = 20 * MEMBERS
        begin = perf_counter()
        kept = ab.ensemble(MACHINE, columns(part), tolerance=tolerance, method=method, workers=2)
        ab.save_run(kept, Path(folder) / "ensemble.nc")
        whole = (perf_counter() - begin) * WHOLE / part
    note = f"from the machine file to the result file on two cores; extrapolated from {part} members"
    return [*rows, measured("ensemble_1e5_s", whole, "s", note=note)]


def against_heyoka(machine: Machine) -> dict[str, Any]:
    """The same members without contact; heyoka at its best width without measures, ours with them."""
    ours, *_, text = best(machine)
    theirs = min(heyoka_batch(width) for width in (2, 4, 8))
    note = (
        f"{MEMBERS} members without contact; ours with measures, {text}; theirs {theirs[1]} at once, tol {theirs[2]:.0e}, median "
        f"error {theirs[3]:.1e}, without measures"
    )
    return compared("ensemble_vs_heyoka_batch", ours, "heyoka, batch mode", theirs[0], note=note)


def heyoka_batch(width: int) -> tuple[float, int, float, float]:
    """Seconds of a core for a member at the loosest tolerance that reaches the goal; width, tolerance and median error.

    Compilation is not counted. The error is that of the ball angles at the end, against a tolerance of 1e-14.
    """
    import heyoka as hy

    assembly = prepared(True)
    radius = float(load_race_machine(MACHINE).unbalances[0].radius or 0.0)
    system = heyoka_equations(assembly.system, True, drag=hy.par[2], unbalance=hy.par[3])
    state = np.repeat(assembly.state[:, None], width, axis=1)
    segments, given = assembly.system.drive.segments, columns(MEMBERS)
    edges = [*segments.start.tolist()[1:], END]

    def ends(tolerance: float) -> tuple[float, np.ndarray]:
        taylor = hy.taylor_adaptive_batch(system, state, tol=tolerance, pars=np.zeros((4, width)))
        found, begin = [], thread_time()
        for first in range(0, MEMBERS, width):
            taylor.set_time(0.0)
            taylor.state[:] = state
            taylor.pars[2] = given["drag"][first : first + width]
            taylor.pars[3] = radius * given["unbalances[1].mass"][first : first + width]
            for row, right in zip(segments, edges, strict=True):
                taylor.pars[0], taylor.pars[1] = row.value - row.rate * row.start, row.rate
                taylor.propagate_until(right)
            found.append(taylor.state[BALLS : BALLS + 2].copy())
        return (thread_time() - begin) / MEMBERS, np.concatenate(found, axis=1)

    exact = ends(1e-14)[1]
    for tolerance in LADDER_BATCH:
        seconds, angles = ends(tolerance)
        error = float(np.median(np.abs(angles - exact).max(axis=0)) / (2.0 * np.pi))
        if error <= GOAL:
            break
    return min(seconds, ends(tolerance)[0]), width, tolerance, error

"""Thousands of run-ups: members a second and core, against heyoka's batch mode, and end to end on two cores."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any, NamedTuple

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import value_of
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import load_race_machine
from autobalancer.kernels.system import BALLS
from autobalancer.machine import Machine
from autobalancer.simulation import Method
from autobalancer.studies.ensemble.columns import Columns, columns_of
from autobalancer.studies.ensemble.layout import Plan
from autobalancer.studies.ensemble.members import Members, without_start_angles
from benchmarks import compared, measured
from benchmarks._run_up import END, GOAL, LADDER_BATCH, MACHINE, heyoka_equations, prepared

MEMBERS, SEED, MADE = 400, 7, 100
DRAG, MASS = (5e-5, 5e-4), (2e-3, 6e-3)  # ranges of drag and unbalance, the latter as its mass
WHOLE = 100_000
REPEATS = 3  # of every time, the least counts
TWO_PLANES = MACHINE.parent / "two_plane_rotor.toml"
METHODS: tuple[Method, ...] = ("dormand_prince_8", "exponential_collocation")


def columns(count: int) -> dict[str, np.ndarray]:
    """Drag and unbalance of the members: equal ratios, and at random."""
    drawn = np.random.default_rng(SEED)
    return {"drag": np.geomspace(*DRAG, count), "unbalances[1].mass": drawn.uniform(*MASS, count)}


def without_contact() -> Machine:
    """The machine of the stall-and-release run-up with balls that pass through each other."""
    return ab.with_parameter(load_race_machine(MACHINE), "balancers[1].races[1].collisions", False)


class Found(NamedTuple):
    """A setting that reaches the goal, and what it costs."""

    at_goal: float  # s of a core for a member at the error of the goal, between this setting and the next looser one
    seconds: float  # with this setting
    method: Method | int  # that of ours, how many members at once of theirs
    tolerance: float
    error: float  # median of the greatest miss of the ball angles at the end, in turns

    @property
    def text(self) -> str:
        """For a note."""
        return f"tolerance {self.tolerance:.1e}, median error {self.error:.1e}"


def reached(method: Method | int, tried: Iterable[tuple[float, float, float]]) -> Found:
    """The first setting that reaches the goal, of (tolerance, error, seconds) from the loosest on."""
    before: tuple[float, float] | None = None
    for tolerance, error, seconds in tried:
        if error <= GOAL:
            share = 1.0 if before is None else math.log(before[0] / GOAL) / math.log(before[0] / error)
            looser = seconds if before is None else before[1]
            return Found(looser ** (1.0 - share) * seconds**share, seconds, method, tolerance, error)
        before = error, seconds
    raise AssertionError("no tolerance reaches the goal")


def median_miss(angles: np.ndarray, exact: np.ndarray) -> float:
    """Median over the members of the greatest miss of a ball angle, (balls, members), in turns."""
    return float(np.median(np.abs(angles - exact).max(axis=0)) / (2.0 * np.pi))


def best(machine: Machine, measures: list[str] | None = None) -> Found:
    """Our faster method at the error of the goal; ``measures`` are those that are asked for, by default all."""
    given = columns(MEMBERS)
    exact = end_angles(
        ab.ensemble(machine, given, tolerance=1e-13, method="dormand_prince_8", measures=[], keep_states=True)
    )

    def tried(method: Method) -> Iterator[tuple[float, float, float]]:
        for tolerance in LADDER_BATCH:
            runs = [
                ab.ensemble(
                    machine, given, tolerance=tolerance, method=method, measures=measures, workers=1, keep_states=True
                )
                for _ in range(REPEATS)
            ]
            seconds = min(float(run.attrs["run_time_per_member"]) for run in runs)
            yield tolerance, median_miss(end_angles(runs[0]), exact), seconds

    return min((reached(method, tried(method)) for method in METHODS), key=lambda found: found.at_goal)


def end_angles(kept: Any) -> np.ndarray:
    """Ball angles at the end, (balls, members)."""
    return np.asarray(kept["final_state"].values[:, BALLS : BALLS + 2].T)


def bench() -> list[dict[str, Any]]:
    """Times of a core are those of the threads themselves, without what other programs take."""
    own = best(load_race_machine(MACHINE))
    note = f"{MEMBERS} members, 20 s, with contact and measures, {own.method}, {own.text}, one core"
    rows = [measured("ensemble_run_ups_per_s", 1.0 / own.seconds, "1/s", note=note), against_heyoka(without_contact())]
    with tempfile.TemporaryDirectory() as folder:
        part = 20 * MEMBERS
        begin = perf_counter()
        kept = ab.ensemble(MACHINE, columns(part), tolerance=own.tolerance, method=own.method, workers=2)
        ab.save_run(kept, Path(folder) / "ensemble.nc")
        whole = (perf_counter() - begin) * WHOLE / part
    note = f"from the machine file to the result file on two cores; extrapolated from {part} members"
    return [*rows, measured("ensemble_1e5_s", whole, "s", note=note), *made_ready()]


def made_ready() -> list[dict[str, Any]]:
    """Members on a rotor that tilts and on a shaft, from the columns to the words of their runs, without these."""
    rotors = {"rigid": load_race_machine(TWO_PLANES), "shaft": rig("cfrp_rig")}
    plan, found = Plan(10.0, 1e-6, 500, 1000), []
    for name, machine in rotors.items():
        around, start = np.linspace(0.98, 1.02, MADE), without_start_angles(machine)
        varied = {
            key: value_of(machine, key) * around for key in ("unbalances[1].moment", "unbalances[1].angle", "drag")
        }
        given = columns_of(start, varied)

        def taken(follow: bool, start: Machine = start, given: Columns = given) -> float:
            begin = thread_time()
            Members(start, given, np.arange(2), 0, "member").sorted(plan, "refuse", follow=follow)
            return (thread_time() - begin) / (2 * MADE)

        ours, theirs = (min(taken(follow) for _ in range(REPEATS)) for follow in (True, False))
        note = f"{2 * MADE} members on a {name} rotor: unbalance, its angle, drag, random starts; one core, without their runs"
        found.append(compared(f"member_made_ready_{name}", ours, "assembled one by one", theirs, note=note))
    return [*found, disk_made_ready(without_start_angles(rotors["shaft"]), plan)]


def disk_made_ready(machine: Machine, plan: Plan) -> dict[str, Any]:
    """Members with other disks and balls on a shaft: their numbers lie between those of assembled ones, or are made anew."""
    around, keys = np.linspace(0.98, 1.02, 10 * MADE), ("rotor.disks[1].mass", "balancers[1].races[1].balls[1].mass")

    def taken(count: int, interpolate: bool) -> float:
        drawn = np.random.default_rng(SEED)
        given = columns_of(
            machine, {key: value_of(machine, key) * drawn.choice(around, count, replace=False) for key in keys}
        )
        begin = thread_time()
        Members(machine, given, None, 0, "member").sorted(plan, "refuse", interpolate=interpolate)
        return (thread_time() - begin) / count

    ours, theirs = taken(10 * MADE, True), taken(MADE, False)
    note = f"{10 * MADE} members on a shaft: mass of the disk and of a ball; one core, without their runs"
    return compared("member_made_ready_disk_on_shaft", ours, "made anew one by one", theirs, note=note)


def against_heyoka(machine: Machine) -> dict[str, Any]:
    """The same members without contact at the same error, only their ends; heyoka at its best width."""
    ours, theirs = best(machine, []), min((heyoka_batch(width) for width in (2, 4, 8)), key=lambda found: found.at_goal)
    note = (
        f"the ends of {MEMBERS} members without contact, both at a median error of {GOAL:g} turns, between two tolerances; ours "
        f"{ours.method}, {ours.text}; theirs {theirs.method} at once, {theirs.text}"
    )
    return compared("ensemble_vs_heyoka_batch", ours.at_goal, "heyoka, batch mode", theirs.at_goal, note=note)


def heyoka_batch(width: int) -> Found:
    """So many members at once, against a tolerance of 1e-14. Compilation is not counted."""
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

    def tried() -> Iterator[tuple[float, float, float]]:
        for tolerance in LADDER_BATCH:
            seconds, angles = ends(tolerance)
            yield tolerance, median_miss(angles, exact), min(seconds, *(ends(tolerance)[0] for _ in range(REPEATS - 1)))

    return reached(width, tried())

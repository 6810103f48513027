"""Fewer and fewer designs, with more and more runs of each: closed forms, short runs, full runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from autobalancer.errors import MachineError
from autobalancer.laws.deep_chamber.fluid import covering_fill
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.archive.folder import Archive
from autobalancer.simulation.chamber.bounds import ChamberBounds, bounds
from autobalancer.simulation.chamber.filling import fill
from autobalancer.studies.chamber_design.candidate import Candidate, machine_of
from autobalancer.studies.chamber_design.limits import numbers_of, ruled_out
from autobalancer.studies.chamber_design.statistics import fronts
from autobalancer.studies.chamber_many import Job, Many, measured_runs

BOUNDS, FULL = "bounds", "full runs"  # names of the first and the last stage
HARDLY = 0.9  # of the vibration without balls: balls that leave more than that balance nothing


@dataclass
class Design:
    """A candidate on its way: bounds and machines by unbalance, where it stopped and why, and its runs."""

    candidate: Candidate
    stage: str = BOUNDS
    reason: str = ""
    bounds: dict[float, ChamberBounds] = field(default_factory=dict)
    machines: dict[float, ChamberMachine] = field(default_factory=dict)
    short: dict[tuple[float, int], dict[str, Any]] = field(default_factory=dict)
    full: dict[tuple[float, int], dict[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Question:
    """How designs are run."""

    unbalances: tuple[float, ...]
    duration: float
    short: float
    last: float
    fillings: int
    finalists: int
    archive: Archive | None
    workers: int | None
    progress: Callable[[int, int], None] | None


def bounded(
    machine: ChamberMachine, found: Sequence[Candidate], limits: dict[str, float], asked: Question
) -> list[Design]:
    """All designs, with the reasons of those that closed forms rule out."""
    return [_bounded(machine, candidate, limits, asked.unbalances) for candidate in found]


def _bounded(
    machine: ChamberMachine, candidate: Candidate, limits: dict[str, float], unbalances: Sequence[float]
) -> Design:
    design = Design(candidate)
    reasons = _of_the_fluid(machine, candidate)
    try:
        for size in unbalances:
            design.machines[size] = machine_of(machine, candidate, size)
            design.bounds[size] = bounds(design.machines[size])
        fill(design.machines[unbalances[0]])
    except MachineError as reason:
        design.reason = f"does not fit: {reason}"
        return design
    for size in unbalances:
        own = design.bounds[size]
        reasons += [text for text in ruled_out(own, limits) if text not in reasons]
        floating = own.capability * (1.0 - candidate.fluid_density / candidate.density)
        if floating < own.unbalance <= own.capability:
            reasons.append(f"in the fluid the balls can balance {floating:.3g} of {own.unbalance:.3g} kg m only")
    design.reason = "; ".join(reasons)
    return design


def _of_the_fluid(machine: ChamberMachine, candidate: Candidate) -> list[str]:
    if not candidate.viscosity > 0.0:
        return []
    chamber, reasons = machine.chambers[0], []
    if candidate.fluid_density >= candidate.density:
        return ["the balls float"]
    needed = covering_fill(float(chamber.radius), 0.5 * candidate.diameter)
    if candidate.fill < needed:
        reasons.append(
            f"the fluid does not cover the balls at speed: it fills {candidate.fill:.3g}, needed is {needed:.3g}"
        )
    volume = math.pi * (float(chamber.radius) ** 2 - float(chamber.inner_radius) ** 2) * chamber.inner_depth
    share = candidate.total_mass / candidate.density / volume
    if candidate.fill + share > 1.0:
        reasons.append(f"fluid ({candidate.fill:.3g}) and balls ({share:.3g}) do not go into the chamber together")
    return reasons


def rounds(alive: int, finalists: int, fillings: int) -> list[tuple[int, int]]:
    """Designs and fillings of each round of short runs: half of the designs and twice the fillings from round to round."""
    found, runs = [], 1
    while alive > finalists:
        found.append((alive, runs))
        alive, runs = max(finalists, math.ceil(alive / 2)), min(2 * runs, fillings)
    return found


def screened(designs: Sequence[Design], asked: Question) -> None:
    """Short runs of what the closed forms left, then full runs of the few best; the designs keep what was found."""
    alive = [design for design in designs if not design.reason]
    plan = rounds(len(alive), asked.finalists, asked.fillings)
    cases = len(asked.unbalances)
    # a filling is run once: a round adds to those of the round before it
    added = [(count, runs - before) for (count, runs), (_, before) in zip(plan, [(0, 0), *plan], strict=False)]
    left = min(asked.finalists, len(alive))
    total = cases * (sum(count * runs for count, runs in added) + left * asked.fillings)
    done = 0

    def told(now: int, _: int) -> None:
        if asked.progress is not None:
            asked.progress(done + now, total)

    for number, (_, runs) in enumerate(plan, 1):
        name = f"round {number}"
        jobs = [(design, size, seed) for design in alive for size in asked.unbalances for seed in range(runs)]
        jobs = [job for job in jobs if job[1:] not in job[0].short]
        for (design, size, seed), row in zip(jobs, _run(jobs, asked.short, asked, told), strict=True):
            design.short[size, seed] = row
        done += len(jobs)
        alive = _halved(alive, name, max(asked.finalists, math.ceil(len(alive) / 2)))
    jobs = [(design, size, seed) for design in alive for size in asked.unbalances for seed in range(asked.fillings)]
    for (design, size, seed), row in zip(jobs, _run(jobs, asked.duration, asked, told), strict=True):
        design.full[size, seed] = row
        design.stage = FULL


def _run(
    jobs: Sequence[tuple[Design, float, int]], duration: float, asked: Question, told: Callable[[int, int], None]
) -> list[dict[str, Any]]:
    last = min(asked.last, 0.5 * duration)
    runs = [
        Job(design.candidate.run_name(size, duration, last, seed), design.machines[size], seed, {"unbalance": size})
        for design, size, seed in jobs
    ]
    rows = measured_runs(runs, Many(duration, last, asked.archive, asked.workers), told)
    return [
        {"outcome": row["outcome"], **(numbers_of(design.machines[size], row) if row["outcome"] == "finished" else {})}
        for (design, size, _), row in zip(jobs, rows, strict=True)
    ]


def _halved(alive: Sequence[Design], name: str, keep: int) -> list[Design]:
    """The ``keep`` best by what turns with the rotor and the mass of the balls; the others stop here.

    Of those that balance nothing yet, the ones whose balls go around come first.
    """
    left = np.array([left_in_short_runs(design) for design in alive])
    mass = np.array([design.candidate.total_mass for design in alive])
    hopeless = left > HARDLY
    front = fronts(np.where(hopeless, np.nan, left), mass)
    around = [_carried(design) if bad else 0.0 for design, bad in zip(alive, hopeless, strict=True)]
    order = sorted(range(len(alive)), key=lambda i: (hopeless[i], -around[i], front[i], left[i], mass[i]))
    for i in order[keep:]:
        alive[i].stage = name
        alive[i].reason = f"{name} left {100.0 * left[i]:.3g} % of the vibration without balls; others were better"
    chosen = sorted(order[:keep])
    return [alive[i] for i in chosen]


def _carried(design: Design) -> float:
    """Mean share of the balls that go around in the short runs."""
    return float(np.mean([row.get("share_carried", 0.0) for row in design.short.values()]))


def left_in_short_runs(design: Design) -> float:
    """Mean over the fillings of the vibration that turns with the rotor, over that without balls, at the worst unbalance.

    nan without short runs.
    """
    if not design.short:
        return math.nan
    found = []
    for size, own in design.bounds.items():
        rows = [row.get("synchronous", math.inf) for (case, _), row in design.short.items() if case == size]
        found.append(float(np.mean(rows)) / own.vibration_without_balls)
    return max(found)

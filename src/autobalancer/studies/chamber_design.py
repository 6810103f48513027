"""Which balls and which fluid a deep chamber should have: bounds, short runs, full runs of the few best."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import balls_in_chambers, machine_text
from autobalancer.laws.deep_chamber import covering_fill
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.progress import shows_progress
from autobalancer.results.answers.kinds import ChamberDesigns
from autobalancer.results.archive import Archive
from autobalancer.results.provenance import provenance
from autobalancer.simulation.chamber.bounds import ChamberBounds, bounds, fill
from autobalancer.studies.chamber_candidates import (
    JUDGED,
    SURE,
    Candidate,
    fronts,
    judged_runs,
    machine_of,
    mean_interval,
    ruled_out,
    share_interval,
    worse_than_worst,
)
from autobalancer.studies.chamber_candidates import candidates as all_candidates
from autobalancer.studies.chamber_study import Job, RunSettings
from autobalancer.units import argument, optional_argument
from autobalancer.units.quantity import list_argument, listed

# The designs of a deep chamber that balance best within limits (Pakuła 2021, section 5, asks for them).


LIMITS = {name: entry.unit for name, entry in JUDGED.items() if name != "share_carried"} | {"pick_up": "1"}


@shows_progress
def design(
    machine: ChamberMachine | str | Path,
    candidates: Mapping[str, Any],
    limits: Mapping[str, Any] | None = None,
    *,
    duration: float | str,
    short: float | str | None = None,
    last: float | str | None = None,
    unbalances: Sequence[float | str] | str | None = None,
    fillings: int = 5,
    finalists: int = 4,
    archive: Archive | str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Find the balls, the friction and the fluid with which a deep chamber balances best.

    Three stages. Closed forms rule out what cannot be good (:func:`bounds`). Short runs, of one filling at first, halve what is
    left again and again and double the fillings. Full runs with all fillings judge the few best.

    Parameters
    ----------
    machine
        With one deep chamber and one group of balls. Chamber, rotor, body and drive stay as they are.
    candidates
        What there is to choose from, all combinations of it: ``balls`` (numbers), ``diameter`` or ``total_mass``, ``density``,
        ``friction``, ``ball_friction`` (of balls on balls), ``viscosity`` (dynamic, 0 for a dry chamber) with
        ``fluid_density`` and ``fill`` (share of the chamber). What is missing stays as in the machine.
    limits
        Most values that any filling may reach, of ``vibration``, ``synchronous`` (what of it turns with the rotor),
        ``residual_unbalance``, ``settling_time``, ``run_up_peak``, ``bearing_force``, ``contact_force`` and
        ``contact_pressure``; and ``pick_up``, the least share of the runs in which all balls go around.
    duration, short
        Of the full and of the short runs, s; short ones by default half as long. Balls may be carried up late.
    last
        Seconds at the end that are the steady state; by default a tenth of ``duration``.
    unbalances
        Sizes for which a design must work, kg m; by default that of the machine. The worst one counts.
    fillings
        Of each full run: seeds 0, 1, ...
    finalists
        Designs that get full runs.
    archive
        Folder that keeps all runs. With it a search that was stopped goes on, and finished runs are not repeated.
    workers
        Threads; the answer does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``design``: what it is, its bounds, ``stage`` and ``reason``, means, intervals and worst values of the full runs,
        whether it ``meets`` the limits, and its place; over ``design``, ``unbalance`` and ``seed`` the numbers of every full run.

    Raises
    ------
    QuestionError
        For names, numbers or ranges that make no sense, or if closed forms rule out every design; the message says why.
    """
    machine, duration = balls_in_chambers(machine), argument("duration", duration, "s")
    short = optional_argument("short", short, "s")
    last = optional_argument("last", last, "s")
    for name, value in (("duration", duration), ("short", short), ("last", last)):
        if value is not None and not value > 0.0:
            raise QuestionError(f"{name}: given {value:g} s; must be above zero")
    short, last = 0.5 * duration if short is None else short, 0.1 * duration if last is None else last
    if short > duration or last > duration:
        raise QuestionError(f"short, last: given {short:g} s and {last:g} s; a full run lasts {duration:g} s only")
    for name, count in (("fillings", fillings), ("finalists", finalists)):
        if count < 1:
            raise QuestionError(f"{name}: given {count}; must be at least 1")
    if machine.body.freedom == "fixed":
        raise QuestionError("machine: its body is fixed, so the balls do not feel the unbalance; free it")
    sizes = _unbalances(machine, unbalances)
    requested = Question(sizes, duration, short, last, fillings, finalists, archive, workers, progress)
    told = _read_limits(limits)
    if "contact_pressure" in told and machine.contact.youngs_modulus is None:
        raise QuestionError("limits: contact_pressure: needs the material of the balls; give contact.youngs_modulus")
    designs = bounded(machine, all_candidates(machine, candidates), told, requested)
    if all(result.reason for result in designs):
        raise QuestionError(_none_left(designs))
    screened(designs, requested)
    return designs_dataset(machine, designs, told, requested)


def _read_limits(options: Mapping[str, Any] | None) -> dict[str, float]:
    """Limits in SI by name: most values, of ``pick_up`` the least share of the runs in which all balls are carried."""
    limits = {}
    for name, value in (options or {}).items():
        if name not in LIMITS:
            raise QuestionError(f"limits: given {name!r}; must be one of {', '.join(LIMITS)}")
        read = argument(f"limits: {name}", value, "" if LIMITS[name] == "1" else LIMITS[name].replace(" ", "*"))
        if not 0.0 < read < math.inf:
            raise QuestionError(f"limits: {name}: given {read:g}; must be above zero, and finite")
        if name == "pick_up" and read > 1.0:
            raise QuestionError(f"limits: pick_up: given {read:g}; it is a share of the runs, at most 1")
        limits[name] = read
    return limits


def _unbalances(machine: ChamberMachine, values: Sequence[float | str] | str | None) -> tuple[float, ...]:
    own = float(abs(sum(part.vector for part in machine.unbalances)))
    if not own > 0.0:
        raise QuestionError(
            "machine: its rotor has no unbalance to balance; give unbalances, with their sizes here if you like"
        )
    if values is None:
        return (own,)
    listing = isinstance(values, str) and "," in values
    sizes = listed("unbalances", str(values), "kg*m") if listing else list_argument("unbalances", values, "kg*m")
    if not sizes or any(not size > 0.0 for size in sizes):
        raise QuestionError(f"unbalances: given {values!r}; must be above zero")
    return tuple(sorted(set(sizes)))


def _none_left(designs: Sequence[Any]) -> str:
    """How many designs each reason rules out; texts that differ in their numbers only count as one."""
    counts: dict[str, list[str]] = {}
    for design in designs:
        for reason in design.reason.split("; "):
            kind = " ".join(word for word in reason.split() if not any(sign.isdigit() for sign in word))
            counts.setdefault(kind, []).append(f"{design.candidate.label}: {reason}")
    lines = [f"{len(texts)} of {len(designs)}, such as {texts[0]}" for texts in counts.values()]
    return f"candidates: closed forms rule out every design. {'. '.join(lines)}. Take other candidates, or wider limits"


# What became of each design, as one dataset.


CHOSEN = {  # of a candidate
    "balls": "",
    "diameter": "m",
    "total_mass": "kg",
    "density": "kg/m^3",
    "friction": "1",
    "ball_friction": "1",
    "viscosity": "Pa s",
    "fluid_density": "kg/m^3",
    "fill": "1",
}
BOUNDED = {  # of the bounds, and which of those for several unbalances counts
    "capability": ("kg m", min),
    "swung_residual": ("kg m", max),
    "held_residual": ("kg m", max),
    "vibration_without_balls": ("m", max),
    "least_friction": ("1", max),
    "drag_ratio": ("1", min),
    "shaking": ("1", max),
    "decay_rate": ("1/s", min),
    "least_settling_time": ("s", max),
    "race_force": ("N", max),
    "race_pressure": ("Pa", max),
    "greatest_couple": ("kg m^2", max),
    "couple_bearing_force": ("N", max),
}
ALL_CARRIED = 1.0 - 1e-9


def designs_dataset(
    machine: ChamberMachine, designs: Sequence[Design], limits: dict[str, float], requested: Question
) -> ChamberDesigns:
    """Everything that is known of the designs; see :func:`~autobalancer.chamber.design`."""
    numbers = np.arange(1, len(designs) + 1)
    dataset = xr.Dataset(
        coords={"design": numbers, "unbalance": list(requested.unbalances), "seed": list(range(requested.fillings))}
    )
    dataset["unbalance"].attrs["units"] = "kg m"
    dataset["label"] = ("design", np.array([design.candidate.label for design in designs], object))
    for name, unit in CHOSEN.items():
        dataset[name] = _along([float(getattr(design.candidate, name)) for design in designs], unit, name)
    dataset["balls"] = dataset["balls"].astype(int)
    for name in ("stage", "reason"):
        dataset[name] = ("design", np.array([getattr(design, name) for design in designs], object))
    for name, (unit, worst) in BOUNDED.items():
        held = [[getattr(own, name) for own in design.bounds.values()] for design in designs]
        dataset[name] = _along([worst(values) if values else math.nan for values in held], unit, name)
    dataset["short_left"] = _along([left_in_short_runs(design) for design in designs], "1", "short_left")
    dataset["short_left"].attrs["long_name"] = (
        "vibration that turns with the rotor in the short runs, over that without balls"
    )
    for name, entry in JUDGED.items():
        values = [
            [
                [design.full.get((size, seed), {}).get(name, math.nan) for seed in range(requested.fillings)]
                for size in requested.unbalances
            ]
            for design in designs
        ]
        attrs = {"units": entry.unit, "long_name": entry.text}
        dataset[name] = (("design", "unbalance", "seed"), np.array(values, np.float64), attrs)
    full = np.array([design.stage == FULL for design in designs])
    _summarize(dataset, full)
    _judge(dataset, full, limits)
    dataset.attrs = {
        "title": f"Designs of {machine.name}",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "limits": json.dumps(limits),
        "confidence": SURE,
        "worse_than_worst": worse_than_worst(requested.fillings),
        "duration": requested.duration,
        "short": requested.short,
        "last": requested.last,
    }
    return ChamberDesigns.of(dataset)


def _along(values: Any, unit: str, name: str) -> Any:
    return "design", np.array(values, np.float64), {"units": unit, "long_name": name.replace("_", " ")}


def _summarize(dataset: xr.Dataset, full: Any) -> None:
    """Means with intervals at the unbalance at which the mean is greatest, and worst values of all runs."""
    runs = dataset["vibration"].values
    rows = [max((mean_interval(case) for case in run), key=lambda row: row[0]) for run in runs]
    for k, name in enumerate(("vibration_mean", "vibration_low", "vibration_high")):
        dataset[name] = _along(
            [row[k] if there else math.nan for row, there in zip(rows, full, strict=True)], "m", name
        )
    for name, entry in JUDGED.items():
        # a run without this number, as it did not finish or never settled, is the worst of all
        dataset[f"worst_{name}"] = _along(
            dataset[name].values.reshape(full.size, -1).max(axis=1), entry.unit, f"worst {name}"
        )
    carried = dataset["share_carried"].values >= ALL_CARRIED
    shares = [min(share_interval(int(case.sum()), case.size) for case in one) for one in carried]
    for k, name in enumerate(("pick_up", "pick_up_low", "pick_up_high")):
        dataset[name] = _along(
            [row[k] if there else math.nan for row, there in zip(shares, full, strict=True)], "1", name
        )


def _judge(dataset: xr.Dataset, full: Any, limits: dict[str, float]) -> None:
    """Which designs meet the limits, in which order they are best, and which none of the others beats."""
    excess = np.where(full, 0.0, math.nan)
    missed: list[list[str]] = [[] for _ in full]
    for name, limit in limits.items():
        values = dataset["pick_up" if name == "pick_up" else f"worst_{name}"].values
        with np.errstate(divide="ignore"):
            over = limit / values - 1.0 if name == "pick_up" else values / limit - 1.0
        over = np.where(np.isnan(over), math.inf, np.maximum(over, 0.0))
        excess = excess + over
        for i in np.flatnonzero(full & (over > 0.0)):
            missed[i].append(name)
    meets = full & (excess == 0.0)
    dataset["meets"] = ("design", meets.astype(int), {"long_name": "meets all limits (1) or not (0)"})
    dataset["missed"] = ("design", np.array([", ".join(names) for names in missed], object))
    vibration, mass = dataset["worst_vibration"].values, dataset["total_mass"].values
    order = sorted(np.flatnonzero(full), key=lambda i: (excess[i], _last(float(vibration[i])), mass[i]))
    place = np.full(full.size, math.nan)
    place[order] = np.arange(1, len(order) + 1)
    dataset["place"] = _along(place, "", "place, 1 is the best")
    for name, other in (("pareto_mass", mass), ("pareto_settling", dataset["worst_settling_time"].values)):
        on = fronts(np.where(full, vibration, math.nan), other) == 0
        text = "no other one has both less worst vibration and less " + (
            "mass of balls" if name == "pareto_mass" else "settling time"
        )
        dataset[name] = ("design", (on & np.isfinite(other) & full).astype(int), {"long_name": text})


def _last(value: float) -> float:
    return math.inf if math.isnan(value) else value


# Fewer and fewer designs, with more and more runs of each: closed forms, short runs, full runs.


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
    archive: Archive | str | Path | None
    workers: int | None
    progress: Callable[[int, int], None] | None


def bounded(
    machine: ChamberMachine, candidates: Sequence[Candidate], limits: dict[str, float], requested: Question
) -> list[Design]:
    """All designs, with the reasons of those that closed forms rule out."""
    return [_bounded(machine, candidate, limits, requested.unbalances) for candidate in candidates]


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
    result, runs = [], 1
    while alive > finalists:
        result.append((alive, runs))
        alive, runs = max(finalists, math.ceil(alive / 2)), min(2 * runs, fillings)
    return result


def screened(designs: Sequence[Design], requested: Question) -> None:
    """Short runs of what the closed forms left, then full runs of the few best; the designs keep what was found."""
    alive = [design for design in designs if not design.reason]
    plan = rounds(len(alive), requested.finalists, requested.fillings)
    cases = len(requested.unbalances)
    # a filling is run once: a round adds to those of the round before it
    added = [(count, runs - before) for (count, runs), (_, before) in zip(plan, [(0, 0), *plan], strict=False)]
    left = min(requested.finalists, len(alive))
    total = cases * (sum(count * runs for count, runs in added) + left * requested.fillings)
    done = 0

    def told(now: int, _: int) -> None:
        if requested.progress is not None:
            requested.progress(done + now, total)

    for number, (_, runs) in enumerate(plan, 1):
        name = f"round {number}"
        jobs = [(design, size, seed) for design in alive for size in requested.unbalances for seed in range(runs)]
        jobs = [job for job in jobs if job[1:] not in job[0].short]
        for (design, size, seed), row in zip(jobs, _run(jobs, requested.short, requested, told), strict=True):
            design.short[size, seed] = row
        done += len(jobs)
        alive = _halved(alive, name, max(requested.finalists, math.ceil(len(alive) / 2)))
    jobs = [
        (design, size, seed) for design in alive for size in requested.unbalances for seed in range(requested.fillings)
    ]
    for (design, size, seed), row in zip(jobs, _run(jobs, requested.duration, requested, told), strict=True):
        design.full[size, seed] = row
        design.stage = FULL


def _run(
    jobs: Sequence[tuple[Design, float, int]], duration: float, requested: Question, told: Callable[[int, int], None]
) -> list[dict[str, Any]]:
    last = min(requested.last, 0.5 * duration)
    runs = [
        Job(design.candidate.run_name(size, duration, last, seed), design.machines[size], seed, {"unbalance": size})
        for design, size, seed in jobs
    ]
    return judged_runs(runs, RunSettings(duration, last, requested.archive, requested.workers), told)


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
    result = []
    for size, own in design.bounds.items():
        rows = [row.get("synchronous", math.inf) for (case, _), row in design.short.items() if case == size]
        result.append(float(np.mean(rows)) / own.vibration_without_balls)
    return max(result)

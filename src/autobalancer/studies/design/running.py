"""Runs of a design with scatter: unbalance, temperature, starts and what else the specification lets vary."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Collection, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.place_response import off_center
from autobalancer.assembly.places import places_of
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.catalog.resolve import resolve
from autobalancer.catalog.small_tables import friction
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine import Machine
from autobalancer.results.answers.studied import Studied
from autobalancer.results.number_text import length_text, moment_text
from autobalancer.results.shares import wilson_interval
from autobalancer.results.verdict import NO_VERDICT, NOT_SETTLED, WORSE
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.stability.friction import held_by_friction
from autobalancer.studies.chamber_design.candidate import fronts
from autobalancer.studies.design.answer import STAGES
from autobalancer.studies.design.candidate import Candidate, driven, machine_of
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import MASS, MEASURED, OUTER, STALL, Spec
from autobalancer.studies.study.chunk import Made
from autobalancer.studies.study.reading import read_study, vary
from autobalancer.studies.study.study import study

TYPICAL = "bearing ring in a running balancer"  # of the catalog: the friction that is assumed to say what any would do
FRICTION = ("friction", "rolling_resistance", "adherence")  # in names of what may vary
STEPS = 101  # temperatures that stand for a range, where a fluid is no single one of the catalog
Report = Callable[[int, int], None] | None


class Case(NamedTuple):
    """Runs of one kind: to an operating speed, or there and back, which only the peak is asked of."""

    name: str
    found: Studied
    coasting: bool


def runs_of(
    spec: Spec, one: Candidate, folder: Path | None, workers: int | None, progress: Report, seed: int | None = None
) -> list[Case]:
    """All runs that judge a candidate; finished ones are taken from the folder.

    Raises
    ------
    QuestionError
        If the scatter makes impossible machines.
    """
    machine = machine_of(spec, one, 0.5 * sum(spec.temperature), spec.unbalance[1])
    cases = [
        (f"{speed:.6g} rad/s", driven(spec, machine, speed, coasting=False), False) for speed in spec.operation.speeds
    ]
    if spec.operation.coast_down:
        cases.append(("coast-down", driven(spec, machine, spec.fastest, coasting=True), True))
    found = []
    for name, described, coasting in cases:
        asked = study_of(spec, described, one, spec.search.seed if seed is None else seed)
        place = folder / name_of(spec, one, name) if folder is not None else None
        found.append(Case(name, study(asked, folder=place, workers=workers, progress=progress), coasting))
    return found


def judge_scatter(spec: Spec, found: Design) -> None:
    """Rule out a design of which the scatter makes no possible machine, as its runs would, before anything runs.

    Raises
    ------
    QuestionError
        With the key at fault, for a scatter or temperatures of the machine's own fluid that no design can have.
    """
    if spec.scatter and found.machine is not None:
        vary(found.machine, spec.scatter, "scatter")
    if found.machine is not None and not found.candidate.fluid:
        _temperatures(spec, found.machine, found.candidate)
    if not spec.scatter or found.machine is None:
        return
    machine = driven(spec, found.machine, spec.fastest, coasting=False)
    try:
        Made(read_study(study_of(spec, machine, found.candidate, spec.search.seed)), 0, 1)
    except AutobalancerError as reason:
        text = str(reason).removeprefix("impossible: draw 1 made")
        found.rule_out(STAGES[-1], f"the scatter makes{text}" if text != str(reason) else f"cannot be run: {reason}")


def left_out(spec: Spec, machine: Machine) -> str:
    """What the runs leave out of a machine that nobody said is ideal: eccentricity and friction, and what typical ones would do.

    They are no scatter by themselves, since coefficients of friction differ by thousands from race to race: a value that nobody
    gave would decide the order.
    """
    found = list[str]()
    if not any("eccentricity" in name for name in spec.scatter):
        away = off_center(
            places_of(machine, assemble(machine, lags=diffusing_lags(machine))), resolve(machine), spec.fastest
        )
        for plane in away.planes if away is not None else ():
            if not plane.given:
                left = f" and {moment_text(plane.residual)}" * math.isfinite(plane.residual)
                size = length_text(plane.eccentricity)
                found.append(
                    f"eccentricity of the race: {size}, as is typical, would leave a vibration of {size}{left}"
                )
                break
    races = [
        f"balancers[{b}].races[{r}]" for b, part in enumerate(machine.balancers, 1) for r, _ in enumerate(part.races, 1)
    ]
    named = any(word in name for name in spec.scatter for word in FRICTION)
    if not named and all(race.friction is None for balancer in machine.balancers for race in balancer.races):
        typical = next(one for one in friction() if one.name == TYPICAL)
        for race in races:
            rolling = {"adherence": typical.adherence, "rolling_resistance": typical.rolling_resistance}
            machine = with_value_at(machine, f"{race}.friction", rolling)
        held = max((plane.residual_95 for plane in held_by_friction(machine, spec.fastest).planes), default=0.0)
        found.append(
            f"friction: that of a {TYPICAL} (adherence {typical.adherence:g}) would leave up to {moment_text(held)} in 95 % of "
            "starts at this speed, that of others more"
        )
    return "; ".join([*found, "give them in the machine or in [scatter], 0 for none"]) if found else ""


def study_of(spec: Spec, machine: Machine, one: Candidate, seed: int) -> dict[str, Any]:
    """The study that runs a machine with the scatter of the specification, as a dict of the form of study files."""
    low, high = spec.unbalance
    vary: dict[str, Any] = {"unbalance": {"distribution": "uniform", "low": low, "high": high}} if low < high else {}
    vary |= _temperatures(spec, machine, one) | spec.scatter
    return {
        "machine": machine,
        "members": spec.search.members,
        "seed": seed,
        "tolerance": spec.search.tolerance,
        "impossible": "truncate",
        "settling_from": spec.search.settling_from,
        "vary": vary,
    }


def _temperatures(spec: Spec, machine: Machine, one: Candidate) -> dict[str, Any]:
    low, high = spec.temperature
    if low == high:
        return {}
    fluids = {race.fluid for balancer in machine.balancers for race in balancer.races}
    if all(fluid is not None and fluid.name is not None for fluid in fluids):
        return {"temperature": {"distribution": "uniform", "low": low, "high": high}}
    if len(one.fillings) != 1:
        which = one.fluid or "the fluid of the machine"
        raise QuestionError(
            f"temperature: given from {low - 273.15:.4g} to {high - 273.15:.4g} °C, which is known for fluids of the catalog "
            f"and for one blend in all races, not for {which}; give one temperature"
        )
    middles = low + (high - low) * (np.arange(STEPS) + 0.5) / STEPS
    values = [one.fillings[0].at(float(temperature))[1] for temperature in middles]
    return {"viscosity": {"distribution": "discrete", "values": values}}


def name_of(spec: Spec, one: Candidate, case: str) -> str:
    """The name of the folder of a design's runs: the same for the same design."""
    return hashlib.sha256(repr((one.key(), case)).encode()).hexdigest()[:16]


# Numbers of a design from its runs, and whether it keeps the limits: shares with their 95 % intervals (Wilson 1927).


FINISHED = "finished"
PEAK = "peak_deflection"
Flags = NDArray[np.bool_]
KEPT, OPEN, MISSED = 1, 0, -1


def judge_runs(spec: Spec, found: Design, cases: Sequence[Case]) -> None:
    """Fill the numbers of a design.

    Of several cases the worst one counts. Of a measure: its value that the wanted share of the runs stays below, its median, the
    share of runs above the limit with its interval. of stall those of :func:`stalled`.
    """
    numbers = found.numbers
    for name in MEASURED:
        parts: list[dict[str, float]] = [
            _measure(spec, name, case) for case in cases if name == PEAK or not case.coasting
        ]
        numbers.update(max(parts, key=partial(_badness, name)))
    found.drag_warning, found.passage = (
        next(filter(None, (str(case.found.attrs.get(name, "")) for case in cases)), "")
        for name in ("drag_warning", "passage_text")
    )
    ups = [case.found for case in cases if not case.coasting]
    numbers |= max((_share("stall", stalled(one)) for one in ups), key=lambda part: part["stall"])
    numbers |= min((_share("balanced", balanced(one)) for one in ups), key=lambda part: part["balanced"])


def _badness(name: str, part: dict[str, float]) -> tuple[float, float]:
    return part.get(f"{name}_over", 0.0), part[name]


def _measure(spec: Spec, name: str, case: Case) -> dict[str, float]:
    values = values_of(case.found, name)
    found = {name: _level(values, spec.share), f"{name}_median": _level(values, 0.5)}
    limit = spec.limits.get(name)
    return found if limit is None else found | _share(f"{name}_over", ~(values <= limit))


def values_of(found: Studied, name: str) -> NDArray[np.float64]:
    """A measure of all runs; infinite where a run did not end or has no such number, as a ball that never settles."""
    values = np.asarray(found[name].values, np.float64) if name in found else np.full(found.sizes["member"], np.nan)
    return np.where(np.isfinite(values) & (found["outcome"].values == FINISHED), values, math.inf)


def _level(values: NDArray[np.float64], share: float) -> float:
    """The value that at least this share of the runs does not exceed."""
    ordered = np.sort(values)
    return float(ordered[min(math.ceil(share * ordered.size) - 1, ordered.size - 1)])


def stalled(found: Studied) -> Flags:
    """Which runs end stalled, or do not end.

    A ball stalls that has not settled, was stalled and never broke away, or makes the vibration worse than without balls at the
    end. The rotor stalls that stays near its lowest critical speed for more than half of the run, as with a weak motor.
    """
    restless = ~np.isfinite(values_of(found, "settling_time"))
    hung = found["stalled_time"].values > 0.0
    bad = np.isin(found["verdict"].values.astype(str), (WORSE, NO_VERDICT, NOT_SETTLED)) | ~np.isfinite(
        found["release_speed"].values
    )
    stuck = found["time_at_resonance"].values > 0.5 * float(found.attrs["duration"])
    return np.asarray((restless & hung & bad) | stuck | (found["outcome"].values != FINISHED))


def balanced(found: Studied) -> Flags:
    """Which runs end balanced."""
    return np.asarray(found["balanced"].values.astype(bool) & (found["outcome"].values == FINISHED))


def _share(name: str, which: Flags) -> dict[str, float]:
    count, total = int(which.sum()), int(which.size)
    low, high = wilson_interval(np.array([count]), total)
    return {name: count / total, f"{name}_low": float(low[0]), f"{name}_high": float(high[0])}


def verdicts(spec: Spec, found: Design) -> dict[str, int]:
    """Each limit on the runs: kept, missed, or open because so few runs cannot tell."""
    shares = {name: (f"{name}_over", 1.0 - spec.share) for name in MEASURED if name in spec.limits}
    if STALL in spec.limits:
        shares[STALL] = ("stall", spec.limits[STALL])
    return {limit: _verdict(found.numbers, share, allowed) for limit, (share, allowed) in shares.items()}


def _verdict(numbers: dict[str, float], share: str, allowed: float) -> int:
    if numbers[f"{share}_high"] <= allowed:
        return KEPT
    return MISSED if numbers[f"{share}_low"] > allowed else OPEN


# The order of the designs that ran: limits, how many are missed and by how much, then the Pareto front.


def objective(found: Design, name: str) -> float:
    """A number of a design that should be small."""
    if name == MASS:
        return found.ball_mass
    return found.candidate.ring.outer if name == OUTER else found.numbers.get(name, math.nan)


def meets(spec: Spec, found: Design) -> int:
    """1: keeps all limits; 0: too few runs to say; -1: misses one."""
    return min(verdicts(spec, found).values(), default=1)


def missed(spec: Spec, found: Design) -> str:
    """The limits that it misses, and those of which too few runs say nothing."""
    found_of = verdicts(spec, found)
    texts = [name.replace("_", " ") for name, one in found_of.items() if one == MISSED]
    return ", ".join(texts + [f"{name.replace('_', ' ')} undecided" for name, one in found_of.items() if one == OPEN])


def misses(spec: Spec, found: Design) -> dict[str, float]:
    """The limits that it misses, each with how far it is beyond it, over the limit."""
    beyond = {name: one for name, one in verdicts(spec, found).items() if one == MISSED}
    return {name: found.numbers["stall" if name == STALL else name] / spec.limits[name] - 1.0 for name in beyond}


def _added_up(beyond: Collection[float]) -> tuple[int, float]:
    """How many have no end, as a settling time of balls that never settle, and the sum of the others."""
    finite = [one for one in beyond if math.isfinite(one)]
    return len(beyond) - len(finite), sum(finite)


def used(spec: Spec, found: Design) -> float:
    """The greatest share of a limit that it uses up; 0 without limits on the runs."""
    shares = [found.numbers[name] / spec.limits[name] for name in MEASURED if name in spec.limits]
    if STALL in spec.limits:
        shares.append(found.numbers["stall"] / spec.limits[STALL])
    return max(shares, default=0.0)


def ordered(spec: Spec, ran: Sequence[Design]) -> list[tuple[Design, int]]:
    """Designs that ran, the best first, each with the number of its front.

    First those that keep all limits, then those of which the runs cannot tell, then those that miss one, two and so on: classes.
    On front 0 of a class nothing is better in both objectives. Those that miss limits are ordered by how far they are beyond
    them, in shares of each added up; all others front by front, and on a front the one whose two objectives have the smallest
    product: a little of one is given for much of the other, in shares of each.
    """
    found: list[tuple[Design, int]] = []
    beyond = {id(one): misses(spec, one) for one in ran}
    classes = {id(one): (-meets(spec, one), len(beyond[id(one)])) for one in ran}
    for level in sorted(set(classes.values())):
        group = [one for one in ran if classes[id(one)] == level]
        values = np.array([[objective(one, name) for name in spec.search.objectives] for one in group])
        front = fronts(values[:, 0], values[:, 1])
        with np.errstate(invalid="ignore"):
            product = np.where(np.isfinite(values).all(axis=1), values.prod(axis=1), math.inf)
        excess = [_added_up(beyond[id(one)].values()) for one in group]
        order = sorted(
            range(len(group)),
            key=lambda i: (excess[i], front[i], product[i], used(spec, group[i]), group[i].candidate.label),
        )
        found += [(group[i], int(front[i])) for i in order]
    return found

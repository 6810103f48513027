"""Design of balancers: candidates screened, run with scatter and ranked, from a specification file or a dict."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.assembly.places import off_center, places_of
from autobalancer.assembly.quantities import in_author_units, with_author_springs, with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.catalog.product_tables import friction
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError, ResultError
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.answers.studied import Studied
from autobalancer.results.display_units import length_text, moment_text
from autobalancer.results.folder_store import Store
from autobalancer.results.store import load_run, save_run
from autobalancer.rotordynamics.receptances import fit_text
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.stability.friction import OF_RELEASED, held_by_friction
from autobalancer.studies.design.candidate import (
    Candidate,
    Design,
    Ring,
    candidates,
    driven,
    fewest,
    free_ring,
    judge_borders,
    machine_of,
    own_sizes,
    planes_of,
    rings,
    screened,
)
from autobalancer.studies.design.design_file import PREFIX, read_spec
from autobalancer.studies.design.designs import (
    NOT_RUN,
    SAME,
    STAGES,
    Designed,
    dataset_of,
    numbers_of_runs,
    objective,
    ordered,
    refuse_none,
    used,
)
from autobalancer.studies.design.specification import MEASURED, Spec, blended
from autobalancer.studies.study.chunk import AssembledMembers
from autobalancer.studies.study.study import study
from autobalancer.studies.study.study_file import read_study, vary

RUNS, ANSWER = "runs", "answer.nc"  # folder of the runs in that of a design, and what they said
HOPELESS = 8  # designs that pass the closed forms, of which the scatter makes no machine: then none is looked for


@shows_progress
def design(
    given: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    seen: Callable[[Designed], None] | None = None,
) -> Designed:
    """Of balls in races, as :func:`autobalancer.api.design` says."""
    spec = read_spec(given)
    named = {"specification_file": Path(given).name} if isinstance(given, (str, Path)) else {}
    with Store(folder, spec.identity(), "design") if folder is not None else nullcontext():
        kept = Path(folder) / ANSWER if folder is not None else None
        result = _stored_answer(kept, spec) if kept is not None else None
        if result is None:
            way = _Context(spec, Path(folder) / RUNS if folder is not None else None, workers, progress, seen)
            try:
                result = _designed(way)
            except QuestionError as reason:
                if folder is not None and str(folder) in str(reason):
                    raise
                source = given if isinstance(given, (str, Path)) else "specification"
                raise QuestionError(f"{source}: {reason}") from None
            if kept is not None:
                save_run(result, kept)
        return result.assign_attrs(named)


def _stored_answer(path: Path, spec: Spec) -> Designed | None:
    """The answer that the same call left, if it had the same names and was made by the same version; a damaged one is none."""
    try:
        designs = load_run(path) if path.exists() and spec.measured is None else None
    except ResultError:
        return None
    named = {**provenance(), "design_name": spec.name, "remarks": list(spec.remarks)}
    same = designs is not None and all(
        designs.attrs.get(key, "") == text for key, text in named.items() if key != "created"
    )
    return Designed.of(designs) if designs is not None and same else None


class _Context(NamedTuple):
    """What is asked, where finished runs are kept, and who wants to know."""

    spec: Spec
    folder: Path | None
    workers: int | None
    progress: Callable[[int, int], None] | None
    seen: Callable[[Designed], None] | None

    def tell(self, designs: Iterable[Design]) -> None:
        """Say what is known so far."""
        if self.seen is not None:
            self.seen(Designed.of(designs_dataset(self.spec, list(designs), "so far")))

    def look(self, alive: Sequence[Design]) -> None:
        """Let somebody end it while nothing runs."""
        if self.progress is not None:
            self.progress(0, max(_runs(self.spec, alive), 1))


def _designed(way: _Context) -> Designed:
    """Every candidate, where sizes have steps and the budget is enough; else a search."""
    spec = way.spec
    searched = bool(spec.options.free)
    designed = [] if searched else [screened(spec, candidate) for candidate in candidates(spec)]
    if not searched:
        refuse_none(spec, designed)
        alive = [one for one in designed if not one.reason]
        _rule_out_equal_races(alive)
        alive = [one for one in alive if not one.reason]
        searched = len(alive) > spec.search.budget
    if not searched:
        for one in alive:
            judge_scatter(spec, one)
        refuse_none(spec, designed)
        alive = [one for one in alive if not one.reason]
        for one in alive:
            way.look(alive)
            judge_borders(spec, one)
        refuse_none(spec, designed)
        for one in designed:
            one.reason += one.cure()
        run_all(way, [one for one in alive if not one.reason], lambda: way.tell(designed))
        refuse_none(spec, designed)
        return Designed.of(designs_dataset(spec, designed, "every candidate that was left"))
    return _searched(way, designed)


def _rule_out_equal_races(alive: Iterable[Design]) -> None:
    """Rule out designs that move like another one, since their bearings have the same race and balls; the smallest one stays."""
    first: dict[Any, Design] = {}
    for one in sorted(alive, key=lambda one: one.candidate.ring.outer):
        kept = first.setdefault(one.candidate.motion(), one)
        if kept is not one:
            kept.twins.append(one.candidate.ring.label)
            one.rule_out(SAME, f"the race and the balls of {kept.candidate.ring.label}", 0.0)


def _searched(way: _Context, known: list[Design]) -> Designed:
    """The same by an optimizer; ``known`` are candidates after the closed forms, if there is a list of them."""
    spec = way.spec
    judged = {one.candidate.key(): one for one in known}
    first = {one.candidate.motion(): one for one in known if not one.reason}

    def judge(one: Any) -> Design:
        if one.key() not in judged:
            judged[one.key()] = screened(spec, one)
        design = judged[one.key()]
        design = first[one.motion()] if design.stage == SAME else design
        if not design.reason and not design.numbers:
            judge_scatter(spec, design)
            _refuse_hopeless(spec, judged.values())
        if not design.reason and not design.numbers:
            judge_borders(spec, design)
        return design

    looked = search_designs(spec, judge, lambda designs: run_all(way, designs, lambda: way.tell(judged.values())))
    designed = list(judged.values())
    seen = {id(one) for one in looked}
    ran, budget = sum(bool(one.numbers) for one in designed), spec.search.budget
    for one in designed:
        if not one.reason and not one.numbers:
            why = (
                "the search did not look at it"
                if id(one) not in seen
                else f"the budget of {budget} designs was used up"
            )
            one.rule_out(NOT_RUN, f"not run: {why}", 0.0)
    if not ran:
        refuse_none(spec, designed)
    how = (
        f"NSGA-II over {spec.search.generations} generations, seed {spec.search.seed}, then the nearest to the best; looked at "
        f"{len(looked)} candidates, of the budget of {budget} designs {ran} were run"
    )
    return Designed.of(designs_dataset(spec, designed, how))


def _runs(spec: Spec, alive: Sequence[Design]) -> int:
    """Runs of so many designs."""
    return spec.search.members * _cases(spec) * len(alive)


def _cases(spec: Spec) -> int:
    return len(spec.operation.speeds) + bool(spec.operation.coast_down)


def run_all(way: _Context, alive: Sequence[Design], tell: Callable[[], None]) -> None:
    """Run what was left, one design after the other; one that cannot be run says why."""
    spec, folder, progress = way.spec, way.folder, way.progress
    cases, members, total = _cases(spec), spec.search.members, _runs(spec, alive)
    for number, one in enumerate(alive):
        done = [number * cases * members, 0]

        def told(now: int, _: int, done: list[int] = done) -> None:
            if now < done[1]:
                done[0] += members
            done[1] = now
            if progress is not None:
                progress(min(done[0] + now, total), total)

        try:
            judge_runs(spec, one, runs_of(spec, one.candidate, folder, way.workers, told))
            one.stage = STAGES[-1]
        except AutobalancerError as reason:
            if isinstance(reason, QuestionError) and folder is not None and str(folder) in str(reason):
                raise
            one.rule_out(STAGES[-1], f"cannot be run: {reason}")
        tell()


def _refuse_hopeless(spec: Spec, designs: Iterable[Design]) -> None:
    """Refuse a search whose first designs that pass the closed forms are all impossible; there is no end of others to try."""
    known = [design for design in designs if design.stage in ("", "border", STAGES[-1])]
    if len(known) >= HOPELESS and all(one.stage == STAGES[-1] and not one.numbers for one in known):
        refuse_none(spec, known)


# The table of the candidates of a balancer.


DESCRIBED: tuple[tuple[str, Callable[[Design], Any], str, str], ...] = (  # name, number or text, what it is, unit
    ("bearing", lambda d: d.candidate.ring.bearing, "bearing whose outer ring is the race", ""),
    ("fluid", lambda d: d.candidate.fluid, "fluid of the races", ""),
    ("planes", lambda d: ", ".join(d.candidate.planes), "stations with balls", ""),
    ("count", lambda d: d.candidate.count, "balls of a race", ""),
    ("races", lambda d: d.candidate.races, "races of a plane", ""),
    ("orbit_radius", lambda d: d.candidate.ring.orbit_radius, "orbit radius", "m"),
    ("ball_diameter", lambda d: d.candidate.ring.ball_diameter, "diameter of a ball", "m"),
    ("bore", lambda d: d.candidate.ring.bore, "free bore", "m"),
    ("outer", lambda d: d.candidate.ring.outer, "outer diameter", "m"),
    ("width", lambda d: d.candidate.ring.width, "width of a race", "m"),
    ("viscosity_cold", lambda d: d.viscosity[0], "kinematic viscosity at the lowest temperature", "m^2/s"),
    ("viscosity_warm", lambda d: d.viscosity[1], "kinematic viscosity at the highest temperature", "m^2/s"),
    ("release", lambda d: d.release, "release speed, the worst of all temperatures and unbalances", "rad/s"),
    ("border", lambda d: d.border, "exact border, the worst of all temperatures and unbalances", "rad/s"),
)


KEPT = ("title", "fit_error", "free_error", "modes", "band_low", "band_high", "warnings", "noise")


def designs_dataset(spec: Spec, designs: Sequence[Design], how: str) -> Designed:
    """All candidates that were looked at; ``how`` says how those that ran were chosen."""
    ran = ordered(spec, [design for design in designs if design.numbers])
    best = next((one.machine for one, _ in ran if one.machine is not None), None)
    left_out = neglected_terms(spec, best) if best is not None else ""
    # what the border speeds of the table leave out of the machines, a sentence each
    machines = [design.machine for design in designs if design.machine is not None and design.numbers]
    sentences = []
    for name, theory in (("release speed", Theory.STALLED), ("exact border", Theory.AT_REST)):
        terms = dict.fromkeys(term for machine in machines for term in unknown(machine, theory))
        sentences += [f"{name}: ignores {', '.join(terms)}"] if terms else []
    attributes = {**_attributes(spec, how), "left_out": left_out, "borders_ignore": sentences}
    stalls = "share of the runs that end with a stalled ball or rotor"
    dataset = dataset_of(spec, designs, DESCRIBED, stalls, partial(_text, spec), attributes)
    if spec.measured is None:
        return dataset
    variables, attributes = _labelled(spec.measured)
    return Designed.of(dataset.assign(variables).assign_attrs(attributes))


def _labelled(fit: Answer) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and attributes under names that no other of a design has."""
    variables = {f"{PREFIX}{name}": fit[name].rename(None) for name in map(str, fit.data_vars)}
    return variables, {f"{PREFIX}{name}": fit.attrs[name] for name in KEPT if name in fit.attrs} | {
        "rotor": fit_text(fit)
    }


def _text(spec: Spec, design: Design) -> str:
    """The machine file of a design that ran, with the run-up of the specification."""
    if design.machine is None:
        return ""
    machine = driven(spec, design.machine, spec.fastest, coasting=False)
    return machine_text(in_author_units(with_author_springs(machine, spec.machine), spec.machine, exact=True))


def _attributes(spec: Spec, how: str) -> dict[str, Any]:
    return {
        "title": f"Balancers for {spec.machine.name}{f': {spec.name}' * (spec.name not in ('design', spec.machine.name))}",
        "machine_name": spec.machine.name,
        "design_name": spec.name,
        "specification": json.dumps(spec.identity()),
        "unbalance_range": list(spec.unbalance),
        "temperature_range": list(spec.temperature),
        "speeds": list(spec.operation.speeds),
        "members": spec.search.members,
        "seed": spec.search.seed,
        "searched_by": how,
        "remarks": list(spec.remarks),
    }


# Runs of a design with scatter: unbalance, temperature, starts and what else the specification lets vary.


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
    spec: Spec,
    candidate: Candidate,
    folder: Path | None,
    workers: int | None,
    progress: Report,
    seed: int | None = None,
) -> list[Case]:
    """All runs that judge a candidate; finished ones are taken from the folder.

    Raises
    ------
    QuestionError
        If the scatter makes impossible machines.
    """
    machine = machine_of(spec, candidate, 0.5 * sum(spec.temperature), spec.unbalance[1])
    cases = [
        (f"{speed:.6g} rad/s", driven(spec, machine, speed, coasting=False), False) for speed in spec.operation.speeds
    ]
    if spec.operation.coast_down:
        cases.append(("coast-down", driven(spec, machine, spec.fastest, coasting=True), True))
    runs = []
    for name, described, coasting in cases:
        requested = study_of(spec, described, candidate, spec.search.seed if seed is None else seed)
        place = folder / name_of(spec, candidate, name) if folder is not None else None
        runs.append(Case(name, study(requested, folder=place, workers=workers, progress=progress), coasting))
    return runs


def judge_scatter(spec: Spec, design: Design) -> None:
    """Rule out a design of which the scatter makes no possible machine, as its runs would, before anything runs.

    Raises
    ------
    QuestionError
        With the key at fault, for a scatter or temperatures of the machine's own fluid that no design can have.
    """
    if spec.scatter and design.machine is not None:
        vary(design.machine, spec.scatter, "scatter")
    if design.machine is not None and not design.candidate.fluid:
        _temperatures(spec, design.machine, design.candidate)
    if not spec.scatter or design.machine is None:
        return
    machine = driven(spec, design.machine, spec.fastest, coasting=False)
    try:
        AssembledMembers(read_study(study_of(spec, machine, design.candidate, spec.search.seed)), 0, 1)
    except AutobalancerError as reason:
        text = str(reason).removeprefix("impossible: draw 1 made")
        design.rule_out(STAGES[-1], f"the scatter makes{text}" if text != str(reason) else f"cannot be run: {reason}")


def neglected_terms(spec: Spec, machine: Machine) -> str:
    """What the runs leave out of a machine that nobody said is ideal: eccentricity and friction, and what typical ones would do.

    They are no scatter by themselves, since coefficients of friction differ by thousands from race to race: a value that nobody
    gave would decide the order.
    """
    result = list[str]()
    if not any("eccentricity" in name for name in spec.scatter):
        away = off_center(
            places_of(machine, assemble(machine, lags=diffusing_lags(machine))), resolve(machine), spec.fastest
        )
        for plane in away.planes if away is not None else ():
            if not plane.given:
                left = f" and {moment_text(plane.residual)}" * math.isfinite(plane.residual)
                size = length_text(plane.eccentricity)
                result.append(
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
        result.append(
            f"friction: that of a {TYPICAL} (adherence {typical.adherence:g}) would leave up to {moment_text(held)} "
            f"{OF_RELEASED}, that of others more"
        )
    if not result:
        return ""
    result = ["not in the runs, so no limit counts it", *result]
    return "; ".join([*result, "give them in the machine or in [scatter], 0 for none"])


def study_of(spec: Spec, machine: Machine, candidate: Candidate, seed: int) -> dict[str, Any]:
    """The study that runs a machine with the scatter of the specification, as a dict of the form of study files."""
    low, high = spec.unbalance
    vary: dict[str, Any] = {"unbalance": {"distribution": "uniform", "low": low, "high": high}} if low < high else {}
    vary |= _temperatures(spec, machine, candidate) | spec.scatter
    return {
        "machine": machine,
        "members": spec.search.members,
        "seed": seed,
        "tolerance": spec.search.tolerance,
        "impossible": "truncate",
        "settling_from": spec.search.settling_from,
        "vary": vary,
    }


def _temperatures(spec: Spec, machine: Machine, candidate: Candidate) -> dict[str, Any]:
    low, high = spec.temperature
    if low == high:
        return {}
    fluids = {race.fluid for balancer in machine.balancers for race in balancer.races}
    if all(fluid is not None and fluid.name is not None for fluid in fluids):
        return {"temperature": {"distribution": "uniform", "low": low, "high": high}}
    if len(candidate.fillings) != 1:
        which = candidate.fluid or "the fluid of the machine"
        raise QuestionError(
            f"temperature: given from {low - 273.15:.4g} to {high - 273.15:.4g} °C, which is known for fluids of the catalog "
            f"and for one blend in all races, not for {which}; give one temperature"
        )
    middles = low + (high - low) * (np.arange(STEPS) + 0.5) / STEPS
    values = [candidate.fillings[0].at(float(temperature))[1] for temperature in middles]
    return {"viscosity": {"distribution": "discrete", "values": values}}


def name_of(spec: Spec, candidate: Candidate, case: str) -> str:
    """The name of the folder of a design's runs: the same for the same design."""
    return hashlib.sha256(repr((candidate.key(), case)).encode()).hexdigest()[:16]


FINISHED = "finished"
PEAK = "peak_deflection"


def judge_runs(spec: Spec, design: Design, cases: Sequence[Case]) -> None:
    """Fill the numbers of a design; of a run there and back the greatest deflection alone counts."""
    worst = max((case.found.attrs for case in cases), key=lambda told: np.nan_to_num(told.get("passage_ratio", 0.0)))
    design.passage = str(worst.get("passage_text", ""))
    design.drag_warning = next(filter(None, (str(case.found.attrs.get("drag_warning", "")) for case in cases)), "")
    measured: list[dict[str, NDArray[Any]]] = []
    for _, found, coasting in cases:
        measured.append({name: values_of(found, name) for name in ((PEAK,) if coasting else MEASURED)})
        if not coasting:
            ended = found["outcome"].values == FINISHED
            measured[-1] |= {"stall": stalled(found), "balanced": found["balanced"].values.astype(bool) & ended}
    design.numbers |= numbers_of_runs(spec, measured)


def values_of(studied: Studied, name: str) -> NDArray[np.float64]:
    """A measure of all runs; infinite where a run did not end or has no such number, as a ball that never settles."""
    values = (
        np.asarray(studied[name].values, np.float64) if name in studied else np.full(studied.sizes["member"], np.nan)
    )
    return np.where(np.isfinite(values) & (studied["outcome"].values == FINISHED), values, math.inf)


def stalled(studied: Studied) -> NDArray[np.bool_]:
    """Which runs end stalled, or do not end."""
    return np.asarray(studied["stalled"].values.astype(bool) | (studied["outcome"].values != FINISHED))


# The search where sizes have no steps or candidates are more than can be run: NSGA-II (Deb et al. 2002), by pymoo.
#
# The objectives are those of the specification, in logarithms; what a candidate misses, over what is allowed, is its
# constraint. A generation is screened first, and what is left of it runs together. What the generations leave of the
# budget goes to candidates that nobody looked at, those nearest to the best ones first.


Judge = Callable[[Candidate], Design]
Run = Callable[[Sequence[Design]], None]
FAR = 30.0  # logarithm of an objective that a candidate does not reach
WORST = 1e3  # of a constraint
LEAST = 4  # designs of a generation
TRIED = 40  # candidates screened for each one of the first generation, and in a round behind the last one
SPREAD = 0.1  # of those where sizes have no steps, about the best designs; the whole range is 1


def search_designs(spec: Spec, judge: Judge, run: Run) -> list[Design]:
    """All candidates that the search looked at; those that passed the screens ran, until the budget was spent or none was left.

    Parameters
    ----------
    spec
        What was asked.
    judge
        Screens a candidate.
    run
        Runs designs and fills their numbers.

    Raises
    ------
    QuestionError
        If pymoo is not installed.
    """
    nsga, problems, evaluators, static = _pymoo()
    coded = Coded(spec)
    seen: dict[Any, Design] = {}
    places: dict[int, Floats] = {}  # of designs, by identity: rings that are the same race share one

    def designs(rows: Floats) -> list[Design]:
        result = []
        for row in rows:
            candidate = coded.candidate(row.tolist())
            if candidate.key() not in seen:
                seen[candidate.key()] = judge(candidate)
                places.setdefault(id(seen[candidate.key()]), row)
            result.append(seen[candidate.key()])
        return result

    def known() -> list[Design]:
        return list({id(one): one for one in seen.values()}.values())

    def spent() -> int:
        return sum(bool(one.numbers) for one in known())

    # NSGA-II: a generation is judged, and what the screens leave of it runs, as long as the budget lasts
    each = max(LEAST, spec.search.budget // spec.search.generations)
    first = _first(spec, len(coded.names), each, designs)
    algorithm = nsga.NSGA2(pop_size=each, sampling=first)
    problem = problems.Problem(n_var=len(coded.names), n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0)
    algorithm.setup(problem, termination=("n_gen", spec.search.generations), seed=spec.search.seed, verbose=False)
    while algorithm.has_next() and spent() < spec.search.budget:
        requested = algorithm.ask()
        if requested is None:
            break
        group = designs(requested.get("X"))
        left = spec.search.budget - spent()
        fresh = {id(one): one for one in group if not one.reason and not one.numbers}
        run(list(fresh.values())[:left])
        numbers = static.StaticProblem(
            problem,
            F=np.array([_objectives(spec, one) for one in group]),
            G=np.array([[_missed(spec, one)] for one in group]),
        )
        evaluators.Evaluator().eval(numbers, requested)
        algorithm.tell(infills=requested)
    # then the neighbors of the best, until the budget is spent or nothing new is near
    for number in range(spec.search.budget):  # what the generations have left of it
        left, fresh = min(spec.search.budget - spent(), each), {}
        if left <= 0:
            break
        for row in _nearest(spec, coded, known(), places, number):
            (one,) = designs(row[None])
            if not one.reason and not one.numbers:
                fresh[id(one)] = one
            if len(fresh) == left:
                break
        if not fresh:  # there is nothing that nobody looked at
            break
        run(list(fresh.values()))
    return known()


def _nearest(spec: Spec, coded: Coded, seen: list[Design], places: dict[int, Floats], number: int) -> Floats:
    """Candidates as numbers, the nearest to the best designs first: a whole list, or some where sizes have no steps."""
    ran = [one for one, _ in ordered(spec, [one for one in seen if one.numbers])]
    best = ran or sorted(seen, key=lambda one: one.excess)
    middles = np.array([places[id(one)] for one in best[:LEAST]])
    if coded.free:
        random = generator(spec.search.seed, 2, number)
        about = middles[random.integers(len(middles), size=TRIED)]
        return np.asarray(np.clip(about + SPREAD * random.standard_normal(about.shape), 0.0, 1.0), np.float64)
    rows = coded.steps()
    away = np.min([np.linalg.norm(rows - middle, axis=1) for middle in middles], axis=0)
    return np.asarray(rows[np.argsort(away, kind="stable")], np.float64)


def _first(spec: Spec, width: int, each: int, designs: Callable[[Floats], list[Design]]) -> Floats:
    """The first generation: as many as possible that pass the screens, the others those that miss them by least."""
    rows = generator(spec.search.seed, 1).random((TRIED * each, width))
    items, order, keys = [], [], set()
    for place, row in enumerate(rows):
        (one,) = designs(row[None])
        if one.candidate.key() in keys:
            continue
        keys.add(one.candidate.key())
        order.append((one.excess if one.reason else -1.0, place))
        items.append(not one.reason)
        if sum(items) == each:
            break
    chosen = [place for _, place in sorted(order)[:each]]
    return np.asarray(rows[chosen + list(range(each - len(chosen)))])


def _objectives(spec: Spec, design: Design) -> list[float]:
    values = [objective(design, name) for name in spec.objectives]
    return [float(np.log(value)) if np.isfinite(value) and value > 0.0 else FAR for value in values]


def _missed(spec: Spec, design: Design) -> float:
    if design.reason:
        return 1.0 + min(design.excess, WORST)
    return min(max(used(spec, design) - 1.0, 0.0), WORST) if design.numbers else WORST


def _pymoo() -> tuple[Any, Any, Any, Any]:
    try:
        return (
            import_module("pymoo.algorithms.moo.nsga2"),
            import_module("pymoo.core.problem"),
            import_module("pymoo.core.evaluator"),
            import_module("pymoo.problems.static"),
        )
    except ImportError:
        raise QuestionError(
            "candidates: sizes without steps, or more candidates than 'search.budget', are searched by pymoo, which is not "
            "installed; install it with: pip install 'autobalancer[design]', or give lists of values and a larger budget"
        ) from None


# Candidates as numbers between 0 and 1, one for each thing that can be chosen, as an optimizer wants them.


class Coded:
    """What can be chosen, and the candidate that numbers stand for.

    A list is ordered so that neighbors are alike: rings by their outer diameter, fluids by their viscosity at 25 °C.
    """

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        options, room = spec.options, 298.15
        self.free = {name: (low, high) for name, low, high in options.free}
        lists: dict[str, Sequence[Any]] = {
            "ring": []
            if set(self.free) & {"orbit_radius", "ball_diameter"}
            else sorted(rings(spec), key=lambda one: one.outer),
            "orbit_radius": options.orbit_radii,
            "ball_diameter": options.ball_diameters,
            "count": options.counts,
            "races": options.races,
            "planes": options.planes,
            "fluid": sorted(options.fluids, key=lambda one: one[0].at(room)[1])
            if len(options.fluids) > 1
            else options.fluids,
        }
        if lists["ring"]:
            lists["orbit_radius"] = lists["ball_diameter"] = ()
        self.lists = lists
        self.names = [name for name, one in lists.items() if len(one) > 1] + list(self.free)

    def candidate(self, numbers: Sequence[float]) -> Candidate:
        """The candidate of numbers between 0 and 1, in the order of ``names``."""
        given = dict(zip(self.names, map(float, numbers), strict=True))
        spec, races = self.spec, int(self._chosen("races", given) or 1)
        planes, fillings = self._chosen("planes", given) or (), self._fillings(given)
        if len(fillings) > 1:
            races = len(fillings)
        ring = self._chosen("ring", given) or self._ring(given)
        count = self._chosen("count", given) or fewest(spec, ring, races, planes_of(spec, planes), fillings)
        return Candidate(ring, int(count), races, planes, fillings)

    def steps(self) -> NDArray[np.float64]:
        """The numbers of all candidates where nothing is free: the middles of their steps."""
        axes = [(np.arange(len(self.lists[name])) + 0.5) / len(self.lists[name]) for name in self.names]
        return np.array(list(product(*axes)), np.float64).reshape(-1, len(axes))

    def _chosen(self, name: str, options: dict[str, float]) -> Any:
        some = self.lists[name]
        if not some:
            return None
        return some[min(int(options.get(name, 0.0) * len(some)), len(some) - 1)]

    def _ring(self, options: dict[str, float]) -> Ring:
        own = own_sizes(self.spec) or (math.nan, math.nan)
        sizes = [
            self._size(name, options, usual) for name, usual in zip(("orbit_radius", "ball_diameter"), own, strict=True)
        ]
        return free_ring(self.spec, sizes[0], sizes[1])

    def _size(self, name: str, options: dict[str, float], usual: float) -> float:
        if name in self.free:
            low, high = self.free[name]
            return round(low + options[name] * (high - low), 5)  # to 10 um: nobody makes it finer
        return float(self._chosen(name, options) or usual)

    def _fillings(self, options: dict[str, float]) -> Any:
        if self.spec.options.blend is None:
            return self._chosen("fluid", options) or ()
        low, high = self.free["viscosity"]
        viscosity = float(f"{low * (high / low) ** options['viscosity']:.3g}")
        return (blended(*self.spec.options.blend, min(max(viscosity, low), high)),)

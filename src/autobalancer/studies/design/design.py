"""Design of balancers: candidates screened, run with scatter and ranked, from a specification file or a dict."""

from __future__ import annotations

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
import xarray as xr
from numpy.typing import NDArray

from autobalancer.assembly.quantities import in_author_units, with_author_springs
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.errors import AutobalancerError, QuestionError, ResultError
from autobalancer.files.machine_file import machine_text
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.results.display_units import moment_text
from autobalancer.results.folder_store import Store
from autobalancer.results.provenance import provenance
from autobalancer.results.store import load_run, save_run
from autobalancer.rotordynamics.receptance.receptances import FittedReceptance, fit_text
from autobalancer.stability.border import Border
from autobalancer.stability.maps.curve import minimum_viscosity
from autobalancer.stability.maps.exact import borders
from autobalancer.studies.design.candidate import (
    Candidate,
    Design,
    Ring,
    candidates,
    driven,
    fewest,
    free_ring,
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
    judge_runs,
    judge_scatter,
    meets,
    missed,
    misses,
    neglected_terms,
    objective,
    ordered,
    runs_of,
    used,
)
from autobalancer.studies.design.specification import MARGIN, MEASURED, Spec, blended
from autobalancer.tables import rpm_and_si

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
    """Find the balancer for a rotor: which race, how many balls, which fluid, with which margins.

    Closed forms rule out what does not fit, cannot balance the largest unbalance or presses too hard; exact borders rule out what
    stalls or is not stable at an operating speed at some temperature. What is left runs with scatter (unbalance, temperature,
    starts and what the specification names), and is ranked by its limits and two objectives.

    Parameters
    ----------
    given
        The path of a specification file (TOML), or a dict of the same form; see the page on design for its keys.
    folder
        Where finished runs are kept, and taken up again by the same call later. By default nothing is kept on the way.
    workers
        Threads; by default one for each core. The result does not depend on it.
    progress
        Called with (runs done, runs in all).
    seen
        Called with the answer so far whenever a candidate has run.

    Returns
    -------
    xarray.Dataset
        Over ``design``: what every candidate is, ``stage`` and ``reason`` of those that were ruled out; of the others numbers and
        shares of their runs with intervals, whether each ``meets`` the limits, its Pareto ``front`` and ``place``, and its
        machine file. :func:`designed_machine` makes a machine of it.

    Raises
    ------
    QuestionError
        For a fault in the specification, named with its key; for limits that contradict each other; if no candidate is left, with
        what ruled the last ones out; for a folder of another design.
    MachineError
        If the machine is impossible.
    """
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


def refuse_none(spec: Spec, designs: Sequence[Design]) -> None:
    """Refuse a specification that leaves no candidate.

    Raises
    ------
    QuestionError
        With how many each question ruled out, and the nearest miss of the question that ruled the last ones out.
    """
    if not designs:
        raise QuestionError("candidates: there is none; races and fluids do not go together")
    if any(not design.reason for design in designs):
        return
    counts = {stage: sum(design.stage == stage for design in designs) for stage in STAGES}
    said = ", ".join(f"{stage} {count}" for stage, count in counts.items() if count)
    last = max((design.stage for design in designs), key=STAGES.index)
    nearest = min((design for design in designs if design.stage == last), key=lambda one: one.excess)
    text = (
        f"candidates: none of {len(designs)} is left; ruled out by {said}. The last ones were ruled out by {last}, the nearest: "
        f"{nearest.candidate.label}: {nearest.reason}{nearest.cure()}"
    )
    raise QuestionError(". ".join([text, *spec.remarks]))


# All candidates of a design as a labeled dataset: what they are, where they were ruled out and why, what the runs
# left.


SHARES = {
    "stall": "share of the runs that end with a stalled ball or rotor",
    "balanced": "share of the runs that end balanced",
    **{f"{name}_over": f"share of the runs with more than the limit: {text}" for name, (_, text) in MEASURED.items()},
}
ENDS = {"low": "lower end of its 95 % interval", "high": "upper end of its 95 % interval"}


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
    ("capability", lambda d: d.capability, "unbalance that the balls of a plane can balance", "kg m"),
    ("capability_margin", lambda d: d.margin, "capability over what is to be balanced, the least of all planes", "1"),
    ("ball_mass", lambda d: d.ball_mass, "mass of all balls", "kg"),
    ("pressure", lambda d: d.pressure, "greatest pressure between ball and race (Hertz)", "Pa"),
    ("release", lambda d: d.release, "release speed, the worst of all temperatures and unbalances", "rad/s"),
    ("border", lambda d: d.border, "exact border, the worst of all temperatures and unbalances", "rad/s"),
)


KEPT = ("title", "fit_error", "free_error", "modes", "band_low", "band_high", "warnings", "noise")


def designs_dataset(spec: Spec, designs: Sequence[Design], how: str) -> xr.Dataset:
    """Over ``design``: candidates in their order; ``place`` is 1 for the best, nan for those that did not run.

    Parameters
    ----------
    spec
        What was asked.
    designs
        All candidates that were looked at.
    how
        How those that ran were chosen.
    """
    # order: those that keep all limits first, then by how many and by how much they miss
    ranked = ordered(spec, [design for design in designs if design.numbers])
    place = {id(one): number for number, (one, _) in enumerate(ranked, start=1)}
    front = {id(one): level for one, level in ranked}
    best = next((one.machine for one, _ in ranked if one.machine is not None), None)
    dataset = xr.Dataset(
        attrs={**_attributes(spec, how), "left_out": neglected_terms(spec, best) if best is not None else ""}
    )
    dataset.attrs["borders_ignore"] = _borders_ignore(designs)
    dataset = dataset.assign_coords(
        design=("design", np.arange(1, len(designs) + 1), {"long_name": "number of the candidate"})
    )

    def add(name: str, values: Sequence[Any], text: str, unit: str = "") -> None:
        kept = (
            np.array(values, dtype=object) if values and isinstance(values[0], str) else np.asarray(values, np.float64)
        )
        dataset[name] = ("design", kept, {"long_name": text, **({"units": unit} if unit else {})})

    add("label", _labels(designs), "what it is")
    for name, numbers, text in (
        ("place", place, "place among those that ran, 1 for the best"),
        ("front", front, "number of its Pareto front among designs that keep or miss as many limits, 0 for the first"),
    ):
        add(name, [float(numbers.get(id(design), np.nan)) for design in designs], text)
    add(
        "meets",
        [float(meets(spec, design)) if design.numbers else -1.0 for design in designs],
        "1: keeps all limits; 0: too few runs to say; -1: does not",
    )
    # by how much limits are missed, or why a candidate was not run
    beyond = [misses(spec, design) if design.numbers else {} for design in designs]
    add("misses", [float(len(one)) for one in beyond], "limits on the runs that it misses, their number", "1")
    add(
        "missed",
        [missed(spec, design) if design.numbers else design.stage for design in designs],
        "limits that it misses, or what ruled it out",
    )
    add(
        "stage",
        [design.stage for design in designs],
        f"what ruled it out: {', '.join(STAGES[:-1])}; {STAGES[-1]!r} if it ran",
    )
    add("reason", [design.reason for design in designs], "why it was ruled out")
    add(
        "excess",
        [design.excess if design.reason else sum(more.values()) for design, more in zip(designs, beyond, strict=True)],
        "how far it misses that, or limits on the runs added up, over what is allowed",
        "1",
    )
    for name, of, text, unit in DESCRIBED:
        add(name, [of(design) for design in designs], text, unit)
    # what the runs gave: the share that the specification names, the median, shares with their intervals
    measured: list[tuple[str, str, str]] = []
    for name, (unit, text) in MEASURED.items():
        at_share = f"{text}; {100.0 * spec.share:g} % of the runs stay below"
        measured += [(name, at_share, unit), (f"{name}_median", f"{text}; median", unit)]
    for name, text in SHARES.items():
        if any(name in design.numbers for design in designs):
            measured += [(name, text, "1"), *((f"{name}_{end}", f"{text}; {said}", "1") for end, said in ENDS.items())]
    for name, text, unit in measured:
        add(name, [design.numbers.get(name, np.nan) for design in designs], text, unit)
    add(
        "drag_warning", [design.drag_warning for design in designs], "where its balls leave the range of their drag law"
    )
    add("passage", [design.passage for design in designs], "where its passage is worse than without balls")
    add(
        "used",
        [used(spec, design) if design.numbers else np.nan for design in designs],
        "greatest share of a limit that it uses up",
        "1",
    )
    dataset["machine"] = (
        "design",
        np.array([_text(spec, design, place) for design in designs], dtype=object),
        {"long_name": "machine file"},
    )
    if spec.measured is not None:
        variables, attributes = _labelled(spec.measured)
        dataset = dataset.assign(variables).assign_attrs(attributes)
    return dataset


def _labelled(fit: FittedReceptance) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and attributes under names that no other of a design has."""
    variables = {f"{PREFIX}{name}": fit[name].rename(None) for name in map(str, fit.data_vars)}
    return variables, {f"{PREFIX}{name}": fit.attrs[name] for name in KEPT if name in fit.attrs} | {
        "rotor": fit_text(fit)
    }


def _borders_ignore(designs: Sequence[Design]) -> list[str]:
    """What the border speeds of the table leave out of the machines, a sentence each."""
    machines = [design.machine for design in designs if design.machine is not None and design.numbers]
    sentences = []
    for name, theory in (("release speed", Theory.STALLED), ("exact border", Theory.AT_REST)):
        terms = dict.fromkeys(term for machine in machines for term in unknown(machine, theory))
        sentences += [f"{name}: ignores {', '.join(terms)}"] if terms else []
    return sentences


def _labels(designs: Sequence[Design]) -> list[str]:
    """What each is, without what all have in common."""
    parts = [design.candidate.parts() for design in designs]
    for part, design in zip(parts, designs, strict=True):
        part["ring"] += f" (same race: {', '.join(design.twins)})" * bool(design.twins)
    common = {key for key in ("ring", "races", "planes", "fluid") if len({one.get(key) for one in parts}) == 1}
    return [", ".join(text for key, text in one.items() if key not in common) for one in parts]


def _text(spec: Spec, design: Design, place: dict[int, int]) -> str:
    """The machine file of a design that ran, with the run-up of the specification."""
    if design.machine is None or id(design) not in place:
        return ""
    machine = driven(spec, design.machine, spec.fastest, coasting=False)
    return machine_text(in_author_units(with_author_springs(machine, spec.machine), spec.machine))


def _attributes(spec: Spec, how: str) -> dict[str, Any]:
    return {
        "title": f"Balancers for {spec.machine.name}{f': {spec.name}' * (spec.name not in ('design', spec.machine.name))}",
        **provenance(),
        "machine_name": spec.machine.name,
        "design_name": spec.name,
        "specification": json.dumps(spec.identity()),
        "limits": json.dumps(spec.limits),
        "unbalance_range": list(spec.unbalance),
        "temperature_range": list(spec.temperature),
        "speeds": list(spec.operation.speeds),
        "objectives": list(spec.search.objectives),
        "share": spec.share,
        "members": spec.search.members,
        "seed": spec.search.seed,
        "searched_by": how,
        "remarks": list(spec.remarks),
    }


# The search where sizes have no steps or candidates are more than can be run: NSGA-II (Deb et al. 2002), by pymoo.
#
# The objectives are those of the specification, in logarithms; what a candidate misses, over what is allowed, is its
# constraint. A generation is screened first, and what is left of it runs together. What the generations leave of the
# budget goes to candidates that nobody looked at, those nearest to the best ones first.


Floats = NDArray[np.float64]
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
    values = [objective(design, name) for name in spec.search.objectives]
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


# Designs whose balls stall or do not balance at an operating speed, by the exact borders; and the least oil that
# would do.


RELEASE, EXACT = "release speed", "exact border"
SAYS = {RELEASE: "its balls stall at the critical speed and are released at", EXACT: "balancing is stable from"}


def judge_borders(spec: Spec, design: Design) -> None:
    """Ask both borders at all temperatures and both ends of the unbalance; rule the design out where one is too high.

    The release speed first, which is found much faster; the exact border only of designs that it lets pass.
    """
    allowed = spec.slowest / (1.0 + spec.limits.get(MARGIN, 0.0))
    for name in (RELEASE, EXACT):
        worst, temperature, size = _worst(spec, design, name)
        if name == RELEASE:
            design.release = worst.speed
        else:
            design.border = worst.speed
        if worst.speed > allowed:
            said = f"{SAYS[name]} {rpm_and_si(worst.speed)} only" if math.isfinite(worst.speed) else _never(name)
            if worst.best < worst.speed:
                said += f" at all positions of the balls, from {rpm_and_si(worst.best)} at the best"
            at = f" at {temperature - 273.15:.4g} °C" if spec.temperature[0] != spec.temperature[1] else ""
            at += f" and {moment_text(size)}" if spec.unbalance[0] != spec.unbalance[1] else ""
            reason = f"{said}{at}; needed is {rpm_and_si(allowed)} or less"
            design.rule_out("border", reason, worst.speed / allowed - 1.0)
            design.cure = partial(_least_viscosity_text, spec, design, name, allowed, (temperature, size))
            return


def _worst(spec: Spec, design: Design, name: str) -> tuple[Border, float, float]:
    """The highest border of a name, and the temperature and unbalance of it; nan if there is none."""
    worst = Border(name, math.nan, ""), 0.0, 0.0
    for temperature in spec.temperatures:
        for size in sorted({max(spec.unbalance[0], 0.02 * spec.unbalance[1]), spec.unbalance[1]}):
            try:
                machine = machine_of(spec, design.candidate, temperature, size)
                (border,) = borders(machine, only=(name,))
            except AutobalancerError:
                continue
            if not border.speed <= worst[0].speed and not math.isnan(border.speed):
                worst = border, temperature, size
    return worst


def _never(name: str) -> str:
    return (
        "its balls stall at the critical speed and are never released"
        if name == RELEASE
        else "balancing is never stable"
    )


def _least_viscosity_text(spec: Spec, design: Design, name: str, allowed: float, at: tuple[float, float]) -> str:
    """How thick the oil would have to be at its density, as the end of a reason; empty where it is not known."""
    one, (temperature, size) = design.candidate, at
    if len(set(one.fillings)) != 1:
        return ""
    has = one.fillings[0].at(temperature)[1]
    try:
        machine = machine_of(spec, one, temperature, size)
        least = minimum_viscosity(machine, allowed, name)
    except AutobalancerError:
        return ""
    if not has < least < math.inf:  # thinner oils may do in a window, which is no design
        return ""
    return f"; that takes {1e6 * least:.3g} mm²/s there, this oil has {1e6 * has:.3g}"

"""The search where sizes have no steps or candidates are more than can be run: NSGA-II (Deb et al. 2002), by pymoo.

The objectives are those of the specification, in logarithms; what a candidate misses, over what is allowed, is its constraint.
A generation is screened first, and what is left of it runs together. What the generations leave of the budget goes to
candidates that nobody looked at, those nearest to the best ones first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.random_numbers import generator
from autobalancer.studies.design.candidate import Candidate
from autobalancer.studies.design.coded import Coded
from autobalancer.studies.design.ranking import objective, ordered, used
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import Spec

Floats = NDArray[np.float64]
Judge = Callable[[Candidate], Design]
Run = Callable[[Sequence[Design]], None]
FAR = 30.0  # logarithm of an objective that a candidate does not reach
WORST = 1e3  # of a constraint
LEAST = 4  # designs of a generation
TRIED = 40  # candidates screened for each one of the first generation, and in a round behind the last one
SPREAD = 0.1  # of those where sizes have no steps, about the best designs; the whole range is 1


def found_by_search(spec: Spec, judge: Judge, run: Run) -> list[Design]:
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
        found = []
        for row in rows:
            one = coded.candidate(row.tolist())
            if one.key() not in seen:
                seen[one.key()] = judge(one)
                places.setdefault(id(seen[one.key()]), row)
            found.append(seen[one.key()])
        return found

    def known() -> list[Design]:
        return list({id(one): one for one in seen.values()}.values())

    def spent() -> int:
        return sum(bool(one.numbers) for one in known())

    each = max(LEAST, spec.search.budget // spec.search.generations)
    first = _first(spec, len(coded.names), each, designs)
    algorithm = nsga.NSGA2(pop_size=each, sampling=first)
    problem = problems.Problem(n_var=len(coded.names), n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0)
    algorithm.setup(problem, termination=("n_gen", spec.search.generations), seed=spec.search.seed, verbose=False)
    while algorithm.has_next() and spent() < spec.search.budget:
        asked = algorithm.ask()
        if asked is None:
            break
        group = designs(asked.get("X"))
        left = spec.search.budget - spent()
        fresh = {id(one): one for one in group if not one.reason and not one.numbers}
        run(list(fresh.values())[:left])
        numbers = static.StaticProblem(
            problem,
            F=np.array([_objectives(spec, one) for one in group]),
            G=np.array([[_missed(spec, one)] for one in group]),
        )
        evaluators.Evaluator().eval(numbers, asked)
        algorithm.tell(infills=asked)
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
    found, order, keys = [], [], set()
    for place, row in enumerate(rows):
        (one,) = designs(row[None])
        if one.candidate.key() in keys:
            continue
        keys.add(one.candidate.key())
        order.append((one.excess if one.reason else -1.0, place))
        found.append(not one.reason)
        if sum(found) == each:
            break
    chosen = [place for _, place in sorted(order)[:each]]
    return np.asarray(rows[chosen + list(range(each - len(chosen)))])


def _objectives(spec: Spec, one: Design) -> list[float]:
    values = [objective(one, name) for name in spec.search.objectives]
    return [float(np.log(value)) if np.isfinite(value) and value > 0.0 else FAR for value in values]


def _missed(spec: Spec, one: Design) -> float:
    if one.reason:
        return 1.0 + min(one.excess, WORST)
    return min(max(used(spec, one) - 1.0, 0.0), WORST) if one.numbers else WORST


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

"""Design of balancers: candidates screened, run with scatter and ranked, from a specification file or a dict."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from autobalancer.errors import AutobalancerError, QuestionError, ResultError
from autobalancer.patience import shows_progress
from autobalancer.results.provenance import provenance
from autobalancer.results.store import load_run, save_run
from autobalancer.studies.design.answer import NOT_RUN, SAME, STAGES, Designed
from autobalancer.studies.design.borders import judge_borders
from autobalancer.studies.design.candidate import candidates
from autobalancer.studies.design.dataset import designs_dataset
from autobalancer.studies.design.judging import judge_runs
from autobalancer.studies.design.reading import read_spec
from autobalancer.studies.design.running import refuse_faulty_scatter, runs_of
from autobalancer.studies.design.screening import Design, screened
from autobalancer.studies.design.search import found_by_search
from autobalancer.studies.design.spec import Spec
from autobalancer.studies.study.store import Store

RUNS, ANSWER = "runs", "answer.nc"  # folder of the runs in that of a design, and what they said


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
    store = Store(folder, spec.identity(), "design") if folder is not None else None
    try:
        kept = Path(folder) / ANSWER if folder is not None else None
        found = _kept(kept, spec) if kept is not None else None
        if found is None:
            way = _Way(spec, Path(folder) / RUNS if folder is not None else None, workers, progress, seen)
            found = _designed(way)
            if kept is not None:
                save_run(found, kept)
        return found.assign_attrs(named)
    finally:
        if store is not None:
            store.close()


def _kept(path: Path, spec: Spec) -> Designed | None:
    """The answer that the same call left, if it had the same names and was made by the same version; a damaged one is none."""
    try:
        found = load_run(path) if path.exists() and spec.measured is None else None
    except ResultError:
        return None
    named = {**provenance(), "design_name": spec.name, "input_text": "\n".join(spec.remarks)}
    same = found is not None and all(
        found.attrs.get(key, "") == text for key, text in named.items() if key != "created"
    )
    return Designed.of(found) if found is not None and same else None


class _Way(NamedTuple):
    """What is asked, where finished runs are kept, and who wants to know."""

    spec: Spec
    folder: Path | None
    workers: int | None
    progress: Callable[[int, int], None] | None
    seen: Callable[[Designed], None] | None

    def tell(self, found: Iterable[Design]) -> None:
        """Say what is known so far."""
        if self.seen is not None:
            self.seen(Designed.of(designs_dataset(self.spec, list(found), "so far")))

    def look(self, alive: Sequence[Design]) -> None:
        """Let somebody end it while nothing runs."""
        if self.progress is not None:
            self.progress(0, max(_runs(self.spec, alive), 1))


def _designed(way: _Way) -> Designed:
    """Every candidate, where sizes have steps and the budget is enough; else a search."""
    spec = way.spec
    searched = bool(spec.options.free)
    found = [] if searched else [screened(spec, one) for one in candidates(spec)]
    if not searched:
        refuse_none(spec, found)
        alive = [one for one in found if not one.reason]
        _each_race_once(alive)
        alive = [one for one in alive if not one.reason]
        searched = len(alive) > spec.search.budget
    if not searched:
        refuse_faulty_scatter(spec, alive[0])
        for one in alive:
            way.look(alive)
            judge_borders(spec, one)
        refuse_none(spec, found)
        run_all(way, [one for one in alive if not one.reason], lambda: way.tell(found))
        refuse_none(spec, found)
        return Designed.of(designs_dataset(spec, found, "every candidate that was left"))
    return _searched(way, found)


def _each_race_once(alive: Iterable[Design]) -> None:
    """Rule out designs that move like another one, since their bearings have the same race and balls; the smallest one stays."""
    first: dict[Any, Design] = {}
    for one in sorted(alive, key=lambda one: one.candidate.ring.outer):
        kept = first.setdefault(one.candidate.motion(), one)
        if kept is not one:
            kept.twins.append(one.candidate.ring.label)
            one.rule_out(SAME, f"the race and the balls of {kept.candidate.ring.label}", 0.0)


def _searched(way: _Way, known: list[Design]) -> Designed:
    """The same by an optimizer; ``known`` are candidates after the closed forms, if there is a list of them."""
    spec = way.spec
    judged = {one.candidate.key(): one for one in known}
    first = {one.candidate.motion(): one for one in known if not one.reason}

    def judge(one: Any) -> Design:
        if one.key() not in judged:
            judged[one.key()] = screened(spec, one)
        found = judged[one.key()]
        found = first[one.motion()] if found.stage == SAME else found
        if not found.reason and not found.numbers:
            refuse_faulty_scatter(spec, found)
            judge_borders(spec, found)
        return found

    looked = found_by_search(spec, judge, lambda designs: run_all(way, designs, lambda: way.tell(judged.values())))
    found = list(judged.values())
    seen = {id(one) for one in looked}
    ran, budget = sum(bool(one.numbers) for one in found), spec.search.budget
    for one in found:
        if not one.reason and not one.numbers:
            why = (
                "the search did not look at it"
                if id(one) not in seen
                else f"the budget of {budget} designs was used up"
            )
            one.rule_out(NOT_RUN, f"not run: {why}", 0.0)
    if not ran:
        refuse_none(spec, found)
    how = (
        f"NSGA-II over {spec.search.generations} generations, seed {spec.search.seed}, then the nearest to the best; looked at "
        f"{len(looked)} candidates, of the budget of {budget} designs {ran} were run"
    )
    return Designed.of(designs_dataset(spec, found, how))


def _runs(spec: Spec, alive: Sequence[Design]) -> int:
    """Runs of so many designs."""
    return spec.search.members * _cases(spec) * len(alive)


def _cases(spec: Spec) -> int:
    return len(spec.operation.speeds) + bool(spec.operation.coast_down)


def run_all(way: _Way, alive: Sequence[Design], tell: Callable[[], None]) -> None:
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


def refuse_none(spec: Spec, found: Sequence[Design]) -> None:
    """Refuse a specification that leaves no candidate.

    Raises
    ------
    QuestionError
        With how many each question ruled out, and the nearest miss of the question that ruled the last ones out.
    """
    if not found:
        raise QuestionError("candidates: there is none; races and fluids do not go together")
    if any(not one.reason for one in found):
        return
    counts = {stage: sum(one.stage == stage for one in found) for stage in STAGES}
    said = ", ".join(f"{stage} {count}" for stage, count in counts.items() if count)
    last = max((one.stage for one in found), key=STAGES.index)
    nearest = min((one for one in found if one.stage == last), key=lambda one: one.excess)
    text = (
        f"candidates: none of {len(found)} is left; ruled out by {said}. The last ones were ruled out by {last}, the nearest: "
        f"{nearest.candidate.label}: {nearest.reason}"
    )
    raise QuestionError(". ".join([text, *spec.remarks]))

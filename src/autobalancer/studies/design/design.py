"""Design of balancers: candidates screened, run with scatter and ranked, from a specification file or a dict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.patience import shows_progress
from autobalancer.studies.design.answer import STAGES, Designed
from autobalancer.studies.design.borders import judge_borders
from autobalancer.studies.design.candidate import candidates
from autobalancer.studies.design.dataset import designs_dataset
from autobalancer.studies.design.judging import judge_runs
from autobalancer.studies.design.reading import read_spec
from autobalancer.studies.design.running import runs_of
from autobalancer.studies.design.screening import Design, screened
from autobalancer.studies.design.search import found_by_search
from autobalancer.studies.design.spec import Spec
from autobalancer.studies.study.store import Store

RUNS = "runs"  # folder of the runs in that of a design


@shows_progress
def design(
    given: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
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
    store = Store(folder, spec.identity(), "design") if folder is not None else None
    try:
        return _designed(spec, Path(folder) / RUNS if folder is not None else None, workers, progress)
    finally:
        if store is not None:
            store.close()


def _designed(spec: Spec, folder: Path | None, workers: int | None, progress: Any) -> Designed:
    """Every candidate, where sizes have steps and the budget is enough; else a search."""
    searched = bool(spec.options.free)
    found = [] if searched else [screened(spec, one) for one in candidates(spec)]
    if not searched:
        refuse_none(found)
        alive = [one for one in found if not one.reason]
        searched = len(alive) > spec.search.budget
    if not searched:
        for one in alive:
            judge_borders(spec, one)
        refuse_none(found)
        run_all(spec, [one for one in alive if not one.reason], folder, workers, progress)
        refuse_none(found)
        return Designed.of(designs_dataset(spec, found, "every candidate that was left"))
    return _searched(spec, found, folder, workers, progress)


def _searched(spec: Spec, known: list[Design], folder: Path | None, workers: int | None, progress: Any) -> Designed:
    """The same by an optimizer; ``known`` are candidates after the closed forms, if there is a list of them."""
    before = {one.candidate.key(): one for one in known}

    def judge(one: Any) -> Design:
        found = before.get(one.key()) or screened(spec, one)
        if not found.reason:
            judge_borders(spec, found)
        return found

    looked = found_by_search(spec, judge, lambda designs: run_all(spec, designs, folder, workers, progress))
    found = known + [one for one in looked if one.candidate.key() not in before]
    for one in found:
        if not one.reason and not one.numbers:
            one.rule_out("budget", f"not run: the budget of {spec.search.budget} designs was used up")
    if not any(one.numbers for one in found):
        refuse_none(found)
    how = f"NSGA-II over {len(looked)} candidates, {spec.search.generations} generations, seed {spec.search.seed}"
    return Designed.of(designs_dataset(spec, found, how))


def run_all(spec: Spec, alive: Sequence[Design], folder: Path | None, workers: int | None, progress: Any) -> None:
    """Run what was left, one design after the other; one that cannot be run says why."""
    cases = len(spec.operation.speeds) + bool(spec.operation.coast_down)
    members, total = spec.search.members, spec.search.members * cases * len(alive)
    for number, one in enumerate(alive):
        done = [number * cases * members, 0]

        def told(now: int, _: int, done: list[int] = done) -> None:
            if now < done[1]:
                done[0] += members
            done[1] = now
            if progress is not None:
                progress(min(done[0] + now, total), total)

        try:
            judge_runs(spec, one, runs_of(spec, one.candidate, folder, workers, told))
            one.stage = STAGES[-1]
        except AutobalancerError as reason:
            if isinstance(reason, QuestionError) and folder is not None and str(folder) in str(reason):
                raise
            one.rule_out(STAGES[-1], f"cannot be run: {reason}")


def refuse_none(found: Sequence[Design]) -> None:
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
    raise QuestionError(
        f"candidates: none of {len(found)} is left; ruled out by {said}. The last ones were ruled out by {last}, the nearest: "
        f"{nearest.candidate.label}: {nearest.reason}"
    )

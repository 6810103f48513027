"""One piece of a study: its members made and run, what they left as plain arrays."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.results.answers.ensemble import IMPOSSIBLE
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.ensemble.dataset import ensemble_variables
from autobalancer.studies.ensemble.execute import run_groups
from autobalancer.studies.ensemble.groups import Groups
from autobalancer.studies.ensemble.integration import Plan
from autobalancer.studies.ensemble.members import Members, without_start_angles
from autobalancer.studies.study.outputs import RUN, STALLED, STANDING, standing_numbers
from autobalancer.studies.study.spec import Study
from autobalancer.studies.study.sudden import BALANCED_BEFORE, after_jump

Arrays = dict[str, np.ndarray]
ATTEMPTS = 100  # times that a draw is taken again before a distribution is refused
PROBED = 100  # members that are made before a study begins
SECONDS, WALL = "seconds", "wall"  # of a core, that the members took to run; of a clock, for the whole chunk
ABOUT = (SECONDS, WALL)  # arrays that are not over members


class Made:
    """Members of a study from ``first`` to before ``last``, made and not run."""

    def __init__(self, study: Study, first: int, last: int) -> None:
        self.study, self.first, self.last = study, first, last
        self.again: dict[int, int] = {}
        self._make()
        while self.reasons and study.impossible == "truncate":
            self._draw_again()
            self._make()

    def _make(self) -> None:
        study = self.study
        self.columns: Columns = study.columns(self.first, self.last, self.again)
        machine = without_start_angles(study.machine) if study.random_starts else study.machine
        self.members = Members(machine, self.columns, None, study.seed, "")
        self.plan = Plan(study.duration, study.tolerance, study.bins, 10_000_000)
        begin, plan = self.members, self.plan
        if study.sudden is not None:
            begin = Members(study.sudden.without(machine), self.columns, None, study.seed, "")
            plan = plan._replace(end=study.sudden.before)
        self.reasons: dict[int, str] = {}
        if RUN in study.results:
            self.groups, self.reasons = begin.sorted(plan, "record")
        else:
            self.groups = Groups(self.plan)
            for number in range(self.members.count):
                try:
                    self.members.machine_of(number)
                except AutobalancerError as error:
                    self.reasons[number] = str(error)

    def _draw_again(self) -> None:
        points = len(self.study.points)
        for draw in {(self.first + number) // points for number in self.reasons}:
            self.again[draw] = self.again.get(draw, 0) + 1
            if self.again[draw] > ATTEMPTS:
                example = next(iter(self.reasons.values()))
                raise QuestionError(
                    f"impossible: draw {draw + 1} made no possible machine in {ATTEMPTS} attempts: {example}. Choose "
                    "distributions of possible machines"
                )


def run_chunk(study: Study, first: int, last: int, workers: int | None = 1, progress: Any = None) -> Arrays:
    """Members from ``first`` to before ``last`` (counted from 0), run; arrays over them.

    Raises
    ------
    KeyboardInterrupt
        If somebody interrupted it; nothing of the chunk is kept.
    """
    begun, points = time.monotonic(), len(study.points)
    first_draw, last_draw = first // points, -(-last // points)
    made = (
        Made(study, first_draw * points, last_draw * points)
        if study.impossible == "truncate"
        else Made(study, first, last)
    )
    found, seconds = _ran(made, workers, progress)
    found |= _standing(made, None if RUN in study.results else progress)
    found["reason"] = np.array([made.reasons.get(number, "") for number in range(made.members.count)], dtype=str)
    draws = (made.first + np.arange(made.members.count)) // points
    found["drawn_again"] = np.array([made.again.get(int(draw), 0) for draw in draws], np.int64)
    inside = slice(first - made.first, last - made.first)
    return {name: values[inside] for name, values in found.items()} | {
        SECONDS: np.array([seconds]),
        WALL: np.array([time.monotonic() - begun]),
    }


def _ran(made: Made, workers: int | None, progress: Any) -> tuple[Arrays, float]:
    if RUN not in made.study.results:
        outcome = ["" if number not in made.reasons else IMPOSSIBLE for number in range(made.members.count)]
        return {"outcome": np.array(outcome, dtype=str), **_columns(made)}, 0.0
    more: Arrays = {}
    if made.study.sudden is None:
        ran, seconds, interrupted = run_groups(made.groups, workers, progress)
    else:
        ran, reasons, balanced, seconds, interrupted = after_jump(
            made.members, made.groups, made.study.sudden, made.plan, workers, progress
        )
        made.reasons |= reasons
        more = {BALANCED_BEFORE: balanced}
    if interrupted:
        raise KeyboardInterrupt
    arrays = {
        name: values.astype(str) if values.dtype.kind == "O" else values
        for name, (_, values, _) in ensemble_variables(
            made.members, ran, made.reasons, made.study.settling_from
        ).items()
        if name != "reason"
    }
    arrays[STALLED] = (arrays["stalled_time"] > 0.0) & ~np.isfinite(arrays["settled_at"])
    return {**arrays, **more, **_columns(made)}, seconds


def _columns(made: Made) -> Arrays:
    """What varied, under ``vary:`` and its name; texts as they are."""
    values = {**made.columns.parameters, **made.columns.starts}
    found = {f"vary:{name}": _plain(entries) for name, entries in values.items() if name in made.study.scatter}
    assert made.columns.seeds is not None
    return {**found, "seed": made.columns.seeds}


def _plain(entries: Any) -> np.ndarray:
    return np.array(entries, dtype=str if isinstance(entries[0], str) else np.float64)


def _standing(made: Made, progress: Any) -> Arrays:
    names = [STANDING[name].name for name in made.study.results if name in STANDING]
    if not names:
        return {}
    found = {name: np.full(made.members.count, np.nan) for name in names}
    for number in range(made.members.count):
        if progress is not None:
            progress(number, made.members.count)
        if number in made.reasons:
            continue
        values, why = standing_numbers(made.members.machine_of(number), made.study.results)
        for name, value in values.items():
            found[name][number] = value
        if why:
            made.reasons[number] = why
    return found


def refuse_impossible(study: Study) -> None:
    """Make some members before a study begins; those that are no machine are refused or counted, as the study says.

    Raises
    ------
    QuestionError
        With the share of impossible members and an example, if the study refuses them.
    """
    if study.impossible == "record":
        return
    made = Made(replace(study, impossible="record"), 0, min(PROBED, study.count))
    share = len(made.reasons) / made.members.count
    if made.reasons and (study.impossible == "refuse" or share == 1.0):
        example = next(iter(made.reasons.values()))
        raise QuestionError(
            f"{100.0 * share:.3g} % of the first {made.members.count} members cannot be built; the first: {example}. Narrow "
            "the distributions, give them 'low' and 'high', or take impossible = 'truncate' (draw again) or 'record'"
        )

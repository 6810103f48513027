"""One piece of a study: its members made and run, what they left as plain arrays."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from typing import Annotated, Any, NamedTuple

import numpy as np
import xarray as xr

from autobalancer.assembly.system import reference_station
from autobalancer.catalog.resolve import capability_of, resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.machine.part import Quantity, Question, Rate, Time, key
from autobalancer.machine.path import dimension_of
from autobalancer.results.answers.answer import provenance
from autobalancer.results.answers.studied import IMPOSSIBLE, stalled
from autobalancer.results.measure_table import SWEPT, label_of
from autobalancer.results.verdict import BALANCED as RULE_BALANCED
from autobalancer.rotordynamics.campbell import critical_speeds
from autobalancer.stability.basins import START_ANGLE, axis_name
from autobalancer.stability.maps.exact import NAMES, borders
from autobalancer.studies.ensemble.columns import STARTS, Columns, ball_of, is_start
from autobalancer.studies.ensemble.ensemble import ensemble_variables
from autobalancer.studies.ensemble.layout import Groups, Plan, run_groups
from autobalancer.studies.ensemble.members import Members, without_start_angles
from autobalancer.studies.study.study_spec import BALANCED_BEFORE, HELD_SPEED, Study, after_jump
from autobalancer.studies.variations import coordinate

Arrays = dict[str, np.ndarray]
ATTEMPTS = 100  # times that a draw is taken again before a distribution is refused
SECONDS, WALL = "seconds", "wall"  # of a core, that the members took to run; of a clock, for the whole chunk
ABOUT = (SECONDS, WALL)  # arrays that are not over members


class AssembledMembers:
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
        AssembledMembers(study, first_draw * points, last_draw * points)
        if study.impossible == "truncate"
        else AssembledMembers(study, first, last)
    )
    arrays, seconds = _ran(made, workers, progress)
    arrays |= _standing(made, None if RUN in study.results else progress)
    arrays["reason"] = np.array([made.reasons.get(number, "") for number in range(made.members.count)], dtype=str)
    draws = (made.first + np.arange(made.members.count)) // points
    arrays["drawn_again"] = np.array([made.again.get(int(draw), 0) for draw in draws], np.int64)
    inside = slice(first - made.first, last - made.first)
    return {name: values[inside] for name, values in arrays.items()} | {
        SECONDS: np.array([seconds]),
        WALL: np.array([time.monotonic() - begun]),
    }


def _ran(made: AssembledMembers, workers: int | None, progress: Any) -> tuple[Arrays, float]:
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
    arrays[STALLED] = stalled(arrays)
    return {**arrays, **more, **_columns(made)}, seconds


def _columns(made: AssembledMembers) -> Arrays:
    """What varied, under ``vary:`` and its name; texts as they are."""
    values = {**made.columns.parameters, **made.columns.starts}
    columns = {f"vary:{name}": _plain(entries) for name, entries in values.items() if name in made.study.scatter}
    assert made.columns.seeds is not None
    return {**columns, "seed": made.columns.seeds}


def _plain(entries: Any) -> np.ndarray:
    return np.array(entries, dtype=str if isinstance(entries[0], str) else np.float64)


def _standing(made: AssembledMembers, progress: Any) -> Arrays:
    names = [STANDING[name].name for name in made.study.results if name in STANDING]
    if not names:
        return {}
    standing = {name: np.full(made.members.count, np.nan) for name in names}
    for number in range(made.members.count):
        if progress is not None:
            progress(number, made.members.count)
        if number in made.reasons:
            continue
        values, why = standing_numbers(made.members.machine_of(number), made.study.results)
        for name, value in values.items():
            standing[name][number] = value
        if why:
            made.reasons[number] = why
    return standing


# What a study asks of every member: the measures of its run, or border speeds and other numbers that need no run.


RUN = "run"
BALANCED, STALLED = "balanced", "stalled"


class Output(NamedTuple):
    """A number of a machine that needs no run."""

    name: str  # of its variable
    text: str
    unit: str
    of: Callable[[Machine], float]


def _border(name: str) -> Output:
    def of(machine: Machine) -> float:
        return next((border.speed for border in borders(machine, only=[name]) if border.name == name), math.nan)

    return Output(name.replace(", ", "_").replace(" ", "_"), name, "rad/s", of)


def _critical(machine: Machine) -> float:
    critical = critical_speeds(machine)["critical_speed"].values
    return float(critical[0]) if critical.size else math.nan


def _capability(machine: Machine) -> float:
    return capability_of(resolve(machine))


STANDING = {
    **{name: _border(name) for name in NAMES},
    "critical speed": Output("critical_speed", "lowest critical speed", "rad/s", _critical),
    "capability": Output("capability", "largest unbalance that the balls can balance", "kg m", _capability),
}
OUTPUTS = (RUN, *STANDING)


def quantity_kind(name: str, results: Iterable[str]) -> tuple[str, str]:
    """What a quantity of a study is, ``"bool"`` or ``"number"``, and its SI unit.

    Raises
    ------
    QuestionError
        If the study has no such quantity.
    """
    known = {STANDING[one].name: STANDING[one].unit for one in results if one in STANDING}
    if RUN in results:
        if name in (BALANCED, STALLED):
            return "bool", ""
        known |= {one.name: one.unit for one in SWEPT if not one.per_ball}
    if name not in known:
        named = ", ".join([*([BALANCED, STALLED] if RUN in results else []), *known])
        near = get_close_matches(name, known, 1, 0.8)
        meant = f"; did you mean {near[0]!r}?" if near else ";"
        raise QuestionError(f"given {name!r}{meant} this study has {named}")
    return "number", known[name].replace(" ", "*") if known[name] != "1" else ""


def standing_numbers(machine: Machine, results: Iterable[str]) -> tuple[dict[str, float], str]:
    """The numbers of one machine that need no run, nan where there is none, and why not."""
    result: dict[str, float] = {}
    reasons = []
    for one in (STANDING[name] for name in results if name in STANDING):
        try:
            result[one.name] = one.of(machine)
        except AutobalancerError as error:
            result[one.name] = np.nan
            reasons.append(f"{one.text}: {error}")
    return result, "; ".join(reasons)


# The members of a study and what they left, as a labeled dataset.


COUNTED = {
    "steps": "accepted steps",
    STALLED: "whether a ball or the rotor is stalled at the end",
    BALANCED_BEFORE: "whether the run was balanced before the unbalance appeared",
    "drawn_again": "how often the draw was taken again because no machine can be like that",
    "reason": "why the member is impossible, or has no number",
}


def study_dataset(study: Study, chunks: Mapping[tuple[int, int], Arrays], count: int) -> xr.Dataset:
    """Over ``member``: coordinates are what varied, ``draw``, ``point`` and ``seed``; variables what each member left.

    Parameters
    ----------
    study
        What was asked.
    chunks
        Finished chunks by their first and after their last member.
    count
        Members after which the study stopped; what was run beyond does not count.
    """
    spans = sorted(span for span in chunks if span[0] < count)
    number = np.concatenate([np.arange(*span) for span in spans] or [np.zeros(0, np.int64)]).astype(np.int64)
    kept = number < count
    dataset = xr.Dataset(attrs=_attributes(study))
    station = reference_station(study.machine) if RUN in study.results else ""
    arrays = {name: _joined([chunks[span].get(name) for span in spans])[kept] for name in _names(chunks, spans)}
    number = number[kept]
    draw, point = np.divmod(number, len(study.points))
    dataset = dataset.assign_coords(
        member=("member", number + 1, {"long_name": "number of the member"}),
        draw=("member", draw + 1, {"long_name": "number of the draw"}),
        point=("member", point + 1, {"long_name": "number of the point of the grid"}),
        **_varied(study, arrays, point),
    )
    for name, values in arrays.items():
        if not name.startswith("vary:") and name != "seed":
            dims = ("member", "ball") if values.ndim == 2 else ("member",)
            dataset[name] = (
                dims,
                values.astype(object) if values.dtype.kind == "U" else values,
                _label(name, study.settling_from, station),
            )
    seconds = sum(float(chunks[span][SECONDS][0]) for span in spans)
    if RUN in study.results and kept.any():
        dataset.attrs["run_time_per_member"] = seconds / int(kept.size)
        dataset.attrs["steps_per_member"] = float(dataset["steps"].values.mean())
    return dataset


def _attributes(study: Study) -> dict[str, Any]:
    return {
        "title": f"Study {study.name} of {study.machine.name}",
        **provenance(),
        "machine": machine_text(study.machine),
        **({} if study.base is None else {"base_machine": machine_text(study.base)}),
        "machine_name": study.machine.name,
        "study": json.dumps(study.identity()),
        "study_name": study.name,
        "plan": study.plan,
        "inputs": study.inputs,
        "grid": list(study.grid),
        "parameters": [*study.grid, *study.scatter],
        "duration": study.duration,
        **({"show": list(study.show)} if study.show else {}),
        **({} if study.sudden is None else {"sudden_unbalance": study.sudden.place, "before": study.sudden.before}),
        "tolerance": study.tolerance,
        "bins": study.bins,
        "settling_from": study.settling_from,
        "starts": "random" if study.random_starts else "machine",
    }


def _names(chunks: Mapping[tuple[int, int], Arrays], spans: list[tuple[int, int]]) -> list[str]:
    return [name for name in dict.fromkeys(name for span in spans for name in chunks[span]) if name not in ABOUT]


def _joined(parts: list[Any]) -> Any:
    """Arrays one behind the other; those over balls get as many columns as the widest has."""
    width = max((part.shape[1] for part in parts if part.ndim == 2), default=0)
    if width:
        parts = [np.pad(part, ((0, 0), (0, width - part.shape[1])), constant_values=np.nan) for part in parts]
    return np.concatenate(parts)


def _varied(study: Study, arrays: Arrays, point: Any) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for place, name in enumerate(study.grid):
        values, label = _labeled(study, name, [point[place] for point in study.points])
        result[dimension_of(name)] = ("member", np.asarray(values)[point], label)
    for name in study.scatter:
        values, label = _labeled(study, name, arrays[f"vary:{name}"].tolist())
        result[dimension_of(name)] = ("member", np.asarray(values), label)
    if "seed" in arrays:
        result["seed"] = ("member", arrays["seed"], {"long_name": "seed of the start"})
    return result


def _labeled(study: Study, name: str, values: list[Any]) -> tuple[Any, dict[str, str]]:
    if is_start(name):
        return values, {"long_name": axis_name(name), "units": STARTS[ball_of(name)[0]]}
    result, label = coordinate(study.machine, name, values)
    if study.sudden is not None and name == HELD_SPEED:
        label["long_name"] = "rotor speed"
    elif name in SHAPES and getattr(getattr(study.machine.drive, "profile", None), "kind", "") == "reduction":
        label["long_name"] = SHAPES[name]
    return result, label


def _label(name: str, settling_from: str, station: str) -> dict[str, Any]:
    for one in STANDING.values():
        if one.name == name:
            return {"long_name": one.text, "units": one.unit}
    measure = next((one for one in SWEPT if one.name == name), None)
    if measure is not None:
        return label_of(measure, settling_from, station)
    if name == RULE_BALANCED:
        return {"long_name": "whether the verdict is 'balanced'"}
    if name == "start_ball_angle_in_rotor":
        return dict(START_ANGLE)
    return {"long_name": COUNTED[name]} if name in COUNTED else {}


# The shape of a run-up as something that varies: rate, dwell, a temporary reduction of the speed.


RUN_UP = "run_up"


class RunUp(Question):
    """The shape of the run-up."""

    speed: Rate = key("of operation")
    rate: Annotated[float, Quantity("rad/s^2")] = key("of the run-up")
    dwell_speed: Rate | None = key("of a dwell on the way up", None)
    dwell: Time | None = key("time of this dwell", None)
    before_reduction: Time | None = key("time at the speed, before it is reduced for a while", None)
    reduced: Rate | None = key("to which the speed is reduced", None)
    reduced_for: Time | None = key("time at the reduced speed", None)


SHAPES = {
    "drive.profile.end & drive.profile.peak": "rotor speed",
    "drive.profile.acceleration": "rate of the run-up",
    "drive.profile.dwell": "speed of the dwell on the way up",
    "drive.profile.hold_dwell": "time of this dwell",
    "drive.profile.hold_peak": "time before the reduction",
    "drive.profile.reduced": "speed to which it is reduced",
    "drive.profile.hold_reduced": "time at the reduced speed",
}

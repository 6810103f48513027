"""Study files: TOML, or the same as a dict, turned into a study; every fault is named with its key."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from autobalancer.assembly.drive_train import corners
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import MachineError, Problem, QuestionError, UnitError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.samples import beside
from autobalancer.files.text_files import built_of, question_data
from autobalancer.machine import Machine, Reduction
from autobalancer.machine.part import Amount, Duration, Label, Listed, Question, key, unknown_key
from autobalancer.random_numbers import GREATEST
from autobalancer.studies.ensemble.columns import SEED, is_start, unit_of_column
from autobalancer.studies.study.chunk import OUTPUTS, RUN, RUN_UP, RunUp, quantity_kind
from autobalancer.studies.study.study_spec import (
    OF_UNBALANCE,
    START,
    TABLE,
    WANTED,
    Distribution,
    Impossible,
    Normal,
    Plan,
    Stop,
    Study,
    Sudden,
    SuddenUnbalance,
    Varied,
    copula_factor,
)
from autobalancer.studies.variations import listed, with_variation
from autobalancer.units import list_argument, shortened, to_si

Whole = Annotated[int, Field(strict=True, ge=1, le=GREATEST)]
Seed = Annotated[int, Field(strict=True, ge=0, le=GREATEST)]
Texts = Annotated[tuple[Label, ...], Listed]
MOST = 10_000_000  # members


class Correlation(Question):
    """The correlation of two parameters that scatter."""

    between: tuple[Label, Label] = key("their names")
    value: Annotated[float, Field(strict=True, ge=-1.0, le=1.0)] = key(
        "of the normal numbers behind both (Gaussian copula)"
    )


class Joint(Question):
    """Parameters that are normal together."""

    names: Annotated[tuple[Label, ...], Field(min_length=1)] = key("of the parameters")
    covariance: tuple[tuple[Annotated[float, Field(strict=True)], ...], ...] = key(
        "in SI, a row for each name", value="list of lists of numbers"
    )
    mean: tuple[Amount, ...] | None = key(
        "a value for each name; those of the machine unless given", None, value="list in the units of the parameters"
    )

    def contradictions(self) -> Iterator[Problem]:
        """What is no covariance of these names, and means that are not theirs."""
        size, rows = len(self.names), self.covariance
        if len(rows) != size or any(len(row) != size for row in rows):
            yield ("covariance",), f"must have {size} rows of {size} numbers, in SI"
        elif any(rows[i][j] != rows[j][i] for i in range(size) for j in range(i)):
            yield ("covariance",), "must be symmetric"
        elif any(not rows[i][i] > 0.0 for i in range(size)):
            yield ("covariance",), "its diagonal holds variances, which must be greater than zero"
        if self.mean is not None and len(self.mean) != size:
            yield ("mean",), f"given {shortened(list(self.mean))}; must be a list of {size} values, as of names"


class StudyFile(Question):
    """A machine, what varies in it and how, and what is asked of every member."""

    machine: Any = key("machine file, seen from this file", value="text")
    name: Label = key("of the study", "")
    members: Whole = key("draws at each point of the grid, at most; base samples with the plan `sensitivity`", 1000)
    plan: Plan = key(
        "of the draws: `sobol` and `latin_hypercube` fill the space more evenly, `sensitivity` is for Sobol' indices",
        "random",
    )
    seed: Seed = key("equal seeds, equal numbers", 0)
    starts: Literal["random", "machine"] = key("of the balls: each draw its own, or those of the machine", "random")
    duration: Duration | None = key("of a run", None, default_text="that of the machine")
    tolerance: Annotated[float, Field(strict=True, ge=1e-13, le=1e-2)] = key("relative, of the integration", 1e-6)
    bins: Annotated[int, Field(strict=True, ge=10, le=GREATEST)] = key("of time in which the peak is looked for", 500)
    settling_from: Literal["run-up", "release"] = key("what settling times count from", "run-up")
    results: Annotated[Texts, Field(min_length=1)] = key(
        "`run` for all measures; border speeds by name, `critical speed` and `capability` need no run", (RUN,)
    )
    impossible: Impossible = key("draws that make no machine: refuse them, draw again, or count them", "refuse")
    sudden_unbalance: SuddenUnbalance | None = key("that appears at speed", None)
    run_up: RunUp | None = key("in place of the drive of the machine", None)
    vary: Varied = key("values that form a grid, and distributions", {}, value="lists, ranges, or tables")
    correlation: Annotated[tuple[Correlation, ...], Listed] = key("of pairs", ())
    joint: Annotated[tuple[Joint, ...], Listed] = key("parameters that are normal together", ())
    stop: Stop | None = key("when draws are enough", None)
    show: Texts = key("quantities of the table", (), default_text="peak deflection")

    @field_validator("results")
    @classmethod
    def _are_known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for one in value:
            if one not in OUTPUTS:
                raise ValueError(f"given {one!r}; must be one of {', '.join(map(repr, OUTPUTS))}")
        return tuple(dict.fromkeys(value))

    def contradictions(self) -> Iterator[Problem]:
        """A sudden unbalance beside what it cannot have."""
        if self.sudden_unbalance is not None and self.run_up is not None:
            yield (TABLE,), f"give it or {RUN_UP!r}; an unbalance appears while the speed is held"
        if self.sudden_unbalance is not None and (RUN not in self.results or self.duration is not None):
            yield (TABLE,), "needs 'run' among the results, and no 'duration': it has 'before' and 'after'"


def read_study(options: str | Path | Mapping[str, Any]) -> Study:
    """A study from a file or a dict of the same form.

    Raises
    ------
    QuestionError
        With the file and the key at fault, what was given, and what is allowed.
    MachineFileError
        If its machine cannot be read.
    """
    data, source, folder, name = question_data(options, "study", "study")

    def build(options: Mapping[str, Any]) -> Study:
        written = {key: one for key, one in options.items() if key != "machine"}
        return _study(StudyFile(**options), written, folder, name)

    return built_of(build, data, source)


OF_PROFILE = {
    "speed": "end",
    "rate": "acceleration",
    "dwell_speed": "dwell",
    "dwell": "hold_dwell",
    "before_reduction": "hold_peak",
    "reduced": "reduced",
    "reduced_for": "hold_reduced",
}


def _study(study_file: StudyFile, written: dict[str, Any], folder: Path, name: str) -> Study:
    given = study_file.machine
    machine = base = balls_in_races(beside(folder, given) if isinstance(given, (str, Path)) else given)
    sudden, paths = None, dict[str, dict[str, str]]()
    if study_file.sudden_unbalance is not None:
        machine, sudden = _with_sudden(machine, study_file.sudden_unbalance)
        paths[TABLE] = sudden.paths()
    if study_file.run_up is not None:
        machine, paths[RUN_UP] = _with_run_up(machine, study_file.run_up)
    grid, scatter = vary(machine, _as_paths(study_file.vary, paths))
    pairs = _joint(machine, study_file.joint, scatter) | {one.between: one.value for one in study_file.correlation}
    check_pairs(pairs, scatter)
    with _at("show"):
        shown = tuple(one for one in study_file.show if quantity_kind(one, study_file.results)[0] != "bool")
    own = math.nan if machine.run is None else float(machine.run.duration)
    study = Study(
        machine=machine,
        name=study_file.name or name,
        grid=grid,
        scatter=scatter,
        correlation=pairs,
        members=study_file.members,
        plan=study_file.plan,
        seed=study_file.seed,
        random_starts=study_file.starts == "random" and RUN in study_file.results,
        duration=sudden.after
        if sudden is not None
        else own
        if study_file.duration is None
        else float(study_file.duration),
        tolerance=study_file.tolerance,
        bins=study_file.bins,
        results=study_file.results,
        impossible=study_file.impossible,
        stop=None if study_file.stop is None else _stop(study_file.stop, study_file.results),
        show=shown,
        base=base if base is not machine else None,
        sudden=sudden,
        settling_from=study_file.settling_from,
        written=written,
    )
    if problems := [*_contradictions(study), *(_too_short(study) if study_file.run_up is not None else ())]:
        raise QuestionError.of("", problems)
    return study


def _too_short(study: Study) -> Iterator[Problem]:
    """That the study ends before one of its run-ups does."""
    longest = 0.0
    for point in study.points:
        own = {name: value for name, value in zip(study.grid, point, strict=True) if name.startswith("drive.")}
        machine = with_variation(study.machine, own, tuple(own.values()))
        profile = machine.drive.profile  # type: ignore[union-attr]
        assert isinstance(profile, Reduction)
        longest = max(longest, corners(profile)[-1][0])
    if longest >= study.duration:
        text = f"the run-up takes up to {longest:.4g} s, and runs end after {study.duration:.4g} s"
        yield ("duration",), f"{text}; give a longer duration, so that the balls have time at the last speed"


def _with_run_up(machine: Machine, run_up: RunUp) -> tuple[Machine, dict[str, str]]:
    """A machine that is run up in this way; names under 'vary' with their paths.

    Raises
    ------
    MachineError
        If there can be no such run-up.
    """
    shape = {name: value for key, name in OF_PROFILE.items() if (value := getattr(run_up, key)) is not None}
    profile = {"kind": "reduction", "peak": run_up.speed, "reduced": run_up.speed, **shape}
    machine = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    paths = {key: f"drive.profile.{name}" for key, name in OF_PROFILE.items()}
    paths["speed"] = "drive.profile.end & drive.profile.peak"
    return machine, paths


def _with_sudden(machine: Machine, sudden_unbalance: SuddenUnbalance) -> tuple[Machine, Sudden]:
    """A machine that runs at one speed with one unbalance more, and when that appears.

    Raises
    ------
    MachineError
        If there can be no such unbalance.
    """
    profile = {"kind": "constant", "speed": sudden_unbalance.speed}
    machine = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    added = {name: value for name in OF_UNBALANCE if (value := getattr(sudden_unbalance, name)) is not None}
    machine = with_value_at(machine, "unbalances", (*machine.unbalances, added))
    return machine, Sudden(
        f"unbalances[{len(machine.unbalances)}]", float(sudden_unbalance.before), float(sudden_unbalance.after)
    )


@contextmanager
def _at(*path: str | int) -> Iterator[None]:
    """What is refused meanwhile is at a path of the file."""
    try:
        yield
    except (QuestionError, UnitError, MachineError) as error:
        raise QuestionError.of("", error.within(*path).problems) from None


def _stop(stop: Stop, results: tuple[str, ...]) -> Stop:
    with _at("stop", "of"):
        kind, unit = quantity_kind(stop.of, results)
    with _at("stop"):
        return stop.settled(kind, unit)


def _contradictions(study: Study) -> Iterator[Problem]:
    """All that cannot be asked together."""
    if study.count > MOST:
        yield ("members",), f"{study.count} in all are asked for; at most {MOST} are possible"
    if not study.grid and not study.inputs:
        yield ("vary",), "nothing varies; give a parameter with values or a distribution, or random starts"
    elif study.plan == "sensitivity" and not study.inputs:
        yield ("plan",), "'sensitivity' needs inputs that scatter; give distributions under 'vary'"
    if study.plan == "sensitivity" and study.correlation:
        yield ("correlation",), "Sobol' indices need inputs that are independent; take the plan 'random'"
    if study.impossible == "truncate" and study.plan != "random":
        yield ("impossible",), f"'truncate' draws again, which the plan {study.plan!r} cannot; take 'random'"
    if study.stop is not None and study.plan != "random":
        text = f"the intervals are those of independent draws, and the plan is {study.plan!r}; take the plan 'random'"
        yield ("stop",), text
    if START in study.scatter:
        yield ("vary", START), "no parameter has this name; random starts are starts = 'random'"


def _as_paths(options: Mapping[str, Any], paths: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    """What varies by its path in the machine, where it is named by a key of a table of the study.

    ``[vary.run_up.rate]`` is the same as ``[vary."run_up.rate"]``.
    """
    result: dict[str, Any] = {}
    for name, entry in options.items():
        table, _, key = str(name).partition(".")
        if table not in paths:
            result[str(name)] = entry
            continue
        for inner, value in {key: entry}.items() if key else dict(entry).items():
            if inner not in paths[table]:
                raise QuestionError(unknown_key(inner, [*paths[table]]), ("vary", table, inner))
            result[paths[table][inner]] = value
    return result


# What varies in a study file: values that form a grid, distributions, and how they are correlated.


Pairs = dict[tuple[str, str], float]


def vary(
    machine: Machine, options: Mapping[str, Any], table: str = "vary"
) -> tuple[dict[str, list[Any]], dict[str, Distribution]]:
    """Parameters with the values of a grid, and parameters with a distribution, from a table of a file."""
    grid: dict[str, list[Any]] = {}
    scatter: dict[str, Distribution] = {}
    for name, entry in options.items():
        with _at(table, name):
            if name == SEED:
                raise QuestionError("starts = 'random' gives every draw a seed of its own")
            unit = unit_of_column(machine, name)
            if isinstance(entry, Distribution):
                scatter[name] = entry.settled(unit, lambda key, name=name: _of_machine(machine, name))  # type: ignore[misc]
                continue
            if isinstance(entry, Mapping):
                raise QuestionError(f"given {shortened(dict(entry))}; {WANTED}")
            grid[name] = list_argument(name, entry, unit) if is_start(name) else list(listed(machine, name, entry))
            if not grid[name]:
                raise QuestionError("given no value; give at least one")
    return grid, scatter


def _of_machine(machine: Machine, name: str) -> float:
    from autobalancer.assembly.quantities import value_of

    value = math.nan if is_start(name) else value_of(machine, name)
    if not math.isfinite(value):
        raise QuestionError(f"missing, and the machine has no single value of {name!r} to take for it")
    return value


def _joint(machine: Machine, values: Sequence[Joint], scatter: dict[str, Distribution]) -> Pairs:
    """Normal parameters with their covariance (SI); they join ``scatter``."""
    pairs: Pairs = {}
    for place, one in enumerate(values):
        deviation = [math.sqrt(one.covariance[i][i]) for i in range(len(one.names))]
        for i, name in enumerate(one.names):
            if name in scatter:
                text = f"{name!r} has a distribution under 'vary' already; give it once"
                raise QuestionError(text, ("joint", place))
            with _at("joint", place, "mean"):
                own = None if one.mean is None else to_si(one.mean[i], unit_of_column(machine, name))
                mean = _of_machine(machine, name) if own is None else float(own)
            scatter[name] = Normal(mean=mean, standard_deviation=deviation[i])
            for j in range(i):
                pairs[one.names[j], name] = one.covariance[i][j] / (deviation[i] * deviation[j])
    return pairs


def check_pairs(pairs: Pairs, scatter: dict[str, Distribution]) -> None:
    """Refuse correlations of what does not scatter, and those that no numbers can have."""
    for one, other in pairs:
        for name in (one, other):
            if name not in scatter:
                text = f"{name!r} has no distribution under 'vary'; there are {list(scatter)}"
                raise QuestionError(text, ("correlation",))
        if one == other:
            raise QuestionError(f"{one!r} is named twice; a correlation is between two parameters", ("correlation",))
    copula_factor(list(scatter), pairs)

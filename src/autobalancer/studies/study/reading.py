"""Study files: TOML, or the same as a dict, turned into a study; every fault is named with its key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.samples import beside
from autobalancer.files.text import read_toml
from autobalancer.machine import Machine
from autobalancer.machine.part import unknown_key
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.studies.study.entries import number, one_of, whole
from autobalancer.studies.study.outputs import OUTPUTS, RUN, quantity_kind
from autobalancer.studies.study.run_up import RUN_UP, check_length, with_run_up
from autobalancer.studies.study.samples import PLANS
from autobalancer.studies.study.scatter import check_pairs, correlation, joint, vary
from autobalancer.studies.study.spec import START, Study
from autobalancer.studies.study.stopping import Stop
from autobalancer.studies.study.sudden import TABLE, with_sudden
from autobalancer.units import argument, shortened

DEFAULTS: dict[str, Any] = {
    "name": None,
    "members": 1000,
    "plan": "random",
    "seed": 0,
    "starts": "random",
    "duration": None,
    "tolerance": 1e-6,
    "bins": 500,
    "settling_from": SETTLING_FROM[0],
    "results": ["run"],
    "impossible": "refuse",
    TABLE: None,
    RUN_UP: None,
    "vary": {},
    "correlation": [],
    "joint": [],
    "stop": None,
    "show": [],
}
KEYS = ("machine", *DEFAULTS)
MOST = 10_000_000  # members


def read_study(given: str | Path | Mapping[str, Any]) -> Study:
    """A study from a file or a dict of the same form.

    Raises
    ------
    QuestionError
        With the file and the key at fault, what was given, and what is allowed.
    MachineFileError
        If its machine cannot be read.
    """
    if isinstance(given, (str, Path)):
        path = Path(given)
        data = read_toml(path)
        return _named_faults(str(path), data, path.parent, path.stem)
    if isinstance(given, Mapping):
        return _named_faults("study", dict(given), Path(), "study")
    raise QuestionError(f"study: given {shortened(given)}; give the path of a study file, or a dict of the same form")


def _named_faults(source: str, data: dict[str, Any], folder: Path, name: str) -> Study:
    try:
        return _read(data, folder, name)
    except QuestionError as error:
        raise QuestionError(f"{source}: {error}") from None


def _read(data: dict[str, Any], folder: Path, name: str) -> Study:
    for key in data:
        if key not in KEYS:
            raise QuestionError(f"{key}: {unknown_key(key, sorted(KEYS))}")
    if "machine" not in data:
        raise QuestionError('machine: missing; give the path of a machine file, such as machine = "centrifuge.toml"')
    given = {**DEFAULTS, **data}
    machine = _machine(data["machine"], folder)
    base, sudden, paths = machine, None, dict[str, dict[str, str]]()
    if given[TABLE] is not None and given[RUN_UP] is not None:
        raise QuestionError(f"{TABLE}, {RUN_UP}: give one of them; an unbalance appears while the speed is held")
    if given[TABLE] is not None:
        machine, sudden = with_sudden(machine, given[TABLE])
        paths[TABLE] = sudden.paths()
    if given[RUN_UP] is not None:
        machine, paths[RUN_UP] = with_run_up(machine, given[RUN_UP])
    if isinstance(given["vary"], Mapping):
        given["vary"] = _as_paths(given["vary"], paths)
    grid, scatter = vary(machine, given["vary"])
    pairs = joint(machine, given["joint"], scatter) | correlation(given["correlation"])
    check_pairs(pairs, scatter)
    random_starts = one_of("starts", given["starts"], ("random", "machine")) == "random"
    results = _results(given["results"])
    plan = one_of("plan", given["plan"], PLANS)
    study = Study(
        machine=machine,
        name=str(given["name"] or name),
        grid=grid,
        scatter=scatter,
        correlation=pairs,
        members=whole("members", given["members"], 1),
        plan=cast(Any, plan),
        seed=whole("seed", given["seed"], 0),
        random_starts=random_starts and RUN in results,
        duration=_duration(machine, given["duration"]) if sudden is None else sudden.after,
        tolerance=number("tolerance", given["tolerance"], 1e-13, 1e-2),
        bins=whole("bins", given["bins"], 10),
        results=results,
        impossible=cast(Any, one_of("impossible", given["impossible"], ("refuse", "truncate", "record"))),
        stop=None if given["stop"] is None else stop_of(given["stop"], results),
        show=_shown(given["show"], results),
        base=base if base is not machine else None,
        sudden=sudden,
        settling_from=one_of("settling_from", given["settling_from"], SETTLING_FROM),
        written={key: value for key, value in data.items() if key != "machine"},
    )
    _checkwhole(study)
    if given[RUN_UP] is not None:
        check_length(study)
    return study


def _checkwhole(study: Study) -> None:
    if study.count > MOST:
        raise QuestionError(f"members: {study.count} in all are asked for; at most {MOST} are possible")
    if not study.grid and not study.inputs:
        raise QuestionError("vary: nothing varies; give a parameter with values or a distribution, or random starts")
    if study.plan == "sensitivity" and study.correlation:
        raise QuestionError(
            "plan, correlation: Sobol' indices need inputs that are independent; take the plan 'random'"
        )
    if study.plan == "sensitivity" and not study.inputs:
        raise QuestionError("plan: 'sensitivity' needs inputs that scatter; give distributions under 'vary'")
    if study.impossible == "truncate" and study.plan != "random":
        raise QuestionError(f"impossible: 'truncate' draws again, which the plan {study.plan!r} cannot; take 'random'")
    if study.stop is not None and study.plan != "random":
        raise QuestionError(
            f"stop: the intervals are those of independent draws, and the plan is {study.plan!r}; take the plan 'random'"
        )
    if study.sudden is not None and (RUN not in study.results or study.written.get("duration") is not None):
        raise QuestionError(f"{TABLE}: needs 'run' among the results, and no 'duration': it has 'before' and 'after'")
    if START in study.scatter:
        raise QuestionError(f"vary.{START}: no parameter has this name; random starts are starts = 'random'")


def _as_paths(given: Mapping[str, Any], paths: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    """What varies by its path in the machine, where it is named by a key of a table of the study.

    ``[vary.run_up.rate]`` is the same as ``[vary."run_up.rate"]``.
    """
    found: dict[str, Any] = {}
    for name, entry in given.items():
        table, _, key = str(name).partition(".")
        if table not in paths:
            found[str(name)] = entry
            continue
        for inner, value in {key: entry}.items() if key else dict(entry).items():
            if inner not in paths[table]:
                raise QuestionError(f"vary.{table}.{inner}: {unknown_key(inner, [*paths[table]])}")
            found[paths[table][inner]] = value
    return found


def _machine(given: Any, folder: Path) -> Machine:
    return balls_in_races(beside(folder, given) if isinstance(given, (str, Path)) else given)


def stop_of(given: Any, results: tuple[str, ...]) -> Stop:
    allowed = ("of", "statistic", "half_width", "relative", "at")
    if not isinstance(given, Mapping):
        raise QuestionError(f"stop: given {shortened(given)}; must be a table with {', '.join(allowed)}")
    for key in given:
        if key not in allowed:
            raise QuestionError(f"stop.{key}: {unknown_key(key, allowed)}")
    if "of" not in given:
        raise QuestionError("stop.of: missing; name a quantity, such as 'balanced' or 'peak_deflection'")
    try:
        of, kind, unit = str(given["of"]), *quantity_kind(str(given["of"]), results)
    except QuestionError as error:
        raise QuestionError(f"stop.of: {error}") from None
    usual = "share" if kind == "bool" else "mean"
    statistic = one_of("stop.statistic", given.get("statistic", usual), ("share", "mean", "quantile"))
    if (statistic == "share") != (kind == "bool"):
        raise QuestionError(
            f"stop.statistic: given {statistic!r}; of {of!r} there is {usual!r}{'' if kind == 'bool' else ' or quantile'}"
        )
    if ("half_width" in given) == ("relative" in given):
        raise QuestionError(
            "stop: give half_width, in the unit of the quantity, or relative, over its value; one of them"
        )
    level = number("stop.at", given.get("at", 0.5), 0.0, 1.0)
    width = "half_width" if "half_width" in given else "relative"
    value = argument(f"stop.{width}", given[width], "" if statistic == "share" or width == "relative" else unit)
    if not value > 0.0:
        raise QuestionError(f"stop.{width}: given {given[width]!r}; must be greater than zero")
    return Stop(of, statistic, at=level, **{width: value})


def _results(given: Any) -> tuple[str, ...]:
    wanted = [given] if isinstance(given, str) else given
    if not isinstance(wanted, list) or not wanted:
        raise QuestionError(f"results: given {shortened(given)}; must be a list of {', '.join(OUTPUTS)}")
    for one in wanted:
        one_of("results", one, tuple(OUTPUTS))
    return tuple(dict.fromkeys(wanted))


def _shown(given: Any, results: tuple[str, ...]) -> tuple[str, ...]:
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, list):
        raise QuestionError(f"show: given {shortened(given)}; must be a list of quantities")
    for name in names:
        try:
            quantity_kind(str(name), results)
        except QuestionError as error:
            raise QuestionError(f"show: {error}") from None
    return tuple(str(name) for name in names if quantity_kind(str(name), results)[0] != "bool")


def _duration(machine: Machine, given: Any) -> float:
    if given is None:
        return float(machine.run.duration) if machine.run is not None else math.nan
    found = argument("duration", given, "s")
    if not (math.isfinite(found) and found > 0.0):
        raise QuestionError(f"duration: given {given!r}; must be a time greater than zero")
    return found

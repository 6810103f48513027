"""Study files: TOML, or the same as a dict, turned into a study; every fault is named with its key."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.samples import beside
from autobalancer.files.text import read_toml
from autobalancer.machine import Machine
from autobalancer.machine.part import unknown_key
from autobalancer.random_numbers import GREATEST
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.studies.ensemble.columns import SEED, is_start, unit_of_column
from autobalancer.studies.study.chunk import OUTPUTS, RUN, RUN_UP, check_length, quantity_kind, with_run_up
from autobalancer.studies.study.spec import (
    KINDS,
    PLANS,
    START,
    TABLE,
    Distribution,
    Normal,
    Stop,
    Study,
    joined,
    with_sudden,
)
from autobalancer.studies.variations import listed
from autobalancer.units import argument, list_argument, shortened

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


# What varies in a study file: values that form a grid, distributions, and how they are correlated.


Pairs = dict[tuple[str, str], float]


def vary(machine: Machine, given: Any) -> tuple[dict[str, list[Any]], dict[str, Distribution]]:
    """Parameters with the values of a grid, and parameters with a distribution."""
    if not isinstance(given, Mapping):
        raise QuestionError(f"vary: given {shortened(given)}; must be a table of parameters")
    grid: dict[str, list[Any]] = {}
    scatter: dict[str, Distribution] = {}
    for name, table in given.items():
        try:
            if name == SEED:
                raise QuestionError("starts = 'random' gives every draw a seed of its own")
            unit = unit_of_column(machine, name)
            if isinstance(table, Mapping) and "distribution" in table:
                scatter[name] = distribution(machine, name, unit, dict(table))
            else:
                values = table["values"] if isinstance(table, Mapping) and set(table) == {"values"} else table
                grid[name] = _values(machine, name, unit, values)
        except AutobalancerError as error:
            raise QuestionError(f"vary.{_quoted(name)}: {error}") from None
    return grid, scatter


def _values(machine: Machine, name: str, unit: str, values: Any) -> list[Any]:
    if values is None or isinstance(values, Mapping):
        raise QuestionError(
            f"given {shortened(values)}; give 'values' = a list or a range, or 'distribution' = one of {', '.join(KINDS)}"
        )
    found = list_argument(name, values, unit) if is_start(name) else list(listed(machine, name, values))
    if not found:
        raise QuestionError("given no value; give at least one")
    return found


def distribution(machine: Machine, name: str, unit: str, table: dict[str, Any]) -> Distribution:
    """The distribution of one parameter from its table in a study file.

    Raises
    ------
    QuestionError
        For an unknown distribution or key, a missing one, and numbers that are none or make no distribution.
    """
    word = one_of("distribution", table.pop("distribution"), tuple(KINDS))
    kind = KINDS[word]
    for key in table:
        if key not in (*kind.needs, *kind.may):
            raise QuestionError(f"{key}: {unknown_key(key, [*kind.needs, *kind.may])}")
    middle = {"mean", "median", "mode", "nominal"} & set(kind.needs)
    for key in kind.needs:
        if key not in table and key in middle and not is_start(name):
            table[key] = _of_machine(machine, name, key)
        elif key not in table:
            raise QuestionError(f"{key}: missing; {word!r} needs {', '.join(kind.needs)}")
    if word == "discrete":
        found = kind(tuple(_discrete(table["values"], unit)), _weights(table.get("weights", ())))  # type: ignore[call-arg]
    else:
        found = kind(**_numbers(word, table, unit))
    if wrong := found.wrong():
        raise QuestionError(wrong)
    return found


def _numbers(word: str, table: dict[str, Any], unit: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        if key == "shape":
            found[key] = value
        elif key == "factor":
            found[key] = argument(key, value, "")
        elif key in ("plus", "minus", "plus_minus", "standard_deviation"):
            middle = "nominal" if word == "tolerance" else "mean"
            found[key] = _width(key, value, unit, argument(middle, table[middle], unit))
        else:
            found[key] = argument(key, value, unit)
    both = found.pop("plus_minus", None)
    if both is not None:
        if "plus" in found or "minus" in found:
            raise QuestionError("plus_minus: stands alone; give it, or plus and minus")
        found |= {"plus": both, "minus": both}
    return found


def _width(key: str, value: Any, unit: str, middle: float) -> float:
    """A difference in the unit of the parameter, or a percentage of its middle."""
    share = isinstance(value, str) and value.strip().endswith("%")
    if share and unit == "K":
        raise QuestionError(f"{key}: given {value!r}; a share of an absolute temperature says little, write it in K")
    if share:
        return abs(middle) * argument(key, value, "")
    if unit == "K" and isinstance(value, str) and "deg" in value:
        raise QuestionError(f"{key}: given {value!r}; a difference of temperatures is written in K, such as '3 K'")
    return argument(key, value, unit)


def _discrete(values: Any, unit: str) -> Sequence[Any]:
    if not isinstance(values, (list, tuple)):
        raise QuestionError(f"values: given {shortened(values)}; must be a list")
    if not unit and all(isinstance(value, str) for value in values):
        return values
    return list_argument("values", values, unit)


def _weights(given: Any) -> tuple[float, ...]:
    if not isinstance(given, (list, tuple)) or any(
        isinstance(one, bool) or not isinstance(one, (int, float)) for one in given
    ):
        raise QuestionError(f"weights: given {shortened(given)}; must be a list of numbers")
    return tuple(float(one) for one in given)


def _of_machine(machine: Machine, name: str, key: str) -> float:
    from autobalancer.assembly.quantities import value_of

    value = value_of(machine, name)
    if not math.isfinite(value):
        raise QuestionError(f"{key}: missing, and the machine has no single value of {name!r} to take for it")
    return value


def joint(machine: Machine, given: Any, scatter: dict[str, Distribution]) -> Pairs:
    """Normal parameters with their covariance (SI); they join ``scatter``."""
    found: Pairs = {}
    for place, table in enumerate(tables("joint", given), start=1):
        where = f"joint[{place}]"
        names, covariance = cast(Any, table.get("names")), cast(Any, table.get("covariance"))
        if set(table) - {"names", "mean", "covariance"} or not _are_texts(names):
            raise QuestionError(f"{where}: must have 'names', 'covariance' in SI, and may have 'mean'")
        if not _square(covariance, len(names)):
            raise QuestionError(f"{where}.covariance: must have {len(names)} rows of {len(names)} numbers, in SI")
        if any(covariance[i][j] != covariance[j][i] for i in range(len(names)) for j in range(i)):
            raise QuestionError(f"{where}.covariance: must be symmetric")
        if any(not covariance[i][i] > 0.0 for i in range(len(names))):
            raise QuestionError(f"{where}.covariance: its diagonal holds variances, which must be greater than zero")
        means = table.get("mean") or [_of_machine(machine, name, "mean") for name in names]
        if not isinstance(means, list) or len(means) != len(names):
            raise QuestionError(
                f"{where}.mean: given {shortened(means)}; must be a list of {len(names)} values, as of names"
            )
        deviation = [math.sqrt(covariance[i][i]) for i in range(len(names))]
        for i, name in enumerate(names):
            if name in scatter:
                raise QuestionError(f"{where}: {name!r} has a distribution under 'vary' already; give it once")
            scatter[name] = Normal(argument(f"{where}.mean", means[i], unit_of_column(machine, name)), deviation[i])
            for j in range(i):
                found[names[j], name] = covariance[i][j] / (deviation[i] * deviation[j])
    return found


def _are_texts(names: Any) -> bool:
    return isinstance(names, list) and bool(names) and all(isinstance(name, str) for name in names)


def _square(matrix: Any, size: int) -> bool:
    return (
        isinstance(matrix, list)
        and len(matrix) == size
        and all(isinstance(row, list) and len(row) == size for row in matrix)
        and all(isinstance(one, (int, float)) for row in matrix for one in row)
    )


def correlation(given: Any) -> Pairs:
    """Correlations of pairs."""
    found: Pairs = {}
    for place, table in enumerate(tables("correlation", given), start=1):
        between, value = table.get("between"), table.get("value")
        if set(table) != {"between", "value"} or not isinstance(between, list) or len(between) != 2:
            raise QuestionError(f"correlation[{place}]: must have 'between', two names, and 'value'")
        found[str(between[0]), str(between[1])] = number(f"correlation[{place}].value", value, -1.0, 1.0)
    return found


def check_pairs(pairs: Pairs, scatter: dict[str, Distribution]) -> None:
    """Refuse correlations of what does not scatter, and those that no numbers can have."""
    for one, other in pairs:
        for name in (one, other):
            if name not in scatter:
                raise QuestionError(
                    f"correlation: {name!r} has no distribution under 'vary'; there are {list(scatter)}"
                )
        if one == other:
            raise QuestionError(f"correlation: {one!r} is named twice; a correlation is between two parameters")
    joined(list(scatter), pairs)


def _quoted(name: str) -> str:
    return f'"{name}"' if not name.isidentifier() else name


# Entries of a study file that are not quantities of a machine: one of several words, whole numbers, tables.


def one_of(key: str, given: Any, allowed: Sequence[str]) -> str:
    """One of several words."""
    if given not in allowed:
        raise QuestionError(f"{key}: given {given!r}; must be one of {', '.join(map(repr, allowed))}")
    return str(given)


def whole(key: str, given: Any, least: int) -> int:
    """A whole number."""
    if isinstance(given, bool) or not isinstance(given, int) or not least <= given <= GREATEST:
        raise QuestionError(f"{key}: given {given!r}; must be a whole number, {least} or more")
    return given


def number(key: str, given: Any, low: float, high: float) -> float:
    """A number within bounds."""
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not low <= given <= high:
        raise QuestionError(f"{key}: given {given!r}; must be a number from {low:g} to {high:g}")
    return float(given)


def tables(key: str, given: Any) -> list[dict[str, Any]]:
    """Tables of an array in TOML."""
    if not isinstance(given, list) or not all(isinstance(entry, dict) for entry in given):
        raise QuestionError(f"{key}: given {shortened(given)}; must be tables, each written as [[{key}]]")
    return given

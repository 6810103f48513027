"""What varies in a study file: values that form a grid, distributions, and how they are correlated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, cast

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.part import unknown_key
from autobalancer.studies.ensemble.columns import SEED, is_start, unit_of_column
from autobalancer.studies.study.distributions import KINDS, Distribution, Normal, joined
from autobalancer.studies.study.entries import number, one_of, tables
from autobalancer.studies.variations import listed
from autobalancer.units import argument, list_argument, shortened

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

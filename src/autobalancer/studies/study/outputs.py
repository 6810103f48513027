"""What a study asks of every member: the measures of its run, or border speeds and other numbers that need no run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from typing import Any, NamedTuple

import numpy as np

from autobalancer.catalog.race_capability import capability_of
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine import Machine
from autobalancer.results.measure_table import SWEPT
from autobalancer.rotordynamics.critical import critical_speeds
from autobalancer.stability.maps.speeds import NAMES, borders

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
        return next((one.speed for one in borders(machine, only=[name]) if one.name == name), math.nan)

    return Output(name.replace(", ", "_").replace(" ", "_"), name, "rad/s", of)


def _critical(machine: Machine) -> float:
    found = critical_speeds(machine)["critical_speed"].values
    return float(found[0]) if found.size else math.nan


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
    found: dict[str, float] = {}
    reasons = []
    for one in (STANDING[name] for name in results if name in STANDING):
        try:
            found[one.name] = one.of(machine)
        except AutobalancerError as error:
            found[one.name] = np.nan
            reasons.append(f"{one.text}: {error}")
    return found, "; ".join(reasons)


def attributes_of(name: str) -> dict[str, Any]:
    """Label of a number that needs no run."""
    one = next(one for one in STANDING.values() if one.name == name)
    return {"long_name": one.text, "units": one.unit}

"""What a specification asks for that cannot be had together; both keys are named."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.results.number_text import moment_text
from autobalancer.results.shares import wilson_interval
from autobalancer.shown import rpm_and_si
from autobalancer.studies.design.measured import refuse_beyond
from autobalancer.studies.design.spec import MARGIN, SHARE, STALL, Spec


def refuse_contradictions(spec: Spec) -> None:
    """Refuse what no design can keep.

    Raises
    ------
    QuestionError
        With the two keys that contradict each other.
    """
    ends: list[tuple[str, float, float, Callable[[float], str]]]
    ends = [("unbalance", *spec.unbalance, moment_text), ("temperature", *spec.temperature, _celsius)]
    for name, low, high, said in ends:
        if low > high:
            given = f"given {said(low)} and {said(high)}"
            raise QuestionError(
                f"{name}.from and {name}.to contradict each other: {given}; 'from' must not be above 'to'"
            )
    space = spec.space
    if not space.bore + 2.0 * space.wall < space.outer:
        raise QuestionError(
            f"space.bore and space.outer contradict each other: a bore of {1e3 * space.bore:g} mm leaves no room within an outer "
            f"diameter of {1e3 * space.outer:g} mm"
        )
    _enough_members(spec)
    settling, hold = spec.limits.get("settling_time"), spec.operation.hold
    if settling is not None and hold and settling > hold:
        raise QuestionError(
            f"limits.settling_time and operation.hold contradict each other: after the run-up the speed is held for {hold:g} s, "
            f"which cannot show a settling time of {settling:g} s; hold it longer"
        )
    if spec.measured is not None:
        refuse_beyond(spec.measured, spec.fastest)
    _fast_enough(spec)


def _celsius(temperature: float) -> str:
    return f"{temperature - 273.15:.4g} °C"


def _enough_members(spec: Spec) -> None:
    """Shares that so few runs can never show, even without a single failure."""
    members = spec.search.members
    _, most = wilson_interval(np.array([0]), members)
    for key, allowed in ((STALL, spec.limits.get(STALL)), (SHARE, 1.0 - spec.share)):
        if allowed is not None and float(most[0]) > allowed:
            needed = math.ceil(1.959964**2 * (1.0 - allowed) / allowed)
            raise QuestionError(
                f"limits.{key} and search.members contradict each other: {members} runs without a failure still leave a share of "
                f"{100.0 * float(most[0]):.3g} % possible (95 %), and {100.0 * allowed:.3g} % is asked for; take {needed} members"
            )


def _fast_enough(spec: Spec) -> None:
    """No border lies below the lowest critical speed of rotor and supports."""
    margin = spec.limits.get(MARGIN)
    if margin is None or not spec.machine.balancers:
        return
    from autobalancer.rotordynamics.critical import critical_speeds

    found = critical_speeds(spec.machine)["critical_speed"].values
    if found.size and spec.slowest < (1.0 + margin) * float(found[0]):
        raise QuestionError(
            f"limits.{MARGIN} and operation.speed contradict each other: balls balance above the critical speed of "
            f"{rpm_and_si(float(found[0]))} only, and {100.0 * margin:g} % above it is more than {rpm_and_si(spec.slowest)}"
        )

"""Numbers of a design from its runs, and whether it keeps the limits: shares with their 95 % intervals (Wilson 1927)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autobalancer.results.answers.studied import Studied
from autobalancer.results.shares import wilson_interval
from autobalancer.results.verdict.rule import NO_VERDICT, NOT_SETTLED, WORSE
from autobalancer.studies.design.running import Case
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import MEASURED, STALL, Spec

FINISHED = "finished"
PEAK = "peak_deflection"
Flags = NDArray[np.bool_]
KEPT, OPEN, MISSED = 1, 0, -1


def judge_runs(spec: Spec, found: Design, cases: Sequence[Case]) -> None:
    """Fill the numbers of a design.

    Of several cases the worst one counts. Of a measure: its value that the wanted share of the runs stays below, its median, the
    share of runs above the limit with its interval. of stall those of :func:`stalled`.
    """
    numbers = found.numbers
    for name in MEASURED:
        parts: list[dict[str, float]] = [
            _measure(spec, name, case) for case in cases if name == PEAK or not case.coasting
        ]
        numbers.update(max(parts, key=partial(_badness, name)))
    found.drag_warning = next(filter(None, (str(case.found.attrs.get("drag_warning", "")) for case in cases)), "")
    ups = [case.found for case in cases if not case.coasting]
    numbers |= max((_share("stall", stalled(one)) for one in ups), key=lambda part: part["stall"])
    numbers |= min((_share("balanced", balanced(one)) for one in ups), key=lambda part: part["balanced"])


def _badness(name: str, part: dict[str, float]) -> tuple[float, float]:
    return part.get(f"{name}_over", 0.0), part[name]


def _measure(spec: Spec, name: str, case: Case) -> dict[str, float]:
    values = values_of(case.found, name)
    found = {name: _level(values, spec.share), f"{name}_median": _level(values, 0.5)}
    limit = spec.limits.get(name)
    return found if limit is None else found | _share(f"{name}_over", ~(values <= limit))


def values_of(found: Studied, name: str) -> NDArray[np.float64]:
    """A measure of all runs; infinite where a run did not end or has no such number, as a ball that never settles."""
    values = np.asarray(found[name].values, np.float64) if name in found else np.full(found.sizes["member"], np.nan)
    return np.where(np.isfinite(values) & (found["outcome"].values == FINISHED), values, math.inf)


def _level(values: NDArray[np.float64], share: float) -> float:
    """The value that at least this share of the runs does not exceed."""
    ordered = np.sort(values)
    return float(ordered[min(math.ceil(share * ordered.size) - 1, ordered.size - 1)])


def stalled(found: Studied) -> Flags:
    """Which runs end stalled, or do not end.

    A ball stalls that has not settled, was stalled and never broke away, or makes the vibration worse than without balls at the
    end. The rotor stalls that stays near its lowest critical speed for more than half of the run, as with a weak motor.
    """
    restless = ~np.isfinite(values_of(found, "settling_time"))
    hung = found["stalled_time"].values > 0.0
    bad = np.isin(found["verdict"].values.astype(str), (WORSE, NO_VERDICT, NOT_SETTLED)) | ~np.isfinite(
        found["release_speed"].values
    )
    stuck = found["time_at_resonance"].values > 0.5 * float(found.attrs["duration"])
    return np.asarray((restless & hung & bad) | stuck | (found["outcome"].values != FINISHED))


def balanced(found: Studied) -> Flags:
    """Which runs end balanced."""
    return np.asarray(found["balanced"].values.astype(bool) & (found["outcome"].values == FINISHED))


def _share(name: str, which: Flags) -> dict[str, float]:
    count, total = int(which.sum()), int(which.size)
    low, high = wilson_interval(np.array([count]), total)
    return {name: count / total, f"{name}_low": float(low[0]), f"{name}_high": float(high[0])}


def verdicts(spec: Spec, found: Design) -> dict[str, int]:
    """Each limit on the runs: kept, missed, or open because so few runs cannot tell."""
    shares = {name: (f"{name}_over", 1.0 - spec.share) for name in MEASURED if name in spec.limits}
    if STALL in spec.limits:
        shares[STALL] = ("stall", spec.limits[STALL])
    return {limit: _verdict(found.numbers, share, allowed) for limit, (share, allowed) in shares.items()}


def _verdict(numbers: dict[str, float], share: str, allowed: float) -> int:
    if numbers[f"{share}_high"] <= allowed:
        return KEPT
    return MISSED if numbers[f"{share}_low"] > allowed else OPEN

"""All speed ranges in which the balanced state is stable, not only the last one."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from autobalancer.assembly.terms import Theory, ignores, weightless
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.patience import still_time
from autobalancer.shown import rpm_and_si
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.maps.balanced import POINTS, Balanced, balanced_states
from autobalancer.stability.states.described import Described, described, lower_critical_speed, why_no_state
from autobalancer.units import argument, optional_argument, unbalance_argument

MARGIN = 1e-12  # a growth rate above -MARGIN times the critical speed is not stable, but marginal

EXACT = 1e-12  # of its speed, to which an end of stability is found
MANY = 4  # critical speeds; more share no finer grid

Window = tuple[float, float]


@dataclass(frozen=True)
class StableWindows:
    """Speed ranges (rad/s, ascending) in which the balanced state is stable, within those searched.

    For more than two balls in one race a range counts if all positions that were tried are stable there. ``note`` says
    what there is to say, and always why there is no range.
    """

    windows: tuple[Window, ...]
    searched: Window
    note: str

    def __repr__(self) -> str:
        ranges = [f"stable from {rpm_and_si(low)} to {rpm_and_si(high)}" for low, high in self.windows]
        low, high = map(rpm_and_si, self.searched)
        return "\n".join(filter(None, [*(ranges or ["stable nowhere"]), f"searched from {low} to {high}", self.note]))


def stable_windows(
    machine: Machine | str | Path,
    highest: float | str,
    *,
    lowest: float | str | None = None,
    unbalance: complex | float | str | None = None,
) -> StableWindows:
    """Speed ranges in which the balanced state is stable.

    The growth rate is followed over the speed; its sign changes are found by bisection, and extreme values between the
    points at which a change of sign could be missed are refined. A window narrower than the grid (a few hundred
    speeds, dense above the critical ones) whose growth rate shows no such extreme value can be missed.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; any rotor.
    highest, lowest
        Ends of the search, rad/s; the lowest speed is by default a twentieth of the lower critical speed.
    unbalance
        kg m, complex for one off the zero mark; by default the largest of the machine over time. On rotors that tilt or bend
        it replaces the machine's unbalance if there is only one.

    Raises
    ------
    QuestionError
        If the speeds make no range, or the machine has no balls.
    """
    highest = argument("highest", highest, "rad/s")
    lowest = optional_argument("lowest", lowest, "rad/s")
    unbalance = unbalance_argument(unbalance)
    machine = balls_in_races(machine)
    p = described(weightless(machine), unbalance, float(highest))
    low = 0.05 * lower_critical_speed(p) if lowest is None else float(lowest)
    if not (0.0 < low < highest < math.inf):
        raise QuestionError(
            f"stable windows: given speeds from {low:.6g} to {highest:.6g} rad/s; "
            "they must ascend, be greater than zero, and finite"
        )
    members = balanced_states(p)
    found = [windows_of(member, low, float(highest), p) for member in members]
    common = found[0][0]
    for windows, _ in found[1:]:
        common = _overlap(common, windows)
    note = found[0][1]
    if len(members) > 1:
        note = f"all of {len(members)} positions that balance; {note}".rstrip("; ")
    note = "; ".join(filter(None, (note, ignores(machine, Theory.AT_REST))))
    return StableWindows(tuple(common), (low, float(highest)), note)


def windows_of(state: Balanced, low: float, high: float, p: Described) -> tuple[list[Window], str]:
    """Stable windows of one state and a note on them; the note is never empty where there is no window."""
    margin = MARGIN * lower_critical_speed(p)
    speeds = _grid(low, high, p, POINTS[state.route])
    rates = state.rates(speeds)
    if np.isnan(rates).all():
        return [], why_no_state(p)

    @cache
    def rate(speed: float) -> float:
        still_time()
        return float(state.rates(np.array([speed]))[0]) + margin

    speeds, rates = _with_extremes(speeds, rates + margin, rate)
    stable = rates < 0.0
    windows: list[Window] = []
    start = low if stable[0] else None
    for i in np.flatnonzero(stable[1:] != stable[:-1]):
        ends, values = (speeds[i], speeds[i + 1]), (rates[i], rates[i + 1])
        edge = _edge(rate, ends, values, getattr(state, "exists", None))
        if stable[i + 1]:
            start = edge
        else:
            assert start is not None
            windows.append((start, edge))
            start = None
    if start is not None:
        windows.append((start, high))
    missing = speeds[np.isnan(rates)]
    notes = []
    if missing.size:
        notes.append(f"no balanced state at some speeds, such as {missing[0]:.4g} rad/s")
    if not windows:
        flat = bool(np.nanmin(np.abs(rates)) < 3.0 * margin)
        notes.append("marginal at best" if flat else f"unstable from {low:.4g} to {high:.4g} rad/s")
    return windows, "; ".join(notes)


def _grid(low: float, high: float, p: Described, count: int) -> Floats:
    """Speeds that are dense just above the critical speeds, where borders lie."""
    parts = [np.geomspace(low, high, count // 3)]
    share = count // (1 + min(len(p.critical_speeds), MANY))
    for critical in p.critical_speeds:
        if low < critical < high:
            parts.append(critical * (1.0 - np.geomspace(1e-6, 1.0, count // 12)[:-1]))
            near = np.geomspace(1e-6 * critical, high - critical, share)
            parts.append(critical + near)
    grid = np.unique(np.concatenate(parts))
    return np.asarray(grid[(grid >= low) & (grid <= high)], np.float64)


def _with_extremes(speeds: Floats, rates: Floats, rate: Callable[[float], float]) -> tuple[Floats, Floats]:
    """The same, with extreme values between the points added where these may have another sign than their neighbors."""
    from scipy.optimize import minimize_scalar

    more: list[tuple[float, float]] = []
    for i in range(1, speeds.size - 1):
        left, here, right = rates[i - 1 : i + 2]
        if not np.isfinite([left, here, right]).all() or not (left < 0.0) == (here < 0.0) == (right < 0.0):
            continue
        sign = 1.0 if here > 0.0 else -1.0  # a valley of an unstable range, a peak of a stable one
        if sign * here > min(sign * left, sign * right) or abs(here) > max(abs(left - here), abs(right - here)):
            continue
        best = minimize_scalar(
            lambda w, sign=sign: sign * rate(float(w)), bounds=(speeds[i - 1], speeds[i + 1]), method="bounded"
        )
        more.append((float(best.x), sign * float(best.fun)))
    if more:
        speeds = np.concatenate([speeds, [w for w, _ in more]])
        rates = np.concatenate([rates, [r for _, r in more]])
        order = np.argsort(speeds)
        speeds, rates = speeds[order], rates[order]
    return speeds, rates


def _edge(
    rate: Callable[[float], float], ends: Window, values: tuple[float, float], exists: Callable[[float], bool] | None
) -> float:
    """Where stability ends: a root of the growth rate, or the end of the range in which the state ``exists``."""
    from scipy.optimize import brentq

    if math.isfinite(values[0]) and math.isfinite(values[1]):
        if rate(ends[0]) * rate(ends[1]) >= 0.0:
            return float(ends[0] if values[0] < 0.0 else ends[1])  # zero within rounding in all of the range
        with suppress(ValueError):  # it has no value somewhere between the ends
            return float(brentq(rate, *ends, xtol=EXACT * ends[1], rtol=1e-13))
    stable, other = ends if values[0] < 0.0 else ends[::-1]
    if exists is not None and rate(last := _halved(exists, stable, other)) < 0.0:  # much less work than the rate
        return last
    return _halved(lambda speed: rate(speed) < 0.0, stable, other)


def _halved(holds: Callable[[float], bool], inside: float, outside: float) -> float:
    """The end of the range in which something holds."""
    smallest = EXACT * max(inside, outside)
    while abs(outside - inside) > smallest:
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return float(inside)


def _overlap(one: list[Window], other: list[Window]) -> list[Window]:
    pairs = ((max(a, c), min(b, d)) for a, b in one for c, d in other)
    return [pair for pair in pairs if pair[0] < pair[1]]

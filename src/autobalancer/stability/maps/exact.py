"""Exact borders: of one state, of all positions of the balls, and the worst case over all unbalances."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.assembly.terms import Theory, ignores, weightless
from autobalancer.errors import BORDERS, QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.progress import OutOfTime, check_deadline, question
from autobalancer.results.display_units import moment_text
from autobalancer.roots import least, root
from autobalancer.stability.averaged import (
    averaged_station_growth,
    averaged_station_growths,
    explicit_averaged_border,
    refuse_without_drag,
)
from autobalancer.stability.border import Border, Borders, ignoring
from autobalancer.stability.host.stations import Plane, Stations
from autobalancer.stability.maps.balanced import (
    POINTS,
    Balanced,
    EqualAtOneStation,
    EqualBalls,
    EqualBallsAtRest,
    ForcedBalls,
    alike,
    balanced_states,
    equal_at_one_station,
    members_of,
    planar_balancer_of,
    worst_case_border,
)
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.capture import CAPTURE, RELEASE
from autobalancer.stability.states.rest_states import Described, StationState, described, why_no_state, yields
from autobalancer.tables import rpm_and_si
from autobalancer.units import argument, optional_argument, to_si, unbalance_argument

SPREADS = (0.0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0)  # |S2|/N at which the worst case is looked for


TRIED = 40  # speeds


def exact_borders(machine: Machine, p: Described) -> list[Border]:
    """*exact border*, and *exact border, best case* where the positions of the balls are a continuum."""
    members = balanced_states(p)
    result = [border_of(member, p) for member in members]
    # why there is none, in words: a reason that holds at any speed, or balls that would overlap
    # positions that exist only at some speeds do not count
    result = [one for one in result if not math.isnan(one.speed)] or result
    if p.forces is None and all(math.isinf(one.speed) for one in result):
        because = _why_never(machine, p.as_station, p.highest_searched)
        result = [one.noted(because) for one in result]
    if abs(p.unbalance) > p.greatest_resultant * (1.0 + 1e-9):
        short = f"side by side the balls can balance {moment_text(p.greatest_resultant, 4)} only: here they would have to overlap"
        result = [one.noted(short) for one in result if not math.isnan(one.speed)] or result
    if isinstance(members[0], ForcedBalls):
        result = [one.noted(members[0].left_at(one.speed)) for one in result]

    # one position, or the worst and the best of a continuum
    def rank(border: Border) -> float:
        return -math.inf if math.isnan(border.speed) else border.speed

    low, high = min(result, key=rank), max(result, key=rank)
    if len(members) == 1:
        return result
    best = replace(low, name="exact border, best case")
    if math.isnan(high.speed):  # nowhere is there any of them
        return [high, best]
    spreads = ""
    if isinstance(members[0], EqualBalls):
        fast = np.array([40.0 * members[0].balancer.critical_speed])
        ends = [float(m.spreads(fast)[0]) for m in (members[0], members[-1]) if isinstance(m, EqualBalls)]
        spreads = f"|S2| from {ends[0]:.3g} to {ends[1]:.3g}; "
    speed = "none" if math.isnan(low.speed) else "never" if math.isinf(low.speed) else f"{low.speed:.5g} rad/s"
    which = f"worst of {len(result)} positions of the balls, {spreads}best {speed}"
    if math.isinf(high.speed) and math.isfinite(low.speed):
        which += ", worst never"
    return [replace(high, best=low.speed).noted(which), best.noted("best of these positions")]


def _why_never(machine: Machine, st: Stations, highest: float) -> str:
    """A reason that holds at all speeds above the lowest critical one up to ``highest``, rad/s; empty if none is known."""
    for speed in np.geomspace(1.02 * st.scale_speed, highest, TRIED):
        if not yields(st, float(speed)):
            return ""
    shape = ""
    if isinstance(machine.rotor, RigidRotor) and machine.rotor.polar_inertia > machine.rotor.transverse_inertia:
        shape = (
            f"the rotor is disk-like, J_p = {machine.rotor.polar_inertia:.4g} > J_t = "
            f"{machine.rotor.transverse_inertia:.4g} kg m^2, and has no conical critical speed to run above: "
        )
    return (
        f"{shape}at every speed the rotor yields towards its load in one motion, so the balls make that motion larger"
    )


def border_of(state: Balanced, p: Described, highest: float | None = None, lowest: float | None = None) -> Border:
    """The border of a state: the lowest speed from which on it is stable up to the highest one that is searched.

    By default from the lower critical speed to the highest one that is searched.
    """
    critical = p.scale_speed if lowest is None else lowest
    high = p.highest_searched if highest is None else highest
    windows, note = windows_of(state, critical, high, p)
    undamped = [
        name for name, values in (("rotor", p.damping), ("balls", p.drag)) if not np.all(np.asarray(values) > 0.0)
    ]
    if undamped and not windows:
        note = f"{note}; {' and '.join(undamped)} without damping"
    if not windows and note.startswith(NO_STATE):
        return Border("exact border", math.nan, note)
    if not windows or windows[-1][1] < high:
        tail = f"{'unstable beyond' if windows else 'none'} up to {high:.4g} rad/s"
        return Border("exact border", math.inf, note, windows=tuple(windows)).noted(tail)
    below = f"stable also {', '.join(f'{a:.4g} to {b:.4g} rad/s' for a, b in windows[:-1])}" if windows[1:] else ""
    return Border("exact border", windows[-1][0], note, windows=tuple(windows[:-1])).noted(below)


def worst_case_of(p: Described) -> Border:
    """*exact border, worst case* of any rotor."""
    return worst_case(p) if isinstance(p, Plane) else worst_case_at_one_station(p)


def worst_case(p: Plane) -> Border:
    """*exact border, worst case*: the highest one for any unbalance from zero to capability, equal balls only.

    Over these unbalances |S2| takes all values from 0 to N. Zero, where the two ball modes have one frequency, is the worst for a
    well damped rotor and has an explicit border on isotropic supports; where the rotor is damped lightly balls in line may be.
    """
    name = "exact border, worst case"
    if not alike(p):
        return Border(name, math.nan, "computed for equal balls only; see the exact border", False)
    if np.any(p.offset != 0.0):
        return Border(name, math.nan, "computed for races on the axis only; see the exact border", False)
    # on orthotropic supports no closed form is known: several |S2| are tried
    balancer = planar_balancer_of(p)
    if not p.isotropic:
        return _worst_spread([EqualBallsAtRest(p, spread=share * balancer.count) for share in SPREADS], p)
    if balancer.damping == 0.0 or balancer.drag == 0.0:
        return Border(name, math.inf, "the rotor or its balls are undamped")
    # balls at right angles in closed form, then whether any other |S2| is worse
    speed, spread = worst_case_border(balancer), 0.0
    if math.isinf(speed):
        return Border(name, speed, "of balls at right angles (|S2| = 0)")
    for share in SPREADS[1:]:
        other = border_of(EqualBalls(p, spread=share * balancer.count), p).speed
        if other > speed * (1.0 + 1e-9):
            speed, spread = other, share
    where = (
        "for balls at right angles"
        if spread == 0.0
        else "for balls in line"
        if spread == 1.0
        else f"for |S2|/N = {spread:g}"
    )
    note = f"{where} (|S2| = {spread * balancer.count:g})"
    return Border(name, speed, f"none up to {p.highest_searched:.4g} rad/s, {note}" if math.isinf(speed) else note)


def worst_case_at_one_station(st: Stations) -> Border:
    """*exact border, worst case* where the rotor tilts or bends: equal balls at one station, |S2| from 0 to N."""
    name = "exact border, worst case"
    if not equal_at_one_station(st):
        which = "equal balls at one station only, races on the axis, isotropic supports"
        if equal_at_one_station(replace(st, slopes=None, forces=None)):
            which = (
                "balls that feel the deflection of their race only"
                if st.forces is None
                else "balls without forces only"
            )
        return Border(name, math.nan, f"computed for {which}; see the exact border", False)
    return _worst_spread([EqualAtOneStation(st, spread=share * st.moment.size) for share in SPREADS], st)


def _worst_spread(members: Sequence[Balanced], p: Described) -> Border:
    """The worst of members for each of ``SPREADS``."""
    items = [(border_of(member, p), share) for member, share in zip(members, SPREADS, strict=True)]
    border, share = max(items, key=lambda one: one[0].speed)
    if not math.isinf(border.speed):  # ranges below it are those of other borders
        border = replace(border, note="", windows=())
    return replace(border, name="exact border, worst case").noted(
        f"for |S2|/N = {share:g}, of {len(SPREADS)} that were tried"
    )


# All speed ranges in which the balanced state is stable, not only the last one.


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
    low = 0.05 * p.scale_speed if lowest is None else float(lowest)
    if not (0.0 < low < highest < math.inf):
        raise QuestionError(
            f"stable windows: given speeds from {low:.6g} to {highest:.6g} rad/s; "
            "they must ascend, be greater than zero, and finite"
        )
    members = balanced_states(p)
    items = [windows_of(member, low, float(highest), p) for member in members]
    common = items[0][0]
    for windows, _ in items[1:]:
        overlaps = [(max(a, c), min(b, d)) for a, b in common for c, d in windows]
        common = [(start, end) for start, end in overlaps if start < end]
    note = items[0][1]
    if len(members) > 1:
        note = f"all of {len(members)} positions that balance; {note}".rstrip("; ")
    note = "; ".join(filter(None, (note, ignores(machine, Theory.AT_REST))))
    return StableWindows(tuple(common), (low, float(highest)), note)


def windows_of(state: Balanced, low: float, high: float, p: Described) -> tuple[list[Window], str]:
    """Stable windows of one state and a note on them; the note is never empty where there is no window."""
    # growth rates over a grid that is dense above the critical speeds
    margin = MARGIN * p.scale_speed
    speeds = _grid(low, high, p, POINTS[state.route])
    rates = state.rates(speeds)
    if np.isnan(rates).all():
        return [], why_no_state(p)

    @cache
    def rate(speed: float) -> float:
        check_deadline()
        return float(state.rates(np.array([speed]))[0]) + margin

    # a pair of borders between two points shows as an extreme value; such points are added
    speeds, rates = _with_extremes(speeds, rates + margin, rate)
    # windows from border to border, each found by bisection
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
    # what the note says
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
    more: list[tuple[float, float]] = []
    left, here, right = rates[:-2], rates[1:-1], rates[2:]
    signs = np.where(here > 0.0, 1.0, -1.0)  # a valley of an unstable range, a peak of a stable one
    with np.errstate(invalid="ignore"):
        finite = np.isfinite(left) & np.isfinite(here) & np.isfinite(right)
        alike = ((left < 0.0) == (here < 0.0)) & ((here < 0.0) == (right < 0.0))
        nearest = signs * here <= np.minimum(signs * left, signs * right)
        crossing = np.abs(here) <= np.maximum(
            np.abs(left - here), np.abs(right - here)
        )  # not farther from zero than that
    for i in 1 + np.flatnonzero(finite & alike & nearest & crossing):
        sign = float(signs[i - 1])

        def signed(speed: float, sign: float = sign) -> float:
            return sign * rate(speed)

        speed, value = least(signed, speeds[i - 1], speeds[i + 1])
        more.append((speed, sign * value))
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
    if math.isfinite(values[0]) and math.isfinite(values[1]):
        if rate(ends[0]) * rate(ends[1]) >= 0.0:
            return float(ends[0] if values[0] < 0.0 else ends[1])  # zero within rounding in all of the range
        with suppress(ValueError):  # it has no value somewhere between the ends
            return root(rate, *ends, xtol=EXACT * ends[1], rtol=1e-13)
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


# The border speeds, each under its own name.
#
# *averaged border*: where the averaged equations become stable (Spannan 2021, 4.74). *Exact border*: where the
# balanced state of the full equations really does. *Release speed*: where balls that stall at the critical speed
# during a slow run-up break away (Ryzhik et al. 2001; Spannan 2021, 4.73), and *capture speed*, the other end of its
# torque balance.


# The averaged border of any machine: of planar rotors in closed form where there is one, of others over the speed.


AVERAGED = "averaged border"
AVERAGED_WORST_CASE = "averaged border, worst case"
AVERAGED_SPREADS = (0.0, 0.5, 1.0)  # between the least and the greatest |g2| at which the worst case is looked for


def averaged_border(
    machine: Machine | str | Path,
    unbalance: complex | float | str | None = None,
    *,
    worst_case: bool = False,
    searched: tuple[float, float] | None = None,
) -> Border:
    """Averaged border from the averaged eigenvalue problem; on planar rotors Spannan (2021), (4.69), by root finding.

    Parameters
    ----------
    machine
        A machine or the path of its file; any rotor.
    unbalance
        kg m, or a text such as ``"594 g*mm"``; by default that of the machine. On rotors that tilt or bend it replaces the
        machine's unbalance if there is only one.
    worst_case
        Take the ball positions with the highest border instead of those that balance the unbalance. Needs races on the
        axis of the rotor, in one plane.
    searched
        Speeds, rad/s: the border is the lowest speed in this range from which on the state is stable up to its end. By
        default from the lowest critical speed to 40 times the critical speed, or to the end of the tables of the supports.

    Returns
    -------
    Border
        Infinite if the state is unstable at the end of the range, nan if there is no balanced state.

    Raises
    ------
    QuestionError
        If a ball has no drag or forces act on it, or the worst case is asked of an eccentric race or several planes.
    """
    machine = balls_in_races(machine)
    p = described(machine, unbalance_argument(unbalance), None if searched is None else searched[1])
    if p.forces is not None:
        raise QuestionError(
            "averaged border: the averaged theory does not know forces on the balls; ask borders for the exact border"
        )
    return ignoring(machine, averaged_border_of(p, worst_case, searched), Theory.AVERAGED)


def averaged_of(p: Described) -> Border:
    """*averaged border* as :func:`autobalancer.stability.borders` has it.

    With races on the axis in one plane that of the worst case over the unbalance: of planar rotors by the closed form, (4.74)
    generalized to any balls and to orthotropic supports, of others by root finding. Else that at this unbalance.
    """
    if p.forces is not None:
        return Border(AVERAGED, math.nan, "computed without forces on the balls only; see the exact border", False)
    if p.moment.size == 1:
        return Border(AVERAGED, math.nan, ONE_BALL)
    if not (p.drag > 0.0).all():
        return Border(AVERAGED, math.inf, "a ball has no drag")
    if max(p.damping) == 0.0:
        return Border(AVERAGED, math.inf, "the rotor has no damping")
    if isinstance(p, Plane) and p.one_centric:
        border = explicit_averaged_border(p)
    else:
        border = averaged_border_of(p, worst_case=p.one_centric)
    return replace(border, name=AVERAGED)


def averaged_border_of(p: Described, worst_case: bool, searched: tuple[float, float] | None = None) -> Border:
    """Averaged border by root finding, (4.69) of Spannan (2021) for any rotor."""
    st = p.as_station
    refuse_without_drag(st.drag)
    if worst_case and not st.one_centric:
        raise QuestionError(
            "averaged border: the worst case over the unbalance needs races on the axis of the rotor, in one plane; leave out "
            "worst_case for the border at the unbalance of the machine"
        )
    st = st if st.slopes is None else replace(st, slopes=None)
    low, high = searched or (st.scale_speed, p.highest_searched)
    members = _any_unbalance(st) if worst_case else members_of(st, averaged_station_growth)
    items = [border_of(member, st, high, low) for member in members]
    items = [item for item in items if not math.isnan(item.speed)] or items[:1]
    border = max(items, key=lambda one: one.speed)
    where = "worst case over the unbalance" if worst_case else "at this unbalance"
    if not worst_case and len(items) > 1:
        where += f", worst of {len(items)} positions of the balls"
    border = replace(border, name=AVERAGED_WORST_CASE if worst_case else AVERAGED)
    return border.noted(f"{where}, from the averaged eigenvalue problem")


def _any_unbalance(st: Stations) -> list[Balanced]:
    """Two equal balls with the same g = sum s^2/beta, and |g2| from the least that the balls can make up to g."""
    weight: Floats = st.moment**2 / st.drag
    g = float(weight.sum())
    least = max(0.0, 2.0 * float(weight.max()) / g - 1.0)
    two = {name: getattr(st, name)[[0, 0]] for name in ("ball_mass", "inertia", "station", "race", "offset")}
    alike = replace(st, moment=np.full(2, math.sqrt(0.5 * g)), drag=np.ones(2), **two)
    return [_AnyUnbalance(alike, least + (1.0 - least) * share) for share in AVERAGED_SPREADS]


@dataclass(frozen=True)
class _AnyUnbalance:
    """Two equal balls in a race on the axis with this |g2|/g."""

    stations: Stations
    share: float
    route: str = "eigenvalues"

    def rates(self, speeds: Floats) -> Floats:
        """Averaged growth rates, 1/s."""
        angle = 0.5 * math.acos(min(self.share, 1.0))
        state = StationState("balanced", np.array([angle, -angle]), np.zeros(1, np.complex128), 0, 0)
        return averaged_station_growths(self.stations, speeds, state)


NO_STATE = "no balanced state"  # begins the note of an exact border where there is none
SMALLER = "of unbalances that the balls can balance, not of this one"
ONE_BALL = "one ball alone can balance one unbalance only"
BUDGET = 10.0  # s of computing for each question where nobody asked for it
NOT_FOUND = "not found in {:g} s of computing; {} looks as long as it takes"
WORST_CASE = "exact border, worst case"
NAMES = (
    AVERAGED,
    WORST_CASE,
    "exact border",
    "exact border, best case",
    "release speed",
    "capture speed",
)


def borders(
    machine: Machine | str | Path,
    unbalance: complex | float | str | None = None,
    *,
    only: Sequence[str] = (),
    up_to: float | str | None = None,
) -> Borders:
    """All border speeds of a machine.

    Parameters
    ----------
    machine
        A machine or the path of a machine file. On a horizontal axis its borders are those without gravity, as their notes say.
    unbalance
        kg m, complex for one off the zero mark; by default the largest of the machine over time.
    only
        Names of the borders that are wanted, such as ``("release speed", "capture speed")``, which are found much faster than
        the exact ones; by default all.
    up_to
        Rotor speed, rad/s or a string with a unit: release and capture speed are those of the resonances that a run-up to it
        passes. By default the highest speed that the drive prescribes if that is above a critical speed, else all count.
        Planar rotors have two resonances at most, and both count.

    Returns
    -------
    tuple of Border
        *averaged border*; *exact border, worst case* over all unbalances; *exact border* at this unbalance; for more
        than two balls also *exact border, best case*, since their positions matter and the exact border is that of the
        worst ones, with that of the best as its ``best``; *release speed* and, where balls stall and are released, *capture
        speed*. An empty note means that there is nothing to add. An infinite speed means never; for nan the note
        gives the reason.

    Raises
    ------
    QuestionError
        If the machine has no balls, the unbalance is no number, or a name in ``only`` is unknown.
    """
    unbalance = unbalance_argument(unbalance)
    machine = balls_in_races(machine)
    top = None if up_to is None else positive_speed(up_to, "up_to")
    return Borders(smaller_noted(borders_of(machine, described(weightless(machine), unbalance), only, top)))


def smaller_noted(borders: Sequence[Border]) -> tuple[Border, ...]:
    """Borders over all unbalances with a note where the balls cannot balance the one at hand."""
    if not any(border.name == "exact border" and border.note.startswith(f"{NO_STATE}:") for border in borders):
        return tuple(borders)
    of_any = [border.name in (AVERAGED, WORST_CASE) and not math.isnan(border.speed) for border in borders]
    return tuple(border.noted(SMALLER) if noted else border for border, noted in zip(borders, of_any, strict=True))


def positive_speed(speed: float | str, name: str = "speed") -> float:
    """rad/s, above zero."""
    value = float(to_si(speed, "rad/s"))
    if not value > 0.0:
        raise QuestionError(f"{name}: given {speed!r}; must be greater than zero")
    return value


def borders_of(
    machine: Machine,
    p: Described,
    only: Sequence[str] = (),
    up_to: float | None = None,
    seconds: float = math.inf,
    say: Callable[[str], None] | None = None,
) -> tuple[Border, ...]:
    """The border speeds of a machine with its numbers, whose unbalance counts; all, or ``only`` some by their names.

    Those that take more than some ``seconds`` of computing are left out, and say so; ``say`` is told what takes over one.
    """
    unknown = [name for name in only if name not in NAMES]
    if unknown:
        raise QuestionError(f"only: given {unknown[0]!r}; must be among {', '.join(repr(name) for name in NAMES)}")
    if p.moment.size == 0:
        raise QuestionError("border speeds: the machine has no balls")
    wanted = set(only or NAMES)
    asked: list[tuple[set[str], Callable[[], Sequence[Border]]]] = [
        ({AVERAGED}, lambda: [averaged_of(p)]),
        ({WORST_CASE}, lambda: [Border(WORST_CASE, math.nan, ONE_BALL) if p.moment.size == 1 else worst_case_of(p)]),
        ({"exact border", "exact border, best case"}, lambda: exact_borders(machine, p)),
        ({RELEASE, CAPTURE}, lambda: release_of(machine, p, capture=CAPTURE in wanted, up_to=up_to)),
    ]
    borders: list[Border] = []
    for names, answer in asked:
        which = sorted(names & wanted, key=NAMES.index)
        if not which:
            continue
        try:
            with question(f"the {' and '.join(which)}", seconds, say):
                borders += answer()
        except OutOfTime:
            note = NOT_FOUND.format(seconds, BORDERS)
            borders += [Border(name, math.nan, note, False) for name in which]
    return with_ignored_terms(machine, [border for border in borders if border.name in wanted])


def theory_of(border: str) -> Theory:
    """Which theory a border is of, by its name."""
    return {RELEASE: Theory.STALLED, CAPTURE: Theory.STALLED, AVERAGED: Theory.AVERAGED}.get(border, Theory.AT_REST)


def with_ignored_terms(machine: Machine, borders: Sequence[Border]) -> tuple[Border, ...]:
    """Borders whose notes name what the theory of each leaves out of this machine."""
    return tuple(ignoring(machine, border, theory_of(border.name)) for border in borders)

"""Bifurcation diagrams: all connected steady states and periodic motions along one parameter."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.assembly.terms import Theory
from autobalancer.errors import QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer
from autobalancer.results.labels import labeled
from autobalancer.stability.bifurcations import (
    Curve,
    FoldCurve,
    HopfCurve,
    NoConvergence,
    Point,
    Special,
    Steps,
    at_parameter,
    follow,
    locate,
)
from autobalancer.stability.border import attributes
from autobalancer.stability.curve_explorer import Branch, Branches, Explorer, Progress
from autobalancer.stability.host.vector_field import Cycle, Equations
from autobalancer.stability.periodic_orbits import Row
from autobalancer.stability.stalled_orbits import partly_stalled_orbits, stalled_orbits
from autobalancer.stability.states.linearized import settled_on
from autobalancer.stability.states.rest_states import StationState, state_vector, states_of, without_exchanges
from autobalancer.stability.steady_curves import Family, Range, Steady, bundled_angles, coincident, kinds
from autobalancer.units import optional_argument

State = Literal["balanced", "mixed", "coincident", "in line", "spread", "stalled", "partly stalled", "all"]
STATES = get_args(State)
Found = TypeVar("Found")
SMOOTH = 1e-9  # of the highest harmonic of a state, in the units of its components
MOST_HARMONICS = 65
STARTS = 13  # places in the range at which a stalled orbit is looked for

TWO_FREQUENCIES = (
    "where supports differ along x and y, balls that move in the rotor have two frequencies, their own and twice the speed, and "
    "are not followed; simulate the machine, or ask basin"
)
MOTIONS = ("stalled", "partly stalled")
SAME_WHIRL = 0.02  # of the speed: stalled orbits of a group nearer to each other are of one branch


def branches(
    machine: Machine | str | Path,
    parameter: str,
    start: float | str,
    end: float | str | None = None,
    *,
    speed: float | str | None = None,
    from_state: State = "balanced",
    switch: bool = True,
    orbits: bool = True,
    largest_step: float = 0.03,
    intervals: int = 30,
    limit: int = 40,
    progress: Progress | None = None,
) -> Branches:
    """Follow steady states and periodic motions of a machine at constant speed along a parameter; any rotor.

    On anisotropic supports steady states repeat with every half turn: their stability is that of multipliers, and a Hopf point
    is where the balls begin to swing with a frequency of their own. Motions with such a second frequency are not followed.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; any rotor, no gravity across its axis.
    parameter
        ``speed``, ``unbalance``, ``drag``, ``viscosity``, ``ball_mass``, ``ball_diameter``, ``damping``, ``stiffness``, or a
        path like ``"balancers[1].races[1].eccentricity"``.
    start, end
        The range, SI or with a unit; ``end`` may be the lower one. Or both as one text: ``"50:110 rad/s"``.
    speed
        Rotor speed in rad/s where it is not the parameter; by default that of a machine with a constant prescribed speed.
    from_state
        Steady states at ``start`` from which to begin; *stalled* for balls stalled at the critical speed, wherever
        in the range they stall, *partly stalled* for those of one race (or one kind) while all others stay in the rotor;
        *all* for all of these.
    switch
        Also follow all branches that start from the ones found.
    orbits
        Follow the periodic motions that begin at Hopf points; on anisotropic supports none are followed.
    largest_step
        Of the parameter as a share of its range, and of the ball angles in rad; for orbits five times that.
    intervals
        Of the mesh over a period, four collocation points each.
    limit
        Greatest number of branches.
    progress
        Called with (number of the branch, place in the range between 0 and 1).

    Returns
    -------
    xarray.Dataset
        Along ``point``: ``branch``, the parameter, ``kind``, ``name``, ``verdict``, ``unstable_directions``,
        ``growth_rate``, least and greatest ``deflection`` and ``ball_angle_in_rotor``, mean ``ball_speed_in_space``,
        ``period``; on anisotropic supports over half a turn of the rotor, so that the greatest and least deflection are
        the half axes of the orbit where the balls do not swing. Along ``special``: ``special_type`` (fold, Hopf,
        pitchfork, branch point, period doubling, torus, infinite period), where, ``lyapunov_coefficient`` and
        ``criticality`` of Hopf points.

    Raises
    ------
    QuestionError
        For an unknown parameter or state, an empty range, gravity across the axis, no balls, stalled balls on anisotropic
        supports.
    """
    speed = optional_argument("speed", speed, "rad/s")
    machine = balls_in_races(machine)
    one_of("from_state", from_state, *STATES)
    if not 1e-4 <= largest_step <= 0.5:
        raise QuestionError(f"largest_step: given {largest_step!r}; must be between 1e-4 and 0.5, 0.03 is a good start")
    if not 4 <= intervals <= 400:
        raise QuestionError(f"intervals: given {intervals!r}; must be between 4 and 400, 30 is a good start")
    # the machine at each value of the parameter, over the range
    family = Family(machine, [parameter], speed)
    if family.count > 1 and from_state in MOTIONS:
        raise QuestionError(f"from_state: given {from_state!r}; {TWO_FREQUENCIES}")
    first, last = family.ends(0, start, end)
    if first == last:
        raise QuestionError(f"{parameter}: the range begins and ends at {first:.6g}; give two different values")
    if parameter in ("speed", "stiffness", "ball_mass", "ball_diameter") and not min(first, last) > 0.0:
        raise QuestionError(f"{parameter}: given {min(first, last):.6g}; must be greater than zero")
    family.reduce(max(first, last) if parameter == "speed" else family(first).speed)
    # the same balls everywhere; at an inner value, too, where ends might be special
    hosts = [family(value).host for value in (first, last, 0.63 * first + 0.37 * last)]
    if hosts[0].moment.size == 0:
        raise QuestionError("branches: the machine has no balls")
    if len({host.moment.size for host in hosts}) > 1:
        raise QuestionError(f"{parameter}: the number of balls must not change along the range")
    kind, steps = kinds(hosts), Steps(0.3 * largest_step, 1e-7, largest_step)

    def steady() -> tuple[Explorer, float]:
        explorer = Explorer(Range(family, first, last), kind, steps, intervals, limit, progress)
        if from_state not in MOTIONS:
            begin_all(explorer, from_state, parameter)
            if switch:
                explorer.switch()
        return explorer, explorer.tail()

    # states at rest in the rotor first, then what branches from them: orbits, stalled and partly stalled balls
    explorer = with_enough_harmonics(family, steady)
    if family.count == 1:
        span = explorer.span
        if orbits:
            explorer.orbits()
        if from_state in ("stalled", "all"):
            _stalled(explorer, span, kind, intervals, from_state)
        if from_state in ("partly stalled", "all"):
            _partly_stalled(explorer, span, kind, intervals, from_state)
    about = attributes(machine, f"Branches of {machine.name}", Theory.AT_REST) | {
        "parameter": parameter,
        "theory": "pseudo-arclength continuation of the full equations",
    }
    if family.count > 1:
        about |= {"theory": f"{about['theory']} over half a turn", "not_followed": TWO_FREQUENCIES}
    if "speed" not in parameter:
        about["speed"] = family(first).speed
    return Branches.of(_branch_dataset(explorer, family.attributes(0), about))


def _branch_dataset(explorer: Explorer, parameter: dict[str, str], attributes: dict[str, Any]) -> xr.Dataset:
    """Flat table of all points, branch after branch, and of all special points."""
    rows = [row for branch in explorer.branches for row in branch.rows]
    number = [i for i, branch in enumerate(explorer.branches, 1) for _ in branch.rows]
    kind = [branch.kind for branch in explorer.branches for _ in branch.rows]
    balls, names = len(explorer.kind), explorer.span.whole(0.0).host.names
    result, along = explorer.specials, tuple(parameter.values())[:2]
    marks = [f.row for f in result]
    lyapunov = [f.special.lyapunov for f in result]

    def counts(values: list[int]) -> np.ndarray:
        return np.array(values, np.int64)

    def words(values: list[str]) -> np.ndarray:
        return np.asarray(values, np.str_)

    at, mark = "point", "special"
    data: dict[str, tuple[Any, ...]] = {
        "branch": (at, counts(number), "number of the branch, counted from 1"),
        "parameter": (at, [row.value for row in rows], *along),
        "kind": (at, words(kind), "equilibrium or orbit"),
        "name": (at, words([row.name for row in rows]), "name of the state or motion"),
        "verdict": (at, words([row.verdict for row in rows]), "stable, marginal or unstable"),
        "unstable_directions": (at, counts([row.unstable for row in rows]), "unstable directions"),
        "growth_rate": (at, [row.growth for row in rows], "growth rate of the leading disturbance", "1/s"),
        **_motion(rows, balls, len(names), at, ""),
        "special_type": (mark, words([f.special.kind for f in result]), "what happens there"),
        "special_branch": (mark, counts([f.branch + 1 for f in result]), "on which branch"),
        "special_parameter": (mark, [row.value for row in marks], *along),
        "special_frequency": (mark, [f.special.frequency for f in result], "frequency of the motion", "rad/s"),
        "lyapunov_coefficient": (mark, lyapunov, "first Lyapunov coefficient for ball angles in rad", "1"),
        "criticality": (mark, words([_criticality(value) for value in lyapunov]), "super- or subcritical Hopf point"),
        "special_unstable_directions": (
            mark,
            counts([row.unstable for row in marks]),
            "unstable directions there; 0 where stability begins or ends",
        ),
        **_motion(marks, balls, len(names), mark, "special_"),
    }
    ends = {"branch_ends": [branch.ended for branch in explorer.branches]}
    table = labeled(data, None, attributes | ends).assign_coords(ball=np.arange(1, balls + 1))
    for name in ("parameter", "special_parameter"):
        table[name].attrs.update(parameter)
    return table.assign_coords(station=list(names)) if len(names) > 1 else table


def _motion(rows: list[Row], balls: int, stations: int, dim: str, prefix: str) -> dict[str, Any]:
    def by_ball(values: list[Any]) -> Any:
        return np.array(values, np.float64).reshape(len(rows), balls)

    shape, most = (dim, "ball"), ", greatest of all stations" if stations > 1 else ""
    by_station = {
        f"{prefix}station_deflection_{which}": (
            (dim, "station"),
            np.array([row.stations[side] for row in rows], np.float64).reshape(len(rows), stations),
            f"{word} deflection of a station",
            "m",
        )
        for side, (which, word) in enumerate((("min", "least"), ("max", "greatest")))
        if stations > 1
    }
    low, high, speed = (by_ball([getattr(row, key) for row in rows]) for key in ("low", "high", "ball_speed"))
    turning = "; nan where the ball turns round and round"
    return {
        f"{prefix}deflection_min": (dim, [row.deflection[0] for row in rows], f"least deflection{most}", "m"),
        f"{prefix}deflection_max": (dim, [row.deflection[1] for row in rows], f"greatest deflection{most}", "m"),
        **by_station,
        f"{prefix}ball_angle_in_rotor_min": (shape, low, f"least ball angle in the rotor{turning}", "rad"),
        f"{prefix}ball_angle_in_rotor_max": (shape, high, f"greatest ball angle in the rotor{turning}", "rad"),
        f"{prefix}ball_speed_in_space": (shape, speed, "mean ball speed in space", "rad/s"),
        f"{prefix}period": (dim, [row.period for row in rows], "period in the frame of the rotor", "s"),
    }


def _criticality(lyapunov: float) -> str:
    return "" if math.isnan(lyapunov) else "supercritical" if lyapunov < 0.0 else "subcritical"


def with_enough_harmonics(family: Family, explore: Callable[[], tuple[Found, float]]) -> Found:
    """What ``explore`` finds with as many harmonics as its states need; it also says how large the highest one is.

    Raises
    ------
    QuestionError
        If the balls do not swing smoothly somewhere.
    """
    while True:
        result, tail = explore()
        if tail <= SMOOTH:
            return result
        if 2 * family.count - 1 > MOST_HARMONICS:
            raise QuestionError(
                f"branches: somewhere in the range balls swing so much that {family.count} harmonics do not describe it; "
                "take a narrower range, or simulate the machine there"
            )
        family.refine(2 * family.count - 1)


def begin_all(explorer: Explorer, from_state: str, parameter: str) -> None:
    """Follow the steady states of one name, or all, from the begin of the range."""
    span, kind = explorer.span, explorer.kind
    field, lost = span.whole(0.0), []
    for state in (states := starts_of(field, from_state, parameter, span.value(0.0))):
        try:
            begin = begin_at(field, state, kind)
        except QuestionError as problem:  # balls swing on anisotropic supports, and may not find it near there
            lost.append(problem)
            continue
        explorer.steady_from(coincident(begin[field.rotor : field.rotor + field.balls], kind), begin)
    if len(lost) == len(states):
        raise lost[0]


def begin_at(field: Equations, state: StationState, kind: list[tuple[float, ...]]) -> Floats:
    """The state vector from which a steady state is followed: of a continuum the member in two bundles."""
    angles = bundled_angles(field, state, kind)
    if isinstance(field, Cycle):
        return settled_on(field, angles, state.freedom)
    return state_vector(field.host, field.speed, angles)


def starts_of(field: Equations, wanted: str, parameter: str, value: float) -> list[StationState]:
    """The steady states of one name, or all."""
    states = without_exchanges(field.host, states_of(field.host, field.speed))
    chosen = [state for state in states if wanted in (state.name, "all")]
    if not chosen:
        there = ", ".join(sorted({state.name for state in states}))
        raise QuestionError(
            f"from_state: no state {wanted!r} at {parameter} = {value:.6g}; there is {there}. take one of these"
        )
    return chosen


def _stalled(explorer: Explorer, span: Range, kind: list[tuple[float, ...]], intervals: int, wanted: str) -> None:
    groups = coincident(np.zeros(len(kind)), kind)
    # speeds at which balls hang begin at the critical speed, where the drag just overcomes them: try the middle first
    shares = sorted(np.linspace(0.0, 1.0, STARTS), key=lambda share: abs(share - 0.5))
    before = len(explorer.branches)
    for share in shares:
        for problem, u in stalled_orbits(span, groups, float(share), intervals):
            explorer.orbit_from(problem, u)
        if len(explorer.branches) > before:
            return
    if wanted == "stalled":
        critical = span.field(0.0, groups).host.scale_speed
        raise QuestionError(
            f"from_state: balls stall at no resonance from {critical:.5g} rad/s on, at none of {STARTS} values in the range; "
            "they catch up with the rotor or settle elsewhere. Widen the range, or look for them with simulate()"
        )


def _partly_stalled(
    explorer: Explorer, span: Range, kind: list[tuple[float, ...]], intervals: int, wanted: str
) -> None:
    groups = coincident(np.zeros(len(kind)), kind)
    result = False
    for hung in groups if len(groups) > 1 else ():
        begun: list[int] = []
        for share in sorted(np.linspace(0.0, 1.0, STARTS).tolist(), key=lambda share: abs(share - 0.5)):
            for problem, u in partly_stalled_orbits(span, kind, hung, share, intervals):
                speed = span.whole(share).speed
                whirl = speed - 2.0 * np.pi / problem.period(u)
                if any(_passes(explorer.branches[number], hung[0], share, whirl, speed) for number in begun):
                    continue
                explorer.orbit_from(problem, u)
                begun.append(len(explorer.branches) - 1)
        result = result or bool(begun)
    if wanted == "partly stalled" and not result:
        raise QuestionError(
            f"from_state: at none of {STARTS} values in the range the balls of one race hang at a resonance while all others "
            "stay in the rotor; they may drift around it, which is no periodic motion. Widen the range, take a greater "
            "unbalance or less drag, or look at such motions with simulate()"
        )


def _passes(branch: Branch, ball: int, share: float, whirl: float, speed: float) -> bool:
    """Whether a branch of orbits has one at this share on which the ball has nearly this speed in space."""
    for a, b in zip(branch.rows, branch.rows[1:], strict=False):
        low, high = sorted((a.share, b.share))
        if low <= share <= high:
            part = 0.5 if high - low < 1e-12 else (share - a.share) / (b.share - a.share)
            there = a.ball_speed[ball] + part * (b.ball_speed[ball] - a.ball_speed[ball])
            if abs(there - whirl) < SAME_WHIRL * speed:
                return True
    return False


# Stability borders and folds over two parameters, followed exactly.


NEAR = 5e-3  # of both ranges: a special point so near to a curve is on it


def bifurcation_curves(
    machine: Machine | str | Path,
    kind: Literal["Hopf", "fold"],
    parameter: str,
    start: float | str,
    end: float | str | None = None,
    second: str = "",
    second_start: float | str = "",
    second_end: float | str | None = None,
    *,
    speed: float | str | None = None,
    from_state: Literal["balanced", "coincident", "in line", "spread"] = "balanced",
    largest_step: float = 0.03,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Curves of Hopf points or folds of steady states in the plane of two parameters.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; any rotor, no gravity across its axis.
    kind
        *Hopf*: where a state becomes unstable and its balls begin to oscillate. *fold*: where two states meet and vanish.
    parameter, start, end
        The first points of the curves are searched along this parameter, at the machine's own value of ``second``.
    second, second_start, second_end
        The other parameter; if the machine's own value is outside, ``second_start`` is taken instead.
    speed, from_state
        As for :func:`branches`.
    largest_step
        Of the parameters, as a share of their ranges.
    progress
        Called with (number of the curve, place in the second range between 0 and 1).

    Returns
    -------
    xarray.Dataset
        Along ``point``: ``curve``, the two parameters, for Hopf curves ``frequency`` (rad/s), ``lyapunov_coefficient``
        and ``criticality``. Along ``special``: *Bautin* points, at which the criticality changes, and *cusps*.

    Raises
    ------
    QuestionError
        If there is no such point along the first parameter, or a parameter or range is not possible.
    """
    speed = optional_argument("speed", speed, "rad/s")
    machine = balls_in_races(machine)
    one_of("kind", kind, "Hopf", "fold")
    if parameter == second:
        raise QuestionError(f"second: given {second!r} twice; take two different parameters")
    family = Family(machine, [parameter, second], speed)
    first, last = family.ends(0, start, end)
    ends = family.ends(1, second_start, second_end)
    if first == last or ends[0] == ends[1]:
        raise QuestionError(f"{parameter}, {second}: a range is empty; give two different ends")
    now = family.now(1)
    now = now if min(ends) <= now <= max(ends) else ends[0]
    # modes up to the greatest speed that occurs
    at_speed = [(first, last), ends][(parameter, second).index("speed")] if "speed" in (parameter, second) else None
    family.reduce(max(at_speed) if at_speed else family(first, now).speed)
    kind_of = kinds([family(value, other).host for value in (first, last) for other in ends])
    if not kind_of:
        raise QuestionError("bifurcation curves: the machine has no balls")
    steps = Steps(0.3 * largest_step, 1e-7, largest_step)

    def followed() -> tuple[tuple[list[dict[str, Any]], list[dict[str, Any]]], float]:
        explorer = Explorer(Range(family, first, last, (now,)), kind_of, steps, 10, 10, None)
        begin_all(explorer, from_state, parameter)
        items = [f for f in explorer.specials if f.special.kind == kind and f.steady is not None and not f.steady.loose]
        if not items:
            raise QuestionError(
                f"kind: no {kind} point of the {from_state} state along {parameter} from {first:.6g} to {last:.6g} at "
                f"{second} = {now:.6g}; widen the range"
            )
        rows: list[dict[str, Any]] = []
        specials: list[dict[str, Any]] = []
        for number, entry in enumerate(items, 1):
            assert entry.steady is not None
            # along the curve both parameters are free, from the point to both sides
            problem, u = _curve_from(entry.special, entry.steady, now, ends)
            if _passes_through(rows, problem, u):
                continue  # the curve came back here along the first parameter
            sides = [_side(problem, u, way, number, specials, largest_step, progress) for way in (1.0, -1.0)]
            rows += [*reversed(sides[1]), *sides[0][1:]]
        return (rows, specials), max(explorer.tail(), *(row["tail"] for row in rows))

    rows, specials = with_enough_harmonics(family, followed)
    title = f"{kind} curves of {machine.name}, {from_state} state"
    about = {"parameter": parameter, "second_parameter": second, "state": from_state}
    return _dataset(family, rows, specials, attributes(machine, title, Theory.AT_REST) | about)


def _curve_from(special: Special, problem: Steady, second: float, ends: tuple[float, float]) -> tuple[Curve, Floats]:
    """The curve through a Hopf point or a fold found at the value ``second`` of the second parameter."""
    u, share = special.point.u, (second - ends[0]) / (ends[1] - ends[0])
    if special.kind == "Hopf":
        q = special.mode / np.linalg.norm(special.mode)
        start = np.concatenate([u, [special.frequency / problem.span.frequency], q.real, q.imag, [share]])
        return HopfCurve(problem.span, problem.groups, *ends, np.conj(q)), start
    null = np.linalg.svd(problem.jacobian(u))[2][-1]
    start = np.concatenate([u, null, [share]])
    return FoldCurve(problem.span, problem.groups, *ends, null.astype(np.complex128)), start


def _side(
    problem: Curve,
    u: Floats,
    way: float,
    number: int,
    specials: list[dict[str, Any]],
    most: float,
    progress: Progress | None,
) -> list[dict[str, Any]]:
    like = np.zeros(u.size)
    like[-1] = way
    u = at_parameter(problem, u, float(u[-1]))
    rows = [_row(problem, u, number)]
    try:
        for now, a, b in follow(problem, u, like, steps=Steps(0.3 * most, 1e-7, most, 1000)):
            assert isinstance(now, Curve)
            if not -1e-9 <= now.share(b.u) <= 1.0 + 1e-9:
                break
            if isinstance(now, HopfCurve) and now.frequency(b.u) < 1e-4 * now.span.frequency:
                break  # Takens-Bogdanov: the frequency runs to zero
            specials += _between(now, a, b, number)
            rows.append(_row(now, b.u, number))
            if progress is not None:
                progress(number, min(max(float(b.u[-1]), 0.0), 1.0))
    except np.linalg.LinAlgError:
        pass
    return rows


def _between(problem: Curve, a: Point, b: Point, number: int) -> list[dict[str, Any]]:
    """A Bautin point or a cusp between two points of a curve."""
    name = "Bautin" if isinstance(problem, HopfCurve) else "cusp"

    def test(p: Point) -> float:
        if isinstance(problem, HopfCurve):
            return problem.lyapunov(p.u)
        assert isinstance(problem, FoldCurve)
        return problem.curvature(p.u)

    if test(a) * test(b) >= 0.0:
        return []
    try:
        point = locate(problem, a, b, test, 1e-11)
    except (NoConvergence, np.linalg.LinAlgError):
        return []
    return [_row(problem, point.u, number) | {"type": name}]


def _row(problem: Curve, u: Floats, number: int) -> dict[str, Any]:
    row = {
        "curve": number,
        "parameter": problem.span.value(problem.share(u)),
        "second_parameter": problem.second(u),
        "share": problem.share(u),
        "mark": float(u[-1]),
        "tail": problem.tail(u),
    }
    if isinstance(problem, HopfCurve):
        row |= {"frequency": problem.frequency(u), "lyapunov_coefficient": problem.lyapunov(u)}
    return row


def _passes_through(rows: list[dict[str, Any]], problem: Curve, u: Floats) -> bool:
    """Whether a curve that was followed goes through this point."""
    mark, share = float(u[-1]), problem.share(u)
    for a, b in pairwise(rows):
        if a["curve"] != b["curve"] or not min(a["mark"], b["mark"]) - NEAR <= mark <= max(a["mark"], b["mark"]) + NEAR:
            continue
        part = (mark - a["mark"]) / (b["mark"] - a["mark"]) if a["mark"] != b["mark"] else 0.5
        if abs(a["share"] + part * (b["share"] - a["share"]) - share) < NEAR:
            return True
    return False


def _dataset(
    family: Family, rows: list[dict[str, Any]], specials: list[dict[str, Any]], attributes: dict[str, Any]
) -> xr.Dataset:
    types = np.array([row["type"] for row in specials], dtype=np.str_)
    data: dict[str, tuple[Any, ...]] = {
        "curve": ("point", [row["curve"] for row in rows], "number of the curve"),
        "special_type": ("special", types, "what happens there"),
    }
    if rows and "frequency" in rows[0]:
        values = [row["lyapunov_coefficient"] for row in rows]
        data["frequency"] = ("point", [row["frequency"] for row in rows], "frequency", "rad/s")
        data["lyapunov_coefficient"] = ("point", values, "first Lyapunov coefficient", "1")
        data["criticality"] = ("point", [_criticality(value) or "subcritical" for value in values], "criticality")
    result = labeled(data, None, attributes)
    for number, name in enumerate(("parameter", "second_parameter")):
        about = family.attributes(number)
        result[name] = ("point", [row[name] for row in rows], about)
        result[f"special_{name}"] = ("special", np.array([row[name] for row in specials], np.float64), about)
    return Answer.of(result, "BifurcationCurves")

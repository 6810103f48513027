"""Whether a run is balanced, and what is left where."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures import thresholds
from autobalancer.laws.capabilities import balance_grade, grade_name
from autobalancer.results.display_units import (
    couple_text,
    force_text,
    length_text,
    moment_text,
    share_text,
    significant,
    velocity_text,
    worded,
)
from autobalancer.results.run_arrays import (
    HELD_AT,
    HeldRotor,
    Stall,
    balls_of,
    bins_of,
    held_rotor,
    jump_times,
    known_balls,
    parts_between_jumps,
    recorded_of,
    rotor_measures,
    settling,
    stall_of,
    stopped,
    whirls_of,
)
from autobalancer.results.time_series import (
    NONE,
    compiled,
    load_of,
    of_a_run,
    plain,
    plane_vectors,
    residual_unbalance,
    rotor_unbalance,
    support_forces,
    vibration,
    whole_turns,
)
from autobalancer.tables import html_table

# How a run got to its end: its greatest deflection and the balls that settle, also between jumps of the unbalance.
#
# Where balls still creep at the end, they are followed to where they come to rest. A slow ball has the speed at which
# the fluid balances the force of the rotor: for ball i of plane p it is Im(exp(-i phi_i) sum_q g_pq R_q), where R_q is
# what is left of the unbalance of plane q. The complex gains g are fitted to the run, and these equations are
# integrated.


BLOCKS = 40  # of the time after the run-up, to which the way of the balls is fitted
MISFIT = 0.2  # of these ways, relative, from which on nothing is extrapolated
AHEAD = 1000.0  # times the run, for which the balls are followed
EVALUATIONS = 20_000  # of their speeds, after which they are followed no more: about a second
NEAR = 0.8  # of the tolerance, within which a ball is sure to count as settled
SAME_SHARE = 0.05  # of the unbalance, within which the residual is that of settled balls


@dataclass(frozen=True)
class Peak:
    """Greatest deflection of a run at the reference station (m) and the speed there (rad/s)."""

    place: str
    deflection: float
    speed: float


@dataclass(frozen=True)
class Settling:
    """The ball that settles last: how long it takes, from when, and when that is in the run, s; ``moving`` never settle.

    ``duration`` is nan where the run-up does not end, see :class:`HeldRotor`.
    """

    ball: int
    duration: float
    counted_from: str
    settled_at: float
    moving: tuple[int, ...]


@dataclass(frozen=True)
class Forecast:
    """Where balls go that still move: their ``speed`` at the end (rad/s), and extrapolated ``share`` and ``duration``.

    ``share`` is residual over unbalance once they have settled, ``duration`` (s) that of a run that shows it; both nan where
    nothing can be extrapolated. ``followed`` (s) is that of a run at whose end they still have not settled, else nan.
    """

    speed: float
    share: float = np.nan
    duration: float = np.nan
    followed: float = np.nan


@dataclass(frozen=True)
class RunPart:
    """A part of a run between jumps of its unbalance, from ``begin`` to ``end`` (s)."""

    begin: float
    end: float
    peak: Peak | None
    settling: Settling | None


def parts_of(run: xr.Dataset) -> tuple[RunPart, ...]:
    """The parts between jumps of the unbalance; none if it does not jump."""
    if not jump_times(run):
        return ()
    return tuple(RunPart(begin, end, peak_of(part), settling_of(part)) for begin, end, part in parts_between_jumps(run))


def peak_of(run: xr.Dataset) -> Peak | None:
    """The greatest deflection; None of a run that kept no data for it."""
    try:
        found = rotor_measures(bins_of(run), np.zeros((0, 2)))
    except QuestionError:
        return None
    return Peak(str(run.attrs["reference_station"]), float(found.peak_deflection), float(found.peak_speed))


def settling_of(run: xr.Dataset) -> Settling | None:
    """The ball that settles last; None without balls, or without data."""
    try:
        found = settling(known_balls(run), whirls_of(run), jump_times(run), HELD_AT in run.attrs)
    except QuestionError:
        return None
    return last_settled(run["ball"].values, found.at, found.duration, found.counted_from)


def last_settled(balls: NDArray[Any], at: Floats, duration: Floats, counted_from: str) -> Settling:
    """Of ``balls`` by number the one that settles last; nan ``at`` (s) is one that does not settle."""
    moving = tuple(int(ball) for ball in balls[np.isnan(at)])
    if len(moving) == at.size:
        return Settling(0, np.nan, "", np.nan, moving)
    last = int(np.nanargmax(at))
    return Settling(int(balls[last]), float(duration[last]), counted_from, float(at[last]), moving)


def forecast_of(run: xr.Dataset, since: float) -> Forecast | None:
    """Where the balls go that have not settled, from their motion after ``since`` (s); None without balls or data."""
    try:
        balls = balls_of(run)
    except QuestionError:
        return None
    if balls is None or balls.time.size < 3:
        return None
    late = min(int(np.searchsorted(balls.time, (1.0 - thresholds.LAST) * balls.time[-1])), balls.time.size - 2)
    way = np.abs(balls.angle[-1] - balls.angle[late]).max()
    speed = float(way / (balls.time[-1] - balls.time[late]))
    inside = balls.time >= 0.5 * (since + balls.time[-1])
    if "plane_balls" not in run or int(inside.sum()) < 2 * BLOCKS:
        return Forecast(speed)
    unbalance = plane_vectors(run)[0]
    plane = run["ball_plane"].values - 1 if "ball_plane" in run else np.zeros(balls.angle.shape[1], np.int64)
    moment = run["ball_moment"].values * (plane == np.arange(unbalance.shape[1])[:, None])  # (P, n)
    return Forecast(speed, *_followed(balls.time[inside], balls.angle[inside], unbalance[inside], moment))


def _followed(time: Floats, angle: Floats, unbalance: Complexes, moment: Floats) -> tuple[float, ...]:
    """The last three numbers of a :class:`Forecast`, or none of them where nothing can be extrapolated."""
    from scipy.integrate import LSODA, cumulative_trapezoid

    size, plane = float(np.abs(unbalance[-1]).sum()), moment.argmax(axis=0)
    if not size > 0.0:
        return ()
    unbalance, moment = unbalance / size, moment / size

    def left(balls: Floats, of: Complexes) -> Complexes:
        return np.asarray(of + np.exp(1j * balls) @ moment.T, np.complex128)

    edges = np.linspace(0, time.size - 1, BLOCKS + 1).astype(int)
    gains = np.zeros((len(moment), len(moment)), np.complex128)
    missed = total = 0.0
    for p in range(len(moment)):
        rows, ways = [], []
        for i in np.flatnonzero(plane == p):
            drive = np.exp(-1j * angle[:, i])[:, None] * left(angle, unbalance)
            done = cumulative_trapezoid(np.hstack([drive.imag, drive.real]), time, axis=0, initial=0.0)
            rows.append(np.diff(done[edges], axis=0))
            ways.append(np.diff(angle[edges, i]))
        if rows:
            matrix, way = np.vstack(rows), np.concatenate(ways)
            gain = np.linalg.lstsq(matrix, way, rcond=1e-6)[0]
            gains[p] = gain[: len(moment)] + 1j * gain[len(moment) :]
            missed, total = missed + float(((matrix @ gain - way) ** 2).sum()), total + float((way**2).sum())
    if not missed < MISFIT**2 * total:
        return ()
    now = unbalance[-1]

    def turning(_: float, balls: Floats) -> Floats:
        return np.asarray((np.exp(-1j * balls) * (gains @ left(balls, now))[plane]).imag, np.float64)

    solver = LSODA(turning, 0.0, angle[-1], AHEAD * time[-1], rtol=1e-7, atol=1e-9)
    times, course = [time[-1]], [angle[-1]]
    while solver.status == "running" and solver.nfev < EVALUATIONS:
        solver.step()
        times.append(time[-1] + solver.t)
        course.append(solver.y)
    way = np.array(course)
    if solver.status == "failed" or np.abs(way[-1] - way[0]).max() > 2.0 * np.pi:
        return ()
    shares = np.abs(left(way, now)).sum(axis=1)
    apart = np.abs(way - way[-1]).max(axis=1) > NEAR * thresholds.SETTLED
    under_way = np.flatnonzero(apart | (np.abs(shares - shares[-1]) > SAME_SHARE))
    duration = times[under_way[-1] + 1 if under_way.size else 0] / (1.0 - thresholds.LAST)
    if solver.status == "running" or duration > times[-1]:
        return np.nan, np.nan, float(times[-1])
    return float(shares[-1]), float(duration)


# The verdict on a run: balanced or not, what is left where, and the same machine without balancing beside it.


@dataclass(frozen=True)
class PlaceVerdict:
    """A plane, station or support: static deflection and vibration (m), rms velocity (m/s), vibration without balls (m).

    ``sag`` (m) is that of the rotor without balls under its weight, from which the static deflection counts.
    """

    name: str
    static: float
    vibration: float
    velocity_rms: float
    without_balls: float
    sag: float = 0.0


@dataclass(frozen=True)
class PlaneVerdict:
    """A plane of balancers: its unbalance and what is left of it, kg m."""

    name: str
    unbalance: float
    residual: float


@dataclass(frozen=True)
class SupportVerdict:
    """A support: static force, greatest vibrating force, and that without balls, N."""

    name: str
    static: float
    vibrating: float
    without_balls: float


@dataclass(frozen=True)
class Verdict:
    """What a run says of balancing, SI but for the grades.

    ``word`` is *balanced*, *partly balanced*, *not balanced*, *worse than without balls*, *not settled yet* or *no
    verdict*, and of the last two ``because`` says why; else it names a free vibration that does not count. ``forecast``
    says where balls go that have not settled. ``ratio`` is the greatest vibration of all places over the greatest
    without balls. ``unbalance`` and ``residual`` (kg m) are those of the rotor in its plane, or summed over several
    planes; ``grade_before`` and ``grade_after`` are the grade G of ISO 21940-11 of both, U W/M at the last speed in
    mm/s. Of two planes ``static_residual`` (kg m) is the resultant of what they leave, ``couple_residual``
    (kg m^2) its couple about the middle between them; ``static_unbalance`` and ``couple_unbalance`` are those of their
    unbalances. ``parts`` are those of the run between jumps of the unbalance; none without a jump. ``without_held``
    says that no run with held balls was given, ``bodies`` what rolls, "balls" or "cylinders". ``stall`` says which balls
    are stalled at the end, None where none is; ``goes_round`` whether a ball goes round in the rotor then; ``turning``
    how many balls of a deep chamber turn with it, and of how many; ``held_rotor`` past which critical speed the drive does
    not take the rotor, None where it does.
    """

    word: str
    because: str
    speed: float = np.nan
    ratio: float = np.nan
    unbalance: float = np.nan
    residual: float = np.nan
    grade_before: float = np.nan
    grade_after: float = np.nan
    places: tuple[PlaceVerdict, ...] = ()
    planes: tuple[PlaneVerdict, ...] = ()
    supports: tuple[SupportVerdict, ...] = ()
    peak: Peak | None = None
    peak_without_balls: Peak | None = None
    settling: Settling | None = None
    notes: tuple[str, ...] = ()
    static_residual: float = np.nan
    couple_residual: float = np.nan
    static_unbalance: float = np.nan
    couple_unbalance: float = np.nan
    parts: tuple[RunPart, ...] = ()
    without_held: bool = False
    bodies: str = "balls"
    forecast: Forecast | None = None
    stall: Stall | None = None
    goes_round: bool = False
    turning: tuple[int, int] | None = None
    held_rotor: HeldRotor | None = None

    @property
    def state_of_balls(self) -> str:
        """What the balls do at the end: *stalled*, *still go round*, *not settled yet* or *settled*."""
        if self.stall is not None:
            return "stalled"
        return "still go round" if self.goes_round else NOT_SETTLED if self.word == NOT_SETTLED else "settled"

    @property
    def turns_with_rotor(self) -> bool:
        """Whether all balls turn with the rotor at the end, without which residual and grade say nothing."""
        return self.stall is None and not self.goes_round

    @property
    def balanced(self) -> bool:
        """Whether the word is *balanced*."""
        return self.word == "balanced"

    @property
    def residual_share(self) -> float:
        """Residual over unbalance; nan without unbalance."""
        return self.residual / self.unbalance if self.unbalance > 0.0 else np.nan

    @property
    def peak_ratio(self) -> float:
        """Greatest deflection of the run over that without balls; nan without a run with held balls."""
        if self.peak is None or self.peak_without_balls is None or self.peak_without_balls.deflection == 0.0:
            return np.nan
        return self.peak.deflection / self.peak_without_balls.deflection

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        return {**asdict(self), "peak_ratio": self.peak_ratio}

    def __repr__(self) -> str:
        head, lines, notes = verdict_lines(self)
        width = max((len(label) for label, _ in lines), default=0)
        return "\n".join(
            [head, *(f"  {label:<{width}}  {text}" for label, text in lines), *(f"note: {n}" for n in notes)]
        )

    def _repr_html_(self) -> str:
        head, rows, notes = verdict_lines(self)
        return html_table(("", ""), [*rows, *(("note", note) for note in notes)], head)


@of_a_run()
def verdict(run: xr.Dataset, held: xr.Dataset | None = None) -> Verdict:
    """Whether a run ends balanced, by the rule of :mod:`autobalancer.results.verdict`, and what remains at each place.

    Parameters
    ----------
    run
        From :func:`simulate` with its last revolutions, which it keeps by default.
    held
        The same machine from ``simulate(machine, hold_balls=True)``. It gives the peak without balls; for a machine with
        external excitation also the vibration without balls, which otherwise every run has.

    Raises
    ------
    QuestionError
        If the run is not one of balls in races.
    """
    if "place" not in run.coords:
        raise QuestionError("verdict: needs a run of balls in races from simulate; that of a deep chamber has no races")
    notes = tuple(map(str, np.atleast_1d(run.attrs.get("remarks", []))))
    peak, other_peak = (None if one is None else peak_of(one) for one in (run, held))
    unfinished = stopped(run)
    alone = held is None and not unfinished and bool(run.sizes.get("ball", 0)) and "balls_held" not in run.attrs
    caught = held_rotor(run, float(run.attrs.get(HELD_AT, np.nan)))
    try:
        turns = whole_turns(run)
    except QuestionError as reason:
        return Verdict(
            NO_VERDICT, unfinished or str(reason), peak=peak, peak_without_balls=other_peak, notes=notes, parts=parts_of(run),
            without_held=alone, stall=stall_of(run), held_rotor=caught,
        )  # fmt: skip
    places, supports, planes = _places(run, held), _supports(run, held), _planes(run)
    unbalance, residual = _rotor(run.isel(turn=turns), planes)
    speed, mass = float(run["turn_speed"].values[-1]), float(run.attrs["turning_mass"])
    without = max(place.without_balls for place in places)
    greatest = max(place.vibration for place in places)
    ratio = greatest / without if without > 0.0 else np.nan
    course = _course(run)
    word, because = (
        (NO_VERDICT, unfinished) if unfinished else _because(run, course, greatest, without, unbalance, planes)
    )
    settling = settling_of(run)
    creeping = settling is not None and settling.moving and not course.uneven and word != NO_VERDICT
    before, after = (grade_of(size, mass, speed) for size in (unbalance, residual))
    return Verdict(
        word or verdict_word(ratio), because, speed, ratio, unbalance, residual, before, after, places, planes, supports, peak,
        other_peak, settling, notes, *_shares(run.isel(turn=turns)), parts_of(run), alone,
        forecast=forecast_of(run, course.since) if creeping or word == NOT_SETTLED else None, stall=stall_of(run),
        goes_round=course.uneven, held_rotor=caught,
    )  # fmt: skip


def _because(
    run: xr.Dataset,
    course: Course,
    vibration: float,
    without: float,
    unbalance: float,
    planes: tuple[PlaneVerdict, ...],
) -> tuple[str, str]:
    """Why there is no verdict, after the word for it; empty texts if there is one."""
    if not run.sizes.get("ball", 0):
        return NO_VERDICT, "the machine has no balls"
    if np.isnan(without):
        if "vibration_without_balls" in run:
            return NO_VERDICT, "the speed is a critical speed of a rotor without damping"
        return NO_VERDICT, (
            "the machine has an external excitation, bearings that harden, or rubber whose steady motion is not known; give "
            "'held', its run with hold_balls=True"
        )
    if without == 0.0 or unbalance + sum(plane.unbalance for plane in planes) == 0.0:
        return NO_VERDICT, "the rotor has no unbalance"
    return unsteady(course, vibration, without)


def _course(run: xr.Dataset) -> Course:
    for prefix in ("", "envelope_", "turn_"):
        if f"{prefix}speed" in run:
            when = "envelope_end" if prefix == "envelope_" and "envelope_end" in run else f"{prefix}time"
            time, speed = run[when].values, run[f"{prefix}speed"].values
            angle = f"{prefix}ball_angle_in_rotor"
            angles = run[angle].values if angle in run else np.zeros((time.size, 0))
            break
    kept = "envelope_high" in run
    middle, low, high = (run[f"envelope_{name}"].values if kept else np.zeros(0) for name in ("time", "low", "high"))
    centered, end = load_of(run.attrs) == NONE, float(run.attrs["end_time"])
    try:
        recorded = recorded_of(run)
        since, creeps = recorded.since, recorded.creeps
    except QuestionError:  # it kept its last revolutions alone
        since, creeps = 0.0, False
    uneven = bool(compiled().goes_round(plain(time), plain(angles), end))
    return Course(end, centered, time, speed, uneven, middle, low, high, since, creeps)


def _places(run: xr.Dataset, held: xr.Dataset | None) -> tuple[PlaceVerdict, ...]:
    moved = vibration(run)
    try:
        greatest = recorded_of(run).of_places.vibration  # slow changes over the last twentieth count too
    except QuestionError:  # it kept its last revolutions alone
        greatest = moved["greatest"].values
    without = _without(run, held, "vibration_without_balls", vibration, greatest.size)
    sag = run["rotor_sag"].values if "rotor_sag" in run else np.zeros(greatest.size)
    columns = (moved["static"].values, greatest, moved["velocity_rms"].values, without, sag)
    return named(PlaceVerdict, run["place"].values, *columns)


def _supports(run: xr.Dataset, held: xr.Dataset | None) -> tuple[SupportVerdict, ...]:
    force = support_forces(run)
    without = _without(run, held, "force_without_balls", support_forces, run.sizes["support"])
    return named(SupportVerdict, run["support"].values, force["static"].values, force["greatest"].values, without)


def _without(run: xr.Dataset, held: xr.Dataset | None, name: str, measure: Any, count: int) -> Floats:
    if name in run:
        return np.asarray(run[name].values, np.float64)
    if held is not None and held.sizes.get("turn", 0) > 1:
        return np.asarray(measure(held)["greatest"].values, np.float64)
    return np.full(count, np.nan)


def _planes(run: xr.Dataset) -> tuple[PlaneVerdict, ...]:
    if "plane" not in run.coords:
        return ()
    unbalance = residual_unbalance(run)
    return named(PlaneVerdict, run["plane"].values, unbalance["unbalance"].values, unbalance["residual"].values)


def named(kind: type[Any], names: Sequence[str] | NDArray[Any], *columns: Floats) -> tuple[Any, ...]:
    """Of each name what a column has of it, as this kind of entry of a verdict."""
    return tuple(kind(str(name), *map(float, row)) for name, *row in zip(names, *columns, strict=True))


def grade_of(unbalance: float, mass: float, speed: float) -> float:
    """The grade G in mm/s of what is known of an unbalance; nan at rest."""
    return balance_grade(abs(unbalance), mass, abs(speed)) if np.isfinite(unbalance) and speed != 0.0 else np.nan


def _rotor(last: xr.Dataset, planes: tuple[PlaneVerdict, ...]) -> tuple[float, float]:
    """Unbalance and residual of the whole rotor: of several planes the sums, else the resultants."""
    if len(planes) > 1:
        return sum(plane.unbalance for plane in planes), sum(plane.residual for plane in planes)
    return rotor_unbalance(last) if "turn_unbalance" in last else (np.nan, np.nan)


def _shares(last: xr.Dataset) -> tuple[float, float, float, float]:
    """Static and couple share of what two planes leave and of their unbalances, kg m and kg m^2; nan unless two."""
    if last.sizes.get("plane", 0) != 2 or "plane_position" not in last.coords:
        return np.nan, np.nan, np.nan, np.nan
    unbalance, balls = plane_vectors(last, "turn_")
    half = 0.5 * float(np.diff(last["plane_position"].values)[0])
    (first, second), (one, two) = (unbalance + balls).T, unbalance.T
    parts = (first + second, half * (second - first), one + two, half * (two - one))
    left, couple, static, moment = (float(abs(part.mean())) for part in parts)
    return left, couple, static, moment


# When a machine counts as balanced: one rule for balls in races, deep chambers, runs and studies.
#
# The vibration with balls, at the place where it is greatest, is compared with the vibration of the same machine with
# its balls spread evenly and held, where that is greatest. Up to a tenth of it is *balanced*, up to nine tenths
# *partly balanced*, up to eleven tenths *not balanced*; more is *worse than without balls*. There is *no verdict* on a
# run that was stopped, or whose speed changes by more than a hundredth in its last twentieth. *Not settled yet* is one
# of fewer than ten revolutions, or whose vibration in the last two twentieths differs by more than a fifth, or would
# still change by more than that: its means in the thirds of the last fifth are continued as an exponential approach;
# or whose balls drift and have not settled. Where a ball goes round in the rotor only the twentieths count, which may
# differ by a factor of two. Below a tenth of that without balls a vibration may change.


BALANCED, PARTLY, NOT, WORSE = "balanced", "partly balanced", "not balanced", "worse than without balls"
NO_VERDICT, NOT_SETTLED = "no verdict", "not settled yet"
# in the order of kernels/measures/thresholds.py
WORDS = (BALANCED, PARTLY, NOT, WORSE, NO_VERDICT, NOT_SETTLED)
LIMITS = tuple(zip(thresholds.LIMITS, WORDS[:3], strict=True))


def verdict_word(ratio: float) -> str:
    """The word for the vibration with balls over that without; ``"no verdict"`` for nan."""
    from autobalancer.kernels.measures.record_series import class_of

    return WORDS[class_of(ratio)]


class Course(NamedTuple):
    """What tells whether a run has come to its end: samples, and the envelope of the reference station."""

    end: float  # time, s
    centered: bool  # nothing can deflect the rotor for good
    time: Floats  # (T,) s
    speed: Floats  # (T,) rad/s
    uneven: bool  # whether a ball goes round in the rotor at the end
    envelope_time: Floats  # (B,) s; empty without an envelope
    low: Floats  # (B,) m
    high: Floats  # (B,) m
    since: float = 0.0  # from when the run was left alone, s
    creeps: bool = False  # whether a ball that has not settled drifts at the end


def unsteady(course: Course, vibration: float, without_balls: float) -> tuple[str, str]:
    """The word and the reason where a run has not come to its end: its speed or its vibration still changes; else empty texts.

    ``vibration`` is the greatest of all places, ``without_balls`` that without balls (m): below a tenth of it a vibration may
    change.
    """
    from autobalancer.kernels.measures.record_series import REVOLUTIONS, changing, too_short, twentieth

    envelope = plain(course.envelope_time), plain(course.low), plain(course.high)
    before, after = (twentieth(*envelope, course.end, begin, course.centered) for begin in (0.9, 0.95))
    to_come = compiled().vibration_to_come(*envelope, course.since, course.end, course.centered)
    moves = speed_changes(course.time, course.speed, course.end)
    reason = changing(moves, course.uneven, course.creeps, before, after, to_come, vibration, without_balls)
    if reason == thresholds.SPEED_CHANGES:
        return NO_VERDICT, (
            "the speed still changes in the last twentieth of the run, so the numbers are those of its last revolutions and "
            "not of a steady state; run longer"
        )
    if course.speed.size and too_short(course.end, float(course.speed[-1])):
        turns = course.end * abs(float(course.speed[-1])) / (2.0 * np.pi)
        return NOT_SETTLED, f"too short to tell: {turns:.2g} revolutions; take {REVOLUTIONS:g} or more"
    said = "the vibration still changes at the end of the run"
    return (NOT_SETTLED, said) if reason == thresholds.VIBRATION_CHANGES else ("", "")


def speed_changes(time: Floats, speed: Floats, end: float) -> bool:
    """Whether the speed still changes in the last twentieth of a run of ``end`` seconds, so that it has no steady state."""
    return bool(compiled().speed_changes(plain(time), plain(speed), end))


# A verdict as lines that people read.


Lines = list[tuple[str, str]]
NOT_COMPARED = "not computed; verdict(run, held) compares it, with held = simulate(machine, hold_balls=True)"
NO_RESIDUAL = "balls do not turn with the rotor: no residual to count on"
LISTED = 8  # balls that are named
ORDINALS = ("first", "second", "third", "fourth")
RAISED = 0.02  # share of a critical speed by which gyroscopic moments raise a whirl that is named
GREATER = thresholds.LIMITS[-1]  # times the greatest deflection without balls, from which on the headline says so
NOT_SEEN = "; how long they take to settle is not known, more than {} s (extrapolated)"
LEAST_SHARE = 1e-3  # of an unbalance, below which an extrapolated residual is not said in figures


def rpm_text(speed: float) -> str:
    """A speed in rad/s as text in rpm: ``"668 rpm"``."""
    return f"{significant(speed * 30.0 / math.pi)} rpm"


def verdict_lines(verdict: Verdict, speed_text: Callable[[float], str] = rpm_text) -> tuple[str, Lines, list[str]]:
    """A headline, rows of a label and a text, and notes; ``speed_text`` writes a speed (rad/s)."""
    rows: Lines = []
    if not math.isnan(verdict.residual):
        of = (
            f" of {moment_text(verdict.unbalance)}, {share_text(verdict.residual_share)}"
            if verdict.unbalance > 0.0
            else ""
        )
        added = "planes added up, " * (len(verdict.planes) > 1)
        counts = "" if verdict.turns_with_rotor else f"; {NO_RESIDUAL}"
        rows.append(("residual unbalance", f"{moment_text(verdict.residual)}{of} ({added}mean at the end){counts}"))
    elif not verdict.turns_with_rotor and not math.isnan(verdict.unbalance):
        rows.append(("residual unbalance", NO_RESIDUAL))
    if len(verdict.planes) > 1:
        for plane in verdict.planes:
            share = f", {share_text(plane.residual / plane.unbalance)}" if plane.unbalance > 0.0 else ""
            rows.append((f"  {plane.name}", f"{moment_text(plane.residual)} of {moment_text(plane.unbalance)}{share}"))
    if not math.isnan(verdict.couple_residual):
        static = f"{moment_text(verdict.static_residual)} of {moment_text(verdict.static_unbalance)}"
        couple = f"{couple_text(verdict.couple_residual)} of {couple_text(verdict.couple_unbalance)}"
        rows.append(("  vector sum", f"static {static}, couple about their middle {couple}"))
    for number, place in enumerate(verdict.places):
        text = f"at most {length_text(place.vibration)} from its mean position, {velocity_text(place.velocity_rms)} rms"
        text += _text_without(place.without_balls, length_text)
        rows.append(("vibration" if not number else "", f"{place.name}: {text}"))
    # a static deflection only where it is more than the noise beside the vibration
    settled = [place for place in verdict.places if place.static > 1e-8 and place.static > 0.01 * place.vibration]
    for number, place in enumerate(settled):
        name = f"{place.name}: " if len(verdict.places) > 1 else ""
        beyond = f", beyond the {length_text(place.sag)} by which the rotor sags without balls" * (place.sag > 0.0)
        rows.append(("static deflection" if not number else "", f"{name}{length_text(place.static)}{beyond}"))
    for number, support in enumerate(verdict.supports):
        static = f"static {force_text(support.static)}, " if support.static > 0.01 * support.vibrating else ""
        name = f"{support.name}: " if len(verdict.supports) > 1 else ""
        text = f"{name}{static}vibrating {force_text(support.vibrating)}"
        rows.append(("support forces" if not number else "", text + _text_without(support.without_balls, force_text)))
    if not math.isnan(verdict.grade_before):
        reached, before = (
            f"{grade_name(v)} ({velocity_text(1e-3 * v)})" if v > 0.0 else "no unbalance"
            for v in (verdict.grade_after, verdict.grade_before)
        )
        if not verdict.turns_with_rotor:
            reached = "no grade, as balls do not turn with the rotor"
        rows.append(("ISO 21940-11", f"{reached}; without balls {before}"))
    if verdict.peak is not None:
        where = f"{verdict.peak.place}: " if len(verdict.places) > 1 else ""
        rows.append(("greatest deflection", f"{where}{_peak(verdict.peak, speed_text)}, from the rest position"))
        if verdict.peak_without_balls is not None:
            rows.append(("  without balls", _peak(verdict.peak_without_balls, speed_text)))
        elif verdict.without_held:
            rows.append(("  without balls", NOT_COMPARED))
    if verdict.parts:
        rows += _parts(verdict.parts, speed_text)
    elif verdict.settling is not None:
        ahead = None if verdict.word == NOT_SETTLED else verdict.forecast
        rows.append(("balls settle", _settling(verdict.settling, ahead)))
    rows = [(worded(label, verdict.bodies), worded(text, verdict.bodies)) for label, text in rows]
    return headline(verdict, speed_text), rows, list(verdict.notes)


def headline(verdict: Verdict, speed_text: Callable[[float], str] = rpm_text) -> str:
    """The verdict in a sentence, with balls that stall, and the greatest deflection where balls made it much greater."""
    stalled = _held(verdict, speed_text) + _stalled(verdict, speed_text)
    vibration = f"vibration {share_text(verdict.ratio)} of that without balls"
    if verdict.word in (PARTLY, NOT):
        vibration += f" (balanced is up to {100.0 * thresholds.LIMITS[0]:.0f} %)"
    if verdict.word in WORDS[:4]:
        beside = f"; {verdict.because}" if verdict.because else ""
        return worded(f"{verdict.word}{stalled}{_transient(verdict)}: {vibration}{beside}", verdict.bodies)
    still = _remaining_change(verdict) if verdict.word == NOT_SETTLED and not stalled else ""
    return worded(f"{verdict.word}{stalled}: {still or verdict.because}{_transient(verdict)}", verdict.bodies)


def _text_without(value: float, text: Callable[[float], str]) -> str:
    return "" if math.isnan(value) else f"; without balls {text(value)}"


def _critical(mode: int, of: int, speed: str) -> str:
    """The critical speed with that number, of several; ``speed`` is its text."""
    number = f"{ORDINALS[mode - 1] if mode <= len(ORDINALS) else f'{mode}th'} " * (of > 1)
    return f"the {number}critical speed of {speed}"


def _held(verdict: Verdict, speed_text: Callable[[float], str]) -> str:
    """Past which critical speed the drive does not take the rotor, and where it stays."""
    held = verdict.held_rotor
    if held is None:
        return ""
    past = _critical(held.mode, held.critical_speeds_of_rotor, speed_text(held.critical_speed))
    return f", the drive does not take the rotor past {past} (it stays at {speed_text(held.speed)})"


def _stalled(verdict: Verdict, speed_text: Callable[[float], str]) -> str:
    """How many balls are stalled at the end, at which critical speed, for how long; of a chamber how many turn with the rotor."""
    stall = verdict.stall
    if stall is None:
        turning, balls = verdict.turning or (0, 0)
        turn = f"turn{'s' * (turning < 2)} with the rotor"
        return "" if turning == balls else f", {turning or 'none'} of {balls} balls {turn}"
    texts = []
    for mode in sorted(set(stall.modes)):
        own = [speed for speed, at in zip(stall.speeds, stall.modes, strict=True) if at == mode]
        first = stall.modes.index(mode)
        critical, whirl = stall.critical_speeds[first], stall.whirls[first]
        raised = f", near its forward whirl of {speed_text(whirl)}" * (whirl > (1.0 + RAISED) * critical)
        there = _critical(mode, stall.critical_speeds_of_rotor, speed_text(critical))
        texts.append(
            f"{len(own)} of {stall.of} balls stalled at {there} (whirling at {speed_text(float(np.mean(own)))}{raised})"
        )
    return f", {', '.join(texts)} while the rotor turns at {speed_text(stall.rotor_speed)}, for {significant(stall.duration)} s"


def _transient(verdict: Verdict) -> str:
    """The passage of the resonance, where balls have made it worse."""
    if verdict.peak is None or verdict.peak_without_balls is None:
        return ""
    text = passage_text(verdict.peak.deflection, verdict.peak_without_balls.deflection)
    joined = ", but" if verdict.word == BALANCED else ", and" if verdict.word in WORDS[:4] else ";"
    return f"{joined} {text}" if text else ""


def passage_text(deflection: float, without: float) -> str:
    """That the greatest deflection of a run (m) is more than a tenth greater than that ``without`` balls; else empty."""
    if not deflection > GREATER * without > 0.0:
        return ""
    much = worse_by(deflection / without) + (" than" if deflection < 2.0 * without else " as")
    beside = f"({length_text(deflection)}, without {length_text(without)})"
    return f"the greatest deflection on the way is {much} without balls {beside}"


def worse_by(ratio: float) -> str:
    """How much worse a passage is of so many times the greatest deflection without balls; empty up to one tenth."""
    if not ratio > GREATER:
        return ""
    return f"{share_text(ratio - 1.0)} worse" if ratio < 2.0 else f"{significant(ratio)} times as much"


def _remaining_change(verdict: Verdict) -> str:
    """What still changes at the end of a run, where it goes, and how long a run shows it."""
    ahead = verdict.forecast
    if ahead is None:
        return f"{verdict.because}; run longer (run.duration)"
    said = verdict.because
    if verdict.settling is not None and verdict.settling.moving:
        said = f"balls still move {significant(math.degrees(ahead.speed), 2)} deg/s"
    if math.isnan(ahead.duration):
        unseen = NOT_SEEN.format(significant(ahead.followed, 2))
        return said + (unseen if ahead.followed > 0.0 else "; run longer (run.duration)")
    later = "below 0.1 %" if ahead.share < LEAST_SHARE else f"about {share_text(ahead.share)}"
    return (
        f"{said}; residual {share_text(verdict.residual_share)} now, {later} when they have settled (extrapolated); run "
        f"for about {significant(ahead.duration, 2)} s to see it (run.duration)"
    )


def _peak(peak: Peak, speed_text: Callable[[float], str]) -> str:
    return f"{length_text(peak.deflection)} at {speed_text(peak.speed)}"


def _parts(parts: tuple[RunPart, ...], speed_text: Callable[[float], str]) -> Lines:
    """Peak and settling before and after each jump of the unbalance."""
    rows: Lines = [("unbalance jumps", "at " + ", ".join(f"{part.begin:.5g} s" for part in parts[1:]))]
    for number, part in enumerate(parts):
        label = f"  from {part.begin:.5g} s" if number else f"  up to {part.end:.5g} s"
        texts = [f"greatest deflection {_peak(part.peak, speed_text)}"] if part.peak is not None else []
        texts += [f"balls settle {_settling(part.settling)}"] if part.settling is not None else []
        rows.append((label, "; ".join(texts) or "nothing was kept"))
    return rows


def _settling(settling: Settling, ahead: Forecast | None = None) -> str:
    moving = settling.moving
    later = ""
    if ahead is not None and ahead.followed > 0.0:
        later = NOT_SEEN.format(significant(ahead.followed, 2))
    elif ahead is not None and not math.isnan(ahead.duration):
        later = f"; a run of about {significant(ahead.duration, 2)} s shows them settled (extrapolated)"
    if not settling.ball:
        return f"none; {'it still moves' if len(moving) == 1 else 'all still move'} at the end{later}"
    at = f" (at {settling.settled_at:.5g} s)" if settling.counted_from != "start" else ""
    when = f"{settling.duration:.3g} s after" if settling.duration > 0.0 else "before"
    since = f"{when} the {settling.counted_from}{at}"
    if math.isnan(settling.duration):
        since = f"at {settling.settled_at:.5g} s, but the run-up has not ended"
    text = f"{since}, ball {settling.ball} last"
    if moving:
        named = ", ".join(map(str, moving[:LISTED])) + (", ..." if len(moving) > LISTED else "")
        text += f"; not settled: {len(moving)} ({named}){later}"
    return text

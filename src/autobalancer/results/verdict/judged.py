"""The verdict on a run: balanced or not, what is left where, and the same machine without balancing beside it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.balance_quality import balance_grade
from autobalancer.results.of_a_run import of_a_run
from autobalancer.results.places import plane_vectors, residual_unbalance, support_forces, vibration, whole_turns
from autobalancer.results.recorded_of import recorded_of
from autobalancer.results.series import mean
from autobalancer.results.standing import NONE, load_of
from autobalancer.results.verdict.passage import (
    Forecast,
    Peak,
    RunPart,
    Settling,
    forecast_of,
    parts_of,
    peak_of,
    settling_of,
)
from autobalancer.results.verdict.rule import NO_VERDICT, NOT_SETTLED, Course, goes_round, unsteady, verdict_word
from autobalancer.results.verdict.text import verdict_html, verdict_lines

NOTES = (
    "input_text",
    "left_race_text",
    "friction_text",
    "floor_text",
    "eccentricity_text",
    "rubber_text",
    "bearing_text",
)  # attributes of a run that are its remarks


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
    says that no run with held balls was given, ``bodies`` what rolls, "balls" or "cylinders".
    """

    word: str
    because: str
    speed: float
    ratio: float
    unbalance: float
    residual: float
    grade_before: float
    grade_after: float
    places: tuple[PlaceVerdict, ...]
    planes: tuple[PlaneVerdict, ...]
    supports: tuple[SupportVerdict, ...]
    peak: Peak | None
    peak_without_balls: Peak | None
    settling: Settling | None
    notes: tuple[str, ...]
    static_residual: float = np.nan
    couple_residual: float = np.nan
    static_unbalance: float = np.nan
    couple_unbalance: float = np.nan
    parts: tuple[RunPart, ...] = ()
    without_held: bool = False
    bodies: str = "balls"
    forecast: Forecast | None = None

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
        return verdict_html(self)


@of_a_run()
def verdict(run: xr.Dataset, held: xr.Dataset | None = None) -> Verdict:
    """Whether a run ends balanced, by the rule of :mod:`autobalancer.results.verdict.rule`, and what remains at each place.

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
    notes = tuple(line for name in NOTES if name in run.attrs for line in str(run.attrs[name]).split("\n"))
    peak, other_peak = (None if one is None else peak_of(one) for one in (run, held))
    stopped = ""
    if run.attrs.get("outcome", "finished") != "finished":
        stopped = f"the run did not finish: {run.attrs.get('outcome_text', run.attrs['outcome'])}"
    alone = held is None and not stopped and bool(run.sizes.get("ball", 0)) and "balls_held" not in run.attrs
    try:
        turns = whole_turns(run)
    except QuestionError as reason:
        none = np.nan
        return Verdict(
            NO_VERDICT,
            stopped or str(reason),
            none,
            none,
            none,
            none,
            none,
            none,
            (),
            (),
            (),
            peak,
            other_peak,
            None,
            notes,
            parts=parts_of(run),
            without_held=alone,
        )
    places, supports = _places(run, held), _supports(run, held)
    planes = _planes(run)
    unbalance, residual = _rotor(run.isel(turn=turns), planes)
    speed, mass = float(run["turn_speed"].values[-1]), float(run.attrs["turning_mass"])
    without = max(place.without_balls for place in places)
    greatest = max(place.vibration for place in places)
    ratio = greatest / without if without > 0.0 else np.nan
    course = _course(run)
    word, because = (NO_VERDICT, stopped) if stopped else _because(run, course, greatest, without, unbalance, planes)
    settling = settling_of(run)
    creeping = settling is not None and settling.moving and not course.uneven and word != NO_VERDICT
    before, after = (
        balance_grade(abs(size), mass, abs(speed)) if np.isfinite(size) else np.nan for size in (unbalance, residual)
    )
    return Verdict(
        word or verdict_word(ratio), because, speed, ratio, unbalance, residual, before, after, places, planes, supports, peak,
        other_peak, settling, notes, *_shares(run.isel(turn=turns)), parts_of(run), alone,
        forecast=forecast_of(run, course.since) if creeping or word == NOT_SETTLED else None,
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
    none = np.zeros(0)
    middle, low, high = (
        run[f"envelope_{name}"].values if "envelope_high" in run else none for name in ("time", "low", "high")
    )
    centered = load_of(run.attrs) == NONE
    end = float(run.attrs["end_time"])
    try:
        recorded = recorded_of(run)
        since, creeps = recorded.since, recorded.creeps
    except QuestionError:  # it kept its last revolutions alone
        since, creeps = 0.0, False
    return Course(end, centered, time, speed, goes_round(time, angles, end), middle, low, high, since, creeps)


def _places(run: xr.Dataset, held: xr.Dataset | None) -> tuple[PlaceVerdict, ...]:
    moved = vibration(run)
    try:
        greatest = recorded_of(run).vibration  # slow changes over the last twentieth count too
    except QuestionError:  # it kept its last revolutions alone
        greatest = moved["greatest"].values
    without = _without(run, held, "vibration_without_balls", vibration, greatest.size)
    sag = run["rotor_sag"].values if "rotor_sag" in run else np.zeros(greatest.size)
    columns = (moved["static"].values, greatest, moved["velocity_rms"].values, without, sag)
    return tuple(
        PlaceVerdict(str(name), *map(float, row)) for name, *row in zip(run["place"].values, *columns, strict=True)
    )


def _supports(run: xr.Dataset, held: xr.Dataset | None) -> tuple[SupportVerdict, ...]:
    force = support_forces(run)
    without = _without(run, held, "force_without_balls", support_forces, run.sizes["support"])
    columns = (force["static"].values, force["greatest"].values, without)
    return tuple(
        SupportVerdict(str(name), *map(float, row)) for name, *row in zip(run["support"].values, *columns, strict=True)
    )


def _without(run: xr.Dataset, held: xr.Dataset | None, name: str, measure: Any, count: int) -> NDArray[np.float64]:
    if name in run:
        return np.asarray(run[name].values, np.float64)
    if held is not None and held.sizes.get("turn", 0) > 1:
        return np.asarray(measure(held)["greatest"].values, np.float64)
    return np.full(count, np.nan)


def _planes(run: xr.Dataset) -> tuple[PlaneVerdict, ...]:
    if "plane" not in run.coords:
        return ()
    found = residual_unbalance(run)
    rows = zip(run["plane"].values, found["unbalance"].values, found["residual"].values, strict=True)
    return tuple(PlaneVerdict(str(name), float(unbalance), float(left)) for name, unbalance, left in rows)


def _rotor(last: xr.Dataset, planes: tuple[PlaneVerdict, ...]) -> tuple[float, float]:
    """Unbalance and residual of the whole rotor: of several planes the sums, else the resultants."""
    if len(planes) > 1:
        return sum(plane.unbalance for plane in planes), sum(plane.residual for plane in planes)
    if "turn_unbalance" not in last:
        return np.nan, np.nan
    return mean(last["turn_unbalance"].values), mean(last["turn_residual_unbalance"].values)


def _shares(last: xr.Dataset) -> tuple[float, float, float, float]:
    """Static and couple share of what two planes leave and of their unbalances, kg m and kg m^2; nan unless two."""
    if last.sizes.get("plane", 0) != 2 or "plane_position" not in last.coords:
        return np.nan, np.nan, np.nan, np.nan
    unbalance, balls = plane_vectors(last, "turn_")
    half = 0.5 * float(np.diff(last["plane_position"].values)[0])
    (first, second), (one, two) = (unbalance + balls).T, unbalance.T
    parts = (first + second, half * (second - first), one + two, half * (two - one))
    left, couple, static, moment = (float(np.abs(part).mean()) for part in parts)
    return left, couple, static, moment

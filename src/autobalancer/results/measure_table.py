"""The table of the measures of a run: name, unit, meaning and arithmetic, for runs, sweeps, commands and documentation.

A new measure of a run is an entry here, of balls in races and of deep chambers alike. One that is made of others (``made_of``)
is in sweeps at once. One that compiled loops take from a motion is an entry of
``kernels/measures/record_series.py`` instead, for runs and sweeps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.record_series import (
    COLUMN,
    COLUMNS,
    HERE,
    LATE_TURNS,
    OF_BALLS,
    OF_IMPACTS,
    OF_PLACES,
    OF_ROTOR,
    WIDTH,
    OfMotion,
)
from autobalancer.kernels.measures.thresholds import LAST as LAST_SHARE
from autobalancer.kernels.measures.thresholds import SETTLED
from autobalancer.results.answers.answer import SOURCE, Answer, Labeled
from autobalancer.results.labels import labeled
from autobalancer.results.run_arrays import (
    HELD_AT,
    SETTLING_FROM,
    Recorded,
    away_from_standing,
    bins_of,
    jump_times,
    known_balls,
    known_origin,
    parts_between_jumps,
    recorded_of,
    rotor_measures,
    series,
    settling,
    stalls_of,
    whirls_of,
)
from autobalancer.results.time_series import (
    NONE,
    crests,
    greatest_at,
    greatest_known,
    last_deflection,
    load_of,
    mean,
    means,
    of_a_run,
    share_of,
    sizes,
    sizes_of_means,
    values_at,
    vibration,
    wrapped,
)
from autobalancer.units import optional_argument

# What a measure is: a number of a run, or one for each ball or place, and what a sweep keeps of it.


NEEDS = {
    "": "bins",
    "ball": "balls",
    "place": "turns",
    "plane": "planes",
    "support": "forces",
    "jump": "parts",
    "link": "links",
}
Of = Callable[..., Any]  # of a Recorded in which nothing that the measure needs is None


class OfAll(NamedTuple):
    """The one number that a sweep keeps of a measure with several; ``name`` where it has its own."""

    text: str
    of: Of
    needs: str = ""  # by default what the measure needs
    name: str = ""
    per_ball: bool = False  # then a sweep has them all


class Measure(NamedTuple):
    """One measure: ``of`` gives a number, or an array along ``along``.

    It is left out where the run did not record what :data:`NEEDS` says of ``along``, or what it ``needs`` besides, both names
    of :class:`~autobalancer.results.run_arrays.Recorded` (of a deep chamber ``needs`` alone). A sweep keeps measures that are one
    number, those over the balls, and ``of_all`` of the others, if they are computed there. With ``made_of`` it is one number, and
    ``of`` gets in place of a run the numbers that a sweep keeps of those measures, or arrays of them. With ``of_rest`` it says
    something only of balls that turn with the rotor: nan where one is stalled or goes round in the rotor at the end; of a deep
    chamber only of a steady state: nan where the speed still changes.
    """

    name: str
    unit: str
    along: str
    text: str
    of: Of
    of_all: OfAll | None = None
    needs: str = ""
    made_of: tuple[str, ...] = ()
    of_rest: bool = False


class InSweep(NamedTuple):
    """A measure as a sweep has it: one number of a run, or one for each ball."""

    name: str
    unit: str
    text: str
    per_ball: bool
    of: Of
    needs: tuple[str, ...]
    made_of: tuple[str, ...] = ()
    of_rest: bool = False


def needed(measure: Measure) -> tuple[str, ...]:
    """What a run must have recorded for a measure; of one that is made of others, for these."""
    if measure.made_of:
        return tuple(
            n
            for m in MEASURES
            if (m.of_all and m.of_all.name) in measure.made_of or m.name in measure.made_of
            for n in needed(m)
        )
    return NEEDS[measure.along], *([measure.needs] if measure.needs else [])


RUN_UP, RELEASED = "from the end of the run-up", "from the last release, if a ball stalls"
SINCE = f"{RUN_UP} or a later jump of the unbalance"
PER_BALL = "ball_angle_to_unbalance"


def _taken(table: tuple[OfMotion, ...], of: str, along: str = "", needs: str = "") -> Iterator[Measure]:
    """The measures that compiled loops take from a motion, ``of`` the property of a :class:`Recorded` that has them by name."""
    for one in table:
        number = attrgetter(f"{of}.{one.name}")
        pick: Of = greatest_known if one.known else lambda values: values[greatest_at(values)]
        of_all = OfAll(one.of_all, lambda r, number=number, pick=pick: pick(number(r))) if one.of_all else None
        yield Measure(one.name, one.unit, along, one.text, number, of_all, needs)


MEASURES = (
    *_taken(OF_ROTOR, "of_rotor"),
    Measure(
        "held_at_critical_speed",
        *("rad/s", "", "critical speed past which its drive does not take the rotor; none if it does"),
        lambda r: r.held,
        needs="held",
    ),
    Measure(
        "residual_vibration", "m", "", f"vibration at the end of the run at {HERE}", lambda r: r.residual_vibration
    ),
    *_taken(OF_PLACES, "of_places", "place"),
    Measure(
        "vibration_without_balls",
        *("m", "place", "greatest vibration at the last speed with the balls spread and held"),
        lambda r: r.without_balls,
        OfAll("greatest vibration of all places with the balls spread and held", lambda r: np.max(r.without_balls)),
        needs="without_balls",
    ),
    Measure(
        "vibration_share",
        *("1", "", "vibration at the end of the run over that with the balls spread and held, the greatest of each"),
        lambda vibration, without: share_of(vibration, without),
        made_of=("vibration", "vibration_without_balls"),
    ),
    Measure(
        "unbalance",
        *("kg m", "plane", f"unbalance that the balls of the plane have to balance {LATE_TURNS}"),
        lambda r: means(r.planes[0]),
    ),
    Measure(
        "residual_unbalance",
        *("kg m", "plane", f"residual unbalance of the plane {LATE_TURNS}"),
        lambda r: sizes_of_means(r.planes[1]),
        OfAll(
            f"residual unbalance, of several planes the sum, {LATE_TURNS}",
            lambda r: sum(sizes_of_means(r.rotor[1])),
            "rotor",
        ),
        of_rest=True,
    ),
    Measure(
        "residual_share",
        *("1", "plane", f"residual unbalance over unbalance {LATE_TURNS}"),
        lambda r: share_of(sizes_of_means(r.planes[1]), means(r.planes[0])),
        OfAll(
            "residual unbalance over unbalance",
            lambda r: share_of(sum(sizes_of_means(r.rotor[1])), mean(r.rotor[0])),
            "rotor",
        ),
        of_rest=True,
    ),
    Measure(
        "static_force",
        *("N", "support", f"static force on the support {LATE_TURNS}"),
        lambda r: r.of_supports.static_deflection,
    ),
    Measure(
        "vibrating_force",
        *("N", "support", f"greatest distance of the force from its mean {LATE_TURNS}"),
        lambda r: r.of_supports.vibration,
        OfAll(
            f"greatest vibrating force of all supports {LATE_TURNS}",
            lambda r: r.of_supports.vibration.max(initial=0.0),
            name="support_force",
        ),
    ),
    Measure(
        "vibrating_force_rms",
        *("N", "support", f"root mean square of the vibrating force {LATE_TURNS}"),
        lambda r: r.of_supports.vibration_rms,
    ),
    Measure(
        "peak_force",
        *("N", "support", "greatest force on the support in the samples, static part included"),
        lambda r: sizes(r.pushes).max(axis=0),
        needs="pushes",
    ),
    Measure(
        "settling_time",
        *("s", "ball", f"settling time, {SINCE}; zero if settled before, none if not settled"),
        lambda r: r.settled.duration,
        OfAll(
            f"settling time of the last ball, {SINCE}; zero if settled before, none if not settled",
            lambda r: r.settled.duration[greatest_at(r.settled.at)],
        ),
    ),
    Measure(
        "settled_at",
        *("s", "ball", "time in the run at which the ball has settled"),
        lambda r: r.settled.at,
        OfAll("time in the run at which the last ball has settled", lambda r: r.settled.at[greatest_at(r.settled.at)]),
    ),
    *_taken(OF_BALLS, "of_balls", "ball"),
    Measure(
        "stalled_balls",
        *("", "", "balls that are stalled at the end of the run"),
        lambda r: np.count_nonzero(np.isfinite(r.stalls[2])),
        needs="balls",
    ),
    Measure(
        "lift_off_time",
        *("s", "ball", "time from which the floor of its annulus carries the resolved ball no more"),
        lambda r: r.lifted[0],
        needs="lifted",
    ),
    Measure(
        "lift_off_speed",
        *("rad/s", "ball", "rotor speed at which the floor of its annulus stops carrying the resolved ball"),
        lambda r: r.lifted[1],
        needs="lifted",
    ),
    Measure(
        "final_ball_angle_to_unbalance",
        *("rad", "ball", "final ball angle from the unbalance"),
        lambda r: r.final_angle,
        OfAll("final ball angle from the unbalance", lambda r: r.final_angle, name=PER_BALL, per_ball=True),
        needs="final_angle",
        of_rest=True,
    ),
    *_taken(OF_IMPACTS, "of_impacts", needs="impacts"),
    Measure(
        "peak_torque",
        *("N m", "link", "greatest torque of a coupling, or of the stator on its mount"),
        lambda r: np.abs(crests(r.links.time, r.links.torque)[1]),
    ),
    Measure(
        "peak_torque_speed",
        *("rad/s", "link", "rotor speed at the greatest torque of the link"),
        lambda r: r.links.speed[r.links.worst],
    ),
    Measure(
        "peak_twist",
        *("rad", "link", "greatest twist of a coupling, or angle of the stator"),
        lambda r: np.abs(crests(r.links.time, r.links.twist)[1]),
    ),
    Measure(
        "peak_after_jump",
        *("m", "jump", "greatest deflection after a jump"),
        lambda r: np.array([part.bins.high.max() for part in r.parts]),
    ),
    Measure(
        "settling_after_jump",
        *("s", "jump", "settling time after a jump, last ball"),
        lambda r: np.array([part.settled.duration.max() for part in r.parts]),
        needs="balls",
    ),
)


def measured(recorded: Any, table: Sequence[Measure], label: Callable[[Measure], dict[str, str]]) -> dict[str, Any]:
    """Dimensions, numbers and ``label`` of the measures of a run by name, without those for which it recorded too little."""
    of_a_race = isinstance(recorded, Recorded)
    values = {
        m.name: _known(m, recorded)
        for m in table
        if not m.made_of and _has(recorded, needed(m) if of_a_race else (m.needs,) * bool(m.needs))
    }
    if any(m.made_of for m in table):
        values = numbers(recorded) | values
    return {
        m.name: ((m.along,) if m.along else (), np.asarray(values[m.name], np.float64), label(m))
        for m in table
        if m.name in values
    }


def numbers(recorded: Recorded) -> dict[str, Any]:
    """What a sweep keeps of a run, by name, without that for which it recorded too little."""
    return _with_made({m.name: _known(m, recorded) for m in SWEPT if not m.made_of and _has(recorded, m.needs)})


def _known(measure: Measure | InSweep, recorded: Any) -> Any:
    values = measure.of(recorded)
    return np.full_like(values, np.nan) if measure.of_rest and not recorded.at_rest else values


def _with_made(single: dict[str, Any]) -> dict[str, Any]:
    """The numbers of a sweep with those that are made of others, in the order of the table."""
    made = {m.name: m.of(*map(single.get, m.made_of)) for m in SWEPT if m.made_of and single.keys() >= set(m.made_of)}
    return {m.name: (single | made)[m.name] for m in SWEPT if m.name in single or m.name in made}


def in_row(row: Floats, settling_from: str = SETTLING_FROM[0]) -> dict[str, Any]:
    """The same by name out of a row of kernels/measures/row.py, or out of many rows; nan for what a run did not record."""
    moving = (row[..., COLUMN.stalled_balls] > 0.0) | (row[..., COLUMN.goes_round] > 0.0)
    result = {}
    for m in (m for m in SWEPT if not m.made_of):
        values = row[..., WIDTH:] if m.per_ball else row[..., getattr(COLUMN, m.name)]
        result[m.name] = np.where(moving[..., None] if m.per_ball else moving, np.nan, values) if m.of_rest else values
    if settling_from != SETTLING_FROM[0]:
        result["settling_time"] = row[..., COLUMN.settling_since_release]
    return _with_made(result)


def label_of(measure: Measure | InSweep, settling_from: str, station: str = "") -> dict[str, str]:
    """Long name and unit of a measure; it says at which reference ``station``, from where settling counts, and where none is."""
    text = measure.text if settling_from == SETTLING_FROM[0] else measure.text.replace(RUN_UP, RELEASED)
    text += "; none where a ball is stalled or goes round in the rotor" * measure.of_rest
    return {"long_name": text.replace(HERE, repr(station) if station else HERE), "units": measure.unit}


def swept(table: Sequence[Measure]) -> tuple[InSweep, ...]:
    """What a sweep keeps of the measures of a table: those that are computed there."""
    one = (m.of_all or OfAll(m.text, m.of) for m in table)
    result = (
        InSweep(
            o.name or m.name,
            m.unit,
            o.text,
            o.per_ball,
            o.of,
            (o.needs,) if o.needs else needed(m),
            m.made_of,
            m.of_rest,
        )
        for m, o in zip(table, one, strict=True)
        if m.of_all is not None or not m.along
    )
    return tuple(m for m in result if m.per_ball or m.name in COLUMNS or m.made_of)


def _has(recorded: Any, names: tuple[str, ...]) -> bool:
    return all(getattr(recorded, name) is not None for name in names)


SWEPT = swept(MEASURES)


# The same of deep chambers: of what :class:`~autobalancer.results.chamber_measures.ChamberRecorded` has. Measures along
# ``stage`` are those before and in the steady state.


STEADY = "in steady state"
STAGES = ("transient", "steady")
KINDS: dict[str, tuple[str, Callable[[Floats], Any]]] = {
    "greatest": ("greatest", lambda values: np.abs(values).max()),
    "rms": ("root mean square", lambda values: np.sqrt(np.mean(values**2))),
    "mean": ("mean", np.mean),
}


def _body_motion(direction: str, unit: str) -> Iterator[Measure]:
    for name, sign, text, of in (
        ("amplitude", unit, f"{direction} amplitude {STEADY}", lambda r: 0.5 * np.ptp(r.moved(direction)[r.steady])),
        ("synchronous", unit, f"{direction} synchronous amplitude {STEADY}", lambda r: r.synchronous(direction)),
        ("peak", unit, f"greatest {direction} deflection in the transient", lambda r: r.away(direction).max()),
        ("peak_time", "s", f"time of the greatest {direction} deflection", lambda r: r.when(r.away(direction))),
    ):
        yield Measure(f"{direction}_{name}", sign, "", text, of, of_rest=True)


def _reaction(name: str, unit: str, of: Of) -> Iterator[Measure]:
    def over_stages(measure: Callable[[Floats], Any]) -> Of:
        return lambda r: r.parts(of(r), measure)

    for kind, (text, measure) in KINDS.items():
        yield Measure(f"{name}_{kind}", unit, "stage", f"{text} of {name.replace('_', ' ')}", over_stages(measure))


CHAMBER_MEASURES = (
    *_body_motion("horizontal", "m"),
    *_body_motion("vertical", "m"),
    *_body_motion("rotation", "rad"),
    *_reaction("bearing_1", "N", lambda r: r.radial_force(1)),
    *_reaction("bearing_1_axial", "N", lambda r: r.values("bearing_force")[:, 0, 0]),
    *_reaction("bearing_2", "N", lambda r: r.radial_force(2)),
    *_reaction("bearing_2_axial", "N", lambda r: r.values("bearing_force")[:, 1, 0]),
    *_reaction("constraint_x", "N", lambda r: r.values("constraint_force")[:, 0]),
    *_reaction("constraint_moment_y", "N m", lambda r: r.values("constraint_moment")[:, 1]),
    *_reaction("constraint_moment_z", "N m", lambda r: r.values("constraint_moment")[:, 2]),
    Measure("contacts_ball", "", "", "contacts between balls", lambda r: r.run["contacts_ball"].values.sum()),
    Measure("contacts_wall", "", "", "contacts with the chamber", lambda r: r.run["contacts_wall"].values.sum()),
    Measure("impact_rate", "1/s", "stage", "contacts begun a second", lambda r: r.over_stages(r.impacts)),
    Measure(
        "impact_speed", "m/s", "stage", "mean speed at which contacts began", lambda r: r.of_impact("impact_speeds")
    ),
    Measure(
        "impact_energy",
        *("J", "stage", "mean energy of approach with which contacts began"),
        lambda r: r.of_impact("impact_energies"),
    ),
    Measure("impact_power", "W", "stage", "power that impacts dissipate", lambda r: r.over_stages(r.impact_loss)),
    Measure("hardest_contact", "N", "", "force of the hardest contact", lambda r: r.contact_force.max()),
    Measure("hardest_contact_time", "s", "", "time of the hardest contact", lambda r: r.when(r.contact_force)),
    Measure(
        "tilting",
        *("", "stage", "greatest moment that would tilt a cylinder over what its contacts could bear"),
        lambda r: r.parts(r.run["tilting"].values, np.max),
        needs="cylinders",
    ),
    Measure(
        "tilting_share",
        *("", "stage", "share of the samples in which it is above 1"),
        lambda r: r.parts(r.run["tilting"].values > 1.0, np.mean),
        needs="cylinders",
    ),
    Measure(
        "settling_time",
        *("s", "", "settling time of the last ball, from the end of the run-up"),
        lambda r: r.settled.duration.max() if r.settled.duration.size else np.nan,
    ),
    Measure("share_carried", "1", "", "share of the balls that go around with the rotor", lambda r: np.mean(r.carried)),
    Measure(
        "residual_unbalance",
        *("kg m", "", f"residual unbalance {STEADY}"),
        lambda r: r.left["static"].mean(),
        needs="left",
        of_rest=True,
    ),
    Measure(
        "residual_couple",
        *("kg m^2", "", f"residual couple unbalance {STEADY}"),
        lambda r: r.left["couple"].mean(),
        needs="left",
        of_rest=True,
    ),
    Measure(
        "energy_error",
        *("1", "", "greatest error of the energy balance over the work of the motor"),
        lambda r: r.error_over_work,
    ),
)


def single_names(measure: Measure) -> list[str]:
    """The names of a measure of a deep chamber as single numbers; those of a stage have its name in front."""
    return [f"{stage}_{measure.name}" for stage in STAGES] if measure.along else [measure.name]


# Measures of a run: the few numbers by which run-ups are compared.


@of_a_run()
def deflection_envelope(run: xr.Dataset, bins: int = 200) -> xr.Dataset:
    """Least and greatest deflection over time.

    Taken from the envelope that the run kept (exact), else from its samples (with their resolution), in ``bins`` parts.

    Returns
    -------
    xarray.Dataset
        ``low`` and ``high`` (m) over ``time`` (s), and ``speed`` (rad/s).

    Raises
    ------
    QuestionError
        If the run kept neither.
    """
    result = bins_of(run, bins)
    envelope = {
        "low": ("time", result.low, "least deflection", "m"),
        "high": ("time", result.high, "greatest deflection", "m"),
        "speed": ("time", result.speed, "rotor speed", "rad/s"),
    }
    time = {"time": ("time", result.time, "time", "s")}
    return Labeled.of_run(run, "Envelope of the deflection", labeled(envelope, time))


@of_a_run()
def peak_deflection(run: xr.Dataset) -> xr.Dataset:
    """Greatest deflection of the run (m), with the ``time`` (s) and ``speed`` (rad/s) at which it occurs.

    In a run through a critical speed this is the peak at resonance.
    """
    found = rotor_measures(bins_of(run), np.zeros((0, 2)))
    peak = {
        "deflection": ((), float(found.peak_deflection), "greatest deflection", "m"),
        "time": ((), float(found.peak_time), "time of the greatest deflection", "s"),
        "speed": ((), float(found.peak_speed), "rotor speed at the greatest deflection", "rad/s"),
    }
    return Labeled.of_run(run, "Greatest deflection", labeled(peak))


@of_a_run()
def residual_vibration(run: xr.Dataset, last: float | str | None = None) -> float:
    """Greatest vibration (m) at the reference station at the end of the run, without static deflection.

    On a vertical axis, which has no static deflection without a recorded excitation, it is the greatest deflection over the
    ``last`` seconds, by default over the last twentieth of the run. Else it is the greatest distance from the mean position,
    over the last revolutions that the run kept; over the samples of the ``last`` seconds if that is given or there are
    none.

    Raises
    ------
    QuestionError
        If the run kept no data for it.
    """
    last = optional_argument("last", last, "s")
    if "end_time" not in run.attrs:
        raise QuestionError("residual_vibration: this result is no run of simulate; there is nothing to measure")
    end = float(run.attrs["end_time"])
    if last is not None and not last > 0.0:
        raise QuestionError(f"last: given {last:g} s; must be greater than zero")
    begin = end - (LAST_SHARE * end if last is None else last)
    if load_of(run.attrs) == NONE:
        bins = bins_of(run)
        return last_deflection(bins.time, bins.high, begin)
    if last is None and run.sizes.get("turn", 0) > 1:
        return float(vibration(run)["greatest"].values[0])
    if "x" not in run:
        raise QuestionError(
            "the rotor has a static load, its weight or a recorded excitation, so the envelope holds static deflection and "
            "vibration together; run it with save=[..., LastRevolutions()]"
        )
    late = run.isel(time=series(run, "time")[0] >= begin)
    if not late.sizes["time"]:
        raise QuestionError(f"the run kept no sample of its last {end - begin:.3g} s; there is nothing to measure")
    return float(away_from_standing(late).max())


@of_a_run()
def settling_time(run: xr.Dataset, tolerance: float = SETTLED, settling_from: str = SETTLING_FROM[0]) -> xr.DataArray:
    """Time (s) that each ball takes to stay within ``tolerance`` (rad) of the angle in the rotor to which it goes.

    It counts from one moment for all balls, zero for a ball that has settled before: from the end of the run-up, where the speed
    comes to stay within 0.1 % of its last value, or with ``settling_from="release"`` from the last release of a stalled ball, if
    one stalls; in any case from a jump of the unbalance that is later. The coordinate ``counted_from`` says which it is,
    ``settled_at`` (s) is the time in the run. Between samples angles are interpolated.

    nan where the drive does not take the rotor past a critical speed, as its run-up does not end, unless the unbalance jumps; and
    for a ball that has not settled: it has been near its last angle for less than a twentieth of the run, or the way that is
    still to come, extrapolated from its motion there as an exponential approach, is longer than the tolerance.

    Raises
    ------
    QuestionError
        If the machine has no balls, the run kept nothing of them, or ``settling_from`` is another word.
    """
    origin, balls = known_origin(settling_from), known_balls(run)
    result = settling(balls, whirls_of(run), jump_times(run), HELD_AT in run.attrs, origin, tolerance)
    return _per_ball(run, result.duration, "settling time", "s").assign_coords(
        settled_at=("ball", result.at), counted_from=result.counted_from
    )


@of_a_run(of_machine="ab.stability.borders(machine)")
def break_away_speed(run: xr.Dataset, critical_speed: float | str | None = None) -> xr.DataArray:
    """Rotor speed (rad/s) at which each ball that stalled at a critical speed breaks away.

    This is what the run did; the release speed of :func:`autobalancer.stability.borders` is the theory of a slow run-up.
    nan for a ball that did not stall, or did not break away. A ball hangs where its speed in space is twice as near to a
    whirl frequency of the rotor, which this has passed by 2 % at least, as to the speed of the rotor, or below that frequency
    down to half of it. It is stalled if it so goes round in the rotor once or more, counted from where the rotor passes that
    frequency, and breaks away where it hangs for the last time. The frequencies are those at ``critical_speed`` or, by default,
    at all critical speeds of the machine, with gyroscopic moments.
    """
    critical_speed = optional_argument("critical_speed", critical_speed, "rad/s")
    balls, whirls = known_balls(run), whirls_of(run)
    if critical_speed is not None:
        whirls = np.array([[critical_speed, 0.0]])
    released = values_at(stalls_of(balls, whirls)[1], balls.speed)
    return _per_ball(run, released, "break-away speed in the run", "rad/s")


@of_a_run()
def ball_angle_to_unbalance(run: xr.Dataset) -> xr.DataArray:
    """Angle (rad, within -pi to pi) of each ball from the direction of the unbalance, over time and ball of ``run``.

    Balls on the light side are near pi, balls on the heavy side near 0.
    """
    if "ball_angle_in_rotor" not in run:
        raise QuestionError("the run kept no samples over time; run it with save=Samples()")
    angle = run["ball_angle_in_rotor"] - run["unbalance_angle_in_rotor"]
    result = xr.apply_ufunc(wrapped, angle)
    result.attrs.update(long_name="ball angle from the unbalance", units="rad", frame="rotor")
    return xr.DataArray(result.rename("ball_angle_to_unbalance"))


def measures_of(
    run: xr.Dataset, recorded: Any, table: Sequence[Measure], label: Callable[[Measure], Any]
) -> xr.Dataset:
    """The measures of a run that a table has, with ``label`` and from whom they are."""
    return xr.Dataset(
        measured(recorded, table, label), attrs={key: run.attrs[key] for key in SOURCE if key in run.attrs}
    )


@of_a_run(called="run_measures")
def measures(run: xr.Dataset, settling_from: str = SETTLING_FROM[0]) -> Answer:
    """All measures of a run in one dataset; each has its unit and its long name, which says where it is measured.

    They are those of :data:`autobalancer.results.measure_table.MEASURES` for which the run kept the data: those over
    ``place``, ``plane`` and ``support`` ask for its last revolutions. ``settling_from`` is as for :func:`settling_time`.
    """
    recorded = recorded_of(run, known_origin(settling_from))
    label = partial(label_of, settling_from=settling_from, station=str(run.attrs.get("reference_station", "rotor")))
    dataset = measures_of(run, recorded, MEASURES, label)
    for name in ("ball", "place", "plane", "support", "link"):
        if name in dataset.dims:
            dataset = dataset.assign_coords({name: run[name].values})
    if recorded.balls is not None:
        dataset = dataset.assign_coords(counted_from=recorded.settled.counted_from)
    if recorded.parts is not None:
        begins = [begin for begin, _, _ in parts_between_jumps(run) if begin > 0.0]
        about = {"units": "s", "long_name": "time of a jump of the unbalance"}
        dataset = dataset.assign_coords(jump_time=("jump", begins, about))
    return Answer.of(dataset, "Measured")


def _per_ball(run: xr.Dataset, values: np.ndarray, text: str, unit: str) -> xr.DataArray:
    return xr.DataArray(values, {"ball": run["ball"].values}, ["ball"], attrs={"long_name": text, "units": unit})

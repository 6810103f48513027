"""The verdict on a run of a deep chamber, by the rule and in the words of balls in races."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import of_kind, parse_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine_kinds import CHAMBERS
from autobalancer.results.chamber_measures import (
    balls_with_rotor,
    bodies_of,
    chamber_settling,
    held_below,
    residual_of_balls,
    unbalance_of,
    window,
)
from autobalancer.results.display_units import length_text, share_text, significant
from autobalancer.results.run_arrays import held_rotor, stopped
from autobalancer.results.time_series import calm_mean, end_of_run_up, of_a_run, place_measures
from autobalancer.results.verdict import (
    LIMITS,
    NO_VERDICT,
    NOT_SETTLED,
    Course,
    Peak,
    PlaceVerdict,
    Settling,
    SupportVerdict,
    Verdict,
    grade_of,
    last_settled,
    named,
    speed_changes,
    unsteady,
    verdict_word,
)
from autobalancer.simulation.chamber.bounds import body_without_balancing, chamber_critical_speeds, tilting_note
from autobalancer.units import optional_argument

MIDDLE = "middle of the rotor"
UNDER_WAY = "the speed still changes in the last twentieth of the run, which has no steady state; run longer"
TWENTIETHS = 20


@of_a_run(runs=CHAMBERS)
def chamber_verdict(run: xr.Dataset, last: float | str | None = None, *, held: xr.Dataset | None = None) -> Verdict:
    """Whether a run of a deep chamber ends balanced, by the rule of balls in races.

    The vibration is the greatest distance of the middle of the rotor from its mean position, across the axis. That without
    balls is the steady one of the same body with the balls as masses in the middles of their chambers. Where all balls go around
    with the rotor, what does not turn with it and becomes smaller is a free vibration that decays: it does not count, and
    ``because`` says how large it is. Where they do not, and the run-up can have left a free vibration that matters, the run
    has not settled yet.

    A run whose speed still changes has no steady state: without ``last`` only its greatest deflection is said, from the rest
    position of the machine without balls.

    Parameters
    ----------
    run
        From ``simulate_chamber``, or an archive.
    last
        Seconds at the end that are the steady state; by default a tenth of the run.
    held
        The same machine from ``simulate(machine, hold_balls=True)``, which gives the peak without balls.

    Raises
    ------
    QuestionError
        If ``last`` is not possible, or the run does not say of which machine it is.
    """
    described = unbalance_of(run)
    if described is None:
        raise QuestionError("verdict: the run does not say of which machine it is; give one of simulate")
    machine: ChamberMachine = of_kind(parse_machine(str(run.attrs["machine"])), CHAMBERS, "verdict")
    last = optional_argument("last", last, "s")
    notes = (*map(str, np.atleast_1d(run.attrs.get("remarks", []))), tilting_note(run))
    about: dict[str, Any] = {"notes": tuple(filter(None, notes)), "bodies": bodies_of(run)}
    try:
        steady = window(run, last)
    except QuestionError as reason:
        if last is not None:
            raise
        return Verdict(NO_VERDICT, stopped(run) or str(reason), **about)
    z, time, unbalance = _across(run, "body_position"), run["time"].values, abs(described[0])
    # what is said of the same machine without balls on the way
    about["without_held"] = held is None and not stopped(run) and bool(run.sizes["ball"])
    about["peak_without_balls"] = None if held is None else _peak(held, middle_deflection(held))
    if last is None and _speed_changes(run):
        last_speed, why = float(run["speed"].values[-1]), stopped(run) or UNDER_WAY
        return Verdict(NO_VERDICT, why, last_speed, unbalance=unbalance, peak=_peak(run, z), **about)
    static, rate = calm_mean(z[steady, None]), np.gradient(z, time)[steady, None]
    found = place_measures(z[steady, None], rate, static)
    speed = float(run["speed"].values[steady].mean())
    without = body_without_balancing(machine, speed)
    ratio = float(found.vibration[0]) / without if without > 0.0 else np.nan
    turning = balls_with_rotor(run, last)
    residual = float(residual_of_balls(run.isel(time=steady), *described)["static"].mean()) if turning.all() else np.nan
    mass = float(machine.rotor.mass) + float(run["ball_mass"].sum())
    # what turns with the rotor is judged, not a free vibration that dies away
    free, synchronous = _free_vibration(run, machine, z - static[0], steady) if turning.all() else ("", np.nan)
    if free:
        ratio = synchronous / without if without > 0.0 else np.nan
    left = "" if turning.all() else _free_left(run, machine, z - static[0], steady, without)
    word, because = _because(run, z - static[0], without, free, left, uneven=not turning.all())
    return Verdict(
        word=word or verdict_word(ratio),
        because=because or free,
        speed=speed,
        ratio=ratio,
        unbalance=unbalance,
        residual=residual,
        grade_before=grade_of(unbalance, mass, speed),
        grade_after=grade_of(residual, mass, speed),
        places=named(PlaceVerdict, [MIDDLE], np.abs(static), found.vibration, found.velocity_rms, np.array([without])),
        supports=_bearings(run.isel(time=steady)),
        peak=_peak(run, z - static[0]),
        settling=_settling(run, last),
        goes_round=not turning.all(),
        turning=(int(turning.sum()), turning.size),
        held_rotor=held_rotor(run, held_below(run)),
        **about,
    )


def middle_deflection(run: xr.Dataset) -> Complexes:
    """Of the middle of the rotor across its axis, y + i z over time, m: from its mean position at the end of the run.

    From the rest position of the machine without balls, if the speed still changes.
    """
    z = _across(run, "body_position")
    return z if _speed_changes(run) else z - calm_mean(z[window(run), None])[0]


def _speed_changes(run: xr.Dataset) -> bool:
    time = run["time"].values
    return speed_changes(time, run["speed"].values, float(time[-1]))


def _peak(run: xr.Dataset, away: Complexes) -> Peak:
    distance = np.abs(away)
    place = int(np.argmax(distance))
    return Peak(MIDDLE, float(distance[place]), float(run["speed"].values[place]))


def _turning(z: Complexes, angle: Floats) -> tuple[Complexes, float]:
    """What of x + i y turns with the rotor, either way: its course and its greatest size, m."""
    turn = np.exp(1j * angle)
    forward, backward = calm_mean((z / turn)[:, None])[0], calm_mean((z * turn)[:, None])[0]
    return forward * turn + backward / turn, float(abs(forward) + abs(backward))


def _free_vibration(run: xr.Dataset, machine: ChamberMachine, away: Complexes, steady: slice) -> tuple[str, float]:
    """A text where a free vibration still decays, else none; and the size of what turns with the rotor, m.

    It is all that does not turn with the rotor, where this becomes smaller at half of the rate of the slowest mode at least, or
    becomes smaller and is more than what does.
    """
    angle, time = run["rotor_angle"].values, run["time"].values
    before = slice(max(0, 2 * steady.start - steady.stop), steady.start)
    if before.stop - before.start < 2:
        return "", np.nan
    (_, turning), rest = _turning(away[steady], angle[steady]), []
    for part in (before, steady):
        still = away[part] - calm_mean(away[part, None])[0]
        rest.append(float(np.sqrt(np.mean(np.abs(still - _turning(still, angle[part])[0]) ** 2))))
    earlier, later = rest
    span = float(time[steady.stop - 1] - time[steady.start])
    if not later < (earlier if turning < later else earlier * np.exp(-0.5 * _slowest(machine)[1] * span)):
        return "", turning
    decay = span / np.log(earlier / later)
    return (
        f"a free vibration still decays, {length_text(later)} rms, to a third in {1.1 * decay:.2g} s, and does not count; "
        f"{length_text(turning)} turn with the rotor"
    ), turning


def _slowest(machine: ChamberMachine) -> tuple[float, float]:
    """The lowest critical speed (rad/s), and the lowest rate at which a free vibration decays (1/s); zeros of a fixed body."""
    critical, ratios = (np.array(values) for values in chamber_critical_speeds(machine))
    return (float(critical.min()), float((critical * ratios).min())) if critical.size else (0.0, 0.0)


def _free_left(run: xr.Dataset, machine: ChamberMachine, away: Complexes, steady: slice, without: float) -> str:
    """A text where the run-up can have left a free vibration that matters beside that ``without`` balls (m); else none.

    With balls that do not turn with the rotor it cannot be told from what they excite. So it is at most what does not turn with
    the rotor after the run-up, less what the damping of the slowest mode has taken since.
    """
    time, angle = run["time"].values, run["rotor_angle"].values
    (slowest, rate), since = _slowest(machine), end_of_run_up(time, run["speed"].values, float(time[0]))
    if not (slowest > 0.0 and without > 0.0):
        return ""
    # parts as long as a period of the slowest mode at least; what each allows at the begin of the steady state
    count = int(np.clip((time[-1] - time[0]) * slowest / (2.0 * np.pi), 2, TWENTIETHS))
    allowed = []
    for part in (*_parts(steady.start, count), steady):
        middle = 0.5 * (time[part.start] + time[part.stop - 1])
        if middle >= since or part is steady:
            still = away[part] - calm_mean(away[part, None])[0]
            rest = np.sqrt(2.0 * np.mean(np.abs(still - _turning(still, angle[part])[0]) ** 2))
            allowed.append(float(rest * np.exp(-rate * max(time[steady.start] - middle, 0.0))))
    size, least = min(allowed), LIMITS[0][0] * without
    if not size > least:
        return ""
    turning = _turning(away[steady], angle[steady])[1]
    more = (
        (time[steady.start] + np.log(size / least) / rate) * (time[-1] / time[steady.start]) if rate > 0.0 else np.nan
    )
    long = f"for about {significant(more, 2)} s" if np.isfinite(more) else "longer"
    return (
        f"a free vibration of up to {length_text(size)} may still decay; {length_text(turning)} turn with the rotor, "
        f"{share_text(turning / without)} of that without balls; run {long} (run.duration)"
    )


def _parts(end: int, count: int) -> list[slice]:
    """The samples up to ``end`` in ``count`` parts."""
    return [slice(*pair) for pair in itertools.pairwise(np.linspace(0, end, count + 1).astype(int))]


def _because(
    run: xr.Dataset, away: Complexes, without: float, free: str, left: str, *, uneven: bool
) -> tuple[str, str]:
    if unfinished := stopped(run):
        return NO_VERDICT, unfinished
    if not run.sizes["ball"]:
        return NO_VERDICT, "the machine has no balls"
    if not without > 0.0:
        return NO_VERDICT, (
            "the rotor has no unbalance"
            if without == 0.0
            else "the speed is a critical speed of a body without damping"
        )
    if left:
        return NOT_SETTLED, left
    time = run["time"].values
    middles, size = time, np.abs(away)
    if free:  # what turns with the rotor in each twentieth
        parts = _parts(time.size, TWENTIETHS)
        angle = run["rotor_angle"].values
        middles = np.array([0.5 * (time[part.start] + time[part.stop - 1]) for part in parts])
        size = np.array([_turning(away[part], angle[part])[1] for part in parts])
    end, low = float(time[-1]), np.zeros_like(middles)
    return unsteady(Course(end, True, time, run["speed"].values, uneven, middles, low, size), float(size[-1]), without)


def _across(run: xr.Dataset, name: str) -> Complexes:
    values = run[name].transpose("time", "axis", ...).values
    return np.asarray(values[:, 1] + 1j * values[:, 2], np.complex128)


def _bearings(steady: xr.Dataset) -> tuple[SupportVerdict, ...]:
    """Radial forces of the rotor on its bearings; what they would be without balls is not worked out."""
    force = -_across(steady, "bearing_force")
    mean = calm_mean(force)
    names = [f"bearing {int(number)}" for number in steady["bearing"].values]
    return named(SupportVerdict, names, np.abs(mean), np.abs(force - mean).max(axis=0), np.full(len(names), np.nan))


def _settling(run: xr.Dataset, last: float | None) -> Settling | None:
    settling = chamber_settling(run, last=last)
    if not settling.at.size:
        return None
    return last_settled(run["ball"].values, settling.at, settling.duration, settling.counted_from)

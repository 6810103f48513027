"""The verdict on a run of a deep chamber, by the rule and in the words of balls in races."""

from __future__ import annotations

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.laws.balance_quality import balance_grade
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.chamber.balls import ball_settling_time, balls_carried, residual_of_balls, window
from autobalancer.results.chamber.shape import bodies_of, unbalance_of
from autobalancer.results.of_a_run import of_a_run
from autobalancer.results.places import Complexes, moved
from autobalancer.results.standing import calm_mean
from autobalancer.results.verdict.judged import PlaceVerdict, SupportVerdict, Verdict
from autobalancer.results.verdict.passage import Peak, Settling
from autobalancer.results.verdict.rule import NO_VERDICT, Course, changing_because, speed_changes, verdict_word
from autobalancer.simulation.chamber.critical_speeds import body_without_balancing
from autobalancer.simulation.chamber.tilting import tilting_note
from autobalancer.units import optional_argument

MIDDLE = "middle of the rotor"


@of_a_run(runs="simulate_chamber")
def chamber_verdict(run: xr.Dataset, last: float | str | None = None) -> Verdict:
    """Whether a run of a deep chamber ends balanced, by the rule of balls in races.

    The vibration is the greatest distance of the middle of the rotor from its mean position, across the axis. That without
    balls is the steady one of the same body with the balls as masses in the middles of their chambers.

    A run whose speed still changes has no steady state: without ``last`` only its greatest deflection is said, from the rest
    position of the machine without balls.

    Parameters
    ----------
    run
        From ``simulate_chamber``, or an archive.
    last
        Seconds at the end that are the steady state; by default a tenth of the run.

    Raises
    ------
    QuestionError
        If there are too few samples, or the run does not say of which machine it is.
    """
    described = unbalance_of(run)
    if described is None:
        raise QuestionError("verdict: the run does not say of which machine it is; give one of simulate")
    machine = parse_machine(str(run.attrs["machine"]))
    assert isinstance(machine, ChamberMachine)
    last = optional_argument("last", last, "s")
    steady = window(run, last)
    z, time = _across(run, "body_position"), run["time"].values
    if last is None and _speed_changes(run):
        return _under_way(run, z, abs(described[0]))
    static, rate = calm_mean(z[steady, None]), np.gradient(z, time)[steady, None]
    vibration, _, velocity = moved(z[steady, None], rate, static)
    speed = float(run["speed"].values[steady].mean())
    without = body_without_balancing(machine, speed)
    ratio = float(vibration[0]) / without if without > 0.0 else np.nan
    residual = float(residual_of_balls(run.isel(time=steady), *described)["static"].mean())
    mass = float(machine.rotor.mass) + float(run["ball_mass"].sum())
    because = _because(run, z - static[0], without)
    return Verdict(
        word=NO_VERDICT if because else verdict_word(ratio),
        because=because,
        speed=speed,
        ratio=ratio,
        unbalance=abs(described[0]),
        residual=residual,
        grade_before=_grade(abs(described[0]), mass, speed),
        grade_after=_grade(residual, mass, speed),
        places=(PlaceVerdict(MIDDLE, float(abs(static[0])), float(vibration[0]), float(velocity[0]), without),),
        planes=(),
        supports=_bearings(run.isel(time=steady)),
        peak=_peak(run, z - static[0]),
        peak_without_balls=None,
        settling=_settling(run, last),
        notes=_notes(run),
        bodies=bodies_of(run),
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


def _under_way(run: xr.Dataset, z: Complexes, unbalance: float) -> Verdict:
    """Of a run whose speed still changes: how far it got from the rest position of the machine without balls."""
    because = "the speed still changes in the last twentieth of the run, which has no steady state; run longer"
    return Verdict(
        word=NO_VERDICT,
        because=_stopped(run) or because,
        speed=float(run["speed"].values[-1]),
        ratio=np.nan,
        unbalance=unbalance,
        residual=np.nan,
        grade_before=np.nan,
        grade_after=np.nan,
        places=(),
        planes=(),
        supports=(),
        peak=_peak(run, z),
        peak_without_balls=None,
        settling=None,
        notes=_notes(run),
        bodies=bodies_of(run),
    )


def _peak(run: xr.Dataset, away: Complexes) -> Peak:
    distance = np.abs(away)
    place = int(np.argmax(distance))
    return Peak(MIDDLE, float(distance[place]), float(run["speed"].values[place]))


def _notes(run: xr.Dataset) -> tuple[str, ...]:
    given = str(run.attrs["input_text"]).split("\n") if "input_text" in run.attrs else []
    return tuple(note for note in (*given, tilting_note(run)) if note)


def _stopped(run: xr.Dataset) -> str:
    outcome = run.attrs.get("outcome", "finished")
    return "" if outcome == "finished" else f"the run did not finish: {run.attrs.get('outcome_text', outcome)}"


def _because(run: xr.Dataset, away: Complexes, without: float) -> str:
    stopped = _stopped(run)
    if stopped:
        return stopped
    if not without > 0.0:
        return (
            "the rotor has no unbalance"
            if without == 0.0
            else "the speed is a critical speed of a body without damping"
        )
    time = run["time"].values
    uneven = not bool(balls_carried(run).all())
    return changing_because(
        Course(float(time[-1]), True, time, run["speed"].values, uneven, time, np.zeros_like(time), np.abs(away)),
        without,
    )


def _across(run: xr.Dataset, name: str) -> Complexes:
    values = run[name].transpose("time", "axis", ...).values
    return np.asarray(values[:, 1] + 1j * values[:, 2], np.complex128)


def _bearings(steady: xr.Dataset) -> tuple[SupportVerdict, ...]:
    """Radial forces of the rotor on its bearings; what they would be without balls is not worked out."""
    force = -_across(steady, "bearing_force")
    mean = calm_mean(force)
    greatest = np.abs(force - mean).max(axis=0)
    return tuple(
        SupportVerdict(f"bearing {int(number)}", float(abs(mean[i])), float(greatest[i]), np.nan)
        for i, number in enumerate(steady["bearing"].values)
    )


def _grade(unbalance: float, mass: float, speed: float) -> float:
    return balance_grade(unbalance, mass, abs(speed)) if speed != 0.0 else np.nan


def _settling(run: xr.Dataset, last: float | None) -> Settling | None:
    at = ball_settling_time(run, last=last).values
    if not at.size:
        return None
    moving = tuple(int(ball) for ball in run["ball"].values[np.isnan(at)])
    if len(moving) == at.size:
        return Settling(0, np.nan, "", np.nan, moving)
    slowest = int(np.nanargmax(at))
    return Settling(int(run["ball"].values[slowest]), float(at[slowest]), "start", float(at[slowest]), moving)

"""Basins of attraction: runs by the loop of ensembles, whose ends a rule names or the verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import any_machine
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.progress import shows_progress
from autobalancer.results.answers.studied import Ends
from autobalancer.stability.basins import unit_of_axis, why_unnamed
from autobalancer.studies.ensemble.start_grid import gridded_starts, named_ends
from autobalancer.studies.random_starts import random_starts
from autobalancer.units import argument, list_argument, optional_argument


@shows_progress
def basin(
    machine: Machine | str | Path,
    speed: float | str,
    axes: Mapping[str, Sequence[float | str] | str] | None = None,
    *,
    random: int = 0,
    seed: int = 0,
    acceleration: float | str | None = None,
    hold: float | str | None = None,
    tolerance: float = 1e-6,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Ends:
    """Ends of a machine at a speed, from many starts.

    Without gravity across the axis a machine ends in states of rest and motions that have names, on several planes also for
    each of them. With it, with forces on the balls, and in run-ups from random starts, an end is the verdict on the run.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; its unbalance is that after all schedules.
    speed
        Final rotor speed, rad/s. Where ends have names fluid that lags is modelled by diffusion, whatever the model of
        its race. It does not lag in starts at the final speed, and differs from start to start in run-ups.
    axes
        Up to two of ``ball_angle[i]`` (rad, balls counted from 1), ``ball_speed[i]`` or ``ball_speed`` of all balls
        (rad/s, in the rotor; minus the rotor speed is at rest in space), ``acceleration`` (rad/s^2: the run begins at
        rest with a ramp), each with its values or a range such as ``"-180:180 deg:60"``;
        of ball angles that end a whole turn after they begin the last is left out, since it is the first again. What is
        not varied is as in the machine; without an acceleration the rotor starts at ``speed``, undeflected.
    random
        Instead of axes: number of starts with random ball angles in the rotor.
    seed
        For random starts, and for balls without start angles. Where ends are verdicts, start i, from 0, has the ball
        angles of the seed ``seed + i``.
    acceleration
        Of all starts, rad/s^2: the run begins at rest with a ramp. With random starts the ends are verdicts then, and the
        peaks on the way are kept.
    hold
        Time at the final speed, s. Where ends have names: the longest; by default 400 revolutions or 25 decay times of the
        slowest mode of any stable state, and after a run-up of fluid that lags, whichever is longer. Where ends are verdicts:
        that of every run; by default 400 revolutions or 10 such decay times, without gravity. At most 20000 revolutions.
    tolerance
        As for :func:`autobalancer.simulate`.
    workers
        Threads; the result does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        ``state`` (number, its names in ``attrs["states"]``), ``residual_unbalance`` of unbalance and balls; ``share`` of each
        state with a 95 % interval (Wilson 1927) for random starts; ``residual_quantile`` (median, 95 %, greatest). Named ends:
        ``time`` until rest, ``final_deflection`` (of balls at rest the greatest in a turn, else at the last instant);
        quantiles over the starts that end at rest, of deflection too, and ``verdict_share``, by the rule of
        :mod:`autobalancer.results.verdict`; over ``plane``: ``plane_state`` (its names in ``attrs["plane_states"]``),
        ``plane_residual_unbalance``, its quantiles, and ``plane_unbalance`` without balls. Verdicts: ``vibration``,
        ``static_deflection`` and ``support_force`` of each run as of :func:`autobalancer.sweep`, ``vibration_quantile`` over
        all that finished; after run-ups ``peak_deflection`` and ``peak_quantile`` too. Random starts have
        ``start_ball_angle_in_rotor``, and the index of the worst, from 0, in ``attrs["worst"]``, for
        :func:`autobalancer.worst_start`.

    Raises
    ------
    QuestionError
        For deep chambers, unknown axes, no axes and no random starts, no balls.
    """
    speed, acceleration = argument("speed", speed, "rad/s"), optional_argument("acceleration", acceleration, "rad/s^2")
    hold = optional_argument("hold", hold, "s")
    machine = _plain(any_machine(machine))
    if not any(race.balls for balancer in machine.balancers for race in balancer.races):
        raise QuestionError("basin: the machine has no balls")
    for name, value, unit in (
        ("speed", speed, "rad/s"),
        ("acceleration", acceleration, "rad/s^2"),
        ("hold", hold, "s"),
    ):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise QuestionError(f"{name}: given {value!r}; must be greater than zero, in {unit}")
    chosen = {
        name: _once_round(name, list_argument(name, values, unit_of_axis(name)))
        for name, values in (axes or {}).items()
    }
    if bool(chosen) == bool(random) or len(chosen) > 2 or random < 0:
        raise QuestionError("basin: give one or two axes, or a number of random starts")
    if acceleration is not None and "acceleration" in chosen:
        raise QuestionError("basin: the acceleration is given twice, as an axis and as a number; leave out one")
    options: dict[str, Any] = {"seed": seed, "acceleration": acceleration, "hold": hold, "tolerance": tolerance}
    why = why_unnamed(machine)
    if not why and (chosen or acceleration is None):
        return Ends.of(named_ends(machine, speed, chosen, random=random, workers=workers, progress=progress, **options))
    if chosen:
        return Ends.of(gridded_starts(machine, speed, chosen, workers=workers, progress=progress, **options))
    return Ends.of(random_starts(machine, speed, random, workers=workers, progress=progress, **options))


def _once_round(name: str, values: list[float]) -> list[float]:
    """Places around a race without the last one, if that is the first again, so that shares count it once."""
    angles = name.startswith("ball_angle") and len(values) > 2
    return values[:-1] if angles and abs(abs(values[-1] - values[0]) - 2.0 * math.pi) < 1e-9 else values


def _plain(machine: Machine | ChamberMachine) -> Machine:
    if isinstance(machine, ChamberMachine):
        raise QuestionError(
            "basin: is for balls in races; here they move freely in chambers, and a seed draws their start. For 50 starts: "
            "autobalancer chamber amplitudes FILE --balls 20 --single none --friction 0.5 --duration '20 s' --seeds 50, with "
            "your numbers; in Python ab.chamber.amplitudes(..., seeds=range(50)). For one: autobalancer simulate FILE --seed 7"
        )
    return machine

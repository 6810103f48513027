"""Basins of attraction: runs by the loop of ensembles, whose ends a rule names or the verdict."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import xarray as xr

from autobalancer.assembly.guided_balls import has_forces
from autobalancer.assembly.places import gauges_of, places_of
from autobalancer.assembly.reduced_rotor import has_hardening, has_rubber
from autobalancer.assembly.system import start_angles, steady
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import any_machine
from autobalancer.kernels.integrators.integrator_state import END, STEP
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.many_members import STOP
from autobalancer.kernels.measures.record_series import COLUMN
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, Drive, Floats, Integers, Matrix, X, Y
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine_kinds import CHAMBERS, machine_kind
from autobalancer.memory import refuse_beyond_memory
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.results.answers.studied import Ends
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import long_steps, stepper_for
from autobalancer.stability.basins import (
    FAILED,
    NOT_RUN,
    RESTING,
    UNDECIDED,
    Question,
    ends_dataset,
    question_of,
    steadily,
    unit_of_axis,
)
from autobalancer.studies.ensemble.layout import PART, Bench, Group, Integration, Shared, run_threads
from autobalancer.studies.random_starts import verdict_starts
from autobalancer.units import argument, list_argument, optional_argument

# Starts whose ends have names: runs by the loop of ensembles, looked at again and again until their balls rest.


_AXIS = re.compile(r"ball_angle\[\d+\]|ball_speed(\[\d+\])?|acceleration")
FIRST, GROWTH = 1.0 / 64.0, 1.25  # first look, over the hold; time of a look over that of the one before
AGAIN, LONGER = 1.0 / 256.0, 1.6  # balls that rested are looked at again this soon, then after longer whiles
LOOKS = 4  # in a row at which balls rest that are at rest
WINDOW = 0.25  # the last part of a hold, over which motion is judged
INSTANTS = 800  # of the window, at random, so that no motion has their beat
LEAST, MOST = 8, 512  # starts that a thread takes from look to look at once
STEPS = 100_000_000  # of one run between two looks


def classify_ends(
    machine: Machine,
    speed: float,
    axes: Mapping[str, Sequence[float]],
    *,
    random: int,
    seed: int,
    acceleration: float | None,
    hold: float | None,
    tolerance: float,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
) -> xr.Dataset:
    """End states of a machine without gravity across its axis; the arguments are those of :func:`autobalancer.basin`."""
    ramp = bool(acceleration or "acceleration" in axes)
    question = question_of(machine, speed, hold, tolerance, seed, ramp=ramp)
    starts, rates, shape = _starts_of(question, axes, random, seed, acceleration)
    work = Settling(question, starts, rates)
    run_threads(work, min(workers or os.cpu_count() or 1, len(starts)), 0, len(starts), progress)
    return ends_dataset(question, axes, shape, starts, work.ends, seed, acceleration)


def _starts_of(
    question: Question, axes: Mapping[str, Sequence[float]], random: int, seed: int, acceleration: float | None
) -> tuple[Matrix, Floats, tuple[int, ...]]:
    """States (k, size), rates of a ramp from rest (k,), 0 without one, and the shape of the map."""
    n, speed = question.st.moment.size, question.speed
    values = [np.asarray(v, np.float64) for v in axes.values()]
    shape = tuple(v.size for v in values) if axes else (random,)
    count = math.prod(shape)
    refuse_beyond_memory("basin", count, "starts", 16.0 * question.assembly.state.size + 400.0, "; ask for fewer")
    # at rest in the middle, or, on a ramp, before it has begun
    first = question.assembly.state.copy()
    first[[X, Y, VX, VY, THETA]] = 0.0
    if question.assembly.general:
        first[BALLS + 2 * n : 2 + 2 * question.assembly.places.shape[2] + 2 * n] = 0.0  # the other coordinates
    first[SPEED] = 0.0 if acceleration or "acceleration" in axes else speed
    # without axes the balls begin anywhere on their races
    starts, rates = np.tile(first, (count, 1)), np.full(count, acceleration or 0.0)
    if not axes:
        drawn = generator(seed)
        balls = question.assembly.balls
        starts[:, BALLS : BALLS + n] = [start_angles(balls, drawn, given=False) for _ in range(count)]
    # with axes each of them sets one number of the start
    for name, grid in zip(axes, np.meshgrid(*values, indexing="ij"), strict=True):
        column = grid.ravel()
        kind, _, ball = name.partition("[")
        if kind == "acceleration":
            rates[:] = column
        elif not ball:
            starts[:, BALLS + n : BALLS + 2 * n] = column[:, None]
        else:
            starts[:, BALLS + n * (kind == "ball_speed") + int(ball.rstrip("]")) - 1] = column
    return starts, rates, shape


class Runs:
    """Runs of a machine with a drive, each from its own state and for its own time, at most ``longest``, s.

    ``state`` is any from which they may start; states at the ``instants`` of a run are kept.
    """

    def __init__(
        self, question: Question, drive: Drive, state: Floats, longest: float, instants: Floats | None = None
    ) -> None:
        assembly = replace(question.assembly, system=steadily(question.assembly.system, drive), state=state)
        stepper = stepper_for(assembly, longest, question.tolerance)
        if stepper.long is not None and len(drive.segments) == 1:
            stepper = stepper._replace(long=long_steps(assembly, stepper.memory, near=question.speed))
        long = (stepper.long.memory, stepper.long.amplitudes) if stepper.long is not None else ()
        record = record_for(() if instants is None else [SampleTimes(instants.tolist())], (), assembly, longest)
        gauges = gauges_of(assembly, places_of(question.machine, assembly), centered=True)
        integration = Integration(assembly.system, record, stepper.memory, gauges, long)
        self._group = Group(integration, stepper, len(assembly.balls))
        layout = self._group.layout
        own = [layout.place(f"memory.{name}", i) for name in ("state", "start") for i in range(state.size)]
        self._places = [*own, layout.place("memory.clock", END), layout.place("memory.clock", STEP)]

    def bench(self) -> Bench:
        """A place for one thread."""
        return self._group.bench()

    def segment(self, number: int, field: str) -> int:
        """Where a number of the drive is."""
        return self._group.layout.place("system.drive.segments", number, field=field)

    def run(
        self,
        bench: Bench,
        flags: Integers,
        states: Matrix,
        times: Floats,
        steps: Floats | float = 0.0,
        own: Mapping[int, Floats] | None = None,
    ) -> tuple[Matrix, Any, Floats]:
        """The states at the ends, which runs finished, and their mean steps, s.

        ``steps`` are the first ones, 0 where nothing is known; ``own`` other numbers of each run by where they are.
        """
        places = np.array([*self._places, *(own or {})], np.int64)
        first = np.broadcast_to(steps, times.shape)
        words = np.column_stack([states, states, times, first, *(own or {}).values()]).view(np.int64)
        room = self._group.room(True, len(states))
        bench.run(self._group.fresh, places, words, STEPS, flags, room)
        return room.states, room.rows[:, COLUMN.status] == FINISHED, times / np.maximum(room.counts[:, 0], 1)


class Settling(Shared):
    """Many starts; ``ends`` are as ``end_states`` wants them."""

    def __init__(self, question: Question, starts: Matrix, rates: Floats) -> None:
        super().__init__(len(starts))
        self._question, self._starts, self._rates = question, starts, rates
        count, n = len(starts), question.st.moment.size
        self.ends = np.zeros((count, starts.shape[1] + 2 + 2 * n))
        self.ends[:, starts.shape[1]] = NOT_RUN
        held, unbalance = starts[0].copy(), question.st.unbalance
        held[SPEED] = question.speed
        drive = steady(question.speed, unbalance)
        self._held = Runs(question, drive, held, question.hold)
        instants = np.unique(generator(0).uniform(0.0, WINDOW * question.hold, INSTANTS))
        self._window = Runs(question, drive, held, question.hold, instants)
        self._ramp: Runs | None = None
        if rates.any():
            ramps = question.speed / rates
            drive = drive._replace(segments=np.concatenate([drive.segments] * 2).view(np.recarray))
            drive.segments[0].value, drive.segments[0].rate, drive.segments[1].start = 0.0, rates[0], ramps[0]
            self._ramp = Runs(question, drive, starts[0], float(ramps.max()))

    def done(self) -> int:
        """How many starts are done."""
        return int((self.ends[:, self._starts.shape[1]] != NOT_RUN).sum())

    def bench(self) -> dict[Runs, Bench]:
        """A place for one thread."""
        return {runs: runs.bench() for runs in (self._ramp, self._held, self._window) if runs is not None}

    def size(self, left: int) -> int:
        """As many as take some looks, and no more than a thread's share of what is left."""
        size = min(MOST, max(int(5.0 * PART / self._each), LEAST)) if self._each > 0.0 else LEAST
        return min(size, max(-(-left // len(self.flags)), LEAST))

    def run(self, part: range, bench: dict[Runs, Bench], flags: Any) -> None:
        """Run some starts to their ends; those that are stopped before have none."""
        numbers = np.arange(part.start, part.stop)
        states, ramps = self._starts[numbers], np.zeros(numbers.size)
        if self._ramp is not None:
            ramp, rates = self._ramp, self._rates[numbers]
            ramps = self._question.speed / rates
            own = {ramp.segment(0, "rate"): rates, ramp.segment(1, "start"): ramps}
            states, finished, _ = ramp.run(bench[ramp], flags, states, ramps, own=own)
            states[:, SPEED] = self._question.speed
            if flags[STOP]:
                return
            for i in np.flatnonzero(~finished):
                self._end(part.start + int(i), states[i], FAILED, float(ramps[i]))
            there = np.flatnonzero(finished)
        else:
            there = np.arange(len(states))
        self._settle(part.start + there, states[there], ramps[there], bench, flags)

    def _settle(
        self, numbers: Integers, states: Matrix, ramps: Floats, benches: Mapping[Runs, Bench], flags: Integers
    ) -> None:
        """Look at starts from time to time until each has its end."""
        q, n = self._question, self._question.st.moment.size
        last = (1.0 - WINDOW) * q.hold
        now, steps, quiet = np.zeros(len(numbers)), np.zeros(len(numbers)), np.zeros(len(numbers), np.int64)
        while numbers.size:
            again = now + AGAIN * LONGER**quiet * q.hold
            then = np.minimum(np.where(quiet > 0, again, np.maximum(GROWTH * now, FIRST * q.hold)), last)
            states, finished, steps = self._held.run(benches[self._held], flags, states, then - now, steps)
            if flags[STOP]:
                return
            rests = (np.abs(states[:, BALLS + n : BALLS + 2 * n]) <= q.rest).all(axis=1) & (then >= q.earliest)
            now, quiet = then, np.where(rests, quiet + 1, 0)
            over = ~finished | (quiet >= LOOKS) | (now >= last)
            for i in np.flatnonzero(over):
                if finished[i] and quiet[i] < LOOKS:
                    self._watch(int(numbers[i]), states[i], float(ramps[i]), benches[self._window], flags)
                else:
                    self._end(int(numbers[i]), states[i], RESTING if finished[i] else FAILED, float(ramps[i] + now[i]))
            left = ~over
            numbers, states, ramps = numbers[left], states[left], ramps[left]
            now, steps, quiet = now[left], steps[left], quiet[left]

    def _watch(self, number: int, state: Floats, ramp: float, bench: Bench, flags: Integers) -> None:
        """How the balls of one start move in the last part of the hold."""
        q, n = self._question, self._question.st.moment.size
        window = WINDOW * q.hold
        states, finished, _ = self._window.run(bench, flags, state[None, :], np.array([window]))
        if flags[STOP]:
            return
        seen = np.vstack([state, bench.record.samples, states])[:, BALLS : BALLS + n]
        verdict = UNDECIDED if finished[0] else FAILED
        motion = np.concatenate([(seen[-1] - seen[0]) / window, np.ptp(seen, axis=0)])
        self._end(number, states[0], verdict, ramp + q.hold, motion)

    def _end(self, number: int, state: Floats, verdict: float, at: float, motion: Floats | float = 0.0) -> None:
        size, row = state.size, self.ends[number]
        row[:size], row[size + 1], row[size + 2 :] = state, at, motion
        row[size] = verdict


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
        quantiles over the ``quantile_starts`` that end at rest, of deflection too, and ``verdict_share``, by the rule of
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
    _refuse_axes(chosen, len(resolve(machine)))
    # ends have names where balls come to rest in the rotor: no gravity in its plane, no forces that may hold them elsewhere;
    # and where states of small motions are those of large ones: no rubber that softens, no bearing that hardens
    falls = machine.axis == "horizontal" and machine.gravity > 0.0
    named = not (falls or has_rubber(machine) or has_hardening(machine) or has_forces(machine))
    return Ends.of(
        (classify_ends if named and (chosen or acceleration is None) else verdict_starts)(
            machine,
            speed,
            chosen,
            random=random,
            seed=seed,
            acceleration=acceleration,
            hold=hold,
            tolerance=tolerance,
            workers=workers,
            progress=progress,
        )
    )


def _once_round(name: str, values: list[float]) -> list[float]:
    """Places around a race without the last one, if that is the first again, so that shares count it once."""
    angles = name.startswith("ball_angle") and len(values) > 2
    return values[:-1] if angles and abs(abs(values[-1] - values[0]) - 2.0 * math.pi) < 1e-9 else values


def _plain(machine: Machine | ChamberMachine) -> Machine:
    if machine_kind(machine) is CHAMBERS:
        raise QuestionError(
            "basin: is for balls in races; here they move freely in chambers, and a seed draws their start. For 50 starts: "
            "autobalancer chamber amplitudes FILE --balls 20 --single none --friction 0.5 --duration '20 s' --seeds 50, with "
            "your numbers; in Python ab.chamber.amplitudes(..., seeds=range(50)). For one: autobalancer simulate FILE --seed 7"
        )
    return cast(Machine, machine)


def _refuse_axes(axes: Mapping[str, Sequence[float]], balls: int) -> None:
    """Refuse axes over starts that a machine with so many balls does not have.

    Raises
    ------
    QuestionError
        It says which there are.
    """
    for name, values in axes.items():
        ball = name.partition("[")[2].rstrip("]")
        if not _AXIS.fullmatch(name) or (ball and not 1 <= int(ball) <= balls):
            raise QuestionError(
                f"basin: no axis {name!r}; there are ball_angle[1] to ball_angle[{balls}], ball_speed[i], ball_speed, "
                "acceleration"
            )
        if not len(values) or not np.all(np.isfinite(values)):
            raise QuestionError("basin: each axis needs a list of finite numbers")
        if name == "acceleration" and min(values) <= 0.0:
            raise QuestionError("basin: an acceleration must be greater than zero")

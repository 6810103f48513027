"""Starts whose ends have names: runs by the loop of ensembles, looked at again and again until their balls rest."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from threading import Lock
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.drive import steady
from autobalancer.assembly.gauges import gauges_of
from autobalancer.assembly.places import places_of
from autobalancer.kernels.ensemble.members import STOP
from autobalancer.kernels.integrators.memory import END, STEP
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.measures.columns import STATUS
from autobalancer.kernels.system import BALLS, SPEED, Drive, Floats, Integers, Matrix
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from autobalancer.simulation.long_steps import long_steps
from autobalancer.simulation.record import record_for
from autobalancer.simulation.sampling import SampleTimes
from autobalancer.simulation.steppers import stepper_for
from autobalancer.stability.basins.basin import ends_dataset, question_of
from autobalancer.stability.basins.end_states import FAILED, NOT_RUN, RESTING, UNDECIDED, Question
from autobalancer.stability.basins.starts import starts_of
from autobalancer.stability.basins.unbalanced import steadily
from autobalancer.studies.ensemble.execute import PART, run_threads
from autobalancer.studies.ensemble.groups import Group
from autobalancer.studies.ensemble.integration import Bench, Found, Integration

FIRST, GROWTH = 1.0 / 64.0, 1.25  # first look, over the hold; time of a look over that of the one before
AGAIN, LONGER = 1.0 / 256.0, 1.6  # balls that rested are looked at again this soon, then after longer whiles
LOOKS = 4  # in a row at which balls rest that are at rest
WINDOW = 0.25  # the last part of a hold, over which motion is judged
INSTANTS = 800  # of the window, at random, so that no motion has their beat
LEAST, MOST = 8, 512  # starts that a thread takes from look to look at once
STEPS = 100_000_000  # of one run between two looks


def named_ends(
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
    starts, rates, shape = starts_of(question, axes, random, seed, acceleration)
    work = Settling(question, starts, rates)
    run_threads(work, min(workers or os.cpu_count() or 1, len(starts)), 0, len(starts), progress)
    return ends_dataset(question, axes, shape, starts, work.ends, seed, acceleration)


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
        one = Integration(assembly.system, record, stepper.memory, gauges, long)
        self._group = Group(one, stepper, len(assembly.balls))
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
        found = Found.room(len(states), self._group.balls, states.shape[1])
        bench.run(self._group.fresh, places, words, range(len(states)), STEPS, flags, found)
        return found.states, found.rows[:, STATUS] == FINISHED, times / np.maximum(found.counts[:, 0], 1)


class Settling:
    """Many starts in parts, which threads take one after the other; ``ends`` are as ``end_states`` wants them."""

    def __init__(self, question: Question, starts: Matrix, rates: Floats) -> None:
        self.flags: list[Any] = []
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
        self._next, self._lock, self._each = 0, Lock(), 0.0

    def done(self) -> int:
        """How many starts are done."""
        return int((self.ends[:, self._starts.shape[1]] != NOT_RUN).sum())

    def stop(self) -> None:
        """Let all threads stop at their next look."""
        for flags in self.flags:
            flags[STOP] = 1

    def _parts(self) -> Iterator[slice]:
        count = len(self._starts)
        while True:
            with self._lock:
                size = min(MOST, max(int(5.0 * PART / self._each), LEAST)) if self._each > 0.0 else LEAST
                share = max(-(-(count - self._next) // len(self.flags)), LEAST)
                part = slice(self._next, min(self._next + min(size, share), count))
                self._next = part.stop
            if part.start == part.stop:
                return
            yield part

    def thread(self, flags: Any, look: Callable[[], None] | None = None) -> None:
        """Work until nothing is left; ``look`` is called between two parts."""
        benches = {runs: runs.bench() for runs in (self._ramp, self._held, self._window) if runs is not None}
        for part in self._parts():
            begin = time.thread_time()
            self._run_up_and_settle(part, benches, flags)
            with self._lock:
                self._each = (time.thread_time() - begin) / (part.stop - part.start)
            if look is not None:
                look()
            if flags[STOP]:
                return

    def _run_up_and_settle(self, part: slice, benches: Mapping[Runs, Bench], flags: Integers) -> None:
        """Run some starts to their ends; those that are stopped before have none."""
        states, ramps = self._starts[part], np.zeros(part.stop - part.start)
        if self._ramp is not None:
            ramp, rates = self._ramp, self._rates[part]
            ramps = self._question.speed / rates
            own = {ramp.segment(0, "rate"): rates, ramp.segment(1, "start"): ramps}
            states, finished, _ = ramp.run(benches[ramp], flags, states, ramps, own=own)
            states[:, SPEED] = self._question.speed
            if flags[STOP]:
                return
            for i in np.flatnonzero(~finished):
                self._end(part.start + int(i), states[i], FAILED, float(ramps[i]))
            there = np.flatnonzero(finished)
        else:
            there = np.arange(len(states))
        self._settle(part.start + there, states[there], ramps[there], benches, flags)

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

"""A run in progress: its numbers, its first energy, and the next samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.chamber import assemble_chamber
from autobalancer.errors import QuestionError
from autobalancer.kernels.chamber.chamber import CHANGED, DESCRIBED, Chamber, Samples
from autobalancer.kernels.chamber.records import LOST_BALLS, TOO_DENSE
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.dataset import chamber_dataset
from autobalancer.simulation.chamber.energy import total_energy
from autobalancer.simulation.chamber.filling import fill
from autobalancer.simulation.chamber.sampling import room_for, sample_now
from autobalancer.simulation.chamber.settle import settled

Array = Any
AT_ONCE = 0.1  # s of computing, after which Ctrl-C and other threads get their turn
OF_A_BALL = 30e-9  # s that its step takes, about


class March:
    """Takes a machine's balls from sample to sample."""

    def __init__(self, machine: ChamberMachine, chamber: Chamber, every: int, method: str, energy: float) -> None:
        self.machine, self.chamber, self.every, self.method = machine, chamber, every, method
        self.first_energy = energy
        self.failure: tuple[str, str] | None = None
        self.interrupted = False

    @property
    def samples(self) -> int:
        """Samples passed since time 0, not counting that one."""
        return int(self.chamber.progress.steps) // self.every

    def first(self) -> xr.Dataset:
        """The sample of the state as it is, with reactions of this instant."""
        return self._labeled(self.samples, sample_now(self.chamber), 1)

    def take(self, count: int, passed: Callable[[int], Any] | None = None) -> xr.Dataset:
        """The next ``count`` samples; fewer if the motion grew without limit, which ``failure`` then says, or ``interrupted``.

        ``passed`` is called with the samples since time 0 several times in a second. If it raises ``KeyboardInterrupt``, or
        Ctrl-C does, what was computed is answered.
        """
        done = self.samples
        samples = room_for(self.chamber, count, self.every)
        at_once = max(round(AT_ONCE / (self.every * len(self.chamber.balls) * OF_A_BALL)), 1)
        try:
            for first in range(0, count, at_once):
                some = slice(first, first + at_once)
                _advance(self.method, self.chamber, Samples(self.every, samples.rows[some], samples.balls[some]))
                if self.chamber.progress.trouble:
                    break
                if passed is not None:
                    passed(self.samples)
        except KeyboardInterrupt:
            self.interrupted = True
        got = self.samples - done
        finite = _finite(samples)[:got]
        trouble = self.chamber.progress.trouble
        if trouble == TOO_DENSE:
            self.failure = (
                "too dense",
                "more balls came close to each other than is possible; the contacts are too soft",
            )
        if trouble == LOST_BALLS or not finite.all():
            got = got if finite.all() else int(np.argmin(finite))
            self.failure = ("not finite", "the motion grew without limit; shorten the step, check masses and stiffness")
        return self._labeled(done + 1, samples, got)

    def checkpoint(self) -> dict[str, Array]:
        """Arrays from which the run goes on to the last bit."""
        return {
            **{name: np.asarray(value).copy() for name, value in _kept(self.chamber).items()},
            "first_energy": np.array(self.first_energy),
            "every": np.array(self.every),
            "method": np.array(self.method),
        }

    def _labeled(self, start: int, samples: Samples, count: int) -> xr.Dataset:
        times = (start + np.arange(count)) * self.every * self.chamber.run.step
        return chamber_dataset(
            self.machine, self.chamber, times, samples.rows[:count], samples.balls[:count], self.first_energy
        )


def _finite(samples: Samples) -> Array:
    """Whether all numbers of a sample are, (k,)."""
    found = np.ones(len(samples.rows), bool)
    for rows in (samples.rows, samples.balls):
        for name in rows.dtype.names:
            found &= np.isfinite(rows[name].reshape(len(found), -1)).all(axis=1)
    return found


def begin(
    machine: ChamberMachine,
    step: float,
    every: int,
    method: str,
    seed: int,
    settle: bool,
    waiting: Callable[[], Any] | None = None,
) -> March:
    """A run at time 0; ``waiting`` is called again and again while the balls settle."""
    from autobalancer.kernels.chamber.verlet import start

    positions, filled = fill(machine, seed)
    if filled and settle:
        positions = settled(machine, positions, step, waiting)
    chamber = assemble_chamber(machine, positions, step)
    start(chamber)
    return March(machine, chamber, every, method, total_energy(chamber))


def restore(machine: ChamberMachine, step: float, every: int, held: dict[str, Array]) -> March:
    """The run of a checkpoint.

    Raises
    ------
    QuestionError
        If it is of another machine, step, sample or method.
    """
    total = sum(balls.count for chamber in machine.chambers for balls in chamber.balls)
    chamber = assemble_chamber(machine, np.zeros((total, 3)), step)
    asked = _kept(chamber)
    if missing := (set(asked) | {"first_energy", "every", "method"}) - set(held):
        raise QuestionError(
            f"resume: not a checkpoint of a chamber run of this version; it lacks {', '.join(sorted(missing))}"
        )
    same = all(_alike(held[name], value) for name, value in asked.items())
    if not same or any(held[name].size != 1 for name in ("first_energy", "every", "method")):
        raise QuestionError(
            "resume: the checkpoint is damaged or belongs to another machine; resume it with its own machine file"
        )
    before = float(held["run"]["step"])
    if int(held["every"]) != every or before != step:
        raise QuestionError(
            f"resume: the checkpoint has steps of {before:.17g} s, {int(held['every'])} to a sample; "
            f"asked for {step:.17g} s, {every} to a sample. Give the step and sample of that run"
        )
    if not all(np.array_equal(held[name], np.asarray(asked[name])) for name in DESCRIBED):
        raise QuestionError("resume: the checkpoint belongs to another machine; resume it with its own machine file")
    for name, value in asked.items():
        _fill(value, held[name])
    return March(machine, chamber, every, str(held["method"]), float(held["first_energy"]))


def _kept(chamber: Chamber) -> dict[str, Any]:
    """What describes a run and what it changes, by name."""
    kept = {name: getattr(chamber, name) for name in DESCRIBED + CHANGED if name != "pairs"}
    return kept | {f"pairs_{name}": value for name, value in chamber.pairs._asdict().items()}


def _alike(found: Array, asked: Any) -> bool:
    """Whether an array has the form of the one asked for."""
    return bool(found.dtype == asked.dtype and found.shape == asked.shape)


def _fill(target: Any, source: Array) -> None:
    if target.shape == ():
        for name in target.dtype.names:
            target[name] = source[name]
    else:
        target[...] = source


def _advance(method: str, chamber: Chamber, samples: Samples) -> None:
    if method == "runge_kutta":
        from autobalancer.kernels.chamber.runge_kutta import runge_kutta

        runge_kutta(chamber, samples)
        return
    from autobalancer.kernels.chamber.verlet import verlet

    verlet(chamber, samples, 1.0)

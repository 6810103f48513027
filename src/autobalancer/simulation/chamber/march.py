"""A run in progress: its arrays, its first energy, and the next samples."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.chamber import ChamberNumbers, assemble_chamber
from autobalancer.errors import QuestionError
from autobalancer.kernels.chamber import layout as at
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.dataset import chamber_dataset
from autobalancer.simulation.chamber.energy import total_energy
from autobalancer.simulation.chamber.filling import fill
from autobalancer.simulation.chamber.settle import settled

Array = Any
DESCRIBED = ("number", "chambers", "pair_stiffness", "inertia", "stiffness", "damping", "active", "profile")


class March:
    """Takes a machine's balls from sample to sample."""

    def __init__(
        self, machine: ChamberMachine, numbers: ChamberNumbers, every: int, method: str, energy: float
    ) -> None:
        self.machine, self.numbers, self.every, self.method = machine, numbers, every, method
        self.first_energy = energy
        self.failure: tuple[str, str] | None = None

    @property
    def samples(self) -> int:
        """Samples passed since time 0, not counting that one."""
        return int(self.numbers.counts[at.STEPS_DONE]) // self.every

    def first(self) -> xr.Dataset:
        """The sample of the state as it is, with reactions of this instant."""
        from autobalancer.kernels.chamber.samples import SAMPLE, note_sample

        p = self.numbers
        row, balls = np.zeros((1, SAMPLE)), np.zeros((1, p.balls.shape[0], 9))
        sums = np.concatenate([p.host[at.P1 : at.P1 + 6], p.host[at.CONSTRAINT : at.CONSTRAINT + 6]])
        note_sample(
            p.balls, p.chambers, p.host, sums, p.counts.copy(), p.greatest.copy(), p.power, 1.0, row[0], balls[0]
        )
        return self._labeled(self.samples, row, balls, p.ledger[None].copy())

    def take(self, count: int) -> xr.Dataset:
        """The next ``count`` samples; fewer if the motion grew without limit, which ``failure`` then says."""
        from autobalancer.kernels.chamber.samples import SAMPLE

        p = self.numbers
        rows, balls = np.zeros((count, SAMPLE)), np.zeros((count, p.balls.shape[0], 9))
        ledgers = np.zeros((count, at.POWERS))
        done = self.samples
        arrays = [getattr(p, field.name) for field in fields(p)]
        _advance(self.method, count * self.every, self.every, *arrays, rows, balls, ledgers)
        got = self.samples - done
        finite = np.isfinite(rows[:got]).all(axis=1) & np.isfinite(balls[:got]).all(axis=(1, 2))
        if p.counts[at.OVERFLOW] == at.TOO_DENSE:
            self.failure = (
                "too dense",
                "more balls came close to each other than is possible; the contacts are too soft",
            )
        if p.counts[at.OVERFLOW] == at.LOST_BALLS or not finite.all():
            got = got if finite.all() else int(np.argmin(finite))
            self.failure = ("not finite", "the motion grew without limit; shorten the step, check masses and stiffness")
        return self._labeled(done + 1, rows[:got], balls[:got], ledgers[:got])

    def checkpoint(self) -> dict[str, Array]:
        """Arrays from which the run goes on to the last bit."""
        return {
            **self.numbers.checkpoint(),
            "first_energy": np.array(self.first_energy),
            "every": np.array(self.every),
            "method": np.array(self.method),
        }

    def _labeled(self, start: int, rows: Array, balls: Array, ledgers: Array) -> xr.Dataset:
        times = (start + np.arange(len(rows))) * self.every * self.numbers.number[at.STEP]
        return chamber_dataset(self.machine, self.numbers, times, rows, balls, ledgers, self.first_energy)


def begin(machine: ChamberMachine, step: float, every: int, method: str, seed: int, settle: bool) -> March:
    """A run at time 0."""
    positions, filled = fill(machine, seed)
    if filled and settle:
        positions = settled(machine, positions, step)
    numbers = assemble_chamber(machine, positions, step)
    evaluate_first(numbers)
    return March(machine, numbers, every, method, float(total_energy(machine, numbers)))


def evaluate_first(p: ChamberNumbers) -> None:
    """The rates of the first step."""
    from autobalancer.kernels.chamber.verlet import start

    skip = {"ledger"}
    evaluate: Any = start
    evaluate(*[getattr(p, field.name) for field in fields(p) if field.name not in skip])


def restore(machine: ChamberMachine, step: float, every: int, held: dict[str, Array]) -> March:
    """The run of a checkpoint.

    Raises
    ------
    QuestionError
        If it is of another machine, step, sample or method.
    """
    names = {field.name for field in fields(ChamberNumbers)}
    if missing := (names | {"first_energy", "every", "method"}) - set(held):
        raise QuestionError(f"resume: not a checkpoint of a chamber run; it lacks {', '.join(sorted(missing))}")
    total = sum(balls.count for chamber in machine.chambers for balls in chamber.balls)
    asked = assemble_chamber(machine, np.zeros((total, 3)), step)
    numbers = ChamberNumbers(**{name: np.array(held[name], order="C") for name in names})
    same = all(_alike(getattr(numbers, name), getattr(asked, name)) for name in names)
    if not same or any(held[name].size != 1 for name in ("first_energy", "every", "method")):
        raise QuestionError(
            "resume: the checkpoint is damaged or belongs to another machine; resume it with its own machine file"
        )
    if int(held["every"]) != every or float(numbers.number[at.STEP]) != step:
        raise QuestionError(
            f"resume: the checkpoint has steps of {numbers.number[at.STEP]:.17g} s, {int(held['every'])} to a sample; "
            f"asked for {step:.17g} s, {every} to a sample. Give the step and sample of that run"
        )
    if not all(np.array_equal(getattr(numbers, name), getattr(asked, name)) for name in DESCRIBED):
        raise QuestionError("resume: the checkpoint belongs to another machine; resume it with its own machine file")
    return March(machine, numbers, every, str(held["method"]), float(held["first_energy"]))


def _alike(found: Array, asked: Array) -> bool:
    """Whether an array may be given to compiled code that trusts its form."""
    return bool(found.dtype == asked.dtype and found.shape == asked.shape)


def _advance(method: str, steps: int, every: int, *arrays: Array) -> None:
    if method == "runge_kutta":
        from autobalancer.kernels.chamber.runge_kutta import runge_kutta

        march: Any = runge_kutta
        march(steps, every, *arrays, np.zeros((2, 9 * len(arrays[0]) + 14)))
        return
    from autobalancer.kernels.chamber.verlet import verlet

    advance: Any = verlet
    advance(steps, every, *arrays)

"""What a study asks: the machine, what varies and how, how many draws, what is wanted, when to stop."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import product
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.study.distributions import Distribution, joined
from autobalancer.studies.study.samples import Plan, correlated, drawn_again, shares
from autobalancer.studies.study.stopping import Stop
from autobalancer.studies.study.sudden import Sudden

START = "start"  # what the random starts of the balls are called where inputs are named
Impossible = Literal["refuse", "truncate", "record"]


@dataclass(frozen=True)
class Study:
    """A study, read and checked; numbers in SI.

    ``grid`` are the parameters whose values are all run with every draw; ``scatter`` those that are drawn. A member is a draw at
    a point of the grid: member ``draw * points + point``, counted from 0.
    """

    machine: Machine
    name: str
    grid: dict[str, list[Any]]
    scatter: dict[str, Distribution]
    correlation: dict[tuple[str, str], float]
    members: int  # draws at each point; base samples with the plan "sensitivity"
    plan: Plan
    seed: int
    random_starts: bool
    duration: float
    tolerance: float
    bins: int
    results: tuple[str, ...]
    impossible: Impossible
    stop: Stop | None = None
    show: tuple[str, ...] = ()  # quantities of the table; none: the usual ones
    base: Machine | None = None  # as it was given, where the study drives it in its own way
    sudden: Sudden | None = None  # with an unbalance of the machine that appears at speed
    settling_from: str = SETTLING_FROM[0]
    written: dict[str, Any] = field(default_factory=dict)  # as the user wrote it

    @property
    def inputs(self) -> list[str]:
        """What is drawn, in order; random starts last."""
        return [*self.scatter, *([START] if self.random_starts else [])]

    @property
    def draws(self) -> int:
        """Draws at each point of the grid, at most."""
        return self.members * (len(self.inputs) + 2) if self.plan == "sensitivity" else self.members

    @property
    def points(self) -> list[tuple[Any, ...]]:
        """Points of the grid; a single empty one without a grid."""
        return list(product(*self.grid.values()))

    @property
    def count(self) -> int:
        """Members in all, at most."""
        return self.draws * math.prod(map(len, self.grid.values()))

    def identity(self) -> dict[str, Any]:
        """What makes it this study and no other, as plain data."""
        return {
            "machine": machine_text(self.machine),
            "grid": {name: [str(value) for value in values] for name, values in self.grid.items()},
            "scatter": {name: [one.word, repr(one), str(one)] for name, one in self.scatter.items()},
            "correlation": [[*pair, value] for pair, value in self.correlation.items()],
            "plan": self.plan,
            "seed": self.seed,
            "starts": "random" if self.random_starts else "machine",
            "duration": self.duration,
            "tolerance": self.tolerance,
            "bins": self.bins,
            "results": list(self.results),
            "impossible": self.impossible,
            "settling_from": self.settling_from,
            **({} if self.sudden is None else {"sudden_unbalance": repr(self.sudden)}),
            **({} if self.plan == "random" else {"members": self.members}),
        }

    def columns(self, first: int, last: int, again: dict[int, int]) -> Columns:
        """What varies in the members from ``first`` to before ``last``.

        Parameters
        ----------
        first, last
            Members, counted from 0.
        again
            Draws that are taken once more, and how often they were.
        """
        draw, point = np.divmod(np.arange(first, last, dtype=np.int64), len(self.points))
        distinct, where = np.unique(draw, return_inverse=True)
        share = self._shares(distinct)
        for number, attempt in again.items():
            share[distinct == number] = drawn_again(self.seed, share.shape[1], number, attempt)
        values: dict[str, Any] = {
            name: one.at(column)[where].tolist()
            for (name, one), column in zip(
                self.scatter.items(), self._correlated(share).T[: len(self.scatter)], strict=True
            )
        }
        at = self.points
        values |= {name: [at[one][place] for one in point] for place, name in enumerate(self.grid)}
        parameters, starts = _sorted(values)
        return Columns(last - first, parameters, starts, self._seeds(draw))

    def _shares(self, draws: NDArray[np.int64]) -> NDArray[np.float64]:
        width = len(self.inputs) if self.plan == "sensitivity" else len(self.scatter)
        return shares(self.plan, self.seed, width, draws, self.draws)

    def _correlated(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        names = list(self.scatter)
        return correlated(share[:, : len(names)], joined(names, self.correlation))

    def _seeds(self, draw: NDArray[np.int64]) -> NDArray[np.int64]:
        """Seeds of the starts; with the plan "sensitivity" they are one more number of its samples A and B."""
        if not self.random_starts:
            return np.full(draw.size, self.seed, np.int64)
        if self.plan != "sensitivity":
            return self.seed + draw
        base, which = np.divmod(draw, len(self.inputs) + 2)
        other = (which == 1) | (which == 1 + len(self.inputs))
        return np.asarray(self.seed + 2 * base + other, np.int64)


def _sorted(values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Parameters of the machine, and starts of its balls."""
    from autobalancer.studies.ensemble.columns import is_start

    starts = {name: np.array(entries, np.float64) for name, entries in values.items() if is_start(name)}
    return {name: entries for name, entries in values.items() if name not in starts}, starts

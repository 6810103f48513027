"""One trial of a fit: a machine with its parameters, and what is computed of it only once."""

from __future__ import annotations

from functools import cache, cached_property
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.rotors import LateralModel, lateral_model, with_ball_mass
from autobalancer.machine import Machine
from autobalancer.rotordynamics.critical import critical_speeds
from autobalancer.rotordynamics.eigenproblem import FreeMotions, free_motions
from autobalancer.rotordynamics.question import Places, along_axis
from autobalancer.rotordynamics.shapes import ellipses_of, mode_names
from autobalancer.rotordynamics.whirl import Whirl, whole_direction


class Trial:
    """A machine under trial; ``values`` are those of the free parameters by name."""

    def __init__(self, machine: Machine, values: dict[str, float]) -> None:
        self.machine = machine
        self.values = values
        self.runs: dict[Any, xr.Dataset] = {}  # that measurements of one run-up share
        self.motions = cache(self._motions)
        self.words = cache(self._words)
        self.critical = cache(self._critical)

    @cached_property
    def bare(self) -> LateralModel:
        """The rotor without balls."""
        return lateral_model(self.machine)

    @cached_property
    def loaded(self) -> LateralModel:
        """The rotor with the masses of the balls."""
        return with_ball_mass(self.machine, self.bare)

    @cached_property
    def axis(self) -> Places:
        """Places from end to end."""
        return along_axis(self.machine, self.bare)

    def model(self, balls: bool) -> LateralModel:
        """The rotor with the masses of the balls or without balls."""
        return self.loaded if balls else self.bare

    def _motions(self, speed: float, balls: bool) -> FreeMotions:
        return free_motions(self.model(balls), speed)

    def _words(self, speed: float, balls: bool) -> list[tuple[str, str]]:
        """Name and whirl direction of every mode."""
        found, model = self.motions(speed, balls), self.model(balls)
        ellipses = ellipses_of(model, found.vector, self.axis)
        names = mode_names(model, found.vector, self.axis)
        ways = [whole_direction(Whirl(f, b)) for f, b in zip(ellipses.forward, ellipses.backward, strict=True)]
        return list(zip(names, ways, strict=True))

    def _critical(self, balls: bool, highest: float | None) -> tuple[np.ndarray, list[tuple[str, str]]]:
        """Critical speeds, undamped or (with a highest speed) damped, with name and whirl direction."""
        found = critical_speeds(self.machine, balls=balls, highest=highest, damped=highest is not None)
        words = list(zip(found["name"].values.tolist(), found["whirl"].values.tolist(), strict=True))
        return np.asarray(found["critical_speed"].values), words


def chosen(words: list[tuple[str, str]], order: int, whirl: str | None, mode: str | None) -> int | None:
    """The number of the ``order``-th entry with this whirl direction and all words of ``mode`` in its name."""
    wanted = set((mode or "").split())
    found = [i for i, (name, way) in enumerate(words) if whirl in (None, way) and wanted <= set(name.split())]
    return found[order - 1] if order <= len(found) else None

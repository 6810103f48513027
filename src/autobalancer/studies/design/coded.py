"""Candidates as numbers between 0 and 1, one for each thing that can be chosen, as an optimizer wants them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.studies.design.candidate import Candidate, Ring, fewest, free_ring, own_sizes, planes_of, rings
from autobalancer.studies.design.fluids import blended
from autobalancer.studies.design.spec import Spec


class Coded:
    """What can be chosen, and the candidate that numbers stand for.

    A list is ordered so that neighbors are alike: rings by their outer diameter, fluids by their viscosity at 25 °C.
    """

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        options, room = spec.options, 298.15
        self.free = {name: (low, high) for name, low, high in options.free}
        lists: dict[str, Sequence[Any]] = {
            "ring": []
            if set(self.free) & {"orbit_radius", "ball_diameter"}
            else sorted(rings(spec), key=lambda one: one.outer),
            "orbit_radius": options.orbit_radii,
            "ball_diameter": options.ball_diameters,
            "count": options.counts,
            "races": options.races,
            "planes": options.planes,
            "fluid": sorted(options.fluids, key=lambda one: one[0].at(room)[1])
            if len(options.fluids) > 1
            else options.fluids,
        }
        if lists["ring"]:
            lists["orbit_radius"] = lists["ball_diameter"] = ()
        self.lists = lists
        self.names = [name for name, one in lists.items() if len(one) > 1] + list(self.free)

    def candidate(self, numbers: Sequence[float]) -> Candidate:
        """The candidate of numbers between 0 and 1, in the order of ``names``."""
        given = dict(zip(self.names, map(float, numbers), strict=True))
        spec, races = self.spec, int(self._chosen("races", given) or 1)
        planes, fillings = self._chosen("planes", given) or (), self._fillings(given)
        if len(fillings) > 1:
            races = len(fillings)
        ring = self._chosen("ring", given) or self._ring(given)
        count = self._chosen("count", given) or fewest(spec, ring, races, planes_of(spec, planes), fillings)
        return Candidate(ring, int(count), races, planes, fillings)

    def steps(self) -> NDArray[np.float64]:
        """The numbers of all candidates where nothing is free: the middles of their steps."""
        axes = [(np.arange(len(self.lists[name])) + 0.5) / len(self.lists[name]) for name in self.names]
        return np.array(list(product(*axes)), np.float64).reshape(-1, len(axes))

    def _chosen(self, name: str, given: dict[str, float]) -> Any:
        some = self.lists[name]
        if not some:
            return None
        return some[min(int(given.get(name, 0.0) * len(some)), len(some) - 1)]

    def _ring(self, given: dict[str, float]) -> Ring:
        own = own_sizes(self.spec) or (math.nan, math.nan)
        sizes = [
            self._size(name, given, usual) for name, usual in zip(("orbit_radius", "ball_diameter"), own, strict=True)
        ]
        return free_ring(self.spec, sizes[0], sizes[1])

    def _size(self, name: str, given: dict[str, float], usual: float) -> float:
        if name in self.free:
            low, high = self.free[name]
            return round(low + given[name] * (high - low), 5)  # to 10 um: nobody makes it finer
        return float(self._chosen(name, given) or usual)

    def _fillings(self, given: dict[str, float]) -> Any:
        if self.spec.options.blend is None:
            return self._chosen("fluid", given) or ()
        low, high = self.free["viscosity"]
        viscosity = float(f"{low * (high / low) ** given['viscosity']:.3g}")
        return (blended(*self.spec.options.blend, min(max(viscosity, low), high)),)

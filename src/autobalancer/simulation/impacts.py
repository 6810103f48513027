"""Impacts that a run notes as it goes."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.contact.touches import Touch
from autobalancer.assembly.gauges import MOST, meetings_of
from autobalancer.kernels.records.impacts import IMPACT
from autobalancer.kernels.system import System
from autobalancer.results.impacts import VARIABLES, Impacts
from autobalancer.results.labels import label


class Noted:
    """Takes what the equations have noted, between two calls of the stepper, and says what it means."""

    def __init__(self, touches: tuple[Touch, ...]) -> None:
        self._touches = touches
        self._kept: list[Any] = []
        self.count = 0  # of all
        self._size = 0

    def take(self, system: System) -> None:
        """Empty the room in ``system``."""
        if not self._touches:
            return
        seen = int(system.impact_count[0])
        keep = min(seen, system.impacts.size, MOST - self._size)
        if keep > 0:
            self._kept.append(system.impacts[:keep].copy())
        self.count, self._size = self.count + seen, self._size + keep
        system.impact_count[0] = 0

    @property
    def lost(self) -> int:
        """Impacts that were counted, but not kept."""
        return self.count - self._size

    def found(self) -> Impacts | None:
        """All that were kept; None where nothing can touch."""
        if not self._touches:
            return None
        rows = np.concatenate([IMPACT.rows(0), *self._kept])
        from autobalancer.kernels.measures.impacts import all_meant

        touch, meant = np.array(rows["touch"], np.int64), np.zeros((2, rows.size))
        all_meant(rows, *meetings_of(self._touches), meant)
        partners = np.array([(touch.one + 1, touch.other + 1) for touch in self._touches])  # 0: partition, -1: wall
        return Impacts(
            time=np.array(rows["time"], np.float64),
            speed=np.array(rows["speed"], np.float64),
            lost=meant[0],
            impulse=meant[1],
            ball=partners[touch, 0],
            partner=partners[touch, 1],
        )


def with_impacts(run: xr.Dataset, noted: Noted) -> xr.Dataset:
    """The run with the impacts that were noted, over the dimension ``impact``."""
    found = noted.found()
    if found is None:
        return run
    variables = {kept: ("impact", getattr(found, name)) for kept, name in VARIABLES.items()}
    run = label(run.assign(variables).assign_coords(impact_time=("impact", found.time)))
    return run.assign_attrs(impacts_not_kept=noted.lost) if noted.lost else run

"""What a run of a deep chamber recorded, as plain arrays: all that a measure is computed from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.results.chamber.balls import Floats, ball_settling_time, balls_carried, residual_of_balls, window

DIRECTIONS = {"horizontal": ("body_position", 1), "vertical": ("body_position", 2), "rotation": ("body_rotation", 0)}

READ = (  # variables that measures read, some of them several times
    "speed", "rotor_angle", "body_position", "body_rotation", "ball_position", "bearing_force", "constraint_force",
    "constraint_moment", "contacts_ball", "contacts_wall", "impact_speeds", "impact_energies", "loss_contact",
    "greatest_contact_force", "work_motor", "energy_error", "tilting",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ChamberRecorded:
    """A run, and what is asked of it: the length of the steady state (s), the tolerance of settling (ball radii).

    ``unbalance`` and ``couple`` are those of the rotor, complex in the rotor (kg m, kg m²), ``places`` those of the chambers (m).
    """

    run: xr.Dataset
    last: float | None = None
    tolerance: float = 1.0
    unbalance: complex | None = None
    couple: complex = 0.0
    places: Floats | None = None
    _read: dict[str, Floats] = field(default_factory=dict)  # a run of an archive is read when it is used, and only once

    def values(self, variable: str) -> Floats:
        """A variable of the run over time first, (T, ...)."""
        if variable not in self._read:
            self._read[variable] = np.asarray(self.run[variable].transpose("time", ..., "axis").values, np.float64)
        return self._read[variable]

    @cached_property
    def steady(self) -> slice:
        """Samples of the steady state."""
        return window(self.run, self.last)

    @cached_property
    def time(self) -> Floats:
        """(T,) s."""
        return np.asarray(self.run["time"].values, np.float64)

    def moved(self, direction: str) -> Floats:
        """The body over the whole run, (T,) m or rad."""
        variable, axis = DIRECTIONS[direction]
        return np.asarray(self.values(variable)[:, axis])

    def synchronous(self, direction: str) -> float:
        """Amplitude of the part that turns with the rotor in steady state."""
        angle = self.run["rotor_angle"].values[self.steady]
        basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
        fit = np.linalg.lstsq(basis, self.moved(direction)[self.steady], rcond=None)[0]
        return float(np.hypot(fit[1], fit[2]))

    def away(self, direction: str) -> Floats:
        """Distance from the mean of the steady state over the whole run, (T,)."""
        values = self.moved(direction)
        return np.asarray(np.abs(values - values[self.steady].mean()))

    def radial_force(self, bearing: int) -> Floats:
        """Across the axis, of a bearing counted from 1, (T,) N."""
        force = self.values("bearing_force")[:, bearing - 1]
        return np.asarray(np.hypot(force[:, 1], force[:, 2]))

    def over_stages(self, amounts: Floats) -> Floats:
        """What came a second before and in steady state, of ``amounts`` since the last sample (T,); nan without time."""
        first, last = self.steady.start, self.time.size - 1
        spans = (0, max(first - 1, 0)), (max(first - 1, 0), last)
        totals = np.cumsum(amounts)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.array([(totals[b] - totals[a]) / (self.time[b] - self.time[a]) for a, b in spans])

    @property
    def cylinders(self) -> bool | None:
        """True if these run in the chambers, else ``None``."""
        return True if "tilting" in self.run else None

    def parts(self, values: Floats, measure: Callable[[Floats], Any]) -> Floats:
        """A measure of ``values`` (T,) before and in steady state; nan where there are none."""
        found = (values[: self.steady.start], values[self.steady])
        return np.array([float(measure(part)) if part.size else np.nan for part in found])

    @cached_property
    def impacts(self) -> Floats:
        """Contacts of balls begun since the last sample, (T,)."""
        return np.asarray(self.run["contacts_ball"].values + self.run["contacts_wall"].values, np.float64)

    def of_an_impact(self, sums: str) -> Floats:
        """The mean of a contact that began, before and in steady state; nan in runs that did not keep it, or without contacts."""
        if sums not in self.run:
            return np.full(2, np.nan)
        with np.errstate(invalid="ignore", divide="ignore"):
            return self.over_stages(self.run[sums].values) / self.over_stages(self.impacts)

    @cached_property
    def impact_loss(self) -> Floats:
        """Energy lost in impacts since the last sample, (T,) J."""
        lost = np.asarray(self.run["loss_contact"].values, np.float64)
        return np.diff(lost, prepend=lost[:1])

    @cached_property
    def contact_force(self) -> Floats:
        """Greatest force of a contact since the last sample, (T,) N."""
        return np.asarray(self.run["greatest_contact_force"].values, np.float64)

    @cached_property
    def settled(self) -> Floats:
        """When each ball has settled, s."""
        return np.asarray(ball_settling_time(self.run, self.tolerance, self.last).values)

    @cached_property
    def carried(self) -> Any:
        """Which balls go around with the rotor."""
        return balls_carried(self.run, self.last).values

    @cached_property
    def left(self) -> xr.Dataset | None:
        """What the balls leave of the unbalance in steady state; ``None`` if it is not known."""
        if self.unbalance is None:
            return None
        return residual_of_balls(self.run.isel(time=self.steady), self.unbalance, self.couple, self.places)

"""A measured run-up as something that a machine is fitted to: each trial of the fit is simulated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.comparison.pairs import Pair, pairs, scale_doubt
from autobalancer.measurement.comparison.stated import stated
from autobalancer.rotordynamics.identification.fit import Search
from autobalancer.rotordynamics.identification.measurements import Rows
from autobalancer.rotordynamics.identification.trial import Trial
from autobalancer.simulation.run import simulate_races
from autobalancer.simulation.sampling import SampleTimes

Floats = NDArray[np.float64]
MOST = 20_000  # samples of a channel; of more every second, third, ... is taken
QUIET: Any = False  # no bar
OF_RUNS = Search(step=1e-4, accuracy=1e-6, central=False, error=1e-6)  # as exact as they are
TOLERANCE = 1e-9  # of runs, so that their differences are smooth


@dataclass(frozen=True, eq=False)
class MeasuredRunUp:
    """Signals or ball angles of one run-up, for :func:`autobalancer.rotor.identify`.

    Time zero of the measurement is that of a run of the machine, whose drive and start are those of the test. Every sample counts
    with the standard deviation of its noise, which is taken as white. The offset of a sensor of motion is free.

    Parameters
    ----------
    measured
        Signals with the ``uncertainty`` of each channel, or ball angles with their ``ball_angle_deviation``.
    seed
        Of the runs, for what the machine leaves to chance.
    label
        In reports.
    times
        Also at these times (s) the run is sampled, those of other measurements of the same run-up: they share it.
    """

    measured: xr.Dataset
    seed: int = 0
    label: str = "run-up"
    times: Sequence[float] = ()
    search: ClassVar[Search] = OF_RUNS

    def __post_init__(self) -> None:
        step = -(-self.measured.sizes.get("time", 1) // MOST)
        thin = self.measured.isel(time=slice(None, None, step)) if step > 1 else self.measured
        object.__setattr__(self, "measured", thin)
        for one in stated(thin):
            if not (np.isfinite(one.deviation).all() and (one.deviation > 0.0).all()):
                raise QuestionError(
                    f"{self.label}: the noise of {one.name!r} is not known; give its standard deviation, as the attribute "
                    "'uncertainty' of a channel or as ball_angle_deviation of a film"
                )
        if not thin["time"].values[0] >= 0.0:
            raise QuestionError(f"{self.label}: it begins before the run, at {thin['time'].values[0]:.6g} s")

    def rows(self) -> Rows:
        """See :class:`~autobalancer.rotordynamics.identification.measurements.Measurement`."""
        found = stated(self.measured)
        values, error = (np.concatenate([one[k] for one in found]) for k in (3, 4))
        units = "/".join(sorted({one.unit for one in found}))
        return Rows(self.label, "run-up", units, values, error, np.full(values.size, np.nan))

    def predict(self, trial: Trial) -> Floats:
        """See :class:`~autobalancer.rotordynamics.identification.measurements.Measurement`."""
        found = self.pairs(trial)
        return np.concatenate([pair.shifted for pair in found]) if found else np.full(self.rows().measured.size, np.nan)

    def pairs(self, trial: Trial) -> list[Pair]:
        """Measured beside simulated; nothing if the run does not come to its end."""
        run = self._run(trial)
        return pairs(run, self.measured, dense=False) if run.attrs["outcome"] == "finished" else []

    def doubts(self, trial: Trial) -> list[str]:
        """What is probably wrong with its units."""
        return list(filter(None, map(scale_doubt, self.pairs(trial))))

    def _run(self, trial: Trial) -> xr.Dataset:
        time = np.unique(np.concatenate([self.measured["time"].values, self.times]))
        key = (self.seed, time.tobytes())
        if key not in trial.runs:
            save = SampleTimes(time)  # type: ignore[arg-type]
            trial.runs[key] = simulate_races(
                trial.machine, duration=float(time[-1]), save=save, tolerance=TOLERANCE, seed=self.seed, progress=QUIET
            )
        return trial.runs[key]

    def residual(self, predicted: Floats) -> Floats:
        """See :class:`~autobalancer.rotordynamics.identification.measurements.Measurement`."""
        rows = self.rows()
        return np.asarray((predicted - rows.measured) / rows.error, np.float64)

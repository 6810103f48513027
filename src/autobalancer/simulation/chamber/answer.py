"""A run of deep chambers as what a person asks first."""

from __future__ import annotations

import numpy as np

from autobalancer.results.answers.run import Run
from autobalancer.results.verdict.judged import Verdict
from autobalancer.simulation.chamber.verdict import chamber_verdict


class ChamberRun(Run):
    """A run of balls that move freely in deep chambers."""

    __slots__ = ()
    drawn_by = "chamber_run"
    times = ("time",)

    def verdict(self) -> Verdict:
        """The verdict on it."""
        return chamber_verdict(self)

    def _balls(self) -> str:
        chambers = np.unique(self["chamber"].values).size
        return f"{self.sizes['ball']} in {chambers} deep chamber{'s' * (chambers > 1)}"

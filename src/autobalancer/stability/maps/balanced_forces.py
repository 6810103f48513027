"""Growth rate over the speed of the states in which balls with forces on them make the deflection smaller."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from autobalancer.results.number_text import length_text
from autobalancer.stability.maps.balanced_stations import MostStable
from autobalancer.stability.states.settled import searched
from autobalancer.stability.states.state import StationState
from autobalancer.stability.states.stations import balanced_of

NONE = 1e-9  # share of a deflection that is not worth a word
ABOVE = 1.0 + 1e-6  # a border
NEAR = 1.15  # ratio of two speeds between which states are followed


@dataclass(frozen=True)
class ForcedBalls(MostStable):
    """Balanced states, each sought from those at a speed nearby, else anew."""

    route: str = "search"
    known: dict[float, list[StationState]] = field(default_factory=dict, repr=False)

    def left_at(self, speed: float) -> str:
        """What the most stable state leaves of the deflection there, in words; empty at no finite speed, or for nothing."""
        states = self.states(speed * ABOVE) if math.isfinite(speed) else []
        if not states:
            return ""
        st, bare = self.stations, self.stations.plain_at(speed)
        state = min(states, key=lambda one: self.growth(st, speed * ABOVE, one))
        left = float(np.abs(state.whirl).max())
        alone = float((speed**2 * np.abs(bare.rows @ st.compliance(speed) @ bare.fixed_load)).max())
        return (
            f"at this speed the balls reduce the deflection of {length_text(alone)} to {100.0 * left / alone:.3g} %"
            if alone > 0.0 and left > NONE * alone
            else ""
        )

    def states(self, speed: float) -> list[StationState]:
        """The balanced states at a speed."""
        if speed not in self.known:
            near = min(self.known, key=lambda other: abs(math.log(other / speed)), default=math.inf)
            before = self.known[near] if max(near / speed, speed / near) < NEAR else []
            found = searched(self.stations, speed, [state.angles for state in before])
            found = [state for state in found if state.name == "balanced"]
            self.known[speed] = found if found and len(found) >= len(before) else balanced_of(self.stations, speed)
        return self.known[speed]

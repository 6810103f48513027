"""States that differ by an exchange of equal balls are one."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.state import StationState


def without_exchanges(st: Stations, states: Iterable[StationState], digits: int = 7) -> list[StationState]:
    """Without states that differ by an exchange of equal balls of one station; ``digits`` of their directions count."""
    kept_states: dict[tuple[tuple[float, ...], ...], StationState] = {}
    for state in states:
        parts = zip(st.station, st.moment, st.inertia, st.drag, np.cos(state.angles), np.sin(state.angles), strict=True)
        key = tuple(
            sorted(tuple(round(float(v), 15 if i < 4 else digits) for i, v in enumerate(part)) for part in parts)
        )
        kept_states.setdefault(key, state)
    return list(kept_states.values())

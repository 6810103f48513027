"""Whether rubber moved farther than its friction elements are known for, in words."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.places import in_frame
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import NEXT_BIN, NEXT_SAMPLE, NEXT_TURN, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.system import Floats, Matrix
from autobalancer.results.number_text import length_text


def greatest_stretch(rows: Matrix, middle: Matrix, assembly: Assembly, record: Record, state: Memory) -> Floats:
    """Greatest distances from ``middle`` (M, 2) of places with ``rows`` (2 M, R) in the states that a run kept, (M,) m."""
    seen = (
        record.samples[: int(state.counts[NEXT_SAMPLE])],
        record.bin_states[: int(state.counts[NEXT_BIN])],
        record.turn_states[: int(state.counts[NEXT_TURN]), 1:],
        state.state[None],
    )
    states = np.concatenate([part[np.isfinite(part).all(axis=1)] for part in seen])
    q = in_frame(states, assembly)[0]
    stretch = (q @ rows[:, : q.shape[1]].T).reshape(len(states), -1, 2) - middle
    return np.asarray(np.hypot(stretch[..., 0], stretch[..., 1]).max(axis=0, initial=0.0))


def rubber_text(assembly: Assembly, record: Record, state: Memory) -> str:
    """Which rubber moved farther than its largest breakaway amplitude, beyond which its loss force no longer grows."""
    if not any(mount.rubber.friction for mount in assembly.mounts):
        return ""
    far = []
    middle = np.zeros((len(assembly.mounts), 2))
    stretches = greatest_stretch(assembly.system.rubber.rows, middle, assembly, record, state)
    for mount, moved in zip(assembly.mounts, stretches, strict=True):
        limit = mount.rubber.largest_amplitude
        if mount.rubber.friction and moved > limit:
            far.append(
                f"{mount.name} moved {length_text(moved)}, its largest breakaway amplitude is {length_text(limit)}"
            )
    if not far:
        return ""
    more = "beyond it all friction elements slide, and their force stays the same; add one with a larger amplitude"
    return f"rubber: {'; '.join(far)}; {more}"

"""Whether a bearing moved farther than the table of its force is known for, in words."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.rotors.hardening import central_force
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.results.number_text import length_text
from autobalancer.simulation.remarks.rubber_text import greatest_stretch


def bearing_text(assembly: Assembly, record: Record, state: Memory) -> str:
    """Which bearings moved beyond their table, where its last slope goes on."""
    reach = [central_force(place.hardening).reach for place in assembly.hard]
    if not np.isfinite(reach).any():
        return ""
    middle = np.array([place.hardening.center for place in assembly.hard], float)
    moved = greatest_stretch(assembly.system.bearings.rows, middle, assembly, record, state)
    far = [
        f"{place.name} moved {length_text(way)} from its middle, its table ends at {length_text(limit)}"
        for place, way, limit in zip(assembly.hard, moved, reach, strict=True)
        if way > limit
    ]
    if not far:
        return ""
    return f"bearings: {'; '.join(far)}; beyond it the force goes on with its last slope, add the forces there"

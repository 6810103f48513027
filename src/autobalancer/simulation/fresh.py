"""A fresh integration."""

from __future__ import annotations

from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import Memory, memory


def memory_for(assembly: Assembly, end: float, tolerance: float, pair: tableaus.Tableau) -> Memory:
    """A fresh integration of an assembled machine up to ``end``."""
    return memory(
        assembly.state,
        end,
        tolerance * assembly.scale,
        tolerance * assembly.growing,
        total=pair.total,
        degree=pair.degree,
        longest=end,
    )

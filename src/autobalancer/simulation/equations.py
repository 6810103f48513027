"""Which compiled equations of motion belong to an assembled machine."""

from __future__ import annotations

from typing import Any

from autobalancer.assembly.system import Assembly
from autobalancer.kernels.guided_balls import planar


def equations(assembly: Assembly) -> Any:
    """The right-hand side for :func:`autobalancer.kernels.integrators.runge_kutta.advance`."""
    if assembly.resolved:
        from autobalancer.kernels.resolved_balls import resolved

        return resolved
    if assembly.general:
        from autobalancer.kernels.rotor_layout import BALL_ROWS, ROWS

        if assembly.system.rotor[BALL_ROWS] != 0.0:
            from autobalancer.kernels.guided_race import real_race

            return real_race
        from autobalancer.kernels.stations import spatial, spatial_full

        return spatial_full if assembly.system.rotor[ROWS] == 4 else spatial
    return planar

"""Speed of the walls within one piece of a profile."""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.system import HILL, Floats


@njit(**INLINE)
def wall_speed(time: float, start: float, kind: float, numbers: Floats) -> tuple[float, float]:
    """Speed of the walls and its rate; ``kind`` and ``numbers`` as a segment of the drive."""
    if kind == HILL:
        if time <= 0.0:
            return numbers[3], 0.0
        ratio = (time / numbers[1]) ** numbers[2]
        rise = ratio / (1.0 + ratio)
        span = numbers[0] - numbers[3]
        return numbers[3] + span * rise, span * rise * numbers[2] / (time * (1.0 + ratio))
    return numbers[0] + numbers[1] * (time - start), numbers[1]

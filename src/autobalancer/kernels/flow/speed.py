"""Speed of the walls within one piece of a profile."""

from __future__ import annotations

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.laws.curves import between
from autobalancer.kernels.records.drive import HILL
from autobalancer.kernels.system import Floats

RECORD = 2  # kind of a piece: a record, whose numbers are step, count and pairs of value and slope times step


@njit(**INLINE)
def wall_speed(time: float, start: float, kind: float, numbers: Floats) -> tuple[float, float]:
    """Speed of the walls and its rate; ``kind`` and ``numbers`` as a segment of the drive, or a record."""
    if kind == RECORD:
        count = int(numbers[1])
        place = (time - start) / numbers[0]
        inside = min(max(place, 0.0), count - 1.0)
        i = min(int(inside), count - 2)
        s, a = inside - i, 2 + 2 * i
        speed = between(numbers[a], numbers[a + 1], numbers[a + 2], numbers[a + 3], s)
        if inside != place:
            return speed, 0.0
        d = numbers[a + 2] - numbers[a]
        m, n = numbers[a + 1] - d, d - numbers[a + 3]
        return speed, (d + (1.0 - 2.0 * s) * (m * (1.0 - s) + n * s) + s * (1.0 - s) * (n - m)) / numbers[0]
    if kind == HILL:
        if time <= 0.0:
            return numbers[3], 0.0
        ratio = (time / numbers[1]) ** numbers[2]
        rise = ratio / (1.0 + ratio)
        span = numbers[0] - numbers[3]
        return numbers[3] + span * rise, span * rise * numbers[2] / (time * (1.0 + ratio))
    return numbers[0] + numbers[1] * (time - start), numbers[1]

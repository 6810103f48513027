"""Speed, torque and unbalance at an instant, from the segment in force."""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.system import DRIVE, HILL, KIND, START, UNBALANCE, System


@njit(**INLINE)
def drive_value(time: float, system: System) -> tuple[float, float]:
    """The drive's profile (speed or torque) and its rate of change."""
    segment = system.now[0]
    c0, c1 = system.segments[segment, DRIVE], system.segments[segment, DRIVE + 1]
    if system.segments[segment, KIND] == HILL:
        end, half = c0, c1
        exponent, begin = system.segments[segment, DRIVE + 2], system.segments[segment, DRIVE + 3]
        if time <= 0.0:
            return begin, 0.0
        ratio = (time / half) ** exponent
        rise = ratio / (1.0 + ratio)
        return begin + (end - begin) * rise, (end - begin) * rise * exponent / (time * (1.0 + ratio))
    return c0 + (time - system.segments[segment, START]) * c1, c1


@njit(**INLINE)
def unbalance_value(time: float, system: System) -> tuple[float, float]:
    """The resultant unbalance (Ux, Uy) in the rotor, kg m."""
    segment = system.now[0]
    s = time - system.segments[segment, START]
    ux, uy = system.segments[segment, UNBALANCE], system.segments[segment, UNBALANCE + 1]
    return ux + s * system.segments[segment, UNBALANCE + 2], uy + s * system.segments[segment, UNBALANCE + 3]


@njit(**INLINE)
def table_torque(speed: float, system: System) -> float:
    """Torque from the table over speed, held constant outside it; 0 without a table."""
    table = system.torque_table
    count = table.shape[0]
    if count == 0:
        return 0.0
    if speed <= table[0, 0]:
        return table[0, 1]
    for i in range(1, count):
        if speed <= table[i, 0]:
            part = (speed - table[i - 1, 0]) / (table[i, 0] - table[i - 1, 0])
            return table[i - 1, 1] + part * (table[i, 1] - table[i - 1, 1])
    return table[count - 1, 1]

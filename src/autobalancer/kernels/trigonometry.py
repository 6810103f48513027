"""Sine and cosine of one angle together, and the exponential function: a third of the time of calls of the library."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.compiler.flags import INLINE, MERGED, njit
from autobalancer.kernels.compiler.simd import power_of_two, rounded, select

QUARTERS = 2.0 / math.pi  # quarter turns in a radian
ROUND = 1.5 * 2.0**52  # added and taken away again, it rounds to the nearest integer
HIGH = float.fromhex("0x1.921fb544p+0")  # the leading 33 bits of pi/2: times an integer below 2^20 without rounding
LOW = 6.07710050650619224932e-11  # pi/2 - HIGH
LARGEST = 1e6  # rad; beyond it the reduction would lose digits

# minimax polynomials of fdlibm (Sun Microsystems 1993), k_sin.c and k_cos.c
S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


BINARY = 1.0 / math.log(2.0)
LOG_HIGH = float.fromhex(
    "0x1.62e42feep-1"
)  # the leading 32 bits of log 2: times an integer below 2^20 without rounding
LOG_LOW = 1.90821492927058770002e-10  # log 2 - LOG_HIGH
LEAST = -700.0  # smaller exponents count as this one


@njit(**MERGED)
def exponential_of_lanes(exponent: Any) -> Any:
    """e^x of the lanes of a wide value up to 700, without a branch, to an ulp: a power of two times the series."""
    x = select(exponent > LEAST, exponent, LEAST)
    powers = rounded(x * BINARY)
    x = (x - powers * LOG_HIGH) - powers * LOG_LOW
    xx = x * x
    x4 = xx * xx
    low = (x * (1.0 / 6.0) + 0.5) + xx * (x * (1.0 / 120.0) + 1.0 / 24.0)
    middle = (x * (1.0 / 5040.0) + 1.0 / 720.0) + xx * (x * (1.0 / 362880.0) + 1.0 / 40320.0)
    high = (x * (1.0 / 39916800.0) + 1.0 / 3628800.0) + xx * (x * (1.0 / 6227020800.0) + 1.0 / 479001600.0)
    return ((low + x4 * (middle + x4 * high)) * xx + x + 1.0) * power_of_two(powers)


@njit(**MERGED)
def sine_cosine_of_lanes(angle: Any) -> tuple[Any, Any]:
    """(sin, cos) of the lanes of a wide value, without a branch; to an ulp of the angle beyond LARGEST, else of one."""
    quarter = rounded(angle * QUARTERS)
    x = (angle - quarter * HIGH) - quarter * LOW
    z = x * x
    zz = z * z
    s = ((z * S2 + S1) + zz * (z * S4 + S3)) + zz * zz * (z * S6 + S5)
    c = ((z * C2 + C1) + zz * (z * C4 + C3)) + zz * zz * (z * C6 + C5)
    s = x + x * z * s
    c = (1.0 - 0.5 * z) + zz * c
    turn = quarter - 4.0 * rounded(quarter * 0.25)  # -2 to 2 quarters
    odd = turn * turn == 1.0
    sine, cosine = select(odd, c, s), select(odd, s, c)
    before, after = turn - 0.5, turn + 0.5
    return select(before * before > 1.0, -sine, sine), select(after * after > 1.0, -cosine, cosine)


@njit(**INLINE)
def sine_cosine(angle: float) -> tuple[float, float]:
    """(sin, cos) to an ulp of one. The polynomials are summed in pairs, which is faster than one after the other."""
    if not abs(angle) < LARGEST:  # also when it is not a number
        return math.sin(angle), math.cos(angle)
    quarter = (angle * QUARTERS + ROUND) - ROUND
    x = (angle - quarter * HIGH) - quarter * LOW
    z = x * x
    zz = z * z
    s = ((S1 + z * S2) + zz * (S3 + z * S4)) + zz * zz * (S5 + z * S6)
    c = ((C1 + z * C2) + zz * (C3 + z * C4)) + zz * zz * (C5 + z * C6)
    s = x + x * z * s
    c = (1.0 - 0.5 * z) + zz * c
    turn = int(quarter)
    if turn & 1:
        s, c = c, -s
    if turn & 2:
        s, c = -s, -c
    return s, c

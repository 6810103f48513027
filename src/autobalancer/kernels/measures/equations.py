"""Small complex equations: solved by elimination, or in the sense of least squares without what is nearly dependent.

The matrix and its right-hand sides stand side by side in one array.
"""

from __future__ import annotations

import math
from typing import Any

from numba import boolean, int64, types, void

from autobalancer.kernels.flags import EXACT_PART, INLINE, njit
from autobalancer.kernels.measures.gauges import complex_matrix_type

TURNS = 60  # of all pairs of columns, at most
SMALL = 1e-15  # relative: columns as good as perpendicular


@njit(**INLINE)
def square(z: complex) -> float:
    """The square of its size."""
    return z.real * z.real + z.imag * z.imag


@njit(boolean(complex_matrix_type, int64, int64), **EXACT_PART)
def solve(a: Any, size: int, right: int) -> bool:
    """Replace the ``right`` columns behind the matrix by the solutions; False where there are none."""
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if square(a[i, k]) > square(a[best, k]):
                best = i
        if not square(a[best, k]) > 0.0:
            return False
        if best != k:
            for j in range(k, size + right):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        for i in range(k + 1, size):
            if a[i, k] != 0.0:
                share = a[i, k] / a[k, k]
                for j in range(k + 1, size + right):
                    a[i, j] -= share * a[k, j]
    for k in range(size - 1, -1, -1):
        for j in range(size, size + right):
            value = a[k, j]
            for i in range(k + 1, size):
                value -= a[k, i] * a[i, j]
            a[k, j] = value / a[k, k]
    return True


@njit(void(complex_matrix_type, int64, int64, int64, complex_matrix_type), **EXACT_PART)
def reduce(a: Any, rows: int, size: int, right: int, small: Any) -> None:
    """Bring a tall matrix with its right-hand sides to a square one of the same least squares, by Gram and Schmidt."""
    for k in range(size):
        total = 0.0
        for t in range(rows):
            total += square(a[t, k])
        length = math.sqrt(total)
        for i in range(k + 1, size):
            small[i, k] = 0.0
        small[k, k] = length
        for t in range(rows if length > 0.0 else 0):
            a[t, k] = a[t, k] / length
        for j in range(k + 1, size + right):
            share = complex(0.0, 0.0)
            for t in range(rows):
                share += a[t, k].conjugate() * a[t, j]
            small[k, j] = share
            for t in range(rows):
                a[t, j] -= share * a[t, k]


@njit(**INLINE)
def _perpendicular(a: Any, v: Any, i: int, j: int, rows: int, size: int) -> bool:
    """Turn two columns until they are perpendicular, the same turn in ``v``; whether they were so already."""
    alpha, beta, gamma = 0.0, 0.0, complex(0.0, 0.0)
    for t in range(rows):
        alpha, beta = alpha + square(a[t, i]), beta + square(a[t, j])
        gamma += a[t, i].conjugate() * a[t, j]
    size_of = math.sqrt(square(gamma))
    if not size_of > SMALL * math.sqrt(alpha * beta):
        return True
    phase = gamma / size_of
    zeta = (beta - alpha) / (2.0 * size_of)
    tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    for t in range(rows):
        x, y = a[t, i], a[t, j] * phase.conjugate()
        a[t, i], a[t, j] = cosine * x - sine * y, sine * x + cosine * y
    for t in range(size):
        x, y = v[t, i], v[t, j] * phase.conjugate()
        v[t, i], v[t, j] = cosine * x - sine * y, sine * x + cosine * y
    return False


@njit(void(complex_matrix_type, int64, int64, types.float64, complex_matrix_type), **EXACT_PART)
def least_squares(a: Any, size: int, right: int, least: float, v: Any) -> None:
    """Replace the right-hand sides of a square matrix by the shortest solutions without singular values below ``least``.

    That is relative to the greatest. One-sided rotations of Jacobi make the columns perpendicular (Golub and Van Loan 2013,
    section 8.6); ``v`` is work.
    """
    for i in range(size):
        for j in range(size):
            v[i, j] = 1.0 if i == j else 0.0
    for _ in range(TURNS):
        done = True
        for i in range(size):
            for j in range(i + 1, size):
                done = _perpendicular(a, v, i, j, size, size) and done
        if done:
            break
    greatest = 0.0
    for k in range(size):
        total = 0.0
        for t in range(size):
            total += square(a[t, k])
        greatest = max(greatest, total)
    for j in range(size, size + right):
        for k in range(size):
            total, share = 0.0, complex(0.0, 0.0)
            for t in range(size):
                total += square(a[t, k])
                share += a[t, k].conjugate() * a[t, j]
            v[k, size] = share / total if total > least * least * greatest else complex(0.0, 0.0)
        for t in range(size):
            value = complex(0.0, 0.0)
            for k in range(size):
                value += v[t, k] * v[k, size]
            v[t, size + 1] = value
        for t in range(size):
            a[t, j] = v[t, size + 1]

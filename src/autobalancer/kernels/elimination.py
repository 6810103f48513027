"""A small linear system with two right-hand sides, in place."""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.flags import EQUATIONS, INLINE


@njit(**EQUATIONS)
def solve_two(r, left, one, two, size):  # type: ignore[no-untyped-def]
    """Gauss elimination with the greatest pivot; matrix by rows at ``left``, answers in place of both right-hand sides."""
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(r[left + i * size + k]) > abs(r[left + pivot * size + k]):
                pivot = i
        if pivot != k:
            for j in range(k, size):
                r[left + k * size + j], r[left + pivot * size + j] = r[left + pivot * size + j], r[left + k * size + j]
            r[one + k], r[one + pivot] = r[one + pivot], r[one + k]
            r[two + k], r[two + pivot] = r[two + pivot], r[two + k]
        inverse = 1.0 / r[left + k * size + k]
        for i in range(k + 1, size):
            factor = r[left + i * size + k] * inverse
            for j in range(k + 1, size):
                r[left + i * size + j] -= factor * r[left + k * size + j]
            r[one + i] -= factor * r[one + k]
            r[two + i] -= factor * r[two + k]
    for k in range(size - 1, -1, -1):
        for j in range(k + 1, size):
            r[one + k] -= r[left + k * size + j] * r[one + j]
            r[two + k] -= r[left + k * size + j] * r[two + j]
        inverse = 1.0 / r[left + k * size + k]
        r[one + k] *= inverse
        r[two + k] *= inverse


@njit(**INLINE)
def solve_two_by_two(r, left: int, one: int, two: int) -> None:  # type: ignore[no-untyped-def]
    """:func:`solve_two` for a matrix of two rows."""
    a, b, c, d = r[left], r[left + 1], r[left + 2], r[left + 3]
    inverse = 1.0 / (a * d - b * c)
    for at in (one, two):
        x, y = r[at], r[at + 1]
        r[at], r[at + 1] = (d * x - b * y) * inverse, (a * y - c * x) * inverse

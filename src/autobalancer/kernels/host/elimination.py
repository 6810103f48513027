"""A small linear system with two right-hand sides, in place."""

from __future__ import annotations

from autobalancer.kernels.flags import EQUATIONS_PART, INLINE, njit


@njit(**EQUATIONS_PART)
def solve_two(left, one, two, size):  # type: ignore[no-untyped-def]
    """Gauss elimination with the greatest pivot; ``left`` by rows, answers in place of both right-hand sides."""
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(left[i * size + k]) > abs(left[pivot * size + k]):
                pivot = i
        if pivot != k:
            for j in range(k, size):
                left[k * size + j], left[pivot * size + j] = left[pivot * size + j], left[k * size + j]
            one[k], one[pivot] = one[pivot], one[k]
            two[k], two[pivot] = two[pivot], two[k]
        inverse = 1.0 / left[k * size + k]
        for i in range(k + 1, size):
            factor = left[i * size + k] * inverse
            for j in range(k + 1, size):
                left[i * size + j] -= factor * left[k * size + j]
            one[i] -= factor * one[k]
            two[i] -= factor * two[k]
    for k in range(size - 1, -1, -1):
        for j in range(k + 1, size):
            one[k] -= left[k * size + j] * one[j]
            two[k] -= left[k * size + j] * two[j]
        inverse = 1.0 / left[k * size + k]
        one[k] *= inverse
        two[k] *= inverse


@njit(**INLINE)
def solve_two_by_two(left, one, two) -> None:  # type: ignore[no-untyped-def]
    """:func:`solve_two` for a matrix of two rows."""
    a, b, c, d = left[0], left[1], left[2], left[3]
    inverse = 1.0 / (a * d - b * c)
    x, y = one[0], one[1]
    one[0], one[1] = (d * x - b * y) * inverse, (a * y - c * x) * inverse
    x, y = two[0], two[1]
    two[0], two[1] = (d * x - b * y) * inverse, (a * y - c * x) * inverse

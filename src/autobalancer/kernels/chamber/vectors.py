"""Vectors as three numbers, which the compiler keeps in registers; nothing here knows an array but the first three."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from autobalancer.kernels.flags import MERGED, njit


@njit(**MERGED)
def three(numbers):
    """The first three of an array."""
    return numbers[0], numbers[1], numbers[2]


@njit(**MERGED)
def put(numbers, a):
    """Write a vector to the first three of an array."""
    numbers[0], numbers[1], numbers[2] = a[0], a[1], a[2]


@njit(**MERGED)
def add(numbers, a):
    """Add a vector to the first three of an array."""
    numbers[0] += a[0]
    numbers[1] += a[1]
    numbers[2] += a[2]


@njit(**MERGED)
def take(numbers, a):
    """Take a vector off the first three of an array."""
    numbers[0] -= a[0]
    numbers[1] -= a[1]
    numbers[2] -= a[2]


@njit(**MERGED)
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(**MERGED)
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(**MERGED)
def times(factor, a):
    """A multiple of a."""
    return factor * a[0], factor * a[1], factor * a[2]


@njit(**MERGED)
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**MERGED)
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]

"""Small dense matrices: product, factors, solution. Nothing is allocated."""

from __future__ import annotations

from numba import njit, types

from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type


@njit(types.void(matrix_type, matrix_type, matrix_type), **COMPILED)
def product(a: Matrix, b: Matrix, out: Matrix) -> None:
    """out = a b."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            out[i, j] = 0.0
        for k in range(a.shape[1]):
            x = a[i, k]
            for j in range(b.shape[1]):
                out[i, j] += x * b[k, j]


@njit(types.void(matrix_type, vector_type), **COMPILED)
def factorize(a: Matrix, pivots: Floats) -> None:
    """a becomes its triangular factors, with rows exchanged as ``pivots`` say."""
    n = a.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        pivots[k] = best
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        scale = 1.0 / a[k, k]
        for i in range(k + 1, n):
            x = a[i, k] * scale
            a[i, k] = x
            if x != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= x * a[k, j]


@njit(types.void(matrix_type, vector_type, vector_type), **COMPILED)
def substitute(a: Matrix, pivots: Floats, x: Floats) -> None:
    """x becomes the solution of the factorized system with the right-hand side x."""
    n = a.shape[0]
    for k in range(n):
        best = int(pivots[k])
        if best != k:
            x[k], x[best] = x[best], x[k]
    for i in range(n):
        total = x[i]
        for j in range(i):
            total -= a[i, j] * x[j]
        x[i] = total
    for i in range(n - 1, -1, -1):
        total = x[i]
        for j in range(i + 1, n):
            total -= a[i, j] * x[j]
        x[i] = total / a[i, i]

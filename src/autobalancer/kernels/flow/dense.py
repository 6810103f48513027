"""Small dense matrices: product, inverse, factors, solution. Nothing is allocated."""

from __future__ import annotations

from numba import types

from autobalancer.kernels.flags import COMPILED, INLINE, njit
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type


@njit(types.void(matrix_type, matrix_type, matrix_type), **COMPILED)
def product(a: Matrix, b: Matrix, out: Matrix) -> None:
    """out = a b; blocks of four by four, so that a row of b serves four rows and a row of ``out`` is touched seldom."""
    rows, depth, columns = a.shape[0], a.shape[1], b.shape[1]
    i = 0
    while i + 4 <= rows:
        for j in range(columns):
            out[i, j], out[i + 1, j], out[i + 2, j], out[i + 3, j] = 0.0, 0.0, 0.0, 0.0
        k = 0
        while k + 4 <= depth:
            a00, a01, a02, a03 = a[i, k], a[i, k + 1], a[i, k + 2], a[i, k + 3]
            a10, a11, a12, a13 = a[i + 1, k], a[i + 1, k + 1], a[i + 1, k + 2], a[i + 1, k + 3]
            a20, a21, a22, a23 = a[i + 2, k], a[i + 2, k + 1], a[i + 2, k + 2], a[i + 2, k + 3]
            a30, a31, a32, a33 = a[i + 3, k], a[i + 3, k + 1], a[i + 3, k + 2], a[i + 3, k + 3]
            for j in range(columns):
                b0, b1, b2, b3 = b[k, j], b[k + 1, j], b[k + 2, j], b[k + 3, j]
                out[i, j] += a00 * b0 + a01 * b1 + a02 * b2 + a03 * b3
                out[i + 1, j] += a10 * b0 + a11 * b1 + a12 * b2 + a13 * b3
                out[i + 2, j] += a20 * b0 + a21 * b1 + a22 * b2 + a23 * b3
                out[i + 3, j] += a30 * b0 + a31 * b1 + a32 * b2 + a33 * b3
            k += 4
        while k < depth:
            a00, a10, a20, a30 = a[i, k], a[i + 1, k], a[i + 2, k], a[i + 3, k]
            for j in range(columns):
                b0 = b[k, j]
                out[i, j] += a00 * b0
                out[i + 1, j] += a10 * b0
                out[i + 2, j] += a20 * b0
                out[i + 3, j] += a30 * b0
            k += 1
        i += 4
    while i < rows:
        for j in range(columns):
            out[i, j] = 0.0
        for k in range(depth):
            a00 = a[i, k]
            for j in range(columns):
                out[i, j] += a00 * b[k, j]
        i += 1


@njit(**INLINE)
def _exchange(a, pivots, k: int) -> None:  # type: ignore[no-untyped-def]
    """Bring the greatest number of column k, from row k on, into row k."""
    n, best = a.shape[0], k
    for i in range(k + 1, n):
        if abs(a[i, k]) > abs(a[best, k]):
            best = i
    pivots[k] = best
    if best != k:
        for j in range(n):
            a[k, j], a[best, j] = a[best, j], a[k, j]


@njit(types.void(matrix_type, vector_type), **COMPILED)
def invert(a: Matrix, pivots: Floats) -> None:
    """a becomes its inverse, by Gauss and Jordan with rows exchanged."""
    n = a.shape[0]
    for k in range(n):
        _exchange(a, pivots, k)
        scale = 1.0 / a[k, k]
        a[k, k] = 1.0
        for j in range(n):
            a[k, j] *= scale
        for i in range(n):
            x = a[i, k]
            if i != k and x != 0.0:
                a[i, k] = 0.0
                for j in range(n):
                    a[i, j] -= x * a[k, j]
    for k in range(n - 1, -1, -1):
        best = int(pivots[k])
        if best != k:
            for i in range(n):
                a[i, k], a[i, best] = a[i, best], a[i, k]


@njit(types.void(matrix_type, vector_type), **COMPILED)
def factorize(a: Matrix, pivots: Floats) -> None:
    """a becomes its triangular factors, transposed, with rows exchanged as ``pivots`` say."""
    n = a.shape[0]
    for k in range(n):
        _exchange(a, pivots, k)
        scale = 1.0 / a[k, k]
        for i in range(k + 1, n):
            x = a[i, k] * scale
            a[i, k] = x
            if x != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= x * a[k, j]
    for i in range(n):
        for j in range(i):
            a[i, j], a[j, i] = a[j, i], a[i, j]


@njit(types.void(matrix_type, vector_type, vector_type), **COMPILED)
def substitute(a: Matrix, pivots: Floats, x: Floats) -> None:
    """x becomes the solution of the system of :func:`factorize` with the right-hand side x."""
    n = a.shape[0]
    for k in range(n):
        best = int(pivots[k])
        if best != k:
            x[k], x[best] = x[best], x[k]
    for j in range(n):
        y = x[j]
        for i in range(j + 1, n):
            x[i] -= a[j, i] * y
    for j in range(n - 1, -1, -1):
        y = x[j] / a[j, j]
        x[j] = y
        for i in range(j):
            x[i] -= a[j, i] * y

"""What of a motion stands still, and what vibrates."""

from __future__ import annotations

import math
from typing import Any

from numba import float64, int64, types, void

from autobalancer.kernels.flags import EXACT, EXACT_PART, njit
from autobalancer.kernels.measures.equations import least_squares, reduce, square
from autobalancer.kernels.measures.gauges import complex_matrix_type, complexes_type
from autobalancer.kernels.measures.limits import SAME_MOTION
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type
from autobalancer.kernels.trigonometry import sine_cosine

columns_type = types.Array(types.complex128, 2, "A")


@njit(
    void(
        columns_type, int64, vector_type, matrix_type, int64, complex_matrix_type, complex_matrix_type, complexes_type,
    ),
    **EXACT,
)  # fmt: skip
def standing(
    z: Any, count: int, rotor: Floats, balls: Matrix, centered: int, work: Any, small: Any, found: Any
) -> None:
    """The part of x + i y that stands still, of each column of ``count`` rows; zero where nothing can deflect a rotor for good.

    ``rotor`` is its angle, at equal steps over whole turns, ``balls`` are the angles of the balls in space, rad. Where some of
    them go round both in space and in the rotor, the revolutions of the rotor are not those of the deflection. Then the standing
    part is fitted together with what whirls with the rotor, with the balls, and against them. Weights that vanish at both ends
    (Hann's) suppress the rest. ``work`` is (T, 1 + 2 (1 + n) + columns), ``small`` as many columns square and two more.
    """
    columns, last, whirling = z.shape[1], count - 1, 0
    for k in range(columns):
        found[k] = complex(0.0, 0.0)
    if centered != 0 or count == 0:
        return
    turned = rotor[last] - rotor[0]
    for i in range(balls.shape[1]):
        way = balls[last, i] - balls[0, i]
        if abs(way) > 2.0 * math.pi and abs(way - turned) > math.pi:
            whirling += 1
    if whirling == 0:
        for k in range(columns):
            total = complex(0.0, 0.0)
            for t in range(count):
                total += z[t, k]
            found[k] = total / count
        return
    size = 1 + 2 * (1 + whirling)
    for t in range(count):
        weight, place = math.sin(math.pi * (t + 0.5) / count), 1
        work[t, 0] = weight
        for i in range(-1, balls.shape[1]):
            angle = rotor[t]
            if i >= 0:
                way = balls[last, i] - balls[0, i]
                if not (abs(way) > 2.0 * math.pi and abs(way - turned) > math.pi):
                    continue
                angle = balls[t, i]
            s, c = sine_cosine(angle)
            work[t, place] = complex(weight * c, weight * s)
            work[t, place + 1 + whirling] = complex(weight * c, -weight * s)
            place += 1
        for k in range(columns):
            work[t, size + k] = weight * z[t, k]
    reduce(work, count, size, columns, small)
    least_squares(small, size, columns, SAME_MOTION, work)
    for k in range(columns):
        found[k] = small[0, size + k]


@njit(float64(columns_type, int64, int64, types.complex128), **EXACT_PART)
def one_way_rms(z: Any, k: int, count: int, mean: complex) -> float:
    """Root mean square of column k along the direction in which it is greatest."""
    size, turned = 0.0, complex(0.0, 0.0)
    for t in range(count):
        a = z[t, k] - mean
        size += square(a)
        turned += a * a
    return math.sqrt(0.5 * (size + math.sqrt(square(turned))) / count)


@njit(void(columns_type, columns_type, int64, complexes_type, matrix_type), **EXACT)
def moved(z: Any, v: Any, count: int, mean: Any, found: Matrix) -> None:
    """Of each column of ``count`` rows: greatest distance from a mean place, rms of that distance and of the velocity.

    The rms are those along the direction in which they are greatest; ``found`` is (3, columns or more).
    """
    for k in range(z.shape[1]):
        greatest = 0.0
        for t in range(count):
            greatest = max(greatest, square(z[t, k] - mean[k]))
        found[0, k] = math.sqrt(greatest)
        found[1, k] = one_way_rms(z, k, count, mean[k])
        found[2, k] = one_way_rms(v, k, count, complex(0.0, 0.0))


@njit(float64(columns_type, int64, int64), **EXACT_PART)
def mean_size(z: Any, k: int, count: int) -> float:
    """Mean size of column k."""
    total = 0.0
    for t in range(count):
        total += math.sqrt(square(z[t, k]))
    return total / count


@njit(void(complexes_type, vector_type), **EXACT)
def sizes(z: Any, found: Floats) -> None:
    """Size of each x + i y."""
    for k in range(z.size):
        found[k] = math.sqrt(square(z[k]))


@njit(void(complexes_type, vector_type), **EXACT)
def directions(z: Any, found: Floats) -> None:
    """Angle of each, rad."""
    for k in range(z.size):
        found[k] = math.atan2(z[k].imag, z[k].real)

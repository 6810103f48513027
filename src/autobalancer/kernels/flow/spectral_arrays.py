"""What the spectral flow solver keeps: matrices of the grid, fields with their past, a clock.

Fields are (m, n): m inner points or shares along r, n along z. A *share* belongs to a product of eigenvectors of D2. g and
psi_z are even about mid-height and q, psi odd where the walls are, and then n counts half of the height; the matrices along z
of even and odd fields differ, and equal one another where the whole height is kept.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import types
from numba.core.types import NamedTuple as NamedTupleType

from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

# clock; AGO: lengths of past steps
(
    TIME, LENGTH, CONVECTION, SHIFT, KNOWN, ACCEPTED, REJECTED, HEAD, LEAST, LOST, REFERENCE, WAVES, AGO,
) = range(13)  # fmt: skip
CLOCK = AGO + 4
LEVELS = 5  # of the past that are kept, one of them for the step that is tried

stack_type = types.float64[:, :, ::1]


class Plan(NamedTuple):
    """What does not change. Matrices along z are transposed, to be multiplied from the right."""

    over_r: Floats  # 1/r
    over_dr: Floats  # 1/spacing
    over_dz: Floats
    orbit_r: Floats  # weights of the inner points of g in its interpolation at the orbit
    orbit_z: Floats
    r_forward: Matrix  # values to shares, filtered
    r_backward: Matrix
    r_slope: Matrix  # shares to d/dr
    even_forward: Matrix
    odd_forward: Matrix
    even_backward: Matrix
    odd_backward: Matrix
    even_slope: Matrix  # values to d/dz
    odd_slope: Matrix
    to_even: Matrix  # d/dz of shares, odd to even
    to_odd: Matrix
    even_rates: Matrix  # L
    odd_rates: Matrix
    source: Matrix  # shares of r^2
    lift: Matrix  # what walls with their own speed add to the shares of nu D2 g,
    wall_r: Matrix  # to g_r
    wall_z: Matrix  # to g_z,
    wall_wave: Matrix  # and to its shares
    near_r: Matrix  # (2, m): columns of d/dr that belong to the walls
    near_z: Matrix  # (walls, n): the same along z, of odd fields
    c: Matrix  # (2, m): columns of D2 that belong to the walls, in shares
    d: Matrix  # (walls, n)
    p: Matrix  # (2, m): slopes at the walls of shares
    s: Matrix  # (walls, n)
    right: Matrix  # (corners, size)
    left: Matrix
    viscosity: float
    orbit_wall: float  # what the walls add to g at the orbit


class State(NamedTuple):
    """The past is a ring of ``LEVELS``, where ``clock[HEAD]`` is the present."""

    g: Floats  # values; (level, m, n)
    g_share: Floats
    q_share: Floats
    g_rate: Floats  # shares of the convection terms
    q_rate: Floats
    g_wave: Floats  # shares of psi_z
    q_wave: Floats  # shares of g_z
    green: Floats  # (m, n, n): inverse of one row of the implicit step
    psi_share: Matrix
    a: Matrix
    b: Matrix
    g_r: Matrix
    g_z: Matrix
    q: Matrix
    q_r: Matrix
    q_z: Matrix
    psi_r: Matrix
    psi_z: Matrix
    scale: Matrix  # 1/(s - nu L) of even fields
    block: Matrix  # (n, n)
    influence: Matrix
    q_side: Matrix  # (2, n): q at the cylinders
    q_lid: Matrix  # (walls, m): q at the lids
    weights: Matrix  # (3, 5): derivative, extrapolation of the terms, of the values
    pivots: Floats
    rows: Floats
    columns: Floats
    unknown: Floats
    speeds: Floats  # (level,)


plan_type = NamedTupleType([vector_type] * 5 + [matrix_type] * 26 + [types.float64] * 2, Plan)
state_type = NamedTupleType([stack_type] * 8 + [matrix_type] * 16 + [vector_type] * 5, State)

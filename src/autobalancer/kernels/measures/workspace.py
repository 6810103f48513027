"""What measures need of a machine besides its equations, and the room in which they are computed.

R coordinates of the rotor, n balls, L places, S supports, P planes of balancers, k speeds of a table. Rows that are multiplied by
coordinates stand coordinate by coordinate, so that all places are summed at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from autobalancer.kernels.compiler.numba_struct import passed_by_address, struct_type
from autobalancer.kernels.records import MEETING
from autobalancer.kernels.system import Floats, Integers, Matrix, Rows, integers_type, matrix_type, vector_type

Complexes = NDArray[np.complex128]

matrices_type = types.Array(types.float64, 3, "C")
complex_matrix_type = types.Array(types.complex128, 2, "C")
complexes_type = types.Array(types.complex128, 1, "C")


@passed_by_address
class MeasureInputs(NamedTuple):
    """Numbers of one machine, filled by assembly/places.py; all arrays are contiguous, so that many fit in a stack."""

    scalars: Floats  # (SCALARS,)
    rows: Matrix  # (R, 2 L) deflections of the places along x and y
    speeds: Floats  # (k,) of the tables of forces
    stiffness: Matrix  # (k, R, 2 S) forces on the supports in a run
    damping: Matrix  # (k, R, 2 S)
    weight: Floats  # (2 S,) of the rotor without balls, N
    rubber: Matrix  # (2 M, 2 S) forces on the supports for those of M pieces of rubber
    hard: Matrix  # (2 H, 2 S) the same for H bearings that become stiffer
    ball_mass: Floats  # (n,) effective, kg
    ball_moment: Floats  # (n,) effective mass times orbit radius, kg m
    ball_centers: Matrix  # (n, 2) centers of their races in the rotor, m
    ball_planes: Integers  # (n,) number of the plane of each
    capability: Floats  # (P,) of the balls of each plane, kg m
    mass: Matrix  # (R, R) with the balls on the rotor
    gyroscopic: Matrix  # (R, R) of speed one
    model_speeds: Floats  # (j,) of the tables of the rotor
    model_damping: Matrix  # (j, R, R)
    model_stiffness: Matrix  # (j, R, R)
    held_stiffness: Matrix  # (k, R, 2 S) forces on the supports with the balls held
    held_damping: Matrix  # (k, R, 2 S)
    held_loads: Matrix  # (2, R) unbalance of the balls spread evenly over their races, real and imaginary parts, kg m
    jumps: Floats  # (J,) times at which the unbalance jumps, s
    meetings: Rows  # (touches,) what an impact means in each contact
    rebounds: Floats  # laws of restitution one behind the other
    whirls: Matrix  # (K, 2) critical speeds with the balls on the rotor, ascending, rad/s, and gyroscopic shares


# places in MeasureInputs.scalars: whether nothing can deflect the rotor for good; whether the balls are resolved; how the
# motion with balls held is found; whether the rotor moves in its plane only
CENTERED, RESOLVED, HELD, PLANAR, SCALARS = range(5)

inputs_type = struct_type(types.NamedTuple(
    [
        vector_type, matrix_type, vector_type, matrices_type, matrices_type, vector_type, matrix_type, matrix_type,
        vector_type, vector_type, matrix_type, integers_type, vector_type, matrix_type, matrix_type,
        vector_type, matrices_type, matrices_type, matrices_type, matrices_type, matrix_type, vector_type,
        MEETING.rows_type(), vector_type, matrix_type,
    ],
    MeasureInputs,
))  # fmt: skip


class Observables(NamedTuple):
    """What T states say of places, planes and supports, in space; unbalances in the rotor."""

    z: Complexes  # (T, L) deflection x + i y of each place, m
    v: Complexes  # (T, L) its velocity, m/s
    force: Complexes  # (T, S) on each support, N
    wanted: Complexes  # (T, P) unbalance that the balls of the plane have to balance, kg m
    held: Complexes  # (T, P) what its balls add up to, kg m
    unbalance: Complexes  # (T, 1) resultant unbalance of the rotor, kg m
    left: Complexes  # (T, 1) what is left of it with all balls, kg m
    angles: Matrix  # (T, n) of the balls in space, rad


observables_type = types.NamedTuple([complex_matrix_type] * 7 + [matrix_type], Observables)


@passed_by_address
class Workspace(NamedTuple):
    """Room for one run at a time, for one thread: B bins, T states in the last revolutions."""

    seen: Observables
    place: Floats  # (R,) work
    move: Floats  # (R,) work
    push: Floats  # (2 most,) work
    rotor: Floats  # (T,) angle of the rotor, rad
    end: Floats  # (B,) of the bins, s
    middle: Floats  # (B,) s
    width: Floats  # (B,) s
    speed: Floats  # (B,) at their ends, rad/s
    angle: Matrix  # (B, n) of the balls in the rotor, rad
    rate: Matrix  # (B, n) rad/s
    of_balls: Matrix  # (4 + measures of balls, n) work
    of_places: Matrix  # (2 + measures of places, most) work: of places and supports
    columns: Complexes  # (T, columns) work of the fit of what stands still
    small: Complexes  # (rows, columns) work of equations
    mean: Complexes  # (most,) static parts
    hits: Matrix  # (4, I) time, speed, energy and impulse of the impacts that were noted
    noted: Integers  # (1,) how many stand there


workspace_type = struct_type(types.NamedTuple(
    [
        observables_type, vector_type, vector_type, vector_type, vector_type, vector_type, vector_type, vector_type, vector_type,
        matrix_type, matrix_type, matrix_type, matrix_type, complex_matrix_type, complex_matrix_type, complexes_type,
        matrix_type, integers_type,
    ],
    Workspace,
))  # fmt: skip

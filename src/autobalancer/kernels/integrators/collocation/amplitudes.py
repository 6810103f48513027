"""What collocation remembers between two calls, beside the memory of every stepper: the motion at the nodes of a step.

Unknowns have a row of eight lanes each, one lane for a node. With K modes and n balls the rows of ``values`` are

    amplitudes (2 K: real and imaginary part of each), rotor speed, rotor angle, ball angles (n), ball speeds (n)

and those of ``forces`` what drives them: 2 K of the amplitudes, p' = (exponent - i turning w0) p + force, the acceleration of the
rotor, the accelerations of the balls (n). w0 is a frozen speed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.integrators.collocation.radau import Radau, radau, radau_type
from autobalancer.kernels.pointers import pointer_to
from autobalancer.kernels.system import Floats, Integers, integers_type, vector_type
from autobalancer.kernels.wide import NODES

# places in Amplitudes.held
FROZEN, FROZEN_BEFORE, LENGTH_BEFORE, LENGTH_KNOWN, FROZEN_KNOWN, DECAY_KNOWN = range(6)
# step of the explicit pair when it was used last; when the work of long steps was counted last
PAIR_STEP, SINCE = 6, 7
BEGINS = 8  # where in the last step this one begins
BASIS = 9  # number of the modes in force, collocation/bases.py; -1: none yet
STEP_KNOWN = 10  # step for which the matrices of collocation/rates.py are known
HELD = 11
# places in Amplitudes.tallies
SWEEPS, RENEWED, UNSETTLED, LONG_STEPS, EXPLICIT, LEFT, CHUNK, IN_A_ROW, SWEEPS_THEN, HANDED = range(10)
TALLIES = 10


class Amplitudes(NamedTuple):
    """Numbers of a linear rotor with K modes and n balls, and the work space of its steps."""

    modes: int  # K
    balls: int  # n
    turning: int  # 1 if the axes turn with the rotor
    radau: Radau
    exponents: Floats  # (2 K,) real and imaginary part
    places: Integers  # (2 K,) where in the state the coordinates and their velocities are
    shapes: Floats  # (2 K 2 K) row by row: coordinates from amplitudes
    inverse: Floats  # (2 K 2 K) amplitudes from coordinates
    numbers: Floats  # own numbers of the equations at the nodes
    bases: Floats  # modes at several speeds, collocation/bases.py; (0,) where they are the same at any speed
    held: Floats  # (HELD,)
    tallies: Integers  # (TALLIES,)
    begin: Floats  # (2 K,) amplitudes at the begin of a step
    weights: Floats  # (rows of values,) inverse tolerances
    values: Floats
    forces: Floats
    forces_before: Floats  # of the last step
    amplitudes_before: Floats  # (2 K 8)
    decays: Floats  # (K 8) e^(Re z c)
    factors: Floats  # (K 16) e^(z c): eight real parts, eight imaginary parts
    sums: Floats  # (K 128) what the forces do: 64 real parts, 64 imaginary parts
    free: Floats  # (2 K,) amplitudes that no force drives, for the dense output
    rates: Floats  # (1 + n) how fast the speeds of rotor and balls die out by themselves, 1/s, collocation/rates.py
    rates_known: Floats  # (1 + n) these times the step, for which there are
    solvers: Floats  # ((1 + n) 64) matrices that integrate the speeds
    solver_places: Integers  # (1 + n) where each of them begins
    heads: Integers  # (1 + n) whose acceleration each of them has: its own number, or that of a ball that it touches
    inside: Floats  # as values, at eight places of a piece of the step
    stretch: Floats  # (64,) forces of the last step at the nodes of this one
    origin: Floats  # (n,) state at the begin of the step
    reached: Floats  # (n,) state at the end of a piece
    balls_work: Floats  # (8 n 8 + 16) rows of the balls, and the acceleration of their race
    work: Floats  # (WORK,)


WORK = 20 * NODES + 64
NO_BASES = np.zeros(0)
amplitudes_type = types.NamedTuple(
    [types.int64] * 3
    + [radau_type, vector_type, integers_type]
    + [vector_type] * 5
    + [integers_type]
    + [vector_type] * 13
    + [integers_type] * 2
    + [vector_type] * 6,
    Amplitudes,
)
amplitudes_at = pointer_to(amplitudes_type)
nodes_type = types.FunctionType(types.void(types.float64, types.float64, types.voidptr, types.voidptr))
"""(time, step, system, amplitudes): ``forces`` from ``values`` at all nodes of the step that begins at ``time``."""
watch_type = types.FunctionType(types.float64(types.float64, types.voidptr, types.voidptr))
"""(step, system, amplitudes): the fraction of the step up to which these forces hold, 1 if to its end.

SWITCHES if the switch has to tell.
"""
SWITCHES = 2.0


def _held() -> Floats:
    found = np.full(HELD, np.nan)
    found[BASIS] = -1.0
    return found


def amplitudes(
    exponents: np.ndarray,
    shapes: Floats,
    places: Integers,
    balls: int,
    numbers: Floats,
    size: int,
    *,
    turning: bool,
    bases: Floats = NO_BASES,
) -> Amplitudes:
    """Fresh ones.

    Parameters
    ----------
    exponents
        (K,) complex, of the modes at a speed of zero.
    shapes
        (2 K, 2 K) coordinates and velocities from real and imaginary parts of the amplitudes, alternating.
    places
        (2 K,) where these coordinates are in the state.
    size
        Length of the state.
    balls, numbers, turning
        See :class:`Amplitudes`.
    """
    modes = len(exponents)
    values, forces = 2 * modes + 2 + 2 * balls, 2 * modes + 1 + balls
    return Amplitudes(
        modes=modes,
        balls=balls,
        turning=int(turning),
        radau=radau(),
        exponents=np.column_stack([np.real(exponents), np.imag(exponents)]).astype(np.float64).ravel(),
        places=np.asarray(places, np.int64),
        shapes=np.array(shapes, np.float64).ravel(),
        inverse=np.asarray(np.linalg.inv(shapes), np.float64).ravel(),
        numbers=np.array(numbers, np.float64),
        bases=bases,
        held=_held(),
        tallies=np.zeros(TALLIES, np.int64),
        begin=np.zeros(2 * modes),
        weights=np.zeros(values),
        values=np.zeros(NODES * values),
        forces=np.zeros(NODES * forces),
        forces_before=np.zeros(NODES * forces),
        amplitudes_before=np.zeros(NODES * 2 * modes),
        decays=np.zeros(NODES * modes),
        factors=np.zeros(2 * NODES * modes),
        sums=np.zeros(2 * NODES * NODES * modes),
        free=np.zeros(2 * modes),
        rates=np.zeros(1 + balls),
        rates_known=np.full(1 + balls, np.nan),
        solvers=np.zeros(NODES * NODES * (1 + balls)),
        solver_places=np.zeros(1 + balls, np.int64),
        heads=np.arange(1 + balls),
        inside=np.zeros(NODES * values),
        stretch=np.zeros(NODES * NODES),
        origin=np.zeros(size),
        reached=np.zeros(size),
        balls_work=np.zeros(NODES * (8 * balls + 2)),
        work=np.zeros(WORK),
    )

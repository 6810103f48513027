"""The layout of ``System.rotor``: header, matrices, work space, loads of unbalance."""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from autobalancer.kernels.flags import INLINE

# header of System.rotor; the last three: where the rows of kernels/race_layout.py begin (0: none), whether balls rub and
# stick, where the excitations begin (0: none)
COORDINATES, WIDTH, PLACES, ROWS, TABLE, AXIAL_GRAVITY, BALL_ROWS, RUBBING, SHAKERS, HEADER = range(10)


class Blocks(NamedTuple):
    """Where the blocks of ``System.rotor`` begin, and the places in its work space."""

    gyroscopic: int  # G, times M^-1 as C and K; matrices column by column
    damping: int  # C at each speed of the table
    stiffness: int  # K at each speed
    spin: int  # N = G/2
    place: int  # B, by rows
    reach: int  # B M^-1, by rows
    host: int  # H = B M^-1 B^T
    q: int
    v: int
    f: int  # q'' = f - w' g
    g: int
    raw: int  # M g
    left: int  # 1 + H S
    one: int  # right-hand sides
    two: int
    pushing: int  # forces R on the stations
    arms: int  # c: what w' adds to them
    turning: int  # what the accelerations of the stations add to the torque
    own: int  # S
    loads: int  # of each segment: M^-1 u (real, imaginary part), u, and the rates of all four


@njit(**INLINE)
def blocks(width: int, rows: int, table: int) -> Blocks:
    """For ``width`` coordinates (in whole lanes), ``rows`` of all stations together and ``table`` speeds.

    The last number of the loads of a segment, beyond the coordinates, says whether they change.
    """
    square = width * width
    gyroscopic = HEADER + table
    damping = gyroscopic + square
    stiffness = damping + table * square
    spin = stiffness + table * square
    place = spin + square
    reach = place + rows * width
    host = reach + rows * width
    q = host + rows * rows
    left = q + 5 * width
    one = left + rows * rows
    return Blocks(
        gyroscopic, damping, stiffness, spin, place, reach, host, q, q + width, q + 2 * width, q + 3 * width, q + 4 * width,
        left, one, one + rows, one + 2 * rows, one + 3 * rows, one + 4 * rows, one + 5 * rows, q + 5 * width + rows * (rows + 9),
    )  # fmt: skip

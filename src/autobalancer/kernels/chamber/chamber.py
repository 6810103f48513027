"""What a step takes: a chamber with its machine, and room for samples."""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types

from autobalancer.kernels.chamber import records as of
from autobalancer.kernels.fields import Row, Rows

Array = Any


class Pairs(NamedTuple):
    """Balls that may touch; as many rows as there is room for pairs, of which the first ``progress.pairs`` count."""

    first: Array  # number of the ball with the lower number
    second: Array
    touching: Array  # 1 while they touch
    stretch: Array  # (., 3) of the tangential spring, m
    listed: Array  # (n, 3) where the balls were when the pairs were listed, from the middle of the rotor, m


class Search(NamedTuple):
    """Scratch of the search for pairs."""

    old_row: Array  # (n + 1,) where the partners of each ball begin in the next two
    old_second: Array
    old_stretch: Array
    cells: Array  # starts of the cells
    order: Array  # (n,) balls, cell by cell
    places: Array  # (n,) cell of each ball


class Scratch(NamedTuple):
    """What is written before it is read in every step."""

    search: Search
    contacts: Row  # CONTACTS
    equations: Array  # (7, 8) of the body: mass matrix, and the right-hand side in the last column
    reduced: Array  # (7, 8) those of its free coordinates
    begun: Rows  # (n,) MOTION of the balls at the start of a step
    gone: Rows  # (n,) sum of their slopes
    body_begun: Row  # BODY_MOTION likewise
    body_gone: Row


class Chamber(NamedTuple):
    """A machine with chambers: what describes it, what a run changes, and scratch."""

    run: Row  # RUN
    contact: Row  # CONTACT
    machine: Row  # MACHINE
    rooms: Rows  # ROOM of each chamber
    pair_stiffness: Array  # (kinds, kinds) N/m^1.5; of cylinders the reduced modulus, Pa
    rebounds: Array  # tables of restitution squared or damping ratio; may be empty
    pair_rebounds: Array  # (kinds, kinds + 1) where the table of a pair begins, in the last column that of the walls
    profile: Rows  # PROFILE
    balls: Rows  # BALL
    wall_stretch: Array  # (n, WALLS, 3) of the tangential springs at the walls, m
    pairs: Pairs
    body: Row  # BODY
    power: Row  # POWER of the last evaluation
    before: Row  # POWER of the last step
    account: Row  # ACCOUNT
    since: Row  # SINCE the last sample
    progress: Row  # PROGRESS
    scratch: Scratch


class Samples(NamedTuple):
    """Room for samples, each after ``every`` steps."""

    every: int
    rows: Rows  # (k,) SAMPLE
    balls: Rows  # (k, n) MOTION


DESCRIBED = Chamber._fields[:8]
CHANGED = Chamber._fields[8:17]

_matrix = types.float64[:, ::1]
_short = types.int32[::1]
_search = types.NamedTuple([_short, _short, _matrix, types.int64[::1], _short, _short], Search)
_scratch = types.NamedTuple(
    [
        _search, of.CONTACTS.row_type, _matrix, _matrix, of.MOTION.rows_type(), of.MOTION.rows_type(),
        of.BODY_MOTION.row_type, of.BODY_MOTION.row_type,
    ],
    Scratch,
)  # fmt: skip
CHAMBER = types.NamedTuple(
    [
        of.RUN.row_type, of.CONTACT.row_type, of.MACHINE.row_type, of.ROOM.rows_type(), _matrix,
        types.float64[::1], types.int64[:, ::1], of.PROFILE.rows_type(),
        of.BALL.rows_type(), types.float64[:, :, ::1],
        types.NamedTuple([_short, _short, types.int8[::1], _matrix, _matrix], Pairs),
        of.BODY.row_type, of.POWER.row_type, of.POWER.row_type, of.ACCOUNT.row_type, of.SINCE.row_type,
        of.PROGRESS.row_type, _scratch,
    ],
    Chamber,
)  # fmt: skip
SAMPLES = types.NamedTuple([types.int64, of.SAMPLE.rows_type(), of.MOTION.rows_type(2)], Samples)

"""The speed of the walls over time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from autobalancer.assembly.guided import uniform_table
from autobalancer.assembly.profile import Piece, SpeedProfile, profile_pieces
from autobalancer.flow.annulus import Floats
from autobalancer.kernels.annulus_flow import RECORD
from autobalancer.kernels.records import HILL
from autobalancer.machine import Constant
from autobalancer.units import texts_argument


@dataclass(frozen=True)
class Recorded:
    """A speed known at instants, as one piece; ``numbers`` as ``kernels/annulus_flow.py`` has them."""

    start: float
    kind: int
    numbers: Floats

    @cached_property
    def times(self) -> Floats:
        """Equally spaced, s."""
        return np.asarray(self.start + self.numbers[0] * np.arange(int(self.numbers[1])), np.float64)

    @cached_property
    def curve(self) -> CubicHermiteSpline:
        """The speed between the first and the last instant."""
        return CubicHermiteSpline(self.times, self.numbers[2::2], self.numbers[3::2] / self.numbers[0])

    def at(self, time: float) -> tuple[float, float]:
        """Speed and rate; constant outside."""
        inside = min(max(time, self.start), float(self.times[-1]))
        return float(self.curve(inside)), float(self.curve(inside, 1)) if inside == time else 0.0


@dataclass(frozen=True)
class WallSpeed:
    """Speed over time from the pieces of a profile; what happened before time zero is ``before``, rad/s."""

    pieces: tuple[Piece | Recorded, ...]
    before: float

    def piece(self, time: float) -> Piece | Recorded:
        """The piece in force just after ``time``."""
        starts = [piece.start for piece in self.pieces]
        return self.pieces[max(bisect_right(starts, time) - 1, 0)]

    def at(self, time: float, piece: Piece | Recorded | None = None) -> tuple[float, float]:
        """Speed (rad/s) and its rate (rad/s^2); ``piece`` tells sides apart at a corner."""
        piece = piece or self.piece(time)
        if isinstance(piece, Recorded):
            return piece.at(time)
        c0, c1, c2, c3 = piece.numbers
        if piece.kind == HILL:
            if time <= 0.0:
                return c3, 0.0
            ratio = (time / c1) ** c2
            rise = ratio / (1.0 + ratio)
            return c3 + (c0 - c3) * rise, (c0 - c3) * rise * c2 / (time * (1.0 + ratio))
        return c0 + c1 * (time - piece.start), c1

    def over(self, times: Floats) -> Floats:
        """Speeds at ``times``, rad/s."""
        return np.array([self.at(float(t))[0] for t in times])

    def corners(self, end: float) -> list[float]:
        """Times inside (0, end) at which the rate may jump."""
        return [piece.start for piece in self.pieces if 0.0 < piece.start < end]

    @property
    def settled(self) -> float:
        """Time from which the speed no longer changes, s; infinite if it always does."""
        last = self.pieces[-1]
        return last.start if last.kind not in (HILL, RECORD) and last.numbers[1] == 0.0 else math.inf

    def fastest(self, end: float) -> float:
        """Greatest magnitude of the speed up to ``end``, rad/s; every piece of a profile is monotonic."""
        times = np.array([0.0, *self.corners(end), end])
        if isinstance(self.pieces[0], Recorded):
            times = self.pieces[0].times
            times = np.append(times[(times > 0.0) & (times < end)], [0.0, end])
        return float(max(np.abs(self.over(times)).max(), abs(self.before)))


def recorded_speed(times: Floats | Sequence[str] | str, speeds: Floats | Sequence[str] | str) -> WallSpeed:
    """A speed that was measured or simulated, for :func:`autobalancer.flow.annulus_problem.annulus_flow`.

    Parameters
    ----------
    times
        Ascending, s; (time,). Speeds are smooth and monotone between them, and constant before and after.
    speeds
        rad/s; (time,).
    """
    times = texts_argument("times", times, "s")
    speeds = texts_argument("speeds", speeds, "rad/s")
    table = uniform_table(np.asarray(times, np.float64), np.asarray(speeds, np.float64))
    pairs = np.column_stack([table.values, table.slopes]).ravel()
    piece = Recorded(float(times[0]), RECORD, np.array([table.step, table.values.size, *pairs]))
    alone = WallSpeed((piece,), 0.0)
    return WallSpeed((piece,), alone.at(0.0)[0])


def wall_speed(profile: SpeedProfile | WallSpeed | float, initial: float | None = None) -> WallSpeed:
    """From a profile or one speed; the fluid turns with ``initial`` before time zero, by default with the profile."""
    if isinstance(profile, WallSpeed):
        return profile if initial is None else WallSpeed(profile.pieces, initial)
    part: SpeedProfile = Constant(speed=profile) if isinstance(profile, (int, float)) else profile
    pieces = tuple(profile_pieces(part))
    first = WallSpeed(pieces, 0.0).at(0.0, pieces[0])[0]
    return WallSpeed(pieces, first if initial is None else initial)

"""How a run got to its end: its greatest deflection and the balls that settle, also between jumps of the unbalance.

Where balls still creep at the end, they are followed to where they come to rest. A slow ball has the speed at which the fluid
balances the force of the rotor: for ball i of plane p it is Im(exp(-i phi_i) sum_q g_pq R_q), where R_q is what is left of the
unbalance of plane q. The complex gains g are fitted to the run, and these equations are integrated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.limits import LAST, SETTLED
from autobalancer.results.jumps import jump_times, parts_between_jumps
from autobalancer.results.measures import peak_deflection, settling_time
from autobalancer.results.places import Complexes, Floats, plane_vectors
from autobalancer.results.recorded_of import balls_of

BLOCKS = 40  # of the time after the run-up, to which the way of the balls is fitted
MISFIT = 0.2  # of these ways, relative, from which on nothing is extrapolated
AHEAD = 1000.0  # times the run, for which the balls are followed
NEAR = 0.8  # of the tolerance, within which a ball is sure to count as settled
SAME_SHARE = 0.05  # of the unbalance, within which the residual is that of settled balls


@dataclass(frozen=True)
class Peak:
    """Greatest deflection of a run at the reference station (m) and the speed there (rad/s)."""

    place: str
    deflection: float
    speed: float


@dataclass(frozen=True)
class Settling:
    """The ball that settles last: how long it takes, from when, and when that is in the run, s; ``moving`` never settle."""

    ball: int
    duration: float
    counted_from: str
    settled_at: float
    moving: tuple[int, ...]


@dataclass(frozen=True)
class Forecast:
    """Where balls go that still move: their ``speed`` at the end (rad/s), and extrapolated ``share`` and ``duration``.

    ``share`` is residual over unbalance once they have settled, ``duration`` (s) that of a run that shows it; both nan where
    nothing can be extrapolated.
    """

    speed: float
    share: float = np.nan
    duration: float = np.nan


@dataclass(frozen=True)
class RunPart:
    """A part of a run between jumps of its unbalance, from ``begin`` to ``end`` (s)."""

    begin: float
    end: float
    peak: Peak | None
    settling: Settling | None


def parts_of(run: xr.Dataset) -> tuple[RunPart, ...]:
    """The parts between jumps of the unbalance; none if it does not jump."""
    if not jump_times(run):
        return ()
    return tuple(RunPart(begin, end, peak_of(part), settling_of(part)) for begin, end, part in parts_between_jumps(run))


def peak_of(run: xr.Dataset) -> Peak | None:
    """The greatest deflection; None of a run that kept no data for it."""
    try:
        found = peak_deflection(run)
    except QuestionError:
        return None
    return Peak(str(run.attrs["reference_station"]), float(found["deflection"]), float(found["speed"]))


def settling_of(run: xr.Dataset) -> Settling | None:
    """The ball that settles last; None without balls, or without data."""
    if not run.sizes.get("ball", 0):
        return None
    try:
        found = settling_time(run)
    except QuestionError:
        return None
    at = found["settled_at"].values
    moving = tuple(int(ball) for ball in found["ball"].values[np.isnan(at)])
    if len(moving) == at.size:
        return Settling(0, np.nan, "", np.nan, moving)
    last = int(np.nanargmax(at))
    return Settling(last + 1, float(found[last]), str(found["counted_from"].values), float(at[last]), moving)


def forecast_of(run: xr.Dataset, since: float) -> Forecast | None:
    """Where the balls go that have not settled, from their motion after ``since`` (s); None without balls or data."""
    try:
        balls = balls_of(run)
    except QuestionError:
        return None
    if balls is None or balls.time.size < 3:
        return None
    late = int(np.searchsorted(balls.time, (1.0 - LAST) * balls.time[-1]))
    late = min(late, balls.time.size - 2)
    way = np.abs(balls.angle[-1] - balls.angle[late]).max()
    speed = float(way / (balls.time[-1] - balls.time[late]))
    inside = balls.time >= 0.5 * (since + balls.time[-1])
    if "plane_balls" not in run or int(inside.sum()) < 2 * BLOCKS:
        return Forecast(speed)
    unbalance = plane_vectors(run)[0]
    plane = run["ball_plane"].values - 1 if "ball_plane" in run else np.zeros(balls.angle.shape[1], np.int64)
    moment = run["ball_moment"].values * (plane == np.arange(unbalance.shape[1])[:, None])  # (P, n)
    return Forecast(speed, *_followed(balls.time[inside], balls.angle[inside], unbalance[inside], moment))


def _followed(time: Floats, angle: Floats, unbalance: Complexes, moment: Floats) -> tuple[float, float]:
    """Share of the residual that settled balls leave, and duration (s) of a run that shows it; nan where it is not known."""
    from scipy.integrate import cumulative_trapezoid, solve_ivp

    size, plane = float(np.abs(unbalance[-1]).sum()), moment.argmax(axis=0)
    if not size > 0.0:
        return np.nan, np.nan
    unbalance, moment = unbalance / size, moment / size

    def left(balls: Floats, of: Complexes) -> Complexes:
        return np.asarray(of + np.exp(1j * balls) @ moment.T, np.complex128)

    edges = np.linspace(0, time.size - 1, BLOCKS + 1).astype(int)
    gains = np.zeros((len(moment), len(moment)), np.complex128)
    missed = total = 0.0
    for p in range(len(moment)):
        rows, ways = [], []
        for i in np.flatnonzero(plane == p):
            drive = np.exp(-1j * angle[:, i])[:, None] * left(angle, unbalance)
            done = cumulative_trapezoid(np.hstack([drive.imag, drive.real]), time, axis=0, initial=0.0)
            rows.append(np.diff(done[edges], axis=0))
            ways.append(np.diff(angle[edges, i]))
        if rows:
            matrix, way = np.vstack(rows), np.concatenate(ways)
            gain = np.linalg.lstsq(matrix, way, rcond=1e-6)[0]
            gains[p] = gain[: len(moment)] + 1j * gain[len(moment) :]
            missed, total = missed + float(((matrix @ gain - way) ** 2).sum()), total + float((way**2).sum())
    if not missed < MISFIT**2 * total:
        return np.nan, np.nan
    now = unbalance[-1]

    def turning(_: float, balls: Floats) -> Floats:
        return np.asarray((np.exp(-1j * balls) * (gains @ left(balls, now))[plane]).imag, np.float64)

    ahead = solve_ivp(turning, (0.0, AHEAD * time[-1]), angle[-1], method="LSODA", rtol=1e-7, atol=1e-9)
    if not ahead.success or np.abs(ahead.y[:, -1] - angle[-1]).max() > 2.0 * np.pi:
        return np.nan, np.nan
    shares = np.abs(left(ahead.y.T, now)).sum(axis=1)
    apart = np.abs(ahead.y - ahead.y[:, -1:]).max(axis=0) > NEAR * SETTLED
    under_way = np.flatnonzero(apart | (np.abs(shares - shares[-1]) > SAME_SHARE))
    settled = time[-1] + (ahead.t[under_way[-1] + 1] if under_way.size else 0.0)
    return float(shares[-1]), float(settled / (1.0 - LAST))

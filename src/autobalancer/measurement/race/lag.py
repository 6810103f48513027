"""Drag and rolling resistance from how far a ball lags behind its rotor in a run-up.

On a round race whose plane hardly moves, with phi' the speed of the ball in the rotor and w that of the rotor:

    I phi'' + S w' = - beta phi' - mu m eps^2 (w + phi')^2 sign(phi')

with the inertias I and S of the ball that its machine has. Integrated once over time this needs no derivative of a measured
speed, and is linear in beta and mu.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.table import read_table
from autobalancer.machine import Machine
from autobalancer.units import texts_argument

Floats = NDArray[np.float64]
EXAMPLE = "time [s], rotor speed [rpm], ball speed [rpm]"
FEWEST, MOST = 20, 1000  # samples; of more, neighbors are averaged
ROUNDS = 4  # of the drag, on which the weights depend
ALIKE = 0.98  # correlation of drag and rolling resistance beyond which only their sum is known


@dataclass(frozen=True)
class LagFit:
    """``drag`` beta (N m s) and ``rolling_resistance`` with one standard deviation each, their ``correlation``, and the "
    "``scatter`` of the speed of
    the ball about the fit (rad/s).
    """

    drag: float
    drag_deviation: float
    rolling_resistance: float
    rolling_resistance_deviation: float
    correlation: float
    scatter: float
    remarks: tuple[str, ...]


def drag_from_lag(
    machine: Machine | str | Path,
    time: ArrayLike | str | Path,
    rotor_speed: ArrayLike | None = None,
    ball_speed: ArrayLike | None = None,
    *,
    rolling: bool = True,
) -> LagFit:
    """Linear drag and rolling resistance of one ball from a run-up.

    Parameters
    ----------
    machine
        With one ball on a vertical axis; its size and mass, not its drag, are used.
    time, rotor_speed, ball_speed
        s and rad/s in space, (n,); or a table with these columns.
    rolling
        Whether there may be rolling resistance beside the drag.

    Raises
    ------
    QuestionError
        If the machine or the record does not fit, or nothing lags.
    """
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if len(balls) != 1 or machine.axis != "vertical":
        raise QuestionError(
            f"drag_from_lag: {len(balls)} balls on a {machine.axis} axis; one ball on a vertical axis is evaluated"
        )
    ball = balls[0]
    t, w, absolute = _record(time, rotor_speed, ball_speed)
    lag = w - absolute
    spin = ball.moment * ball.orbit_radius - ball.spin_ratio * ball.mass * ball.rolling_radius * ball.orbit_radius
    known = -ball.inertia * lag + spin * w  # momentum that drag and friction have given to the ball
    if np.abs(lag).max() < 1e-9 * np.abs(w).max():
        raise QuestionError(
            "drag_from_lag: the ball does not lag behind the rotor; record a faster run-up, or check the channels"
        )
    pulls = [lag, _sense(lag) * ball.moment * ball.orbit_radius * absolute**2]
    columns = [_integral(t, pull) for pull in (pulls if rolling else pulls[:1])]
    rows = np.column_stack([*columns, np.full(t.size, ball.inertia)])  # the last one: an error of the first speed
    found, covariance, variance = _least(t, rows, known - known[0], ball.inertia)
    sure = np.sqrt(np.diag(covariance))
    correlation = float(covariance[0, 1] / (sure[0] * sure[1])) if rolling else 0.0
    remarks = []
    if abs(correlation) > ALIKE:
        remarks.append(
            "drag and rolling resistance act alike in this record; only their sum is known: use several accelerations"
        )
    if rolling and abs(found[1]) < 2.0 * sure[1]:
        remarks.append("no rolling resistance is seen beyond its uncertainty; without it the drag is surer")
    if found[0] < -2.0 * sure[0] or (rolling and found[1] < -3.0 * sure[1] - 1e-6):
        remarks.append(
            "a negative friction or drag: the ball gains where it should lose; check signs, and whether the rotor whirls much"
        )
    return LagFit(
        float(found[0]), float(sure[0]), float(found[1]) if rolling else 0.0, float(sure[1]) if rolling else 0.0,
        correlation, float(np.sqrt(variance)), tuple(remarks),
    )  # fmt: skip


def _record(
    time: ArrayLike | str | Path, rotor_speed: ArrayLike | None, ball_speed: ArrayLike | None
) -> tuple[Floats, Floats, Floats]:
    if isinstance(time, (str, Path)):
        table = read_table(Path(time), EXAMPLE)
        parts = [
            table.numbers("time", "s"),
            table.numbers("rotor speed", "rad/s"),
            table.numbers("ball speed", "rad/s"),
        ]
    else:
        given = (("time", time, "s"), ("rotor_speed", rotor_speed, "rad/s"), ("ball_speed", ball_speed, "rad/s"))
        parts = [
            np.atleast_1d(np.asarray(texts_argument(n, np.nan if v is None else v, u), float)) for n, v, u in given
        ]
    t, w, b = parts
    if (
        t.ndim != 1
        or not t.shape == w.shape == b.shape
        or t.size < FEWEST
        or not all(np.isfinite(p).all() for p in parts)
    ):
        raise QuestionError(f"drag_from_lag: give at least {FEWEST} finite times, and as many speeds of rotor and ball")
    if (np.diff(t) <= 0.0).any():
        raise QuestionError(
            f"drag_from_lag: times must ascend; they do not after {t[int(np.argmax(np.diff(t) <= 0.0))]:g} s"
        )
    t, w, b = _thinned([t, w, b])
    return t, w, b


def _least(time: Floats, rows: Floats, known: Floats, inertia: float) -> tuple[Floats, Floats, float]:
    """Unknowns, their covariance, and the variance of a speed of the ball.

    An error e of that speed is in the momentum as I e and in the integral of the drag as beta times the integral of e, so that
    errors of neighboring rows belong together; rows are combined until they do not.
    """
    from scipy.linalg import solve_triangular

    steps = np.diff(time)
    trapezes = np.tril(np.tile(np.r_[0.5 * steps, 0.0] + np.r_[0.0, 0.5 * steps], (time.size, 1)), -1)
    trapezes += np.diag(np.r_[0.0, 0.5 * steps])
    trapezes[1:, 0] = 0.5 * steps[0]
    scale = np.abs(rows).max(axis=0)
    mixed, beta = np.eye(time.size) * inertia, 0.0
    for _ in range(ROUNDS):
        mixed = inertia * np.eye(time.size) + beta * trapezes
        design = solve_triangular(mixed, rows / scale, lower=True)
        values = solve_triangular(mixed, known, lower=True)
        found, _, rank, _ = np.linalg.lstsq(design, values, rcond=None)
        if rank < rows.shape[1]:
            raise QuestionError("drag_from_lag: the record does not determine the drag; the lag must change over it")
        beta = max(0.0, float(found[0] / scale[0]))
    variance = float(((values - design @ found) ** 2).sum()) / (time.size - rows.shape[1])
    return found / scale, variance * np.linalg.inv(design.T @ design) / np.outer(scale, scale), variance


def _sense(lag: Floats) -> Floats:
    """Sign of the lag, that of its neighborhood where it is small."""
    from scipy.signal import medfilt

    return np.asarray(np.sign(medfilt(lag, 9)))


def _thinned(parts: list[Floats]) -> list[Floats]:
    """Means of neighboring samples of a long record."""
    block = -(-parts[0].size // MOST)
    whole = parts[0].size // block * block
    return [part[:whole].reshape(-1, block).mean(axis=1) for part in parts]


def _integral(time: Floats, values: Floats) -> Floats:
    """From the first time on, by splines."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(time, values).antiderivative()(time))

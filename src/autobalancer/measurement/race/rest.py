"""Friction between ball and race from where a ball came to rest in many run-ups.

Adherence mu holds a ball anywhere within an interval around its place opposite the unbalance. Rests that fill an interval
evenly, as after run-ups that end anyhow, give its width; the friction is that whose interval is as wide.
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
from autobalancer.laws.resting import rest_ends
from autobalancer.machine import Machine
from autobalancer.rotordynamics.response import response
from autobalancer.units import argument, texts_argument

Floats = NDArray[np.float64]
FEWEST = 5
GREATEST = 0.5  # adherence
EXAMPLE = "angle [deg]"


@dataclass(frozen=True)
class RestFriction:
    """``adherence`` with ends of its 95 % interval ``low`` and ``high``; ``width`` of the interval of rests (rad) with "
    "the ends of its own,
    its ``middle`` (rad from the balanced place) with one standard deviation, the ``angles`` of all rests, and ``remarks``.
    """

    adherence: float
    low: float
    high: float
    width: float
    width_low: float
    width_high: float
    middle: float
    middle_deviation: float
    angles: tuple[float, ...]
    remarks: tuple[str, ...]


def rest_friction(machine: Machine | str | Path, angles: ArrayLike | str | Path, speed: float | str) -> RestFriction:
    """Adherence of one ball from its rest positions.

    Parameters
    ----------
    machine
        With one ball, whose unbalance it cannot balance alone or just balances, on a rotor alike along x and y.
    angles
        Of the rests in the rotor, from the place opposite the unbalance, rad, (n,); or a table with the column ``angle``.
    speed
        At which it rested, rad/s, above the critical speed.

    Raises
    ------
    QuestionError
        If there are too few rests, more than one ball, or no friction up to 0.5 explains them.

    Notes
    -----
    Of n rests spread evenly over a width d their range R has R/d distributed as Beta(n - 1, 2), so d is (n + 1)/(n - 1) R and
    its interval follows from quantiles. Rests that gather in the middle make d too wide. A race that is not round shifts and
    widens the interval.
    """
    machine = balls_in_races(machine)
    w = argument("speed", speed, "rad/s")
    rests = _rests(angles)
    balls = resolve(machine)
    if len(balls) != 1:
        raise QuestionError(f"rest_friction: the machine has {len(balls)} balls; rests of exactly one are evaluated")
    ball = balls[0]
    gain, load = _gain(machine, w)
    range_, n = float(np.ptp(rests)), rests.size
    if range_ == 0.0:
        raise QuestionError(
            f"rest_friction: all {n} rests are at one angle; the friction is too small to be seen, or they are copies"
        )
    width, width_low, width_high = _widths(range_, n)
    found = [_adherence(width, gain, load, ball.moment, ball.orbit_radius) for width in (width, width_low, width_high)]
    middle = 0.5 * float(rests.max() + rests.min())
    spread = width / np.sqrt(2.0 * (n + 1.0) * (n + 2.0))
    ends = rest_ends(gain, load, ball.moment, ball.orbit_radius, found[0])
    expected = 0.0 if ends is None else 0.5 * (ends[0] + ends[1])
    remarks = []
    if abs(middle - expected) > 3.0 * spread:
        remarks.append(
            f"the middle of the rests is {np.degrees(middle - expected):.3g} deg off where it should be, more than chance "
            "makes it: a race that "
            "is not round or not centered, or an unbalance elsewhere"
        )
    third = float(np.mean(np.abs(rests - middle) < width / 6.0))
    if n >= 12 and third > 1.0 / 3.0 + 3.0 * np.sqrt(2.0 / 9.0 / n):
        remarks.append(
            "the rests gather in the middle of their interval, so that friction is rather smaller than stated"
        )
    return RestFriction(
        found[0],
        found[1],
        found[2],
        width,
        width_low,
        width_high,
        middle,
        float(spread),
        tuple(rests.tolist()),
        tuple(remarks),
    )


def _rests(angles: ArrayLike | str | Path) -> Floats:
    if isinstance(angles, (str, Path)):
        found = read_table(Path(angles), EXAMPLE).numbers("angle", "rad")
    else:
        found = np.atleast_1d(np.asarray(texts_argument("angles", angles, "rad"), float))
    if found.ndim != 1 or found.size < FEWEST or not np.isfinite(found).all():
        raise QuestionError(f"rest_friction: given {found.size} rests; at least {FEWEST} finite angles are needed")
    wrapped = np.mod(found + np.pi, 2.0 * np.pi) - np.pi
    if np.abs(wrapped).max() > 0.5 * np.pi:
        far = float(wrapped[int(np.argmax(np.abs(wrapped)))])
        raise QuestionError(
            f"rest_friction: a rest at {np.degrees(far):.4g} deg is more than 90 deg off the place opposite the "
            "unbalance; count angles from "
            "there, and leave out balls that stuck before they balanced"
        )
    return np.asarray(wrapped)


def _gain(machine: Machine, speed: float) -> tuple[complex, float]:
    """Whirl of the plane of the ball for a unit unbalance there, and the unbalance of the machine seen there."""
    if not machine.unbalances:
        raise QuestionError("rest_friction: the machine has no unbalance; a ball rests opposite to one")
    own = response(machine, [speed], balls=True).isel(speed=0, station=0)
    one = response(machine, [speed], unbalance=1.0, balls=True).isel(speed=0, station=0)
    gain = complex(float(one["x_real"]), float(one["x_imag"]))
    return gain, abs(complex(float(own["x_real"]), float(own["x_imag"])) / gain)


def _widths(range_: float, count: int) -> tuple[float, float, float]:
    from scipy.stats import beta

    low, high = beta.ppf([0.975, 0.025], count - 1, 2)
    return range_ * (count + 1) / (count - 1), range_ / float(low), range_ / float(high)


def _adherence(width: float, gain: complex, load: float, moment: float, orbit_radius: float) -> float:
    """The friction whose interval of rest is so wide."""
    from scipy.optimize import brentq

    def excess(adherence: float) -> float:
        ends = rest_ends(gain, load, moment, orbit_radius, adherence)
        return (0.0 if ends is None else ends[1] - ends[0]) - width

    if excess(GREATEST) < 0.0:
        raise QuestionError(
            f"rest_friction: rests over {np.degrees(width):.3g} deg are wider than an adherence of {GREATEST:g} explains "
            "at this speed and "
            "unbalance; check the speed and the unbalance of the machine"
        )
    return float(brentq(excess, 1e-9, GREATEST, xtol=1e-12, rtol=1e-9))

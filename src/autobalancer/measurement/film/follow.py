"""Balls followed from picture to picture: identity, angle in the rotor and speed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.balls import Seen
from autobalancer.measurement.film.identity import matched, wrapped
from autobalancer.measurement.film.rotor import RotorPlace
from autobalancer.measurement.film.setup import FilmSetup

Floats = NDArray[np.float64]
HALF = 3  # pictures before and after one whose motion gives its speed


class Followed(NamedTuple):
    """Of all balls in all pictures; (pictures, balls)."""

    angle: Floats  # rad, in the rotor, not wrapped; nan if not seen
    deviation: Floats
    margin: Floats  # (pictures,): what the second best match would cost more


def unwrapped_rotor(time: Floats, rotor: list[RotorPlace], first_speed: float) -> Floats:
    """Rotor angle with its turns counted: at each picture the turn nearest to where the last speed leads; nan where unknown."""
    found = np.array([place.angle for place in rotor])
    speed, last = first_speed, -1
    for k in np.flatnonzero(np.isfinite(found)):
        if last >= 0:
            step = time[k] - time[last]
            expected = found[last] + speed * step
            found[k] = expected + float(wrapped(np.array(found[k] - expected)))
            speed = (found[k] - found[last]) / step
        last = int(k)
    return np.asarray(found)


def angles_in_rotor(seen: Seen, place: RotorPlace, setup: FilmSetup) -> tuple[Floats, NDArray[np.intp]]:
    """Angles of the finds of one picture in the rotor, increasing, and their order."""
    turned = (seen.place - place.center) * np.exp(-1j * place.angle) - complex(*setup.race_center)
    angle = np.angle(turned)
    order = np.argsort(angle, kind="stable")
    return np.asarray(angle[order]), order


def follow(
    time: Floats,
    rotor: list[RotorPlace],
    seen: list[Seen],
    deviation: list[Floats],
    setup: FilmSetup,
    first_rate: float,
) -> Followed:
    """Give each find to its ball.

    Parameters
    ----------
    time
        Of the pictures, s.
    rotor, seen, deviation
        What was found in each; deviations of the angles, rad.
    setup
        The film.
    first_rate
        About how fast the balls move in the rotor at first, rad/s.
    """
    n, pictures = setup.balls, len(seen)
    angle, spread = np.full((pictures, n), np.nan), np.full((pictures, n), np.nan)
    margin = np.full(pictures, np.nan)
    now, rate, when = np.zeros(n), np.full(n, first_rate), np.full(n, -np.inf)
    contact = setup.contact_angle
    started = False
    for k in range(pictures):
        if seen[k].place.size == 0 or np.isnan(rotor[k].angle):
            continue
        at, order = angles_in_rotor(seen[k], rotor[k], setup)
        if not started or n == at.size == 1:  # one ball can be no other, wherever it went
            if at.size < n:
                continue
            find = np.arange(n)
            margin[k] = np.inf
            base = now + rate * (time[k] - when) if started else np.zeros(n)
            started = True
        else:
            away = time[k] - when
            base = _apart(now + rate * away, contact)
            gone = float(away.max() / max(away.min(), 1e-12))
            guess = (0.3 * contact + 0.25 * np.abs(rate * away).max()) * min(gone, 10.0) ** 0.5
            match = matched(base, at, min(guess, 0.5))
            find, margin[k] = match.find, match.margin
        for i in np.flatnonzero(find >= 0):
            here = at[find[i]]
            value = here if when[i] == -np.inf else base[i] + float(wrapped(np.array(here - base[i])))
            if when[i] > -np.inf:
                rate[i] = (value - now[i]) / (time[k] - when[i])
            now[i], when[i] = value, time[k]
            angle[k, i], spread[k, i] = value, deviation[k][order[find[i]]]
    return Followed(angle, spread, margin)


def _apart(expected: Floats, contact: float) -> Floats:
    """Expected angles in order, none nearer to its neighbor than balls that touch."""
    if expected.size < 2:
        return expected
    out = expected.copy()
    for _ in range(4):
        following = np.append(out[1:], out[0] + 2.0 * np.pi * np.ceil((out[-1] - out[0]) / (2.0 * np.pi)))
        lack = np.maximum(contact - (following - out), 0.0)
        out -= 0.5 * lack
        out += 0.5 * np.roll(lack, 1)
    return out


def speeds(time: Floats, angle: Floats, deviation: Floats, breaks: list[Floats]) -> tuple[Floats, Floats]:
    """Speed of each ball and its deviation: slopes of parabolas through neighboring pictures.

    None reaches across an impact; ``breaks`` has their times for each ball.
    """
    rate, spread = np.full(angle.shape, np.nan), np.full(angle.shape, np.nan)
    for i in range(angle.shape[1]):
        rows = np.flatnonzero(np.isfinite(angle[:, i]))
        part = np.searchsorted(np.sort(breaks[i]), time[rows])
        for j, k in enumerate(rows):
            near = np.arange(max(0, j - HALF), min(rows.size, j + HALF + 1))
            near = near[part[near] == part[j]]
            if near.size < 2:
                continue
            t, weight = time[rows[near]] - time[k], 1.0 / deviation[rows[near], i]
            size = max(float(np.abs(t).max()), 1e-12)
            power = (t[:, None] / size) ** np.arange(min(3, near.size))
            solution = np.linalg.pinv(power * weight[:, None])
            rate[k, i] = solution[1] @ (weight * (angle[rows[near], i] - angle[k, i])) / size
            spread[k, i] = np.linalg.norm(solution[1]) / size
    return rate, spread

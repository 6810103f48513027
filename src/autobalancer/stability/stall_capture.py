"""The rotor speed below which balls in line fall back to a resonance, on any rotor.

Balls that stand in line at every station and turn nearly with the rotor are braked by the whirl they make. The surplus of
what carries them, all together, over what brakes them is looked at for all whirl speeds from a resonance up to the speed of
the rotor or to the next resonance below it. While it is nowhere positive they cannot stay beyond the resonance. Of the
ways to stand in line, on one side of the axis or on both, the one that brakes most counts.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from autobalancer.stability.lateral import Complexes, Floats
from autobalancer.stability.stall_release import HangingRange
from autobalancer.stability.stalled_groups import Loads
from autobalancer.stability.whirling import Whirling

POINTS = 60  # whirl speeds at each end
SPEEDS = 12
STATIONS = 6  # whose sides are all tried; beyond, balls stand on that of the first


def capture_speed(rotor: Whirling, loads: Loads, at: HangingRange, others: list[HangingRange], top: float) -> float:
    """The capture speed of one resonance, rad/s; nan if there is none up to the release speed.

    ``others`` are those at which balls can hang besides, ``top`` the highest rotor speed that is asked for.
    """
    from scipy.optimize import brentq

    def surplus(speed: float) -> float:
        frequencies = rotor.modes(speed).frequency
        met = [float(frequencies[one.mode]) for one in [at, *others] if one.mode < frequencies.size]
        last = min([v for v in met if met[0] < v < speed], default=speed)
        return _greatest_surplus(rotor, loads, met[0], last, speed) if met[0] < speed else -math.inf

    low = math.nan
    for speed in np.geomspace(at.begin * (1.0 + 1e-6), min(at.end, top), SPEEDS).tolist():
        if surplus(speed) <= 0.0:
            low = speed
        elif not math.isnan(low):
            return float(brentq(surplus, low, speed, xtol=1e-9 * speed))
    return math.nan


def _greatest_surplus(rotor: Whirling, loads: Loads, first: float, last: float, speed: float) -> float:
    """N m, over all balls, at the whirl speed of a range where it is greatest; of the sides that brake most there."""
    from scipy.optimize import minimize_scalar

    def surplus(whirl: Floats) -> Floats:
        receptance = rotor.receptance(whirl, speed)
        return np.asarray(np.min([_surplus(loads, receptance, whirl, speed, side) for side in _sides(loads)], axis=0))

    near = np.geomspace(1e-5, 0.5, POINTS)
    whirl = first + (last - first) * np.concatenate([near, 1.0 - near[-2::-1], [1.0]])
    found = surplus(whirl)
    top = int(np.argmax(found))
    if top in (0, whirl.size - 1):
        return float(found[top])
    bounds = (float(whirl[top - 1]), float(whirl[top + 1]))
    fine = minimize_scalar(lambda v: -float(surplus(np.array([v]))[0]), bounds=bounds, method="bounded")
    return max(float(found[top]), -float(fine.fun))


def _surplus(loads: Loads, receptance: Complexes, whirl: Floats, speed: float, phases: Floats) -> Floats:
    answer = loads.whirl(receptance, whirl, phases)
    return np.asarray((loads.carried(speed - whirl, answer, whirl) - loads.braking(answer, whirl)) @ loads.count)


def _sides(loads: Loads) -> list[Floats]:
    """Angles of the groups, 0 or pi, the same for all of one station."""
    places = sorted(set(loads.station))
    free = min(len(places), STATIONS) - 1
    found = []
    for turned in product((0.0, np.pi), repeat=free):
        side = dict(zip(places[1:], turned, strict=False))
        found.append(np.array([side.get(place, 0.0) for place in loads.station]))
    return found

"""Where balls that hang together at a resonance break away: the joint torque balance with the whole receptance.

The balances of all groups make a curve of rotor speed, whirl speed and phases between the groups. Its top is the fold above
which they cannot hang.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from autobalancer.stability.lateral import Floats
from autobalancer.stability.stalled_groups import Loads
from autobalancer.stability.whirling import Whirling

BELOW = 0.65  # sine of the angle by which the weakest lags where a curve is begun; 1 at the top
SHARES = np.linspace(0.95, 0.05, 19)  # of the greatest slip
STEP, STEPS = 0.2, 150  # along the curve on which the fold is sought; one is a decay rate, or a radian
PASSED = 12.0  # decay rates beyond the resonance; a curve without a fold up to there leads past it
SLIPS = 1e-6  # balls that slip by less of the speed are held by rolling resistance and turn with the rotor
STRAIGHT = 0.98  # cosine between neighboring tangents
DIFFERENCE = 1e-6


class Point(NamedTuple):
    """A point of the curve."""

    y: Floats
    jacobian: Floats


class Fold:
    """The curve of balances of groups that hang together, near its greatest rotor speed.

    Unknowns y: whirl speed in decay rates from the resonance, log of the slip, phases but the first. The balances are one
    fewer; the curve is followed along its length, because the whirl speed may turn back on it. It is begun well below its
    top, where balls are drawn together: beyond, there may be others on which they drive each other apart. ``passed``: it
    leads past the resonance without a fold, or to where balls turn with the rotor, so that they do not stall there.
    """

    def __init__(self, rotor: Whirling, loads: Loads, k: int, speed: float) -> None:
        """``loads`` of the groups that hang at mode ``k``, up to about ``speed`` by that mode alone."""
        self.rotor, self.loads, self.passed = rotor, loads, False
        greatest = speed - float(rotor.modes(speed).frequency[k])
        for share in SHARES:
            begun = speed - (1.0 - share) * greatest
            modes = rotor.modes(begun)
            self.center, self.decay = float(modes.frequency[k]), float(modes.decay[k])
            whirl, left = np.full(1, self.center), modes.left[k][loads.station]
            carried = np.array([group.carried(begun - whirl, whirl, 0.0 * whirl)[0] for group in loads.groups])
            strength = loads.moment * np.sqrt(np.abs(modes.right[k][loads.station] * left))
            sines = carried / (strength * np.sqrt(self.center**4 / self.decay * (loads.count * carried).sum()))
            if sines.max() <= BELOW:
                break
        self.steep = bool(sines.max() > BELOW and len(loads.groups) > 1)
        theta = np.arcsin(np.minimum(sines, 1.0))
        lag = float(np.angle((loads.count * strength * np.exp(1j * theta)).sum()))
        phases, off = theta - lag - np.angle(left), -1.0 / np.tan(lag)
        slip = max(begun - self.center - off * self.decay, 1e-6 * begun)
        self.start = np.array([off, np.log(slip), *(phases - phases[0])[1:]])

    def found(self) -> tuple[float, float] | None:
        """Rotor speed and whirl speed of the fold; none without one, or if the curve could not be followed to it."""
        from scipy.optimize import brentq

        here, step = self.corrected(self.start), STEP
        along = None if here is None else self.tangent(here)
        for _ in range(STEPS):
            if here is None or along is None or self.passed:
                return None
            there = self.corrected(here.y + step * along)
            turned = along if there is None else self.tangent(there, along)
            if there is None or along @ turned < STRAIGHT or np.linalg.norm(there.y - here.y) > 1.5 * step:
                step *= 0.5  # or it might go over to another branch
                continue
            if self.rise(there.y, turned) <= 0.0:
                break
            here, along, step = there, turned, min(1.5 * step, STEP)
            self.passed = bool(here.y[0] > PASSED)
        else:
            return None
        first, last = here.y, there.y

        def between(share: float) -> float:
            point = self.corrected(first + share * (last - first))
            return np.nan if point is None else self.rise(point.y, self.tangent(point, along))

        try:
            top = self.corrected(first + float(brentq(between, 0.0, 1.0, xtol=1e-6)) * (last - first))
        except ValueError:
            return None
        if top is None:
            return None
        speed, whirl = (float(one[0]) for one in self.speeds(top.y[None]))
        self.passed = speed - whirl < SLIPS * speed
        apart = self.steep and top.y[0] > 0.0  # begun too near the top, it may be on a branch where balls part
        return None if self.passed or apart else (speed, whirl)

    def speeds(self, y: Floats) -> tuple[Floats, Floats]:
        """Of rotor and whirl, of points (n, unknowns)."""
        whirl = self.center + y[:, 0] * self.decay
        return whirl + np.exp(y[:, 1]), whirl

    def rise(self, y: Floats, along: Floats) -> float:
        """Of the rotor speed along the curve."""
        return float(self.decay * along[0] + np.exp(y[1]) * along[1])

    def misfit(self, y: Floats) -> Floats:
        """Brake over drive less one for each group, (n, groups)."""
        speed, whirl = self.speeds(y)
        phases = np.hstack([np.zeros((whirl.size, 1)), y[:, 2:]])
        answer = self.loads.whirl(self.rotor.receptance(whirl, speed), whirl, phases)
        return self.loads.braking(answer, whirl) / self.loads.carried(speed - whirl, answer, whirl) - 1.0

    def misfit_and_jacobian(self, y: Floats) -> tuple[Floats, Floats]:
        """At one point, (groups,) and (groups, unknowns)."""
        steps = DIFFERENCE * np.vstack([np.zeros(y.size), np.eye(y.size), -np.eye(y.size)])
        found = self.misfit(y + steps)
        n = y.size
        return found[0], ((found[1 : n + 1] - found[n + 1 :]) / (2.0 * DIFFERENCE)).T

    def corrected(self, y: Floats) -> Point | None:
        """The point of the curve nearest to y, by Newton's method; none if it does not converge."""
        for _ in range(15):
            miss, jacobian = self.misfit_and_jacobian(y)
            change = np.linalg.lstsq(jacobian, -miss, rcond=None)[0]
            size = float(np.abs(change).max())
            y = y + change * min(1.0, 0.5 / max(size, 1e-12))
            if size < 1e-6:  # as it converges quadratically, twice the digits
                return Point(y, jacobian)
        return None

    def tangent(self, point: Point, like: Floats | None = None) -> Floats:
        """Of unit length; on the side of ``like``, else the one on which the rotor speed rises."""
        along = np.linalg.svd(point.jacobian)[2][-1]
        side = self.rise(point.y, along) if like is None else float(along @ like)
        return np.asarray(along if side >= 0.0 else -along)

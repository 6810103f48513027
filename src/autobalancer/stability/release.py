"""The release speed: from which rotor speed on no ball can stall.

A ball that circles in space at a speed v drives the rotor, with all others that stall, at the frequency v. The rotor
answers with a whirl that brakes the ball; averaged over a turn the torque on N equal balls in line is

    N s^2 v^4 L(v),    L(v) = (1/2) sum over x, y of b v / ((k - M v^2)^2 + (b v)^2),    s = m eps,

and the fluid drags it with beta (W - v). A ball can stall as long as W is below the maximum that v + torque/beta has
near a resonance. Unequal balls take angles to each other at which each is in balance; with the power that all of
them put into the whirl, :mod:`autobalancer.stability.stall_holds`, a set of them stalls together as long as for each

    beta^2 (W - v) <= s^2 v^4 L(v) sum beta.
"""

from __future__ import annotations

import math

import numpy as np

from autobalancer.stability.border import Border
from autobalancer.stability.lateral import Floats, Plane

POINTS = 2000  # on each side of a resonance
UNDAMPED = "never: without damping of the rotor its whirl at a critical speed has no bound"


def release_border(p: Plane) -> Border:
    """The release speed, linear drag and no friction; closed form (4.73) of Spannan (2021) for isotropic supports.

    That is the torque balance at v = w_c, W = w_c (1 + N S) for N equal balls. Of balls that are not equal sets stall
    together, from the strongest on; the set that holds longest counts. On orthotropic supports the balance is sought over v.
    """
    name, note = "release speed", "for a drag that is linear and no friction"
    if not all(b > 0.0 for b in p.damping):
        return Border(name, math.inf, UNDAMPED)
    if not (p.drag > 0.0).all():
        return Border(name, math.inf, "never: a ball without drag is not dragged along")
    if p.isotropic:
        critical = math.sqrt(p.stiffness[0] / p.mass)
        speeds, pulls = np.array([critical]), np.array([critical**3 / p.damping[0]])
    else:
        note = f"the highest of both resonances; {note}"
        ends = [math.sqrt(k / p.mass) for k in p.stiffness]
        near = np.geomspace(1e-7, 0.5, POINTS)
        offsets = np.concatenate([-near, [0.0], near])
        speeds = np.unique(np.concatenate([end * (1.0 + offsets) for end in ends]))
        pulls = np.zeros(speeds.size)
        for k, b in zip(p.stiffness, p.damping, strict=True):
            pulls += 0.5 * speeds**5 * b / ((k - p.mass * speeds**2) ** 2 + (b * speeds) ** 2)
    released, together = 0.0, 0.0
    ratio = p.moment / p.drag
    for i in np.argsort(-ratio, kind="stable"):  # the strongest holds longest; the weakest of a set leaves first
        together += float(p.drag[i])
        released = max(released, _greatest(speeds, float(ratio[i]) ** 2 * together * pulls))
    if released == 0.0:
        return Border(name, math.nan, "the balls are damped so well that they never stall")
    return Border(name, released, note)


def _greatest(speeds: Floats, lags: Floats) -> float:
    """The highest maximum of v + lag that is not at an end; zero if there is none."""
    sums = speeds + lags
    if sums.size == 1:
        return float(sums[0])
    peaks = (sums[1:-1] > sums[:-2]) & (sums[1:-1] >= sums[2:])
    return float(sums[1:-1][peaks].max(initial=0.0))

"""The release speed in closed form: from which rotor speed on no ball can stall, linear drag and isotropic supports.

A ball that circles in space at a speed v drives the rotor, with all others that stall, at the frequency v. The rotor
answers with a whirl that brakes the ball; averaged over a turn the torque on N equal balls in line is

    N s^2 v^4 L(v),    L(v) = b v / ((k - M v^2)^2 + (b v)^2),    s = m eps,

and the fluid drags it with beta (W - v). Balls that lag behind the whirl by a right angle are at their limit, which is at
v = w_c. Unequal balls take angles to each other at which each is in balance; with the power that all of them put into the
whirl a set of them stalls together as long as for each

    beta^2 (W - v) <= s^2 v^4 L(v) sum beta.
"""

from __future__ import annotations

import math

import numpy as np

from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Plane

UNDAMPED = "without damping of the rotor its whirl at a critical speed has no bound"


def release_border(p: Plane) -> Border:
    """The release speed of isotropic supports, linear drag and no friction; closed form (4.73) of Spannan (2021).

    That is the torque balance at v = w_c, W = w_c (1 + N S) for N equal balls. Of balls that are not equal sets stall
    together, from the strongest on; the set that holds longest counts.
    """
    critical = math.sqrt(p.stiffness[0] / p.mass)
    released, together = 0.0, 0.0
    ratio = p.moment / p.drag
    for i in np.argsort(-ratio, kind="stable"):  # the strongest holds longest; the weakest of a set leaves first
        together += float(p.drag[i])
        released = max(released, critical + float(ratio[i]) ** 2 * together * critical**3 / p.damping[0])
    return Border("release speed", released, "for a drag that is linear and no friction")

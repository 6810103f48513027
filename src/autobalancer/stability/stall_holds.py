"""Which balls can hang at a resonance: the joint torque balance of unequal balls, and of balls at several stations.

Near a resonance one mode answers, H_pq = r_p l_q/(d + i (v - w)) with the decay d. Balls of the groups g with the strengths
s' = s |r l|^(1/2) at their stations turn, each at its own angle before the whirl; the angle theta of a group settles where
sin theta = tau/(s' G Y), G = v^4/d, tau what carries one of its balls along, Y = sum n s' sin theta. Multiplied and
summed this is a balance of power, Y^2 = sum n tau/G, so that a set of balls hangs together as long as

    tau <= s' (G sum n tau)^(1/2)    for each of them.

With equal balls at one station it is tau = N s'^2 G. Of unequal ones the weakest leaves first; those that stay drive
the rotor less, so that they may go with it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.lateral import Floats
from autobalancer.stability.stalled_groups import Loads
from autobalancer.stability.whirling import ForwardModes

LEAST = 1e-300  # stands for zero in logarithms


def holds(loads: Loads, modes: ForwardModes, speed: float) -> Floats:
    """How firmly balls hang at each of k modes while the rotor runs at ``speed``, (k,): above 0 they can.

    The log of the least of s' (G sum)^(1/2)/tau of the set of groups that holds best; -inf at modes faster than the rotor.
    """
    margins, _ = _margins(loads, modes, speed)
    return np.asarray(np.where(modes.frequency < speed, margins.max(axis=0), -np.inf))


def members(loads: Loads, modes: ForwardModes, speed: float, k: int) -> tuple[int, ...]:
    """The groups of the set that holds best at mode k, the strongest first."""
    margins, order = _margins(loads, modes, speed)
    return tuple(order[: int(np.argmax(margins[:, k])) + 1, k].tolist())


def _margins(loads: Loads, modes: ForwardModes, speed: float) -> tuple[Floats, NDArray[np.int64]]:
    """Of the sets of the strongest one, two, ... groups, (groups, k), and the groups from the strongest on."""
    whirl, slip = modes.frequency, np.maximum(speed - modes.frequency, 0.0)
    carried = np.stack([group.carried(slip, whirl, 0.0 * whirl) for group in loads.groups])
    reach = np.sqrt(np.abs(modes.right * modes.left)[:, loads.station]).T
    strength = loads.moment[:, None] * reach
    gain = whirl**4 / np.maximum(modes.decay, LEAST)
    order = np.argsort(carried / np.maximum(strength, LEAST), axis=0, kind="stable")
    carried, strength = (np.take_along_axis(one, order, axis=0) for one in (carried, strength))
    together = np.cumsum(loads.count[order] * carried, axis=0)
    margins = np.log(np.maximum(strength, LEAST)) - np.log(np.maximum(carried, LEAST))
    return margins + 0.5 * np.log(np.maximum(together, LEAST)) + 0.5 * np.log(np.maximum(gain, LEAST)), order

"""Whether a stalled state is stable: the equations of motion linearized in axes that turn with its whirl.

There the state is at rest, so that its eigenvalues say everything (on anisotropic supports after the mean over the whirl).
Small motions: a = (z, z') of the rotor, Da = (S - i v) a + P f, and delta of the groups,

    f = n s e^(i psi) (i v^2 delta + 2 v D delta - i DD delta),    X = e^(-i psi) (R z'' of S a + B f),
    I DD delta = - s Im(q X) - s v^2 Re(q h) delta - (dT/dW - 2 mu s eps v) D delta,

B f the acceleration that loads give at once. Turning the whole picture changes nothing: one eigenvalue is zero. Balls of a
group that part from each other leave the whirl alone, so that this motion has its own equation, I DD delta + dT/dW D delta
+ s v^2 Re(q h) delta = 0: they stay together while Re(q h) > 0. With one mode this ends exactly at its resonance.
"""

from __future__ import annotations

import numpy as np

from autobalancer.stability.host.planar import Floats
from autobalancer.stability.stall.states import STEEP, Balance, States


def growth(balance: Balance, states: States) -> Floats:
    """Of groups that stay together: greatest real part of all eigenvalues but the one of turning, 1/s, (n,)."""
    n, loads = states.speed.size, balance.loads
    groups = loads.count.size
    if n == 0:
        return np.zeros(0)
    v, slip, place = states.whirl, states.slip, loads.station
    free, pushed_by, lightness = balance.rotor.free_motion(states.speed)
    turned, rolled = np.exp(1j * states.phases), 1.0 + 1j * balance.rolling
    load, back = (loads.count * loads.moment * turned)[:, None, :], (rolled / turned)[:, :, None]
    count = free.shape[1]
    felt = pushed_by[:, place] * load  # (n, K, G)
    seen = balance.rotor.read[place] @ free[:, count // 2 :] * back  # (n, G, K)
    at_once = lightness[place][:, place] * back * load  # (n, G, G)
    slope = (balance.drag(slip * (1.0 + STEEP)) - balance.drag(slip)) / (STEEP * slip[:, None])
    slope = slope - 2.0 * balance.rolling * loads.moment * balance.orbit * v[:, None]
    held = loads.moment * v[:, None] ** 2 * balance.deflections(states).real
    inertia = np.array([group.ball.inertia for group in loads.groups])
    s, own = loads.moment[None, :, None], np.eye(groups)
    v1 = v[:, None, None]
    mass = inertia[None, :, None] * own - s * at_once.real
    by_angle = -s * (1j * v1**2 * at_once).imag - held[:, :, None] * own
    by_rate = -s * (2.0 * v1 * at_once).imag - slope[:, :, None] * own
    by_modes = np.concatenate([-s * seen.imag, -s * seen.real], axis=2)
    soft, c = balance.softening(states), count // 2
    if soft is not None:
        read = balance.rotor.read[place] * back
        moved = read.imag @ soft[:, :c] + read.real @ soft[:, c:]
        by_modes[:, :, :c] -= s * moved[:, :, :c]
        by_modes[:, :, count : count + c] -= s * moved[:, :, c:]
    accelerations = np.linalg.solve(mass, np.concatenate([by_modes, by_angle, by_rate], axis=2))  # (n, G, 2K + 2G)
    size = 2 * count + 2 * groups
    whole = np.zeros((n, size, size))
    turns = free - 1j * v1 * np.eye(count)
    whole[:, :count, :count] = whole[:, count : 2 * count, count : 2 * count] = turns.real
    whole[:, :count, count : 2 * count], whole[:, count : 2 * count, :count] = -turns.imag, turns.imag
    if soft is not None:
        for i, rows in enumerate((slice(c, count), slice(count + c, 2 * count))):
            for k, columns in enumerate((slice(0, c), slice(count, count + c))):
                whole[:, rows, columns] += soft[:, i * c : (i + 1) * c, k * c : (k + 1) * c]
    pushed = -1j * felt @ accelerations
    pushed[:, :, 2 * count : 2 * count + groups] += 1j * v1**2 * felt
    pushed[:, :, 2 * count + groups :] += 2.0 * v1 * felt
    whole[:, :count] += pushed.real
    whole[:, count : 2 * count] += pushed.imag
    whole[:, 2 * count : 2 * count + groups, 2 * count + groups :] = own
    whole[:, 2 * count + groups :] = accelerations
    values = np.linalg.eigvals(whole)
    turning = np.abs(values).argmin(axis=1)
    values[np.arange(n), turning] = -np.inf
    if soft is not None:  # its stiffness is that of changes that are slow against a turn
        values[np.abs(values.imag) > v[:, None]] = -np.inf
    return np.asarray(values.real.max(axis=1))


def together(balance: Balance, states: States) -> Floats:
    """Least of Re(q h) over the orbit radius of the groups of several balls, (n,): above zero they do not part."""
    several = balance.loads.count > 1.0
    if not several.any() or not states.speed.size:
        return np.full(states.speed.size, np.inf)
    return np.asarray((balance.deflections(states).real / balance.orbit)[:, several].min(axis=1))


def past(balance: Balance, states: States) -> Floats:
    """How far balls are beyond the resonance, over the orbit radius, (n,): above zero the whirl moves against them."""
    if not states.speed.size:
        return np.zeros(0)
    weight = balance.loads.count * balance.loads.moment
    return np.asarray(-(balance.deflections(states).real / balance.orbit) @ weight / weight.sum())

"""Where balls of one plane leave a resonance while those of the others, released already, run freely nearby.

A free ball turns nearly with the rotor, but the whirl of those that hang passes under it and makes it swing. In axes that turn
with the whirl at v its angle chi before the local whirl h obeys

    I DD chi = T_drag(W - v - D chi) - s v^2 |h| sin chi ,

a driven pendulum that goes around. With u = D chi as a function of chi this is a periodic equation of first order. The mean of
e^(i chi) over time is the load with which free balls take part in the whirl at v; the rest has other frequencies and no
mean torque. With it the balance of those that hang and the angle at which they part are solved again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.stall.groups import Loads, StalledGroup
from autobalancer.stability.stall.states import Balance, States

POINTS = 48  # around the free ball's way
ROUNDS = 40
SHORT = 0.05  # of the speed by which the end may shift at most, downward
FAR = 0.12  # and upward
BELOW = 2e-3  # of the speed below the end, where balls must still be in line
FITS = 1e-7


@dataclass(frozen=True)
class Freed:
    """Speed of the rotor and of those that hang, rad/s, where they part."""

    speed: float
    whirl: float


def freed(balance: Balance, hung: tuple[int, ...], state: States) -> Freed | None:
    """Where the ``hung`` groups part while all others run freely, near the end ``state`` of their range; none if not found."""
    free = tuple(g for g in range(len(balance.loads.groups)) if g not in hung)
    if not free or balance.rolling.any():
        return None
    from scipy.optimize import root

    problem = _Problem(balance, hung, free)
    with np.errstate(all="ignore"):  # where free balls would not go around
        found = root(problem.ended, problem.begun(state), tol=1e-11)
    speed, whirl = problem.speeds(found.x)
    before = float(state.speed[0])
    fits = np.abs(found.fun).max() <= FITS and whirl < speed
    if not (fits and (1.0 - SHORT) * before < speed < (1.0 + FAR) * before):
        return None
    fixed = (1.0 - BELOW) * speed
    with np.errstate(all="ignore"):
        earlier = root(lambda x: problem.balanced(np.append(x, np.log(fixed))), found.x[:-1], tol=1e-11)
    held = np.abs(earlier.fun).max() <= FITS and problem.drawn(np.append(earlier.x, np.log(fixed))) > 0.0
    return Freed(speed, whirl) if held else None


class _Problem:
    """Unknowns x: log (slip over whirl) and phases of those that hang, log |h| and angle of h at each free group, log speed."""

    def __init__(self, balance: Balance, hung: tuple[int, ...], free: tuple[int, ...]) -> None:
        self.balance, self.hung, self.free = balance, np.array(hung), np.array(free)
        self.groups: Loads = balance.loads

    def speeds(self, x: Floats) -> tuple[float, float]:
        """Of the rotor and of the whirl."""
        speed = float(np.exp(x[-1]))
        return speed, speed / (1.0 + float(np.exp(x[0])))

    def begun(self, state: States) -> Floats:
        """From the end without the free balls."""
        speed, whirl = float(state.speed[0]), float(state.whirl[0])
        load = np.zeros(len(self.groups.groups), np.complex128)
        load[self.hung] = (self.groups.count * self.groups.moment)[self.hung] * np.exp(
            1j * state.phases[0][: self.hung.size]
        )
        h = whirl**2 * (self._host(speed, whirl) @ load)[self.free]
        return np.array([*state.y[0][: self.hung.size], *np.log(np.abs(h)), *np.angle(h), np.log(speed)])

    def ended(self, x: Floats) -> Floats:
        """Balances, and that one of those that hang parts."""
        return np.append(self.balanced(x), self.drawn(x))

    def drawn(self, x: Floats) -> float:
        """Least cosine of the angle between balls that hang and their whirl; of groups of several balls, else of all."""
        h = self._whirl(x)[self.hung]
        several = self.groups.count[self.hung] > 1.0
        return float((h.real / np.abs(h))[several if several.any() else slice(None)].min())

    def balanced(self, x: Floats) -> Floats:
        """Torques on those that hang, and the whirl at the free ones."""
        speed, whirl = self.speeds(x)
        h = self._whirl(x)
        brake = -self.groups.moment[self.hung] * whirl**2 * h[self.hung].imag
        need = self.balance.needed(np.array([speed - whirl]), np.array([whirl]))[0][self.hung]
        n, m = self.hung.size, self.free.size
        ratio = h[self.free] / np.exp(x[n : n + m])  # seen along the assumed direction
        return np.array([*(brake / need - 1.0), *(ratio.real - 1.0), *ratio.imag])

    def _whirl(self, x: Floats) -> Complexes:
        """Whirl at every group, those that hang seen along their balls, free ones along the assumed direction, (G,)."""
        speed, whirl = self.speeds(x)
        n, m = self.hung.size, self.free.size
        size, angle = np.exp(x[n : n + m]), x[n + m : n + 2 * m]
        turned = np.ones(len(self.groups.groups), np.complex128)
        turned[self.hung] = np.exp(1j * np.concatenate([[0.0], x[1:n]]))
        turned[self.free] = np.exp(1j * angle)
        load = self.groups.count * self.groups.moment * turned
        for g, reach in zip(self.free, size, strict=True):
            load[g] *= _share(self.groups.groups[g], speed - whirl, whirl**2 * float(reach))
        return np.asarray(whirl**2 * (self._host(speed, whirl) @ load) / turned, np.complex128)

    def _host(self, speed: float, whirl: float) -> Complexes:
        place = self.groups.station
        among = self.balance.rotor.receptance(np.array([whirl]), speed)[0]
        return np.asarray(among[place[:, None], place], np.complex128)


def _share(group: StalledGroup, slip: float, pull: float) -> complex:
    """Mean of e^(i chi) over the way of a free ball; ``pull`` is v^2 |h|, m/s^2. nan where it would not go around."""
    torque, inertia = group.moment * pull, group.ball.inertia
    u = np.full(POINTS, slip)
    for _ in range(ROUNDS):
        change_of = DERIVATIVE @ u
        lag = slip - u
        drag, step = group.drag(lag), 1e-6 * slip
        slope = (group.drag(lag + step) - drag) / step
        miss = inertia * u * change_of - drag + torque * np.sin(CHI)
        matrix = inertia * (np.diag(change_of) + u[:, None] * DERIVATIVE) + np.diag(slope)
        try:
            change = np.linalg.solve(matrix, -miss)
        except np.linalg.LinAlgError:
            break
        part = 1.0
        while part > 1e-6 and float((u + part * change).min()) <= 0.0:
            part *= 0.5
        u = u + part * change
        if float(np.abs(change).max()) < 1e-10 * slip:
            return complex((np.exp(1j * CHI) / u).sum() / (1.0 / u).sum())
    return complex(np.nan)


def _derivative() -> Floats:
    waves = np.fft.fftfreq(POINTS, 1.0 / POINTS)
    waves[POINTS // 2] = 0.0
    return np.asarray(np.fft.ifft(1j * waves[:, None] * np.fft.fft(np.eye(POINTS), axis=0), axis=0).real)


CHI = 2.0 * np.pi * np.arange(POINTS) / POINTS
DERIVATIVE = _derivative()

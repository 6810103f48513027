"""Two balls in line on the machine that stalls (stall_and_release.toml), integrated by SciPy from equations of its own.

The pair is one point at the angle psi in space, with the moment 2 m eps cos(gap/2) of two balls that are ``gap`` apart:

    M z'' + b z' + k z = U (W^2 - i W') e^(i theta) + S (psi'^2 - i psi'') e^(i psi)
    2 I psi'' + 2 beta (psi' - W) = -S Im(z'' e^(-i psi))
"""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

MASS, STIFFNESS, DAMPING = 10.0, 6.25e5, 100.0
MOMENT, ORBIT, BETA, UNBALANCE = 2.5e-4, 0.1, 1.4685e-4, 5e-4
INERTIA = 1.4 * MOMENT * ORBIT  # a ball that rolls
TOUCHING = 2.0 * math.asin(0.5 * (6.0 * 2.5e-3 / (math.pi * 7850.0)) ** (1.0 / 3.0) / ORBIT)


def torque(whirl: float, speed: float, moment: float = 2.0 * MOMENT) -> float:
    """On each ball of a pair that turns with ``whirl`` where the unbalance averages out; zero where it hangs."""
    deflection = moment * whirl**2 / complex(STIFFNESS - MASS * whirl**2, DAMPING * whirl)
    return BETA * (speed - whirl) + 0.5 * moment * whirl**2 * deflection.imag


def hanging_speed(speed: float) -> float:
    """Speed of the pair below the critical speed, rad/s."""
    return float(brentq(torque, 200.0, 250.0, args=(speed,)))


def start(speed: float) -> list[float]:
    """The pair on the x axis, as the unbalance: x, y, their rates, psi, psi'."""
    whirl = hanging_speed(speed)
    parts = [
        (rate, moment * rate**2 / complex(STIFFNESS - MASS * rate**2, DAMPING * rate))
        for rate, moment in ((whirl, 2.0 * MOMENT), (speed, UNBALANCE))
    ]
    z, v = sum(z for _, z in parts), sum(1j * rate * z for rate, z in parts)
    return [z.real, z.imag, v.real, v.imag, 0.0, whirl]


def rates(time: float, state: Any, speed: float, ramp: float, gap: float) -> list[float]:
    """Of the pair, and of small distances of its balls from each other if the state has them (distance, rate)."""
    x, y, vx, vy, psi, w = state[:6]
    v, now, turn = complex(vx, vy), speed + ramp * time, cmath.exp(1j * psi)
    moment = 2.0 * MOMENT * math.cos(0.5 * gap)
    force = UNBALANCE * complex(now**2, -ramp) * cmath.exp(1j * (speed * time + 0.5 * ramp * time**2))
    force += moment * w**2 * turn - DAMPING * v - STIFFNESS * complex(x, y)
    drag = -2.0 * BETA * (w - now)
    change = (drag - moment * (force / turn).imag / MASS) / (2.0 * INERTIA - moment**2 / MASS)
    pull = (force - 1j * moment * change * turn) / MASS
    apart = [
        value
        for i in range(6, len(state), 2)
        for value in (state[i + 1], (MOMENT * (pull / turn).real * state[i] - BETA * state[i + 1]) / INERTIA)
    ]
    return [vx, vy, pull.real, pull.imag, w, change, *apart]


def run_up(begin: float, end: float, ramp: float) -> tuple[float, float]:
    """Greatest deflection (m), and the speed there (rad/s), of a touching pair that hangs at ``begin``."""
    options: Any = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-12, "dense_output": True}
    run = solve_ivp(rates, (0.0, (end - begin) / ramp), start(begin), args=(begin, ramp, TOUCHING), **options)
    times = np.linspace(0.0, run.t[-1], 40_001)
    x, y = run.sol(times)[:2]
    size = np.hypot(x, y)
    return float(size.max()), float(begin + ramp * times[size.argmax()])


def beat(state: Any, period: float, speed: float) -> Any:
    """The state after one beat in axes that turn with the rotor, with the angle of the pair there."""
    run = solve_ivp(rates, (0.0, period), state, method="DOP853", rtol=1e-12, atol=1e-15, args=(speed, 0.0, 0.0))
    end = run.y[:, -1]
    back = cmath.exp(-1j * speed * period)
    z, v = complex(*end[:2]) * back, complex(*end[2:4]) * back
    return np.array([z.real, z.imag, v.real, v.imag, end[4] - speed * period + 2.0 * math.pi, *end[5:]])


SCALE = np.array([1e-3, 1e-3, 0.25, 0.25, 1.0, 250.0])


def orbit(speed: float) -> tuple[Any, float]:
    """State of two balls in one place with which a beat repeats itself, and its period."""
    guess = np.array(start(speed))

    def miss(unknown: Any) -> Any:
        state = np.array([*unknown[:4], 0.0, unknown[4]]) * SCALE
        return (beat(state, unknown[5] * 0.05, speed) - state) / SCALE

    first = [*(guess / SCALE)[:4], guess[5] / SCALE[5], 2.0 * math.pi / (speed - guess[5]) / 0.05]
    found = root(miss, first, tol=1e-11)
    assert np.abs(found.fun).max() < 1e-9
    return np.array([*found.x[:4], 0.0, found.x[4]]) * SCALE, float(found.x[5] * 0.05)


def parting_multipliers(speed: float) -> Any:
    """By what small distances of the balls grow over a beat: above one they part, below minus one after every other."""
    state, period = orbit(speed)
    apart = [beat([*state, *unit], period, speed)[6:] for unit in ((1.0, 0.0), (0.0, 1.0))]
    return np.sort(np.linalg.eigvals(np.array(apart).T).real)

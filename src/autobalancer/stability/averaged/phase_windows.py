"""Speed ranges in which balls are drawn towards the light side: the forward whirl must lag by more than a quarter turn.

On orthotropic supports the balls feel the forward part of the whirl only; the backward part averages out over a turn.
The averaged torque balances where Re(1/D) < 0, 1/D = (1/D_x + 1/D_y)/2 the forward receptance. Without damping this
gives the two ranges of Spannan (2021), section 4.2.1: w_x to w_r and above w_y, w_r^2 = (w_x^2 + w_y^2)/2 (4.71).

It is necessary, not sufficient: within a range the averaged or the exact border says from which speed on the balanced
state is stable.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import Polynomial

from autobalancer.assembly.terms import Theory, ignores
from autobalancer.errors import RangeWarning, warn
from autobalancer.files.given import balls_in_races
from autobalancer.stability.averaged.equations import Given, averaged_plane
from autobalancer.stability.host.planar import Plane

Window = tuple[float, float]


def speed_windows(machine: Given, *, damped: bool = False) -> list[Window]:
    """Speed ranges (low, high) in rad/s, ascending, in which the averaged torque moves balls to the light side.

    Parameters
    ----------
    machine
        A machine, the path of its file, or its plane.
    damped
        If true, the sign of the real part of the forward receptance decides, and damping may close the lower range. If
        false, the undamped theory: (w_x, w_r) and (w_y, inf), one range where both critical speeds are one.
    """
    if not isinstance(machine, Plane):
        machine = balls_in_races(machine)
        if left_out := ignores(machine, Theory.AVERAGED):
            warn(f"speed windows: the averaged theory {left_out}", RangeWarning)
    p = averaged_plane(machine)
    squares = sorted(k / p.mass for k in p.stiffness)
    if not damped:
        low, high = (math.sqrt(square) for square in squares)
        middle = math.sqrt(0.5 * sum(squares))
        return [(low, math.inf)] if low == high else [(low, middle), (high, math.inf)]
    unit = squares[1]  # Re(1/D) |D_x D_y|^2 is a cubic in u = (W/unit speed)^2
    detuning = [Polynomial([k / (p.mass * unit), -1.0]) for k in p.stiffness]
    amount = [d**2 + Polynomial([0.0, b**2 / (p.mass**2 * unit)]) for d, b in zip(detuning, p.damping, strict=True)]
    lag = detuning[0] * amount[1] + detuning[1] * amount[0]
    roots = np.asarray(lag.roots(), np.complex128)
    edges = sorted(roots.real[(roots.real > 0.0) & (np.abs(roots.imag) < 1e-7 * np.abs(roots))].tolist())
    points = [0.0, *edges, 2.0 * max(edges, default=1.0)]
    windows: list[Window] = []
    for first, last in zip(points, [*edges, math.inf], strict=False):
        inside = 2.0 * first + 1.0 if last == math.inf else 0.5 * (first + last)
        if float(lag(inside)) < 0.0 and last > first:
            low, high = math.sqrt(first * unit), math.sqrt(last * unit)
            if windows and windows[-1][1] == low:  # a double root parts nothing
                low = windows.pop()[0]
            windows.append((low, high))
    return windows

"""Release and capture of stalled balls: torque balance against closed forms and against the equations of motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.laws.drag_coefficient import DragCurve
from autobalancer.laws.stall import (
    StalledBall,
    planar_receptance,
    stall_balance,
    stall_ranges,
)

MASS, STIFFNESS, DAMPING = 12.27, 44654.0, 68.37  # discoidal rig
ORBIT, BALL, DIAMETER = 0.07695, 6.656e-3, 0.0123
MOMENT, BETA = BALL * ORBIT, 5.468e-6
CRITICAL = math.sqrt(STIFFNESS / MASS)
RIG = planar_receptance(MASS, STIFFNESS, DAMPING)
OIL = DragCurve(ab.laws.discoidal(), 760.0, 0.65e-6, DIAMETER)


def release_speed(stalled: StalledBall, resonances: list[float]) -> float:
    ranges = stall_ranges(stalled, RIG, resonances)
    return ranges[-1].release if ranges else math.nan


def linear(slip: np.ndarray) -> np.ndarray:
    return BETA * slip


def nonlinear(slip: np.ndarray) -> np.ndarray:
    return OIL.torque(slip, ORBIT)


def ball(drag: Callable[..., np.ndarray], rolling: float = 0.0, count: int = 2) -> StalledBall:
    return StalledBall(MOMENT, count * MOMENT, ORBIT, drag, rolling)


@pytest.mark.parametrize(
    ("drag", "rolling", "speed", "digits"),
    [(linear, 0.0, 368.4, 0.1), (nonlinear, 0.0, 72.0, 0.05), (nonlinear, 0.01, 64.58, 0.05)],
)
def test_the_discoidal_rig_lets_go_where_the_balance_at_the_critical_speed_says(
    drag: Callable[..., np.ndarray], rolling: float, speed: float, digits: float
) -> None:
    at = stall_balance(ball(drag, rolling), RIG, CRITICAL)
    assert at.braking[0] == pytest.approx(2.0 * MOMENT**2 * CRITICAL**3 / DAMPING, rel=1e-12)
    assert at.normal_force[0] == pytest.approx(MOMENT * CRITICAL**2, rel=1e-12)
    assert at.speed[0] == pytest.approx(speed, abs=digits)
    highest = release_speed(ball(drag, rolling), [CRITICAL])
    assert at.speed[0] < highest < 1.01 * at.speed[0]


def test_at_the_critical_speed_linear_drag_gives_the_closed_form() -> None:
    for count in (1, 2, 5):
        s = (MOMENT * CRITICAL) ** 2 / (DAMPING * BETA)
        at = stall_balance(ball(linear, count=count), RIG, CRITICAL)
        assert at.speed[0] == pytest.approx(CRITICAL * (1.0 + count * s), rel=1e-12)


def test_above_a_rolling_resistance_of_0_0117_the_balls_never_stall() -> None:
    limit = 2.0 * MOMENT * CRITICAL / (DAMPING * ORBIT)
    assert limit == pytest.approx(0.0117, abs=5e-5)
    assert release_speed(ball(nonlinear, 0.999 * limit), [CRITICAL]) > CRITICAL
    assert math.isnan(release_speed(ball(nonlinear, 1.003 * limit), [CRITICAL]))


def test_rolling_resistance_lowers_release_and_capture() -> None:
    found = [stall_ranges(ball(nonlinear, mu), RIG, [CRITICAL])[0] for mu in np.linspace(0.0, 0.0117, 14)]
    assert (np.diff([fold.release for fold in found]) < 0.0).all()
    assert (np.diff([fold.capture for fold in found]) < 0.0).all()
    assert all(fold.capture < fold.release for fold in found)
    assert all(fold.release_whirl < fold.capture_whirl for fold in found)


def test_the_folds_are_stationary_points_of_the_balance() -> None:
    fold = stall_ranges(ball(nonlinear), RIG, [CRITICAL])[0]
    for whirl, speed, sign in ((fold.release_whirl, fold.release, -1.0), (fold.capture_whirl, fold.capture, 1.0)):
        around = stall_balance(ball(nonlinear), RIG, whirl + np.array([-0.05, 0.0, 0.05])).speed
        assert around[1] == pytest.approx(speed, rel=1e-12)
        assert (sign * (around[[0, 2]] - around[1]) > 0.0).all()


def test_the_torque_balance_closes() -> None:
    b = ball(nonlinear, 0.004)
    at = stall_balance(b, RIG, np.linspace(50.0, 64.0, 30))
    pressed = at.excess > 0.0
    total = nonlinear(at.speed - at.whirl) + 0.004 * at.normal_force * ORBIT
    np.testing.assert_allclose(total[pressed], at.braking[pressed], rtol=1e-9)
    assert (at.slip[~pressed] == 0.0).all()
    assert 0 < pressed.sum() < pressed.size


def test_without_drag_balls_stall_at_any_speed_and_with_very_much_they_never_do() -> None:
    assert math.isinf(release_speed(ball(lambda slip: 0.0 * slip), [CRITICAL]))
    assert math.isnan(release_speed(ball(lambda slip: 1.0 * slip), [CRITICAL]))


def test_drag_that_levels_off_below_the_braking_torque_never_frees_the_balls() -> None:
    assert math.isinf(release_speed(ball(lambda slip: 1e-3 * np.tanh(slip)), [CRITICAL]))


def test_supports_of_two_stiffnesses_have_two_ranges_and_half_the_brake_at_each() -> None:
    split = planar_receptance(MASS, (STIFFNESS, 4.0 * STIFFNESS), DAMPING)
    found = stall_ranges(ball(linear), split, [CRITICAL, 2.0 * CRITICAL])
    assert len(found) == 2
    whole = CRITICAL * (MOMENT * CRITICAL) ** 2 / (DAMPING * BETA)  # half of N = 2
    assert found[0].release == pytest.approx(CRITICAL + whole, rel=0.01)
    assert found[1].release == pytest.approx(2.0 * CRITICAL + 8.0 * whole, rel=0.01)


def torque(slip: float) -> float:
    """The same drag for one number, from the printed form of the law."""
    u = ORBIT * slip
    re = max(abs(u) * DIAMETER / 0.65e-6, 1e-9)
    x = math.log10(re)
    cubic = 2.6865492 - 1.1888334 * x + 0.08115217 * x**2 + 0.00884302 * x**3
    cd = 387.0 / re if re < 10.0 else 0.6 if re > 2e4 else 10.0**cubic
    return ORBIT * 0.5 * 760.0 * math.pi * DIAMETER**2 / 4.0 * cd * u * abs(u)


def motion(speed: float, whirl: float, rolling: float, duration: float) -> np.ndarray:
    """Speed in space of two balls in line that start at ``whirl``, at the end of a run at constant rotor speed.

    Both are one ball of twice the mass; without unbalance the motion settles on a circular whirl. Inertial axes, written
    down from Newton's law; the rolling resistance is that of the actual normal force.
    """
    mass, inertia = 2.0 * BALL, 2.0 * 1.4 * BALL * ORBIT**2
    bare = MASS - mass

    def rate(_: float, y: np.ndarray) -> list[Any]:
        x, z, vx, vz, psi, w = y
        s, c = math.sin(psi), math.cos(psi)
        slip = speed - w
        drive = 2.0 * torque(slip)
        grip = rolling * ORBIT * math.tanh(slip / 0.02)
        # N = mass (eps w^2 - a.n), unknowns x'', y'', w'
        rows = np.array(
            [
                [bare + mass, 0.0, -mass * ORBIT * s],
                [0.0, bare + mass, mass * ORBIT * c],
                [-mass * ORBIT * s + grip * mass * c, mass * ORBIT * c + grip * mass * s, inertia],
            ]
        )
        right = [
            -STIFFNESS * x - DAMPING * vx + mass * ORBIT * w**2 * c,
            -STIFFNESS * z - DAMPING * vz + mass * ORBIT * w**2 * s,
            drive + grip * mass * ORBIT * w**2,
        ]
        ax, az, aw = np.linalg.solve(rows, right)
        return [vx, vz, ax, az, w, aw]

    circle = 2.0 * MOMENT * whirl**2 * complex(RIG(np.array([whirl]))[0])
    start = [circle.real, circle.imag, -whirl * circle.imag, whirl * circle.real, 0.0, whirl]
    run = solve_ivp(rate, (0.0, duration), start, rtol=1e-7, atol=1e-9)
    return np.asarray(run.y[5, -1])


@pytest.mark.slow
@pytest.mark.parametrize("rolling", [0.0, 0.006])
def test_balls_in_line_hang_below_the_release_speed_and_break_away_above(rolling: float) -> None:
    fold = stall_ranges(ball(nonlinear, rolling), RIG, [CRITICAL])[0]
    below, above = 0.995 * fold.release, 1.005 * fold.release
    assert motion(below, fold.release_whirl - 0.3, rolling, 25.0) == pytest.approx(fold.release_whirl, abs=1.0)
    assert motion(above, fold.release_whirl, rolling, 40.0) > fold.capture_whirl


@pytest.mark.slow
def test_balls_in_line_keep_up_above_the_capture_speed_and_fall_back_below() -> None:
    fold = stall_ranges(ball(nonlinear), RIG, [CRITICAL])[0]
    assert motion(1.004 * fold.capture, fold.capture_whirl + 1.0, 0.0, 25.0) > fold.capture_whirl
    assert motion(0.996 * fold.capture, fold.capture_whirl, 0.0, 40.0) < fold.release_whirl

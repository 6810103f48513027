"""The laws of a resolved contact, against closed forms: bounce, Hertz, sliding, rolling, adherence."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.references.resolved import chamber, run

from autobalancer.friction.coulomb import Coulomb
from autobalancer.friction.stribeck import Stribeck
from autobalancer.kernels import records as at
from autobalancer.kernels.laws.contact_law import adherence, normal_force
from autobalancer.laws.impacts import collision_time, hertz_stiffness, pair_stiffness
from autobalancer.simulation.saved import wall_contacts

HERTZ = {"reduced_modulus": 1.15e11}
laws = pytest.mark.parametrize("law", [{}, HERTZ], ids=["linear", "hertz"])
ARM, ORBIT, RADIUS, MASS = 0.02, 0.1, 0.005, 5e-3


def shot(v: float, gap: float = 1e-3) -> dict[tuple[int, int], float]:
    """Start states of a ball that flies at the wall."""
    return {(0, at.BALL_X): ORBIT - gap, (0, at.BALL_VX): v}


def after(own: Any, which: int = 0) -> Any:
    return own[-1, which]


@laws
@pytest.mark.parametrize("restitution", [0.0, 0.2, 0.8, 1.0])
def test_a_head_on_bounce_returns_the_stated_share_of_any_speed(law: dict[str, Any], restitution: float) -> None:
    """Less than 1 % counts as 1 %, beyond critical damping."""
    for v in (0.1, 1.0):
        _, own, _ = run(chamber(restitution=restitution, **law), [0.0, 2.5e-3 / v], shot(v), tolerance=1e-12)
        assert after(own)[at.BALL_VX] == pytest.approx(-max(restitution, 0.01) * v, rel=2e-6)


@laws
def test_the_wall_never_pulls(law: dict[str, Any]) -> None:
    machine = chamber(restitution=0.1, **law)
    times = np.linspace(0.9e-3, 1.6e-3, 2001)
    # the force ends with a corner, across which saved states are only as good as the step that holds it is short
    _, own, assembly = run(machine, [0.0, *times], shot(1.0), tolerance=1e-12)
    force = wall_contacts(own, assembly.system)[1][:, 0]
    assert force.max() > 10.0
    assert force.min() == 0.0
    speeds = own[:, 0, at.BALL_VX]
    assert np.diff(speeds).max() < 1e-11  # only pushed inward
    assert (own[:, 0, at.BALL_X] > ORBIT)[(force == 0.0)].any()  # let go of while the spring is still short
    for hertz in (0.0, 1.0):
        assert normal_force(1e-6, -10.0, 1e6, 1e3, hertz) == 0.0
        assert normal_force(-1e-9, 10.0, 1e6, 1e3, hertz) == 0.0


def test_a_hertz_contact_lasts_as_long_as_hertz_says() -> None:
    """2.9433 x/v with x = (5 m v^2 / 4 k)^(2/5) (Johnson 1985, 11.24); the wall is a cylinder."""
    k, v, gap = hertz_stiffness(1.15e11, RADIUS, ORBIT + RADIUS), 0.5, 1e-4
    lasts = 2.94327 * (1.25 * MASS * v**2 / k) ** 0.4 / v
    end = 3.0 * gap / v
    _, own, _ = run(chamber(**HERTZ), [0.0, end], shot(v, gap), tolerance=1e-11)
    assert after(own)[at.BALL_VX] == pytest.approx(-v, rel=1e-7)
    flown = (gap + ORBIT - after(own)[at.BALL_X]) / v
    assert end - flown == pytest.approx(lasts, rel=1e-4)


@pytest.mark.parametrize("restitution", [1.0, 0.6])
def test_two_unequal_balls_part_with_the_stated_share_and_without_loss_after_the_time_of_hertz(
    restitution: float,
) -> None:
    v, gap, reach = 0.5, 1e-4, RADIUS + 8e-3
    balls = [
        {"count": 1, "mass": mass, "diameter": 2.0 * radius, "start_angles": [angle]}
        for mass, radius, angle in ((MASS, RADIUS, 0.0), (4.0 * MASS, 8e-3, 1.0))
    ]
    race = {"orbit_radius": None, "race_radius": 0.1, "balls": balls, "contact": {"restitution": restitution}}
    start = {(0, x): 0.0 for x in (at.BALL_X, at.BALL_Y, at.BALL_VY)} | {(0, at.BALL_VX): v}
    start |= {(1, x): 0.0 for x in (at.BALL_VX, at.BALL_VY, at.BALL_Y)} | {(1, at.BALL_X): reach + gap}
    end = 3.0 * gap / v
    _, own, _ = run(chamber(race=race, **HERTZ), [0.0, end], start, tolerance=1e-12)
    one, other = own[-1]
    assert other[at.BALL_VX] - one[at.BALL_VX] == pytest.approx(restitution * v, rel=1e-6)
    assert one[at.BALL_VX] + 4.0 * other[at.BALL_VX] == pytest.approx(v, rel=1e-9)
    if restitution == 1.0:
        apart = (other[at.BALL_X] - one[at.BALL_X] - reach) / v
        lasts = collision_time(pair_stiffness(HERTZ["reduced_modulus"], RADIUS, 8e-3), 0.8 * MASS, v)
        assert end - gap / v - apart == pytest.approx(lasts, rel=1e-5)


def test_a_linear_contact_lasts_half_a_period() -> None:
    k, v, gap = 1e6, 0.5, 1e-4
    end = 3.0 * gap / v + 1e-3
    _, own, _ = run(chamber(stiffness=k), [0.0, end], shot(v, gap), tolerance=1e-11)
    flown = (gap + ORBIT - after(own)[at.BALL_X]) / v
    assert end - flown == pytest.approx(math.pi * math.sqrt(MASS / k), rel=1e-6)


def test_hertz_stiffness_on_a_flat_wall_is_the_closed_form_and_grows_in_a_tight_groove() -> None:
    flat = 4.0 / 3.0 * 1e11 * math.sqrt(RADIUS)
    assert hertz_stiffness(1e11, RADIUS) == pytest.approx(flat, rel=1e-9)
    # nearly circular ellipses: exact to first order with the geometric mean of both radii
    wide = hertz_stiffness(1e11, RADIUS, 100.0 * RADIUS)
    assert wide == pytest.approx(flat * (1.0 - 0.01) ** -0.25, rel=1e-5)
    assert hertz_stiffness(1e11, RADIUS, -0.1) < flat < hertz_stiffness(1e11, RADIUS, 0.1)


@laws
def test_a_ball_that_slides_on_the_wall_rolls_with_five_sevenths_of_its_speed(law: dict[str, Any]) -> None:
    """Whatever the friction: m v - (2/5) m r s is kept; before it rolls, 1/v = 1/v0 + mu t/eps."""
    v, mu = 2.0, 0.2
    machine = chamber(sliding_friction=mu, slip_speed=1e-4, restitution=0.0, **law)
    start = {(0, at.BALL_VY): v}
    rolls = ORBIT / mu * (7.0 / 5.0 - 1.0) / v
    _, own, _ = run(machine, [0.0, 0.5 * rolls, 0.999 * rolls, 3.0 * rolls], start, tolerance=1e-9)
    place = own[:, 0, at.BALL_X] + 1j * own[:, 0, at.BALL_Y]
    speed = ((own[:, 0, at.BALL_VX] + 1j * own[:, 0, at.BALL_VY]) * np.exp(-1j * np.angle(place))).imag
    spin = RADIUS * own[:, 0, at.BALL_SPIN]
    assert speed[1] == pytest.approx(1.0 / (1.0 / v + mu * 0.5 * rolls / ORBIT), rel=2e-3)
    assert speed[2] + spin[2] > 1e-4
    assert speed[3] == pytest.approx(5.0 / 7.0 * v, rel=1e-3)
    assert spin[3] == pytest.approx(-speed[3], rel=1e-5)
    np.testing.assert_allclose(speed - 0.4 * spin, v, rtol=1e-3)


def test_rolling_resistance_slows_a_rolling_ball_by_a_over_r_in_1_4() -> None:
    """The moment a F_N of (5.9) alone: v' = -(a/r_b) F_N/(1.4 m), F_N = m v^2/eps, which is (5.14) for free rolling."""
    arm, v = 0.02, 2.0
    machine = chamber(
        balls={"start_speeds": [v / ORBIT]},
        race={"friction": {"rolling_resistance": arm}},
        restitution=0.0, sliding_friction=0.4, slip_speed=1e-3, rest_speed=1e-3,
    )  # fmt: skip
    end = 1.0
    _, own, _ = run(machine, [0.0, end], tolerance=1e-9)
    speed = math.hypot(after(own)[at.BALL_VX], after(own)[at.BALL_VY])
    assert speed == pytest.approx(1.0 / (1.0 / v + arm / 1.4 * end / ORBIT), rel=1e-3)


def test_friction_of_both_forms_is_odd_and_has_the_stated_level_and_peak() -> None:
    def at(slip: float) -> SimpleNamespace:
        return SimpleNamespace(slip=slip, sliding=0.05, slip_speed=1e-3)

    slips = np.geomspace(1e-5, 10.0, 2001)
    plain = np.array([Coulomb.coefficient(at(u), None) for u in slips])
    np.testing.assert_allclose(plain, 0.05 * np.tanh(slips / 1e-3), rtol=1e-13)
    law = Stribeck(peak=0.2, peak_speed=0.1)
    peaked = np.array([law.coefficient(at(u), law) for u in slips])
    assert 0.19 < peaked.max() < 0.2  # as printed, the factor 1.0 - mu would make it 0.97
    assert peaked[-1] == pytest.approx(0.05, rel=1e-6)
    assert law.coefficient(at(-0.01), law) == -law.coefficient(at(0.01), law)


def test_adherence_takes_from_the_ball_at_least_what_it_stores() -> None:
    rng = np.random.default_rng(1)
    for _ in range(2000):
        hold, slip, v = rng.normal(0.0, 1e-3), rng.normal(0.0, 0.02), rng.normal(0.0, 0.02)
        limit = 10.0 ** rng.uniform(-3, 1)
        force, rate = adherence(hold, slip, v, limit, 1e3, 2.0, 0.02)
        assert force * v >= 1e3 * hold * rate - 1e-15
        assert abs(force) <= limit * (1.0 + 1e-12)


@pytest.mark.parametrize("share", [0.85, 0.99, 1.1])
def test_adherence_holds_a_ball_on_a_slope_up_to_its_coefficient(share: float) -> None:
    """At the angle alpha from the lowest point a ball needs tan(alpha) F_N."""
    mu = 0.1
    angle = -0.5 * math.pi + math.atan(share * mu)
    machine = chamber(
        axis="horizontal", balls={"start_angles": [angle]}, race={"friction": {"adherence": mu}},
        restitution=0.0, sliding_friction=0.4, slip_speed=1e-2, rest_speed=2e-3,
    )  # fmt: skip
    load = MASS * 9.80665
    start = {
        (0, at.BALL_X): (ORBIT + load / 1e6) * math.cos(angle),
        (0, at.BALL_Y): (ORBIT + load / 1e6) * math.sin(angle),
    }
    _, own, _ = run(machine, [0.0, 0.5, 1.0], start, tolerance=1e-10)
    moved = np.unwrap(np.angle(own[:, 0, at.BALL_X] + 1j * own[:, 0, at.BALL_Y])) - angle
    if share < 0.9:  # the spring never yielded
        assert moved[1:] * ORBIT == pytest.approx(-load * math.sin(angle + 0.5 * math.pi) / 1e3, rel=1e-3)
    if share < 1.0:
        assert math.hypot(own[-1, 0, at.BALL_VX], own[-1, 0, at.BALL_VY]) < 1e-9
    else:
        assert moved[1] < -0.05

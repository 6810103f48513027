"""Resolved balls on races that are not round: closest point, reflection, and the guided ball of the same path."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from tests.references.resolved import beyond, chamber, contact, run
from tests.references.resolved_run_ups import GRIP, PLANAR, RIG, RIGID, apart, run_up

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.kernels import records as at
from autobalancer.kernels.balls.guided import closest
from autobalancer.kernels.records import FREE_BALL, WAVE
from autobalancer.machine import Machine, Race

WAVES: list[dict[str, float]] = [
    {"order": 2, "amplitude": 1e-3, "angle": 0.3},
    {"order": 5, "amplitude": 1e-4, "angle": 1.0},
]
POINTS = {"count": 2, "mass": 2.5e-3, "diameter": 8e-3, "start_angles": [1.0, -1.9], "motion": "point"}


def race_of(machine: Machine) -> Race:
    return machine.balancers[0].races[0]


def test_the_closest_point_of_an_orbit_is_the_closest_and_the_normal_is_the_slope_of_the_distance() -> None:
    random = np.random.default_rng(2)
    for _ in range(40):
        waves = [
            {"order": k, "amplitude": float(random.uniform(0.0, 4e-3 / k**2)), "angle": float(random.uniform(0.0, 6.0))}
            for k in (1, 2, 3, 7)
        ]
        race = race_of(chamber(race={"harmonics": waves}))
        rows, ball = WAVE.rows(7), FREE_BALL.rows(1)[0]
        ball.waves = 7
        for wave in waves:
            turned = wave["amplitude"] * cmath.exp(1j * wave["order"] * wave["angle"])
            rows[int(wave["order"]) - 1] = turned.real, turned.imag
        angle, away = random.uniform(-3.0, 3.0), 0.1 + random.uniform(-8e-3, 8e-3)
        place = away * cmath.exp(1j * angle)

        def nearest(z: complex, rows: Any = rows, ball: Any = ball) -> Any:
            return closest.py_func(rows, ball, 0.1, z.real, z.imag, z.real / abs(z), z.imag / abs(z))

        depth, nx, ny = nearest(place)
        assert depth == pytest.approx(float(beyond(race, 0.1, np.array([place]))[0]), abs=1e-14)
        assert math.hypot(nx, ny) == pytest.approx(1.0, rel=1e-14)
        slope = [(nearest(place + step)[0] - nearest(place - step)[0]) / 2e-6 for step in (1e-6, 1e-6j)]
        np.testing.assert_allclose([nx, ny], slope, atol=1e-9)


@pytest.mark.parametrize(("side", "level"), [(1.0, 0.1), (-1.0, 0.09)], ids=["outer wall", "inner wall"])
def test_a_ball_is_thrown_back_as_from_a_mirror(side: float, level: float) -> None:
    """An elastic stiff wall reflects the velocity at its normal, which is not the radius."""
    waves = [{"order": 3, "amplitude": 4e-3, "angle": 0.25}]
    machine = chamber(stiffness=1e8, race={"width": 0.02, "harmonics": waves})
    spot, speed = 0.6, side * cmath.exp(0.5j)
    radius = level + 4e-3 * math.cos(3.0 * (spot - 0.25))
    tangent = (1j * radius - 12e-3 * math.sin(3.0 * (spot - 0.25))) * cmath.exp(1j * spot)
    start = radius * cmath.exp(1j * spot) - 3e-3 * speed
    change = {
        (0, at.BALL_X): start.real,
        (0, at.BALL_Y): start.imag,
        (0, at.BALL_VX): speed.real,
        (0, at.BALL_VY): speed.imag,
    }
    _, own, _ = run(machine, [0.0, 4.5e-3], change)
    unit = tangent / abs(tangent)
    found = complex(own[1, 0, at.BALL_VX], own[1, 0, at.BALL_VY])
    assert found == pytest.approx(unit**2 * speed.conjugate(), abs=1e-4)
    assert abs((1j * cmath.exp(1j * spot)) ** 2 * speed.conjugate() - found) > 0.1


@pytest.mark.parametrize(
    ("rotor", "torque"),
    [(PLANAR, False), (RIGID, True), (RIG, False)],
    ids=["planar speed", "rigid torque", "rig speed"],
)
def test_stiff_balls_roll_over_the_waves_of_a_race_like_guided_ones(rotor: dict[str, Any], torque: bool) -> None:
    waves: dict[str, Any] = {"harmonics": WAVES}
    guided = run_up(rotor=rotor, torque=torque, **waves)
    assert apart(guided, run_up(rotor=rotor, torque=torque)) > 1.0
    law = contact(stiffness=1e7, slip_speed=0.01, **GRIP)
    assert apart(guided, run_up(law, rotor=rotor, torque=torque, **waves)) < 2e-3


def test_stiff_balls_slip_over_the_waves_of_a_race_like_guided_points() -> None:
    """The difference falls with 1/k."""
    waves: dict[str, Any] = {"harmonics": WAVES}
    guided = run_up(**waves, balls=[POINTS])
    laws = [contact(stiffness=k, slip_speed=0.01, restitution=0.3) for k in (1e6, 1e7)]
    soft, stiff = (apart(guided, run_up(law, **waves)) for law in laws)
    assert stiff == pytest.approx(0.1 * soft, rel=0.02)
    assert stiff < 1e-3


def test_a_measured_profile_is_the_same_race_as_its_waves() -> None:
    angles = 2.0 * math.pi * np.arange(36) / 36
    profile = 1e-4 * np.cos(2.0 * angles - 1.0)
    measured = chamber(race={"roundness": {"deviations": profile.tolist(), "harmonics": 2}})
    given = chamber(race={"harmonics": [{"order": 2, "amplitude": 1e-4, "angle": 0.5}]})
    for amplitude in ("cosine", "sine"):
        one, other = (getattr(assemble(m).system.waves, amplitude) for m in (measured, given))
        np.testing.assert_allclose(one, other, atol=1e-15)
        assert one.size == 2


def test_a_result_gives_the_distance_from_a_wavy_wall() -> None:
    machine = run_up(contact(stiffness=1e6, slip_speed=0.01, start_gap=2e-3, **GRIP), harmonics=WAVES)
    result = ab.simulate(machine, duration=0.3, save=ab.Samples(31))
    gap = result.ball_gap.values
    np.testing.assert_allclose(gap[0], 2e-3, rtol=1e-5)  # measured across the waves
    assert gap[-1].max() < 0.0
    # the balls still run over the waves: the damper of the contact adds 4e-4
    np.testing.assert_allclose(result.ball_normal_force.values[-1] / -gap[-1], 1e6, rtol=1e-3)

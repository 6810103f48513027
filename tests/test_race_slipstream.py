"""Balls that shield one another from the fluid in a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.references.race_runs import states_from, states_of
from tests.references.rates import rates_at
from tests.references.resolved import chamber, states_at
from tests.references.standing_races import DENSITY, DIAMETER, ORBIT, standing

import autobalancer as ab
from autobalancer.assembly.guided_balls import Lag
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError, RangeWarning
from autobalancer.kernels.balls.on_stations import guided_rough
from autobalancer.kernels.balls.planar import planar
from autobalancer.kernels.system import BALLS
from autobalancer.laws.drag_coefficient import slipstream_factor, slipstream_factors
from autobalancer.machine import Machine
from autobalancer.simulation.record import Samples
from autobalancer.simulation.steppers import equations

VISCOSITY = 1e-4
OIL = {"density": 900.0, "viscosity": VISCOSITY}
LAWS: list[dict[str, Any]] = [{"law": "viscous", "damping": 2e-4}, {"law": "sphere_on_plane", "range": "whole"}]


def race(shielded: bool, angles: list[float], **changes: Any) -> Machine:
    """A race that stands still on a vertical axis, so that only drag acts along it."""
    return standing(axis="vertical", angles=angles, **{"fluid": OIL, "slipstream": shielded, **changes})


def accelerations(machine: Machine, lag: float = 0.0) -> Callable[[Any, Any], np.ndarray]:
    """Of the ball angles, as a function of angles and speeds; the fluid is behind the race by ``lag``."""
    table = Lag(times=np.array([0.0, 1.0]), values=np.array([lag, lag]))
    assembly = assemble(machine, rotating=False, lags={(0, 0): table})
    whole, n = assembly.state.copy(), len(assembly.balls)

    def found(angles: Any, rates: Any) -> np.ndarray:
        whole[6 : 6 + n], whole[6 + n : 6 + 2 * n] = angles, rates
        out = rates_at(guided_rough, 0.5, whole, assembly.system)
        return out[6 + n : 6 + 2 * n]

    return found


@pytest.mark.parametrize("lag", [0.0, 0.8])
@pytest.mark.parametrize("law", LAWS, ids=["linear", "whole"])
def test_the_drag_of_each_ball_has_the_factor_of_the_law(law: dict[str, Any], lag: float) -> None:
    random = np.random.default_rng(3)
    shares = []
    for _ in range(8):
        angles = np.cumsum(random.uniform(0.11, 1.2, 4)) + random.integers(-2, 3, 4) * 2.0 * math.pi
        rates = random.uniform(-3.0, 3.0, 4)
        on, off = (accelerations(race(s, angles.tolist(), drag=law), lag)(angles, rates) for s in (True, False))
        expected = slipstream_factors(angles, ORBIT * (rates + lag), ORBIT, DIAMETER, VISCOSITY)
        np.testing.assert_allclose(on / off, expected, rtol=1e-8)
        shares.append(expected)
    assert np.min(shares) < 0.75
    assert np.max(shares) == 1.0


@pytest.mark.slow
def test_drag_is_continuous_where_balls_pass_each_other_and_where_they_turn_round() -> None:
    """All that a step of an angle or a speed changes gets smaller with the step."""
    drag = accelerations(race(True, [0.0, 0.3, 0.7, 1.5], drag=LAWS[0], collisions=False))

    def jump(steps: int) -> float:
        paths = [
            [drag([a, 0.3, 0.35, fixed], [1.0, -1.0, 0.5, 0.7]) for a in np.linspace(-0.2, 2.0 * math.pi, steps)]
            for fixed in (1.5, -0.4)
        ]
        paths.append([drag([0.0, 0.3, 0.7, 1.5], [v, 1.0, 0.5 - v, 1.0]) for v in np.linspace(-1.0, 1.0, steps)])
        return max(float(np.abs(np.diff(path, axis=0)).max()) for path in paths)

    assert jump(2401) < 0.05 * np.abs(drag([0.0, 0.3, 0.7, 1.5], [1.0, -1.0, 0.5, 0.7])).max()
    assert jump(9601) < 0.3 * jump(2401)


def test_the_factor_itself_has_no_jump_at_the_end_of_its_range() -> None:
    for re in (0.0, 150.0, 300.0, 1e4):
        assert np.abs(np.diff(slipstream_factor(re, np.linspace(0.5, 25.0, 24501)))).max() < 5e-4
        assert float(slipstream_factor(re, 20.0)) == 1.0


def test_a_ball_behind_catches_up_as_both_slow_down_and_takes_no_energy_from_the_fluid() -> None:
    speeds = [40.0, 40.0]
    times = np.linspace(0.0, 1.0, 401)
    off, on = (states_of(race(s, [0.0, 0.5], speeds=speeds, drag=LAWS[0]), times) for s in (False, True))
    gaps = [run[:, 7] - run[:, 6] for run in (off, on)]
    assert np.ptp(gaps[0]) < 1e-9
    assert np.all(np.diff(gaps[1][gaps[1] > 0.105]) < 0.0)
    assert gaps[1][-1] == pytest.approx(2.0 * math.asin(0.5 * DIAMETER / ORBIT), rel=1e-2)  # side by side at last
    assert np.diff((on[:, 8:10] ** 2).sum(axis=1)).max() < 0.0
    # the leader has nobody ahead within reach: it goes as if alone, by the exponential of linear drag
    before = gaps[1] > 0.11
    inertia = assemble(race(True, [0.5], drag=LAWS[0])).balls[0].inertia
    np.testing.assert_allclose(on[before, 9], 40.0 * np.exp(-2e-4 / inertia * times[before]), rtol=1e-9)


def test_resolved_balls_shield_each_other_like_guided_ones() -> None:
    ball = {"count": 2, "mass": 5e-3, "diameter": DIAMETER, "start_angles": [0.0, 0.25], "start_speeds": [20.0, 20.0]}
    part = {"drag": LAWS[1], "fluid": OIL, "slipstream": True}
    law = {"restitution": 0.3, "sliding_friction": 1.0, "slip_speed": 1e-2, "stiffness": 1e5}
    times = np.linspace(0.0, 0.2, 21)
    lags = {(0, 0): Lag(times=np.array([0.0, 1.0]), values=np.array([0.0, 30.0]))}
    found = []
    for shielded, more in ((True, {"resolved": None}), (True, {}), (False, {})):
        machine = chamber(speed=50.0, balls=ball, race=part | {"slipstream": shielded} | more, **law)
        found.append(states_at(assemble(machine, lags=lags), times, 1e-9)[:, BALLS : BALLS + 2])
    np.testing.assert_allclose(found[1], found[0], atol=5e-4)
    assert np.abs(found[2] - found[0]).max() > 0.05


def test_a_partition_far_from_resolved_balls_leaves_their_slipstream_as_it_is() -> None:
    ball = {"count": 2, "mass": 5e-3, "diameter": DIAMETER, "start_angles": [0.0, 0.25], "start_speeds": [20.0, 20.0]}
    part = {"drag": LAWS[1], "fluid": OIL}
    found = []
    for more in ({}, {"partitions": {"count": 1, "angle": 2.0}}, {"slipstream": False}):
        assembly = assemble(chamber(balls=ball, race=part | {"slipstream": True} | more))
        found.append(rates_at(equations(assembly).rates, 0.0, assembly.state, assembly.system))
    np.testing.assert_array_equal(found[1], found[0])
    assert np.abs(found[2] - found[0]).max() > 0.05 * np.abs(found[0]).max()


def test_shielded_balls_lose_no_less_energy_than_drag_takes_with_any_fluid_that_lags() -> None:
    """Power of the drag on the velocity through the fluid is never positive, in random states of five balls."""
    random = np.random.default_rng(8)
    for _ in range(20):
        angles = (np.cumsum(random.uniform(0.11, 1.1, 5))).tolist()
        rates, lag = random.uniform(-4.0, 4.0, 5), float(random.uniform(-3.0, 3.0))
        found = accelerations(race(True, angles, drag=LAWS[1]), lag)(angles, rates)
        assert np.all(found * (rates + lag) <= 0.0)


def _stalled(oil: str, shielded: bool) -> Machine:
    """The discoidal stand-in, its two balls side by side and stalled at the critical speed while the rotor is faster."""
    machine = ab.load_machine("examples/machines/discoidal.toml")
    where = "balancers[1].races[1]"
    machine = ab.with_parameter(machine, f"{where}.fluid.name", oil)
    return ab.with_parameter(machine, f"{where}.slipstream", shielded)


def test_balls_shield_each_other_only_where_the_machine_says_so() -> None:
    with_it, without = _stalled("silicone oil 20", True), _stalled("silicone oil 20", False)
    assert equations(assemble(without)).rates is planar
    assert equations(assemble(with_it)).rates is guided_rough
    old = ab.load_machine("examples/machines/discoidal.toml")
    assert without == old
    found = ab.stability.borders(with_it, only=("release speed", "capture speed"))
    assert [border.note.endswith("ignores slipstream") for border in found] == [True, True]


@pytest.mark.parametrize("shielded", [False, True])
def test_stalled_balls_line_up_in_their_slipstream_and_are_released_where_less_drag_lets_go(shielded: bool) -> None:
    """Torque balance of the pair with the mean of both factors, against a slow run-up."""
    viscosity, where = 30e-6, "balancers[1].races[1]"
    ramp = {"kind": "table", "time": [0.0, 5.0, 45.0, 445.0], "speed": [0.0, 12.7, 63.0, 75.0]}
    machine = ab.load_machine("examples/machines/discoidal.toml")
    machine = ab.with_parameter(machine, f"{where}.fluid", {"density": 950.0, "viscosity": viscosity})
    machine = ab.with_parameter(ab.with_parameter(machine, f"{where}.slipstream", shielded), "drive.profile", ramp)
    (critical,), (ball, _) = assemble(machine).critical_speeds, assemble(machine).balls
    alone = next(border.speed for border in ab.stability.borders(machine) if border.name == "release speed")
    touching = 2.0 * math.asin(ball.radius / ball.orbit_radius)

    def excess(speed: float) -> float:
        slip = [(critical - speed) * ball.orbit_radius] * 2
        share = (
            slipstream_factors([0.0, touching], slip, ball.orbit_radius, ball.diameter, viscosity).mean()
            if shielded
            else 1.0
        )
        return critical + (alone - critical) / float(share) - speed

    run = ab.simulate(machine, duration=445.0, save=Samples(4000))
    stalled = run.where((run.time > 50.0) & (run.ball_speed_in_rotor.mean("ball") < -2.0), drop=True)
    assert float(stalled.speed[-1]) == pytest.approx(brentq(excess, critical + 0.1, 200.0), rel=0.01)
    gap = np.abs(np.angle(np.exp(1j * stalled.ball_angle_in_rotor.diff("ball"))))
    assert (float(np.median(gap)) < 1.01 * touching) == shielded


def test_a_run_says_that_its_reynolds_numbers_left_the_fit() -> None:
    with pytest.warns(RangeWarning, match="slipstream: the Reynolds number reached"):
        run = ab.simulate(race(True, [0.0, 1.0], speeds=[50.0, 10.0], drag=LAWS[0]), duration=0.01, save=Samples(3))
    assert run.attrs["slipstream_reynolds"] == pytest.approx(50.0 * ORBIT * DIAMETER / VISCOSITY, rel=1e-6)
    calm = ab.simulate(race(True, [0.0, 1.0], speeds=[5.0, 1.0], drag=LAWS[0]), duration=0.01, save=Samples(3))
    assert calm.attrs["slipstream_warning"] == ""


def test_a_slipstream_of_unknown_fluid_or_size_is_refused() -> None:
    with pytest.raises(MachineError, match="slipstream: needs the viscosity of a fluid"):
        standing(slipstream=True)
    points = [{"mass": 0.01, "motion": "point"}] * 2
    with pytest.raises(MachineError, match="needs the size of the balls"):
        assemble(race(True, [], balls=points))
    unequal = [{"diameter": d, "density": DENSITY} for d in (0.01, 0.012)]
    with pytest.raises(MachineError, match="balls of equal size only"):
        assemble(race(True, [], orbit_radius=None, race_radius=0.1, balls=unequal))


def test_one_ball_alone_is_nobodys_slipstream() -> None:
    machine = race(True, [0.3], speeds=[5.0], drag=LAWS[0])
    found = states_from(assemble(machine, rotating=False), np.array([0.0, 0.5]))
    plain = states_of(race(False, [0.3], speeds=[5.0], drag=LAWS[0]), np.array([0.0, 0.5]))
    np.testing.assert_array_equal(found, plain)

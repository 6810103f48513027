"""Resolved balls that hit the partitions of their race."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.race_runs import states_of
from tests.references.resolved import chamber, run

from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.resolved import ball_states
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.kernels import records as at
from autobalancer.kernels.system import BALLS
from autobalancer.machine import Machine

ORBIT, RADIUS = 0.1, 2e-3
SMALL: dict[str, Any] = {"diameter": 2.0 * RADIUS, "start_speeds": [20.0]}


def split(count: int = 4, *, start: float = 0.7, **changes: Any) -> Machine:
    race = {"partitions": {"count": count, "angle": 0.1}, "contact": {"restitution": changes.pop("rebound", 0.5)}}
    return chamber(
        balls=SMALL | {"start_angles": [start]}, race=race, **{"restitution": 0.2, "stiffness": 1e7, **changes}
    )


def guided(machine: Machine) -> Machine:
    race = machine.balancers[0].races[0]
    points = tuple(balls.model_copy(update={"motion": "point"}) for balls in race.balls)
    plain = race.model_copy(update={"resolved": None, "balls": points})
    return machine.model_copy(update={"balancers": (machine.balancers[0].model_copy(update={"races": (plain,)}),)})


@pytest.mark.parametrize("count", [1, 4])
def test_without_friction_a_ball_bounces_to_and_fro_between_partitions_like_a_guided_one(count: int) -> None:
    """Up to (r/eps)^2 of the speed, by which a partition also pushes it outward; several rebounds, from both sides."""
    machine, times = split(count, rebound=0.8), np.linspace(0.0, 1.0, 4001)
    expected = states_of(guided(machine), times, tolerance=1e-9)
    found, _, _ = run(machine, times, tolerance=1e-9)
    turned = np.flatnonzero(np.diff(np.sign(expected[:, BALLS + 1])))
    assert turned.size >= (2 if count == 1 else 5)
    np.testing.assert_allclose(found[:, BALLS], expected[:, BALLS], atol=0.02)
    half = math.asin(RADIUS / ORBIT)
    low = 0.1 + half
    high = 0.1 + 2.0 * math.pi / count - half
    assert found[:, BALLS].min() == pytest.approx(low, abs=2e-3)
    assert found[:, BALLS].max() == pytest.approx(high, abs=2e-3)


@pytest.mark.parametrize("rebound", [0.2, 0.9])
def test_a_partition_returns_the_stated_share_of_the_speed(rebound: float) -> None:
    """e c^2 - s^2 with s = r/eps: what it returns along its normal, less what it throws against the wall."""
    _, own, _ = run(split(rebound=rebound), [0.0, 0.06], tolerance=1e-10)
    place, velocity = (
        own[-1, 0, x] + 1j * own[-1, 0, y] for x, y in ((at.BALL_X, at.BALL_Y), (at.BALL_VX, at.BALL_VY))
    )
    along = (velocity * (1j * place / abs(place)).conjugate()).real
    share = (RADIUS / ORBIT) ** 2
    assert along == pytest.approx(-2.0 * (rebound - 0.5 * (1.0 + rebound) * share), abs=2.0 * (1.0 + rebound) * share)


def test_a_rolling_ball_keeps_its_spin_at_a_partition_and_comes_back_slower() -> None:
    """(e - 2/5)/(7/5) of the speed, once it rolls again: a guided ball would turn its spin round too."""
    rebound = 0.9
    machine = split(1, start=5.9, rebound=rebound, sliding_friction=0.2, slip_speed=1e-3, stiffness=1e6)
    states, own, _ = run(machine, [0.0, 0.022, 0.5], tolerance=1e-8)
    spin = RADIUS * own[:, 0, at.BALL_SPIN]
    assert spin[1] == pytest.approx(-2.0, rel=1e-3)
    assert spin[2] == pytest.approx(2.0 * (rebound - 0.4) / 1.4, rel=0.03)
    assert states[2, BALLS + 1] * ORBIT == pytest.approx(-spin[2], rel=1e-3)


def test_a_rough_partition_drags_a_rolling_ball_off_its_wall() -> None:
    """Its surface moves outward there: mu (1 + e) v inward, and it slips throughout while this is less than 2/7 v."""
    machine = split(rebound=1.0, ball_friction=0.1, slip_speed=1e-3)
    _, own, _ = run(machine, [0.0, 0.0497], tolerance=1e-9)
    velocity, wall = own[-1, 0, at.BALL_VX] + 1j * own[-1, 0, at.BALL_VY], np.exp(1j * (0.1 + 0.5 * math.pi))
    assert (velocity * wall.conjugate()).real == pytest.approx(2.0 * RADIUS / ORBIT - 0.2 * 2.0, rel=0.03)
    assert RADIUS * own[-1, 0, at.BALL_SPIN] == pytest.approx(-2.0 * (1.0 - 2.5 * 0.2), rel=0.03)


def test_a_ball_that_is_told_to_start_in_a_partition_is_refused_and_one_that_is_not_told_starts_beside_it() -> None:
    for start in (0.1 + 1e-3, 0.1 - 1e-3):
        with pytest.raises(MachineError, match="overlaps the partition beside it"):
            assemble(split(start=start, start_gap=1e-3))
    many = with_value_at(split(100, start=0.1 + math.pi / 100), "balancers[1].races[1].balls[1].start_angles", None)
    width, half = 2.0 * math.pi / 100, math.asin(RADIUS / ORBIT)
    for seed in range(20):
        assembly = assemble(many, seed=seed)
        own = ball_states(assembly.state[None], assembly.system, assembly.places.shape[2])[0, 0]
        behind = (math.atan2(own[at.BALL_Y], own[at.BALL_X]) - 0.1) % width
        assert half - 1e-9 <= behind <= width - half + 1e-9

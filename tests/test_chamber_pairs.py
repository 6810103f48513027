"""The list of near pairs: it is made again when a ball may have come near another, and not before."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import free_machine

from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.chamber_run import March, begin

STEP, EVERY = 5e-6, 200


def drum(speed: float, balls: dict[str, Any], friction: float) -> ChamberMachine:
    """A drum of 60 mm on a body that is held, at constant speed."""
    chamber = {"radius": 0.06, "depth": 0.1, "balls": [{"density": 7800.0} | balls]}
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    return free_machine(
        body={"freedom": "fixed"}, chambers=[chamber], drive=drive, contact={"friction": friction},
        gravity=[0.0, 0.0, -9.81 if speed < 50.0 else 0.0],
    )  # fmt: skip


def listed(march: March) -> set[tuple[int, int]]:
    """Pairs in the list now."""
    pairs, count = march.chamber.pairs, int(march.chamber.progress.pairs)
    return set(zip(pairs.first[:count].tolist(), pairs.second[:count].tolist(), strict=True))


def touching(march: March) -> set[tuple[int, int]]:
    """Pairs whose balls overlap now, whatever the list says."""
    place, radius = march.chamber.balls.position, march.chamber.balls.radius
    gaps = np.linalg.norm(place[:, None] - place[None], axis=-1) - radius[:, None] - radius[None]
    return {(int(i), int(j)) for i, j in np.argwhere(gaps < 0.0) if i < j}


@pytest.mark.parametrize("count", [40, 130])  # every pair is looked at, and cells
def test_balls_that_touch_are_always_in_the_list(count: int) -> None:
    machine = drum(30.0, {"count": count, "diameter": 0.012}, 0.6)
    march = begin(machine, STEP, EVERY, "verlet", 0, settle=False)
    most = 0
    for _ in range(150):
        march.take(1)
        now = touching(march)
        most = max(most, len(now))
        assert now <= listed(march)
    assert most > 10
    assert 5 < march.chamber.progress.rebuilds < 150 * EVERY / 10


def test_balls_that_turn_with_the_rotor_are_listed_once() -> None:
    speed, reach = 100.0, 0.054
    angles = np.array([0.0, 0.3, 2.0, 4.0])
    across = np.stack([np.zeros(4), np.cos(angles), np.sin(angles)], axis=1)
    along = np.stack([np.zeros(4), -np.sin(angles), np.cos(angles)], axis=1)
    balls = {
        "count": 4, "diameter": 0.012, "positions": (reach * across).tolist(),
        "velocities": (speed * reach * along).tolist(), "spins": [[speed, 0.0, 0.0]] * 4,
    }  # fmt: skip
    march = begin(drum(speed, balls, 0.4), STEP, EVERY, "verlet", 0, settle=False)
    march.take(200)
    way = speed * reach * march.samples * EVERY * STEP
    assert way > 500.0 * march.chamber.run.margin
    assert march.chamber.progress.rebuilds == 1

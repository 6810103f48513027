"""Contacts are evaluated in blocks; what a ball does must not depend on where its contacts stand in them."""

from __future__ import annotations

import numpy as np
import pytest

from autobalancer.kernels.chamber.chamber_records import BLOCK
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber


def places() -> tuple[tuple[float, float, float], ...]:
    """23 balls of 17 mm in three layers above the bottom of a drum of 50 mm."""
    across = 0.017 * np.arange(-2, 3)
    sites = [(x, y, z) for z in (-0.02, -0.003) for x in (-0.0085, 0.0085) for y in across]
    return tuple(sites + [(0.0, y, 0.014) for y in (-0.017, 0.0, 0.017)])


def contacts(found: np.ndarray, machine: ChamberMachine) -> int:
    """Balls that touch each other or a wall, at ``found`` (chambers, balls, 3)."""
    chamber = machine.chambers[0]
    radius, balls = chamber.balls[0].radius, found.shape[1]
    gaps = np.linalg.norm(found[:, :, None] - found[:, None], axis=-1)
    pairs = (int((gaps < 2.0 * radius).sum()) - found.shape[0] * balls) // 2
    race = np.hypot(found[..., 1], found[..., 2]) > chamber.radius - radius
    side = np.abs(found[..., 0]) > 0.5 * chamber.inner_depth - radius
    return pairs + int((race | side).sum())


@pytest.mark.parametrize("law", ["restitution", "history"])
def test_equal_chambers_do_the_same_to_the_last_bit(law: str) -> None:
    group = {"count": len(places()), "density": 7800.0, "mass": 0.02, "positions": places()}
    chamber = {"radius": 0.05, "depth": 0.04, "balls": [group]}
    machine = ChamberMachine(
        name="twice", gravity=(0.0, 0.0, -9.81), body={"freedom": "fixed"},
        rotor={"mass": 3.0, "polar_inertia": 0.02, "transverse_inertia": 0.02, "bearings": (0.1, -0.1)},
        chambers=[chamber, chamber],
        contact={"law": law, "restitution": 0.6, "friction": 0.4, "rolling_arm": 1e-5, "stiffness": 1e8},
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 20.0}},
    )  # fmt: skip
    run = simulate_chamber(machine, duration=0.05)
    for name in ("ball_position", "ball_velocity", "ball_spin"):
        first, second = np.split(run[name].values, 2, axis=1)
        np.testing.assert_array_equal(first, second)
    touching = [contacts(found, machine) for found in run.ball_position.values.reshape(-1, 2, len(places()), 3)]
    assert max(touching) > BLOCK  # more at once than a block has places

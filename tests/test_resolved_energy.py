"""Energy and momentum of a rotor in whose race balls bounce, roll and meet."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references.resolved import Bodies, free, run

from autobalancer.machine import Machine

TIMES = np.linspace(0.0, 1.5, 301)
WAVES = {"harmonics": [{"order": 2, "amplitude": 2e-3, "angle": 0.4}, {"order": 7, "amplitude": 2e-4, "angle": 1.0}]}
SPLIT = {"partitions": {"count": 3, "angle": 0.8}}
FLUID = {"fluid": {"density": 900.0, "viscosity": 1e-5}}
PEAK = {"kind": "stribeck", "peak": 0.4, "peak_speed": 0.1}
RUBS: dict[str, Any] = {"restitution": 0.6, "sliding_friction": 0.2, "slip_speed": 0.02, "ball_friction": 0.3}


def bodies(machine: Machine, tolerance: float = 1e-11) -> Bodies:
    states, own, assembly = run(machine, TIMES, tolerance=tolerance)
    found = Bodies(machine, states, own, assembly)
    wall = np.array([ball.orbit_radius for ball in assembly.balls])
    assert (wall - np.abs(found.place)).max() > 5e-4  # balls leave their wall
    assert np.ptp(found.speed) > 0.1  # and the rotor feels them
    return found


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize(
    "race", [{}, FLUID, WAVES | SPLIT, WAVES | FLUID], ids=["dry", "fluid", "waves", "waves in fluid"]
)
def test_elastic_balls_without_friction_keep_the_energy(axis: str, race: dict[str, Any]) -> None:
    motion = bodies(free(axis=axis, race=race))
    energy = motion.energy()
    np.testing.assert_allclose(energy, energy[0], rtol=0.0, atol=1e-7 * energy[0])


@pytest.mark.parametrize("race", [{}, WAVES | SPLIT], ids=["round", "waves"])
def test_angular_momentum_survives_friction_and_impacts(race: dict[str, Any]) -> None:
    momentum = bodies(free(race=race, **RUBS)).angular_momentum()
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)


def test_momentum_survives_friction_and_impacts_where_no_support_pulls() -> None:
    machine = free(**RUBS)
    # the rotor drifts some centimeters: a support of 1e-9 N/m still takes 2e-9 of the momentum
    loose = machine.rotor.model_copy(update={"stiffness": 1e-9})
    machine = Machine(**{**{key: getattr(machine, key) for key in machine.model_fields_set}, "rotor": loose})
    momentum = bodies(machine).momentum()
    np.testing.assert_allclose(momentum, momentum[0], rtol=0.0, atol=1e-8 * abs(momentum[0]))


@pytest.mark.parametrize("shape", [{}, WAVES | SPLIT], ids=["round", "waves"])
@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
def test_friction_never_feeds_energy_in(axis: str, shape: dict[str, Any]) -> None:
    friction = {"rolling_resistance": 0.01, "adherence": 0.1}
    machine = free(axis=axis, race={"friction": friction, **shape}, rest_speed=0.05, friction_law=PEAK, **RUBS)
    energy = bodies(machine).energy()
    assert np.diff(energy).max() < 1e-9 * energy[0]
    assert energy[-1] < 0.97 * energy[0]

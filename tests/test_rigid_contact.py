"""Rigid contact of guided balls: what it keeps, what it loses, and what soft contact tends to."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.race_runs import states_from
from tests.references.standing_races import DIAMETER, ORBIT

from autobalancer.assembly.contact import meetings
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.machine import Machine

TOUCH = 2.0 * math.asin(0.5 * DIAMETER / ORBIT)
COUNT, MASS, STIFFNESS, INERTIA = 5, 1.0, 2e3, 0.01


@pytest.fixture(autouse=True)
def _rigid(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meetings, "RIGID", True)


def _free(restitution: float, **race: Any) -> Machine:
    """A rotor that nothing drives or brakes, on springs, with balls that nothing brakes."""
    balls = {
        "count": COUNT, "mass": 0.02, "diameter": DIAMETER, "start_angles": [0.0, 0.4, 1.1, 2.5, 4.0],
        "start_speeds": [9.0, -4.0, 2.0, -7.0, 3.0],
    }  # fmt: skip
    whole = {
        "orbit_radius": ORBIT, "drag": {"law": "beta", "beta": 0.0}, "contact": {"restitution": restitution},
        "balls": [balls], **race,
    }  # fmt: skip
    return Machine(
        name="free rotor",
        axis="vertical",
        rotor={"mass": MASS, "stiffness": STIFFNESS, "damping": 0.0, "inertia": INERTIA},
        balancers=[{"races": [whole]}],
        drive={"kind": "torque", "torque": 0.0},
        start={"speed": 30.0, "deflection": [1e-3, -2e-3], "velocity": [0.05, 0.02]},
    )


def _energy_and_momentum(assembly: Assembly, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Written anew from places and velocities; states are in axes at rest."""
    place, move = states[:, 0] + 1j * states[:, 1], states[:, 2] + 1j * states[:, 3]
    speed, n = states[:, 5], len(assembly.balls)
    energy = 0.5 * MASS * np.abs(move) ** 2 + 0.5 * INERTIA * speed**2 + 0.5 * STIFFNESS * np.abs(place) ** 2
    momentum = MASS * (np.conj(place) * move).imag + INERTIA * speed
    for k, ball in enumerate(assembly.balls):
        arm = ball.orbit_radius * np.exp(1j * (states[:, 4] + states[:, 6 + k]))
        velocity = move + 1j * (speed + states[:, 6 + n + k]) * arm
        spin = speed - ball.orbit_radius / ball.rolling_radius * states[:, 6 + n + k]
        energy += 0.5 * ball.mass * np.abs(velocity) ** 2 + 0.5 * ball.own_inertia * spin**2
        momentum += ball.mass * (np.conj(place + arm) * velocity).imag + ball.own_inertia * spin
    return energy, momentum


@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize("restitution", [1.0, 0.54, 0.0])
def test_a_free_rotor_keeps_its_angular_momentum_and_never_gains_energy(restitution: float, general: bool) -> None:
    assembly = assemble(_free(restitution), rotating=False, general=general)
    states = states_from(assembly, np.linspace(0.0, 1.0, 501), tolerance=1e-13)
    energy, momentum = _energy_and_momentum(assembly, states)
    np.testing.assert_allclose(momentum, momentum[0], rtol=2e-12)
    assert np.diff(energy).max() < 2e-12 * energy[0]
    if restitution == 1.0:
        np.testing.assert_allclose(energy, energy[0], rtol=2e-12)
    else:
        assert energy[-1] < 0.99 * energy[0]
    gaps = np.diff(np.column_stack([states[:, 6:11], states[:, 6] + 2.0 * math.pi]), axis=1)
    assert -1e-11 < gaps.min() - TOUCH < 5e-3

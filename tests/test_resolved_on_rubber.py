"""Balls resolved in contact on rotors whose rubber softens: energy with all that is lost, and the guided ball as the limit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references.resolved import contact, states_at
from tests.references.resolved_run_ups import GRIP, RIG, apart, run_up
from tests.references.rig_energy import RigEnergy
from tests.references.rubber import CHAIN, described

from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.files.examples import rig
from autobalancer.kernels import records as at
from autobalancer.kernels.system import X, Y
from autobalancer.machine import Machine

RACE = "balancers[1].races[1]."
RUBS = {
    "reduced_modulus": "5 MPa", "restitution": 0.5, "sliding_friction": 0.2, "slip_speed": "20 mm/s", "rest_speed": "20 mm/s",
    "start_gap": "0.3 mm", "floor_friction": 0.1,
}  # fmt: skip


def loose(speed: float) -> Machine:
    """The discoidal rig on softening bushings, free to spin; its balls fall onto the wall, bounce, slide and roll."""
    changes: dict[str, Any] = {
        RACE + "drag": {"law": "viscous", "damping": 1e-5},
        RACE + "friction": {"rolling_resistance": 0.01},
        RACE + "collisions": False,
        RACE + "resolved": RUBS,
        RACE + "balls[1].start_speeds": [9.0, -7.0],
        "drive": {"kind": "torque", "torque": 0.0},
        "start": {"speed": speed, "deflection": [2e-4, 1e-4], "velocity": [0.05, -0.08]},
    }
    machine = rig("discoidal_rig_rubber")
    for path, value in changes.items():
        machine = with_value_at(machine, path, value)
    return machine


@pytest.mark.parametrize(
    ("speed", "tolerance"), [pytest.param(0.0, 1e-13, marks=pytest.mark.slow), (60.0, 1e-11)]
)  # the spin has 2000 times the energy of the rest
def test_energy_is_kept_to_1e_9_if_all_that_rubber_and_balls_lose_is_counted(speed: float, tolerance: float) -> None:
    motion = RigEnergy(loose(speed))
    stored, lost = motion.run(np.linspace(0.0, 0.06, 4), tolerance)
    np.testing.assert_allclose(stored + lost, stored[0], rtol=1e-9)
    assert lost[-1] > 0.01  # J; without the spin there are 0.03 at the start
    assert np.diff(lost).min() > 0.0


def test_rubber_that_is_left_out_of_the_losses_is_missed_in_that_balance() -> None:
    motion = RigEnergy(loose(0.0))
    motion.rubber = [(rows, stiffness, 1e3 * amplitude) for rows, stiffness, amplitude in motion.rubber]  # never slides
    stored, lost = motion.run(np.linspace(0.0, 0.03, 2), 1e-7)
    assert stored[-1] + lost[-1] < 0.99 * stored[0]


def softening(rotor: dict[str, Any]) -> dict[str, Any]:
    """The rig of the run-ups with bushings that soften."""
    *others, bushing = rotor["joints"]
    kept = {key: value for key, value in bushing.items() if not key.startswith("shear")}
    amplitudes, stiffnesses = [0.1 * a for _, a in CHAIN], [5.0 * k for k, _ in CHAIN]
    rubber = {
        "stiffness": 8e4, "damping": 30.0, "friction": {"breakaway_amplitude": amplitudes, "stiffness": stiffnesses},
    }  # fmt: skip
    return {**rotor, "joints": [*others, {**kept, "shear_rubber": rubber}]}


@pytest.mark.slow
def test_stiff_balls_that_do_not_slip_run_up_like_guided_ones_on_softening_bushings() -> None:
    """As on rubber of one stiffness, the difference is that of the orbit and falls with 1/k of the wall."""
    rotor = softening(RIG)
    guided = run_up(rotor=rotor)
    soft, stiff = (
        apart(guided, run_up(contact(stiffness=k, slip_speed=0.01, **GRIP), rotor=rotor)) for k in (1e6, 1e7)
    )
    assert stiff == pytest.approx(0.1 * soft, rel=0.02)
    assert stiff < 2e-3
    assert apart(guided, run_up(rotor=RIG)) > 10.0 * stiff  # the rubber matters


def test_resolved_balls_move_alike_on_a_planar_rotor_and_on_bodies_with_the_same_rubber() -> None:
    mass, times = 12.27, np.linspace(0.0, 0.5, 41)
    body = {"mass": 0.5 * mass, "position": 0.0, "transverse_inertia": 0.2, "polar_inertia": 0.1}
    bodies = {
        "kind": "multibody",
        "bodies": [{**body, "name": "rotor", "rotating": True}, {**body, "name": "housing"}],
        "joints": [
            {"kind": "lock", "between": ["rotor", "housing"]},
            {"kind": "bushing", "between": ["housing", "ground"], "position": 0.0, "count": 3, "radius": 0.1,
             "shear_rubber": described(share=1.0 / 3.0), "axial_stiffness": 1e5},
        ],
    }  # fmt: skip
    rubs = contact(restitution=0.5, sliding_friction=0.2, slip_speed=0.02, start_gap=3e-4, stiffness=1e5)
    found = []
    for rotor in ({"mass": mass, "rubber": described()}, bodies):
        machine = run_up(rubs, rotor=rotor, station=0.0)
        machine = with_value_at(machine, "drive.profile", {"kind": "constant", "speed": 62.0})
        machine = with_value_at(machine, RACE + "balls[1].start_speeds", [6.0, -4.0])
        assembly = assemble(machine, rotating=True)
        states = states_at(assembly, times, 1e-11)
        own = 2 + 2 * assembly.places.shape[2] + 2 * len(assembly.balls)
        balls = states[:, own : own + at.BALL_STATES * len(assembly.balls)]
        found.append(np.column_stack([np.hypot(states[:, X], states[:, Y]), balls]))
    size = np.abs(found[0]).max(axis=0)
    assert np.ptp(found[0][:, 1:].reshape(-1, 2, at.BALL_STATES)[..., at.BALL_X], axis=0).min() > 0.01  # the balls run
    assert (np.abs(found[1] - found[0]).max(axis=0) <= 1e-6 * size).all()

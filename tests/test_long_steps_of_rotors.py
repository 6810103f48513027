"""Long steps of rotors that tilt or bend, and of real races: the motion of the explicit pair, in the amplitudes of the modes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from tests.references.spatial import Spatial, split
from tests.references.spatial_machines import tilting, turned

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.kernels.integrators.integrator_state import ACCEPTED
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.system import BALLS, THETA
from autobalancer.machine import Machine
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import Stepper, stepper_for

LONG, PAIR = "exponential_collocation", "dormand_prince_8"
RAMP = {"kind": "speed", "profile": {"kind": "table", "time": [0.0, 0.4, 1.0], "speed": [20.0, 300.0, 250.0]}}
TORQUE = {"kind": "torque", "torque": 3.0, "damping": 1e-3}


def states(machine: Machine, times: np.ndarray, method: str, tolerance: float) -> tuple[np.ndarray, Stepper]:
    """States by the general equations, in their own axes."""
    assembly, end = assemble(machine, general=True), float(times[-1])
    stepper = stepper_for(assembly, end, tolerance, method)
    record = record_for([SampleTimes(times)], [], assembly, end)
    assert stepper.advance(assembly.system, record, 10**8) == FINISHED
    return record.samples, stepper


def miss(found: np.ndarray, exact: np.ndarray, balls: int) -> float:
    """Greatest miss of the deflection over its peak, and of a ball angle over a turn."""
    place = np.abs(found[:, :2] - exact[:, :2]).max() / np.abs(exact[:, 0] + 1j * exact[:, 1]).max()
    angle = np.abs(found - exact)[:, BALLS : BALLS + balls].max(initial=0.0) / (2.0 * np.pi)
    return float(max(place, angle))


def real_race(**race: Any) -> Machine:
    """A planar rotor run up through 63 rad/s; its balls roll with resistance in an oval race, against drag that is not linear."""
    real = {
        "collisions": False,
        "orbit_radius": 0.077,
        "width": 0.014,
        "height": 0.014,
        "fluid": {"name": "silicone oil 20"},
        "drag": {"law": "sphere_on_plane", "range": "whole"},
        "friction": {"rolling_resistance": 1e-3},
        "harmonics": [{"order": 2, "amplitude": 2e-5, "angle": 0.5}],
        "balls": [{"count": 2, "diameter": 0.0123, "material": "steel", "start_angles": [0.7, 4.4]}],
    }
    return Machine(
        name="real race",
        axis="vertical",
        rotor={"mass": 12.0, "stiffness": 4.8e4, "damping": 60.0},
        unbalances=[{"moment": 6e-4}],
        balancers=[{"races": [real | race]}],
        drive={"kind": "speed", "profile": {"kind": "ramp", "start": 20.0, "end": 120.0, "duration": 3.0}},
    )


SHAKEN = [
    {"kind": "base_motion", "displacement": 2e-5, "frequency": 90.0, "phase": 0.3},
    {"kind": "force", "force": 2.0, "order": 2.0, "direction": 0.8},
]


def hard(law: dict[str, Any]) -> Machine:
    """A rotor on equal springs whose bearings become stiffer, one of them by a law of its own."""
    own = {"distance": [0.0, 2e-4, 5e-4, 1e-3], "force": [0.0, 1.0, 6.0, 20.0]}
    machine = with_value_at(tilting(isotropic=True, drive=RAMP), "rotor.supports[1].hardening", law)
    return with_value_at(machine, "rotor.supports[2].hardening", own)


MACHINES: dict[str, tuple[Machine, float]] = {
    "spins freely, equal springs": (tilting(isotropic=True), 1.0),
    "spins freely, lies on unequal springs": (tilting(axis="horizontal"), 1.0),
    "races that tilt, driven by a torque": (tilting(isotropic=True, tilting_races="full", drive=TORQUE), 0.6),
    "ramps with corners, equal springs": (tilting(isotropic=True, drive=RAMP), 1.0),
    "ramps with corners, unequal springs": (tilting(drive=RAMP), 1.0),
    "a shaft that hangs": (rig("cfrp_rig"), 3.0),
    "real races": (real_race(), 3.0),
    "shaken from outside, driven by a torque": (tilting(isotropic=True, drive=TORQUE, excitations=SHAKEN), 0.6),
    "bearings that become stiffer": (hard({"cubic_stiffness": 1e10, "center": [1e-5, 3e-5]}), 1.0),
}


@pytest.mark.parametrize("name", MACHINES)
def test_long_steps_are_as_accurate_as_the_pair_at_the_same_tolerance(name: str) -> None:
    """Against a run of the pair at 1e-13. Where stability limits the pair it is better than its tolerance."""
    machine, end = MACHINES[name]
    times, balls = np.linspace(0.0, end, 97), len(assemble(machine).balls)
    exact, _ = states(machine, times, PAIR, 1e-13)
    for tolerance in (1e-6, 1e-9):
        pair, one = states(machine, times, PAIR, tolerance)
        long, other = states(machine, times, LONG, tolerance)
        assert miss(long, exact, balls) < max(4.0 * miss(pair, exact, balls), 3.0 * tolerance), tolerance
        assert other.memory.counts[ACCEPTED] < one.memory.counts[ACCEPTED]


def test_a_shaft_takes_a_hundredth_of_the_steps() -> None:
    """Its fastest mode turns at 5758 rad/s and limits the pair, while it does nothing."""
    times = np.linspace(0.0, 20.0, 11)
    _, pair = states(rig("cfrp_rig"), times, PAIR, 1e-8)
    _, long = states(rig("cfrp_rig"), times, LONG, 1e-8)
    assert long.memory.counts[ACCEPTED] < 0.01 * pair.memory.counts[ACCEPTED]
    assert long.attributes()["long_steps"] == long.memory.counts[ACCEPTED]


@pytest.mark.parametrize("isotropic", [True, False])
@pytest.mark.parametrize("races", ["deflection", "full"])
def test_long_steps_keep_the_energy_of_a_rotor_that_spins_freely(races: str, isotropic: bool) -> None:
    axis = "vertical" if isotropic else "horizontal"
    machine = tilting(isotropic=isotropic, damping=0.0, beta=0.0, axis=axis, tilting_races=races)
    times, reference = np.linspace(0.0, 2.0, 21), Spatial(machine)
    found, stepper = states(machine, times, LONG, 1e-11)
    at_rest = turned(found, 4) if isotropic else found
    moved = split(machine, at_rest)
    energy = np.array([reference.energy(t, q, v) for t, (q, v) in zip(times, moved, strict=True)])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    assert stepper.attributes()["long_steps"] > 0.5 * stepper.memory.counts[ACCEPTED]


@pytest.mark.parametrize("isotropic", [True, False])
def test_the_free_whirl_of_a_gyroscopic_rotor_is_the_matrix_exponential(isotropic: bool) -> None:
    """Without balls and unbalance, at a constant speed, all is linear; a step is longer than the whirl."""
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 437.0}}
    machine = tilting(isotropic=isotropic, balancers=[], unbalances=[], stations=[], drive=drive)
    assembly, times = assemble(machine, general=True), np.linspace(0.0, 1.0, 23)
    h = assembly.system.host
    damping, stiffness, gyroscopic = (m[:4, :4].T for m in (h.damping[0], h.stiffness[0], h.gyroscopic))
    whole = np.block([[np.zeros((4, 4)), np.eye(4)], [-stiffness, -damping - 437.0 * gyroscopic]])
    found, stepper = states(machine, times, LONG, 1e-9)
    found = turned(found, 0) if isotropic else found
    start = turned(assembly.state[None], 0)[0] if isotropic else assembly.state
    order = [0, 1, BALLS, BALLS + 1, 2, 3, BALLS + 2, BALLS + 3]
    exact = np.array([expm(whole * t) @ start[order] for t in times])
    scale = np.abs(exact).max(axis=0)
    assert (np.abs(found[:, order] - exact) / scale).max() < 1e-8
    assert stepper.memory.counts[ACCEPTED] < 12
    assert found[-1, THETA] == pytest.approx(437.0 + float(machine.start.rotor_angle), rel=1e-12)


RECORD = {"kind": "recorded_base_motion", "time": [0.0, 0.01, 0.02], "acceleration": [0.0, 1.0, 0.0]}


@pytest.mark.parametrize(
    ("machine", "words"),
    [
        (tilting(drive=RAMP, excitations=[RECORD]), "recorded excitations"),
        (tilting(drive=RAMP, damping=9e4), "without vibrating"),
        (hard({"clearance": 1e-4, "contact_stiffness": 2e4}), "a stop of a bearing"),
    ],
)
def test_rotors_without_long_steps_are_refused_by_name_and_run_with_the_pair(machine: Machine, words: str) -> None:
    with pytest.raises(QuestionError, match=words):
        ab.simulate(machine, duration=0.01, method=LONG)
    assert ab.simulate(machine, duration=0.01).attrs["method"] == PAIR


def test_a_ball_that_stops_and_breaks_loose_does_so_at_the_same_instant() -> None:
    """Adherence holds the balls at first; the pair makes the change, and long steps go on."""
    machine = real_race(friction={"rolling_resistance": 1e-3, "adherence": 2e-3})
    times = np.linspace(0.0, 3.0, 97)
    exact, _ = states(machine, times, PAIR, 1e-12)
    found, stepper = states(machine, times, LONG, 1e-9)
    held = (exact[:, BALLS + 2 : BALLS + 4] == 0.0).any(axis=1)
    assert held.any()
    assert not held.all()
    assert miss(found, exact, 2) < 1e-6
    assert 0 < stepper.attributes()["long_steps"] < stepper.memory.counts[ACCEPTED]


def test_balls_strike_and_touch_inside_long_steps() -> None:
    """In the first resonance the balls of both planes gather and touch for seconds; no step is the pair's."""
    profile = {"kind": "ramp", "start": 0.0, "end": "4000 rpm", "duration": "60 s"}
    machine = with_value_at(ab.load_machine("examples/machines/two_plane_rotor.toml"), "drive.profile", profile)
    times = np.linspace(0.0, 18.0, 181)
    exact, pair = states(machine, times, PAIR, 1e-12)
    found, stepper = states(machine, times, LONG, 1e-9)
    rates = exact[:, BALLS + 4 : BALLS + 8]
    together = (rates[:, 2] == rates[:, 3]) & (rates[:, 2] != 0.0)
    assert together.sum() > 20
    assert miss(found, exact, 4) < 1e-6
    assert stepper.attributes()["long_steps"] == stepper.memory.counts[ACCEPTED]
    assert stepper.memory.counts[ACCEPTED] < 0.5 * pair.memory.counts[ACCEPTED]


def striking(restitution: float) -> Machine:
    """A rotor that spins freely on equal springs, whose balls nothing brakes and who strike each other on races that tilt."""
    machine = tilting(isotropic=True, damping=0.0, beta=0.0, tilting_races="full")
    for balancer in (1, 2):
        race = f"balancers[{balancer}].races[1]."
        machine = with_value_at(machine, race + "collisions", True)
        machine = with_value_at(machine, race + "contact", {"restitution": restitution})
    return machine


@pytest.mark.parametrize("restitution", [1.0, 0.6])
def test_balls_on_races_that_tilt_strike_without_gaining_energy(restitution: float) -> None:
    """By an energy that is written apart, with the pair and in long steps; elastic impacts keep it."""
    machine, times = striking(restitution), np.linspace(0.0, 1.0, 101)
    reference = Spatial(machine)
    exact, _ = states(machine, times, PAIR, 1e-12)
    found, stepper = states(machine, times, LONG, 1e-10)
    energy = [
        np.array([reference.energy(t, q, v) for t, (q, v) in zip(times, split(machine, turned(one, 4)), strict=True)])
        for one in (exact, found)
    ]
    for one in energy:
        assert np.diff(one).max() < 1e-9 * one[0]
        if restitution == 1.0:
            np.testing.assert_allclose(one, one[0], rtol=1e-9)
        else:
            assert one[-1] < (1.0 - 1e-4) * one[0]
    assert miss(found, exact, 4) < 1e-7
    assert stepper.attributes()["long_steps"] > 0.5 * stepper.memory.counts[ACCEPTED]

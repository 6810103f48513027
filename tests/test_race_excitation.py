"""Shaken bases and forces from outside: closed forms, order, superposition, records."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.references.motion import Motion, motion
from tests.references.race_runs import states_of
from tests.references.standing_races import GRAVITY, ORBIT, ROLLING, standing

from autobalancer.assembly.rotors import lateral_model, station_rows
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.machine import BaseMotion, Machine, RecordedBaseMotion

MASS, STIFFNESS, DAMPING = 5.0, (2e4, 3e4), (20.0, 40.0)
TIMES = np.linspace(0.0, 2.0, 201)


def rotor(*excitations: dict[str, Any], speed: float = 0.0, start: complex = 0j, velocity: complex = 0j) -> Machine:
    return Machine(
        name="shaken",
        axis="vertical",
        rotor={"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING},
        excitations=excitations,
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
        start={"deflection": (start.real, start.imag), "velocity": (velocity.real, velocity.imag)},
    )


def amplitudes(force: complex, direction: float, frequency: float) -> np.ndarray:
    """Complex amplitudes along x and y under a harmonic force."""
    along = force * np.array([math.cos(direction), math.sin(direction)])
    stiff = np.array(STIFFNESS) - MASS * frequency**2 + 1j * frequency * np.array(DAMPING)
    return along / stiff


def assert_steady(shake: dict[str, Any], z: np.ndarray, frequency: float) -> None:
    """A rotor that starts on its steady motion stays on it."""
    moving = 1j * frequency * z
    machine = rotor(shake, start=complex(*z.real), velocity=complex(*moving.real))
    found = motion(machine, states_of(machine, TIMES)).deflection
    expected = (z[None, :] * np.exp(1j * frequency * TIMES)[:, None]).real
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(z).max())


def moved(*excitations: dict[str, Any], **more: Any) -> Motion:
    machine = rotor(*excitations, **more)
    return motion(machine, states_of(machine, TIMES))


def test_a_shaken_base_moves_the_rotor_as_its_transfer_function_says() -> None:
    frequency, phase, direction = 70.0, 0.6, 0.9
    shake = {"kind": "base_motion", "acceleration": 3.0, "frequency": frequency, "phase": phase, "direction": direction}
    assert_steady(shake, amplitudes(-MASS * 3.0 * np.exp(1j * phase), direction, frequency), frequency)


def test_a_displacement_of_the_base_is_its_acceleration_over_minus_the_squared_frequency() -> None:
    frequency, direction = 55.0, -0.4
    shake = {"kind": "base_motion", "displacement": 1e-3, "frequency": frequency, "direction": direction}
    assert_steady(shake, amplitudes(MASS * 1e-3 * frequency**2, direction, frequency), frequency)


def test_a_harmonic_force_moves_the_rotor_by_its_receptance() -> None:
    frequency, phase, direction = 80.0, -1.1, 2.0
    shake = {"kind": "force", "force": 4.0, "frequency": frequency, "phase": phase, "direction": direction}
    assert_steady(shake, amplitudes(4.0 * np.exp(1j * phase), direction, frequency), frequency)


def test_a_force_at_a_station_moves_other_stations_by_the_receptance_between_them() -> None:
    frequency = 90.0
    machine = Machine(
        name="rigid",
        axis="vertical",
        rotor={
            "kind": "rigid",
            "mass": 6.0,
            "transverse_inertia": 0.05,
            "polar_inertia": 0.02,
            "supports": [
                {"position": -0.1, "stiffness": [2e4, 3e4], "damping": 60.0},
                {"position": 0.15, "stiffness": [4e4, 3e4], "damping": 60.0},
            ],
        },
        stations=[{"name": "here", "position": 0.12}, {"name": "there", "position": -0.2}],
        excitations=[{"kind": "force", "station": "here", "force": 5.0, "frequency": frequency, "direction": 0.7}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 200.0}},
    )
    model = lateral_model(machine)
    rows = station_rows(machine, model)
    here, there = (model.both(rows[name].deflection[None]) for name in ("here", "there"))
    damping = model.damping_at(200.0) + 200.0 * model.gyroscopic
    dynamic = model.stiffness_at(200.0) - frequency**2 * model.mass + 1j * frequency * damping
    force = 5.0 * np.array([math.cos(0.7), math.sin(0.7)])
    expected = there @ np.linalg.solve(dynamic, here.T @ force)
    times = 6.0 + np.linspace(0.0, 2.0 * math.pi / frequency, 16, endpoint=False)
    assembly = assemble(machine, rotating=False)
    found = states_of(machine, np.array([0.0, *times]), tolerance=1e-11)[1:]
    r = np.column_stack([found[:, :2], found[:, 6:8]])
    seen = r @ assembly.stations["there"].T
    amplitude = 2.0 / 16 * (seen * np.exp(-1j * frequency * times)[:, None]).sum(axis=0)
    np.testing.assert_allclose(amplitude, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def test_an_excitation_of_first_order_keeps_pace_with_the_rotor() -> None:
    base = {"kind": "force", "force": 4.0, "direction": 0.3, "phase": 0.2}
    found = moved({**base, "order": 2.0}, speed=30.0).deflection
    same = moved({**base, "frequency": 60.0}, speed=30.0).deflection
    np.testing.assert_allclose(found, same, rtol=0.0, atol=1e-10 * np.abs(same).max())
    assert np.abs(found).max() > 1e-5


def test_answers_to_two_excitations_add_up() -> None:
    one = {"kind": "force", "force": 4.0, "frequency": 61.0, "direction": 0.3}
    two = {"kind": "base_motion", "acceleration": 2.0, "frequency": 33.0, "direction": -1.0}
    both, first, second = moved(one, two), moved(one), moved(two)
    for kind in ("deflection", "velocity"):
        whole = getattr(both, kind)
        size = np.abs(whole).max(axis=0)
        np.testing.assert_allclose(
            whole / size, (getattr(first, kind) + getattr(second, kind)) / size, atol=1e-9, rtol=0.0
        )


@pytest.mark.parametrize("kind", ["base_motion", "force"])
def test_a_record_of_a_harmonic_acts_as_the_harmonic(kind: str) -> None:
    amount = "acceleration" if kind == "base_motion" else "force"
    times = np.linspace(0.0, 3.0, 6001)
    record = 3.0 * np.cos(40.0 * times + 0.5)
    recorded = {"kind": f"recorded_{kind}", "time": times.tolist(), amount: record.tolist(), "direction": 0.8}
    harmonic = {"kind": kind, amount: 3.0, "frequency": 40.0, "phase": 0.5, "direction": 0.8}
    found, expected = moved(recorded).deflection, moved(harmonic).deflection
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-5 * np.abs(expected).max())


def test_a_record_is_silent_outside_its_times() -> None:
    record = {"kind": "recorded_force", "time": [0.5, 0.6, 0.7], "force": [0.0, 5.0, 5.0]}
    found, late = moved(record), TIMES > 0.85
    assert np.all(np.abs(found.deflection[TIMES <= 0.5]) < 1e-15)
    assert np.all(np.abs(found.velocity[TIMES <= 0.5]) < 1e-15)
    energy = 0.5 * (MASS * found.velocity[late] ** 2 + np.array(STIFFNESS) * found.deflection[late] ** 2).sum(axis=1)
    assert np.all(np.diff(energy) < 0.0)
    assert energy[0] > 1e-6


def test_a_ball_in_a_shaken_race_is_a_pendulum_whose_support_moves() -> None:
    amplitude, frequency, direction = 6.0, 9.0, 0.5
    shake = {"kind": "base_motion", "acceleration": amplitude, "frequency": frequency, "direction": direction}
    machine = standing(angles=[0.4], excitations=[shake], firm=True)
    found = motion(machine, states_of(machine, np.linspace(0.0, 3.0, 61))).angles[:, 0]

    def pendulum(time: float, y: np.ndarray) -> list[float]:
        felt = -amplitude * math.cos(frequency * time) * np.array([math.cos(direction), math.sin(direction)])
        felt[1] -= GRAVITY
        along = np.array([math.cos(y[0]), math.sin(y[0])])  # tangent at the angle from the bottom
        return [y[1], float(felt @ along) / (ROLLING * ORBIT)]

    path = solve_ivp(
        pendulum, (0.0, 3.0), [0.4, 0.0], t_eval=np.linspace(0.0, 3.0, 61), method="DOP853", rtol=1e-11, atol=1e-12
    )
    np.testing.assert_allclose(found + 0.5 * math.pi, path.y[0], rtol=0.0, atol=2e-5)


def test_a_base_that_shakes_as_weight_pulls_is_weight() -> None:
    """A constant record of g upwards on a vertical axis is a horizontal axis at rest."""
    record = {
        "kind": "recorded_base_motion",
        "time": [0.0, 1.0, 2.0, 3.0],
        "acceleration": [GRAVITY] * 4,
        "direction": 0.5 * math.pi,
    }
    times = np.linspace(0.0, 2.0, 41)
    cases = (
        standing(axis="vertical", angles=[1.0], excitations=[record], firm=True),
        standing(angles=[1.0], friction={}),
    )
    shaken, heavy = (motion(machine, states_of(machine, times)) for machine in cases)
    np.testing.assert_allclose(shaken.angles, heavy.angles, rtol=0.0, atol=2e-5)
    np.testing.assert_allclose(shaken.speeds, heavy.speeds, rtol=0.0, atol=2e-5)


def test_excitations_that_say_too_little_or_too_much_are_refused() -> None:
    with pytest.raises(MachineError, match="either 'acceleration' or 'displacement'"):
        BaseMotion(frequency=10.0)
    with pytest.raises(MachineError, match="either 'frequency', or 'order'"):
        BaseMotion(acceleration=1.0)
    with pytest.raises(MachineError, match="needs a fixed 'frequency'"):
        BaseMotion(displacement=1e-3, order=1.0)
    with pytest.raises(MachineError, match="must increase"):
        RecordedBaseMotion(time=[0.0, 1.0, 1.0], acceleration=[0.0, 1.0, 0.0])
    with pytest.raises(MachineError, match="2 values at 3 times"):
        RecordedBaseMotion(time=[0.0, 1.0, 2.0], acceleration=[0.0, 1.0])
    with pytest.raises(MachineError, match="no station is named 'nowhere'"):
        rotor({"kind": "force", "station": "nowhere", "force": 1.0, "frequency": 3.0})

"""What the motion must keep, lose and balance: energy and angular momentum."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from tests.references import lagrange
from tests.references.motion import motion
from tests.references.runs import run_to, states_at

from autobalancer.machine import Machine

REVOLUTIONS = 1000
SPEED = 300.0  # rad/s, above the critical speed of about 240


def machine(
    *, axis: str = "vertical", isotropic: bool = True, damping: float = 0.0, beta: float = 0.0, **top: Any
) -> Machine:
    """Two races, one of them off center, with unequal rolling balls, a fluid around some; nothing drives."""
    drag = {"law": "viscous", "damping": beta}
    data: dict[str, Any] = {
        "name": "free",
        "axis": axis,
        "rotor": {
            "mass": 10.0,
            "stiffness": 6e5 if isotropic else [6e5, 8e5],
            "damping": damping if isotropic else [damping, 1.5 * damping],
            "inertia": 0.05,
        },
        "unbalances": [{"moment": 6e-4, "angle": 0.4}],
        "balancers": [
            {
                "races": [
                    {
                        "collisions": False,
                        "race_radius": 0.1,
                        "eccentricity": 1e-3,
                        "eccentricity_angle": 0.7,
                        "drag": drag,
                        "balls": [
                            {"diameter": 0.012, "density": 7800.0, "start_angles": 1.0},
                            {"diameter": 0.008, "density": 7800.0, "start_angles": 3.5, "start_speeds": -40.0},
                        ],
                    },
                    {
                        "collisions": False,
                        "orbit_radius": 0.08,
                        "fluid": {"density": 900.0, "viscosity": 1e-5},
                        "drag": drag,
                        "balls": [{"diameter": 0.01, "density": 7800.0, "motion": "point", "start_angles": -1.0}],
                    },
                ]
            }
        ],
        "drive": {"kind": "torque", "torque": 0.0},
        "start": {"speed": SPEED, "deflection": [2e-4, -1e-4], "velocity": [0.03, 0.05]},
    }
    return Machine(**(data | top))


def energies(reference: lagrange.Planar, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    return np.array([reference.energy(t, *reference.split(y)) for t, y in zip(times, states, strict=True)])


TIMES = np.linspace(0.0, REVOLUTIONS * 2.0 * np.pi / SPEED, 400)


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize("isotropic", [True, False])
def test_energy_is_kept_over_a_thousand_revolutions_when_nothing_dissipates(axis: str, isotropic: bool) -> None:
    case = machine(axis=axis, isotropic=isotropic)
    states = states_at(case, TIMES)
    moved = motion(case, states)
    assert moved.rotor_angle[-1] > 0.9 * 2.0 * np.pi * REVOLUTIONS
    assert np.ptp(moved.angles, axis=0).min() > 10.0  # the balls really run
    energy = energies(lagrange.planar(case), TIMES, states)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_energy_that_moves_between_host_and_balls_is_kept_to_a_billionth_of_the_part_that_moves() -> None:
    """The spin of the rotor holds most of the energy and would hide errors; here it stands still at first."""
    case = machine(start={"speed": 0.0, "deflection": [5e-4, 0.0], "velocity": [0.0, 0.1]})
    times = np.linspace(0.0, 20.0, 200)
    energy = energies(lagrange.planar(case), times, states_at(case, times))
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_angular_momentum_about_the_shaft_is_kept_if_all_is_isotropic_and_free() -> None:
    case = machine()
    reference = lagrange.planar(case)
    states = states_at(case, TIMES)
    momentum = [reference.angular_momentum(t, *reference.split(y)) for t, y in zip(TIMES, states, strict=True)]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-10)


def test_angular_momentum_is_not_kept_on_unequal_supports() -> None:
    case = machine(isotropic=False)
    reference = lagrange.planar(case)
    states = states_at(case, TIMES[:100])
    momentum = [reference.angular_momentum(t, *reference.split(y)) for t, y in zip(TIMES[:100], states, strict=True)]
    assert np.ptp(momentum) > 1e-6 * abs(momentum[0])


@pytest.mark.parametrize(("damping", "beta"), [(50.0, 0.0), (0.0, 2e-4), (50.0, 2e-4)])
def test_damping_lets_the_energy_only_fall(damping: float, beta: float) -> None:
    case = machine(damping=damping, beta=beta)
    times = np.linspace(0.0, 3.0, 3000)
    energy = energies(lagrange.planar(case), times, states_at(case, times))
    assert np.diff(energy).max() < 1e-12 * energy[0]
    assert energy[-1] < energy[0] - 1e-3


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize("isotropic", [True, False])
def test_energy_gained_is_torque_work_less_dissipation(axis: str, isotropic: bool) -> None:
    """Integrated over time with the states at Gauss points, d(energy) = (torque - damping w) w dt - dissipation dt."""
    drive = {"kind": "torque", "torque": 0.8, "damping": 2e-3}
    case = machine(axis=axis, isotropic=isotropic, damping=80.0, beta=3e-4, drive=drive)
    reference = lagrange.planar(case)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    edges = np.linspace(0.0, 2.0, 401)
    half = 0.5 * np.diff(edges)
    inner = edges[:-1, None] + half[:, None] * (1.0 + nodes)
    times = np.concatenate([[0.0], inner.ravel(), [edges[-1]]])
    states = states_at(case, times)
    energy = energies(reference, times[[0, -1]], states[[0, -1]])
    power = []
    for t, y in zip(times[1:-1], states[1:-1], strict=True):
        velocity = reference.split(y)[1]
        power.append(reference.torque(t, velocity[2]) * velocity[2] - reference.dissipation(velocity))
    work = float(np.sum(half[:, None] * weights * np.reshape(power, inner.shape)))
    assert abs(energy[1] - energy[0]) > 1.0
    assert energy[1] - energy[0] == pytest.approx(work, rel=1e-9)


def test_a_prescribed_speed_puts_in_the_work_of_its_torque() -> None:
    """The torque on the shaft follows from the rotor's row of the full equations."""
    profile = {"kind": "ramp", "start": 100.0, "end": 300.0, "duration": 2.0}
    case = machine(damping=80.0, beta=3e-4, drive={"kind": "speed", "profile": profile}, start={})
    reference = lagrange.planar(case)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    edges = np.linspace(0.0, 2.0, 401)
    half = 0.5 * np.diff(edges)
    times = np.concatenate([[0.0], (edges[:-1, None] + half[:, None] * (1.0 + nodes)).ravel(), [2.0]])
    states = states_at(case, times)
    energy = energies(reference, times[[0, -1]], states[[0, -1]])
    power = []
    for t, y in zip(times[1:-1], states[1:-1], strict=True):
        q, v = reference.split(y)
        row = reference.mass_matrix(t, q)[2] @ reference.accelerations(t, q, v) - reference.forces(t, q, v)[2]
        power.append(row * v[2] - reference.dissipation(v))
    work = float(np.sum(half[:, None] * weights * np.reshape(power, (400, 10))))
    assert energy[1] - energy[0] == pytest.approx(work, rel=1e-9)


def test_a_free_pendulum_of_one_ball_has_the_period_of_the_elliptic_integral() -> None:
    """A ball in a race that stands still under gravity; the host is too heavy to move."""
    case = Machine(
        name="pendulum",
        axis="horizontal",
        gravity=9.81,
        rotor={"mass": 1e9, "stiffness": 1e15, "damping": 0.0},
        balancers=[
            {
                "races": [
                    {
                        "orbit_radius": 0.1,
                        "drag": {"law": "viscous", "damping": 0.0},
                        "balls": [{"diameter": 0.01, "mass": 4e-3, "start_angles": [-np.pi / 2 + 2.0]}],
                    }
                ]
            }
        ],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
    )
    # half swing: phi'^2 = 2 g/(1.4 eps) (cos a - cos 2)
    rate = 2.0 * 9.81 / (1.4 * 0.1)
    half, _ = quad(
        lambda s: 2.0 * s / np.sqrt(rate * (np.cos(2.0 - s * s) - np.cos(2.0))), 0.0, np.sqrt(2.0), epsabs=1e-13
    )
    period = 4.0 * half
    states, memory = run_to(case, [0.25 * period, 0.5 * period, period])
    np.testing.assert_allclose(motion(case, states).angles[:, 0] + np.pi / 2, [0.0, -2.0, 2.0], atol=1e-9)
    assert memory.counts[0] > 10

"""The balancers of a machine as an element of a rotor that something else moves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.references.shafts import shaft
from tests.references.spatial_machines import tilting

import autobalancer as ab
from autobalancer.assembly.rotors import balancer_rows, lateral_model, unbalance_load
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.simulation.balancer_element import BalancerElement

SPEED = 150.0  # rad/s
GRAVITY = 9.80665
SOFT = {"density": 1200.0, "youngs_modulus": 3e8, "poisson_ratio": 0.4}  # no fast modes, which cost steps


def races(*given: dict[str, Any]) -> list[dict[str, Any]]:
    """Races with point-like balls of 30 g and 20 mm that pass through each other, unless ``given`` says more."""
    ball = {"mass": 0.03, "diameter": 0.02, "motion": "point"}
    drag = {"law": "viscous", "damping": 2e-4}
    return [
        {"drag": drag, "collisions": False}
        | {name: value for name, value in one.items() if name != "angles"}
        | {"balls": [{"count": len(one["angles"]), "start_angles": one["angles"]} | ball]}
        for one in given
    ]


def planar(drive: dict[str, Any], *given: dict[str, Any], **more: Any) -> Machine:
    rotor = {"mass": 5.0, "stiffness": [4e4, 6e4], "damping": 120.0, "inertia": 0.05}
    unbalances = [{"moment": 1.5e-3, "angle": 0.4}]
    data = {
        "name": "planar",
        "axis": "horizontal",
        "rotor": rotor,
        "unbalances": unbalances,
        "balancers": [{"races": races(*given)}],
        "drive": drive,
    }
    return Machine.model_validate(data | more)


TOUCHING = {
    "orbit_radius": 0.08,
    "angles": (1.0, 1.3, 4.0),
    "collisions": True,
    "contact": {"restitution": 0.5, "stiffness": 2e4},
    "eccentricity": 1e-4,
}
TWO = {"orbit_radius": 0.06, "angles": (0.5, 3.0)}
STEADY = {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}}


def motion(element: BalancerElement, seed: int = 1) -> tuple[Any, ...]:
    """A motion of everything, with accelerations."""
    random, size, count = np.random.default_rng(seed), len(element.rows), element.state.size // 2
    shaft_motion = random.uniform(-1.0, 1.0, 2 * size) * np.repeat([1e-3, 0.3], size)
    balls = np.concatenate([random.uniform(-3.0, 3.0, count), random.uniform(-30.0, 30.0, count)])
    return 0.0, shaft_motion, np.array([0.7, SPEED]), balls, random.uniform(-50.0, 50.0, size + 1)


def test_forces_are_the_change_of_momentum_of_the_balls() -> None:
    """Newton's law for every ball, whatever the accelerations, and the moment of it about the center of the race."""
    machine = planar(STEADY, TOUCHING, TWO)
    element = ab.balancer_element(machine)
    time, shaft_motion, (angle, speed), balls, given = motion(element)
    balls[:3] = 1.0, 1.2, 4.0  # the first two press on each other
    force, rates = element.rates(time, shaft_motion, np.array([angle, speed]), balls, given)
    count = balls.size // 2
    mass = element.system.balls.mass
    radius, center = np.array([0.08] * 3 + [0.06] * 2), np.array([1e-4] * 3 + [0.0] * 2)
    turn = np.exp(1j * angle)
    along = radius * np.exp(1j * balls[:count])
    place, moved = turn * (center + along), turn * 1j * along
    rate, acceleration = balls[count:], rates[count:]
    second = complex(*given[:2]) + 1j * given[2] * place - speed**2 * place
    second += moved * acceleration + 2j * speed * moved * rate - turn * along * rate**2
    needed = mass * (second + 1j * GRAVITY)
    np.testing.assert_allclose(complex(*force[:2]), -needed.sum(), rtol=1e-12)
    np.testing.assert_allclose(force[2], -(np.conj(place) * needed).imag.sum(), rtol=1e-12)
    # along its path each ball feels its drag, and the torque of the contact, which is as great on both that touch
    torque = (np.conj(along * turn) * needed).imag + 2e-4 * rate
    np.testing.assert_allclose([torque[0] + torque[1], *torque[2:]], 0.0, atol=1e-12 * np.abs(needed).max())


def test_the_power_of_the_forces_is_what_the_balls_gain_and_lose() -> None:
    machine = planar(STEADY, TWO)
    element = ab.balancer_element(machine)
    time, shaft_motion, (angle, speed), balls, given = motion(element)
    mass = element.system.balls.mass

    def energy(after: float) -> float:
        """Kinetic and potential energy of the balls a little later."""
        x, v = shaft_motion[:2] + after * shaft_motion[2:], shaft_motion[2:] + after * given[:2]
        theta, w = angle + after * speed + 0.5 * after**2 * given[2], speed + after * given[2]
        rate = balls[2:] + after * rates[2:]
        along = 0.06 * np.exp(1j * (theta + balls[:2] + after * balls[2:] + 0.5 * after**2 * rates[2:]))
        velocity = complex(*v) + 1j * along * (w + rate)
        return float((0.5 * mass * np.abs(velocity) ** 2 + mass * GRAVITY * (x[1] + along.imag)).sum())

    force, rates = element.rates(time, shaft_motion, np.array([angle, speed]), balls, given)
    gained = (energy(1e-6) - energy(-1e-6)) / 2e-6
    lost = 2e-4 * (balls[2:] ** 2).sum()
    given_power = -force[:2] @ shaft_motion[2:] - force[2] * speed
    assert given_power == pytest.approx(gained + lost, rel=1e-7)


def test_its_mass_is_symmetric_also_where_races_tilt() -> None:
    element = ab.balancer_element(tilting(tilting_races="full"))
    assert element.rows[:4] == ("x at lower", "y at lower", "dx/dz at lower", "dy/dz at lower")
    mass = element.forms(*motion(element)[:4]).mass
    np.testing.assert_allclose(mass, mass.T, rtol=0.0, atol=1e-15)


def moved_by_scipy(machine: Machine, times: np.ndarray, torque: float) -> tuple[np.ndarray, np.ndarray]:
    """Deflections at the first plane, x + i y, and ball angles: the rotor's own matrices with the element, by DOP853."""
    element, model = ab.balancer_element(machine), lateral_model(machine)
    slopes = len(element.rows) == 4 * len(machine.balancers)
    planes = balancer_rows(machine, model)
    rows = np.vstack([model.both(row[None]) for r in planes for row in (r.deflection, r.slope)[: 1 + slopes]])
    load = unbalance_load(machine, model)
    load = np.concatenate([load, -1j * load])
    size, free = model.size, bool(torque)  # whether a torque drives the rotor, else its speed is given
    bare, damping, stiffness = np.pad(np.linalg.inv(model.mass), (0, 1)), model.damping_at(0.0), model.stiffness_at(0.0)
    wide = np.zeros((len(rows) + 1, size + 1))
    wide[:-1, :-1], wide[-1, -1] = rows, 1.0

    def rates(time: float, y: np.ndarray) -> np.ndarray:
        q, v, (angle, speed), balls = y[:size], y[size : 2 * size], y[2 * size : 2 * size + 2], y[2 * size + 2 :]
        turned, inverse = load * np.exp(1j * angle), bare
        if free:
            mass = np.pad(model.mass, (0, 1))
            mass[-1, :-1] = mass[:-1, -1] = (1j * turned).real
            mass[-1, -1] = machine.rotor.inertia
            inverse = np.linalg.inv(mass)
        push = (speed**2 * turned).real - stiffness @ q - (damping + speed * model.gyroscopic) @ v
        moved = inverse @ np.append(push, torque)
        motion = np.concatenate([rows @ q, rows @ v]), np.array([angle, speed]), balls
        force, changed = element.coupled(time, *motion, wide @ moved, wide @ inverse @ wide.T)
        moved += inverse @ wide.T @ force
        return np.concatenate([v, moved[:-1], [speed, moved[-1]], changed])

    begin = 0.0 if free else SPEED
    start = np.concatenate([np.zeros(2 * size), [0.0, begin], element.state])
    found = solve_ivp(rates, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-13).y
    balls = found[2 * size + 2 :].T
    return (rows[:2] @ found[:size]).T @ [1.0, 1.0j], balls[:, : balls.shape[1] // 2]


CASES = {
    "planar, contact": planar(STEADY, TOUCHING, TWO),
    "planar, torque": planar({"kind": "torque", "torque": 4.0}, TWO, axis="vertical"),
    "tilting": tilting(drive=STEADY, start={}),
    "races that tilt": tilting(drive=STEADY, start={}, tilting_races="full"),
    "shaft": Machine.model_validate({
        "name": "shaft", "axis": "horizontal", "drive": STEADY,
        "rotor": shaft(
            0.5, 0.04, 2, material=SOFT, modes=6,
            disks=[{"position": 0.25, "mass": 3.0, "transverse_inertia": 0.008, "polar_inertia": 0.015}],
            supports=[{"position": z, "stiffness": 1e5, "damping": 60.0} for z in (0.0, 0.5)],
        ),
        "unbalances": [{"moment": 1e-4, "station": 0.25}],
        "balancers": [{"station": 0.25, "races": races(TWO)}],
    }),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_rotor_of_ones_own_moves_with_it_as_in_simulate(name: str) -> None:
    machine, times = CASES[name], np.linspace(0.0, 0.1, 11)
    deflection, angles = moved_by_scipy(machine, times, 4.0 if "torque" in name else 0.0)
    run = ab.simulate(machine, duration=0.1, save=ab.SampleTimes(times.tolist()), tolerance=1e-12)
    ours = run["x"].values + 1j * run["y"].values
    np.testing.assert_allclose(deflection, ours, rtol=0.0, atol=1e-8 * np.abs(ours).max())
    np.testing.assert_allclose(angles, run["ball_angle_in_rotor"].values, rtol=0.0, atol=1e-8 * np.abs(angles).max())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            TWO | {"collisions": True},
            "meet rigidly, which takes an instant; give contact.stiffness, or collisions = false",
        ),
        (TWO | {"friction": {"rolling_resistance": 1e-3}}, r"balancers\[1\].races\[1\].friction: balls that stick"),
    ],
)
def test_what_takes_events_is_refused_by_name(given: dict[str, Any], message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ab.balancer_element(planar(STEADY, given))

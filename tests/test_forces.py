"""Forces on balls that are leaves: what they do to balls, rotor and energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.references import lagrange
from tests.references.resolved import Bodies, free
from tests.references.resolved import run as run_resolved
from tests.references.runs import states_at
from tests.references.spatial import split
from tests.references.spatial_machines import states_of, tilting
from tests.references.spatial_races import SpatialRaces

import autobalancer as ab
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Force, Machine

STIFF, LENGTH = 40.0, 0.12  # N/m and m of springs along a race
ALONG = {"kind": "race_springs", "stiffness": STIFF, "free_length": LENGTH}
ROD = {"kind": "radial_spring", "stiffness": 3000.0, "free_length": 0.05}
TURN = 2.0 * np.pi


def energy_along(angles: np.ndarray, orbit: float) -> np.ndarray:
    """Of springs along a race between balls at these angles (times, n), which start in their order within a turn, J."""
    gaps = np.diff(np.column_stack([angles, angles[:, 0] + TURN]), axis=1)
    return np.asarray((0.5 * STIFF * (orbit * gaps - LENGTH) ** 2).sum(axis=1))


def planar(forces: Any, **top: Any) -> Machine:
    """Three unequal balls off center on a light rotor that nothing drives or damps."""
    race = {
        "coincidence": True,
        "orbit_radius": 0.1,
        "eccentricity": 1e-3,
        "drag": {"law": "beta", "beta": 0.0},
        "forces": forces,
        "balls": [
            {"diameter": 0.01, "mass": 4e-3, "start_angles": 1.0},
            {"diameter": 0.01, "mass": 6e-3, "start_angles": 2.5, "start_speeds": -20.0},
            {"diameter": 0.01, "mass": 5e-3, "start_angles": 4.0},
        ],
    }
    data: dict[str, Any] = {
        "name": "springs along the race",
        "axis": "vertical",
        "rotor": {"mass": 0.5, "stiffness": 2e4, "damping": 0.0, "inertia": 2e-3},
        "unbalances": [{"moment": 1e-4, "angle": 0.4}],
        "balancers": [{"races": [race]}],
        "drive": {"kind": "torque", "torque": 0.0},
        "start": {"speed": 60.0, "deflection": [2e-4, -1e-4]},
    }
    return Machine(**(data | top))


def test_springs_along_the_race_keep_the_energy_of_a_planar_rotor_that_spins_freely() -> None:
    machine, times = planar(ALONG), np.linspace(0.0, 3.0, 61)
    states, reference = states_at(machine, times), lagrange.planar(machine)
    without = np.array([reference.energy(t, *reference.split(y)) for t, y in zip(times, states, strict=True)])
    stored = energy_along(states[:, 6:9], 0.1)
    assert np.ptp(stored) > 0.05
    np.testing.assert_allclose(without + stored, without[0] + stored[0], rtol=1e-10)
    momentum = [reference.angular_momentum(t, *reference.split(y)) for t, y in zip(times, states, strict=True)]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-10)  # they turn balls and rotor against each other


def test_springs_keep_the_energy_of_a_tilting_rotor_whose_races_are_not_round() -> None:
    """Rods feel the waves of the race, springs along it do not."""
    waves = [{"order": k, "amplitude": a, "angle": 0.7 * k} for k, a in ((1, 6e-4), (2, 1e-3))]
    machine = tilting(damping=0.0, beta=0.0, tilting_races="full")
    machine = ab.with_parameter(machine, "balancers[2].races[1].harmonics", waves)
    for b in (1, 2):
        machine = ab.with_parameter(machine, f"balancers[{b}].races[1].forces", [ALONG, ROD])
    states = split(machine, states_of(machine, np.linspace(0.0, 0.5, 21)))
    reference, angles = SpatialRaces(machine), states[:, 0, 5:]
    without = np.array([reference.energy(q, v) for q, v in states])
    stored = np.zeros(len(angles))
    for b, pair in enumerate((angles[:, :2], angles[:, 2:])):
        orbits = [ball.orbit_radius for ball in resolve(machine) if ball.balancer == b]
        gap = pair[:, 1] - pair[:, 0] + (TURN if b == 0 else 0.0)  # they start at 1 and -1.9, or at 2.5 and 5
        stored += 0.5 * STIFF * (orbits[0] * gap - LENGTH) ** 2 + 0.5 * STIFF * (orbits[1] * (TURN - gap) - LENGTH) ** 2
        for orbit, angle in zip(orbits, pair.T, strict=True):
            shape = waves if b == 1 else []
            away = orbit + sum(w["amplitude"] * np.cos(w["order"] * (angle - w["angle"])) for w in shape)
            stored += 0.5 * ROD["stiffness"] * (away - ROD["free_length"]) ** 2  # type: ignore[operator]
    assert np.ptp(stored) > 0.01
    np.testing.assert_allclose(without + stored, without[0] + stored[0], rtol=1e-9)


def test_springs_keep_the_energy_and_the_angular_momentum_of_balls_that_bounce() -> None:
    machine = free(race={"forces": [ALONG, ROD]})
    times = np.linspace(0.0, 0.5, 101)
    motion = Bodies(machine, *run_resolved(machine, times, tolerance=1e-11))
    angles = np.unwrap(np.angle(motion.place), axis=0)
    ahead = angles[:, 1] - angles[:, 0]
    gap = ahead - TURN * np.floor(ahead[0] / TURN)
    one, other = (ball.orbit_radius for ball in resolve(machine))
    stored = 0.5 * STIFF * (one * gap - LENGTH) ** 2 + 0.5 * STIFF * (other * (TURN - gap) - LENGTH) ** 2
    stored += (0.5 * ROD["stiffness"] * (np.abs(motion.place) - ROD["free_length"]) ** 2).sum(1)  # type: ignore[operator]
    energy = motion.energy()
    assert np.ptp(stored) > 0.01
    np.testing.assert_allclose(energy + stored, energy[0] + stored[0], rtol=1e-7)
    momentum = motion.angular_momentum()
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)


def test_two_balls_at_the_bottom_are_held_apart_by_the_springs_between_them() -> None:
    """Race at rest, axis horizontal: m g eps sin a = k eps^2 (2 pi - 4 a), each ball at a from the bottom."""
    race = {
        "coincidence": True,
        "orbit_radius": 0.1,
        "drag": {"law": "beta", "beta": 3e-4},
        "forces": {"kind": "race_springs", "stiffness": 2.0, "free_length": 0.02},
        "balls": [{"mass": 0.05, "motion": "point", "count": 2, "start_angles": [-2.0, -1.0]}],
    }
    machine = Machine(
        name="at the bottom",
        axis="horizontal",
        gravity=9.81,
        rotor={"mass": 1e6, "stiffness": 1e12, "damping": 0.0},
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
    )
    run = ab.simulate(machine, duration=60.0, mass_spread=0.0)
    away = brentq(lambda a: 0.05 * 9.81 * 0.1 * np.sin(a) - 2.0 * 0.01 * (TURN - 4.0 * a), 0.1, 3.0, xtol=1e-14)
    assert 0.5 < away < 1.5
    np.testing.assert_allclose(
        run.ball_angle_in_rotor.values[-1], -0.5 * np.pi + np.array([-away, away]), rtol=0.0, atol=1e-7
    )


def test_rods_relieve_the_wall_of_a_guided_ball() -> None:
    """N = m eps w^2 - k (eps - l) where nothing else acts."""
    race = {
        "orbit_radius": 0.1,
        "coincidence": True,
        "drag": {"law": "beta", "beta": 1e-4},
        "friction": {"rolling_resistance": 1e-6},
        "forces": {"kind": "radial_spring", "stiffness": 100.0, "free_length": 0.08},
        "balls": [{"diameter": 0.01, "mass": 0.004, "count": 2, "start_angles": [0.0, np.pi]}],
    }
    machine = Machine(
        name="rods",
        axis="vertical",
        rotor={"mass": 10.0, "stiffness": 6e5, "damping": 80.0},
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
    )
    run = ab.simulate(machine, duration=0.5, mass_spread=0.0)
    np.testing.assert_allclose(run.ball_normal_force.values[-1], 0.004 * 0.1 * 1e4 - 100.0 * 0.02, rtol=1e-9)


def test_a_resolved_ball_on_a_rod_leaves_the_wall_below_its_speed_and_hovers() -> None:
    """m w^2 r = k (r - l) inside the race: r = k l / (k - m w^2)."""
    stiffness, length, speed = 100.0, 0.05, 90.0
    race = {
        "race_radius": 0.105,
        "drag": {"law": "beta", "beta": 5e-3},
        "resolved": {"stiffness": 1e5, "restitution": 0.3, "sliding_friction": 0.1, "slip_speed": 0.01},
        "forces": {"kind": "radial_spring", "stiffness": stiffness, "free_length": length},
        "balls": [{"diameter": 0.01, "mass": 0.004, "count": 2, "start_angles": [0.0, np.pi]}],
    }
    machine = Machine(
        name="hovering",
        axis="vertical",
        rotor={"mass": 1e4, "stiffness": 6e9, "damping": 80.0},
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
    )
    run = ab.simulate(machine, duration=1.0)
    expected = stiffness * length / (stiffness - 0.004 * speed**2)
    assert 0.05 < expected < 0.095
    found = np.hypot(run.ball_x - run.x, run.ball_y - run.y).values[-1]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_forces_are_keys_with_paths_and_survive_a_file() -> None:
    machine = planar([ALONG, {"kind": "radial_spring", "stiffness": "3 N/mm", "free_length": "5 cm"}])
    twice = ab.with_parameter(machine, "balancers[1].races[1].forces[2].stiffness", "6 N/mm")
    assert twice.balancers[0].races[0].forces[1].numbers() == {"stiffness": 6000.0, "free_length": 0.05}
    assert ab.parse_machine(ab.machine_text(twice)) == twice
    table = ab.keys("balancers.races.forces")["[[balancers.races.forces]]"]
    assert {key.default or key.value for key in table if key.name == "kind"} >= {'"race_springs"', '"radial_spring"'}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"kind": "radial_sprin"}, "forces[1].kind: given 'radial_sprin'; did you mean 'radial_spring'"),
        ({"kind": 3}, "forces[1].kind: given 3; must be one of"),
        ({"stiffness": 1.0}, "it has no 'kind', which must be one of"),
        (3, "forces[1]: given 3; must be a table with a 'kind'"),
        (ALONG | {"stiffness": -1.0}, "forces[1].stiffness: given -1.0; must be greater than zero"),
        (ALONG | {"stifness": 1.0}, "forces[1].stifness: unknown key; did you mean 'stiffness'?"),
    ],
)
def test_a_force_that_is_not_possible_is_refused_where_it_stands(given: Any, said: str) -> None:
    with pytest.raises(ValueError, match=r"balancers\[1\].races\[1\]") as refused:
        planar(given)
    assert said in str(refused.value)


def test_questions_of_stability_refuse_forces_on_the_balls() -> None:
    machine = planar(ALONG)
    with pytest.raises(QuestionError, match=r"balancers\[1\]\.races\[1\]\.forces: this question does not know"):
        ab.stability.equilibria(machine, 200.0)


def test_every_force_of_the_package_is_found_by_its_file() -> None:
    from autobalancer.machine.leaves import find, known

    for word in known(Force):
        leaf = find(Force, word)
        assert leaf.__module__ == f"autobalancer.forces.{word}"
        assert leaf.interface == Force.current

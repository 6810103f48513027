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
from tests.references.spatial_machines import rates, states_of, tilting
from tests.references.spatial_races import SpatialRaces

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Force, Machine
from autobalancer.machine.plugins import find, known
from autobalancer.plots.style import FORCE
from autobalancer.results.drawn import Motion, lines_of, races_of

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
        "collisions": False,
        "orbit_radius": 0.1,
        "eccentricity": 1e-3,
        "drag": {"law": "viscous", "damping": 0.0},
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


@pytest.mark.slow  # computer algebra for the reference
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


@pytest.mark.parametrize("real", [False, True])
def test_all_equations_of_guided_balls_give_forces_the_same_effect(real: bool) -> None:
    """Those of any rotor, with smooth and with real races, as the fast path of planar rotors."""
    machine = planar([ALONG, ROD])
    fast = assemble(machine, rotating=False)
    if real:
        wave = [{"order": 2, "amplitude": 0.0}]
        machine = ab.with_parameter(machine, "balancers[1].races[1].harmonics", wave)
    slow = assemble(machine, rotating=False, general=True)
    assert (fast.model.name, slow.model.name) == ("PLANAR", "ROUGH" if real else "GUIDED")
    state = fast.state + 1e-3 * np.sin(np.arange(fast.state.size))
    np.testing.assert_allclose(rates(slow, 0.0, state), rates(fast, 0.0, state), rtol=1e-11, atol=1e-9)
    assert np.abs(rates(assemble(planar([]), rotating=False), 0.0, state) - rates(fast, 0.0, state)).max() > 1.0


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
        "collisions": False,
        "orbit_radius": 0.1,
        "drag": {"law": "viscous", "damping": 3e-4},
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
        "collisions": False,
        "drag": {"law": "viscous", "damping": 1e-4},
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
        "drag": {"law": "viscous", "damping": 5e-3},
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


HEAVY = {"mass": 1e4, "stiffness": 6e9, "damping": 80.0}


def still(race: dict[str, Any], speed: float, **top: Any) -> Machine:
    """A rotor that nothing moves, at one speed."""
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    data = {"name": "still", "axis": "vertical", "rotor": HEAVY, "balancers": [{"races": [race]}], "drive": drive}
    return Machine(**(data | top))


def chamber(force: dict[str, Any], gap: float) -> dict[str, Any]:
    """Two opposite balls between an inner wall, where their centers are at 0.08 m, and an outer one, at 0.1 m."""
    return {
        "race_radius": 0.105,
        "width": 0.03,
        "drag": {"law": "viscous", "damping": 1e-3},
        "resolved": {
            "stiffness": 1e5,
            "restitution": 0.3,
            "sliding_friction": 0.1,
            "slip_speed": 0.01,
            "start_gap": gap,
        },
        "forces": force,
        "balls": [{"diameter": 0.01, "mass": 0.004, "count": 2, "start_angles": [0.0, np.pi]}],
    }


def radii(run: Any) -> Any:
    """Of the ball centers in the race, (time, ball)."""
    return np.hypot(run.ball_x - run.x, run.ball_y - run.y).values


MAGNETS = {"kind": "magnets", "force_at_contact": 2.0, "reach": 3e-3, "radius": 0.075}


@pytest.mark.parametrize("share", [0.995, 1.005])
def test_magnets_on_the_inner_wall_release_balls_where_the_centrifugal_force_is_greater(share: float) -> None:
    """m r w^2 = force at contact, with the ball center at r on the inner wall; the ball then runs to the outer wall."""
    speed = share * np.sqrt(2.0 / (0.004 * 0.08))
    run = ab.simulate(still(chamber(MAGNETS, 0.02), speed), duration=0.5)
    np.testing.assert_allclose(radii(run)[-1], 0.08 if share < 1.0 else 0.1, atol=2e-4)


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_magnets_draw_balls_back_from_the_outer_wall_below_a_lower_speed_only(share: float) -> None:
    speed = share * np.sqrt(2.0 * np.exp(-0.02 / 3e-3) / (0.004 * 0.1))
    run = ab.simulate(still(chamber(MAGNETS, 0.0), speed), duration=10.0)
    np.testing.assert_allclose(radii(run)[-1], 0.08 if share < 1.0 else 0.1, atol=2e-4)


@pytest.mark.parametrize("share", [0.99, 1.01])
@pytest.mark.parametrize("radius", [0.08, 0.1])
def test_balls_climb_an_inclined_race_and_come_back_where_weight_and_centrifugal_force_balance(
    radius: float, share: float
) -> None:
    """w^2 = g tan(incline)/r: of the inner radius for balls at rest there, of the outer one for those that are up."""
    incline = {"kind": "inclined_race", "incline": "30 deg"}
    speed = share * np.sqrt(9.80665 * np.tan(np.pi / 6.0) / radius)
    run = ab.simulate(still(chamber(incline, 0.1 - radius), speed), duration=4.0)
    np.testing.assert_allclose(radii(run)[-1], 0.08 if share < 1.0 else 0.1, atol=2e-4)


@pytest.mark.parametrize("share", [0.97, 1.03])
def test_pins_hold_balls_until_the_whirl_of_the_rotor_pulls_harder_than_what_is_left_of_their_hold(
    share: float,
) -> None:
    """m w^2 X = hold (1 - w^2/w_r^2), with the deflection X = U w^2/(k - M w^2) at a right angle to the balls."""
    stiffness, mass, moment, hold, release = 1e6, 100.02, 0.01, 1e-3, 80.0
    pins = {"kind": "pins", "count": 2, "angle": "90 deg", "hold": hold, "reach": "2 mm", "release_speed": release}
    race = {
        "orbit_radius": 0.1,
        "collisions": False,
        "drag": {"law": "viscous", "damping": 5e-3},
        "forces": pins,
        "balls": [{"mass": 0.01, "motion": "point", "count": 2, "start_angles": ["90 deg", "-90 deg"]}],
    }

    def deflection(w: float) -> float:
        return moment * w**2 / (stiffness - mass * w**2)

    breaks = brentq(lambda w: 0.01 * w**2 * deflection(w) - hold * (1.0 - (w / release) ** 2), 10.0, 79.0)
    speed = share * breaks
    machine = still(
        race,
        speed,
        rotor={"mass": 100.0, "stiffness": stiffness, "damping": 0.0},
        unbalances=[{"moment": moment}],
        start={"deflection": [deflection(speed), 0.0], "velocity": [0.0, speed * deflection(speed)]},
    )
    run = ab.simulate(machine, duration=30.0, mass_spread=0.0)
    moved = 0.1 * np.abs(np.abs(run.ball_angle_in_rotor.values[-1]) - 0.5 * np.pi)
    assert (moved < 2e-3).all() if share < 1.0 else (moved > 1e-2).all()


def test_pins_do_nothing_from_their_release_speed_on() -> None:
    runs = []
    for force in ([], {"kind": "pins", "count": 3, "hold": 5.0, "reach": 1e-3, "release_speed": 59.0}):
        machine = planar(force, drive={"kind": "speed", "profile": {"kind": "constant", "speed": 60.0}}, start={})
        run = ab.simulate(machine, duration=0.3, method="dormand_prince_8")  # long steps do not take forces
        runs.append(run.ball_angle_in_rotor.values)
    np.testing.assert_array_equal(*runs)


def test_two_magnetized_balls_at_the_bottom_rest_where_weight_and_repulsion_balance() -> None:
    """m g eps sin a = F eps cos a with F = 3 mu_0 M^2/(4 pi d^4) at the distance d = 2 eps sin a."""
    race = {
        "collisions": False,
        "orbit_radius": 0.1,
        "drag": {"law": "viscous", "damping": 3e-4},
        "forces": {"kind": "repelling_balls", "moment": 2.0},
        "balls": [{"mass": 0.05, "motion": "point", "count": 2, "start_angles": [-2.0, -1.0]}],
    }
    machine = still(race, 0.0, axis="horizontal", gravity=9.81)
    run = ab.simulate(machine, duration=60.0, mass_spread=0.0)

    def pushed(a: float) -> float:
        return 3e-7 * 4.0 / (0.2 * np.sin(a)) ** 4

    away = brentq(lambda a: 0.05 * 9.81 * np.sin(a) - pushed(a) * np.cos(a), 0.01, 1.5, xtol=1e-14)
    assert 0.2 < away < 1.2
    np.testing.assert_allclose(
        run.ball_angle_in_rotor.values[-1], -0.5 * np.pi + np.array([-away, away]), rtol=0.0, atol=1e-7
    )


def test_the_energy_of_magnets_and_magnetized_balls_is_in_the_file_and_completes_that_of_the_machine() -> None:
    poles = {"kind": "magnets", "force_at_contact": 3.0, "reach": 0.01, "radius": 0.085, "count": 5, "angle": 0.2}
    machine = planar([poles, {"kind": "repelling_balls", "moment": 3.0}])
    times = np.linspace(0.0, 2.0, 41)
    states, reference = states_at(machine, times), lagrange.planar(machine)
    without = np.array([reference.energy(t, *reference.split(y)) for t, y in zip(times, states, strict=True)])
    place = 0.1 * np.exp(1j * states[:, 6:9])
    pole = 0.085 * np.exp(1j * (0.2 + TURN / 5.0 * np.arange(5)))
    stored = -3.0 * 0.01 * np.exp((0.005 - np.abs(place[:, :, None] - pole)) / 0.01).sum(axis=(1, 2))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        stored += 1e-7 * 9.0 / np.abs(place[:, i] - place[:, j]) ** 3
    assert np.ptp(stored) > 0.02
    np.testing.assert_allclose(without + stored, without[0] + stored[0], rtol=1e-9)
    run = ab.simulate(machine, duration=2.0, save=ab.SampleTimes(times.tolist()), tolerance=1e-12, mass_spread=0.0)
    np.testing.assert_allclose(run.force_energy, stored, rtol=1e-6)
    assert run.force_energy.attrs["units"] == "J"


def test_an_inclined_race_is_refused_where_nothing_can_climb() -> None:
    incline = {"kind": "inclined_race", "incline": "30 deg"}
    with pytest.raises(ValueError, match=r"forces\[1\]: guided balls cannot climb; make them 'resolved'"):
        planar(incline)
    with pytest.raises(ValueError, match=r"forces\[1\]: its force is the weight along the axis"):
        still(chamber(incline, 0.0), 10.0, axis="horizontal")


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


def test_the_averaged_theory_refuses_forces_on_the_balls() -> None:
    with pytest.raises(QuestionError, match="the averaged theory does not know forces on the balls"):
        ab.stability.averaged_border(planar(ALONG))


def test_every_force_of_the_package_is_found_by_its_file() -> None:
    for word in known(Force):
        leaf = find(Force, word)
        assert leaf.__module__ == f"autobalancer.forces.{word}"
        assert leaf.interface == Force.current


def test_pictures_of_a_race_draw_springs_that_end_at_their_balls() -> None:
    machine = planar([ALONG, ROD])
    run = ab.simulate(machine, duration=0.1)
    angles = run.ball_angle_in_rotor.values[-1]
    (axes,) = ab.plot.race(run).axes
    drawn = [line.get_xydata() @ [1.0, 1j] for line in axes.lines if line.get_color() == FORCE]
    along, rods = drawn[:3], drawn[3:]
    center = rods[0][0]
    balls = center + 100.0 * np.exp(1j * angles)
    np.testing.assert_allclose([line[-1] for line in rods], balls, atol=1e-6)
    order = np.argsort(np.mod(angles + np.pi, TURN))
    np.testing.assert_allclose([line[0] for line in along], balls[order], atol=1e-6)
    np.testing.assert_allclose([line[-1] for line in along], np.roll(balls[order], -1), atol=1e-6)


@pytest.mark.parametrize("word", known(Force))
def test_every_force_of_the_package_has_a_symbol(word: str) -> None:
    keys: dict[str, dict[str, Any]] = {
        "race_springs": {"stiffness": 1.0},
        "radial_spring": {"stiffness": 1.0, "free_length": 0.0},
        "magnets": {"force_at_contact": 1.0, "reach": 1e-3, "radius": 0.08, "count": 3},
        "repelling_balls": {"moment": 1.0},
        "inclined_race": {"incline": 0.5},
        "pins": {"count": 3, "hold": 1.0, "reach": 1e-3, "release_speed": 50.0},
    }
    lines = lines_of([find(Force, word)(**keys[word])], 0.1, [0.1, 0.1j], 0.0)  # type: ignore[list-item]
    assert lines
    assert 0.0 < max(abs(point) for line in lines for point in line) < 0.13


def test_pins_are_drawn_beside_the_balls_that_they_hold_and_not_once_they_have_sunk_in() -> None:
    pins = {"kind": "pins", "count": 2, "hold": 0.2, "reach": 0.004, "release_speed": 80.0}
    lengths = []
    for speed in (0.0, -40.0, 80.0, -120.0):
        lines = lines_of([find(Force, "pins")(**pins)], 0.1, [0.1, -0.1], speed)  # type: ignore[list-item]
        assert len(lines) == 4
        assert min(abs(point - ball) for line in lines for point in line for ball in (0.1, -0.1)) > 0.0115
        lengths.append([abs(end - begin) for begin, end in lines])
    np.testing.assert_allclose(
        np.divide(lengths, lengths[0]), [[1.0] * 4, [0.75] * 4, [0.0] * 4, [0.0] * 4], atol=1e-12
    )


def test_pictures_draw_resolved_balls_where_magnets_hold_them() -> None:
    """On the inner wall, where they also balance less."""
    run = ab.simulate(still(chamber(MAGNETS, 0.02), 40.0, unbalances=[{"moment": 1e-4}]), duration=0.2)
    (axes,) = ab.plot.race(run).axes
    centers = [abs(complex(*patch.center)) for patch in axes.patches if getattr(patch, "radius", 0.0) == 5.0]
    np.testing.assert_allclose(centers, 80.0, atol=0.1)
    races, moments = races_of(run), Motion(run).at(run.time.values[-1:])
    np.testing.assert_allclose(np.abs(races.resultant(moments)), run.residual_unbalance.values[-1:], rtol=1e-3)

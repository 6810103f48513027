"""Rollers and pendulums in a race: what they keep, and what they have in common with balls."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from tests.references import lagrange
from tests.references.motion import motion
from tests.references.planar_linear import matrices
from tests.references.planar_states import equilibria_of
from tests.references.resolved import contact
from tests.references.resolved_run_ups import GRIP, apart, run_up
from tests.references.runs import states_at
from tests.references.spatial import Spatial, joined, split
from tests.references.spatial_machines import rates, states_of, tilting
from tests.test_spatial_lagrange import random_place
from tests.test_stability_tilting import SPEED as SPINNING
from tests.test_stability_tilting import Compiled, random_state

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity, with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import MachineError, QuestionError
from autobalancer.kernels.system import BALLS, VX, VY, X, Y
from autobalancer.machine import Machine
from autobalancer.plots.animation import RotorView
from autobalancer.results.drawn import Motion, races_of
from autobalancer.stability.friction import held_by_friction
from autobalancer.stability.host.stations import plane, stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.linearized import eigensystem
from autobalancer.stability.steady_curves import Family

SPEED = 300.0  # rad/s, above the critical speed of about 240
RING = {"body": "roller", "diameter": 0.012, "inner_diameter": 0.007, "length": 0.015, "density": 7800.0}
ROD = {"body": "pendulum", "mass": 0.02, "inertia": 4e-5}


def race(*groups: dict[str, Any], eccentricity: float = 1e-3, beta: float = 0.0, **other: Any) -> dict[str, Any]:
    """One of 0.08 m around a point beside the shaft."""
    return {
        "collisions": False,
        "orbit_radius": 0.08,
        "eccentricity": eccentricity,
        "eccentricity_angle": 0.7,
        "drag": {"law": "viscous", "damping": beta},
        "balls": list(groups),
        **other,
    }


def machine(*races: dict[str, Any], axis: str = "vertical", isotropic: bool = True, **top: Any) -> Machine:
    """A planar rotor that nothing drives and nothing brakes."""
    rotor = {"mass": 10.0, "stiffness": 6e5 if isotropic else [6e5, 8e5], "damping": 0.0, "inertia": 0.05}
    data: dict[str, Any] = {
        "name": "free",
        "axis": axis,
        "rotor": rotor,
        "unbalances": [{"moment": 6e-4, "angle": 0.4}],
        "balancers": [{"races": list(races)}],
        "drive": {"kind": "torque", "torque": 0.0},
        "start": {"speed": SPEED, "deflection": [2e-4, -1e-4], "velocity": [0.03, 0.05]},
    }
    return Machine(**(data | top))


def both(more: dict[str, Any] | None = None, **top: Any) -> Machine:
    """Two rollers of one race, two pendulums of another, and ``more`` about both races."""
    more = more or {}
    arm = {**ROD, "bearing_radius": 0.005}
    first, second = {"start_angles": 1.0, "start_speeds": 10.0}, {"start_angles": 3.5, "start_speeds": -40.0}
    rollers = race(RING | first, RING | second, **more)
    arms = race(arm | second, arm | first | {"mass": 0.03}, **more)
    return machine(rollers, arms, **top)


TIMES = np.linspace(0.0, 2.0, 100)


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize("isotropic", [True, False])
def test_rollers_and_pendulums_keep_the_energy_of_a_rotor_that_spins_freely(axis: str, isotropic: bool) -> None:
    """Their own inertia takes part in the speed of the rotor, also where their race is off center."""
    case = both(axis=axis, isotropic=isotropic)
    reference, states = lagrange.planar(case), states_at(case, TIMES)
    assert np.ptp(motion(case, states).angles, axis=0).min() > 3.0  # they really run
    energy = [reference.energy(t, *reference.split(y)) for t, y in zip(TIMES, states, strict=True)]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_rollers_and_pendulums_keep_the_angular_momentum_if_all_is_isotropic_and_free() -> None:
    case = both()
    reference, states = lagrange.planar(case), states_at(case, TIMES)
    momentum = [reference.angular_momentum(t, *reference.split(y)) for t, y in zip(TIMES, states, strict=True)]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-10)


@pytest.mark.parametrize("model", ["planar", "any rotor", "real races"])
def test_the_equations_are_those_of_the_lagrangian_with_nothing_eliminated(model: str) -> None:
    """At random states on eccentric races, with a rotor that is free to speed up; the friction of real races is none here."""
    friction = {"friction": {"adherence": 1e-15}} if model == "real races" else {}
    case = both(friction, axis="horizontal", isotropic=False)
    reference, assembly = lagrange.planar(case), assemble(case, rotating=False, general=model == "any rotor")
    assert (assembly.general, assembly.rough) == (model != "planar", model == "real races")
    random = np.random.default_rng(5)
    for _ in range(5):
        state = np.array(
            [*random.normal(size=2) * 1e-3, *random.normal(size=2), 0.3, 250.0, *random.normal(size=8) * 60.0]
        )
        expected, found = reference.rates(0.0, state), rates(assembly, 0.0, state)
        for group in (slice(2, 4), [5], slice(10, 14)):
            np.testing.assert_allclose(
                found[group], expected[group], rtol=0.0, atol=1e-12 * np.abs(expected[group]).max()
            )


@pytest.mark.parametrize("races", ["deflection", "full"])
def test_the_equations_of_a_rotor_that_tilts_are_those_of_its_lagrangian(races: str) -> None:
    case = tilted(tilting_races=races, axis="horizontal")
    reference, assembly = Spatial(case), assemble(case, rotating=False)
    random = np.random.default_rng(6)
    for _ in range(3):
        q, v = random_place(random, 180.0)
        found = split(case, rates(assembly, 0.0, joined(case, q, v))[None])[0][1]
        expected = reference.accelerations(0.0, q, v)
        for group in ([0, 2], [1, 3], [4], [5, 6, 7, 8]):
            np.testing.assert_allclose(
                found[group], expected[group], rtol=0.0, atol=1e-12 * np.abs(expected[group]).max()
            )


@pytest.mark.parametrize("races", ["deflection", "full"])
def test_rollers_and_pendulums_keep_energy_and_angular_momentum_of_a_rotor_that_tilts(races: str) -> None:
    case = tilted(tilting_races=races)
    times = np.linspace(0.0, 1.0, 21)
    reference, states = Spatial(case), split(case, states_of(case, times))
    assert np.ptp(states[:, 0, 5:], axis=0).min() > 1.0
    energy = [reference.energy(t, q, v) for t, (q, v) in zip(times, states, strict=True)]
    momentum = [reference.angular_momentum(t, q, v) for t, (q, v) in zip(times, states, strict=True)]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-10)


def tilted(**top: Any) -> Machine:
    """Rollers in the lower plane, pendulums in the upper one, both off center."""
    rollers = race({**RING, "start_angles": 1.0}, {**RING, "start_angles": -1.9})
    arms = race({**ROD, "start_angles": 2.5}, {**ROD, "start_angles": 5.0, "start_speeds": -20.0})
    planes = [{"station": "lower", "races": [rollers]}, {"station": "upper", "races": [arms]}]
    return tilting(isotropic=True, damping=0.0, beta=0.0, balancers=planes, **top)


def test_check_says_where_the_own_inertia_of_a_pendulum_is_left_out() -> None:
    left = {form: " ".join(ab.check(tilted(tilting_races=form)).warnings) for form in ("full", "deflection")}
    assert "0.31 of m eps^2" in left["full"]  # 4e-5 / (0.02 * 0.08^2)
    assert "eps^2" not in left["deflection"]


def test_curves_of_states_see_the_equations_of_bodies_that_tilt_with_their_race() -> None:
    """The vector field from which eigenvalues and branches follow, at random states."""
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": SPINNING}}
    case = tilted(tilting_races="full", drive=drive)
    field, compiled, random = Field(stations(case), SPINNING), Compiled(case), np.random.default_rng(1)
    for _ in range(3):
        state = random_state(field, random)
        for found, expected in zip(np.split(field(state), 4), np.split(compiled(state), 4), strict=True):
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_a_pendulum_without_inertia_moves_as_a_point_ball() -> None:
    start = {"start_angles": [1.0], "start_speeds": [30.0]}
    arm = machine(race({"body": "pendulum", "mass": 0.02, "inertia": 0.0, **start}), axis="horizontal")
    point = machine(race({"motion": "point", "mass": 0.02, **start}), axis="horizontal")
    np.testing.assert_array_equal(states_at(arm, TIMES), states_at(point, TIMES))


@pytest.mark.parametrize("name", ["pendulum", "roller"])
def test_a_free_body_answers_a_rotor_that_speeds_up_by_its_coupling(name: str) -> None:
    """(m eps^2 + J) w' + I phi'' = 0 of a pendulum, which so stays where it is in space; - j m r eps for J of a roller."""
    group = {"pendulum": ROD, "roller": RING}[name]
    rotor = {"mass": 1e6, "stiffness": 1e12, "damping": 0.0, "inertia": 0.05}
    drive = {"kind": "torque", "torque": 0.1}
    case = machine(
        race({**group, "start_angles": 0.0}, eccentricity=0.0), rotor=rotor, drive=drive, unbalances=[], start={}
    )
    (ball,), moved = resolve(case), motion(case, states_at(case, [0.1]))
    square = ball.mass * 0.08**2
    own = 4e-5 if name == "pendulum" else -0.5 * (1.0 + (7.0 / 12.0) ** 2) * ball.mass * 0.006 * 0.08
    inertia = square + (4e-5 if name == "pendulum" else 0.5 * (1.0 + (7.0 / 12.0) ** 2) * square)
    share = moved.speeds[0, 0] / moved.rotor_speed[0]
    assert share == pytest.approx(-(square + own) / inertia, rel=1e-6)
    assert (share == pytest.approx(-1.0, rel=1e-6)) == (name == "pendulum")


@pytest.mark.parametrize("group", [RING, ROD], ids=["rollers", "pendulums"])
@pytest.mark.parametrize("speed", [150.0, 400.0])
def test_growth_rates_of_steady_states_are_those_of_the_compiled_equations(group: dict[str, Any], speed: float) -> None:
    """The right-hand side at each state, differentiated; below and above the critical speed."""
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    bodies = race({**group, "count": 2}, eccentricity=0.0, beta=2e-3)
    rotor = {"mass": 10.0, "stiffness": 6e5, "damping": 300.0}
    case = machine(bodies, rotor=rotor, drive=drive, start={})
    assembly, p = assemble(case), plane(case)
    places = np.array([X, Y, VX, VY, *range(BALLS, BALLS + 4)])
    found = equilibria_of(p, speed)
    assert len(found) >= 2
    for state in found:
        y = assembly.state.copy()
        v = 1j * speed * state.whirl
        y[[X, Y, VX, VY]] = state.whirl.real, state.whirl.imag, v.real, v.imag
        y[BALLS : BALLS + 2], y[BALLS + 2 :] = state.angles, 0.0
        jacobian = np.empty((8, 8))
        for column, place in enumerate(places):
            step = np.zeros_like(y)
            step[place] = 1e-4 * assembly.scale[place]
            rise = rates(assembly, 0.0, y + step) - rates(assembly, 0.0, y - step)
            jacobian[:, column] = rise[places] / (2.0 * step[place])
        scale = assembly.scale[places]
        numeric = np.linalg.eigvals(jacobian * scale / scale[:, None])
        exact, _ = eigensystem(*matrices(p, speed, state))
        for value in exact:
            assert np.abs(numeric - value).min() < 1e-5 * speed


def swinging(**group: Any) -> Machine:
    """A pendulum of 0.08 m with the bearing friction 0.3 at 8 mm, on a rotor that stands still; the axis is horizontal."""
    arm = race({**ROD, "bearing_radius": 0.008, **group}, eccentricity=0.0, friction={"rolling_resistance": 0.3})
    still = {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}}
    return machine(
        arm, axis="horizontal", rotor={"mass": 1e9, "stiffness": 1e15, "damping": 0.0}, drive=still, start={}
    )


def test_the_bearing_of_a_pendulum_takes_its_friction_of_what_it_carries_also_where_it_pulls() -> None:
    """From above, where the bearing holds the pendulum up, to below: the loss is the integral of mu r |N| |phi'|."""
    case = swinging(start_angles=1.2 + np.pi / 2)
    run = ab.simulate(case, duration=0.5, tolerance=1e-10, save=ab.Samples(2000))
    angle, speed = run.ball_angle_in_rotor.values[:, 0], run.ball_speed_in_rotor.values[:, 0]
    assert np.cos(angle[0] + np.pi / 2) < 0.0  # above
    inertia, weight = 0.02 * 0.08**2 + 4e-5, 0.02 * case.gravity
    energy = 0.5 * inertia * speed**2 + weight * 0.08 * np.sin(angle)
    force = 0.02 * 0.08 * speed**2 - weight * np.sin(angle)
    assert force.min() < -0.2 * weight
    assert force.max() > weight
    loss = 0.3 * 0.008 * np.abs(force * speed)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (loss[1:] + loss[:-1]) * np.diff(run.time.values))])
    np.testing.assert_allclose(energy[0] - energy, work, atol=2e-5 * np.ptp(energy))
    assert work[-1] > 0.02 * np.ptp(energy)


@pytest.mark.parametrize("middle", [np.pi / 2, -np.pi / 2], ids=["above", "below"])
def test_the_bearing_holds_a_pendulum_within_its_cone_of_friction(middle: float) -> None:
    """m g eps sin(a) <= mu r m g cos(a) around the highest and the lowest place: tan(a) <= 0.3 * 8/80."""
    cone = np.arctan(0.3 * 0.008 / 0.08)
    for share, rests in ((0.99, True), (1.01, False)):
        run = ab.simulate(swinging(start_angles=middle + share * cone), duration=0.05, save=ab.Samples(2))
        assert (run.ball_speed_in_rotor.values[-1, 0] == 0.0) == rests


@pytest.mark.parametrize("diameter", [None, 0.02])
def test_pendulums_pass_each_other_unless_they_have_heads_in_one_plane(diameter: float | None) -> None:
    """Heads rebound where their centers are a diameter apart, a chord of the orbit."""
    arms = {**ROD, "count": 2, "start_angles": [0.0, 1.0], "start_speeds": [10.0, -10.0]}
    arms |= {} if diameter is None else {"diameter": diameter}
    contact = {} if diameter is None else {"contact": {"restitution": 1.0, "stiffness": 1e7}}
    still = {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}}
    rotor = {"mass": 1e9, "stiffness": 1e15, "damping": 0.0}
    case = machine(race(arms, eccentricity=0.0, collisions=True, **contact), rotor=rotor, drive=still, start={})
    run = ab.simulate(case, duration=0.1, save=ab.Samples(1001))
    apart = np.diff(run.ball_angle_in_rotor.values, axis=1).ravel()
    if diameter is None:
        assert apart[-1] == pytest.approx(-1.0, abs=1e-9)
    else:
        assert apart.min() == pytest.approx(2.0 * np.arcsin(0.5 * diameter / 0.08), abs=5e-3)
        assert run.ball_speed_in_rotor.values[-1] == pytest.approx([-10.0, 10.0], rel=0.02)


FLUID = {"density": 900.0, "viscosity": 1e-5}
BALL = {"diameter": 0.012, "density": 7800.0}
RESOLVED = {"stiffness": 1e7, "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": 1e-3}
WRONG: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "size of a roller": ({**RING, "diameter": None}, {}, "a roller needs its 'diameter'"),
    "mass of a roller": ({**RING, "density": None}, {}, "a roller needs its 'diameter', and 'mass'"),
    "roller given twice": ({**RING, "mass": 0.01}, {}, "mass, length and density"),
    "bore": ({**RING, "inner_diameter": 0.013}, {}, "given 13 mm; must be smaller than the diameter, 12 mm"),
    "inertia": ({**ROD, "inertia": None}, {}, "a pendulum needs its 'mass' and 'inertia'"),
    "ball with a length": ({**BALL, "length": 0.01}, {}, "length: a key of rollers, but this is a group of balls"),
    "point roller": ({**RING, "motion": "point"}, {}, "motion: a key of balls, but this is a group of rollers"),
    "pendulum of steel": ({**ROD, "material": "steel"}, {}, "material: a key of balls and rollers"),
    "drag of spheres": (RING, {"drag": {"law": "free_sphere"}, "fluid": FLUID}, "'free_sphere' is that of spheres"),
    "bearing": (RING, {"orbit_radius": None, "bearing": "16021"}, "its groove is made for balls"),
    "virtual mass": (RING, {"fluid": FLUID}, "its default, 2, is that of balls"),
    "fluid in a bore": (RING, {"fluid": {**FLUID, "virtual_mass": 1.5}}, "hollow roller is not known"),
    "mixed": (ROD, {"balls": [ROD, BALL]}, "pendulums share no race with others"),
    "waves": (ROD, {"harmonics": {"order": 2, "amplitude": 1e-5}}, "the path of a pendulum is a circle"),
    "pendulum in oil": (ROD, {"fluid": FLUID}, "does not know what it displaces"),
    "wall": (ROD, {"orbit_radius": None, "race_radius": 0.08}, "a pendulum runs on no wall"),
    "bearing radius": (ROD, {"friction": {"adherence": 0.1}}, "balls.bearing_radius: missing"),
    "large bearing": ({**ROD, "bearing_radius": 0.08}, {}, "must be smaller than the orbit radius, 80 mm"),
    "rubbing pendulums": (
        ROD,
        {"collisions": True, "contact": {"restitution": 0.5, "friction": 0.1}},
        "only rolling",
    ),
    "resolved pendulum": (ROD, {"resolved": RESOLVED}, "a pendulum is guided by its bearing"),
    "contact of spheres": (
        RING,
        {"resolved": {**RESOLVED, "stiffness": None, "reduced_modulus": 1e11}},
        "contact of spheres",
    ),
    "too long": (RING, {"height": 0.01}, "a roller of 15 mm does not fit into a chamber of height 10 mm"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_fit_a_body_is_refused_in_words(name: str) -> None:
    group, other, words = WRONG[name]
    described = {key: value for key, value in {**race(group), **other}.items() if value is not None}
    given = {key: value for key, value in group.items() if value is not None}
    described["balls"] = described["balls"] if "balls" in other else [given]
    with pytest.raises(MachineError, match=re.escape(words)):
        resolve(machine(described))


# what the rest of the package makes of them -----------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["rollers", "pendulums"])
def sample(request: pytest.FixtureRequest) -> tuple[Machine, xr.Dataset]:
    """A sample machine and the end of a run of it."""
    case = ab.example(request.param)
    case = with_value_at(case, "drive.profile", {"kind": "constant", "speed": 125.0})
    return case, ab.simulate(case, duration=20.0, save=[ab.Samples(200), ab.LastRevolutions(5)])


def test_the_samples_balance_their_rotor_down_to_what_friction_holds(sample: tuple[Machine, xr.Dataset]) -> None:
    case, run = sample
    held = held_by_friction(case, 125.0)
    most = max((plane.sticking_residual for plane in held.planes), default=0.0)
    balls = (run.ball_moment * np.exp(1j * run.ball_angle_in_rotor.isel(time=-1))).sum()
    assert abs(complex(balls) + case.unbalances[0].size) < 1.01 * most + 1e-3 * case.unbalances[0].size
    assert (most > 0.0) == case.name.endswith("pendulums")


def test_the_picture_of_a_race_shows_rods_of_pendulums_and_rollers_between_walls(
    sample: tuple[Machine, xr.Dataset],
) -> None:
    case, run = sample
    body = case.balancers[0].races[0].balls[0].body
    (axes,) = ab.plot.race(run).axes
    circles = [patch.get_radius() for patch in axes.patches if isinstance(patch, Circle)]
    rods = [line for line in axes.lines if len(line.get_xdata()) == 2 and line.get_linewidth() > 3.0]
    walls = [radius for radius in circles if radius == pytest.approx(76.95 + 5.0)]
    assert (len(rods), len(walls)) == ((2, 0) if body == "pendulum" else (0, 1))
    words = " ".join(text.get_text() for text in [*axes.texts, *axes.get_legend().get_texts()])
    assert f"{body}s" in words
    assert "balls" not in words


def test_a_film_moves_the_rod_of_a_pendulum_with_its_head(sample: tuple[Machine, xr.Dataset]) -> None:
    case, run = sample
    motion_, races = Motion(run), races_of(run)
    moments = motion_.at(np.array([0.0, 0.3, 0.6]))
    view = RotorView(
        Figure().subplots(), moments, races, np.zeros(3), moments.deflection_in_rotor, 1, 1.0, ["k", "r"], 0.07695, {}
    )
    assert (len(view.rods), len(view.chamfers)) == ((2, 0) if case.name.endswith("pendulums") else (0, 2))
    for k in (0, 2):
        view.show(k)
        for i, (edge, core) in view.rods.items():
            for rod in (edge, core):
                np.testing.assert_allclose([rod.get_xdata()[1], rod.get_ydata()[1]], view.balls[i].center)
        for i, chamfer in view.chamfers.items():
            assert chamfer.center == view.balls[i].center


def test_a_run_names_its_bodies_and_says_nothing_of_balls_alone(sample: tuple[Machine, xr.Dataset]) -> None:
    case, run = sample
    assert set(run.ball_body.values) == {case.balancers[0].races[0].balls[0].body}
    assert "ball_body" not in ab.simulate(ab.example("stall_and_release"), duration=0.01)


def test_resolved_rings_that_do_not_slip_run_up_like_guided_ones() -> None:
    """Nearly all mass of a ring is at its rim, so that it is slower to follow than a ball of its mass."""
    ring = {"body": "roller", "mass": 2.5e-3, "diameter": 8e-3, "inner_diameter": 7.5e-3}
    ring |= {"count": 2, "start_angles": [1.0, -1.9]}
    guided = run_up(balls=[ring])
    stiff = run_up(contact(stiffness=1e7, slip_speed=0.01, **GRIP), balls=[ring])
    assert resolve(stiff)[0].own_inertia == pytest.approx(2.5e-3 * 0.5 * (4e-3**2 + 3.75e-3**2), rel=1e-12)
    assert apart(guided, stiff) < 2e-3
    assert apart(guided, run_up()) > 0.1  # balls


@pytest.mark.parametrize("name", ["rollers", "pendulums"])
def test_another_mass_of_a_body_changes_curves_of_states_as_it_changes_the_machine(name: str) -> None:
    """A pendulum keeps its own inertia, a roller its shape."""
    case = with_value_at(ab.example(name), "drive.profile", {"kind": "constant", "speed": 125.0})
    quick, slow = Family(case, ["ball_mass"], 125.0)(9e-3).host, stations(with_quantity(case, "ball_mass", 9e-3))
    np.testing.assert_allclose(quick.inertia, slow.inertia, rtol=1e-13)
    own = 4e-6 if name == "pendulums" else 0.5 * 9e-3 * 0.07695**2
    np.testing.assert_allclose(slow.inertia, 9e-3 * 0.07695**2 + own, rtol=1e-12)


def test_a_roller_in_oil_loses_the_oil_it_displaces_and_moves_some_of_it() -> None:
    solid = {key: value for key, value in RING.items() if key != "inner_diameter"}
    (ball,) = resolve(machine(race(solid, fluid={**FLUID, "virtual_mass": 1.5})))
    volume = 0.25 * np.pi * 0.012**2 * 0.015
    assert ball.effective_mass == pytest.approx((7800.0 - 900.0) * volume, rel=1e-12)
    assert ball.inertia == pytest.approx((1.5 * 7800.0 + 1.5 * 900.0) * volume * 0.08**2, rel=1e-12)


def test_a_roller_of_another_diameter_has_its_length_and_material_and_a_pendulum_is_refused() -> None:
    rollers = with_quantity(ab.example("rollers"), "ball_diameter", 0.012)
    assert resolve(rollers)[0].mass == pytest.approx(7800.0 * 0.25 * np.pi * 0.012**2 * 0.012, rel=1e-12)
    with pytest.raises(QuestionError, match="the density of the pendulums"):
        with_quantity(ab.example("pendulums"), "ball_diameter", 0.012)

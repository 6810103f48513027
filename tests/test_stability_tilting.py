"""Exact stability where balls move with their race in space: steady states, eigenvalues, borders, branches."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.references.rates import rates_at
from tests.references.spatial_machines import tilting
from tests.references.two_balls import specials

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity
from autobalancer.assembly.reduced_rotor import spatial_parts
from autobalancer.assembly.system import assemble
from autobalancer.catalog.resolve import resolve
from autobalancer.files.examples import rig
from autobalancer.kernels.balls.on_stations import guided_tilting
from autobalancer.kernels.system import BALLS
from autobalancer.machine import Machine
from autobalancer.simulation.record import Samples
from autobalancer.stability.host.stations import stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.linearized import modes
from autobalancer.stability.states.rest_states import balanced_of, state_vector, states_of
from autobalancer.stability.steady_curves import Family

SPEED = 400.0
TWO_PLANES = ab.with_parameter(ab.example("two_plane_rotor"), "tilting_races", "full")


@cache
def border_of(form: str) -> float:
    """The exact border of two planes on a rigid rotor."""
    machine = ab.with_parameter(TWO_PLANES, "tilting_races", form)
    (border,) = ab.stability.borders(machine, only=("exact border",))
    assert "ignores" not in border.note
    return border.speed


def off_center(**top: Any) -> Machine:
    """Unequal balls at two stations, one race off center, static and couple unbalance, in constant rotation."""
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}}
    return tilting(isotropic=True, drive=drive, **({"tilting_races": "full"} | top))


class Compiled:
    """The compiled equations of a machine as a function of a state of the vector field."""

    def __init__(self, machine: Machine) -> None:
        found = assemble(machine, rotating=True, contact=False)
        self.system, self.empty, self.balls = found.system, np.zeros(found.state.size), len(found.balls)
        self.basis = spatial_parts(machine, resolve(machine)).reduction.basis
        assert self.system.rotating

    def __call__(self, state: np.ndarray) -> np.ndarray:
        half, y = self.basis.shape[0], self.empty.copy()
        rest = BALLS + 2 * self.balls
        place = [[0, 1, *range(rest, rest + half - 2)], [2, 3, *range(rest + half - 2, rest + 2 * half - 4)]]
        for where, part in zip(place, (state[:half], state[half : 2 * half]), strict=True):
            y[where] = np.linalg.solve(self.basis, part)
        y[5], y[BALLS:rest] = SPEED, state[2 * half :]
        dy = rates_at(guided_tilting, 0.0, y, self.system)
        return np.concatenate([*(self.basis @ dy[where] for where in place), dy[BALLS:rest]])


def random_state(field: Field, random: np.random.Generator) -> np.ndarray:
    half, n = field.rotor // 2, field.balls
    sizes = np.concatenate([np.full(half, 1e-2), np.full(half, 3.0), np.full(n, 2.0), np.full(n, 50.0)])
    return sizes * random.normal(size=sizes.size)


def test_the_vector_field_is_that_of_the_compiled_equations() -> None:
    machine = off_center()
    field, compiled, random = Field(stations(machine), SPEED), Compiled(machine), np.random.default_rng(1)
    for _ in range(5):
        state = random_state(field, random)
        for found, expected in zip(np.split(field(state), 4), np.split(compiled(state), 4), strict=True):
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_its_derivatives_are_those_of_its_values() -> None:
    field, random = Field(stations(off_center()), SPEED), np.random.default_rng(2)
    state = random_state(field, random)
    u, v = (1e-2 * random_state(field, random) for _ in range(2))

    def difference(function: Any) -> np.ndarray:
        a, b, c, d = (function(state + h * v) for h in 0.1 * np.array([-2.0, -1.0, 1.0, 2.0]))
        return (a - 8.0 * b + 8.0 * c - d) / 1.2

    for obtained, expected in (
        (field.jacobian(state) @ v, difference(field)),
        (field.second(state, u, v), difference(lambda x: field.jacobian(x) @ u)),
        (field.third(state, u, v), difference(lambda x: field.second(x, u, u))),
    ):
        np.testing.assert_allclose(obtained, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())
    both = field.taylor(state, u + 1j * v, 1)[1]
    np.testing.assert_allclose(both, field.jacobian(state) @ (u + 1j * v), rtol=0.0, atol=1e-12 * np.abs(both).max())


def test_in_every_state_the_compiled_equations_rest_and_their_jacobian_has_its_eigenvalues() -> None:
    machine = off_center()
    st, compiled = stations(machine), Compiled(machine)
    states = states_of(st, SPEED)
    assert len(states) > 10
    for state in states:
        here = state_vector(st, SPEED, state.angles)
        assert np.abs(compiled(here)).max() < 1e-9 * SPEED**2
        sizes = np.concatenate([np.full(4, 1e-4), np.full(4, 3e-2), np.full(4, 1e-2), np.full(4, 1.0)])
        columns = []
        for number, size in enumerate(sizes):
            way = np.zeros(here.size)
            way[number] = size
            a, b, c, d = (compiled(here + k * way) for k in (-2.0, -1.0, 1.0, 2.0))
            columns.append((a - 8.0 * b + 8.0 * c - d) / (12.0 * size))
        numeric = np.linalg.eigvals(np.array(columns).T)
        for value in modes(st, SPEED, state)[0]:
            assert np.abs(numeric - value).min() < 1e-6 * SPEED


def test_without_drag_and_damping_motions_come_in_pairs_that_grow_and_decay_alike() -> None:
    # energy in the frame of the rotor is kept: with every eigenvalue its negative is one
    st = stations(off_center(damping=0.0, beta=0.0))
    for state in states_of(st, SPEED)[:6]:
        values, _ = modes(st, SPEED, state)
        for value in values:
            assert np.abs(values + value).min() < 1e-6 * SPEED


def scaled(factor: float, form: str) -> Machine:
    """Two planes with balls, unbalances and drag of another size, which change together."""
    machine = ab.with_parameter(ab.example("two_plane_rotor"), "tilting_races", form)
    for name in ("ball_mass", "drag"):
        machine = with_quantity(machine, name, factor * (4.0e-3 if name == "ball_mass" else 2e-4))
    unbalances = tuple(
        u.model_copy(update={key: factor * float(getattr(u, key)) for key in ("moment", "couple") if getattr(u, key)})
        for u in machine.unbalances
    )
    return machine.model_copy(update={"unbalances": unbalances, "gravity": 0.0})  # weight does not depend on the size


def test_the_lighter_the_balls_the_less_the_full_motion_differs_from_the_deflection() -> None:
    apart = []
    for factor in (1.0, 0.1, 0.01):
        full, flat = (
            np.sort(modes(st, SPEED, balanced_of(st, SPEED)[0])[0].imag)
            for st in (stations(scaled(factor, form)) for form in ("full", "deflection"))
        )
        apart.append(float(np.abs(full - flat).max()))
    assert apart[0] > 1e-2  # rad/s
    assert apart[1] / apart[0] == pytest.approx(0.1, rel=0.1)
    assert apart[2] / apart[1] == pytest.approx(0.1, rel=0.02)


def test_two_planes_still_balance_a_rigid_rotor_completely_with_the_weight_of_the_balls_too() -> None:
    st = stations(TWO_PLANES)
    assert st.weight == pytest.approx(-9.81, abs=0.01)
    state = balanced_of(st, SPEED)[0]
    assert np.abs(st.coordinates(SPEED, state.angles)).max() < 1e-15
    flat = balanced_of(stations(ab.with_parameter(TWO_PLANES, "gravity", 0.0)), SPEED)[0]
    assert np.abs(state.angles - flat.angles).max() > 1e-6  # the moment of their weights is balanced too


def test_on_a_leaning_race_no_ball_is_pushed_along_it_by_whirl_weight_and_shorter_reach() -> None:
    bare = TWO_PLANES.model_copy(update={"balancers": TWO_PLANES.balancers[:1]})
    st = stations(bare)
    (state,) = balanced_of(st, SPEED)[:1]
    (lean,) = st.slopes @ st.coordinates(SPEED, state.angles)
    assert abs(lean) > 1e-4
    assert abs(state.whirl[0]) > 1e-9  # the race does not quite run true
    for angle, orbit in zip(state.angles, st.orbit, strict=True):
        along, out = 1j * np.exp(1j * angle), np.exp(1j * angle)
        downhill = st.weight / SPEED**2 + (lean.conjugate() * orbit * out).real  # z'' of the ball, over W^2
        push = state.whirl[0] - downhill * lean
        assert abs((push.conjugate() * along).real) < 1e-6 * abs(state.whirl[0])


@pytest.mark.parametrize(("share", "grows"), [(0.9, True), (1.1, False)])
def test_on_either_side_of_the_border_a_run_moves_as_its_eigenvalues_say(share: float, grows: bool) -> None:
    speed = share * border_of("full")
    machine = ab.with_parameter(TWO_PLANES, "drive.profile.speed", speed)
    st = stations(machine)
    state = balanced_of(st, speed)[0]
    swing = 1e-6 * np.array([1.0, -1.0, 1.0, 1.0])
    for number in (1, 2):
        angles = tuple((state.angles + swing)[2 * number - 2 : 2 * number])
        machine = ab.with_parameter(machine, f"balancers[{number}].races[1].balls[1].start_angles", angles)
    run = ab.simulate(machine, duration=0.5, save=Samples(51), tolerance=1e-12, mass_spread=0.0)
    away = run["ball_angle_in_rotor"].values - state.angles
    values, vectors = np.linalg.eig(Field(st, speed).jacobian(state_vector(st, speed, state.angles)))
    assert (values.real.max() > 0.0) == grows
    shares = np.linalg.solve(vectors, np.concatenate([np.zeros(8), swing, np.zeros(4)]))
    motion = (vectors[8:12] @ (shares[:, None] * np.exp(values[:, None] * run["time"].values))).real.T
    np.testing.assert_allclose(away, motion, rtol=0.0, atol=1e-4 * np.abs(motion).max())


def test_the_first_hopf_point_of_a_branch_is_the_exact_border_and_not_that_of_the_deflection() -> None:
    border = border_of("full")
    assert border == pytest.approx(175.155, abs=0.001)
    assert border_of("deflection") == pytest.approx(175.025, abs=0.001)
    found = ab.stability.branches(TWO_PLANES, "speed", 175.3, 175.0, orbits=False, largest_step=0.5)
    point = specials(found, "Hopf")[0]
    assert float(point["special_parameter"]) == pytest.approx(border, rel=1e-9)
    assert str(point["criticality"].values) == "supercritical"


def test_a_family_in_fewer_coordinates_keeps_the_slopes_of_its_stations() -> None:
    shaft = ab.with_parameter(rig("cfrp_rig"), "tilting_races", "full")
    whole = stations(shaft)
    family = Family(shaft, ["speed"])
    family.reduce(40.0)
    small = family(35.0).host
    assert small.model.pairs < whole.model.pairs
    states = [balanced_of(st, 35.0)[0] for st in (whole, small)]
    rates = [modes(st, 35.0, state)[0][0].real for st, state in zip((whole, small), states, strict=True)]
    assert rates[1] == pytest.approx(rates[0], rel=1e-4)


def test_what_is_not_known_in_the_full_motion_says_so() -> None:
    notes = {border.name: border.note for border in ab.stability.borders(TWO_PLANES, only=("release speed",))}
    assert "ignores tilt of the races" in notes["release speed"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "flat", "full"),
    [
        (rig("cfrp_rig"), 294.07, 292.69),
        (rig("discoidal_rig"), 2331.50, 2331.83),
    ],
    ids=["cfrp", "discoidal"],
)
def test_borders_of_published_rigs_in_both_forms(machine: Machine, flat: float, full: float) -> None:
    for form, border in (("deflection", flat), ("full", full)):
        (found,) = ab.stability.borders(ab.with_parameter(machine, "tilting_races", form), only=("exact border",))
        assert found.speed * 30.0 / np.pi == pytest.approx(border, rel=1e-4), form


def test_a_continuum_of_three_balls_in_one_plane_stays_one_on_a_leaning_race() -> None:
    balls = [{"count": 3, "diameter": "10 mm", "density": 7800.0, "motion": "rolling"}]
    one = TWO_PLANES.model_copy(update={"balancers": TWO_PLANES.balancers[:1]})
    machine = ab.with_parameter(one, "balancers[1].races[1].balls", balls)
    full, flat = (
        ab.stability.equilibria(ab.with_parameter(machine, "tilting_races", form), 300.0)
        for form in ("full", "deflection")
    )
    assert full["name"].values.tolist() == flat["name"].values.tolist()
    assert full["freedom"].values.tolist() == flat["freedom"].values.tolist()
    np.testing.assert_allclose(full["growth_rate"], flat["growth_rate"], rtol=5e-3)

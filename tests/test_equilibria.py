"""Steady states and their exact stability."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tests.references.planar_linear import matrices
from tests.references.planar_states import equilibria_of
from tests.references.rates import rates_at
from tests.references.shooting import derivative, periodic_state

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.errors import QuestionError
from autobalancer.kernels.balls.planar import planar
from autobalancer.kernels.system import BALLS, VX, VY, X, Y
from autobalancer.machine import (
    Balancer,
    Balls,
    Constant,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    Race,
    Unbalance,
    ViscousDrag,
)
from autobalancer.simulation.record import SampleTimes
from autobalancer.stability.basins import Turn
from autobalancer.stability.host.stations import of_plane, plane
from autobalancer.stability.maps.balanced import PlanarBalancer, planar_eigenvalues
from autobalancer.stability.states.ball_positions import close_polygon
from autobalancer.stability.states.linearized import eigensystem, motion_name

MACHINES = Path(__file__).parents[1] / "examples" / "machines"


def machine(races: list[list[float]], *, offsets: list[complex] | None = None, unbalance: float = 4e-4) -> Machine:
    """A machine with races of point balls of the given masses on 0.1 m, at constant speed."""
    offsets = offsets or [0j] * len(races)
    parts = [
        Race(
            orbit_radius=0.1,
            eccentricity=abs(e),
            eccentricity_angle=float(np.angle(e)),
            drag=ViscousDrag(damping=2e-4),
            balls=tuple(Balls(mass=m, motion="point") for m in masses),
        )
        for masses, e in zip(races, offsets, strict=True)
    ]
    return Machine(
        name="test",
        axis="vertical",
        rotor=PlanarRotor(mass=10.0, stiffness=6e5, damping=100.0),
        unbalances=(Unbalance(moment=unbalance, angle=0.3),),
        balancers=(Balancer(races=tuple(parts)),),
        drive=PrescribedSpeed(profile=Constant(speed=400.0)),
    )


CASES = {
    "two equal": machine([[3e-3, 3e-3]]),
    "two unequal": machine([[3e-3, 4e-3]]),
    "five": machine([[1e-3, 2e-3, 2e-3, 1.5e-3, 3e-3]]),
    "eccentric": machine([[5e-3, 5e-3]], offsets=[4e-5 * np.exp(2j)]),
    "two races, one center": machine([[3e-3, 3e-3], [2e-3, 2e-3]]),
    "two races, two centers": machine([[3e-3, 3e-3], [4e-3]], offsets=[3e-5 + 0j, -2e-5j]),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("speed", [150.0, 400.0])
def test_the_full_equations_rest_in_every_listed_state(name: str, speed: float) -> None:
    described = with_value_at(CASES[name], "drive.profile.speed", speed)
    assembly, p = assemble(described), plane(described)
    states = equilibria_of(p, speed)
    assert states
    n = p.moment.size
    for state in states:
        y = assembly.state.copy()
        v = 1j * speed * state.whirl
        y[[X, Y, VX, VY]] = state.whirl.real, state.whirl.imag, v.real, v.imag
        y[BALLS : BALLS + n], y[BALLS + n :] = state.angles, 0.0
        dy = rates_at(planar, 0.0, y, assembly.system)
        rates = np.delete(dy / assembly.scale, 4) / speed  # less the rotor's own turning
        assert np.abs(rates).max() < 1e-9


def test_no_steady_state_of_two_equal_balls_is_missed() -> None:
    """Found again by Newton from a grid of ball angles."""
    p = plane(CASES["two equal"])
    speed = 150.0
    listed = [np.exp(1j * s.angles) for s in equilibria_of(p, speed)]
    listed += [angles[::-1] for angles in listed]  # the exchange of equal balls
    from scipy.optimize import fsolve

    def torque(angles: np.ndarray) -> np.ndarray:
        load = p.fixed_load + (p.moment * np.exp(1j * angles)).sum()
        z = speed**2 * load / p.dynamic_stiffness(speed)
        return np.imag(np.exp(-1j * angles) * z) * 1e5

    found = 0
    for a in np.linspace(-np.pi, np.pi, 24, endpoint=False):
        for b in np.linspace(-np.pi, np.pi, 24, endpoint=False):
            angles, _, flag, _ = fsolve(torque, [a + 0.01, b], full_output=True)
            if flag == 1 and np.abs(torque(angles)).max() < 1e-9:
                found += 1
                assert min(np.abs(np.exp(1j * angles) - state).max() for state in listed) < 1e-4
    assert found > 300


@pytest.mark.parametrize("name", CASES)
def test_linearized_equations_are_the_derivative_of_the_compiled_ones(name: str) -> None:
    described, speed = CASES[name], 400.0
    assembly, p = assemble(described), plane(described)
    n = p.moment.size
    places = np.array([X, Y, VX, VY, *range(BALLS, BALLS + 2 * n)])
    for state in equilibria_of(p, speed):
        y = assembly.state.copy()
        v = 1j * speed * state.whirl
        y[[X, Y, VX, VY]] = state.whirl.real, state.whirl.imag, v.real, v.imag
        y[BALLS : BALLS + n], y[BALLS + n :] = state.angles, 0.0
        jacobian = np.empty((places.size, places.size))
        for column, place in enumerate(places):
            step = 1e-3 * assembly.scale[place]
            values = []
            for shift in (-2, -1, 1, 2):
                shifted = y.copy()
                shifted[place] += shift * step
                values.append(rates_at(planar, 0.0, shifted, assembly.system)[places])
            jacobian[:, column] = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step)
        values, _ = eigensystem(*matrices(p, speed, state))
        characteristic = [np.linalg.slogdet(jacobian - (v + 30.0) * np.eye(places.size)) for v in values]
        exact = [np.log(np.abs(np.prod(v + 30.0 - values))) for v in values]
        np.testing.assert_allclose([c[1] for c in characteristic], exact, rtol=1e-8)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_closed_form_and_matrices_have_the_same_eigenvalues(count: int) -> None:
    described = machine([[3e-3] * count])
    p, speed = plane(described), 350.0
    state = equilibria_of(p, speed)[0]
    assert state.name == "balanced"
    balancer = PlanarBalancer(p.mass, p.stiffness[0], p.damping[0], count, p.moment[0], p.inertia[0], p.drag[0])
    closed = planar_eigenvalues(balancer, speed, abs(np.exp(2j * state.angles).sum()))
    extra = [0.0] * (count - 2) + [-p.drag[0] / p.inertia[0]] * (count - 2)
    values, _ = eigensystem(*matrices(p, speed, state))
    remaining = list(values)
    for value in [*closed, *extra]:
        nearest = min(remaining, key=lambda other: abs(other - value))
        assert abs(nearest - value) < 1e-6 if value in extra else abs(nearest - value) < 1e-9 * abs(values).max()
        remaining.remove(nearest)
    assert not remaining


def test_floquet_multipliers_of_an_isotropic_machine_are_exponentials_of_the_eigenvalues() -> None:
    described, speed = CASES["eccentric"], 400.0
    p = plane(described)
    for state in equilibria_of(p, speed):
        values, _ = eigensystem(*matrices(p, speed, state))
        found = periodic_state(described, p, speed, state)
        for value in values:
            assert np.abs(found.multipliers - np.exp(value * 2 * np.pi / speed)).min() < 1e-9


@pytest.mark.parametrize("stiffness", [6e5, (5e5, 7e5)])
@pytest.mark.parametrize("speed", [265.0, 450.0])
def test_a_small_disturbance_grows_or_decays_as_the_leading_eigenvalue_says(
    stiffness: float | tuple[float, float], speed: float
) -> None:
    """The run starts along the leading mode and is looked at once a turn."""
    described = with_value_at(CASES["two equal"], "rotor.stiffness", stiffness)
    p = plane(described)
    state = equilibria_of(p, speed)[0]
    if p.isotropic:
        values, vectors = eigensystem(*matrices(p, speed, state))
        leading, mode = values[0], vectors[:, 0]
        z, dz = mode[:2], leading * mode[:2]
        v = dz + speed * np.array([-z[1], z[0]])
        direction = np.concatenate([z, v, mode[2:], leading * mode[2:]])
        rest = np.concatenate([np.zeros(4), state.angles, np.zeros(2)])
    else:
        found = periodic_state(described, p, speed, state)
        multipliers, vectors = np.linalg.eig(derivative(Turn(described, p, speed), found.start))
        first = np.argmax(np.abs(multipliers))
        leading, direction, rest = found.exponents[0], vectors[:, first], found.start
    start = rest + 1e-5 * np.real(direction) / np.abs(direction[4:6]).max()
    groups = tuple(
        Balls(mass=group.mass, motion="point", start_angles=(start[4 + i],), start_speeds=(start[6 + i],))
        for i, group in enumerate(described.balancers[0].races[0].balls)
    )
    described = with_value_at(described, "balancers[1].races[1].balls", groups)
    described = with_value_at(described, "drive.profile.speed", speed)
    described = with_value_at(described, "start", {"deflection": tuple(start[:2]), "velocity": tuple(start[2:4])})
    turn = 2.0 * np.pi / speed
    turns = np.arange(int(1.0 / abs(leading.real) / turn) + 8) * turn
    run = ab.simulate(
        described, duration=float(turns[-1]) + turn, save=SampleTimes(turns), tolerance=1e-13, mass_spread=0.0
    )
    x = run["ball_angle_in_rotor"].values[:, 0] - rest[4]
    # one mode obeys x2 = 2 Re(m) x1 - |m|^2 x0 with the multiplier m of a turn, or x1 = m x0 if it does not swing
    if abs(leading.imag) > 1e-6:
        fit, *_ = np.linalg.lstsq(np.column_stack([x[1:-1], -x[:-2]]), x[2:], rcond=None)
        growth = 0.5 * math.log(fit[1]) / turn
    else:
        growth = math.log(x[-1] / x[0]) / (turns[-1] - turns[0])
    assert growth == pytest.approx(leading.real, rel=1e-3)


def test_modes_are_named_after_what_moves() -> None:
    """Far above the critical speed the free whirl is the rotor's, at the critical speed; the slow modes are the balls'."""
    p, speed = plane(CASES["two equal"]), 1500.0
    values, vectors = eigensystem(*matrices(p, speed, equilibria_of(p, speed)[0]))
    names = [motion_name(vectors[:, i], of_plane(p), values[i], speed) for i in range(values.size)]
    critical = math.sqrt(p.stiffness[0] / p.mass)
    for name, value in zip(names, values, strict=True):
        if abs(abs(value.imag) - (speed - critical)) < 0.01 * speed:
            assert name == "rotor, forward whirl"  # speed - critical in the rotor is + critical in space
        elif abs(abs(value.imag) - (speed + critical)) < 0.01 * speed:
            assert name == "rotor, backward whirl"
        else:
            assert name.startswith("balls, ")
    assert len(set(names)) == 4


def test_balls_balance_from_half_the_unbalance_each_on() -> None:
    """The balanced state of two equal balls exists from m eps = unbalance / 2 on."""
    p = plane(machine([[2.01e-3, 2.01e-3]]))
    assert equilibria_of(p, 400.0)[0].name == "balanced"
    p = plane(machine([[1.99e-3, 1.99e-3]]))
    assert all(state.name != "balanced" for state in equilibria_of(p, 400.0))


def test_states_in_which_balls_of_their_size_would_overlap_are_said_to_be_those_of_points() -> None:
    machine = ab.example("discoidal")
    found = ab.stability.equilibria(machine, "1200 rpm")
    assert found["overlapping"].values.tolist() == [name == "coincident" for name in found["name"].values]
    assert "coincident*" in repr(found)
    assert "balls of this size would overlap" in repr(found)
    passing = with_value_at(machine, "balancers[1].races[1].collisions", False)
    assert not ab.stability.equilibria(passing, "1200 rpm")["overlapping"].any()
    assert "would overlap" not in repr(ab.stability.equilibria(passing, "1200 rpm"))


def test_coincident_and_balanced_exchange_stability_near_the_critical_speed() -> None:
    described = with_value_at(CASES["two equal"], "balancers[1].races[1].drag.damping", 5e-3)
    below, above = ab.stability.equilibria(described, 200.0), ab.stability.equilibria(described, 300.0)
    stable_below = set(below["name"].values[below["verdict"].values == "stable"])
    stable_above = set(above["name"].values[above["verdict"].values == "stable"])
    assert stable_below == {"coincident"}
    assert stable_above == {"balanced"}
    heavy = below.isel(state=int(np.flatnonzero(below["verdict"].values == "stable")[0]))
    assert int(heavy["outward"]) == 2


def test_three_balls_balance_in_a_continuum() -> None:
    found = ab.stability.equilibria(machine([[3e-3] * 3]), 400.0)
    balanced = found.isel(state=0)
    assert str(balanced["name"].values) == "balanced"
    assert int(balanced["freedom"]) == 1
    assert float(balanced["residual_unbalance"]) < 1e-15
    assert str(balanced["verdict"].values) == "stable"  # the zero of the continuum does not count


def test_an_eccentric_race_leaves_its_eccentricity() -> None:
    found = ab.stability.equilibria(CASES["eccentric"], 400.0)
    assert float(found.isel(state=0)["deflection"]) == pytest.approx(4e-5, rel=1e-12)


def test_polygon_closes_or_says_that_it_cannot() -> None:
    lengths = np.array([1.0, 2.0, 2.5, 0.7])
    for target in (0.5 + 1j, -3.0 + 0j, 6.19 + 0j):
        for angles in close_polygon(lengths, target):
            assert (lengths * np.exp(1j * angles)).sum() == pytest.approx(target, abs=1e-12)
    for angles in close_polygon(np.ones(3), 0.2 + 0j):
        assert np.exp(1j * angles).sum() == pytest.approx(0.2, abs=1e-12)
    assert len(close_polygon(np.ones(3), 0.2 + 0j)) == 2
    assert close_polygon(lengths, 6.3 + 0j) == []
    assert close_polygon(np.array([5.0, 1.0]), 1.0 + 0j) == []


def test_balls_too_weak_are_named_with_their_numbers() -> None:
    with pytest.raises(QuestionError, match="the balls can balance 200 g mm at most, the unbalance is 400 g mm"):
        ab.stability.eigenvalues(machine([[1e-3, 1e-3]]), [300.0])


@pytest.mark.parametrize("mass", [10.0, 7.3, 3.1, 0.37])
def test_the_deflection_of_an_undamped_rotor_is_not_determined_at_its_critical_speed(mass: float) -> None:
    described = with_value_at(with_value_at(CASES["two equal"], "rotor.damping", 0.0), "rotor.mass", mass)
    p = plane(described)
    critical = math.sqrt(p.stiffness[0] / p.mass)
    for speed in (critical, math.nextafter(critical, 0.0), math.nextafter(critical, math.inf)):
        with pytest.raises(QuestionError, match="critical speed of an undamped rotor"):
            ab.stability.equilibria(described, speed)
    beside = ab.stability.equilibria(described, critical * (1.0 + 1e-12))
    assert np.isfinite(beside["deflection"].values).all()


def test_gravity_in_the_plane_is_refused_with_a_cure() -> None:
    described = Machine(**{**dict(CASES["two equal"]), "axis": "horizontal"})
    with pytest.raises(QuestionError, match="simulate it instead"):
        ab.stability.equilibria(described, 300.0)


def test_a_rotor_without_balls_has_one_state_and_its_deflection() -> None:
    bare = machine([[3e-3] * 2]).model_copy(update={"balancers": ()})
    found = ab.stability.equilibria(bare, 400.0)
    p = plane(bare)
    assert found["name"].values.tolist() == ["no balls"]
    expected = 400.0**2 * abs(p.unbalance) / abs(p.dynamic_stiffness(400.0))
    assert float(found["deflection"][0]) == pytest.approx(expected, rel=1e-12)

"""The averaged theory of rotors that tilt or bend: against planar rotors, closed forms and the exact equations."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.catalog.resolve import resolve
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.machine import (
    Balancer,
    Balls,
    Constant,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    Race,
    RigidRotor,
    Support,
    Unbalance,
    ViscousDrag,
)
from autobalancer.stability.averaged import (
    averaged_station_eigenvalues,
    averaged_station_growth,
    explicit_averaged_border,
)
from autobalancer.stability.host.stations import of_plane, plane, stations
from autobalancer.stability.maps.balanced import members_of
from autobalancer.stability.maps.exact import averaged_of
from autobalancer.stability.states.linearized import exponents_of
from autobalancer.stability.states.rest_states import StationState, balanced_of

ARM, DRAG = 0.1, 8e-4
RIGHT_ANGLES = np.array([0.25, -0.25, 0.25, -0.25]) * math.pi


def symmetric(polar: float) -> Machine:
    """A rigid rotor with two equal planes and two equal supports at the same distance from its mass center."""
    race = Race(orbit_radius=0.05, drag=ViscousDrag(damping=DRAG), balls=(Balls(mass=0.004, count=2, motion="point"),))
    return Machine(
        name="symmetric",
        axis="vertical",
        rotor=RigidRotor(
            mass=5.0,
            transverse_inertia=0.05,
            polar_inertia=polar,
            supports=tuple(Support(position=z, stiffness=2e4, damping=20.0) for z in (-ARM, ARM)),
        ),
        balancers=tuple(Balancer(station=z, races=(race,)) for z in (-ARM, ARM)),
        drive=PrescribedSpeed(profile=Constant(speed=300.0)),
    )


def with_supports(machine: Machine, along_y: float, damping_y: float = 20.0) -> Machine:
    """A rotor with 20 kN/m along x of each support, and so many times as much along y."""
    supports = [
        Support(position=support.position, stiffness=(2e4, 2e4 * along_y), damping=(20.0, damping_y))
        for support in machine.rotor.supports  # type: ignore[union-attr]
    ]
    return ab.with_parameter(machine, "rotor.supports", supports)


def one_plane_amid(along_y: float, damping_y: float) -> Machine:
    """The rotor with all balls in its middle, where they and the unbalance do not tilt it."""
    machine = with_supports(symmetric(0.03), along_y, damping_y)
    race = machine.balancers[0].races[0]
    heavy = race.model_copy(update={"drag": ViscousDrag(damping=2.0 * DRAG)})
    unbalance = Unbalance(moment=1.5e-4, station=0.0)
    return machine.model_copy(
        update={"balancers": (Balancer(station=0.0, races=(heavy,)),), "unbalances": (unbalance,)}
    )


@pytest.mark.parametrize(("along_y", "damping_y"), [(1.0, 20.0), (1.4, 28.0)])
def test_balls_in_the_middle_of_a_rotor_have_the_averaged_border_of_its_planar_motion(
    along_y: float, damping_y: float
) -> None:
    machine = one_plane_amid(along_y, damping_y)
    rotor = PlanarRotor(mass=5.0, stiffness=(4e4, 4e4 * along_y), damping=(40.0, 2.0 * damping_y), inertia=0.03)
    flat = machine.model_copy(
        update={
            "rotor": rotor,
            "balancers": (Balancer(races=machine.balancers[0].races),),
            "unbalances": (Unbalance(moment=1.5e-4),),
        }
    )
    searched = (89.4, 200.0)  # from the critical speed along x
    planar, found = (ab.stability.averaged_border(one, searched=searched).speed for one in (flat, machine))
    assert searched[0] < planar < searched[1]
    assert found == pytest.approx(planar, rel=1e-9)
    planar, found = (
        ab.stability.averaged_border(one, worst_case=True, searched=searched).speed for one in (flat, machine)
    )
    assert found == pytest.approx(planar, rel=1e-9)
    (border,) = ab.stability.borders(machine, only=("averaged border",))
    assert border.speed == pytest.approx(explicit_averaged_border(flat).speed, rel=1e-9)


def test_supports_that_hardly_differ_have_the_averaged_eigenvalues_of_alike_ones_and_of_the_backward_whirl() -> None:
    machine, w = symmetric(0.03), 150.0
    alike, uneven = (stations(with_supports(machine, along_y)) for along_y in (1.0, 1.0 + 1e-7))
    assert alike.isotropic
    assert not uneven.isotropic
    state = StationState("balanced", RIGHT_ANGLES, np.zeros(2, np.complex128), 0, 0)
    found = averaged_station_eigenvalues(uneven, w, state)
    mass, turning, stiffness = (matrix.conj() for matrix in alike.model.complex_matrices(w))  # it whirls the other way
    held = stiffness + 1j * w * turning - w * w * mass
    backward = np.linalg.eigvals(-np.linalg.solve(2j * w * mass + 1j * turning.imag, held))
    forward = averaged_station_eigenvalues(alike, w, state)
    assert found.size == forward.size + 2 * backward.size
    for value in (*forward, *backward, *backward.conj()):
        assert np.abs(found - value).min() < 1e-5 * w


def test_a_planar_rotor_as_one_station_has_the_averaged_border_of_the_closed_form() -> None:
    p = plane(ab.example("discoidal"))
    assert averaged_of(of_plane(p)).speed == pytest.approx(explicit_averaged_border(p).speed, rel=1e-10)
    uneven = replace(p, moment=p.moment * [1.0, 1.7], drag=p.drag * [1.0, 1.3])
    found = averaged_of(of_plane(replace(uneven, drag=50.0 * uneven.drag)))
    assert found.speed <= explicit_averaged_border(replace(uneven, drag=50.0 * uneven.drag)).speed


@pytest.mark.parametrize("polar", [0.01, 0.03])
def test_the_conical_border_of_two_planes_is_the_root_of_its_own_closed_form(polar: float) -> None:
    st = stations(symmetric(polar))
    tilting = 0.05 + 4 * 0.004 * ARM**2  # with the balls
    stiffness, damping = 2 * 2e4 * ARM**2, 2 * 20.0 * ARM**2
    g = 4 * (0.004 * 0.05) ** 2 / DRAG * ARM**2

    def miss(speed: float) -> float:  # an imaginary eigenvalue i nu for balls at right angles
        nu = (stiffness - speed**2 * (tilting - polar)) / (speed * (2.0 * tilting - polar))
        return -nu * damping - 0.5 * g * speed * (speed + nu) * (speed + 2.0 * nu)

    critical = math.sqrt(stiffness / (tilting - polar))
    border = brentq(miss, critical, 2.0 * critical)
    state = StationState("balanced", RIGHT_ANGLES, np.zeros(2, np.complex128), 0, 0)
    rates = [averaged_station_growth(st, share * border, state) for share in (1.0 - 1e-3, 1.0, 1.0 + 1e-3)]
    assert rates[0] > 1e-6 > abs(rates[1]) > rates[2]
    assert abs(rates[1]) < 1e-8 * border


def test_averaged_and_exact_border_of_two_planes_meet_as_the_drag_grows() -> None:
    machine = ab.example("two_plane_rotor")
    drag, apart = resolve(machine)[0].drag, []
    for factor in (100.0, 1000.0):
        heavy = ab.with_parameter(machine, "drag", factor * drag)
        both = ab.stability.borders(heavy, only=("averaged border", "exact border"))
        averaged, exact = (next(b.speed for b in both if b.name == f"{name} border") for name in ("averaged", "exact"))
        apart.append(abs(averaged / exact - 1.0))
    assert apart[0] < 2e-5
    assert apart[1] < 0.02 * apart[0]  # of second order in the share of the balls


def test_averaged_and_exact_border_meet_as_the_drag_grows_on_uneven_supports_too() -> None:
    machine, apart = with_supports(ab.example("two_plane_rotor"), 1.3), []
    for factor in (100.0, 1000.0):
        heavy = ab.with_parameter(machine, "drag", factor * 2e-4)
        averaged = ab.stability.averaged_border(heavy, searched=(140.0, 160.0)).speed
        (exact,) = members_of(stations(heavy))
        border = brentq(
            lambda w, exact=exact: exact.rates(np.array([w]))[0], 0.99 * averaged, 1.01 * averaged, xtol=1e-9
        )
        apart.append(abs(averaged / border - 1.0))
    assert apart[0] < 2e-5
    assert apart[1] < 0.02 * apart[0]


@pytest.mark.parametrize("speed", [120.0, 150.0, 250.0])
def test_slow_motions_of_balls_on_uneven_supports_grow_as_the_multipliers_over_a_turn_say(speed: float) -> None:
    heavy = ab.with_parameter(with_supports(ab.example("two_plane_rotor"), 1.3), "drag", 0.2)
    st = stations(heavy)
    (state, *_) = balanced_of(st, speed)
    averaged = averaged_station_eigenvalues(st, speed, state)[:4]  # of the balls, the others belong to the rotor
    exact = exponents_of(st, speed, state)
    for value in averaged:
        assert np.abs(exact - value).min() < 2e-3 * abs(value)


def test_the_averaged_border_of_any_rotor_is_where_its_growth_rate_changes_sign() -> None:
    machine = ab.with_parameter(ab.example("two_plane_rotor"), "drag", 0.0125)
    border = ab.stability.averaged_border(machine)
    near = ab.stability.averaged_border(machine, searched=(0.99 * border.speed, 1.01 * border.speed))
    assert near.speed == pytest.approx(border.speed, rel=1e-9)
    assert "at this unbalance" in border.note
    curve = ab.stability.border_curve(machine, "drag", [0.0125, 0.02], only=["averaged border"])
    assert float(curve["averaged_border"][0]) == pytest.approx(border.speed, rel=1e-9)
    assert float(curve["averaged_border"][1]) < border.speed


def test_what_averaging_does_not_know_of_other_rotors_is_refused_in_words() -> None:
    two = ab.example("two_plane_rotor")
    with pytest.raises(QuestionError, match="needs races on the axis of the rotor, in one plane"):
        ab.stability.averaged_border(two, worst_case=True)
    springs = [{"kind": "race_springs", "stiffness": 0.02}]
    with pytest.raises(QuestionError, match="does not know forces on the balls"):
        ab.stability.averaged_border(ab.with_parameter(two, "balancers[1].races[1].forces", springs))


def test_the_command_line_prints_the_averaged_border_of_a_rotor_that_tilts() -> None:
    answer = CliRunner().invoke(
        app, ["borders", "examples/machines/two_plane_rotor.toml", "--only", "averaged border"], env={"COLUMNS": "300"}
    )
    assert "averaged border" in answer.output
    assert "at this unbalance, from the averaged eigenvalue problem" in answer.output
    # stable in a range of speeds and unstable above it: the range stands where else the speed stands
    assert "stable 2005.6 rpm to 3111.6 rpm only" in answer.output
    assert "never" not in answer.output

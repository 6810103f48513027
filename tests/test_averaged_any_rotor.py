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
    DragTorque,
    Machine,
    PrescribedSpeed,
    Race,
    RigidRotor,
    Support,
)
from autobalancer.stability.averaged.equations import averaged_eigenvalues
from autobalancer.stability.averaged.formulas import explicit_averaged_border
from autobalancer.stability.averaged.stations import averaged_station_eigenvalues, averaged_station_growth
from autobalancer.stability.host.planar import plane
from autobalancer.stability.host.stations import of_plane, stations
from autobalancer.stability.maps.averaged import averaged_of
from autobalancer.stability.states.planar import equilibria_of
from autobalancer.stability.states.stations import StationState

ARM, DRAG = 0.1, 8e-4
RIGHT_ANGLES = np.array([0.25, -0.25, 0.25, -0.25]) * math.pi


def symmetric(polar: float) -> Machine:
    """A rigid rotor with two equal planes and two equal supports at the same distance from its mass center."""
    race = Race(orbit_radius=0.05, drag=DragTorque(beta=DRAG), balls=(Balls(mass=0.004, count=2, motion="point"),))
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


@pytest.mark.parametrize("speed", [80.0, 120.0])
def test_a_planar_rotor_as_one_station_has_the_averaged_eigenvalues_of_its_forward_whirl(speed: float) -> None:
    p = plane(ab.example("discoidal"))
    for state in equilibria_of(p, speed):
        of_station = StationState(state.name, state.angles, np.array([state.whirl]), state.freedom, 0)
        found = averaged_station_eigenvalues(of_plane(p), speed, of_station)
        planar = list(averaged_eigenvalues(p, speed, state))
        for value in found:
            planar.pop(int(np.argmin(np.abs(np.array(planar) - value))))
        backward = np.array([-p.damping[0] / (2.0 * p.mass)] * 2)  # the balls do not feel it
        assert np.abs(np.array(planar).real - backward).max() < 1e-9 * speed
        assert np.abs(averaged_eigenvalues(p, speed, state)[:, None] - found[None]).min(0).max() < 1e-8 * speed


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
    supports = [{"position": at, "stiffness": ["20 kN/m", "25 kN/m"], "damping": "20 N*s/m"} for at in (-0.12, 0.12)]
    uneven = ab.with_parameter(two, "rotor.supports", supports)
    with pytest.raises(QuestionError, match="differ along x and y"):
        ab.stability.averaged_border(uneven)
    (border,) = ab.stability.borders(uneven, only=("averaged border",))
    assert math.isnan(border.speed)
    assert not border.known


def test_the_command_line_prints_the_averaged_border_of_a_rotor_that_tilts() -> None:
    answer = CliRunner().invoke(
        app, ["borders", "examples/machines/two_plane_rotor.toml", "--only", "averaged border"], env={"COLUMNS": "300"}
    )
    assert "averaged border" in answer.output
    assert "at this unbalance, from the averaged eigenvalue problem" in answer.output

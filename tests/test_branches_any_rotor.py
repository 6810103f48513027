"""Branches of rotors that tilt or bend: steady states, periodic motions and their borders."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.references.two_balls import specials

import autobalancer as ab
from autobalancer.api import simulate
from autobalancer.assembly.quantities import with_quantity, with_value_at
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine, RigidRotor, Support
from autobalancer.simulation.record import Samples
from autobalancer.stability.branch_diagrams import bifurcation_curves, branches
from autobalancer.stability.host.stations import stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.stalled_orbits import partly_stalled_orbits
from autobalancer.stability.states.linearized import matrices as station_matrices
from autobalancer.stability.states.questions import eigenvalues
from autobalancer.stability.states.rest_states import balanced_of, states_of
from autobalancer.stability.steady_curves import Family, Range, kinds

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
TWO_PLANES = load_race_machine(MACHINES / "two_plane_rotor.toml")
DISCOIDAL = load_race_machine(MACHINES / "discoidal.toml")


SHAFT = rig("cfrp_rig")


def as_rigid(machine: Machine) -> Machine:
    """A planar machine as a rigid rotor on two alike supports, with its balls and unbalance at the mass center."""
    rotor = machine.rotor
    half = [Support(position=z, stiffness=0.5 * rotor.stiffness, damping=0.5 * rotor.damping) for z in (-0.1, 0.1)]
    rigid = RigidRotor(mass=rotor.mass, transverse_inertia=0.05, polar_inertia=0.02, supports=tuple(half))
    balancers = tuple(b.model_copy(update={"station": 0.0}) for b in machine.balancers)
    unbalances = tuple(u.model_copy(update={"station": 0.0}) for u in machine.unbalances)
    return machine.model_copy(update={"rotor": rigid, "balancers": balancers, "unbalances": unbalances})


@pytest.mark.parametrize(("state", "start"), [("balanced", 110.0), ("coincident", 20.0)])
def test_a_planar_machine_written_as_a_rigid_rotor_has_the_planar_branches(state: Any, start: float) -> None:
    machines = DISCOIDAL, as_rigid(DISCOIDAL)
    planar, rigid = (branches(m, "speed", start, 65.06, from_state=state, orbits=False) for m in machines)
    assert planar.sizes["special"] == rigid.sizes["special"] > 0
    assert planar["special_type"].values.tolist() == rigid["special_type"].values.tolist()
    for name in ("special_parameter", "special_frequency", "lyapunov_coefficient", "special_deflection_max"):
        np.testing.assert_allclose(rigid[name], planar[name], rtol=1e-9, atol=1e-14, err_msg=name)


@pytest.mark.parametrize("speed", [95.0, 160.0, 300.0])
def test_the_field_linearized_at_any_steady_state_has_the_eigenvalues_of_its_matrices(speed: float) -> None:
    st = stations(TWO_PLANES)
    field = Field(st, speed)
    for state in states_of(st, speed):
        whirl = st.coordinates(speed, state.angles)
        rate = 1j * speed * whirl
        here = np.concatenate([whirl.real, whirl.imag, rate.real, rate.imag, state.angles, np.zeros(4)])
        np.testing.assert_allclose(field(here), 0.0, atol=1e-9 * speed**2)
        m, c, k = station_matrices(st, speed, state)
        eye, none = np.eye(m.shape[0]), np.zeros_like(m)
        expected = np.linalg.eigvals(np.block([[none, eye], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]]))
        for value in np.linalg.eigvals(field.jacobian(here)):
            assert np.abs(expected - value).min() < 1e-6 * speed


def test_the_first_hopf_point_of_two_planes_is_the_exact_border() -> None:
    (border,) = (b.speed for b in ab.stability.borders(TWO_PLANES) if b.name == "exact border")
    point = specials(branches(TWO_PLANES, "speed", 180.0, 165.0, orbits=False), "Hopf")[0]
    assert float(point["special_parameter"]) == pytest.approx(border, rel=1e-9)
    assert str(point["criticality"].values) == "supercritical"


def test_next_to_the_hopf_point_a_run_grows_as_its_eigenvalue_says() -> None:
    speed = 165.0
    machine = with_value_at(TWO_PLANES, "drive.profile.speed", speed)
    st = stations(machine)
    state = balanced_of(st, speed)[0]
    start = state.angles + 1e-6 * np.array([1.0, -1.0, 1.0, 1.0])
    for number in (1, 2):
        angles = tuple(start[2 * number - 2 : 2 * number])
        machine = with_value_at(machine, f"balancers[{number}].races[1].balls[1].start_angles", angles)
    run = simulate(machine, duration=3.5, save=Samples(7001), tolerance=1e-12, mass_spread=0.0)
    late = run.sel(time=slice(1.5, 3.5))
    swing = late["ball_angle_in_rotor"].values - state.angles
    spun = np.hypot(swing, late["ball_speed_in_rotor"].values / 16.43)  # amplitude of an oscillation of 16.43 rad/s
    slope = np.polyfit(late["time"].values, np.log(spun[:, 0]), 1)[0]
    rate = float(eigenvalues(machine, [speed])["growth_rate"][0])
    assert rate > 2.0
    assert slope == pytest.approx(rate, rel=0.02)


def test_a_small_swing_grows_with_the_root_of_the_distance_from_the_hopf_point() -> None:
    found = branches(TWO_PLANES, "speed", 175.1, 175.0)
    point = specials(found, "Hopf")[0]
    around = float(point["special_parameter"]) + np.array([-5e-4, 5e-4])
    slope = 1e3 * float(np.diff(eigenvalues(TWO_PLANES, around)["growth_rate"])[0])
    orbit = found.isel(point=np.flatnonzero(found["kind"].values == "orbit")[0])
    away = float(orbit["parameter"] - point["special_parameter"])
    swing = 0.5 * float((orbit["ball_angle_in_rotor_max"] - orbit["ball_angle_in_rotor_min"]).max())
    weak = -slope * away / (float(point["special_frequency"]) * float(point["lyapunov_coefficient"]))
    assert swing == pytest.approx(math.sqrt(weak), rel=0.02)


def test_a_branch_too_narrow_to_be_read_is_drawn_again_in_its_own_range() -> None:
    found = branches(TWO_PLANES, "speed", 185.0, 165.0)  # the balls swing over 0.29 rad/s
    swinging = found["parameter"].values[found["branch"].values == 2]
    panel = ab.plot.branches(found, speed_unit="rad/s").axes[-1]
    low, high = panel.get_xlim()
    assert low < swinging.min() < swinging.max() < high
    assert high - low < 1.3 * float(np.ptp(swinging))
    assert panel.get_title(loc="left").startswith("a: branch 2")
    wide = found.isel(point=np.flatnonzero(found["branch"].values == 1))
    assert len(ab.plot.branches(wide).axes) == 2


@pytest.mark.slow
def test_the_curve_of_hopf_points_over_the_drag_is_the_exact_border() -> None:
    curve = bifurcation_curves(TWO_PLANES, "Hopf", "speed", 190.0, 165.0, "drag", 2e-4, 4e-4, largest_step=0.2)
    for place in (0, curve.sizes["point"] // 2, -1):
        machine = with_quantity(TWO_PLANES, "drag", float(curve["second_parameter"][place]))
        (border,) = (b.speed for b in ab.stability.borders(machine) if b.name == "exact border")
        assert float(curve["parameter"][place]) == pytest.approx(border, rel=1e-8)
        assert float(curve["frequency"][place]) > 0.0


def test_balls_of_two_planes_stall_together_up_to_a_fold_near_their_release_speed() -> None:
    found = branches(TWO_PLANES, "speed", 205.0, 214.0, from_state="stalled", largest_step=0.1)
    (fold,) = (float(point["special_parameter"]) for point in specials(found, "fold"))
    (parting,) = (float(point["special_parameter"]) for point in specials(found, "branch point"))
    assert parting == pytest.approx(
        206.7, rel=1e-3
    )  # where the torque balance of all balls together ends, at 151.9 rad/s
    assert parting < fold < 1.02 * parting


def test_a_shaft_of_many_elements_is_followed_in_few_coordinates() -> None:
    whole = stations(SHAFT)
    family = Family(SHAFT, ["speed"])
    (border,) = (b.speed for b in ab.stability.borders(SHAFT) if b.name == "exact border")
    family.reduce(1.1 * border)
    assert family(border).host.model.pairs < whole.model.pairs
    found = branches(SHAFT, "speed", 1.1 * border, 0.95 * border, orbits=False)
    assert float(specials(found, "Hopf")[0]["special_parameter"]) == pytest.approx(border, rel=1e-5)


def test_unbalances_of_a_general_rotor_change_together() -> None:
    family = Family(TWO_PLANES, ["unbalance"], 300.0)
    st = stations(TWO_PLANES)
    np.testing.assert_allclose(family(2.0 * family.now(0)).host.load, 2.0 * st.load, rtol=1e-13)
    couple = with_value_at(TWO_PLANES, "unbalances[1].moment", 1e-12)
    bare = couple.model_copy(update={"unbalances": couple.unbalances[1:]})
    with pytest.raises(QuestionError, match="no resultant"):
        Family(bare, ["unbalance"], 300.0)(1e-4)


def test_balls_that_stall_in_a_run_up_turn_as_their_branch_says() -> None:
    machine = TWO_PLANES
    for number in (1, 2):  # points do not touch; real balls stand side by side where these coincide
        balls = [{"count": 2, "mass": "4.084 g", "motion": "point"}]
        machine = with_value_at(machine, f"balancers[{number}].races[1].balls", balls)
    found = branches(machine, "speed", 180.0, 190.0, from_state="stalled", largest_step=0.1)
    orbit = found.isel(point=int(np.argmin(found["parameter"].values)))  # the end of the branch where the balls hang
    assert str(orbit["verdict"].values) == "stable"
    machine = with_value_at(machine, "drive.profile", {"kind": "ramp", "end": 180.0, "duration": 6.0})
    run = simulate(machine, duration=14.0, save=Samples(14001))
    late = run.isel(time=slice(-round(1e3 * 20 * float(orbit["period"])) - 1, None))  # twenty periods
    angles = late["ball_angle_in_rotor"].values
    slip = (angles[-1] - angles[0]) / float(late["time"][-1] - late["time"][0])
    np.testing.assert_allclose(180.0 + slip, orbit["ball_speed_in_space"].values, rtol=1e-5)
    for bound, end in ((late["deflection"].min(), "min"), (late["deflection"].max(), "max")):
        assert float(bound) == pytest.approx(float(orbit[f"station_deflection_{end}"][0]), rel=1e-5)


def hanging_alone(speed: float) -> Machine:
    """Two planes with point balls, little drag and an unbalance that holds the lower balls while the upper ones hang."""
    machine = with_value_at(TWO_PLANES, "unbalances[1]", {"moment": 3e-4, "angle": 0.349, "station": 0.0})
    for number in (1, 2):
        balls = [{"count": 2, "mass": "4.084 g", "motion": "point"}]
        machine = with_value_at(machine, f"balancers[{number}].races[1].balls", balls)
    return with_value_at(with_quantity(machine, "drag", 1e-4), "drive.profile", {"kind": "constant", "speed": speed})


@pytest.mark.slow
def test_balls_of_one_plane_hang_alone_above_the_speed_at_which_runs_begin_to_hold_the_others() -> None:
    speed = 252.0
    found = branches(hanging_alone(speed), "speed", speed, 247.0, from_state="partly stalled", largest_step=0.1)
    (onset,) = (float(point["special_parameter"]) for point in specials(found, "fold"))
    assert 248.0 < onset < 250.0
    orbit = found.isel(point=int(np.argmax(np.where(found["verdict"] == "stable", found["parameter"], 0.0))))
    assert float(orbit["parameter"]) == pytest.approx(speed)
    assert str(orbit["name"].values) == "partly stalled"
    low, high = (orbit[f"ball_angle_in_rotor_{end}"].values for end in ("min", "max"))
    middle, turning = 0.5 * (low + high), np.isnan(low)
    assert turning.tolist() == [False, False, True, True]
    drifts = []
    for at in (speed, 246.0):
        machine = hanging_alone(at)
        for number in (1, 2):
            balls = slice(2 * number - 2, 2 * number)
            group = {"count": 2, "mass": "4.084 g", "motion": "point"}
            group["start_angles"] = np.where(turning, 0.0, middle)[balls].tolist()
            group["start_speeds"] = np.where(turning, orbit["ball_speed_in_space"] - speed, 0.0)[balls].tolist()
            machine = with_value_at(machine, f"balancers[{number}].races[1].balls", [group])
        run = simulate(machine, duration=40.0, save=Samples(40001), mass_spread=0.0)
        late = run["ball_angle_in_rotor"].isel(time=slice(-round(1e3 * 60 * float(orbit["period"])) - 1, None))
        last = run["ball_angle_in_rotor"].isel(time=slice(20000, None)).values
        drifts.append(last[-1] - last[0])
        if at == speed:
            slip = (late.values[-1] - late.values[0]) / float(late["time"][-1] - late["time"][0])
            np.testing.assert_allclose(speed + slip, orbit["ball_speed_in_space"], rtol=1e-4)
            np.testing.assert_allclose(late.values[:, :2].min(axis=0), low[:2], atol=5e-3)
            np.testing.assert_allclose(late.values[:, :2].max(axis=0), high[:2], atol=5e-3)
    assert np.abs(drifts[0][:2]).max() < 0.2  # a swing
    assert drifts[1][:2].max() < -1.0  # both fall behind the rotor


def test_balls_that_hang_alone_are_back_after_a_period_but_for_a_turn_and_the_others_too() -> None:
    machine = hanging_alone(252.0)
    span = Range(Family(machine, ["speed"]), 252.0, 251.0)
    kind = kinds([span.whole(0.0).host])
    ((problem, u),) = partly_stalled_orbits(span, kind, (2, 3), 0.0, 30)
    assert problem.groups == ((2, 3), (0,), (1,))
    field, states = span.field(0.0, problem.groups), problem.states(u) * problem.scale
    end = solve_ivp(
        lambda _, x: field(x), (0.0, problem.period(u)), states[0], method="DOP853", rtol=1e-11, atol=1e-14
    ).y[:, -1]
    turned = np.zeros(states.shape[1])
    turned[field.rotor] = -2.0 * math.pi
    np.testing.assert_allclose((end - states[0] - turned) / problem.scale, 0.0, atol=1e-6)
    assert not problem.orbit(u).unstable


@pytest.mark.slow
def test_resting_balls_that_nothing_holds_have_no_limit_cycle_beside_those_that_hang() -> None:
    with pytest.raises(QuestionError, match=r"drift around it.*simulate"):
        branches(TWO_PLANES, "speed", 229.0, 230.0, from_state="partly stalled")

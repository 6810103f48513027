"""Unbalance response: closed forms, direct integration, whirl, measures."""

from __future__ import annotations

import cmath
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.test_rotordynamics_modes import ARM, MASS, POLAR, RIG, SPRING, TRANSVERSE, planar, rigid

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Machine, Unbalance
from autobalancer.results.store import load_run, save_run
from autobalancer.rotordynamics.natural_modes import Whirl, greatest_mean, mean_of_greatest, whirl
from autobalancer.rotordynamics.response import whirl_orbits

RPM = math.pi / 30.0
SIZE = 40e-6 * cmath.exp(0.7j)  # kg m
POINT = Unbalance(moment=40e-6, angle=0.7, station=0.05)
COUPLE = Unbalance(couple=2e-6, angle=-1.1)


def complex_of(found: Any, name: str) -> np.ndarray:
    return np.asarray(found[f"{name}_real"].values + 1j * found[f"{name}_imag"].values)


def integrated(speed: float, turns: int = 60) -> np.ndarray:
    """(theta, x, y at both bearings) of the last turn of Rodrigues' rig from his equation (1), written out anew."""
    mass, transverse, polar, k_x, k_y, c = 1.28, 0.0138, 0.00124, 21500.0, 15800.0, 2.5e-4
    arms, eccentric = (0.11, -0.15), 29e-6 * cmath.exp(1j * math.radians(224.0))
    chi = 6.8e-5 * (transverse - polar)

    def rates(t: float, s: np.ndarray) -> np.ndarray:
        x, tilt_y, y, tilt_x, vx, w_y, vy, w_x = s  # tilts: phi_Y, phi_X
        force_x = force_y = torque_y = torque_x = 0.0
        for arm in arms:
            f_x = -k_x * (x + arm * tilt_y + c * (vx + arm * w_y))
            f_y = -k_y * (y - arm * tilt_x + c * (vy - arm * w_x))
            force_x, force_y = force_x + f_x, force_y + f_y
            torque_y, torque_x = torque_y + arm * f_x, torque_x - arm * f_y
        turn = cmath.exp(1j * speed * t)
        driven, couple = mass * speed**2 * eccentric * turn, chi * speed**2 * turn
        return np.array([
            vx, w_y, vy, w_x,
            (force_x + driven.real) / mass,
            (torque_y + speed * polar * w_x + couple.real) / transverse,
            (force_y + driven.imag) / mass,
            (torque_x - speed * polar * w_y - couple.imag) / transverse,
        ])  # fmt: skip

    end = turns * 2.0 * math.pi / speed
    theta = np.linspace((turns - 1) * 2.0 * math.pi, turns * 2.0 * math.pi, 181)
    run = solve_ivp(rates, (0.0, end), np.zeros(8), method="DOP853", rtol=1e-10, atol=1e-14, t_eval=theta / speed)
    x, tilt_y, y, tilt_x = run.y[:4]
    return np.array([theta, *(p for arm in arms for p in (x + arm * tilt_y, y - arm * tilt_x))])


# closed forms


@pytest.mark.parametrize("speed", [20.0, 63.0, 64.0, 200.0])
def test_the_planar_rotor_answers_as_an_oscillator(speed: float) -> None:
    found = ab.rotor.response(planar(), [speed], unbalance=SIZE)
    expected = speed**2 * SIZE / (12e3 - 3.0 * speed**2 + 20j * speed)
    assert complex_of(found, "x")[0, 0] == pytest.approx(expected, rel=1e-12)
    assert complex_of(found, "y")[0, 0] == pytest.approx(-1j * expected, rel=1e-12)
    assert found["phase"].item() == pytest.approx(cmath.phase(expected / SIZE), rel=1e-12)
    assert found["x_phase"].item() == found["y_phase"].item() == pytest.approx(found["phase"].item(), rel=1e-12)
    assert found["phase"].item() < 0.0


def test_a_rigid_rotor_answers_to_unbalance_and_couple_as_its_complex_equations() -> None:
    machine, arms = rigid(damping=25.0, arms=(-0.15, ARM)), np.array([-0.15, ARM])
    found = ab.rotor.response(machine, [50.0, 180.0, 900.0], [0.3], [POINT, COUPLE])
    for i, w in enumerate((50.0, 180.0, 900.0)):
        spring = SPRING + 25j * w
        matrix = spring * np.array([[2.0, arms.sum()], [arms.sum(), (arms**2).sum()]])
        matrix = matrix - w**2 * np.diag([MASS, TRANSVERSE - POLAR])
        load = SIZE * np.array([1.0, 0.05]) + 2e-6 * cmath.exp(-1.1j) * np.array([0.0, 1.0])
        expected = np.array([1.0, 0.3]) @ np.linalg.solve(matrix, w**2 * load)
        assert complex_of(found, "x")[i, 0] == pytest.approx(expected, rel=1e-11)


def test_an_isotropic_rotor_whirls_forward_on_circles_only() -> None:
    found = ab.rotor.response(rigid(damping=25.0), np.linspace(1.0, 900.0, 50), [-0.2, 0.0, 0.1], [POINT, COUPLE])
    assert (found["whirl"].values == "forward").all()
    assert (found["backward"].values == 0.0).all()
    assert (found["semi_major"].values == found["semi_minor"].values).all()
    assert (found["inclination"].values == 0.0).all()


def test_turning_the_unbalance_turns_the_response() -> None:
    machine = rigid(stiffness=(SPRING, 0.6 * SPRING), damping=25.0)
    here = ab.rotor.response(machine, [170.0], [0.1], POINT)
    there = ab.rotor.response(machine, [170.0], [0.1], POINT.model_copy(update={"angle": 0.7 + 1.3}))
    assert complex_of(there, "x") == pytest.approx(complex_of(here, "x") * cmath.exp(1.3j), rel=1e-12)
    for name in ("phase", "x_phase", "y_phase", "semi_major", "semi_minor", "inclination"):
        assert there[name].values == pytest.approx(here[name].values, rel=1e-9)


def test_turning_the_supports_by_a_right_angle_turns_the_orbit() -> None:
    flat, upright = ((SPRING, 0.6 * SPRING), (0.6 * SPRING, SPRING))
    one = ab.rotor.response(rigid(stiffness=flat, damping=25.0), [170.0], [0.1], POINT)
    quarter = POINT.model_copy(update={"angle": 0.7 + math.pi / 2.0})
    other = ab.rotor.response(rigid(stiffness=upright, damping=25.0), [170.0], [0.1], quarter)
    assert complex_of(other, "y") == pytest.approx(complex_of(one, "x"), rel=1e-12)
    assert complex_of(other, "x") == pytest.approx(-complex_of(one, "y"), rel=1e-12)
    turned = one["inclination"].item() + math.pi / 2.0
    assert math.remainder(other["inclination"].item() - turned, math.pi) == pytest.approx(0.0, abs=1e-12)


def test_the_dampers_take_the_power_that_the_unbalance_brings() -> None:
    machine, w = rigid(stiffness=(SPRING, 0.6 * SPRING), damping=(25.0, 40.0)), 190.0
    found = ab.rotor.response(machine, [w], [-ARM, ARM, 0.05], POINT)
    x, y = complex_of(found, "x")[0], complex_of(found, "y")[0]
    lost = 0.5 * w**2 * (25.0 * np.abs(x[:2]) ** 2 + 40.0 * np.abs(y[:2]) ** 2).sum()
    force = w**2 * SIZE
    brought = 0.5 * (force * np.conj(1j * w * x[2]) + (-1j * force) * np.conj(1j * w * y[2])).real
    assert brought == pytest.approx(lost, rel=1e-12)


def test_the_rotor_follows_the_unbalance_below_and_opposes_it_above_the_critical_speed() -> None:
    critical = math.sqrt(4e3)
    found = ab.rotor.response(planar(damping=0.02), [0.2 * critical, 0.99 * critical, 1.01 * critical, 9.0 * critical],
                               unbalance=SIZE)  # fmt: skip
    assert np.degrees(found["phase"].values[:, 0]) == pytest.approx([0.0, 0.0, -180.0, -180.0], abs=3.0)
    damped = ab.rotor.response(planar(), [critical], unbalance=SIZE)
    assert damped["phase"].item() == pytest.approx(-math.pi / 2.0, rel=1e-9)


def test_far_above_the_critical_speeds_the_rotor_turns_about_its_mass_center() -> None:
    found = ab.rotor.response(rigid(0.001, damping=5.0), [1e6], [0.0], Unbalance(moment=SIZE.real, station=0.0))
    assert complex_of(found, "x").item() == pytest.approx(-SIZE.real / MASS, rel=1e-5)


def test_between_split_critical_speeds_the_whirl_is_backward() -> None:
    machine = planar(stiffness=[12e3, 27e3], damping=0.5)
    low, high = math.sqrt(4e3), math.sqrt(9e3)
    found = ab.rotor.response(machine, [0.9 * low, 1.1 * low, 0.9 * high, 1.1 * high], unbalance=1e-4)
    assert list(found["whirl"].values[:, 0]) == ["forward", "backward", "backward", "forward"]
    orbit = whirl_orbits(machine, 1.1 * low, unbalance=1e-4)
    x, y = orbit["x"].values[0], orbit["y"].values[0]
    assert (x[:-1] * np.diff(y) - y[:-1] * np.diff(x) < 0.0).all()


def test_the_orbit_leans_to_one_side_at_all_speeds_where_one_support_is_the_softer() -> None:
    """Damping and forward rotation leave one sign only: Re(X conj Y) has that of -sin of the difference of the lags."""
    found = ab.rotor.response(planar(stiffness=[27e3, 12e3]), np.linspace(5.0, 400.0, 200), unbalance=1e-4)
    assert (found["inclination"].values[1:] * -1.0 > 0.0).all()


# a rig


@pytest.mark.parametrize("rpm", [1300.0, 1600.0, 1910.0, 2285.0, 4500.0])
def test_the_response_is_what_direct_integration_ends_in(rpm: float) -> None:
    theta, *motion = integrated(rpm * RPM, turns=int(rpm / 60.0 * 8.0))
    found = ab.rotor.response(RIG, [rpm * RPM], ["B1", "B2"])
    turn = np.exp(1j * theta)
    lines = [(complex_of(found, name)[0, p] * turn).real for p in range(2) for name in "xy"]
    size = np.abs(motion).max()
    assert np.abs(np.array(lines) - np.array(motion)).max() < 1e-6 * size
    radii = np.hypot(motion[0], motion[1]), np.hypot(motion[2], motion[3])
    assert found["mean_of_greatest"].item() == pytest.approx(0.5 * (radii[0].max() + radii[1].max()), rel=3e-4)
    assert found["greatest_mean"].item() == pytest.approx((0.5 * (radii[0] + radii[1])).max(), rel=3e-4)
    turning = [motion[2 * p] @ np.gradient(motion[2 * p + 1]) - motion[2 * p + 1] @ np.gradient(motion[2 * p])
               for p in range(2)]  # fmt: skip
    assert list(found["whirl"].values[0]) == ["forward" if area > 0.0 else "backward" for area in turning]


def test_the_two_measures_differ_where_the_bearings_peak_at_different_moments() -> None:
    found = ab.rotor.response(RIG, [500.0 * RPM, 2000.0 * RPM], ["B1", "B2"])
    ratio = found["mean_of_greatest"].values / found["greatest_mean"].values
    assert 1.0 <= ratio[0] < 1.005
    assert ratio[1] > 1.2
    alone = ab.rotor.response(RIG, [2000.0 * RPM], "B1")
    assert alone["greatest_mean"].item() == pytest.approx(alone["semi_major"].item(), rel=1e-12)


def test_velocity_and_acceleration_are_the_rates_of_the_displacement() -> None:
    speeds = np.array([100.0, 200.0])
    x, v, a = (complex_of(ab.rotor.response(RIG, speeds, quantity=q), "y")  # type: ignore[arg-type]
               for q in ("displacement", "velocity", "acceleration"))  # fmt: skip
    assert v == pytest.approx(1j * speeds[:, None] * x, rel=1e-13)
    assert a == pytest.approx(-(speeds[:, None] ** 2) * x, rel=1e-13)
    assert ab.rotor.response(RIG, speeds, quantity="velocity")["semi_major"].attrs["units"] == "m/s"


def test_balls_at_rest_opposite_to_the_unbalance_balance_a_plane() -> None:
    machine = with_value_at(planar(), "balancers", [{"races": [{
        "orbit_radius": 0.1, "drag": {"law": "viscous", "damping": 1e-4},
        "balls": [{"mass": 2e-3, "motion": "point", "count": 2}],
    }]}])  # fmt: skip
    angle = math.acos(-3e-4 / (2.0 * 2e-4))
    left = ab.rotor.response(machine, [100.0], unbalance=3e-4, ball_angles=[angle, -angle])
    plain = ab.rotor.response(machine, [100.0], unbalance=3e-4)
    assert left["semi_major"].item() < 1e-12 * plain["semi_major"].item()
    heavy = ab.rotor.response(machine, [100.0], unbalance=3e-4, balls=True)
    expected = 100.0**2 * 3e-4 / (12e3 - 3.004 * 100.0**2 + 2000j)
    assert complex_of(heavy, "x").item() == pytest.approx(expected, rel=1e-12)
    added = ab.rotor.response(machine, [100.0], unbalance=3e-4, ball_angles=[0.0, 0.0])
    assert complex_of(added, "x").item() == pytest.approx(expected * 7.0 / 3.0, rel=1e-12)


def test_a_standing_rotor_does_not_whirl() -> None:
    found = ab.rotor.response(RIG, [0.0])
    assert (found["semi_major"].values == 0.0).all()
    assert (found["whirl"].values == "straight").all()


def test_orbits_are_the_response_over_a_turn() -> None:
    speed = 1675.0 * RPM
    found, orbit = ab.rotor.response(RIG, [speed]), whirl_orbits(RIG, speed)
    turn = np.exp(1j * orbit["rotor_angle"].values)
    for name in "xy":
        assert orbit[name].values == pytest.approx((complex_of(found, name)[0][:, None] * turn).real, abs=1e-18)
    assert orbit["x"].values[:, -1] == pytest.approx(orbit["x"].values[:, 0], rel=1e-9)
    ends = orbit["place"].values
    assert (ends[0], ends[-1]) == (-0.15, 0.11)
    assert orbit["axis_x"].values[[-1, 0]] == pytest.approx(orbit["x"].values[:2], abs=1e-15)
    fine = whirl_orbits(RIG, speed, points=20001)
    reach = np.hypot(fine["x"].values, fine["y"].values)
    assert orbit["semi_major"].values == pytest.approx(reach.max(axis=1), rel=1e-7)
    assert orbit["semi_minor"].values == pytest.approx(reach.min(axis=1), rel=1e-5)
    top = np.argmax(reach, axis=1)
    lean = [math.atan2(fine["y"].values[p, i], fine["x"].values[p, i]) for p, i in enumerate(top)]
    assert np.sin(orbit["inclination"].values - lean) == pytest.approx(np.zeros(3), abs=2e-3)


def test_the_greatest_mean_is_found_between_its_samples() -> None:
    random = np.random.default_rng(3)
    x, y = (random.normal(size=(40, 3)) + 1j * random.normal(size=(40, 3)) for _ in range(2))
    ellipses: Whirl = whirl(x, y)
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 40001))
    radii = np.hypot((x[..., None] * turn).real, (y[..., None] * turn).real)
    assert greatest_mean(ellipses) == pytest.approx(radii.mean(axis=1).max(axis=-1), rel=1e-7)
    assert mean_of_greatest(ellipses) == pytest.approx(radii.max(axis=-1).mean(axis=-1), rel=1e-7)
    assert (greatest_mean(ellipses) <= mean_of_greatest(ellipses)).all()


def test_the_response_can_be_saved_and_names_its_units(tmp_path: Path) -> None:
    found = ab.rotor.response(RIG, [100.0, 150.0])
    for name in found.data_vars:
        assert found[name].attrs["long_name"]
        assert "units" in found[name].attrs
    back = load_run(save_run(found, tmp_path / "response.nc"))
    assert back.drop_attrs().equals(found.drop_attrs())


def bare() -> Machine:
    return with_value_at(RIG, "unbalances", ())


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: ab.rotor.response(RIG, []), "speeds: given none"),
        (lambda: ab.rotor.response(RIG, [-5.0]), "given -5 rad/s"),
        (lambda: ab.rotor.response(RIG, [math.inf]), "must be finite"),
        (lambda: ab.rotor.response(RIG, [5.0], []), "stations: given none"),
        (lambda: ab.rotor.response(RIG, [5.0], ["B7"]), "no station is named 'B7'"),
        (lambda: ab.rotor.response(bare(), [5.0]), "no unbalance"),
        (lambda: ab.rotor.response(RIG, [5.0], unbalance=math.nan), "must be finite, in kg m"),
        (lambda: ab.rotor.response(RIG, [5.0], quantity="jerk"), "given 'jerk'"),  # type: ignore[arg-type]
        (lambda: ab.rotor.response(RIG, [5.0], ball_angles=[0.0]), "given 1 for 2 balls"),
        (lambda: ab.rotor.response(planar(stiffness=12.0, damping=0.0), [2.0], unbalance=1e-3), "critical speed"),
        (lambda: whirl_orbits(RIG, 5.0, points=3), "given 3"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(ask: Any, message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ask()


def test_a_place_off_a_planar_rotor_is_refused() -> None:
    with pytest.raises(MachineError, match="one plane only"):
        ab.rotor.response(planar(), [5.0], [0.1], unbalance=1e-3)

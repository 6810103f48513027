"""The rig of rigid bodies: closed forms, limits and symmetries of its matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from autobalancer.assembly.rotors import lateral_model, station_rows, with_ball_mass
from autobalancer.assembly.rotors.critical import critical_speeds
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.assembly.rotors.rig import multibody
from autobalancer.assembly.rotors.rigid import rigid
from autobalancer.errors import MachineError
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.machine import (
    BallBearing,
    Body,
    Bushing,
    Dashpot,
    Lock,
    MultibodyRotor,
    RigidRotor,
    SpeedTable,
    Spring,
    Support,
)

DISCOIDAL = rig("discoidal_rig")
TO_GROUND = ("a", "ground")
G = 9.80665


def body(name: str, mass: float, jt: float, jp: float, z: float, turns: bool = True, **more: Any) -> Body:
    return Body(name=name, mass=mass, transverse_inertia=jt, polar_inertia=jp, position=z, rotating=turns, **more)


def model(bodies: list[Body], joints: list[Any], gravity: float = 0.0, **more: Any) -> LateralModel:
    return multibody(MultibodyRotor(bodies=bodies, joints=joints, **more), gravity)


def lateral(m: LateralModel) -> np.ndarray:
    """Undamped angular frequencies of the x part at rest."""
    n = m.pairs
    return np.sqrt(eigh(m.stiffness[0][:n, :n], m.mass[:n, :n], eigvals_only=True))


def same(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> None:
    np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance * np.abs(b).max())


def motor(angle: float = 0.0, count: int = 3, **more: Any) -> tuple[list[Body], list[Any]]:
    """A disc in two bearings of a housing on bushings; all damped."""
    bodies = [body("disc", 4.0, 0.017, 0.033, 0.14), body("housing", 7.0, 0.03, 0.027, -0.02, turns=False)]
    joints: list[Any] = [
        BallBearing(between=("disc", "housing"), position=0.07, stiffness=2e6, damping=30, axial_stiffness=3e6),
        BallBearing(between=("disc", "housing"), position=-0.05, stiffness=1e6, damping=20),
        Bushing(
            between=("housing", "ground"), position=-0.03, count=count, radius=0.1, angle=angle, shear_stiffness=16e3,
            shear_damping=20, axial_stiffness=9e4, axial_damping=130, **more,
        ),
    ]  # fmt: skip
    return bodies, joints


# limits -----------------------------------------------------------------------------------------------------------------


def test_one_body_on_two_supports_is_the_rigid_rotor() -> None:
    expected = rigid(
        RigidRotor(
            mass=3.0, transverse_inertia=0.02, polar_inertia=0.03,
            supports=[Support(position=-0.1, stiffness=(1e4, 2e4), damping=(5, 6)),
                      Support(position=0.2, stiffness=3e4, damping=7, tilt_stiffness=40, tilt_damping=2)],
        )
    )  # fmt: skip
    found = model(
        [body("a", 3.0, 0.02, 0.03, 0.5)],
        [Spring(between=TO_GROUND, position=0.4, stiffness=(1e4, 2e4), damping=(5, 6)),
         Spring(between=TO_GROUND, position=0.7, stiffness=3e4, damping=7, tilt_stiffness=40, tilt_damping=2)],
    )  # fmt: skip
    for name in ("mass", "gyroscopic", "damping", "stiffness"):
        same(getattr(found, name), getattr(expected, name))
    rows = found.axis.rows(0.7, None)
    same(np.append(rows.deflection, rows.slope), np.array([1.0, 0.2, 0.0, 1.0]))


def test_locked_bodies_are_one_body_by_the_parallel_axis_theorem() -> None:
    bodies = [body("a", 2.0, 0.01, 0.004, 0.1), body("b", 3.0, 0.02, 0.03, 0.3), body("c", 1.0, 0.0, 0.0, -0.2)]
    joints = [
        Lock(between=("a", "b")), Lock(between=("c", "a")),
        Spring(between=("b", "ground"), position=0.0, stiffness=1e4),
        Spring(between=("c", "ground"), position=0.3, stiffness=2e4),
    ]  # fmt: skip
    center = (0.2 + 0.9 - 0.2) / 6.0
    across = 0.03 + 2.0 * (0.1 - center) ** 2 + 3.0 * (0.3 - center) ** 2 + 1.0 * (-0.2 - center) ** 2
    one = [
        Spring(between=TO_GROUND, position=0.0, stiffness=1e4),
        Spring(between=TO_GROUND, position=0.3, stiffness=2e4),
    ]
    found, expected = model(bodies, joints), model([body("a", 6.0, across, 0.034, center)], one)
    for name in ("mass", "gyroscopic", "stiffness"):
        same(getattr(found, name), getattr(expected, name))
    assert found.polar_inertia == pytest.approx(0.034)
    assert found.total_mass == pytest.approx(6.0)


def test_a_locked_bearing_is_the_limit_of_a_stiff_one() -> None:
    bodies, joints = motor()
    merged = lateral(model(bodies, [Lock(between=("disc", "housing")), joints[2]]))
    differences = []
    for stiffness in (1e8, 1e9):
        stiff = [
            BallBearing(between=("disc", "housing"), position=z, stiffness=stiffness, axial_stiffness=1e9)
            for z in (0.07, -0.05)
        ]
        differences.append(np.abs(lateral(model(bodies, [*stiff, joints[2]]))[:2] / merged - 1.0).max())
    assert differences[1] < 1e-4
    assert differences[0] / differences[1] == pytest.approx(10.0, rel=0.01)  # compliance counts to first order


def test_a_body_locked_off_the_axis_turns_with_its_carrier() -> None:
    carrier = body("a", 2.0, 0.02, 0.03, 0.0, turns=False)
    rotor = body("r", 1.0, 0.01, 0.01, 0.0)
    weight = body("w", 0.5, 0.0, 0.0, 0.0, turns=False, offset=(0.3, 0.4))
    ring = Bushing(between=TO_GROUND, position=0.0, count=3, radius=0.1, shear_stiffness=1e4, axial_stiffness=3e4)
    m = model([carrier, rotor, weight], [Lock(between=("a", "r")), Lock(between=("a", "w")), ring])
    turning = m.coordinates.index("turning of a + r + w")
    assert m.mass[turning, turning] == pytest.approx(0.03 + 0.5 * 0.25, rel=1e-12)
    assert m.mass[turning, 0] == pytest.approx(-0.5 * 0.4, rel=1e-12)
    assert m.mass[turning, m.pairs] == pytest.approx(0.5 * 0.3, rel=1e-12)
    assert not m.isotropic


def test_a_body_that_is_not_round_resists_each_tilt_with_its_own_inertia() -> None:
    box = Body(name="h", mass=7.0, position=0.0, inertia=(0.02, 0.03, 0.04))
    ring = Bushing(between=("h", "ground"), position=0.0, count=3, radius=0.1, shear_stiffness=1e4, axial_stiffness=3e4)
    m = model([body("a", 1.0, 0.01, 0.01, 0.0), box], [Lock(between=("a", "h")), ring])
    np.testing.assert_allclose(np.diag(m.mass), [8.0, 0.04, 8.0, 0.03, 8.0, 0.04], rtol=1e-12)  # toward x is about y


# closed forms -------------------------------------------------------------------------------------------------------------


def test_two_masses_between_springs_have_the_frequencies_of_the_textbook() -> None:
    bodies = [body("a", 2.0, 0.02, 0.03, 0.0), body("b", 2.0, 0.02, 0.03, 0.0, turns=False)]
    spring = {"stiffness": 5e3, "tilt_stiffness": 100.0}
    joints = [
        Spring(between=("a", "ground"), position=0.0, **spring),
        Spring(between=("a", "b"), position=0.0, **spring),
        Spring(between=("b", "ground"), position=0.0, **spring),
    ]
    expected = np.sort(np.sqrt([5e3 / 2.0, 3 * 5e3 / 2.0, 100.0 / 0.02, 3 * 100.0 / 0.02]))
    np.testing.assert_allclose(lateral(model(bodies, joints)), expected, rtol=1e-12)


@pytest.mark.parametrize("count", [3, 4, 7])
def test_a_ring_of_bushings_has_the_stiffness_of_its_sums(count: int) -> None:
    shear, axial, radius, height = 16e3, 9e4, 0.1, -0.03
    ring = Bushing(
        between=("h", "ground"), position=height, count=count, radius=radius, angle=0.4, shear_stiffness=shear,
        axial_stiffness=axial, bending_stiffness=11.0, torsional_stiffness=7.0,
    )  # fmt: skip
    m = model(
        [body("a", 4.0, 0.02, 0.03, 0.0), body("h", 7.0, 0.03, 0.03, 0.0, turns=False)],
        [Lock(between=("a", "h")), ring],
    )
    k = m.stiffness[0]
    assert m.isotropic
    assert k[0, 0] == pytest.approx(count * shear, rel=1e-12)
    assert k[0, 1] == pytest.approx(count * shear * height, rel=1e-12)
    tilt = count * (axial * radius**2 / 2 + shear * height**2 + 11.0)
    assert k[1, 1] == pytest.approx(tilt, rel=1e-12)
    assert k[4, 4] == pytest.approx(count * axial, rel=1e-12)
    assert k[5, 5] == pytest.approx(count * (shear * radius**2 + 7.0), rel=1e-12)


def test_two_bushings_are_not_isotropic() -> None:
    assert model(*motor(count=3, bending_stiffness=50.0)).isotropic
    assert not model(*motor(count=2, bending_stiffness=50.0)).isotropic


def test_inclined_bushings_share_their_stiffness_between_the_directions() -> None:
    angle, along, across = 0.5, 9e4, 16e3
    ring = Bushing(
        between=("h", "ground"), position=0.0, count=4, radius=0.1, direction=(np.sin(angle), 0.0, np.cos(angle)),
        shear_stiffness=across, axial_stiffness=along,
    )  # fmt: skip
    m = model(
        [body("a", 4.0, 0.02, 0.03, 0.0), body("h", 7.0, 0.03, 0.03, 0.0, turns=False)],
        [Lock(between=("a", "h")), ring],
    )
    radial = along * np.sin(angle) ** 2 + across * np.cos(angle) ** 2
    upright = along * np.cos(angle) ** 2 + across * np.sin(angle) ** 2
    shared = (along - across) * np.sin(angle) * np.cos(angle)
    assert m.stiffness[0][0, 0] == pytest.approx(2.0 * (radial + across), rel=1e-12)
    assert m.stiffness[0][4, 4] == pytest.approx(4.0 * upright, rel=1e-12)
    assert m.stiffness[0][0, 1] == pytest.approx(-2.0 * shared * 0.1, rel=1e-12)  # leans inwards, tilts the other way


def test_axial_and_torsional_motion_have_their_own_frequencies() -> None:
    bodies, joints = motor()
    n = 2 * model(bodies, joints).pairs
    m = model(bodies, joints)
    assert m.coordinates[n:] == ("z of disc", "z of housing", "turning of housing")
    found = eigh(m.stiffness[0][n:, n:], m.mass[n:, n:], eigvals_only=True)
    k, k0 = 3e6, 3 * 9e4
    half = 0.5 * (k / 4.0 + (k + k0) / 7.0)
    root = np.sqrt(half**2 - k * k0 / 28.0)
    np.testing.assert_allclose(found, np.sort([half - root, half + root, 3 * 16e3 * 0.01 / 0.027]), rtol=1e-10)


def test_tilting_splits_into_forward_and_backward_whirl_by_the_closed_form() -> None:
    jt, jp, k, speed = 0.02, 0.03, 500.0, 200.0
    m = model([body("a", 3.0, jt, jp, 0.0)], [Spring(between=TO_GROUND, position=0.0, stiffness=1e4, tilt_stiffness=k)])
    mass, turning, stiffness = m.complex_matrices(speed)
    poles = np.linalg.eigvals(
        np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, turning)]])
    )
    half = jp * speed / (2 * jt)
    root = np.sqrt(half**2 + k / jt)
    lateral_whirl = np.sqrt(1e4 / 3.0)
    np.testing.assert_allclose(
        np.sort(poles.imag), np.sort([half + root, half - root, lateral_whirl, -lateral_whirl]), rtol=1e-10
    )
    assert abs(half + root) > abs(half - root)


# structure ----------------------------------------------------------------------------------------------------------------


def test_mass_and_stiffness_are_symmetric_and_damping_takes_energy() -> None:
    bodies, joints = motor(count=2, angle=0.3, bending_stiffness=5.0, torsional_damping=0.4)
    joints.append(
        Dashpot(between=("housing", "ground"), position=0.1, offset=(0.05, -0.02), damping=(8, 3), axial_damping=9)
    )
    m = model(bodies, joints)
    for matrix in (m.mass, m.stiffness[0], m.damping[0]):
        assert np.array_equal(matrix, matrix.T)
    assert np.linalg.eigvalsh(m.mass)[0] > 0.0
    assert np.linalg.eigvalsh(m.stiffness[0])[0] > 0.0
    assert np.linalg.eigvalsh(m.damping[0])[0] > -1e-12 * np.abs(m.damping).max()
    assert np.array_equal(m.gyroscopic, -m.gyroscopic.T)
    assert np.abs(m.gyroscopic).max() == pytest.approx(0.033)  # of the disc, and not of the housing


def test_turning_the_whole_rig_about_its_axis_changes_nothing() -> None:
    def turned(angle: float) -> LateralModel:
        bodies, joints = motor(count=2, angle=0.3 + angle, direction=(0.5, 0.2, 1.0), bending_stiffness=5.0)
        place = 0.08 * np.array([np.cos(1.0 + angle), np.sin(1.0 + angle)])
        bodies.append(body("box", 2.0, 0.01, 0.01, -0.05, turns=False, offset=tuple(place)))
        return model(bodies, [*joints, Lock(between=("box", "housing"))])

    angle = 0.7
    before, after = turned(0.0), turned(angle)
    n = before.pairs
    turn = np.eye(before.size)
    turn[: 2 * n, : 2 * n] = np.kron([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]], np.eye(n))
    assert not before.isotropic
    for name in ("mass", "gyroscopic", "damping", "stiffness"):
        same(getattr(after, name), turn @ getattr(before, name) @ turn.T)


def test_tables_are_interpolated_on_their_common_speeds() -> None:
    shear = SpeedTable(speed=[0, 50, 100], stiffness=[10e3, 12e3, 20e3], damping=[30, 20, 10])
    axial = SpeedTable(speed=[20, 120], stiffness=[80e3, 100e3], damping=[200, 100])
    ring = Bushing(between=("h", "ground"), position=0.0, count=3, radius=0.1, shear_table=shear, axial_table=axial)
    bodies = [body("a", 4.0, 0.02, 0.03, 0.0), body("h", 7.0, 0.03, 0.03, 0.0, turns=False)]
    m = model(bodies, [Lock(between=("a", "h")), ring])
    np.testing.assert_array_equal(m.speeds, [0.0, 20.0, 50.0, 100.0])
    for speed, k, c, kz, cz in ((10.0, 10.4e3, 28.0, 80e3, 200.0), (75.0, 16e3, 15.0, 91e3, 145.0)):
        stiffness, damping = m.stiffness_at(speed), m.damping_at(speed)
        found = [stiffness[0, 0], damping[0, 0], stiffness[4, 4], damping[4, 4]]
        np.testing.assert_allclose(found, [3 * k, 3 * c, 3 * kz, 3 * cz], rtol=1e-12)
    with pytest.raises(MachineError, match=r"tables end at 100 rad/s and do not cover 101 rad/s"):
        m.stiffness_at(101.0)


# weight -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("up", ["+z", "-z"])
def test_a_body_on_a_soft_joint_is_a_pendulum_or_an_inverted_one(up: str) -> None:
    mass, across, arm, k, holding = 2.0, 0.01, 0.3, 1e9, 50.0
    joint = Spring(between=TO_GROUND, position=0.0, stiffness=k, axial_stiffness=k, tilt_stiffness=holding)
    m = model([body("a", mass, across, 0.01, arm)], [joint], gravity=G, up=up)
    righting = -mass * G * arm if up == "+z" else mass * G * arm
    assert lateral(m)[0] ** 2 == pytest.approx((holding + righting) / (across + mass * arm**2), rel=1e-5)


def test_weight_acts_as_the_energy_of_finite_rotations_says() -> None:
    bodies, joints = motor(angle=0.2, direction=(0.5, 0.0, 1.0))
    rotor = MultibodyRotor(bodies=bodies, joints=joints, up="+z")
    m = multibody(rotor, G)
    n = m.pairs
    bare = multibody(rotor.model_copy(update={"up": None}), G).stiffness[0]
    rest = np.linalg.solve(bare, np.append(np.zeros(2 * n), [-4.0 * G, -7.0 * G, 0.0]))

    def energy(q: np.ndarray) -> float:
        pose = {
            "disc": (np.array([q[0], q[4], q[8]]), Rotation.from_rotvec([-q[5], q[1], 0.0])),
            "housing": (np.array([q[2], q[6], q[9]]), Rotation.from_rotvec([-q[7], q[3], q[10]])),
        }
        centers = {b.name: np.array(b.center) for b in bodies}

        def moved(name: str, point: np.ndarray) -> np.ndarray:
            if name == "ground":
                return np.zeros(3)
            shift, turn = pose[name]
            arm = point - centers[name]
            return np.asarray(shift + turn.apply(arm) - arm)

        total = sum(b.mass * G * pose[b.name][0][2] for b in bodies)
        for joint, axial in ((joints[0], 3e6), (joints[1], 0.0)):
            stretch = moved("disc", np.array([0, 0, joint.position])) - moved(
                "housing", np.array([0, 0, joint.position])
            )
            total += 0.5 * float(np.array([joint.stiffness, joint.stiffness, axial]) @ stretch**2)
        for i in range(3):
            turn = Rotation.from_rotvec([0.0, 0.0, 0.2 + 2 * np.pi * i / 3])
            stretch = moved("housing", turn.apply([0.1, 0.0, 0.0]) + np.array([0.0, 0.0, -0.03]))
            along = stretch @ turn.apply([0.5, 0.0, 1.0]) / np.sqrt(1.25)
            total += 0.5 * float(9e4 * along**2 + 16e3 * (stretch @ stretch - along**2))
        return float(total)

    step, hessian = 1e-4, np.zeros((m.size, m.size))
    unit = step * np.eye(m.size)
    for i in range(m.size):
        for j in range(i + 1):
            signs = [(a, b, a * b) for a in (1, -1) for b in (1, -1)]
            hessian[i, j] = hessian[j, i] = sum(s * energy(rest + a * unit[i] + b * unit[j]) for a, b, s in signs) / (
                4 * step**2
            )
    weight = m.stiffness[0] - bare
    assert weight[1, 1] + weight[3, 3] < -1.0  # the disc stands high and leans over
    same(hessian - bare, weight, tolerance=2e-3)


# the discoidal rig --------------------------------------------------------------------------------------------------------


def test_the_discoidal_rig_vibrates_at_rest_as_it_was_measured() -> None:
    machine = DISCOIDAL
    m = lateral_model(machine)
    n = m.pairs
    assert m.isotropic
    np.testing.assert_allclose(lateral(m)[:2] / (2 * np.pi), [9.6, 25.2], rtol=1e-5)
    mass, turning, stiffness = m.complex_matrices(0.0)
    poles = np.linalg.eigvals(
        np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, turning)]])
    )
    first = poles[np.argmin(np.abs(np.abs(poles) - 2 * np.pi * 9.6))]
    assert -first.real == pytest.approx(2.8, rel=1e-4)
    assert parse_machine(machine_text(machine)) == machine


def test_the_modes_of_the_discoidal_rig_come_in_the_published_order() -> None:
    m = lateral_model(DISCOIDAL)
    squares, shapes = eigh(m.stiffness[0], m.mass)
    frequencies = np.sqrt(squares) / (2 * np.pi)
    assert np.sum(frequencies < 30.0) == 6  # two pairs across, turning of the stator, axial
    order = [
        m.coordinates[int(np.argmax(np.abs(shapes[:, i] * np.sqrt(np.diag(m.mass)))))].split(" of")[0] for i in (4, 5)
    ]
    assert order == ["turning", "z"]
    assert critical_speeds(m)[0] / (2 * np.pi) < 10.7


def test_balls_in_the_race_slow_the_first_mode_of_the_discoidal_rig() -> None:
    machine = DISCOIDAL
    m = lateral_model(machine)
    race = station_rows(machine, m)["race"]
    same(race.slope, m.axis.rows(0.0, "disc").slope)
    same(race.deflection - 0.14 * race.slope, m.axis.rows(0.0, "disc").deflection)
    assert lateral(with_ball_mass(machine, m))[0] < lateral(m)[0]

"""A joint from outside the package: two matrices of its own, in the model of the rig, in runs and in stability."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, Literal

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.assembly.rotors.rig import multibody
from autobalancer.assembly.rotors.rigid import rigid
from autobalancer.errors import MachineError
from autobalancer.files.examples import rig
from autobalancer.machine import (
    Body,
    Bushing,
    Lock,
    Machine,
    MultibodyRotor,
    PointJoint,
    RigidRotor,
    SpeedTable,
    Spring,
    Support,
)
from autobalancer.machine import plugins as leaves
from autobalancer.machine.part import Length, key
from autobalancer.machine.rotors.joint import SpringStiffness

RIG = rig("discoidal_rig")
BUSHINGS = 5  # number of the joint, from 0
GRID = (0.0, 60.0, 200.0)


class Mount(PointJoint):
    """Three rubber feet on a circle, as one joint in their middle."""

    kind: Literal["mount"] = "mount"
    interface: ClassVar[int] = 1
    shear: SpringStiffness = key("of a foot, across its axis", symbol="k_s")
    axial: SpringStiffness = key("of a foot, along its axis", symbol="k_a")
    circle: Length = key("radius of the circle")
    loss: SpringStiffness = key("damping over stiffness, s", 0.0)

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        tilt = 1.5 * self.axial * self.circle**2
        k = np.diag([3 * self.shear, 3 * self.shear, 3 * self.axial, tilt, tilt, 3 * self.shear * self.circle**2])
        return k, self.loss * k


class HighSpring(PointJoint):
    """A spring across the axis at a height above its point, where it couples displacement and tilt."""

    kind: Literal["high_spring"] = "high_spring"
    interface: ClassVar[int] = 1
    stiffness: SpringStiffness = key("across the axis")
    height: Length = key("above the point")

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        along_x = np.array([1.0, 0.0, 0.0, 0.0, self.height, 0.0])
        along_y = np.array([0.0, 1.0, 0.0, -self.height, 0.0, 0.0])
        k = self.stiffness * (np.outer(along_x, along_x) + np.outer(along_y, along_y))
        return k, 1e-3 * k


class Rubber(PointJoint):
    """Stiffness and damping that change with the frequency."""

    kind: Literal["rubber"] = "rubber"
    interface: ClassVar[int] = 1

    def frequencies(self) -> tuple[tuple[float, ...], ...]:
        return (GRID,)

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        return 4e4 * (1 + speed / 100) * np.eye(6), 90.0 / (1 + speed / 50) * np.eye(6)


class Film(PointJoint):
    """An oil film: stiffness across its direction."""

    kind: Literal["film"] = "film"
    interface: ClassVar[int] = 1
    symmetric: ClassVar[bool] = False
    cross: SpringStiffness = key("across")

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        k, c = np.zeros((6, 6)), np.zeros((6, 6))
        k[:2, :2] = [[2e4, self.cross], [-self.cross, 2e4]]
        c[0, 0] = c[1, 1] = 40.0
        return k, c


def broken(matrices: Callable[[float], Any], between: tuple[str, str] = ("base", "ground")) -> PointJoint:
    class Broken(PointJoint):
        kind: Literal["broken"] = "broken"
        interface: ClassVar[int] = 1

        def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
            return matrices(speed)  # type: ignore[no-any-return]

    return Broken(between=between, position=0.0)


def model(*joints: Any) -> LateralModel:
    bodies = [Body(name="a", mass=3.0, transverse_inertia=0.02, polar_inertia=0.03, position=0.1, rotating=True)]
    return multibody(MultibodyRotor(bodies=bodies, joints=joints), 0.0)


def with_last(joint: Any) -> Machine:
    machine: Machine = ab.with_parameter(RIG, "rotor.joints", [*RIG.rotor.joints[:BUSHINGS], joint])
    return machine


def same(found: LateralModel, expected: LateralModel) -> None:
    for name in ("mass", "gyroscopic", "speeds", "damping", "stiffness"):
        one, other = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12 * np.abs(other).max(initial=1e-300))


@pytest.fixture(autouse=True)
def _known_here_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(leaves, "_registered", dict(leaves._registered))


def mount() -> Mount:
    ring = RIG.rotor.joints[BUSHINGS]
    assert isinstance(ring, Bushing)
    return Mount(
        between=ring.between,
        position=ring.position,
        shear=ring.shear_stiffness,
        axial=ring.axial_stiffness,
        circle=ring.radius,
        loss=float(ring.shear_damping) / float(ring.shear_stiffness),
    )


def test_three_feet_in_one_joint_are_three_bushings_on_their_circle() -> None:
    found, expected = lateral_model(with_last(mount())), lateral_model(RIG)
    for name in ("mass", "stiffness", "damping"):
        one, other = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(
            one, other, rtol=0.0, atol=2e-5 * np.abs(other).max()
        )  # their damping is rounded in the file
    assert found.isotropic


@pytest.mark.filterwarnings("ignore::autobalancer.errors.RangeWarning")
def test_runs_and_stability_know_a_joint_from_outside() -> None:
    ours, theirs = RIG, with_last(mount())
    for machine in (ours, theirs):
        assert lateral_model(machine).coordinates == lateral_model(ours).coordinates
    modes = [ab.rotor.modes(machine, 60.0)["frequency"].values for machine in (ours, theirs)]
    np.testing.assert_allclose(modes[1], modes[0], rtol=1e-5)
    stiffer = with_last(Mount(**{**dict(mount()), "shear": 4.0 * float(mount().shear)}))
    found = [ab.stability.eigenvalues(machine, [100.0]) for machine in (ours, theirs, stiffer)]
    values = [np.sort(np.hypot(one["eigenvalue_real"], one["eigenvalue_imag"]).values[0]) for one in found]
    np.testing.assert_allclose(values[1], values[0], rtol=1e-4)
    assert float(np.abs(values[2] / values[0] - 1.0).max()) > 0.3
    runs = [ab.simulate(machine, duration=1.0)["deflection"].values[-1] for machine in (ours, theirs)]
    assert float(runs[0]) > 0.0
    assert float(runs[1]) == pytest.approx(float(runs[0]), rel=1e-3)


@pytest.mark.parametrize("up", [None, "+z"])
def test_a_joint_that_couples_displacement_and_tilt_is_a_spring_elsewhere(up: str | None) -> None:
    def rotor(side: Any) -> LateralModel:
        bodies = [Body(name="a", mass=3.0, transverse_inertia=0.02, polar_inertia=0.03, position=0.1, rotating=True)]
        foot = Spring(between=("a", "ground"), position=0.0, stiffness=3e4, tilt_stiffness=900.0, axial_stiffness=1e6)
        return multibody(MultibodyRotor(bodies=bodies, joints=[foot, side], up=up), 9.81 if up else 0.0)

    plain = Spring(between=("a", "ground"), position=0.25, stiffness=2e4, damping=20.0)
    same(rotor(HighSpring(between=("a", "ground"), position=0.05, stiffness=2e4, height=0.2)), rotor(plain))


class Inclined(PointJoint):
    """A bushing whose axis is inclined, in the axes of the rig."""

    kind: Literal["inclined"] = "inclined"
    interface: ClassVar[int] = 1

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        along = np.array([0.6, 0.0, 0.8])
        across = np.eye(3) - np.outer(along, along)
        k = np.kron(np.diag([1.0, 0.0]), 9e4 * np.outer(along, along) + 2e4 * across)
        return k + np.kron(np.diag([0.0, 1.0]), 800.0 * np.eye(3)), 1e-3 * k


@pytest.mark.parametrize("up", [None, "+z"])
def test_an_inclined_bushing_as_coupled_matrices_carries_the_weight_as_a_bushing_does(up: str | None) -> None:
    def rotor(foot: Any) -> LateralModel:
        sizes = {"transverse_inertia": 0.02, "polar_inertia": 0.03, "position": 0.1}
        bodies = [Body(name="r", mass=3.0, rotating=True, **sizes), Body(name="h", mass=2.0, rotating=False, **sizes)]
        lock = Lock(between=("r", "h"))
        return multibody(MultibodyRotor(bodies=bodies, joints=[lock, foot], up=up), 9.81 if up else 0.0)

    stiff = {"axial_stiffness": 9e4, "shear_stiffness": 2e4, "bending_stiffness": 800.0, "torsional_stiffness": 800.0}
    damped = {"axial_damping": 90.0, "shear_damping": 20.0, "direction": (0.6, 0.0, 0.8)}
    plain = Bushing(between=("h", "ground"), position=0.02, **stiff, **damped)
    same(rotor(Inclined(between=("h", "ground"), position=0.02)), rotor(plain))


def test_a_joint_over_the_frequency_is_its_table() -> None:
    table = {
        "speed": GRID,
        "stiffness": [4e4 * (1 + w / 100) for w in GRID],
        "damping": [90 / (1 + w / 50) for w in GRID],
    }
    tilt = [
        Spring(between=("a", "ground"), position=0.1, table=SpeedTable(**table), axial_table=SpeedTable(**table)),
        Spring(between=("a", "ground"), position=0.1, tilt_stiffness=1.0),
    ]
    found, expected = model(Held(between=("a", "ground"), position=0.1)), model(*tilt)
    assert found.speeds.tolist() == list(GRID)
    assert found.top_speed == 200.0
    for speed in (0.0, 30.0, 130.0):
        n = [0, 2]  # displacements along x and y
        np.testing.assert_allclose(
            found.stiffness_at(speed)[np.ix_(n, n)], expected.stiffness_at(speed)[np.ix_(n, n)], rtol=1e-12
        )
        np.testing.assert_allclose(
            found.damping_at(speed)[np.ix_(n, n)], expected.damping_at(speed)[np.ix_(n, n)], rtol=1e-12
        )


class Held(Rubber):
    """The same, free to turn with the rotor."""

    kind: Literal["held"] = "held"  # type: ignore[assignment]

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        k, c = super().matrices(speed)
        return k * (np.arange(6) < 5), c * (np.arange(6) < 5)


def test_a_film_is_the_cross_stiffness_of_a_support_and_drives_the_rotor_beyond_a_share_of_its_damping() -> None:
    tilt = Spring(between=("a", "ground"), position=0.1, tilt_stiffness=900.0)
    found = model(Film(between=("a", "ground"), position=0.1, cross=3e3), tilt)
    support = Support(position=0.0, stiffness=2e4, damping=40.0, cross_stiffness=(3e3, -3e3), tilt_stiffness=900.0)
    expected = rigid(RigidRotor(mass=3.0, transverse_inertia=0.02, polar_inertia=0.03, supports=[support]))
    np.testing.assert_allclose(found.stiffness[0][:4, :4], expected.stiffness[0], rtol=1e-12, atol=1e-9)

    def growth(cross: float) -> float:
        m = model(Film(between=("a", "ground"), position=0.1, cross=cross), tilt)
        k, c, mass = (stack[np.ix_([0, 2], [0, 2])] for stack in (m.stiffness[0], m.damping[0], m.mass))
        first = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, k), -np.linalg.solve(mass, c)]])
        return float(np.linalg.eigvals(first).real.max())

    onset = 40.0 * math.sqrt(2e4 / 3.0)  # cross stiffness = damping times natural frequency
    assert growth(0.98 * onset) < 0.0 < growth(1.02 * onset)


def test_a_registered_joint_is_read_and_written() -> None:
    ab.laws.register(Mount)
    machine = with_last(mount())
    text = ab.machine_text(machine)
    assert 'kind = "mount"' in text
    assert ab.parse_machine(text) == machine
    assert "radius of the circle" in repr(ab.keys("rotor.joints"))
    with pytest.raises(MachineError, match=r"joints\[6\]\.circle: given -1; must be greater"):
        with_last(
            {"kind": "mount", "between": ["base", "ground"], "position": 0.0, "shear": 1.0, "axial": 1.0, "circle": -1}
        )


def off(i: int, j: int, value: float) -> Callable[[float], Any]:
    def matrices(speed: float) -> Any:
        k = 1e4 * np.eye(6)
        k[i, j] = value
        return k, np.zeros((6, 6))

    return matrices


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (broken(off(1, 3, math.nan)), r"joints\[6\]: .*'broken' at 0 rad/s: its stiffness along y for .* about x is nan"),
        (broken(off(0, 4, 7.0)), "not symmetric, 7 along x for a motion about y, but 0 about y for a motion along x"),
        (broken(off(2, 2, -5.0)), r"stiffness pushes away, most along z \(-5\)"),
        (broken(lambda w: (1e4 * np.eye(6), -np.eye(6))), "its damping drives what it should damp"),
        (broken(lambda w: (np.eye(3), np.eye(6))), r"its stiffness has the shape \(3, 3\); must be \(6, 6\)"),
        (broken(lambda w: 1.0 / 0.0), "fails: ZeroDivisionError"),
        (broken(off(5, 5, 1e4), ("disc", "ground")), "cannot be held against rotation"),
        (broken(lambda w: (np.diag([1e4, 2e4, 0, 0, 0, 0]), np.zeros((6, 6))), ("disc", "shaft")), "x and y must be equal"),
    ],
)  # fmt: skip
def test_matrices_that_are_no_joint_are_named_with_their_entry(joint: PointJoint, message: str) -> None:
    apart = [one for one in RIG.rotor.joints[:BUSHINGS] if set(one.between) != set(joint.between)]
    machine = with_last(joint) if len(apart) == BUSHINGS else ab.with_parameter(RIG, "rotor.joints", [*apart, joint])
    with pytest.raises(MachineError, match=message):
        lateral_model(machine)


def test_a_joint_for_another_version_is_refused_with_both_versions() -> None:
    class Older(Mount):
        kind: Literal["older"] = "older"  # type: ignore[assignment]
        interface: ClassVar[int] = 0

    with pytest.raises(MachineError, match=r"version 0 .* version 1"):
        ab.laws.register(Older)

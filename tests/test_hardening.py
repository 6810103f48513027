"""Bearings that become stiffer as they deflect: exact motions, energy, jumps, and what theories say of them."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from scipy.integrate import quad
from tests.references.motion import motion
from tests.references.spatial import Spatial, split
from tests.references.spatial_machines import states_of

import autobalancer as ab
from autobalancer.assembly.places import coordinates
from autobalancer.assembly.rotors import spring_model
from autobalancer.assembly.system import assemble
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Hardening, Machine, PointJoint

MASS, STIFFNESS, CUBIC = 10.0, 4e5, 4e13  # kg, N/m, N/m^3: twice as stiff on a circle of 0.1 mm
AMPLITUDE = 1e-4
STOP = {"clearance": 0.5 * AMPLITUDE, "contact_stiffness": 8e5}


def planar(hardening: dict[str, Any] | None, **top: Any) -> Machine:
    rotor = {"mass": MASS, "stiffness": STIFFNESS, "damping": 0.0, "hardening": hardening}
    data: dict[str, Any] = {
        "name": "hard",
        "axis": "vertical",
        "rotor": rotor,
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
    }
    return Machine(**(data | top))


def rigid(hardening: dict[str, Any]) -> Machine:
    """A rotor that tilts, on one bearing that hardens and one that does not, with a ball; all in space-fixed axes."""
    race = {
        "orbit_radius": 0.05,
        "drag": {"law": "viscous", "damping": 0.0},
        "balls": [{"mass": 0.01, "motion": "point"}],
    }
    supports = [
        {"position": -0.1, "stiffness": [2e5, 3e5], "hardening": hardening},
        {"position": 0.15, "stiffness": 2e5},
    ]
    rotor = {
        "kind": "rigid",
        "mass": MASS,
        "transverse_inertia": 0.1,
        "polar_inertia": 0.05,
        "supports": supports,
    }
    drive = {"kind": "torque", "torque": 0.0}
    start = {"speed": 150.0, "deflection": [2e-4, -1e-4]}
    stations = [{"name": "race", "position": 0.02}]
    return Machine(
        name="two bearings",
        axis="vertical",
        rotor=rotor,
        stations=stations,
        balancers=[{"station": "race", "races": [race]}],
        drive=drive,
        start=start,
    )


def stored(hardening: dict[str, Any], r: np.ndarray) -> np.ndarray:
    """Energy of a bearing at distances from its middle, written down again, J."""
    far = np.maximum(r - hardening.get("clearance", 0.0), 0.0)
    return 0.25 * hardening.get("cubic_stiffness", 0.0) * r**4 + 0.5 * hardening.get("contact_stiffness", 0.0) * far**2


@pytest.mark.parametrize(
    ("hardening", "stiffness"),
    [
        ({"cubic_stiffness": CUBIC}, STIFFNESS + CUBIC * AMPLITUDE**2),
        (STOP, STIFFNESS + STOP["contact_stiffness"] * (1.0 - STOP["clearance"] / AMPLITUDE)),
    ],
)
def test_a_free_circle_is_exact_with_the_secant_stiffness_of_its_radius(
    hardening: dict[str, Any], stiffness: float
) -> None:
    rate = np.sqrt(stiffness / MASS)
    start = {"deflection": [AMPLITUDE, 0.0], "velocity": [0.0, rate * AMPLITUDE]}
    times = np.linspace(0.0, 1.0, 51)
    case = planar(hardening, start=start)
    place = motion(case, states_of(case, times, rotating=False)).deflection @ (1.0, 1j)
    np.testing.assert_allclose(place, AMPLITUDE * np.exp(1j * rate * times), atol=1e-9 * AMPLITUDE)


def test_a_straight_motion_has_the_period_of_duffings_oscillator() -> None:
    """T = 4 int_0^a dx / sqrt(2 (V(a) - V(x))/m), with x = a sin(s)."""
    k, c, a = STIFFNESS, CUBIC, AMPLITUDE

    def slow(s: float) -> float:
        # V(a) - V(x) = (a^2 - x^2) (k + c (a^2 + x^2)/2)/2
        return float(1.0 / np.sqrt((k + 0.5 * c * a * a * (1.0 + np.sin(s) ** 2)) / MASS))

    period = 4.0 * quad(slow, 0.0, 0.5 * np.pi)[0]
    case = planar({"cubic_stiffness": CUBIC}, start={"deflection": [0.0, a]})
    states = motion(case, states_of(case, np.array([0.25, 0.5, 1.0, 7.0]) * period)).deflection
    np.testing.assert_allclose(states[:, 1], [0.0, -a, a, a], atol=1e-8 * a)
    np.testing.assert_allclose(states[:, 0], 0.0, atol=1e-15)


@pytest.mark.parametrize("center", [[0.0, 0.0], [3e-5, -2e-5]])
@pytest.mark.parametrize("kind", [{"cubic_stiffness": CUBIC}, {"cubic_stiffness": CUBIC, **STOP}])
def test_a_tilting_rotor_on_a_bearing_that_hardens_keeps_its_energy(kind: dict[str, Any], center: list[float]) -> None:
    hardening = kind | {"center": center}
    case = rigid(hardening)
    times = np.linspace(0.0, 0.5, 41)
    first, second = case.rotor.supports
    plain = case.rotor.model_copy(update={"supports": (first.model_copy(update={"hardening": None}), second)})
    reference = Spatial(case.model_copy(update={"rotor": plain}))
    states = split(case, states_of(case, times, rotating=False))
    linear = np.array([reference.energy(t, q, v) for t, (q, v) in zip(times, states, strict=True)])
    q = states[:, 0]
    z = q[:, 0] - 0.1 * q[:, 1] + 1j * (q[:, 2] - 0.1 * q[:, 3])  # in the first bearing
    rest = force_on(hardening, np.array([-complex(*center)]))[0]
    own = stored(hardening, abs(z - complex(*center))) - (np.conj(rest) * z).real
    assert np.ptp(own) > 1e-3 * np.ptp(linear)
    np.testing.assert_allclose(linear + own, linear[0] + own[0], rtol=1e-10)
    run = ab.simulate(case, duration=0.5, save=ab.SampleTimes(times), tolerance=1e-12, frame="space")
    felt = run["support_force_x"].values[:, 0] + 1j * run["support_force_y"].values[:, 0]
    force = 2e5 * z.real + 3e5j * z.imag + force_on(hardening, z - complex(*center)) - rest
    # later the stop, which the rotor hits again and again, has driven two runs of other tolerances apart
    early = times < 0.3
    np.testing.assert_allclose(felt[early], force[early], atol=1e-6 * abs(force).max())


def force_on(hardening: dict[str, Any], way: np.ndarray) -> np.ndarray:
    """Force of the rotor on the bearing, x + i y in N."""
    r = abs(way)
    far = np.maximum(r - hardening.get("clearance", 0.0), 0.0)
    unit = way / np.where(r > 0.0, r, 1.0)
    return hardening.get("cubic_stiffness", 0.0) * r**2 * way + hardening.get("contact_stiffness", 0.0) * far * unit


def test_a_run_up_carries_a_hardening_rotor_on_where_a_fresh_start_at_that_speed_stays_small() -> None:
    """Circles of the radius a: ((k + c a^2 - m w^2)^2 + (b w)^2) a^2 = (U w^2)^2, here with three radii, two of them stable."""
    damping, moment, speed = 40.0, 2e-5, 230.0
    rotor = {"mass": MASS, "stiffness": STIFFNESS, "damping": damping, "hardening": {"cubic_stiffness": CUBIC}}
    case = planar(None, rotor=rotor, unbalances=[{"moment": moment}])
    detuned = STIFFNESS - MASS * speed**2
    squares = np.roots(
        [CUBIC**2, 2.0 * CUBIC * detuned, detuned**2 + (damping * speed) ** 2, -((moment * speed**2) ** 2)]
    )
    radii = np.sqrt(np.sort(squares.real[abs(squares.imag) < 1e-9 * abs(squares)]))
    assert radii.size == 3
    plan: dict[str, Any] = {"dwell": 4.0, "window": 0.1}
    up = ab.stepped_response(case, [200.0, 215.0, speed], acceleration=20.0, **plan)["amplitude"].values[-1]
    fresh = ab.stepped_response(case, [speed], **plan)["amplitude"].item()
    assert up == pytest.approx(radii[2], rel=2e-3)
    assert fresh == pytest.approx(radii[0], rel=2e-3)


def test_theories_of_small_motions_leave_the_hardening_out_and_say_so() -> None:
    hard, soft = rigid({"cubic_stiffness": CUBIC}), rigid({"cubic_stiffness": 1e-6})
    for theory in (Theory.AT_REST, Theory.STALLED, Theory.ROTOR):
        assert "hardening of the bearings (stiffness at rest)" in unknown(hard, theory)
    np.testing.assert_array_equal(ab.rotor.modes(hard)["frequency"], ab.rotor.modes(soft)["frequency"])
    assert "ignores hardening of the bearings (stiffness at rest)" in repr(ab.rotor.modes(hard))


def test_a_verdict_on_hardening_bearings_compares_with_a_run_with_held_balls() -> None:
    """Held balls meet the same bearings: without unbalance nothing moves, and with it as much as the exact circle."""
    balls = {
        "orbit_radius": 0.05,
        "drag": {"law": "viscous", "damping": 1e-3},
        "balls": [{"count": 2, "mass": 1e-3, "motion": "point"}],
    }
    rotor = {"mass": MASS - 2e-3, "stiffness": STIFFNESS, "damping": 400.0, "hardening": {"cubic_stiffness": CUBIC}}
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 150.0}}
    case = planar(None, rotor=rotor, balancers=[{"races": [balls]}], unbalances=[{"moment": 8e-5}], drive=drive)
    run, held = (ab.simulate(case, duration=2.0, hold_balls=hold) for hold in (False, True))
    assert "bearings that harden" in str(ab.verdict(run))
    size = float(held["deflection"][-1])
    stiff = STIFFNESS + CUBIC * size**2 - MASS * 150.0**2
    assert size == pytest.approx(8e-5 * 150.0**2 / np.hypot(stiff, 400.0 * 150.0), rel=1e-6)
    assert "no verdict" not in str(ab.verdict(run, held))


@pytest.mark.parametrize(
    ("hardening", "says"),
    [
        ({}, "cubic_stiffness: missing"),
        ({"clearance": 1e-5}, "contact_stiffness: missing"),
        ({"contact_stiffness": 1e5}, "clearance: missing"),
        ({"cubic_stiffness": -1.0}, "must not be negative"),
    ],
)
def test_a_hardening_that_lacks_something_is_refused(hardening: dict[str, Any], says: str) -> None:
    with pytest.raises(MachineError, match=says):
        planar(hardening)


RIG = {"cubic_stiffness": CUBIC, "clearance": 4e-5, "contact_stiffness": 8e5}
TABLE: dict[str, Any] = {"distance": [2e-5, 6e-5, AMPLITUDE, 2e-4], "force": [0.0, 1.0, 12.0, 80.0]}


def rig(joints: list[dict[str, Any]], **top: Any) -> Machine:
    """A disc that turns in a housing, with these joints."""
    bodies = [
        {
            "name": "disc",
            "rotating": True,
            "mass": MASS,
            "transverse_inertia": 0.1,
            "polar_inertia": 0.05,
            "position": 0.0,
        },
        {"name": "housing", "mass": 6.0, "transverse_inertia": 0.08, "polar_inertia": 0.1, "position": 0.05},
    ]
    if not any("housing" in joint["between"] for joint in joints):
        bodies = bodies[:1]
    data: dict[str, Any] = {
        "name": "rig",
        "axis": "vertical",
        "rotor": {"kind": "multibody", "bodies": bodies, "joints": joints},
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
    }
    return Machine(**(data | top))


def held(hardening: dict[str, Any] | None, damping: float = 0.0) -> list[dict[str, Any]]:
    """A spring at the mass center that also keeps the disc from tilting."""
    return [
        {
            "kind": "spring", "between": ["disc", "ground"], "position": 0.0, "stiffness": STIFFNESS, "damping": damping,
            "tilt_stiffness": 1e5, "hardening": hardening,
        }
    ]  # fmt: skip


@pytest.mark.parametrize("hardening", [RIG, RIG | {"center": [1e-5, 3e-5]}, TABLE])
def test_a_rig_in_a_nonlinear_bearing_runs_up_like_the_planar_machine_it_equals(hardening: dict[str, Any]) -> None:
    """Pulled, unbalanced, with free balls: the rig does not tilt, so its equations are those of the plane."""
    race = {
        "orbit_radius": 0.05,
        "drag": {"law": "viscous", "damping": 1e-3},
        "balls": [{"count": 2, "mass": 5e-3, "motion": "point", "start_angles": [0.3, 2.0]}],
    }
    common: dict[str, Any] = {
        "balancers": [{"races": [race]}],
        "unbalances": [{"moment": 2e-4}],
        "drive": {"kind": "speed", "profile": {"kind": "ramp", "start": 150.0, "end": 300.0, "duration": 1.0}},
        "start": {"deflection": [1e-4, 0.0]},
    }
    plain = {"mass": MASS, "stiffness": STIFFNESS, "damping": 60.0, "hardening": hardening}
    times = ab.SampleTimes(np.linspace(0.0, 1.0, 21))
    one, other = (
        ab.simulate(case, duration=1.0, save=times, tolerance=1e-11, frame="space")
        for case in (planar(None, rotor=plain, **common), rig(held(hardening, damping=60.0), **common))
    )
    for name in ("x", "y", "ball_angle_in_rotor", "support_force_x", "support_force_y"):
        a, b = one[name].values, other[name].values.reshape(one[name].shape)
        np.testing.assert_allclose(b, a, atol=1e-7 * np.abs(a).max(), err_msg=name)
    far = np.hypot(one["x"].values, one["y"].values).max()
    assert far > 2.0 * hardening.get("clearance", 2e-5)


def test_a_bearing_between_two_bodies_keeps_the_energy_of_its_rig() -> None:
    """The disc moves against its housing, which moves on its own springs; the disc spins, so gyroscopic forces act."""
    hardening = RIG | {"center": [2e-5, -1e-5]}
    joints = [
        {"kind": "bearing", "between": ["disc", "housing"], "position": -0.02, "stiffness": 3e5, "hardening": hardening},
        {"kind": "bearing", "between": ["disc", "housing"], "position": 0.12, "stiffness": [2e5, 4e5]},
        {
            "kind": "spring", "between": ["housing", "ground"], "position": 0.02, "stiffness": STIFFNESS,
            "tilt_stiffness": 5e4,
        },
    ]  # fmt: skip
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 150.0}}
    case = rig(joints, start={"deflection": [3e-4, 1e-4]}, drive=drive)
    times = np.linspace(0.0, 0.5, 41)
    assembly = assemble(case, rotating=False)
    q, v = coordinates(states_of(case, times, rotating=False), assembly)
    model, basis = spring_model(case), assembly.reduction.basis
    q, v = q @ basis.T, v @ basis.T
    linear = 0.5 * np.einsum("ti,ij,tj->t", v, model.mass, v) + 0.5 * np.einsum("ti,ij,tj->t", q, model.stiffness[0], q)
    rig_axis = model.axis.rig
    kept = [rig_axis.coordinates.index(name) for name in model.coordinates]
    place = (0.0, 0.0, -0.02)
    row = (rig_axis.motion("disc", place) - rig_axis.motion("housing", place))[:2, kept]
    z = q @ row.T @ (1.0, 1j)
    middle = complex(*hardening["center"])
    rest = force_on(hardening, np.array([-middle]))[0]
    own = stored(hardening, abs(z - middle)) - (np.conj(rest) * z).real
    assert np.ptp(own) > 1e-3 * np.ptp(linear)
    # the stiffness jumps at the stop: a step over it can lose more than its tolerance, 3e-9 where rounding places it badly
    np.testing.assert_allclose(linear + own, linear[0] + own[0], rtol=1e-8)


def test_a_law_of_your_own_gives_a_free_circle_its_own_force_at_the_points_of_its_table() -> None:
    """At a point of the table its force is what was given, whatever lies between: w^2 = (k + F/a)/m."""
    case = rig(held(TABLE), start={"deflection": [AMPLITUDE, 0.0], "velocity": [0.0, AMPLITUDE]})
    rate = np.sqrt((STIFFNESS + 12.0 / AMPLITUDE) / MASS)
    case = case.model_copy(update={"start": case.start.model_copy(update={"velocity": (0.0, rate * AMPLITUDE)})})
    times = np.linspace(0.0, 1.0, 51)
    place = coordinates(states_of(case, times, rotating=False), assemble(case, rotating=False))[0][:, :2] @ (1.0, 1j)
    np.testing.assert_allclose(place, AMPLITUDE * np.exp(1j * rate * times), atol=1e-8 * AMPLITUDE)


class Magnetic(PointJoint):
    """A bearing whose force follows from a formula in Python."""

    kind: Literal["magnetic"] = "magnetic"
    interface: ClassVar[int] = 1

    def matrices(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        return np.diag([STIFFNESS, STIFFNESS, 0.0, 1e5, 1e5, 0.0]), np.zeros((6, 6))

    def hardenings(self) -> tuple[Hardening, ...]:
        return (Hardening(distance=tuple(TABLE["distance"]), force=tuple(TABLE["force"])),)


def test_a_stop_of_its_own_and_a_joint_of_your_own_do_what_the_key_of_a_spring_does() -> None:
    times = np.linspace(0.0, 0.3, 31)
    alone = {"kind": "spring", "between": ["disc", "ground"], "position": 0.0, "hardening": TABLE}
    cases = [rig(held(TABLE), start={"deflection": [1.5e-4, 5e-5]})]
    cases.append(rig([*held(None), alone], start={"deflection": [1.5e-4, 5e-5]}))
    own = cases[0].rotor.model_copy(update={"joints": (Magnetic(between=("disc", "ground"), position=0.0),)})
    cases.append(cases[0].model_copy(update={"rotor": own}))
    runs = [states_of(case, times, rotating=False)[:, :4] for case in cases]
    for other in runs[1:]:
        np.testing.assert_allclose((other - runs[0]) / np.abs(runs[0]).max(axis=0), 0.0, atol=1e-9)
    save = ab.SampleTimes(times / 3.0)
    found = [ab.simulate(case, duration=0.1, save=save, tolerance=1e-11) for case in cases]
    forces = [one["support_force_x"].sum("support").values for one in found]
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-6 * np.abs(forces[0]).max())


def test_modes_are_those_of_small_motions_about_the_place_where_the_rotor_rests() -> None:
    """F' along the way from the middle and F/r across it, of cubic spring and stop: compared with these and with a run."""
    hardening = RIG | {"center": [0.0, -8e-5]}
    case = rig(held(hardening))
    r, stop = 8e-5, RIG["contact_stiffness"]
    along = 3.0 * CUBIC * r**2 + stop
    across = CUBIC * r**2 + stop * (1.0 - RIG["clearance"] / r)
    wanted = np.sqrt((STIFFNESS + np.array([across, along])) / MASS)
    np.testing.assert_allclose(ab.rotor.modes(case, modes=2)["frequency"], wanted, rtol=1e-9)
    small = 1e-9
    started = rig(held(hardening), start={"deflection": [small, small]})
    times = np.linspace(0.0, 0.5, 51)
    q = coordinates(states_of(started, times, rotating=False), assemble(started, rotating=False))[0][:, :2]
    np.testing.assert_allclose(q, small * np.cos(np.outer(times, wanted)), atol=2e-4 * small)


def test_a_run_says_that_a_bearing_moved_beyond_its_table() -> None:
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}}
    for size, says in ((1e-4, False), (3e-4, True)):
        run = ab.simulate(rig(held(TABLE), start={"deflection": [size, 0.0]}, drive=drive), duration=0.1)
        assert (
            "joint 1 moved 300 µm from its middle, its table ends at 200 µm" in " ".join(run.attrs.get("remarks", []))
        ) == says


def test_a_skewed_rest_of_a_planar_rotor_is_refused_by_its_theories_and_known_to_modes() -> None:
    balls = {
        "orbit_radius": 0.05,
        "drag": {"law": "viscous", "damping": 1e-3},
        "balls": [{"count": 2, "mass": 1e-3, "motion": "point"}],
    }
    rotor = {"mass": MASS, "stiffness": STIFFNESS, "damping": 40.0}
    center = [3e-5, 4e-5]
    case = planar(
        None, rotor=rotor | {"hardening": {"cubic_stiffness": CUBIC, "center": center}}, balancers=[{"races": [balls]}]
    )
    stiff = STIFFNESS + CUBIC * 25e-10 * np.array([1.0, 3.0])
    found = ab.rotor.modes(case, balls=False)["undamped_frequency"]
    np.testing.assert_allclose(found, np.sqrt(stiff / MASS), rtol=1e-9)
    with pytest.raises(QuestionError, match="turn the axes until 'center'"):
        ab.stability.equilibria(case, speed=250.0)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ({"distance": [1e-5, 2e-5]}, "force: missing"),
        ({"distance": [1e-5, 2e-5], "force": [1.0]}, "given 1 values for 2 distances"),
        ({"distance": [1e-5], "force": [1.0]}, "give at least two"),
        ({"distance": [1e-5, 1e-5], "force": [1.0, 2.0]}, "entry 2 is 1e-05 after 1e-05; the values must increase"),
        (
            {"distance": [1e-5, 2e-5, 3e-5], "force": [1.0, 2.0, 1.5]},
            "entry 3 is 1.5 after 2; the values must not fall",
        ),
        ({"distance": [0.0, 2e-5], "force": [1.0, 2.0]}, "given 1 N at distance 0; it must be 0"),
        ({"distance": [0.0, 2e-5], "force": [-1.0, 2.0]}, "must not be negative"),
    ],
)
def test_a_table_of_a_bearing_that_is_odd_is_refused(table: dict[str, Any], says: str) -> None:
    with pytest.raises(MachineError, match=says):
        rig(held(table))


def test_a_middle_that_would_turn_with_both_bodies_of_a_joint_is_refused() -> None:
    bodies = [
        {"name": name, "rotating": True, "mass": 1.0, "transverse_inertia": 0.1, "polar_inertia": 0.1, "position": 0.0}
        for name in ("disc", "ring")
    ]
    spring = {"kind": "spring", "between": ["disc", "ring"], "position": 0.0, "stiffness": 1e5}
    rotor = {"kind": "multibody", "bodies": bodies, "joints": [spring | {"hardening": RIG | {"center": [0.0, 1e-5]}}]}
    with pytest.raises(MachineError, match="the middle would rotate with them"):
        planar(None, rotor=rotor)


def test_a_sweep_counts_hardening_bearings_in_the_force_on_supports() -> None:
    rotor = {"mass": MASS, "stiffness": STIFFNESS, "damping": 400.0, "hardening": {"cubic_stiffness": CUBIC}}
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 150.0}}
    case = planar(None, rotor=rotor, unbalances=[{"moment": 8e-4}], drive=drive)
    run = ab.simulate(case, duration=2.0)
    swept = ab.sweep(case, {"rotor.mass": [MASS]}, duration=2.0)["support_force"].item()
    assert swept == pytest.approx(float(ab.run_measures(run)["vibrating_force"].item()), rel=1e-6)
    size = float(ab.run_measures(run)["vibration"].item())
    assert swept == pytest.approx(np.hypot(STIFFNESS + CUBIC * size**2, 400.0 * 150.0) * size, rel=1e-3)


def test_a_sweep_keeps_the_hardening_of_a_rotor_that_is_given_by_its_critical_speed() -> None:
    """With w_c and D in place of k and b it is the same rotor, whatever else is varied."""
    words = {"mass": MASS, "critical_speed": math.sqrt(STIFFNESS / MASS), "damping_ratio": 0.05}
    numbers = {"mass": MASS, "stiffness": STIFFNESS, "damping": 0.1 * math.sqrt(STIFFNESS * MASS)}
    more = {
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 150.0}},
        "unbalances": [{"moment": 3e-4}],
    }
    peaks = [
        float(ab.sweep(one, {"unbalances[1].angle": [0.4]}, duration=0.5, progress=False)["peak_deflection"][0])
        for one in (
            planar(None, rotor=rotor | {"hardening": {"cubic_stiffness": CUBIC}}, **more) for rotor in (words, numbers)
        )
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-6)
    soft = ab.sweep(planar(None, rotor=words, **more), {"unbalances[1].angle": [0.4]}, duration=0.5, progress=False)
    assert peaks[0] < 0.99 * float(soft["peak_deflection"][0])

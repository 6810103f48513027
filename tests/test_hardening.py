"""Bearings that become stiffer as they deflect: exact motions, energy, jumps, and what theories say of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from tests.references.motion import motion
from tests.references.spatial import Spatial, split
from tests.references.spatial_machines import states_of

import autobalancer as ab
from autobalancer.errors import MachineError
from autobalancer.machine import Machine
from autobalancer.stability.ignored import ignored_at_rest, ignored_by_stalled

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
    race = {"orbit_radius": 0.05, "drag": {"law": "beta", "beta": 0.0}, "balls": [{"mass": 0.01, "motion": "point"}]}
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
    np.testing.assert_allclose(felt, force, atol=1e-6 * abs(force).max())


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
    for ignored in (ignored_at_rest, ignored_by_stalled):
        assert "hardening of the bearings" in ignored(hard)
    np.testing.assert_array_equal(ab.rotor.modes(hard)["frequency"], ab.rotor.modes(soft)["frequency"])
    assert "leaves out: hardening of the bearings" in repr(ab.rotor.modes(hard))


def test_a_verdict_on_hardening_bearings_compares_with_a_run_with_held_balls() -> None:
    """Held balls meet the same bearings: without unbalance nothing moves, and with it as much as the exact circle."""
    balls = {
        "orbit_radius": 0.05,
        "drag": {"law": "beta", "beta": 1e-3},
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

"""Rings partly filled with liquid: loads in closed form, steady response, self-excitation, and what is refused."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import autobalancer as ab
from autobalancer.errors import MachineError, QuestionError
from autobalancer.laws.ring_of_liquid import Ring, growth_rate, whirl_speeds
from autobalancer.machine import Machine

RING = Ring(radius=0.25, height=0.1, layer=0.02, density=1150.0)
MASS, STIFFNESS = 30.0, 30.0 * 25.0**2


def machine(ring: dict[str, Any] | None = None, **more: Any) -> Machine:
    given = {"radius": 0.25, "height": 0.1, "layer": 0.02, "fluid": {"density": 1150.0, "viscosity": 1.5e-6}}
    return Machine(
        **{
            "name": "drum",
            "axis": "vertical",
            "rotor": {"mass": MASS, "stiffness": STIFFNESS, "damping": 120.0},
            "unbalances": [{"mass": 0.3, "radius": 0.25}],
            "liquid_rings": [given | (ring or {})],
            "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
        }
        | more
    )


def by_pressure(ring: Ring, surface: float, deflection: float) -> float:
    """S from the pressure rho (s^2 - b^2)/2 on the wet part of the wall, integrated around it."""
    angle = (np.arange(200_000) + 0.5) * 2.0 * np.pi / 200_000
    s2 = deflection**2 + ring.radius**2 + 2.0 * deflection * ring.radius * np.cos(angle)
    pressure = 0.5 * ring.density * np.maximum(s2 - surface**2, 0.0)
    return float(np.mean(pressure * np.cos(angle)) * 2.0 * np.pi * ring.radius * ring.height)


@pytest.mark.parametrize("deflection", [0.001, 0.015, 0.03, 0.1, 0.24, 0.26, 0.4])
def test_the_load_on_the_ring_is_that_of_the_pressure_on_its_wet_wall(deflection: float) -> None:
    surface = RING.wet_radius(deflection)
    assert RING.moment(deflection) == pytest.approx(by_pressure(RING, surface, deflection), rel=1e-7)


def test_the_liquid_keeps_its_volume_when_the_wall_falls_dry() -> None:
    for deflection in (0.021, 0.1, 0.3):
        b, x = RING.wet_radius(deflection), np.linspace(-0.25, 0.25, 400_001)
        half = np.sqrt(RING.radius**2 - x**2)  # of the circle of the wall, centered here
        dry = np.minimum(half, np.sqrt(np.maximum(b**2 - (x + deflection) ** 2, 0.0)))
        volume = np.trapezoid(2.0 * (half - dry), x) * RING.height
        assert volume * RING.density == pytest.approx(RING.mass, rel=1e-4)


def test_a_covered_wall_carries_the_mass_of_a_full_ring_and_a_dry_one_less() -> None:
    full = math.pi * 1150.0 * 0.25**2 * 0.1
    assert RING.moment(0.0199) == pytest.approx(full * 0.0199, rel=1e-12)
    assert RING.moment(0.02 * (1 + 1e-9)) == pytest.approx(full * 0.02, rel=1e-6)
    shares = [RING.moment(r) / (full * r) for r in (0.02, 0.03, 0.1, 1.0)]
    assert all(more > less for more, less in pairwise(shares))
    # far off the surface is straight, and the liquid a segment with its centroid at 2 R^3 sin^3(h) / (3 area)
    area = RING.mass / (1150.0 * 0.1)
    half = brentq(lambda h: 0.25**2 * (h - math.sin(h) * math.cos(h)) - area, 0.1, 3.0)
    assert RING.moment(100.0) / RING.mass - 100.0 == pytest.approx(
        2.0 * (0.25 * math.sin(half)) ** 3 / (3.0 * area), rel=1e-3
    )


def test_liquid_leaves_the_share_of_the_masses_far_above_the_critical_speed() -> None:
    found = ab.rotor.liquid_response(machine(), [3000.0])
    full = math.pi * 1150.0 * 0.25**2 * 0.1
    assert float(found["share"][0]) == pytest.approx(MASS / (MASS + full), rel=1e-3)
    less = ab.rotor.liquid_response(machine({"layer": 0.004}), [3000.0])
    assert float(less["share"][0]) == pytest.approx(float(found["share"][0]), rel=1e-9), "however little liquid"
    assert float(less["liquid_moment"][0]) > float(found["liquid_moment"][0])


def test_liquid_acts_like_mass_below_and_above_the_critical_speed() -> None:
    speeds = np.array([12.0, 60.0, 90.0])
    found = ab.rotor.liquid_response(machine(), speeds)
    full = math.pi * 1150.0 * 0.25**2 * 0.1
    expected = 0.075 * speeds**2 / np.abs(STIFFNESS - (MASS + full) * speeds**2 + 120j * speeds)
    assert found["deflection"].values == pytest.approx(expected, rel=1e-9)
    assert float(found["share"][0]) > 1.0, "below it the liquid adds to the unbalance"
    same = ab.rotor.response(
        machine(liquid_rings=(), rotor={"mass": MASS + full, "stiffness": STIFFNESS, "damping": 120.0}), speeds
    )
    assert found["deflection"].values == pytest.approx(same["semi_major"].values[:, 0], rel=1e-9)
    assert found["phase"].values == pytest.approx(same["phase"].values[:, 0], abs=1e-9)


def test_a_large_unbalance_dries_the_wall_and_is_balanced_less() -> None:
    heavy = machine({"layer": 0.002}, unbalances=[{"mass": 0.8, "radius": 0.25}])
    found = ab.rotor.liquid_response(heavy, [100.0])
    light = ab.rotor.liquid_response(machine({"layer": 0.002}, unbalances=[{"mass": 0.1, "radius": 0.25}]), [100.0])
    assert str(found["wall"].values[0]) == "partly dry"
    assert str(light["wall"].values[0]) == "covered"
    assert float(found["share"][0]) > 1.1 * float(light["share"][0])
    deflection = float(found["deflection"][0])
    ring = Ring(0.25, 0.1, 0.002, 1150.0)
    force = (STIFFNESS - MASS * 1e4 + 120j * 100.0) * deflection - 1e4 * by_pressure(
        ring, ring.wet_radius(deflection), deflection
    )
    assert abs(force) == pytest.approx(1e4 * 0.2, rel=1e-6)


def test_viscosity_and_its_law_do_not_affect_a_steady_whirl() -> None:
    thick = {"density": 1150.0, "viscosity": 1e-3, "shear": {"law": "carreau", "time": 1.0, "exponent": 1.8}}
    one, other = (
        ab.rotor.liquid_response(machine({"fluid": fluid}), [100.0])
        for fluid in (thick, {"density": 1150.0, "viscosity": 1e-6})
    )
    assert float(one["deflection"][0]) == float(other["deflection"][0])


def test_small_motions_have_the_limits_of_a_full_and_an_empty_ring() -> None:
    w = 60.0
    full = Ring(0.25, 0.1, 0.25 * (1 - 1e-9), 1150.0)
    rotor = whirl_speeds((full,), MASS, STIFFNESS, w)
    expected = math.sqrt(STIFFNESS / (MASS + full.full_mass))
    assert np.abs(rotor - expected).min() < 1e-4
    empty = Ring(0.25, 0.1, 1e-12, 1150.0)
    assert np.abs(whirl_speeds((empty,), MASS, STIFFNESS, w) - 25.0).min() < 1e-2


def test_a_free_layer_in_a_held_ring_has_its_surface_waves() -> None:
    # a held ring is one of infinite stiffness: s^2 (1 + q) with s = W - w, surface waves of a turning layer
    w, q = 60.0, (0.25 / 0.23) ** 2
    waves = whirl_speeds((RING,), MASS, 1e15, w)
    near = np.sort(waves[np.abs(waves) < 1e4].real)
    expected = w * (2.0 * q + np.array([-1.0, 1.0]) * math.sqrt(2.0 * q * (q - 1.0))) / (1.0 + q)
    assert near == pytest.approx(expected, rel=1e-6)


def test_a_load_without_viscosity_does_no_work_on_a_neutral_whirl() -> None:
    # roots of a polynomial with real coefficients come in pairs, so damping of the supports alone moves them off the axis
    real = whirl_speeds((RING,), MASS, STIFFNESS, 15.0)
    assert np.abs(real.imag).max() < 1e-9
    assert growth_rate((RING,), MASS, STIFFNESS, 15.0) == 0.0


def test_the_rotor_is_self_excited_in_a_band_above_the_critical_speed_with_the_liquid() -> None:
    found = ab.rotor.liquid_response(machine(), [30.0])
    a = found.attrs
    assert a["critical_speed"] < a["unstable_from"] < 30.0 < a["unstable_to"] < 2.0 * a["dry_critical_speed"]
    ends = np.array([a["unstable_from"], a["unstable_to"]])
    assert (growth_rate((RING,), MASS, STIFFNESS, ends) > 0.0).all(), "the ends of the band are not those of a grid"
    assert (growth_rate((RING,), MASS, STIFFNESS, ends * [1.0 - 1e-8, 1.0 + 1e-8]) == 0.0).all()
    rate = float(found["growth_rate"][0])
    roots = whirl_speeds((RING,), MASS, STIFFNESS, 30.0)
    grows = roots[np.argmin(roots.imag)]
    assert rate == pytest.approx(-grows.imag) != 0.0
    # the linear equations at this root hold, worked out from the flow: ring, free surface, force
    w, s = 30.0, grows - 30.0
    q, full = (0.25 / 0.23) ** 2, RING.full_mass
    c = np.linalg.solve(  # a - c = i s z at the wall, pressure zero on the moving surface; c in units of R^2
        np.array([[1.0, -1.0], [(w + s) ** 2, q * ((s - w) ** 2 - 2.0 * w**2)]]), np.array([1j * s, 0.0])
    )
    force = full * (w**2 - 1j * ((s + 2.0 * w) * c[0] + (s - 2.0 * w) * c[1]))
    assert STIFFNESS - MASS * grows**2 == pytest.approx(force, rel=1e-8)


def test_two_rings_act_like_one_of_both_heights() -> None:
    half = {"height": 0.05}
    two = machine(half).model_copy(update={"liquid_rings": machine(half).liquid_rings * 2})
    one = ab.rotor.liquid_response(machine(), [30.0, 90.0])
    both = ab.rotor.liquid_response(two, [30.0, 90.0])
    for name in ("deflection", "growth_rate", "liquid_moment"):
        assert both[name].values == pytest.approx(one[name].values, rel=1e-5)


@pytest.mark.parametrize(
    ("ring", "message"),
    [
        ({"liquid": 1.0}, "give either 'layer' or 'liquid'"),
        ({"layer": None}, "give either 'layer' or 'liquid'"),
        ({"layer": 0.3}, "layer: given 300 mm, which fills the ring"),
        ({"width": 0.01}, "layer: given 20 mm, which fills the ring; must be less than 10 mm"),
        ({"width": 0.3}, "width: given 300 mm, but the outer wall is at 250 mm"),
        ({"layer": -0.01}, "must be greater than zero"),
        ({"radius": 0.0}, "must be greater than zero"),
    ],
)
def test_a_ring_that_is_none_is_refused(ring: dict[str, Any], message: str) -> None:
    with pytest.raises(MachineError, match=message):
        machine(ring)


def test_more_liquid_than_fits_is_refused() -> None:
    with pytest.raises(MachineError, match=r"liquid_rings\[1\].liquid: given 50 kg, but the ring holds"):
        ab.rotor.liquid_response(machine({"layer": None, "liquid": 50.0, "width": 0.05}), [30.0])


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"rotor": {"mass": 30.0, "stiffness": (1e4, 2e4), "damping": 120.0}}, "supports differ along x and y"),
        ({"rotor": {"kind": "rigid", "mass": 30.0, "transverse_inertia": 1.0, "inertia": 2.0}}, "planar rotor only"),
        ({"unbalances": []}, "unbalances: there is none"),
        ({"liquid_rings": []}, "has no 'liquid_rings'"),
    ],
)
def test_what_has_no_steady_whirl_here_is_refused(more: dict[str, Any], message: str) -> None:
    if more.get("rotor", {}).get("kind") == "rigid":
        rig = ab.example("rigid_rotor")
        described = Machine(
            **{name: getattr(rig, name) for name in ("name", "axis", "rotor", "stations", "drive")},
            unbalances=rig.unbalances,
            liquid_rings=machine().liquid_rings,
        )
    else:
        described = machine(**more)
    with pytest.raises((MachineError, QuestionError), match=message):
        ab.rotor.liquid_response(described, [30.0])


@pytest.mark.parametrize("speeds", [[], [0.0], [-1.0], [math.nan]])
def test_speeds_must_be_above_zero(speeds: list[float]) -> None:
    with pytest.raises(QuestionError, match="speeds: give at least one"):
        ab.rotor.liquid_response(machine(), speeds)


@pytest.mark.parametrize(
    "asked",
    [
        lambda one: ab.simulate(one, duration=1.0),
        lambda one: ab.rotor.modes(one),
        lambda one: ab.rotor.response(one, [10.0]),
        lambda one: ab.stability.borders(one),
        lambda one: ab.stepped_response(one, [10.0], dwell=1.0, window=0.5),
        lambda one: ab.compare([one, one]),
    ],
)
def test_questions_that_do_not_know_liquid_refuse_it(asked: Any) -> None:
    with pytest.raises(QuestionError, match="does not know liquid with a free surface"):
        asked(machine())


def test_a_check_says_what_the_rings_hold() -> None:
    text = str(ab.check(machine()))
    assert "3.468 kg of liquid in a layer of 20 mm" in text
    assert "all other rows are those without liquid" in text


def test_balls_and_liquid_on_one_rotor_are_refused() -> None:
    race = {
        "orbit_radius": 0.1,
        "drag": {"law": "viscous", "damping": 1e-4},
        "balls": [{"count": 2, "mass": 0.01, "motion": "point"}],
    }
    with pytest.raises(MachineError, match="balls and rings of liquid on one rotor"):
        machine(balancers=[{"races": [race]}])


def test_a_slow_ring_does_not_hold_its_liquid() -> None:
    found = ab.rotor.liquid_response(machine(axis="horizontal"), [5.0, 30.0])
    assert [str(text) for text in found["wall"].values] == ["liquid falls", "covered"]
    assert math.isnan(float(found["deflection"][0]))


def test_the_picture_has_the_curves_the_band_and_the_balls() -> None:
    found = ab.rotor.liquid_response(machine(), np.linspace(12.0, 100.0, 40))
    figure = ab.plot.answer(found, balls=([60.0, 90.0], [1e-4, 1e-4]))
    (axes,) = figure.axes
    labels = [line.get_label() for line in axes.get_lines()]
    assert labels == ["without liquid", "liquid frozen", "liquid", "balls"]
    drawn = axes.get_lines()[2]
    assert drawn.get_ydata() == pytest.approx(1e3 * found["deflection"].values)

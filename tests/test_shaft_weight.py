"""Weight along the axis of a shaft: what hangs is righted, what stands falls or buckles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import jn_zeros
from tests.references.shafts import frequencies, model_of, part, shaft

import autobalancer as ab
from autobalancer.assembly.rotors.shaft import mesh, tensions
from autobalancer.machine import Machine
from autobalancer.simulation.record import Samples

G = 9.80665
HINGE = [{"position": 0.0, "stiffness": 1e9}]
POINT = {"mass": 3.0, "transverse_inertia": 0.0, "polar_inertia": 0.0}
LIGHT = {"density": 1e-3, "youngs_modulus": 2.1e11, "poisson_ratio": 0.3}
HANGING = {"up": "-z", "thrust_bearing": 0.0}
PINNED, CLAMPED = (0, -2), (0, 1)
BENDING = 2.1e11 * math.pi / 64.0 * 0.005**4  # of 5 mm, E I


def pendulum(offset: float = 0.0, **more: object) -> dict:
    disk = {"position": 1.0, "offset": offset, **POINT}
    usual = {"diameter": 0.005, "elements": 6, "material": LIGHT, "disks": [disk], "supports": HINGE, **HANGING}
    return shaft(**(usual | more))


@pytest.mark.parametrize("offset", [0.0, 0.3, -0.3])
def test_a_mass_hanging_from_a_hinge_swings_like_a_pendulum(offset: float) -> None:
    stiff = {**LIGHT, "youngs_modulus": 2.1e17}
    found = frequencies(model_of(pendulum(offset, material=stiff)))[0]
    assert found == pytest.approx(math.sqrt(G / (1.0 + offset)), rel=1e-5)


def test_a_mass_on_a_string_swings_like_a_pendulum() -> None:
    assert frequencies(model_of(pendulum()))[0] == pytest.approx(math.sqrt(G), rel=1e-6)


def test_a_body_on_a_string_is_the_compound_pendulum() -> None:
    body = {"position": 1.0, "mass": 3.0, "offset": 0.2, "transverse_inertia": 0.05, "polar_inertia": 0.01}
    stiff = {**LIGHT, "youngs_modulus": 2.1e17}
    found = frequencies(model_of(pendulum(material=stiff, disks=[body])))[0]
    assert found == pytest.approx(math.sqrt(3.0 * G * 1.2 / (3.0 * 1.2**2 + 0.05)), rel=1e-5)


def test_a_body_under_a_string_feels_its_own_weight_at_its_arm() -> None:
    """Two degrees of freedom: string of length 1 and a rigid body below it, the double pendulum."""
    body = {"position": 1.0, "mass": 3.0, "offset": 0.2, "transverse_inertia": 0.05, "polar_inertia": 0.01}
    soft = {"density": 10.0, "youngs_modulus": 1.0, "poisson_ratio": 0.3}
    rotor = shaft(diameter=0.005, elements=1, material=soft, disks=[body], supports=HINGE, **HANGING)
    pieces = [(0.99, 10), (0.009, 9), (0.001, 4)]
    segments = [{"length": length, "diameter": 0.005, "elements": count} for length, count in pieces]
    model = model_of({**rotor, "segments": segments})
    mass = np.array([[3.0, 0.6], [0.6, 0.05 + 3.0 * 0.04]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, np.diag([3.0 * G, 0.6 * G])))))
    assert frequencies(model)[:2] == pytest.approx(expected, rel=2e-3)


def test_tension_raises_the_frequencies_of_a_pinned_shaft_as_the_closed_form_says() -> None:
    end = {"position": 1.0, **POINT, "mass": 0.02}
    pins = [{"position": z, "stiffness": 1.0} for z in (0.0, 1.0)]
    thin = {"diameter": 0.0005, "material": {**LIGHT, "density": 1.0}}
    rotor = shaft(elements=40, disks=[end], supports=pins, **thin, **HANGING)
    pull, mass, bending = 0.02 * G, math.pi / 4.0 * 0.0005**2, 1e-4 * BENDING
    waves = math.pi * np.arange(1, 4)
    found = frequencies(model_of(rotor), PINNED)[:3]
    assert found == pytest.approx(np.sqrt((bending * waves**4 + pull * waves**2) / mass), rel=3e-6)
    bare = frequencies(model_of(rotor, gravity=0.0), PINNED)[:3]
    assert bare == pytest.approx(np.sqrt(bending * waves**4 / mass), rel=3e-6)


@pytest.mark.parametrize("up", ["-z", "+z"])
def test_a_mass_on_a_clamped_shaft_is_held_by_bending_and_tension(up: str) -> None:
    rotor = pendulum(
        supports=[{"position": 0.0, "stiffness": 1e9, "tilt_stiffness": 1e7}], up=up, shear_coefficient=1e6
    )
    rotor["segments"][0]["elements"] = 20
    rotor["disks"][0]["mass"] = 1.2
    pull = 1.2 * G
    a = math.sqrt(pull / BENDING)
    compliance = (1.0 - math.tanh(a) / a) / pull if up == "-z" else (math.tan(a) / a - 1.0) / pull
    assert frequencies(model_of(rotor))[0] == pytest.approx(1.0 / math.sqrt(1.2 * compliance), rel=1e-5)


def test_a_heavy_chain_hangs_with_the_frequencies_of_bessel() -> None:
    soft = {"density": 7850.0, "youngs_modulus": 2e3, "poisson_ratio": 0.3}
    rotor = shaft(diameter=0.005, elements=200, material=soft, supports=HINGE, **HANGING)
    expected = 0.5 * jn_zeros(0, 3) * math.sqrt(G)
    assert frequencies(model_of(rotor))[:3] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("up", "foot"), [("-z", 1.0), ("+z", 0.0)])
def test_a_standing_column_buckles_at_the_height_of_greenhill(up: str, foot: float) -> None:
    clamp = [{"position": foot, "stiffness": 1e9, "tilt_stiffness": 1e7}]
    column = {"diameter": 0.005, "elements": 20, "supports": clamp, "up": up, "thrust_bearing": foot}
    weight = 7850.0 * math.pi / 4.0 * 0.005**2
    critical = 7.8373474 * BENDING / weight
    held = model_of(shaft(**column), gravity=critical * (1.0 - 1e-4))
    assert frequencies(held)[0] < 0.02 * frequencies(model_of(shaft(**column), gravity=0.0))[0]
    with pytest.raises(ValueError, match=r"rotor\.up: the rotor falls over or buckles under its weight"):
        model_of(shaft(**column), gravity=critical * (1.0 + 1e-4))


def test_the_thrust_bearing_parts_tension_below_from_compression_above() -> None:
    disks = [{"position": z, **POINT, "mass": m} for z, m in ((0.0, 1.0), (0.5, 20.0), (1.0, 2.0))]
    pins = [{"position": z, "stiffness": 1e6} for z in (0.0, 1.0)]
    own = 7850.0 * math.pi / 4.0 * 0.01**2
    for up, sign in (("-z", 1.0), ("+z", -1.0)):
        rotor = part(shaft(diameter=0.01, elements=2, disks=disks, supports=pins, up=up, thrust_bearing=0.5))
        above, below = tensions(rotor, mesh(rotor), 10.0)
        assert above == pytest.approx((-sign * 10.0, -sign * 10.0 * (1.0 + 0.5 * own)), rel=1e-12)
        assert below == pytest.approx((sign * 10.0 * (2.0 + 0.5 * own), sign * 20.0), rel=1e-12)


def test_turning_a_hanging_rotor_upside_down_together_with_up_changes_nothing() -> None:
    disk = {"mass": 6.8, "transverse_inertia": 0.04, "polar_inertia": 0.07}
    clamp = {"stiffness": 1e7, "tilt_stiffness": 1e4}
    one = shaft(
        length=0.17, diameter=0.006, disks=[{"position": 0.17, "offset": 0.05, **disk}],
        supports=[{"position": 0.0, **clamp}], up="-z", thrust_bearing=0.0,
    )  # fmt: skip
    other = shaft(
        length=0.17, diameter=0.006, disks=[{"position": 0.0, "offset": -0.05, **disk}],
        supports=[{"position": 0.17, **clamp}], up="+z", thrust_bearing=0.17,
    )  # fmt: skip
    hanging, turned = frequencies(model_of(one)), frequencies(model_of(other))
    slow = hanging < 1e5  # those of single elements, above 1e6 rad/s, have lost a digit more by rounding
    assert slow.sum() >= 8
    assert hanging[slow] == pytest.approx(turned[slow], rel=1e-7)
    assert hanging == pytest.approx(turned, rel=1e-6)


def test_weight_acts_only_along_a_vertical_axis_and_where_it_is_asked_for() -> None:
    held = {"supports": [{"position": z, "stiffness": 1e5} for z in (0.0, 1.0)]}
    hanging = frequencies(model_of(pendulum(**held)))
    free = pendulum(**held)
    del free["up"], free["thrust_bearing"]
    for other in (
        model_of(free),
        model_of(pendulum(**held), axis="horizontal"),
        model_of(pendulum(**held), gravity=0.0),
    ):
        assert frequencies(other) == pytest.approx(frequencies(model_of(free)), rel=1e-12)
        assert frequencies(other)[0] < 0.99999 * hanging[0]


@pytest.mark.parametrize("up", ["-z", "+z"])
def test_a_ball_in_the_race_of_a_swinging_plumb_bob_stays_where_it_is(up: str) -> None:
    """Bob and ball fall alike: what inertia asks of the ball across the string is what its weight gives there."""
    low, high = (1.0, 0.0) if up == "-z" else (0.0, 1.0)
    stiff = {**LIGHT, "youngs_modulus": 2.1e15}
    hanging = {"up": up, "thrust_bearing": high, "supports": [{"position": high, "stiffness": 1e9}]}
    ball = {"mass": 1e-6, "motion": "point", "start_angles": [0.5 * math.pi]}
    race = {"orbit_radius": 0.05, "drag": {"law": "viscous", "damping": 1e-12}, "balls": [ball]}
    plumb = Machine.model_validate(
        {
            "name": "plumb bob",
            "axis": "vertical",
            "tilting_races": "full",
            "rotor": pendulum(disks=[{"position": low, **POINT}], material=stiff, modes=1, **hanging),
            "stations": [{"name": "bob", "position": low}],
            "balancers": [{"station": "bob", "races": [race]}],
            "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
            "start": {"deflection": (1e-3, 0.0)},
        }
    )
    run = ab.simulate(plumb, duration=2.0, save=Samples(21))
    assert run["x"].values == pytest.approx(1e-3 * np.cos(math.sqrt(G) * run["time"].values), abs=2e-6)
    # weight of the wrong sign, or none, would move it by 0.04 rad or more
    assert run["ball_angle_in_rotor"].values == pytest.approx(0.5 * math.pi, abs=1e-6)

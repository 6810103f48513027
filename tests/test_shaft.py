"""The flexible shaft against closed forms of beams, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.references.shafts import STEEL, frequencies, machine, model_of, part, shaft, whirl

from autobalancer.assembly.rotors import lateral_model, rows_at, unbalance_load
from autobalancer.assembly.rotors.shaft import Element, cowper

PINS = [{"position": 0.0, "stiffness": 1.0}, {"position": 1.0, "stiffness": 1.0}]  # pinned by leaving coordinates out
CLAMP = [{"position": 0.0, "stiffness": 1.0, "tilt_stiffness": 1.0}]
PINNED, CLAMPED = (0, -2), (0, 1)
STIFF = {"density": 1e-3, "youngs_modulus": 1e19, "poisson_ratio": 0.3}


def numbers(rotor: dict) -> tuple[float, float, float, float]:
    """E I, kappa G A, rho A, rho I."""
    segment = part(rotor).segments[0]
    young, ratio = 2.1e11, 0.3
    kappa = cowper(ratio, float(segment.inner_diameter) / float(segment.diameter))
    bending = young * segment.second_moment
    return bending, kappa * young / 2.6 * segment.area, 7850.0 * segment.area, 7850.0 * segment.second_moment


def timoshenko_pinned(rotor: dict, wave: float, speed: float = 0.0) -> np.ndarray:
    """Whirl frequencies of one half wave shape of a pinned beam of sin and cos, rad/s, ascending."""
    bending, shearing, mass, rotary = numbers(rotor)
    across = np.array([-mass, 0.0, shearing * wave**2])
    tilting = np.array([-rotary, 2.0 * rotary * speed, bending * wave**2 + shearing])
    return np.sort(np.roots(np.polysub(np.polymul(across, tilting), [(shearing * wave) ** 2])).real)


# beams


def test_a_slender_pinned_shaft_has_the_frequencies_of_euler_and_bernoulli() -> None:
    rotor = shaft(diameter=1e-4, elements=60, supports=PINS)
    bending, _, mass, _ = numbers(rotor)
    expected = (np.arange(1, 4) * math.pi) ** 2 * math.sqrt(bending / mass)
    assert frequencies(model_of(rotor), PINNED)[:3] == pytest.approx(expected, rel=1e-6)


def test_a_slender_cantilever_with_a_tip_mass_has_the_frequencies_of_the_beam_equation() -> None:
    share = 0.7
    rotor = shaft(diameter=1e-4, elements=60, supports=CLAMP)
    bending, _, mass, _ = numbers(rotor)
    tip = {"position": 1.0, "mass": share * mass, "transverse_inertia": 0.0, "polar_inertia": 0.0}

    def condition(b: float) -> float:
        c, s, ch, sh = math.cos(b), math.sin(b), math.cosh(b), math.sinh(b)
        return 1.0 + c * ch + share * b * (c * sh - s * ch)

    roots = np.array([brentq(condition, *ends, xtol=1e-14) for ends in ((1.0, 2.0), (3.5, 4.6), (6.5, 7.8))])
    found = frequencies(model_of({**rotor, "disks": [tip]}), CLAMPED)[:3]
    assert found == pytest.approx(roots**2 * math.sqrt(bending / mass), rel=1e-6)


def without_mesh(rotor: dict, speed: float, wanted: np.ndarray) -> np.ndarray:
    """The whirl frequencies nearest to the ``wanted``, extrapolated over two meshes, errors being of order two."""
    found = []
    for count in (48, 96):
        segments = [{**rotor["segments"][0], "elements": count}]
        all_of_them = whirl(model_of({**rotor, "segments": segments}), speed, PINNED)
        found.append(all_of_them[np.abs(all_of_them[:, None] - wanted).argmin(axis=0)])
    return (4.0 * found[1] - found[0]) / 3.0


@pytest.mark.parametrize("inner", [0.0, 0.06])
@pytest.mark.parametrize("speed", [0.0, 500.0, 4000.0])
def test_a_thick_turning_pinned_shaft_has_the_whirl_frequencies_of_timoshenko(inner: float, speed: float) -> None:
    rotor = shaft(diameter=0.1, inner_diameter=inner, supports=PINS)
    expected = np.concatenate([timoshenko_pinned(rotor, n * math.pi, speed)[1:3] for n in (1, 2, 3)])
    assert without_mesh(rotor, speed, expected) == pytest.approx(expected, rel=3e-7)


def test_forward_whirl_is_faster_and_backward_whirl_slower_than_vibration_at_rest() -> None:
    model = model_of(shaft(diameter=0.1, supports=PINS))
    found, rest = whirl(model, 4000.0, PINNED), frequencies(model, PINNED)[0]
    assert found[found > 0.0][0] > rest * (1.0 + 1e-3)
    assert -found[found < 0.0][-1] < rest * (1.0 - 1e-3)


def order(diameter: float, counts: tuple[int, ...], mode: int) -> np.ndarray:
    errors = []
    for count in counts:
        rotor = shaft(diameter=diameter, elements=count, supports=PINS)
        exact = timoshenko_pinned(rotor, mode * math.pi)[2]
        errors.append(frequencies(model_of(rotor), PINNED)[mode - 1] / exact - 1.0)
    assert min(errors) > 0.0
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_frequencies_of_a_slender_shaft_converge_with_order_four_from_above() -> None:
    assert order(2e-3, (4, 8, 16), 2) == pytest.approx(4.0, abs=0.1)


def test_frequencies_converge_with_order_two_where_elements_are_shorter_than_the_shaft_is_thick() -> None:
    assert order(0.2, (32, 64, 128), 2) == pytest.approx(2.0, abs=0.05)


# the element


ELEMENT = Element(length=0.3, bending=2e4, shearing=3e7, mass=15.0, rotary=0.02)


def test_an_element_moves_and_tilts_as_a_rigid_body_without_force() -> None:
    stiffness = ELEMENT.stiffness()
    for motion in ([1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.3, 1.0]):
        assert np.abs(stiffness @ motion).max() < 1e-12 * np.abs(stiffness).max()
    assert np.linalg.matrix_rank(stiffness, tol=1e-9 * np.abs(stiffness).max()) == 2


def test_a_rigid_motion_of_an_element_has_the_energy_of_a_rod() -> None:
    inertia = ELEMENT.inertia()
    shift, tilt = np.array([1.0, 0.0, 1.0, 0.0]), np.array([0.0, 1.0, 0.3, 1.0])
    assert shift @ inertia @ shift == pytest.approx(4.5, rel=1e-13)
    assert shift @ inertia @ tilt == pytest.approx(4.5 * 0.15, rel=1e-13)
    assert tilt @ inertia @ tilt == pytest.approx(4.5 * 0.3**2 / 3.0 + 0.006, rel=1e-13)
    assert tilt @ ELEMENT.gyroscopic() @ tilt == pytest.approx(0.012, rel=1e-13)


def test_a_tilted_element_under_tension_is_pulled_back_like_a_string() -> None:
    tilt = np.array([0.0, 1.0, 0.3, 1.0])
    assert tilt @ ELEMENT.tension(50.0, 50.0) @ tilt == pytest.approx(50.0 * 0.3, rel=1e-13)
    assert tilt @ ELEMENT.tension(50.0, 20.0) @ tilt == pytest.approx(35.0 * 0.3, rel=1e-13)


def test_the_stiffness_is_that_of_timoshenko_in_closed_form() -> None:
    length, phi = 0.3, ELEMENT.phi
    expected = np.array([
        [12.0, 6.0 * length, -12.0, 6.0 * length],
        [6.0 * length, (4.0 + phi) * length**2, -6.0 * length, (2.0 - phi) * length**2],
        [-12.0, -6.0 * length, 12.0, -6.0 * length],
        [6.0 * length, (2.0 - phi) * length**2, -6.0 * length, (4.0 + phi) * length**2],
    ])  # fmt: skip
    expected *= 2e4 / (length**3 * (1.0 + phi))
    assert np.abs(ELEMENT.stiffness() - expected).max() < 1e-13 * np.abs(expected).max()


def test_the_shear_coefficient_is_cowpers_for_solid_and_thin_walled_sections() -> None:
    assert cowper(0.3, 0.0) == pytest.approx(6.0 * 1.3 / 8.8, rel=1e-14)
    assert cowper(0.3, 1.0) == pytest.approx(2.0 * 1.3 / 4.9, rel=1e-14)


# the whole matrices


RICH = shaft(
    diameter=0.03,
    elements=5,
    disks=[
        {"position": 0.33, "mass": 4.0, "transverse_inertia": 0.02, "polar_inertia": 0.03, "offset": 0.05},
        {"position": 1.0, "mass": 2.0, "transverse_inertia": 0.01, "polar_inertia": 0.015, "offset": 0.1},
    ],
    supports=[
        {"position": 0.1, "stiffness": [1e6, 2e6], "damping": 50.0},
        {"position": 0.77, "stiffness": 3e6, "tilt_stiffness": 200.0, "tilt_damping": 0.3},
    ],
    stiffness_proportional_damping=1e-5,
    up="-z",
    thrust_bearing=0.1,
)


def test_mass_and_stiffness_are_symmetric_and_the_gyroscopic_matrix_is_not() -> None:
    model = model_of(RICH)
    stiffness, damping = model.stiffness_at(0.0), model.damping_at(0.0)
    for matrix in (model.mass, stiffness, damping):
        assert np.abs(matrix - matrix.T).max() < 1e-14 * np.abs(matrix).max()
        assert np.linalg.eigvalsh(matrix)[0] > -1e-12 * np.abs(matrix).max()
    assert np.array_equal(model.gyroscopic, -model.gyroscopic.T)
    assert np.abs(model.gyroscopic).max() > 0.03
    assert not model.isotropic


def test_moving_a_shaft_as_a_rigid_body_takes_only_its_supports() -> None:
    model = model_of(RICH, gravity=0.0)
    nodes = model.axis.mesh.nodes
    for shift, tilt in ((1.0, 0.0), (0.0, 1.0), (0.3, -0.7)):
        motion = np.zeros(model.size)
        motion[: model.pairs : 2], motion[1 : model.pairs : 2] = shift + tilt * nodes, tilt
        work = motion @ model.stiffness_at(0.0) @ motion
        expected = 1e6 * (shift + 0.1 * tilt) ** 2 + 3e6 * (shift + 0.77 * tilt) ** 2 + 200.0 * tilt**2
        assert work == pytest.approx(expected, rel=1e-8)
        rotor = part(RICH)
        assert motion @ model.mass @ motion == pytest.approx(rigid_energy(shift, tilt), rel=1e-12)
        assert tilt**2 * rotor.inertia == pytest.approx(
            abs(motion @ model.gyroscopic @ np.roll(motion, model.pairs)), rel=1e-12
        )


def rigid_energy(shift: float, tilt: float) -> float:
    mass = part(RICH).segments[0].volume * 7850.0
    middle = mass * (shift + 0.5 * tilt) ** 2 + (mass / 12.0 + mass * 0.03**2 / 16.0) * tilt**2
    disks = 4.0 * (shift + 0.38 * tilt) ** 2 + 0.02 * tilt**2 + 2.0 * (shift + 1.1 * tilt) ** 2 + 0.01 * tilt**2
    return middle + disks


def test_mass_and_inertia_of_a_shaft_are_those_of_its_parts() -> None:
    rotor, model = part(RICH), model_of(RICH)
    own = math.pi / 4.0 * 0.03**2 * 7850.0
    assert rotor.mass == model.total_mass == pytest.approx(own + 6.0, rel=1e-13)
    assert rotor.inertia == model.polar_inertia == pytest.approx(own * 0.03**2 / 8.0 + 0.045, rel=1e-13)


def test_a_place_between_two_nodes_is_cut_automatically() -> None:
    whole = model_of(RICH, gravity=0.0)
    pieces = [(0.1, 1), (0.1, 1), (0.13, 1), (0.07, 1), (0.2, 1), (0.17, 1), (0.03, 1), (0.2, 1)]
    cut = model_of(
        {**RICH, "segments": [{"length": length, "diameter": 0.03, "elements": n} for length, n in pieces]}, gravity=0.0
    )
    assert whole.axis.mesh.nodes == pytest.approx(cut.axis.mesh.nodes, abs=1e-12)
    assert whole.mass == pytest.approx(cut.mass, rel=1e-9, abs=1e-12)


def test_an_element_end_beside_a_support_gives_way_to_it() -> None:
    rotor = shaft(elements=4, supports=[{"position": 0.2501, "stiffness": 1e6}, {"position": 1.0, "stiffness": 1e6}])
    assert model_of(rotor).axis.mesh.nodes == pytest.approx([0.0, 0.2501, 0.5, 0.75, 1.0], abs=1e-12)


# limits


def test_a_stiff_shaft_moves_like_a_rigid_rotor() -> None:
    disks = [
        {"position": 0.4, "mass": 5.0, "transverse_inertia": 0.03, "polar_inertia": 0.05},
        {"position": 1.0, "mass": 3.0, "transverse_inertia": 0.01, "polar_inertia": 0.02, "offset": 0.2},
    ]
    supports = [
        {"position": 0.1, "stiffness": [3e4, 5e4], "damping": [20.0, 30.0], "cross_stiffness": [4e3, -3e3]},
        {"position": 0.9, "table": {"speed": [0.0, 400.0], "stiffness": [2e4, 6e4], "damping": [10.0, 40.0]}},
    ]
    center = (5.0 * 0.4 + 3.0 * 1.2) / 8.0
    transverse = 0.04 + 5.0 * (0.4 - center) ** 2 + 3.0 * (1.2 - center) ** 2
    rest = {"stiffness_proportional_damping": 2e-4}
    stiff = {**STIFF, "youngs_modulus": 1e16}
    flexible = model_of(shaft(elements=3, material=stiff, disks=disks, supports=supports, **rest))
    moved = [{**support, "position": support["position"] - center} for support in supports]
    body = {"mass": 8.0, "transverse_inertia": transverse, "polar_inertia": 0.07}
    rigid = model_of({"kind": "rigid", **body, "supports": moved, **rest})
    places = (0.0, 0.55, 1.2)
    for speed in (0.0, 90.0, 400.0):
        seen = [
            model.receptance(1j * 77.0, speed, np.array([model.axis.rows(z - at, None).deflection for z in places]))
            for model, at in ((flexible, 0.0), (rigid, center))
        ]
        # the shaft is stiff by damping too, which the factor t makes small here
        assert seen[0] == pytest.approx(seen[1], rel=1e-5, abs=1e-6 * np.abs(seen[1]).max())


@pytest.mark.parametrize("offset", [0.2, -0.15])
def test_an_offset_disk_is_the_same_disk_on_a_stiff_massless_extension(offset: float) -> None:
    inertias = {"mass": 5.0, "transverse_inertia": 0.03, "polar_inertia": 0.05}
    supports = [{"position": 0.3, "stiffness": 1e6}, {"position": 0.8, "stiffness": 1e6}]
    weight = {"up": "-z", "thrust_bearing": 0.3}
    if offset < 0.0:  # the extension is then the left end of a longer shaft
        arm, bare = {"position": 0.0, "offset": offset, **inertias}, {"position": 0.0, **inertias}
        places = [{**s, "position": s["position"] - offset} for s in supports]
        pieces, thrust = [(-offset, STIFF), (1.0, STEEL)], {"up": "-z", "thrust_bearing": 0.3 - offset}
    else:
        arm, bare = {"position": 1.0, "offset": offset, **inertias}, {"position": 1.0 + offset, **inertias}
        places, pieces, thrust = supports, [(1.0, STEEL), (offset, STIFF)], weight
    one = model_of(shaft(diameter=0.02, disks=[arm], supports=supports, **weight))
    segments = [
        {"length": length, "diameter": 0.02, "elements": 8 if m is STEEL else 1, "material": m} for length, m in pieces
    ]
    other = model_of({"kind": "shaft", "segments": segments, "disks": [bare], "supports": places, **thrust})
    shift = max(-offset, 0.0)
    for speed in (0.0, 150.0):
        lines = [(one, 0.0), (other, shift)]
        rows = [
            np.array(
                [m.axis.rows(z + at, None).deflection for z in (0.5, min(offset, 1.0) if offset < 0 else 1.0 + offset)]
            )
            for m, at in lines
        ]
        seen = [m.receptance(20j, speed, r) for (m, _), r in zip(lines, rows, strict=True)]
        assert seen[0] == pytest.approx(seen[1], rel=1e-5, abs=1e-7 * np.abs(seen[1]).max())


# stations


def test_a_station_between_nodes_sees_the_exact_static_deflection() -> None:
    rotor = shaft(diameter=0.1, elements=1, supports=[{"position": 0.0, "stiffness": 1e15, "tilt_stiffness": 1e15}])
    model = model_of(rotor)
    bending, shearing, _, _ = numbers(rotor)
    z = np.array([0.2, 0.5, 0.81, 1.0])
    rows = [model.axis.rows(float(place), None) for place in z]
    seen = np.array([row.deflection for row in rows])
    found = model.receptance(0.0, 0.0, seen)[: z.size, z.size - 1].real
    assert found == pytest.approx(z**2 * (3.0 - z) / (6.0 * bending) + z / shearing, rel=1e-7)
    load = np.linalg.solve(model.stiffness_at(0.0)[:4, :4], seen[-1])
    assert [row.slope @ load for row in rows] == pytest.approx(z * (2.0 - z) / (2.0 * bending), rel=1e-7)


def test_an_unbalance_at_a_station_loads_its_place() -> None:
    stations = [{"name": "middle", "position": 0.47}]
    both = machine(
        shaft(supports=PINS), stations=stations, unbalances=[{"moment": 2e-3, "angle": "90 deg", "station": "middle"}]
    )
    model = lateral_model(both)
    load = unbalance_load(both, model)
    assert load.real == pytest.approx(np.zeros(model.pairs), abs=1e-15)
    assert load.imag == pytest.approx(2e-3 * model.axis.rows(0.47, None).deflection)
    assert load.imag[::2].sum() == pytest.approx(2e-3, rel=1e-12)


def test_places_on_a_rigid_arm_move_with_its_foot() -> None:
    disk = {"name": "bell", "position": 1.0, "mass": 1.0, "transverse_inertia": 0.0, "polar_inertia": 0.0}
    disk |= {"offset": 0.1, "extent": [-0.3, 0.25]}
    model = model_of(shaft(disks=[disk], supports=PINS))
    foot = model.axis.rows(1.0, None)
    for place, body in ((1.2, None), (1.25, None), (0.8, "bell")):
        rows = model.axis.rows(place, body)
        assert rows.deflection == pytest.approx(foot.deflection + (place - 1.0) * foot.slope, rel=1e-12)
        assert np.array_equal(rows.slope, foot.slope)
    assert model.axis.rows(None, None).deflection == pytest.approx(foot.deflection + 0.1 * foot.slope)
    assert np.abs(model.axis.rows(0.8, None).deflection - model.axis.rows(0.8, "bell").deflection).max() > 0.1
    line = [z for z, _ in model.axis.line()]
    assert line == sorted(line)
    assert (line[0], line[-1]) == pytest.approx((0.0, 1.25))


@pytest.mark.parametrize(
    ("place", "body", "message"),
    [
        (1.3, None, "position 1.3 m: nothing is there; the shaft reaches from 0 to 1 m; disk bell from 0.7 to 1.25 m"),
        (-0.1, None, "position -0.1 m: nothing is there"),
        (0.6, "bell", "position 0.6 m: disk 'bell' reaches from 0.7 to 1.25 m only"),
        (0.6, "cup", "body 'cup': no disk has this name; there is 'bell'"),
    ],
)
def test_a_place_beside_the_rotor_is_refused_with_its_name(place: float, body: str | None, message: str) -> None:
    disk = {"name": "bell", "position": 1.0, "mass": 1.0, "transverse_inertia": 0.0, "polar_inertia": 0.0}
    disk |= {"extent": [-0.3, 0.25]}
    station = {"name": "race", "position": place, "body": body}
    refused = machine(shaft(disks=[disk], supports=PINS), stations=[station])
    with pytest.raises(ValueError, match=r"stations\[1\]") as error:
        rows_at(refused, lateral_model(refused), "race")
    assert message in str(error.value)

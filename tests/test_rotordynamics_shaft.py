"""Modes, branches and responses of flexible shafts and rigs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import MachineError
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.rotordynamics.campbell import campbell, critical_speeds, modes
from autobalancer.rotordynamics.response import whirl_orbits

LENGTH, DIAMETER, DENSITY, MODULUS = 2.0, 0.02, 7800.0, 2.1e11
BEAM = math.sqrt(MODULUS * DIAMETER**2 / (16.0 * DENSITY)) / LENGTH**2  # sqrt(E I / rho A) / L^2


def shaft(stiffness: Any, **rotor: Any) -> Machine:
    """A slender steel shaft held at both ends."""
    return Machine(
        name="shaft",
        axis="horizontal",
        rotor={
            "kind": "shaft",
            "material": {"density": DENSITY, "youngs_modulus": MODULUS, "poisson_ratio": 0.3},
            "segments": [{"length": LENGTH, "diameter": DIAMETER, "elements": 20}],
            "supports": [{"position": place, "stiffness": stiffness} for place in (0.0, LENGTH)],
        }
        | rotor,
        stations=[{"name": "middle", "position": 0.5 * LENGTH}, {"name": "quarter", "position": 0.25 * LENGTH}],
        unbalances=[{"moment": 1e-4, "station": "middle"}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 50.0}},
    )


def test_a_slender_shaft_on_stiff_supports_bends_in_half_waves() -> None:
    found = modes(shaft(1e10), 0.0, modes=8)
    expected = BEAM * (np.repeat([1, 2, 3, 4], 2) * math.pi) ** 2
    assert found["frequency"].values == pytest.approx(expected, rel=2e-3)
    assert list(found["name"].values[:4]) == [
        "bending 1 backward", "bending 1 forward", "bending 2 backward", "bending 2 forward",
    ]  # fmt: skip
    wave = found["x_real"].values[3]
    assert np.abs(wave) == pytest.approx(np.abs(np.sin(2.0 * math.pi * found["place"].values / LENGTH)), abs=1e-4)


def test_a_shaft_on_soft_supports_moves_as_a_rigid_body_before_it_bends() -> None:
    found = modes(shaft(10.0), 0.0, modes=8)
    assert [str(name).rsplit(" ", 1)[0] for name in found["name"].values[::2]] == [
        "cylindrical", "conical", "bending 1", "bending 2",
    ]  # fmt: skip
    assert found["frequency"].values[4] == pytest.approx(BEAM * 4.7300407**2, rel=3e-3)
    mass = DENSITY * math.pi / 4.0 * DIAMETER**2 * LENGTH
    assert found["frequency"].values[0] == pytest.approx(math.sqrt(20.0 / mass), rel=2e-3)


def test_anisotropic_supports_name_the_direction_of_bending() -> None:
    found = modes(shaft([1e10, 1e5]), 0.0, modes=4)
    assert sorted(str(name) for name in found["name"].values[:2]) == ["bending 1 x", "bending 1 y"]
    assert str(found["name"].values[0]) == "bending 1 y"


@pytest.mark.slow
def test_branches_of_a_shaft_are_followed_over_crossings_of_all_its_modes() -> None:
    disks = [{"position": 0.4, "mass": 5.0, "transverse_inertia": 0.05, "polar_inertia": 0.09}]
    machine = shaft(1e7, disks=disks)
    fine, coarse = (campbell(machine, np.linspace(0.0, 400.0, n), modes=8) for n in (81, 11))
    assert coarse["frequency"].values == pytest.approx(fine["frequency"].values[:, ::8], rel=1e-8)
    assert np.isfinite(fine["frequency"].values).all()
    for name, words in zip(fine["name"].values, fine["whirl"].values, strict=True):
        assert set(words) == {str(name).rsplit(" ", 1)[1]}
    direct = critical_speeds(machine, highest=400.0)["critical_speed"].values
    assert fine["intersection_speed"].values == pytest.approx(direct, rel=1e-8)


def test_the_response_of_a_shaft_passes_its_critical_speed_and_bends_into_the_shape_of_the_mode() -> None:
    machine = shaft(1e8, stiffness_proportional_damping=1e-4)
    critical = float(critical_speeds(machine, highest=80.0)["critical_speed"][0])
    found = ab.rotor.response(machine, [0.5 * critical, critical, 1.5 * critical])
    phase = np.degrees(found["phase"].sel(station="middle").values)
    assert phase[0] == pytest.approx(0.0, abs=1.0)
    assert phase[1] == pytest.approx(-90.0, abs=3.0)  # the higher modes follow the unbalance
    assert phase[2] == pytest.approx(-180.0, abs=1.0)
    ratio = found["semi_major"].values[1]
    assert ratio[1] / ratio[0] == pytest.approx(math.sin(math.pi / 4.0), rel=1e-3)
    orbits = whirl_orbits(machine, critical)
    reach = np.hypot(orbits["axis_x"].values[:, 0], orbits["axis_y"].values[:, 0])
    assert reach / ratio[0] == pytest.approx(np.sin(math.pi * orbits["place"].values / LENGTH), abs=3e-3)


def test_motions_of_a_damped_shaft_that_creep_are_no_modes() -> None:
    disks = [{"position": 0.4, "mass": 5.0, "transverse_inertia": 0.05, "polar_inertia": 0.09}]
    plain, damped = (
        modes(shaft(1e7, disks=disks, stiffness_proportional_damping=factor), 100.0, modes=4) for factor in (0.0, 2e-4)
    )
    assert list(damped["name"].values) == list(plain["name"].values)
    assert damped["frequency"].values == pytest.approx(plain["frequency"].values, rel=1e-2)
    assert damped["undamped_frequency"].values == pytest.approx(plain["frequency"].values, rel=1e-9)
    assert min(damped.attrs["decay_rates_without_frequency"]) > 2500.0  # about 1/(2 t) and more


def test_a_place_outside_the_shaft_is_refused() -> None:
    with pytest.raises(MachineError, match="stations"):
        ab.rotor.response(shaft(1e8), [5.0], [3.0])


def test_axial_and_torsional_modes_of_a_rig_are_named_and_do_not_whirl() -> None:
    found = modes(rig("discoidal_rig"), 40.0)
    for kind in ("axial", "torsional"):
        number = next(i for i, name in enumerate(found["name"].values) if str(name).startswith(f"{kind}, "))
        assert found["whirl"].values[number] == "straight"

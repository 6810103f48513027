"""Critical speeds: closed forms, known rigs, tables, and where there is none."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.test_rotordynamics_modes import ARM, MASS, RIG, SPRING, TRANSVERSE, planar, rigid

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.system import assemble
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine
from autobalancer.rotordynamics.campbell import campbell, critical_speeds
from autobalancer.rotordynamics.response import response_peaks
from autobalancer.stability.host.stations import stations

RPM = math.pi / 30.0
MACHINES = Path(__file__).parents[1] / "examples" / "machines"


def tabled(stiffness: list[Any], speeds: list[float], **how: Any) -> Any:
    table = {"speed": speeds, "stiffness": stiffness, "damping": [0.0] * len(speeds)}
    return with_value_at(rigid(**how), "rotor.supports", [{"position": arm, "table": table} for arm in (-ARM, ARM)])


def by_name(found: Any) -> dict[str, float]:
    return dict(zip(map(str, found["name"].values), found["critical_speed"].values, strict=True))


def test_a_planar_rotor_is_critical_at_the_root_of_stiffness_over_mass() -> None:
    found = critical_speeds(planar())
    assert found["critical_speed"].values == pytest.approx([math.sqrt(4e3)] * 2, rel=1e-13)
    assert sorted(found["whirl"].values) == ["backward", "forward"]
    split = critical_speeds(planar(stiffness=[12e3, 27e3]))
    assert split["critical_speed"].values == pytest.approx([math.sqrt(4e3), math.sqrt(9e3)], rel=1e-13)
    assert list(split["name"].values) == ["cylindrical x", "cylindrical y"]


@pytest.mark.parametrize("polar", [0.001, 0.012, 0.0199])
def test_conical_critical_speeds_have_the_inertia_less_or_more_the_polar_one(polar: float) -> None:
    found = by_name(critical_speeds(rigid(polar)))
    tilt = 2.0 * SPRING * ARM**2
    assert found["conical forward"] == pytest.approx(math.sqrt(tilt / (TRANSVERSE - polar)), rel=1e-11)
    assert found["conical backward"] == pytest.approx(math.sqrt(tilt / (TRANSVERSE + polar)), rel=1e-12)
    assert found["cylindrical forward"] == pytest.approx(math.sqrt(2.0 * SPRING / MASS), rel=1e-12)


@pytest.mark.parametrize("stiffness", [SPRING, (SPRING, 0.8 * SPRING)])
def test_a_disc_shaped_rotor_has_no_second_forward_critical_speed(stiffness: Any) -> None:
    assert critical_speeds(rigid(0.019, stiffness)).sizes["critical"] == 4
    found = critical_speeds(rigid(0.021, stiffness))
    assert found.sizes["critical"] == 3
    if stiffness == SPRING:
        assert sorted(found["name"].values) == ["conical backward", "cylindrical backward", "cylindrical forward"]


def test_the_second_harmonic_meets_the_forward_conical_whirl_of_a_disc() -> None:
    tilt = 2.0 * SPRING * ARM**2
    found = critical_speeds(rigid(0.03), harmonics=[2.0])
    expected = math.sqrt(tilt / (4.0 * TRANSVERSE - 2.0 * 0.03))
    assert by_name(found)["conical forward"] == pytest.approx(expected, rel=1e-11)
    assert set(found["harmonic"].values) == {2.0}


def test_the_rig_of_rodrigues_has_its_four_critical_speeds() -> None:
    plain = response_peaks(RIG, 100.0, 300.0, ["B1", "B2"])["peak_speed"].values / RPM
    assert plain == pytest.approx([1458.0, 1699.0, 1916.0, 2280.0], abs=1.0)
    found = critical_speeds(RIG, balls=False)
    assert found["critical_speed"].values / RPM == pytest.approx([1455.0, 1700.0, 1920.0, 2280.0], rel=0.0025)
    assert list(found["name"].values) == ["cylindrical y", "cylindrical x", "conical y", "conical x"]


def test_the_determinant_vanishes_at_a_critical_speed() -> None:
    machine = rigid(stiffness=(SPRING, 0.6 * SPRING), arms=(-0.15, 0.1))
    model = lateral_model(machine)
    found = critical_speeds(machine)
    assert found.sizes["critical"] == 4
    for w in found["critical_speed"].values:
        dynamic = model.stiffness[0] - w**2 * model.mass + 1j * w**2 * model.gyroscopic
        levels = np.abs(np.linalg.eigvalsh(dynamic))
        assert levels.min() < 1e-10 * levels.max()


@pytest.mark.parametrize("stiffness", [SPRING, (SPRING, 0.6 * SPRING)])
def test_the_direct_way_and_the_campbell_diagram_agree(stiffness: Any) -> None:
    machine = rigid(stiffness=stiffness, arms=(-0.15, 0.1))
    direct = critical_speeds(machine, highest=900.0)
    crossed = campbell(machine, np.linspace(0.0, 900.0, 46))
    assert crossed["intersection_speed"].values == pytest.approx(direct["critical_speed"].values, rel=1e-10)
    assert sorted(crossed["intersection_whirl"].values) == sorted(direct["whirl"].values)


@pytest.mark.parametrize("stiffness", [SPRING, (SPRING, 0.6 * SPRING)])
def test_a_level_table_has_the_critical_speeds_of_a_constant(stiffness: Any) -> None:
    level = critical_speeds(tabled([stiffness, stiffness], [0.0, 900.0]))
    direct = critical_speeds(rigid(stiffness=stiffness), highest=900.0)
    assert level["critical_speed"].values == pytest.approx(direct["critical_speed"].values, rel=1e-12)
    assert sorted(level["name"].values) == sorted(direct["name"].values)


def test_a_rubber_that_stiffens_with_the_speed_raises_the_critical_speed_as_its_quadratic_says() -> None:
    slope = 60.0  # N/m per rad/s
    found = by_name(critical_speeds(tabled([SPRING, SPRING + slope * 900.0], [0.0, 900.0])))
    expected = (slope + math.sqrt(slope**2 + MASS * 2.0 * SPRING)) / MASS  # M w^2 = 2 (k + s w)
    assert found["cylindrical forward"] == pytest.approx(expected, rel=1e-12)
    assert found["cylindrical forward"] > math.sqrt(2.0 * SPRING / MASS) + 20.0


def test_damping_moves_the_crossing_to_the_damped_frequency() -> None:
    found = critical_speeds(planar(), damped=True, highest=200.0)
    ratio = 20.0 / (2.0 * math.sqrt(12e3 * 3.0))
    assert found["critical_speed"].values == pytest.approx([math.sqrt(4e3 * (1.0 - ratio**2))] * 2, rel=1e-10)
    assert found.attrs["theory"] == "damped natural frequencies"


def test_balls_count_as_mass_only_if_asked() -> None:
    machine = with_value_at(planar(), "balancers", [{"races": [{
        "orbit_radius": 0.1, "drag": {"law": "viscous", "damping": 1e-4},
        "balls": [{"mass": 0.1, "motion": "point", "count": 2}],
    }]}])  # fmt: skip
    assert critical_speeds(machine, balls=False)["critical_speed"].values == pytest.approx([math.sqrt(4e3)] * 2)
    assert critical_speeds(machine)["critical_speed"].values == pytest.approx([math.sqrt(12e3 / 3.2)] * 2, rel=1e-13)


def test_the_greatest_response_of_a_planar_rotor_is_above_its_natural_frequency() -> None:
    ratio = 0.1
    damping = 2.0 * ratio * math.sqrt(12e3 * 3.0)
    found = response_peaks(planar(damping=damping), 10.0, 200.0, unbalance=1e-3)
    assert found["peak_speed"].values == pytest.approx([math.sqrt(4e3 / (1.0 - 2.0 * ratio**2))], rel=1e-6)
    expected = 1e-3 / 3.0 / (2.0 * ratio * math.sqrt(1.0 - ratio**2))
    assert found["peak_amplitude"].values == pytest.approx([expected], rel=1e-10)


def test_a_fluid_film_needs_a_speed_up_to_which_to_search() -> None:
    support = {"position": 0.0, "stiffness": SPRING, "cross_stiffness": [800.0, -800.0], "tilt_stiffness": 2e3}
    machine = with_value_at(rigid(0.001), "rotor.supports", [support])
    with pytest.raises(QuestionError, match="cross-coupled stiffness"):
        critical_speeds(machine)
    found = by_name(critical_speeds(machine, highest=200.0))
    exact = ((SPRING - 800.0j) / MASS) ** 0.5  # z'' + (k - i k_c)/M z = 0
    assert found["cylindrical forward"] == pytest.approx(exact.real, rel=1e-9)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: critical_speeds(RIG, damped=True), "highest: missing"),
        (lambda: critical_speeds(RIG, highest=-3.0), "given -3 rad/s"),
        (lambda: critical_speeds(RIG, harmonics=[]), "at least one"),
        (lambda: response_peaks(RIG, 300.0, 100.0), "must ascend"),
        (lambda: response_peaks(RIG, -1.0, 100.0), "must ascend from zero"),
        (lambda: response_peaks(RIG, 0.0, 100.0, measure="loudest"), "given 'loudest'"),
        (lambda: response_peaks(RIG, 0.0, 100.0, quantity="jerk"), "given 'jerk'"),
        (lambda: response_peaks(RIG, 0.0, 100.0, samples=2), "given 2"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(ask: Any, message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ask()


def test_a_rotor_on_tabled_supports_has_the_same_critical_speeds_in_runs_borders_and_rotordynamics() -> None:
    table = {"speed": [0.0, 150.0, 250.0, 600.0], "stiffness": [25e3, 40e3, 120e3, 120e3], "damping": [30.0] * 4}
    race = {
        "orbit_radius": 0.05,
        "drag": {"law": "viscous", "damping": 2e-4},
        "balls": [{"mass": 3e-3, "motion": "point"}],
    }
    machine = Machine.model_validate(
        {
            "name": "on tables",
            "axis": "vertical",
            "rotor": {
                "kind": "rigid",
                "mass": 5.0,
                "transverse_inertia": 0.03,
                "polar_inertia": 0.015,
                "supports": [{"position": z, "table": table} for z in (-0.1, 0.1)],
            },
            "stations": [{"name": "race", "position": 0.02}],
            "balancers": [{"station": "race", "races": [race]}],
            "drive": {"kind": "speed", "profile": {"kind": "ramp", "end": 400.0, "duration": 0.1}},
        }
    )
    found = ab.rotor.critical_speeds(machine)
    forward = found["critical_speed"].values[found["whirl"].values == "forward"]
    run = ab.simulate(machine, duration=0.1)
    assert run.attrs["critical_speeds"] == pytest.approx(forward.tolist(), rel=1e-9)
    assert ab.check(machine).critical_speeds == pytest.approx(forward.tolist(), rel=1e-9)
    # the parallel mode, K(w) = w^2 M, between two entries of the table
    first = forward[0]
    assert 2.0 * np.interp(first, table["speed"], table["stiffness"]) == pytest.approx(first**2 * 5.003, rel=1e-3)


@pytest.mark.parametrize("name", ["two_plane_rotor", "disk_like_rotor", "discoidal"])
def test_a_run_the_stability_and_the_rotor_alone_have_the_same_critical_speeds(name: str) -> None:
    machine = load_race_machine(MACHINES / f"{name}.toml")
    forward = critical_speeds(machine)
    expected = np.unique(forward["critical_speed"].values[forward["whirl"].values != "backward"].round(9))
    np.testing.assert_allclose(stations(machine).critical_speeds, expected, rtol=1e-9)
    np.testing.assert_allclose(assemble(machine).critical_speeds, expected, rtol=1e-9)

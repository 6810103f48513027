"""The planar oscillator of a place on a rotor."""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.references.pictures import size_of
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import lateral_model, rows_at
from autobalancer.cli import app
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine, save_machine
from autobalancer.machine import Machine
from autobalancer.rotordynamics.campbell import critical_speeds, modes
from autobalancer.rotordynamics.equivalent_planar import equivalent_planar

BALANCER = {
    "name": "ring",
    "races": [
        {
            "orbit_radius": 0.08,
            "drag": {"law": "viscous", "damping": 2e-4},
            "balls": [{"count": 2, "mass": 5e-3, "motion": "point", "start_angles": [0.5, 3.0]}],
        }
    ],
}


def rotor(support: dict, place: float, *, polar: float = 0.05, arms: tuple[float, float] = (0.25, -0.25)) -> Machine:
    return Machine(
        name="rotor", axis="vertical",
        rotor={
            "kind": "rigid", "mass": 10.0, "transverse_inertia": 0.2, "polar_inertia": polar,
            "supports": [{"position": arm, **support} for arm in arms],
        },
        stations=[{"name": "plane", "position": place}],
        unbalances=[{"moment": 1e-4, "angle": 0.7, "station": "plane"}],
        balancers=[{**BALANCER, "station": "plane"}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 300.0}}, run={"duration": 3.0},
    )  # fmt: skip


SYMMETRIC = rotor({"stiffness": 5e4, "damping": 20.0}, 0.0)
FAR = rotor({"stiffness": 5e4, "damping": 20.0, "tilt_stiffness": 2e5}, 0.1, polar=0.3, arms=(0.35, -0.15))


@pytest.mark.parametrize("method", ["static", "modal"])
@pytest.mark.parametrize("frequency", ["critical", "natural"])
@pytest.mark.parametrize("pair", [False, True])
def test_a_planar_machine_is_its_own_oscillator(method: str, frequency: str, pair: bool) -> None:
    machine = load_race_machine("examples/machines/discoidal.toml")
    if pair:
        machine = with_value_at(machine, "rotor.stiffness", (4e4, 9e4))
        machine = with_value_at(machine, "rotor.damping", (30.0, 80.0))
    found = equivalent_planar(machine, method=method, frequency=frequency)  # type: ignore[arg-type]
    assert found.machine.rotor.mass == pytest.approx(12.27, rel=1e-12)
    assert found.machine.rotor.stiffness_xy == pytest.approx(machine.rotor.stiffness_xy, rel=1e-12)
    assert found.machine.rotor.damping_xy == pytest.approx(machine.rotor.damping_xy, rel=1e-12)
    assert found.machine.balancers == machine.balancers
    assert found.machine.drive == machine.drive
    assert found.machine.unbalances[0].size == pytest.approx(machine.unbalances[0].size, rel=1e-12)
    assert float(np.abs(found.data["deviation"]).max()) < 1e-9
    np.testing.assert_allclose(found.data["static_share"], 1.0, rtol=1e-12)
    assert not found.data.attrs["notes"]


@pytest.mark.parametrize("method", ["static", "modal"])
def test_at_the_mass_center_of_a_symmetric_rotor_it_is_exact(method: str) -> None:
    found = equivalent_planar(SYMMETRIC, method=method)  # type: ignore[arg-type]
    own = found.machine.rotor
    np.testing.assert_allclose([own.mass, own.stiffness, own.damping, own.inertia], [10.0, 1e5, 40.0, 0.05], rtol=1e-12)
    assert float(found.data["deviation"].max()) < 1e-9
    assert found.data["valid_to"].values == pytest.approx(300.0, rel=1e-9)
    (unbalance,) = found.machine.unbalances
    assert (unbalance.size, unbalance.angle) == pytest.approx((1e-4, 0.7), rel=1e-12)
    assert found.machine.balancers[0].races == SYMMETRIC.balancers[0].races
    by_hand = Machine(
        name="by hand", axis="vertical", rotor={"kind": "planar", "mass": 10.0, "stiffness": 1e5, "damping": 40.0},
        unbalances=[{"moment": 1e-4}], balancers=[BALANCER], drive=SYMMETRIC.drive,
    )  # fmt: skip
    borders = [ab.stability.borders(machine) for machine in (found.machine, by_hand)]
    for one, other in zip(*borders, strict=True):
        assert one.speed == pytest.approx(other.speed, rel=1e-9, nan_ok=True)


def test_a_couple_does_not_drive_a_mode_without_tilt() -> None:
    couple = with_value_at(SYMMETRIC, "unbalances", ({"couple": 1e-4},))
    assert equivalent_planar(couple).machine.unbalances[0].size == pytest.approx(0.0, abs=1e-18)


def test_with_a_far_second_mode_it_moves_like_the_rotor_near_the_first() -> None:
    found = equivalent_planar(FAR, method="modal")
    critical = float(found.data["critical_speed"][0])
    speeds = critical * np.linspace(0.8, 1.2, 41)
    ours = ab.rotor.response(found.machine, speeds)
    true = ab.rotor.response(FAR, speeds, "plane")
    amplitudes = [(d["x_real"] + 1j * d["x_imag"]).values[:, 0] for d in (ours, true)]
    assert np.abs(amplitudes[0] / amplitudes[1] - 1.0).max() < 0.01
    assert float(found.data["static_share"][0]) > 0.99
    assert float(found.data["other_modes_from"][0]) > 1.5 * critical
    modal, static = found.data["mass"].sel(direction="x", way=["modal", "static"]).values
    assert modal > static


def test_its_speed_and_damping_are_those_of_the_mode() -> None:
    found = equivalent_planar(FAR)
    table = critical_speeds(FAR, balls=False)
    forward = table["critical_speed"].values[table["whirl"].values == "forward"]
    assert found.data["critical_speed"].values == pytest.approx(forward[0], rel=1e-10)
    rest = equivalent_planar(FAR, frequency="natural")
    mode = modes(FAR, balls=False)
    assert rest.data["critical_speed"].values == pytest.approx(float(mode["undamped_frequency"][0]), rel=1e-10)
    assert rest.data["damping_ratio"].values == pytest.approx(float(mode["damping_ratio"][0]), rel=1e-9)
    assert found.data["critical_speed"].values[0] > 1.000005 * rest.data["critical_speed"].values[0]


def test_its_stiffness_is_the_static_stiffness_at_the_place() -> None:
    """Two springs k at arms a of a rigid bar: 1/(1/(2 k) + z^2/(2 k a^2)) at z."""
    for place in (0.0, 0.1, -0.3):
        machine = with_value_at(SYMMETRIC, "stations[1].position", place)
        stiffness = equivalent_planar(machine).data["stiffness"].sel(way="static").values
        np.testing.assert_allclose(stiffness, 1e5 / (1.0 + (place / 0.25) ** 2), rtol=1e-12)


def test_the_rotor_of_the_comparison_is_the_rotor() -> None:
    """Receptance of forward whirl, R_xx - i R_xy, from the matrices in space."""
    speeds = np.array([20.0, 90.0, 140.0])
    found = equivalent_planar(FAR, speeds=speeds)
    model = lateral_model(FAR)
    row = rows_at(FAR, model, "plane").deflection[None]
    for speed, value in zip(speeds, found.data["receptance"].values[0], strict=True):
        matrix = model.receptance(1j * speed, speed, row)
        assert value == pytest.approx(abs(matrix[0, 0] - 1j * matrix[0, 1]), rel=1e-10)


def test_x_and_y_of_unlike_supports_have_their_own_modes() -> None:
    machine = rotor({"stiffness": (5e4, 8e4), "damping": 20.0}, 0.05)
    found = equivalent_planar(machine, method="static", frequency="natural")
    k = found.machine.rotor.stiffness_xy
    mass = found.machine.rotor.mass
    frequencies = np.sqrt(np.array(k) / mass)
    mode = modes(machine, balls=False)
    np.testing.assert_allclose(frequencies, found.data["critical_speed"], rtol=1e-12)
    assert frequencies[0] == pytest.approx(float(mode["undamped_frequency"][0]), rel=1e-10)
    assert k[1] > k[0]


def test_balancers_in_another_plane_are_left_out_and_named() -> None:
    extra = SYMMETRIC.balancers[0].model_copy(update={"station": 0.1, "name": "upper"})
    found = equivalent_planar(with_value_at(SYMMETRIC, "balancers", (*SYMMETRIC.balancers, extra)))
    assert [b.name for b in found.machine.balancers] == ["ring"]
    assert "upper" in found.machine.description


def test_the_machine_says_where_it_comes_from_and_can_be_saved(tmp_path: Path) -> None:
    found = equivalent_planar(FAR, method="modal")
    again = load_race_machine(save_machine(found.machine, tmp_path / "planar.toml"))
    assert again == found.machine
    assert "'rotor' at plane" in again.description
    valid = float(found.data["valid_to"].sel(way="modal", direction="x"))
    assert f"{valid:.4g} rad/s" in again.description


def test_where_springs_have_tables_they_are_read_at_the_mode() -> None:
    table = {"speed": [0.0, 200.0], "stiffness": [4e4, 8e4], "damping": [20.0, 20.0]}
    found = equivalent_planar(rotor({"table": table}, 0.0))
    speed = float(found.data["critical_speed"][0])
    spring = 2.0 * (4e4 + 4e4 * speed / 200.0)
    assert speed == pytest.approx(np.sqrt(spring / 10.0), rel=1e-10)
    assert found.machine.rotor.stiffness == pytest.approx(spring, rel=1e-9)
    assert found.machine.rotor.mass == pytest.approx(10.0, rel=1e-9)


def test_a_disc_without_synchronous_tilting_mode_still_has_its_first_mode() -> None:
    """J_p > J_t: no forward critical speed of the conical mode."""
    found = equivalent_planar(rotor({"stiffness": 5e4, "damping": 20.0}, 0.05, polar=0.35))
    assert found.data["critical_speed"].values == pytest.approx(100.0, rel=1e-9)


def test_the_picture_shows_rotor_and_both_oscillators() -> None:
    figure = ab.plot.answer(equivalent_planar(FAR).data)
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert labels == ["rotor", "oscillator, static", "oscillator, modal"]
    with pytest.raises(QuestionError, match=r"is of a result of rotor\.equivalent_planar"):
        ab.plot.answer(modes(FAR), "equivalent_planar")


@pytest.mark.parametrize(
    ("machine", "options", "says"),
    [
        (SYMMETRIC, {"method": "best"}, "method: given 'best'"),
        (SYMMETRIC, {"frequency": "first"}, "frequency: given 'first'"),
        (SYMMETRIC, {"tolerance": 1.5}, "between 0 and 1"),
        (SYMMETRIC, {"speeds": np.array([3.0, 1.0])}, "must ascend"),
        (rotor({"stiffness": 5e4, "damping": 1e5}, 0.0), {}, "nothing|oscillates"),
    ],
)
def test_impossible_questions_are_refused(machine: Machine, options: dict, says: str) -> None:
    with pytest.raises(QuestionError, match=says):
        equivalent_planar(machine, **options)


def test_the_command_says_what_the_function_returns_and_writes_a_machine_that_runs(tmp_path: Path) -> None:
    given, planar = "examples/machines/rigid_rotor.toml", tmp_path / "planar.toml"
    arguments = [
        "equivalent-planar",
        given,
        "--method",
        "modal",
        "--out",
        str(planar),
        "--plot",
        str(tmp_path / "p.png"),
    ]
    said = CliRunner().invoke(app, [*arguments, "--json"])
    assert said.exit_code == 0, said.output
    found = equivalent_planar(load_race_machine(given), method="modal")
    answer = json.loads(said.output)
    stiffness = np.array(answer["stiffness"])[answer["way"].index("modal")]
    assert stiffness == pytest.approx(found.data["stiffness"].sel(way="modal").values)
    assert load_race_machine(planar).rotor == found.machine.rotor
    assert size_of(tmp_path / "p.png") == (990, 750)
    assert "taken: modal" in CliRunner().invoke(app, ["equivalent-planar", given]).output

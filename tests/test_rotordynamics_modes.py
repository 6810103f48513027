"""Natural frequencies, whirl, mode shapes and branches of rotors."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import lateral_model
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.results.store import load_run, save_run
from autobalancer.rotordynamics.campbell import campbell, modes
from autobalancer.rotordynamics.natural_modes import correlation, free_motions

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
RIG = rig("rodrigues_rig")
MASS, TRANSVERSE, POLAR, SPRING, ARM = 2.0, 0.02, 0.012, 40e3, 0.12


def rigid(polar: float = POLAR, stiffness: Any = SPRING, damping: Any = 0.0, arms: Any = (-ARM, ARM)) -> Machine:
    """A rigid rotor on two equal supports, by default symmetric and isotropic."""
    return Machine(
        name="rigid",
        axis="vertical",
        rotor={
            "kind": "rigid",
            "mass": MASS,
            "transverse_inertia": TRANSVERSE,
            "polar_inertia": polar,
            "supports": [{"position": arm, "stiffness": stiffness, "damping": damping} for arm in arms],
        },
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
    )


def planar(**rotor: Any) -> Machine:
    return Machine(
        name="planar",
        axis="vertical",
        rotor={"kind": "planar", "mass": 3.0, "stiffness": 12e3, "damping": 20.0} | rotor,
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
    )


def first_order(machine: Machine, speed: float) -> np.ndarray:
    """Eigenvalues with positive imaginary part from the plain companion matrix, by imaginary part."""
    model = lateral_model(machine)
    inverse = np.linalg.inv(model.mass)
    n = model.size
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -inverse @ model.stiffness_at(speed)
    matrix[n:, n:] = -inverse @ (model.damping_at(speed) + speed * model.gyroscopic)
    values = np.linalg.eigvals(matrix)
    values = values[values.imag > 1e-9]
    return np.asarray(values[np.argsort(values.imag)])


# one speed


def test_modes_need_no_balancer_and_no_length() -> None:
    disk = {"mass": 1.0, "transverse_inertia": 1e-3, "polar_inertia": 1e-3}
    shaft = {
        "kind": "shaft",
        "material": {"density": 7800.0, "youngs_modulus": 2e11, "poisson_ratio": 0.3},
        "segments": [{"length": 0.4, "diameter": 0.02, "elements": 4}],
        "disks": [disk | {"position": 0.1}, disk | {"position": 0.2}],
        "supports": [{"position": 0.0, "stiffness": 1e6}, {"position": 0.4, "stiffness": 1e6}],
    }
    bare = Machine(name="bare", axis="vertical", rotor=shaft, drive=planar().drive)
    found = modes(bare)
    assert found["station"].item() == "middle of the rotor"
    placed = modes(bare, stations=[0.2])
    assert float(found["station_x_real"][0, 0]) == pytest.approx(float(placed["station_x_real"][0, 0]))
    resonances = [{"mass": 10.0, "frequency": w, "damping_ratio": 0.05} for w in (60.0, 300.0)]
    modal = Machine(name="modal", axis="vertical", rotor={"kind": "modal", "resonances": resonances}, drive=bare.drive)
    assert modes(modal)["undamped_frequency"].values == pytest.approx([60.0, 60.0, 300.0, 300.0])


def test_the_planar_rotor_has_the_frequencies_of_an_oscillator() -> None:
    found = modes(planar(), 50.0)
    ratio = 20.0 / (2.0 * math.sqrt(12e3 * 3.0))
    assert found["undamped_frequency"].values == pytest.approx([math.sqrt(4e3)] * 2, rel=1e-13)
    assert found["frequency"].values == pytest.approx([math.sqrt(4e3 * (1.0 - ratio**2))] * 2, rel=1e-12)
    assert found["damping_ratio"].values == pytest.approx([ratio] * 2, rel=1e-12)
    assert found["decay_rate"].values == pytest.approx([20.0 / 6.0] * 2, rel=1e-12)
    assert list(found["whirl"].values) == ["backward", "forward"]
    assert list(found["name"].values) == ["cylindrical backward", "cylindrical forward"]


def test_an_orthotropic_planar_rotor_swings_on_lines() -> None:
    found = modes(planar(stiffness=[12e3, 27e3], damping=0.0), 50.0)
    assert found["frequency"].values == pytest.approx([math.sqrt(4e3), math.sqrt(9e3)], rel=1e-12)
    assert list(found["name"].values) == ["cylindrical x", "cylindrical y"]
    assert list(found["whirl"].values) == ["straight"] * 2
    assert (found["station_whirl"].values == "straight").all()


@pytest.mark.parametrize("speed", [0.0, 40.0, 300.0, 2000.0])
def test_gyroscopics_split_the_conical_mode_by_the_quadratic_formula(speed: float) -> None:
    found = modes(rigid(), speed)
    tilt = 2.0 * SPRING * ARM**2
    half = POLAR * speed / (2.0 * TRANSVERSE)
    root = math.sqrt(half**2 + tilt / TRANSVERSE)
    by_name = dict(zip(found["name"].values, found["frequency"].values, strict=True))
    assert by_name["conical forward"] == pytest.approx(root + half, rel=1e-12)
    assert by_name["conical backward"] == pytest.approx(root - half, rel=1e-12)
    lateral = math.sqrt(2.0 * SPRING / MASS)
    assert by_name["cylindrical forward"] == pytest.approx(lateral, rel=1e-12)
    assert by_name["cylindrical backward"] == pytest.approx(lateral, rel=1e-12)
    assert all(str(n).endswith(str(w)) for n, w in zip(found["name"].values, found["whirl"].values, strict=True))


def test_the_split_is_symmetric_about_standstill_in_the_geometric_mean() -> None:
    rest = modes(rigid(), 0.0)
    conical = float(rest["frequency"][2])
    for speed in (50.0, 500.0):
        found = modes(rigid(), speed)
        split = [f for f, name in zip(found["frequency"].values, found["name"].values, strict=True) if "con" in name]
        assert math.prod(split) == pytest.approx(conical**2, rel=1e-12)
        assert split[1] - split[0] == pytest.approx(POLAR / TRANSVERSE * speed, rel=1e-10)


@pytest.mark.parametrize("speed", [0.0, 100.0, 700.0])
@pytest.mark.parametrize("stiffness", [SPRING, (SPRING, 0.6 * SPRING)])
def test_damped_eigenvalues_are_those_of_the_companion_matrix(speed: float, stiffness: Any) -> None:
    machine = rigid(
        stiffness=stiffness, damping=(30.0, 30.0) if stiffness == SPRING else (30.0, 70.0), arms=(-0.2, 0.1)
    )
    found, expected = modes(machine, speed), first_order(machine, speed)
    assert found["frequency"].values == pytest.approx(expected.imag, rel=1e-10)
    if np.diff(expected.imag).min() > 1e-3:
        assert found["decay_rate"].values == pytest.approx(-expected.real, rel=1e-8)


def test_modes_solve_the_equation_of_motion() -> None:
    for machine in (
        rigid(damping=30.0),
        rigid(stiffness=(SPRING, 0.5 * SPRING), damping=(30.0, 5.0)),
        RIG,
    ):
        model = lateral_model(machine)
        for value, vector in zip(*(lambda m: (m.eigenvalue, m.vector))(free_motions(model, 250.0)), strict=True):
            terms = [
                value**2 * model.mass @ vector,
                value * (model.damping_at(250.0) + 250.0 * model.gyroscopic) @ vector,
                model.stiffness_at(250.0) @ vector,
            ]
            assert np.abs(sum(terms)).max() < 1e-10 * np.abs(terms[2]).max()


def test_modes_of_an_isotropic_rotor_are_circles() -> None:
    found = modes(rigid(damping=30.0), 200.0)
    x, y = (found[f"{letter}_real"] + 1j * found[f"{letter}_imag"] for letter in "xy")
    sign = np.where(found["whirl"].values == "forward", 1.0, -1.0)[:, None]
    assert np.abs(y.values + 1j * sign * x.values).max() < 1e-12  # forward: y follows x a quarter turn later
    assert np.hypot(np.abs(x), np.abs(y)).values.max(axis=1) == pytest.approx(math.sqrt(2.0), rel=1e-9)


def test_an_undamped_rotor_keeps_its_motion_whatever_the_gyroscopics() -> None:
    found = modes(rigid(stiffness=(SPRING, 0.5 * SPRING)), 400.0)
    assert np.abs(found["decay_rate"].values).max() < 1e-9
    assert found["frequency"].values == pytest.approx(found["undamped_frequency"].values, rel=1e-12)
    for name in ("damping_ratio", "decay_rate"):  # no rounding, and no zero with a sign
        assert [f"{value:g}" for value in found[name].values] == ["0"] * found.sizes["mode"]


def test_conical_modes_have_a_node_and_cylindrical_ones_none() -> None:
    found = modes(RIG, 100.0)
    assert list(found["name"].values) == ["cylindrical y", "cylindrical x", "conical y", "conical x"]
    for number, letter, nodes in ((0, "y", 0), (1, "x", 0), (2, "y", 1), (3, "x", 1)):
        line = found[f"{letter}_real"].values[number]
        assert np.count_nonzero(np.diff(np.sign(line))) == nodes
    assert found["place"].values[[0, -1]] == pytest.approx([-0.15, 0.11])


def test_the_whirl_turns_round_where_the_part_along_x_or_y_has_a_node() -> None:
    stations = [float(z) for z in np.linspace(-0.15, 0.11, 501)]
    found = modes(with_value_at(RIG, "rotor.stiffness_proportional_damping", 0.0), 200.0,
                             stations=stations)  # fmt: skip
    assert list(found["whirl"].values) == ["mixed"] * 4
    for number, turns in enumerate((1, 1, 2, 2)):
        words = found["station_whirl"].values[number]
        nodes = 0
        for letter in "xy":
            line = found[f"station_{letter}_real"].values[number] + 1j * found[f"station_{letter}_imag"].values[number]
            line = (line * np.exp(-0.5j * np.angle((line**2).sum()))).real
            nodes += np.count_nonzero(np.diff(np.sign(line)))
        assert np.count_nonzero(words[1:] != words[:-1]) == nodes == turns


def test_a_fast_orthotropic_rotor_whirls_in_one_direction_each() -> None:
    found = modes(rigid(polar=0.03, stiffness=(SPRING, 0.9 * SPRING)), 3000.0)
    conical = [str(w) for w, n in zip(found["whirl"].values, found["name"].values, strict=True) if "conical" in n]
    assert conical == ["backward", "forward"]


def test_the_mass_of_the_balls_lowers_the_frequencies_as_a_rayleigh_quotient_says() -> None:
    bare, loaded = modes(RIG, 0.0, balls=False), modes(RIG, 0.0)
    model = lateral_model(RIG)
    vector = free_motions(model, 0.0).vector[0]
    disk = np.array([1.0, -0.02])
    added = 2 * 0.44e-3 * (abs(disk @ vector[:2]) ** 2 + abs(disk @ vector[2:]) ** 2)
    change = float(loaded["undamped_frequency"][0] / bare["undamped_frequency"][0]) - 1.0
    assert change == pytest.approx(-0.5 * added, rel=2e-3)


def test_overdamped_motions_are_listed_apart() -> None:
    found = modes(planar(damping=[1e4, 20.0]), 0.0)
    assert list(found["name"].values) == ["cylindrical y"]
    rates = sorted(found.attrs["decay_rates_without_frequency"])
    root = math.sqrt((1e4 / 6.0) ** 2 - 4e3)
    assert rates == pytest.approx([1e4 / 6.0 - root, 1e4 / 6.0 + root], rel=1e-9)


def test_a_fluid_film_drives_the_forward_whirl() -> None:
    support = {"position": 0.0, "stiffness": SPRING, "cross_stiffness": [800.0, -800.0], "tilt_stiffness": 2e3}
    machine = with_value_at(rigid(polar=0.001), "rotor.supports", [support])
    found = modes(machine, 100.0)
    rates = dict(zip(found["name"].values, found["decay_rate"].values, strict=True))
    lateral = math.sqrt(SPRING / MASS)
    assert rates["cylindrical forward"] == pytest.approx(-800.0 / (2.0 * MASS * lateral), rel=1e-3)
    assert rates["cylindrical backward"] == pytest.approx(800.0 / (2.0 * MASS * lateral), rel=1e-3)


def test_tables_are_read_at_the_speed() -> None:
    table = {"speed": [0.0, 400.0], "stiffness": [SPRING, 3.0 * SPRING], "damping": [0.0, 0.0]}
    machine = with_value_at(rigid(), "rotor.supports", [{"position": arm, "table": table} for arm in (-ARM, ARM)])
    found = modes(machine, 200.0)
    assert float(found["frequency"][0]) == pytest.approx(math.sqrt(2.0 * 2.0 * SPRING / MASS), rel=1e-12)
    with pytest.raises(QuestionError, match="tables of the rotor end at 400 rad/s"):
        modes(machine, 500.0)


def test_the_result_can_be_saved_and_names_its_units(tmp_path: Path) -> None:
    found = modes(RIG, 150.0)
    for name in found.data_vars:
        assert found[name].attrs["long_name"]
        assert "units" in found[name].attrs
    back = load_run(save_run(found, tmp_path / "modes.nc"))
    assert back.drop_attrs().equals(found.drop_attrs())


# branches


def test_branches_pass_through_a_crossing_and_keep_their_shape() -> None:
    speeds = np.linspace(0.0, 1500.0, 31)
    found = campbell(rigid(), speeds)
    by_name = {str(n): found["frequency"].values[i] for i, n in enumerate(found["name"].values)}
    tilt = 2.0 * SPRING * ARM**2
    half = POLAR * speeds / (2.0 * TRANSVERSE)
    assert by_name["conical backward"] == pytest.approx(np.sqrt(half**2 + tilt / TRANSVERSE) - half, rel=1e-10)
    lateral = math.sqrt(2.0 * SPRING / MASS)
    assert by_name["cylindrical forward"] == pytest.approx(np.full(31, lateral), rel=1e-10)
    assert by_name["conical backward"][0] > lateral > by_name["conical backward"][-1]
    for name, words in zip(found["name"].values, found["whirl"].values, strict=True):
        assert set(words) == {str(name).split()[1]}


def test_branches_of_a_coarse_and_a_fine_diagram_agree() -> None:
    machine = rigid(stiffness=(SPRING, 0.7 * SPRING), damping=(20.0, 40.0), arms=(-0.15, 0.1))
    fine = campbell(machine, np.linspace(0.0, 2000.0, 401))
    coarse = campbell(machine, np.linspace(0.0, 2000.0, 9))
    assert coarse["frequency"].values == pytest.approx(fine["frequency"].values[:, ::50], rel=1e-9)
    assert (coarse["whirl"].values == fine["whirl"].values[:, ::50]).all()


def test_a_branch_changes_little_from_speed_to_speed() -> None:
    machine = rigid(stiffness=(SPRING, 0.7 * SPRING), arms=(-0.15, 0.1))
    model = lateral_model(machine)
    coarse, fine = (
        np.abs(np.diff(campbell(machine, np.linspace(0.0, 3000.0, n))["frequency"].values, 2, axis=1)).max()
        for n in (301, 3001)
    )
    assert fine < 0.011 * coarse  # no jump, else the second differences would not shrink with the square of the step
    assert correlation(*([free_motions(model, 5.0).vector] * 2), model.mass).diagonal() == pytest.approx(np.ones(4))


def test_a_branch_that_stops_to_oscillate_ends() -> None:
    table = {"speed": [0.0, 100.0], "stiffness": [SPRING] * 2, "damping": [[0.0, 0.0], [0.0, 2000.0]]}
    machine = with_value_at(
        rigid(polar=1e-9), "rotor.supports", [{"position": arm, "table": table} for arm in (-ARM, ARM)]
    )
    found = campbell(machine, np.linspace(0.0, 100.0, 42))
    ends = {str(n): np.isnan(found["frequency"].values[i]) for i, n in enumerate(found["name"].values)}
    expected = 2.0 * 2000.0 * found["speed"].values / 100.0 >= 2.0 * math.sqrt(2.0 * SPRING * MASS)
    assert (ends["cylindrical y"] == expected).all()
    assert expected.any()
    assert not ends["cylindrical x"].any()
    assert (found["whirl"].values[list(ends).index("cylindrical y")][expected] == "none").all()


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: modes(RIG, -1.0), "given -1 rad/s"),
        (lambda: modes(RIG, math.nan), "must be finite"),
        (lambda: modes(RIG, modes=0), "given 0"),
        (lambda: modes(RIG, stations=[]), "stations: given none"),
        (lambda: modes(RIG, stations=["B3"]), "no station is named 'B3'; there is 'B1', 'B2', 'disk'"),
        (lambda: campbell(RIG, []), "speeds: given none"),
        (lambda: campbell(RIG, [100.0]), "at least two"),
        (lambda: campbell(RIG, [100.0, 50.0]), "ascending"),
        (lambda: campbell(RIG, [0.0, 50.0], harmonics=[0.0]), "greater than zero"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(ask: Any, message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ask()


def test_a_missing_file_is_named() -> None:
    with pytest.raises(MachineError, match="no such file"):
        modes("none.toml")

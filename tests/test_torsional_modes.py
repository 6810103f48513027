"""Torsional frequencies, critical speeds and responses against closed forms and runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from tests.test_torsion import CHAIN, FIRST, MOTOR, MOUNT, ROTOR, STATOR, free, machine
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.drive_train import motor_slope
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, QuestionError

SAMPLE = str(Path(__file__).parents[1] / "examples" / "machines" / "coupled_drive.toml")
FREE = machine(free())


def test_three_inertias_on_a_free_shaft_have_the_two_frequencies_of_the_textbook() -> None:
    """Roots of w^4 - w^2 (k1 (1/J1 + 1/J2) + k2 (1/J2 + 1/J3)) + k1 k2 (J1 + J2 + J3)/(J1 J2 J3), Holzer's shaft of three."""
    k1, k2 = 2000.0, 3000.0
    b = k1 * (1.0 / ROTOR + 1.0 / FIRST) + k2 * (1.0 / FIRST + 1.0 / MOTOR)
    c = k1 * k2 * (ROTOR + FIRST + MOTOR) / (ROTOR * FIRST * MOTOR)
    expected = np.sqrt(np.sort(np.roots([1.0, -b, c]).real))
    found = ab.rotor.torsional_modes(FREE)
    np.testing.assert_allclose(found["frequency"], expected, rtol=1e-12)
    np.testing.assert_allclose(found["undamped_frequency"], expected, rtol=1e-12)
    momentum = (found["angle_real"] * found["inertia"]).sum("part")
    np.testing.assert_allclose(momentum, 0.0, atol=1e-12)  # a free shaft swings about its center of inertia
    critical = ab.rotor.torsional_critical_speeds(FREE, harmonics=[1, 2])
    np.testing.assert_allclose(
        critical["critical_speed"], np.sort(np.concatenate([expected, expected / 2])), rtol=1e-12
    )


def test_a_motor_of_prescribed_speed_holds_its_end_of_the_coupling_and_damping_is_that_of_an_oscillator() -> None:
    drive = {
        "kind": "speed",
        "profile": {"kind": "constant", "speed": 100.0},
        "couplings": [{"stiffness": 2e3, "damping": 3.0}],
    }
    found = ab.rotor.torsional_modes(machine(drive))
    ratio = 3.0 / (2.0 * np.sqrt(2e3 * ROTOR))
    assert float(found["damping_ratio"][0]) == pytest.approx(ratio, rel=1e-12)
    assert float(found["frequency"][0]) == pytest.approx(np.sqrt(2e3 / ROTOR * (1.0 - ratio**2)), rel=1e-12)
    assert found["name"].values.tolist() == ["rotor"]


def test_a_mounted_motor_swings_alone_if_its_torque_is_constant_and_with_the_rotor_if_its_speed_is_kept() -> None:
    """The two limits of a controller, both without a coupling: the mount feels the stator, or stator and rotor."""
    for gain, inertia in ((0.0, STATOR), (1e6, STATOR + ROTOR)):
        drive = {
            "kind": "target_torque",
            "profile": {"kind": "constant", "speed": 100.0},
            "gain": gain,
            "damping": gain,
        }
        found = ab.rotor.torsional_modes(machine(drive | {"mount": MOUNT}))
        assert float(found["frequency"][0]) == pytest.approx(np.sqrt(500.0 / inertia), rel=1e-6)


def test_the_torque_of_a_motor_that_falls_with_its_speed_damps_and_one_that_rises_does_not() -> None:
    words: dict[str, Any] = {"rated_torque": 10.0, "overload": 2.2, "synchronous_speed": 157.0, "breakdown_slip": 0.2}
    motor = machine({"kind": "asynchronous", "couplings": CHAIN, **words})
    low, high = (ab.rotor.torsional_modes(motor, speed)["decay_rate"].values for speed in (60.0, 150.0))
    assert (low < 0.0).all()
    assert (high > 0.0).all()
    table = machine(
        {"kind": "torque_table", "speed": [0.0, 100.0, 200.0], "torque": [1.0, 3.0, 0.0], "couplings": CHAIN}
    )
    assert [motor_slope(table.drive, speed) for speed in (50.0, 150.0, 250.0)] == pytest.approx([0.02, -0.03, 0.0])

    def torque(slip: float) -> float:
        return 2.0 * 22.0 / (slip / 31.4 + 31.4 / slip)

    assert motor_slope(motor.drive, 100.0) == pytest.approx((torque(56.999) - torque(57.001)) / 2e-3, rel=1e-6)


def test_the_response_is_that_of_a_run_at_every_harmonic() -> None:
    """Weight of the unbalance, errors of both couplings and a ripple, with a stator; settled, and Fourier over whole turns."""
    couplings = [CHAIN[0] | {"damping": 4.0, "error": 2e-4}, CHAIN[1] | {"damping": 2.0, "error": 1e-4, "phase": 1.0}]
    target = {"kind": "target_torque", "profile": {"kind": "constant", "speed": 150.0}, "gain": 0.5, "damping": 0.5}
    drive = target | {
        "couplings": couplings,
        "mount": MOUNT | {"damping": 8.0},
        "ripples": [{"torque": 0.05, "order": 5, "phase": 0.7}],  # 3 would also come from products of both errors
    }
    rotor = {"mass": 1e4, "stiffness": 1e12, "damping": 1e6, "inertia": ROTOR}  # it stays where it is
    case = machine(drive, rotor=rotor, start={"speed": 150.0}, unbalances=[{"moment": 2e-4, "angle": 0.4}])
    turn = 2.0 * np.pi / 150.0
    times = 2.0 + np.arange(200) * turn / 100.0
    run = ab.simulate(case, duration=float(times[-1]), save=ab.SampleTimes(times), tolerance=1e-11)
    found = ab.rotor.torsional_response(case, [150.0]).isel(speed=0)
    assert found["harmonic"].values.tolist() == [1.0, 2.0, 5.0]
    for at in (found.isel(harmonic=i) for i in range(3)):
        wave = np.exp(-1j * float(at["harmonic"]) * run["rotor_angle"].values)[:, None]
        amplitude = 2.0 * (run["twist"].values * wave).mean(axis=0)
        expected = at["twist"].values * np.exp(1j * at["twist_phase"].values)
        np.testing.assert_allclose(amplitude, expected, atol=2e-3 * abs(expected).max())
        torque = 2.0 * abs((run["link_torque"].values * wave).mean(axis=0))
        np.testing.assert_allclose(torque, at["link_torque"], atol=2e-3 * float(at["link_torque"].max()))


def test_a_campbell_diagram_has_the_torsional_lines_and_where_the_speed_meets_them() -> None:
    case = ab.load_machine(SAMPLE)
    found = ab.rotor.campbell(case, "0:3000 rpm:11", harmonics=[1, 2])
    critical = ab.rotor.torsional_critical_speeds(case)
    np.testing.assert_allclose(found["torsional_intersection_speed"], critical["critical_speed"])
    assert critical["excited_by"].values.tolist() == ["alignment of coupling 1", "weight of the unbalance"]
    figure = ab.plot.campbell(found)
    (axes,) = figure.axes
    assert "torsion" in [text.get_text() for text in axes.get_legend().get_texts()]
    assert axes.get_ylim()[1] > float(found["torsional_frequency"][0]) / (2.0 * np.pi)
    plt.close(figure)
    assert "torsional_frequency" not in ab.rotor.campbell(ab.example("rigid_rotor"), "0:3000 rpm:3")


def test_damped_crossings_are_where_the_response_peaks_though_no_undamped_critical_speed_is_near() -> None:
    rig = ab.example("rodrigues_rig_motor")
    found = ab.rotor.torsional_critical_speeds(rig)
    assert found["critical_speed"].values == pytest.approx([8269.9 * np.pi / 30.0], rel=1e-5)
    speeds = np.linspace(900.0, 1100.0, 401) * np.pi / 30.0
    torque = ab.rotor.torsional_response(rig, speeds)["link_torque"].transpose(..., "speed").values.reshape(-1, 401)[-1]
    assert found["crossing_speed"].values == pytest.approx([speeds[torque.argmax()]], rel=5e-3)
    assert "999.5" in repr(found)
    without = ab.rotor.torsional_critical_speeds(FREE)
    assert without["crossing_speed"].values == pytest.approx(without["critical_speed"].values, rel=1e-6)


def test_commands_print_what_the_functions_find(tmp_path: Path) -> None:
    told = CliRunner().invoke(app, ["torsional-modes", SAMPLE, "--json"])
    answer = json.loads(told.output)
    modes = ab.rotor.torsional_modes(SAMPLE)
    assert answer["frequency"][0] == pytest.approx(float(modes["frequency"][0]))
    assert answer["critical_speeds"]["harmonic"] == [2.0, 1.0]
    assert "1383.8" in CliRunner().invoke(app, ["torsional-modes", SAMPLE]).output
    words = ["torsional-response", SAMPLE, "--speeds", "100:3000 rpm:30", "--plot", str(tmp_path / "a.png")]
    told = CliRunner().invoke(app, words)
    assert told.exit_code == 0, told.output
    assert "greatest" in told.output
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_questions_about_a_drive_that_does_not_twist_or_is_not_shaken_are_refused() -> None:
    with pytest.raises(MachineError, match="has no couplings and no mount"):
        ab.rotor.torsional_modes(ab.example("rigid_rotor"))
    calm = machine(free(couplings=[{"stiffness": 1e3, "inertia": 0.1}]), axis="vertical")
    with pytest.raises(QuestionError, match="nothing shakes this drive train"):
        ab.rotor.torsional_response(calm, [100.0])
    with pytest.raises(QuestionError, match="greater than zero"):
        ab.rotor.torsional_response(FREE, [0.0])
    with pytest.raises(QuestionError, match="harmonics"):
        ab.rotor.torsional_critical_speeds(FREE, harmonics=[0.0])

"""A rotor behind elastic couplings: energy, momentum, limits, and what the motor does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references import lagrange
from tests.references.spatial_machines import states_of
from typer.testing import CliRunner

from autobalancer import basin, load_run, plot, run_measures, save_run, simulate, stepped_response, with_parameter
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, QuestionError
from autobalancer.kernels.system import SPEED, THETA
from autobalancer.machine import Machine
from autobalancer.simulation.record import SampleTimes

ROTOR, FIRST, MOTOR, STATOR = 0.05, 0.01, 0.02, 0.1  # kg m^2
CHAIN: list[dict[str, Any]] = [
    {"name": "belt", "stiffness": 2000.0, "inertia": FIRST, "error": 2e-3, "order": 1, "phase": 0.3},
    {"stiffness": 3000.0, "inertia": MOTOR, "error": 1e-3},
]
MOUNT = {"inertia": STATOR, "stiffness": 500.0}
TIMES = np.linspace(0.0, 2.0, 81)


def machine(drive: dict[str, Any], *, balls: bool = False, **top: Any) -> Machine:
    """A rotor on unequal supports with gravity across its axis; nothing dissipates unless the drive does."""
    race = {
        "collisions": False,
        "race_radius": 0.1,
        "drag": {"law": "viscous", "damping": 0.0},
        "balls": [
            {"count": 2, "diameter": 0.012, "density": 7800.0, "start_angles": [1.0, 3.5], "start_speeds": [0.0, -40.0]}
        ],
    }
    data: dict[str, Any] = {
        "name": "driven",
        "axis": "horizontal",
        "rotor": {"mass": 10.0, "stiffness": [6e5, 8e5], "damping": 0.0, "inertia": ROTOR},
        "unbalances": [{"moment": 6e-3, "angle": 0.4}],
        "balancers": [{"races": [race]}] if balls else [],
        "drive": drive,
        "start": {"speed": 100.0},
    }
    if drive["kind"] == "speed":
        del data["start"]
    return Machine(**(data | top))


def free(**more: Any) -> dict[str, Any]:
    return {"kind": "torque", "torque": 0.0, "couplings": CHAIN} | more


def link_energy(drive: dict[str, Any], states: np.ndarray) -> np.ndarray:
    """Kinetic and elastic energy of all links, written down again from the states behind those of the rotor, J."""
    couplings, mount = drive["couplings"], drive.get("mount")
    count = len(couplings) + (mount is not None)
    links = states[:, -2 * count :].reshape(len(states), count, 2)
    angle, energy = states[:, THETA].copy(), np.zeros(len(states))
    for i, c in enumerate(couplings):
        error = c.get("error", 0.0) * np.cos(c.get("order", 2.0) * angle + c.get("phase", 0.0))
        energy += 0.5 * c["stiffness"] * (links[:, i, 0] - error) ** 2 + 0.5 * c["inertia"] * links[:, i, 1] ** 2
        angle += links[:, i, 0]
    if mount is not None:
        energy += 0.5 * mount["stiffness"] * links[:, -1, 0] ** 2 + 0.5 * mount["inertia"] * links[:, -1, 1] ** 2
    return energy


@pytest.mark.parametrize("balls", [False, True])
def test_energy_goes_to_and_fro_between_rotor_and_couplings_and_none_is_lost(balls: bool) -> None:
    case = machine(free(), balls=balls)
    states, reference = states_of(case, TIMES), lagrange.planar(case)
    links = link_energy(free(), states)
    host = np.array([reference.energy(t, *reference.split(y)) for t, y in zip(TIMES, states[:, :-4], strict=True)])
    assert np.ptp(links) > 0.05  # J
    np.testing.assert_allclose(host + links, host[0] + links[0], rtol=1e-10)


def test_a_motor_on_a_mount_does_the_work_that_rotor_and_stator_take_up_and_dampers_lose() -> None:
    drive = free(
        torque=5.0, mount=MOUNT, couplings=[CHAIN[0] | {"error": 0.0}, CHAIN[1] | {"error": 0.0, "damping": 0.2}]
    )
    case = machine(drive, axis="vertical", unbalances=[])
    fine = np.linspace(0.0, 0.4, 4001)
    states = states_of(case, fine)
    total = 0.5 * ROTOR * states[:, SPEED] ** 2 + link_energy(drive, states)
    motor, stator, first = states[:, -3], states[:, -1], states[:, -5]
    power = 5.0 * (motor - stator) - 0.2 * (motor - first) ** 2
    work = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(fine) * (power[1:] + power[:-1]))])
    assert abs(states[:, -2]).max() > 5.0 / 500.0  # rad, more than it would turn at rest
    np.testing.assert_allclose(total - total[0], work, atol=1e-6 * work[-1])  # of the trapezoids


def test_angular_momentum_of_rotor_and_all_inertias_is_kept_about_a_free_axis() -> None:
    case = machine(free(), axis="vertical", unbalances=[], start={"speed": 100.0})
    states = states_of(case, TIMES)
    momentum = ROTOR * states[:, SPEED] + FIRST * states[:, -3] + MOTOR * states[:, -1]
    # the error of an alignment turns with the shaft: its torques on both sides differ, and the bearings take the rest
    assert np.ptp(momentum) > 1e-5 * momentum[0]
    aligned = [c | {"error": 0.0} for c in CHAIN]
    bent = states_of(machine(free(couplings=aligned, torque=3.0), axis="vertical", unbalances=[]), TIMES)
    momentum = ROTOR * bent[:, SPEED] + FIRST * bent[:, -3] + MOTOR * bent[:, -1]
    np.testing.assert_allclose(momentum, momentum[0] + 3.0 * TIMES, rtol=1e-11)


def test_two_inertias_swing_against_each_other_with_the_frequency_of_the_textbook() -> None:
    """A torque step on a free pair: the twist is that of an oscillator about its static value."""
    k = 2000.0
    case = machine(
        {"kind": "torque", "torque": 4.0, "couplings": [{"stiffness": k, "inertia": MOTOR}]},
        axis="vertical",
        unbalances=[],
    )
    run = simulate(case, duration=0.5, save=SampleTimes(np.linspace(0.0, 0.5, 101)), tolerance=1e-11)
    rate = np.sqrt(k * (1.0 / ROTOR + 1.0 / MOTOR))
    still = 4.0 * ROTOR / (ROTOR + MOTOR) / k
    expected = still * (1.0 - np.cos(rate * run["time"].values))
    np.testing.assert_allclose(run["twist"].values[:, 0], expected, atol=1e-7 * still)
    np.testing.assert_allclose(run["link_torque"].values[:, 0], k * expected, atol=1e-7 * k * still)
    assert list(run["link"].values) == ["motor"]
    assert run["twist"].attrs["units"] == "rad"
    assert run["link_torque"].attrs["units"] == "N m"


def test_a_rotor_on_softening_rubber_twists_as_one_on_springs_while_its_rubber_slides() -> None:
    """Both have states of their own behind those of the rotor; without unbalance they do not meet."""
    friction = {"breakaway_amplitude": [1e-4, 3e-4], "stiffness": [2e5, 1e5]}
    rubber = {"mass": 10.0, "inertia": ROTOR, "rubber": {"stiffness": 3e5, "damping": 20.0, "friction": friction}}
    top: dict[str, Any] = {"axis": "vertical", "unbalances": [], "start": {"speed": 100.0, "deflection": [4e-4, 0.0]}}
    springs = {"mass": 10.0, "inertia": ROTOR, "stiffness": 3e5, "damping": 20.0}
    times = np.linspace(0.0, 0.3, 31)
    soft, plain = (
        simulate(machine(free(torque=2.0), rotor=rotor, **top), duration=0.3, save=SampleTimes(times), tolerance=1e-11)
        for rotor in (rubber, springs)
    )
    assert np.ptp(soft["twist"].values) > 1e-3
    np.testing.assert_allclose(soft["twist"], plain["twist"], atol=1e-10)
    assert abs(soft["x"].values - plain["x"].values).max() > 1e-5


def test_a_stiff_coupling_is_none() -> None:
    """The rotor with the inertia of the motor on it moves alike; the swing after a step falls with the root of the stiffness."""
    rigid = machine(
        {"kind": "torque", "torque": 5.0},
        rotor={"mass": 10.0, "stiffness": [6e5, 8e5], "damping": 0.0, "inertia": ROTOR + MOTOR},
        balls=True,
    )
    times = np.linspace(0.0, 0.5, 51)
    expected, missed = states_of(rigid, times)[:, SPEED], []
    for stiffness in (1e4, 1e5):
        drive = {
            "kind": "torque",
            "torque": 5.0,
            "couplings": [{"stiffness": stiffness, "inertia": MOTOR, "damping": 2.0}],
        }
        missed.append(abs(states_of(machine(drive, balls=True), times)[:, SPEED] - expected).max())
    assert missed[1] / missed[0] == pytest.approx(0.1**0.5, rel=0.1)
    assert missed[1] < 0.02


def test_behind_a_coupling_the_rotor_follows_a_prescribed_motor_with_the_lag_of_its_inertia() -> None:
    profile = {"kind": "ramp", "start": "0 rpm", "end": "1000 rpm", "duration": "1 s"}
    coupling = {"stiffness": 500.0, "damping": 2.0}
    case = machine({"kind": "speed", "profile": profile, "couplings": [coupling]}, axis="vertical", unbalances=[])
    run = simulate(case, duration=1.0, save=SampleTimes([0.0, 0.5, 0.99]), tolerance=1e-10)
    rate = 1000.0 * np.pi / 30.0
    np.testing.assert_allclose(run["link_speed"].values[:, 0], rate * run["time"].values, atol=1e-9 * rate)
    assert float(run["twist"][-1, 0]) == pytest.approx(ROTOR * rate / 500.0, rel=1e-6)
    assert float(run["speed"][-1]) == pytest.approx(0.99 * rate, rel=1e-6)


def test_ripples_of_the_torque_shake_a_rotor_without_any_coupling() -> None:
    """Far below their effect on the speed: w' = T cos(n w t)/J."""
    ripple = {"torque": 0.5, "order": 6}
    case = machine({"kind": "torque", "torque": 0.0, "ripples": [ripple]}, axis="vertical", unbalances=[])
    run = simulate(case, duration=0.1, save=SampleTimes(np.linspace(0.0, 0.1, 201)), tolerance=1e-11)
    moved = run["speed"].values - 100.0
    np.testing.assert_allclose(
        moved, 0.5 / ROTOR * np.sin(6.0 * run["rotor_angle"].values) / 600.0, atol=1e-4 * moved.max()
    )


def test_an_asynchronous_motor_gives_its_breakdown_torque_at_its_breakdown_slip() -> None:
    """At start, at its breakdown speed, and at the synchronous speed: s/s_b + s_b/s halves of the breakdown torque."""
    words = {"rated_torque": 10.0, "overload": 2.2, "synchronous_speed": 157.0, "breakdown_slip": 0.2}
    for speed, torque in ((0.0, 22.0 * 2.0 / (5.0 + 0.2)), (0.8 * 157.0, 22.0), (157.0, 0.0)):
        for extra in ({}, {"couplings": [{"stiffness": 1000.0, "inertia": MOTOR}]}):
            drive = {"kind": "asynchronous", **words, **extra}
            case = machine(drive, axis="vertical", unbalances=[], start={"speed": speed})
            states = states_of(case, [0.0, 1e-6])
            inertia, at = (MOTOR, -1) if extra else (ROTOR, SPEED)
            assert (states[-1, at] - states[0, at]) / 1e-6 * inertia == pytest.approx(torque, abs=3e-4)


@pytest.mark.parametrize(
    ("drive", "says"),
    [
        ({"kind": "torque", "torque": 1.0, "couplings": [{"stiffness": 1e3}]}, r"couplings\[1\].inertia: missing"),
        ({"kind": "speed", "profile": {"kind": "constant", "speed": 10}, "mount": MOUNT}, "unknown key"),
        ({"kind": "torque", "torque": 1.0, "couplings": [{"stiffness": 0.0, "inertia": 1.0}]}, "greater than zero"),
    ],
)
def test_a_drive_train_that_cannot_be_is_refused(drive: dict[str, Any], says: str) -> None:
    with pytest.raises(MachineError, match=says):
        machine(drive)


def test_a_coupling_needs_the_inertia_of_the_rotor() -> None:
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 10}, "couplings": [{"stiffness": 1e3}]}
    with pytest.raises(MachineError, match=r"rotor\.inertia"):
        machine(drive, rotor={"mass": 10.0, "stiffness": 6e5, "damping": 0.0})


def test_theories_at_a_constant_speed_say_that_they_leave_the_torsion_out_and_are_those_of_the_rigid_drive() -> None:
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 300.0}}
    damped = {"axis": "vertical", "rotor": {"mass": 10.0, "stiffness": 6e5, "damping": 100.0, "inertia": ROTOR}}
    rigid, twisting = (
        machine(drive | more, balls=True, **damped) for more in ({}, {"couplings": [{"stiffness": 1e3}]})
    )
    said = "torsion of the drive"
    for theory in (Theory.AT_REST, Theory.STALLED, Theory.BASIN):
        assert said in unknown(twisting, theory)
        assert said not in unknown(rigid, theory)
    speeds = [stepped_response(case, ["300 rpm"], dwell=0.05, window=0.05) for case in (rigid, twisting)]
    assert speeds[0]["amplitude"].values == speeds[1]["amplitude"].values
    drag = "balancers[1].races[1].drag.damping"
    ends = [basin(with_parameter(case, drag, 1e-3), 300.0, random=2) for case in (rigid, twisting)]
    name = "final_ball_angle_in_rotor"
    assert np.array_equal(*(end[name].values for end in ends))


def sudden(torque: float) -> Machine:
    """A rotor at rest behind one coupling, and a motor whose full torque acts from the first instant."""
    coupling = {"name": "shaft", "stiffness": 2000.0, "inertia": MOTOR}
    return machine(
        {"kind": "torque", "torque": torque, "couplings": [coupling]}, axis="vertical", unbalances=[], start={}
    )


def test_a_torque_that_acts_at_once_loads_the_shaft_twice_as_much_as_a_slow_one() -> None:
    """Slowly applied it is T J_r/(J_r + J_m); the twist then swings about this without loss."""
    steady = 3.0 * ROTOR / (ROTOR + MOTOR)
    found = run_measures(simulate(sudden(3.0), duration=0.5))
    assert float(found["peak_torque"].sel(link="shaft")) == pytest.approx(2.0 * steady, rel=1e-3)
    assert float(found["peak_twist"].sel(link="shaft")) == pytest.approx(2.0 * steady / 2000.0, rel=1e-3)
    period = 2.0 * np.pi / np.sqrt(2000.0 * (1.0 / ROTOR + 1.0 / MOTOR))
    turns = np.round(float(found["peak_torque_speed"][0]) / (3.0 / (ROTOR + MOTOR) * 0.5 * period))
    assert turns % 2 == 1  # at half a period, or any number of whole ones later


def test_ten_samples_in_a_cycle_are_enough_for_the_greatest_torque() -> None:
    period = 2.0 * np.pi / np.sqrt(2000.0 * (1.0 / ROTOR + 1.0 / MOTOR))
    every = np.arange(0.15, 1.9, 0.1) * period  # the peaks are in the middle between two samples
    run = simulate(sudden(3.0), duration=float(every[-1]), save=SampleTimes(tuple(every)))
    wanted = 2.0 * 3.0 * ROTOR / (ROTOR + MOTOR)
    assert float(np.abs(run["link_torque"]).max()) < 0.976 * wanted
    found = run_measures(run)
    assert float(found["peak_torque"][0]) == pytest.approx(wanted, rel=4e-3)
    assert float(found["peak_twist"][0]) == pytest.approx(wanted / 2000.0, rel=4e-3)


def test_the_twist_of_a_drive_train_is_drawn_and_refused_where_there_is_none(tmp_path: Path) -> None:
    file, picture = tmp_path / "sudden.nc", tmp_path / "twist.png"
    save_run(simulate(sudden(3.0), duration=0.2), file)
    shown = CliRunner().invoke(app, ["plot", str(file), "--kind", "drive-train", "--out", str(picture)])
    assert shown.exit_code == 0
    assert picture.stat().st_size > 10_000
    figure = plot.answer(load_run(file), "drive_train")
    assert [axes.get_ylabel() for axes in figure.axes] == ["speed (rpm)", "torque (N m)", "twist (°)", "torque (N m)"]
    torque = figure.axes[1].lines[0].get_ydata()
    assert np.max(torque) == pytest.approx(6.0 * ROTOR / (ROTOR + MOTOR), rel=1e-2)
    stiff = simulate(machine({"kind": "torque", "torque": 1.0}, axis="vertical"), duration=0.1)
    with pytest.raises(
        QuestionError,
        match=r"given 'drive_train', which .*couplings or a mount; of this result there are run_up, race, orbit",
    ):
        plot.answer(stiff, "drive_train")

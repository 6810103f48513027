"""Measures of planes, stations and supports: statics apart from vibration, forces against the momentum of everything."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import CubicSpline

import autobalancer as ab
from autobalancer.assembly.places import coordinates, places_of
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.system import assemble
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine import Machine
from autobalancer.results.display_units import length_text
from autobalancer.results.time_series import standing

GRAVITY = 9.80665
MACHINES = Path(__file__).parents[1] / "examples" / "machines"
DRUM = """
name = "drum"
axis = "horizontal"
rotor = { kind = "planar", mass = "25 kg", stiffness = ["9 kN/m", "12 kN/m"], damping = ["150 N*s/m", "180 N*s/m"] }
unbalances = [{ moment = "60000 g*mm" }]
drive = { kind = "speed", profile = { kind = "constant", speed = "1200 rpm" } }
run = { duration = "6 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "230 mm"
drag = { law = "viscous", damping = "6e-3 N*m*s" }
balls = [{ count = 10, diameter = "20 mm", material = "steel" }]
"""


@pytest.fixture(scope="module")
def drum() -> xr.Dataset:
    return ab.simulate(parse_machine(DRUM))


def test_the_weight_of_the_balls_is_static_deflection_and_no_vibration(drum: xr.Dataset) -> None:
    weight = 10 * math.pi / 6 * 0.02**3 * 7800.0 * GRAVITY  # of steel balls as in the catalog
    static = ab.run_measures(drum, "static_deflection")
    assert static.imag == pytest.approx(-weight / 12e3, rel=0.02)
    assert abs(static.real) < 1e-3 * abs(static)
    turn = drum.isel(turn=slice(1, None))
    ranges = [0.5 * np.ptp(turn[f"turn_{axis}"].values) for axis in "xy"]
    found = ab.run_measures(drum, "vibration", place="rotor")
    assert float(found["half_range"]) == pytest.approx(max(ranges), rel=1e-12)
    assert max(ranges) < ab.run_measures(drum, "residual_vibration") < math.sqrt(2.0) * max(ranges) * 1.001
    assert ab.run_measures(drum, "residual_vibration") < 0.05 * abs(static)
    alone = parse_machine(str(drum.attrs["machine"])).rotor.mass * 9.80665 / 12e3  # the sag of the rotor, not in it
    assert float(drum["rotor_sag"][0]) == pytest.approx(alone, rel=1e-9)
    assert f"beyond the {length_text(alone)} by which the rotor sags" in str(ab.verdict(drum))


def test_vibration_of_a_circle_is_its_radius_and_its_velocity() -> None:
    # without balls a rotor far above its critical speed circles with a radius known in closed form
    machine = ab.load_machine(MACHINES / "stall_and_release.toml").model_copy(update={"balancers": ()})
    text = {"kind": "constant", "speed": 500.0}
    machine = ab.with_parameter(machine, "drive", {"kind": "speed", "profile": text})
    run = ab.simulate(machine, duration=10.0, tolerance=1e-11)
    w, m, k, b, u = 500.0, 9.995, 625e3, 100.0, 5e-4
    radius = u * w**2 / abs(k - m * w**2 + 1j * b * w)
    found = ab.run_measures(run, "vibration")
    np.testing.assert_allclose(found["greatest"], radius, rtol=1e-6)
    np.testing.assert_allclose(found["rms"], radius / math.sqrt(2.0), rtol=1e-6)
    np.testing.assert_allclose(found["velocity_rms"], radius * w / math.sqrt(2.0), rtol=1e-6)
    force = ab.run_measures(run, "support_forces")
    np.testing.assert_allclose(force["greatest"], radius * abs(k + 1j * b * w), rtol=1e-6)
    assert float(force["static"][0]) < 1e-6 * float(force["greatest"][0])


@pytest.mark.parametrize(("turns", "ratio"), [(10, 0.44), (10, 0.137), (3, 0.44), (10, 1.35)])
def test_a_whirl_at_another_speed_than_that_of_the_rotor_leaves_no_static_part(turns: int, ratio: float) -> None:
    # circles of 50 um with the rotor and of 500 um with two balls that stall: closed form, about a place 20 um below
    rotor = np.arange(72 * turns) * math.tau / 72
    balls = ratio * rotor[:, None] + np.array([0.3, 2.9])
    whirl = 5e-5 * np.exp(1j * (rotor + 1.0)) + 5e-4 * np.exp(1j * (ratio * rotor - 0.7))
    z = (whirl - 2e-5j)[:, None]
    assert abs(z.mean() + 2e-5j) > 5e-6  # the mean over turns of the rotor alone invents a static part
    assert abs(standing(z, rotor, balls, "weight")[0] + 2e-5j) < 1e-9
    assert standing(z, rotor, balls, "none")[0] == 0.0


STALLED = """
name = "balls stall in thin oil"
axis = "vertical"
rotor = { kind = "planar", mass = "12.27 kg", stiffness = "44.654 kN/m", damping = "68.37 N*s/m" }
unbalances = [{ mass = "5.5 g", radius = "108 mm" }]
drive = { kind = "speed", profile = { kind = "ramp", end = "1200 rpm", duration = "20 s" } }
run = { duration = "30 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "76.95 mm"
drag = { law = "viscous", damping = "8e-6 N*m*s" }
balls = [{ count = 2, diameter = "12.3 mm", density = "7800 kg/m^3", start_angles = ["40 deg", "250 deg"] }]
"""


def test_balls_that_stall_leave_no_static_deflection_on_a_vertical_axis() -> None:
    run = ab.simulate(parse_machine(STALLED))
    in_space = run["turn_rotor_angle"] + run["turn_ball_angle_in_rotor"]
    whirls = (in_space[-1] - in_space[0]) / math.tau
    assert (np.abs(whirls - 4.5) < 1.5).all()  # of ten turns of the rotor
    found, force = ab.run_measures(run, "vibration"), ab.run_measures(run, "support_forces")
    assert float(found["static"][0]) == 0.0 == float(force["static"][0])
    z = np.hypot(run["turn_place_x"].values, run["turn_place_y"].values)
    assert float(found["greatest"][0]) <= z.max()
    told = str(ab.verdict(run))
    assert "static" not in told
    # the same numbers in a row of a sweep
    row = ab.sweep(parse_machine(STALLED), {"rotor.mass": ["12.27 kg"]})
    assert float(row["static_deflection"][0]) == 0.0
    assert float(row["vibration"][0]) == pytest.approx(ab.run_measures(run, "residual_vibration"), rel=1e-3)
    assert float(row["support_force"][0]) == pytest.approx(float(force["greatest"][0]), rel=1e-3)


SHAFT = """
name = "shaft with two balancers"
axis = "horizontal"
drive = { kind = "target_torque", gain = 0.05, damping = 0.05, profile = { kind = "ramp", start = 0, end = 500, duration = 1 } }
stations = [{ name = "left", position = "100 mm" }]
unbalances = [{ moment = "100 g*mm", station = "left" }, { moment = "50 g*mm", angle = "70 deg", station = "300 mm" }]
[rotor]
kind = "shaft"
stiffness_proportional_damping = 1e-5
material = { density = 7850, youngs_modulus = "210 GPa", poisson_ratio = 0.3 }
segments = [{ length = "400 mm", diameter = "15 mm", elements = 8 }]
disks = [{ position = "100 mm", mass = "2 kg", transverse_inertia = 0.004, polar_inertia = 0.008 }]
supports = [
  { position = 0, stiffness = ["50 kN/m", "80 kN/m"], damping = 40, cross_stiffness = [2e3, -3e3] },
  { position = "400 mm", stiffness = "60 kN/m", damping = 20 },
]
[[balancers]]
station = "left"
[[balancers.races]]
orbit_radius = "40 mm"
drag = { law = "viscous", damping = 2e-5 }
balls = [{ count = 2, mass = "1.5 g", motion = "point" }]
[[balancers]]
station = "300 mm"
[[balancers.races]]
orbit_radius = "40 mm"
drag = { law = "viscous", damping = 2e-5 }
balls = [{ count = 2, mass = "1 g", motion = "point" }]
"""


def laid_down_rig() -> Machine:
    """A published rig of several bodies, on its side and at speed from the start."""
    fast = {"kind": "speed", "profile": {"kind": "constant", "speed": "900 rpm"}}
    laid = rig("discoidal_rig").model_copy(update={"axis": "horizontal"})
    return ab.with_parameter(laid, "drive", fast)


@pytest.mark.parametrize(
    "machine",
    [parse_machine(DRUM), ab.load_machine(MACHINES / "two_plane_rotor.toml"), parse_machine(SHAFT), laid_down_rig()],
    ids=["planar", "rigid", "shaft", "multibody"],
)
def test_the_forces_on_the_supports_change_the_momentum_of_rotor_unbalance_and_balls(machine: Machine) -> None:
    end = 0.8
    times = np.linspace(end - 0.02, end, 2001)
    run = ab.simulate(machine, duration=end, save=ab.SampleTimes(times.tolist()), tolerance=1e-11)
    assembly = assemble(machine)
    model, balls = lateral_model(machine), assembly.balls
    force = (run["support_force_x"] + 1j * run["support_force_y"]).values.sum(axis=1)
    rotor = np.exp(1j * run["rotor_angle"].values)
    spread = (run["unbalance"] * np.exp(1j * run["unbalance_angle_in_rotor"])).values * rotor  # M times its offset
    where = {name: (run["plane_x"] + 1j * run["plane_y"]).values[:, i] for i, name in enumerate(run["plane"].values)}
    planes = [where[name] for name in run["plane"].values]
    for i, ball in enumerate(balls):
        arm = ball.eccentricity + ball.orbit_radius * np.exp(1j * run["ball_angle_in_rotor"].values[:, i])
        spread = spread + ball.effective_mass * (planes[int(run["ball_plane"][i]) - 1] + rotor * arm)
    pull = GRAVITY if machine.axis == "horizontal" else 0.0
    weight = -1j * pull * (model.total_mass + sum(ball.effective_mass for ball in balls))
    # the rotor's own mass center, from its states
    own = _rotor_moment(machine, times, end)
    momentum_rate = CubicSpline(times, spread + own)(times, 2)
    middle = slice(100, -100)
    scale = np.abs(force[middle] - weight).max()
    assert scale > 1e-3
    np.testing.assert_allclose((force + momentum_rate)[middle], np.full(1801, weight), atol=2e-3 * scale)


def _rotor_moment(machine: Machine, times: np.ndarray, end: float) -> np.ndarray:
    """Mass times deflection of the rotor's mass center, from the states of the same run."""
    from autobalancer.kernels.integrators import tableau
    from autobalancer.kernels.integrators.runge_kutta import advance
    from autobalancer.simulation.record import record_for
    from autobalancer.simulation.steppers import equations, memory_for

    assembly = assemble(machine)
    pair = tableau.dormand_prince_8()
    record = record_for([ab.SampleTimes(times.tolist())], (), assembly, end)
    memory = memory_for(assembly, end, 1e-11, pair)
    advance(*equations(assembly), assembly.system, pair, record, memory, 10_000_000)
    model, places = lateral_model(machine), places_of(machine, assembly)
    q = coordinates(record.samples, assembly)[0] @ places.basis.T
    n, shape = model.pairs, model.translation[: model.pairs, 0]
    moved = model.mass[:n, :n] @ shape
    return np.asarray(q[:, :n] @ moved + 1j * (q[:, n : 2 * n] @ moved))


def test_residual_unbalance_is_said_of_each_plane() -> None:
    run = ab.simulate(MACHINES / "two_plane_rotor.toml")
    found = ab.run_measures(run, "residual_unbalance")
    point, couple = 100e-6 * np.exp(1j * np.deg2rad(20.0)), 10e-6 * np.exp(1j * np.deg2rad(60.0)) / 0.25
    by_moments = np.abs([point * 0.13 / 0.25 - couple, point * 0.12 / 0.25 + couple])  # planes at -100 and 150 mm
    np.testing.assert_allclose(found["unbalance"], by_moments, rtol=1e-9)
    needed = ab.stability.equilibria(MACHINES / "two_plane_rotor.toml", float(run["speed"][-1]))["required_moment"]
    np.testing.assert_allclose(found["unbalance"], needed, rtol=1e-9)
    assert (found["share"] < 1e-3).all()
    assert float(ab.run_measures(run, "residual_unbalance", plane="upper")["residual"]) == pytest.approx(
        float(found["residual"][1])
    )
    with pytest.raises(QuestionError, match="'lower', 'upper'"):
        ab.run_measures(run, "residual_unbalance", plane="middle")


def test_what_was_not_kept_is_asked_for() -> None:
    machine = parse_machine(DRUM)
    run = ab.simulate(machine, duration=0.3, save=ab.Envelope(20))
    with pytest.raises(QuestionError, match="LastRevolutions"):
        ab.run_measures(run, "residual_vibration")
    with pytest.raises(QuestionError, match="LastRevolutions"):
        ab.run_measures(run, "vibration")


def test_a_drum_is_optimized_by_its_vibration_and_not_by_its_sag() -> None:
    found = ab.sweep(parse_machine(DRUM), {"balancers[1].races[1].balls[1].count": [8, 12]}, seeds=2, duration=6.0)
    assert found["vibration"].dims == ("balancers_1_races_1_balls_1_count", "seed")
    assert found.sizes["ball"] == 12  # of eight balls the other four angles are nan
    sag = found["static_deflection"].mean("seed").values
    assert sag[1] == pytest.approx(1.5 * sag[0], rel=0.02)
    # more balls sag deeper and vibrate less: the worst of these runs with twelve 0.12 of the best with eight
    assert found["vibration"][1].max() < 0.13 * found["vibration"][0].min()
    assert found["balanced"].mean() == (found["verdict"] == "balanced").mean()

"""Ready orders, amplitude and phase over the speed, as what a machine is fitted to and compared with."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.measure import Channel, MeasuredOrders, Sensor, Tacho, record
from autobalancer.measurement.balancing.run_down import first_orders, load_orders
from autobalancer.measurement.noise_density import independent
from autobalancer.measurement.run_up_fit import load_measured
from autobalancer.measurement.tracking import fitted_orders
from autobalancer.rotordynamics.parameter_fit import Trial

ROTOR = """name = "rotor on springs"
axis = "vertical"
rotor = { kind = "planar", mass = "10 kg", stiffness = "100 kN/m", damping = "100 N*s/m" }
drive = { kind = "speed", profile = { kind = "ramp", start = "50 rad/s", end = "180 rad/s", duration = "8 s" } }
unbalances = [{ moment = "400 g*mm", angle = "30 deg" }]
run = { duration = "8 s" }
"""
FREE = {
    "rotor.stiffness": ("50 kN/m", "200 kN/m"),
    "rotor.damping": ("10 N*s/m", "1 kN*s/m"),
    "unbalances[1].moment": ("50 g*mm", "2 kg*mm"),
    "unbalances[1].angle": ("-90 deg", "90 deg"),
}


@pytest.fixture(scope="module")
def rotor() -> ab.machine.Machine:
    return ab.parse_machine(ROTOR)


@pytest.fixture(scope="module")
def run(rotor: ab.machine.Machine) -> xr.Dataset:
    return ab.simulate(rotor, save=ab.Samples(8001), progress=False)


@pytest.fixture(scope="module")
def tracked(run: xr.Dataset) -> xr.Dataset:
    sensors = [Sensor("displacement", direction=way, noise="20 um") for way in ("x", "y")]
    return ab.measure.orders(record(run, [*sensors, Tacho()], "1 kHz", seed=3))


def steady(rotor: ab.machine.Machine, speeds: np.ndarray, noise: float, seed: int = 1) -> xr.Dataset:
    """Exact steady orders of a displacement along x and an acceleration at 20 degrees, with noise of a share of the mean."""
    random, found = np.random.default_rng(seed), []
    for quantity, way in (("displacement", 0.0), ("acceleration", np.radians(20.0))):
        seen = ab.rotor.response(rotor, speeds, quantity=quantity)
        x, y = ((seen[f"{k}_real"] + 1j * seen[f"{k}_imag"]).values[:, 0] for k in "xy")
        found.append(x * np.cos(way) + y * np.sin(way))
    exact = np.array(found).T
    spread = noise * np.abs(exact).mean(axis=0) + 0.0 * np.abs(exact)
    values = exact + spread * (random.standard_normal(exact.shape) + 1j * random.standard_normal(exact.shape))
    both = ("speed", "channel")
    data = {
        "amplitude": (both, np.abs(values)),
        "phase": (both, np.angle(values)),
        "amplitude_deviation": (both, spread),
    }
    text = {"place": ["", ""], "direction": ["x", "20"], "quantity": ["displacement", "acceleration"]}
    return xr.Dataset(data, {"speed": speeds, **{k: ("channel", np.array(v, object)) for k, v in text.items()}})


def test_points_that_share_samples_count_as_often_as_their_noise_is_independent() -> None:
    angle = np.arange(0.0, 2.0 * np.pi * 400.0, 2.0 * np.pi / 32.0)
    noise = np.random.default_rng(2).standard_normal((40, angle.size))
    centers = np.arange(20.0, angle[-1] - 20.0, 0.5 * np.pi)
    seen = fitted_orders(angle, noise, np.array([1.0]), centers, 4.0).amplitude[0]
    spread = np.sqrt((np.abs(seen.mean(axis=1)) ** 2).mean())  # of the mean over all points
    time = centers / 10.0
    points = xr.Dataset(
        {"amplitude": ("time", np.abs(seen[0]))}, {"time": time, "speed": ("time", np.full(time.size, 10.0))}
    )
    count = independent(points.assign_attrs(window_revolutions=4.0)).sizes["time"]
    one = np.sqrt((np.abs(seen) ** 2).mean())
    assert spread == pytest.approx(
        one / np.sqrt(count), rel=0.3
    )  # of 40 means: 8 % of a complex number, and the step of 6
    assert spread > 1.5 * one / np.sqrt(time.size)
    assert independent(points).sizes["time"] == time.size


def test_amplitude_and_phase_give_back_stiffness_damping_and_unbalance(rotor: ab.machine.Machine) -> None:
    orders = steady(rotor, np.linspace(70.0, 140.0, 40), 0.01)
    start = ab.with_parameter(ab.with_parameter(rotor, "rotor.stiffness", 108e3), "rotor.damping", 140.0)
    found = ab.rotor.identify(start, FREE, [MeasuredOrders(orders)]).data
    true = np.array([100e3, 100.0, 400e-6, np.radians(30.0)])
    assert (np.abs(found["value"].values - true) < 4.0 * found["uncertainty"].values).all()
    assert (found["uncertainty"].values < 0.005 * true).all()
    assert found.attrs["chi_square"] == pytest.approx(156.0, abs=4.0 * np.sqrt(2.0 * 156.0))
    assert set(found["row_part"].values) == {
        "x, amplitude", "20 deg, amplitude", "x, phase", "20 deg, phase",
    }  # fmt: skip


def test_an_error_that_all_points_of_a_channel_share_counts_once(rotor: ab.machine.Machine) -> None:
    speeds = np.linspace(70.0, 140.0, 30)
    orders, shift = steady(rotor, speeds, 0.01), 40e-6 * np.exp(0.7j)  # of a run-out that was found wrong
    readings = orders["amplitude"] * np.exp(1j * orders["phase"])
    readings[:, 0] += shift
    orders = orders.assign(amplitude=np.abs(readings), phase=(readings.dims, np.angle(readings)))
    alone = MeasuredOrders(orders)
    spread = np.array([abs(shift), 0.0])
    known = orders.assign(
        amplitude_deviation=np.hypot(orders["amplitude_deviation"], spread), runout_deviation=("channel", spread)
    )
    shared = MeasuredOrders(known)
    np.testing.assert_allclose(shared.deviations, alone.deviations, rtol=1e-6)
    exact = steady(rotor, speeds, 0.0)
    predicted = np.concatenate([exact[name].values.T.ravel() for name in ("amplitude", "phase")])
    apart, white = alone.residual(predicted), shared.residual(predicted)
    phase = np.angle(readings.values[:, 0])
    sizes = shared.deviations[0][:, 0]
    seen = np.zeros((apart.size, 2))
    seen[: speeds.size] = np.column_stack([np.cos(phase), np.sin(phase)]) / sizes[:, None]
    seen[apart.size // 2 :][: speeds.size] = np.column_stack([-np.sin(phase), np.cos(phase)]) / sizes[:, None]
    whole = np.eye(apart.size) + abs(shift) ** 2 * seen @ seen.T
    assert white @ white == pytest.approx(apart @ np.linalg.solve(whole, apart), rel=1e-9)
    assert white @ white < 0.2 * (apart @ apart)


def test_orders_of_a_fast_run_up_give_back_the_rotor_if_trials_run_up_too(
    rotor: ab.machine.Machine, tracked: xr.Dataset
) -> None:
    start, free = ab.with_parameter(rotor, "rotor.damping", 130.0), {"rotor.damping": FREE["rotor.damping"]}
    found = ab.rotor.identify(start, free, [MeasuredOrders(tracked, steady=False)]).data
    assert abs(float(found["value"][0]) - 100.0) < 4.0 * float(found["uncertainty"][0]) < 2.0
    assert found.attrs["scatter_ratio"] == pytest.approx(1.0, abs=0.2)
    along = ab.rotor.identify(
        start, free, [MeasuredOrders(tracked)]
    ).data  # the linear rotor follows the measured speed
    assert abs(float(along["value"][0]) - 100.0) < 4.0 * float(along["uncertainty"][0]) < 2.0
    assert along.attrs["notes"][-1] == "orders: the response is followed along the measured speed"


@cache
def beating() -> xr.Dataset:
    """Signals of a lightly damped rotor after its resonance."""
    mass, damping, stiffness, moment, begin, grow = 10.0, 30.0, 100e3, 400e-6 * np.exp(1j * np.pi / 6.0), 50.0, 16.25
    time = np.arange(32000) / 4e3
    start = moment * begin**2 / (stiffness - mass * begin**2 + 1j * damping * begin)

    def rates(t: float, s: np.ndarray) -> list[complex]:  # z = x + i y
        w, theta = begin + grow * t, begin * t + 0.5 * grow * t**2
        force = moment * (w**2 - 1j * grow) * np.exp(1j * theta)
        return [s[1], (force - damping * s[1] - stiffness * s[0]) / mass]

    z = solve_ivp(rates, (0.0, 8.0), [start, 1j * begin * start], "DOP853", time, rtol=1e-8, atol=1e-11).y[0]
    noise = 5e-6 * np.random.default_rng(3).standard_normal((2, time.size))
    pulses = (begin * time + 0.5 * grow * time**2) % (2.0 * np.pi) < 0.3
    return ab.measure.signals(
        time,
        {
            "x": Channel(z.real + noise[0], "displacement", "", "x"),
            "y": Channel(z.imag + noise[1], "displacement", "", "y"),
            "tacho": Channel(pulses.astype(float), "tacho"),
        },
    )


@pytest.mark.parametrize("method", ["fit", "vold-kalman"])
def test_beats_after_a_resonance_do_not_look_like_damping(rotor: ab.machine.Machine, method: Any) -> None:
    """At 7 times the squared decay rate they are as short as the window, which the response goes through, too."""
    light = ab.with_parameter(rotor, "rotor.damping", 30.0)
    orders = MeasuredOrders(ab.measure.orders(beating(), method=method, progress=False))
    free = {name: FREE[name] for name in ("rotor.stiffness", "rotor.damping", "unbalances[1].moment")}
    found = ab.rotor.identify(ab.with_parameter(light, "rotor.damping", 40.0), free, [orders]).data
    true = np.array([100e3, 30.0, 400e-6])
    assert (np.abs(found["value"].values - true) < 2.0 * found["uncertainty"].values).all()
    assert float(found["uncertainty"][1]) < (1.0 if method == "fit" else 4.0)
    # chi square is that of the noise: what the window takes from the response, too, and errors of the angle count once
    ratio = found.attrs["scatter_ratio"]
    assert ratio == pytest.approx(1.0, abs=0.15) or method != "fit"
    assert (
        f"the deviations are {ratio:.2g} of the stated errors: these are too large" in str(found.attrs["notes"])
    ) == (ratio < 0.8)


def test_slow_errors_of_the_tacho_do_not_look_like_stiffness(rotor: ab.machine.Machine) -> None:
    """At 22 rpm/s edges that are known to a sample leave the speed at the resonance wrong by far more than noise does."""
    mass, damping, stiffness, moment, begin, grow = 10.0, 30.0, 100e3, 400e-6 * np.exp(1j * np.pi / 6.0), 85.0, 2.3
    grid = np.linspace(0.0, 13.0, 5201)
    start = moment * begin**2 / (stiffness - mass * begin**2 + 1j * damping * begin)

    def rates(t: float, s: np.ndarray) -> list[complex]:
        w, theta = begin + grow * t, begin * t + 0.5 * grow * t**2
        force = moment * (w**2 - 1j * grow) * np.exp(1j * theta)
        return [s[1], (force - damping * s[1] - stiffness * s[0]) / mass]

    z = solve_ivp(rates, (0.0, 13.0), [start, 1j * begin * start], "DOP853", grid, rtol=1e-8, atol=1e-12).y[0]
    slow = CubicSpline(grid, z * np.exp(-1j * (begin * grid + 0.5 * grow * grid**2)))
    light, scores, angles = ab.with_parameter(rotor, "rotor.damping", damping), [], []
    for seed in range(3):
        random = np.random.default_rng(seed)
        rate = 1e3 * (1.0 + 0.03 * random.uniform(-1.0, 1.0))
        time = 0.01 + np.arange(int(12.9 * rate)) / rate
        angle = begin * time + 0.5 * grow * time**2
        seen = (slow(time) * np.exp(1j * angle)).real + 2e-6 * random.standard_normal(time.size)
        channels = {
            "x": Channel(seen, "displacement", "", "x"),
            "tacho": Channel((angle % (2.0 * np.pi) < 0.3).astype(float), "tacho"),
        }
        known = MeasuredOrders(ab.measure.orders(ab.measure.signals(time, channels), progress=False))
        trials = [Trial(ab.with_parameter(light, "rotor.stiffness", k), {}) for k in (1e5, 1.0001e5)]
        rest, other = (known.residual(known.predict(trial)) for trial in trials)
        way = (other - rest) / np.linalg.norm(other - rest)
        scores.append(float(way @ rest))  # what a fit of the stiffness alone is off by, in standard deviations
        found = ab.measure.unbalance_from_run_down(light, known.data)
        angles.append(float((found["unbalance_angle"][0] - np.angle(moment)) / found["unbalance_angle_deviation"][0]))
    assert 0.2 < np.sqrt(np.mean(np.square(scores))) < 1.8  # 10 with errors of the angle that are white
    assert 0.2 < np.sqrt(np.mean(np.square(angles))) < 1.8  # of where a correction goes; 20 without errors of the angle


def test_a_pulse_is_no_better_known_than_to_a_sample() -> None:
    """With a whole number of samples in a turn all pulses are late by the same, which no scatter shows."""
    time, late = np.arange(4000) / 4e3, 0.05 / 4e3  # 25 turns a second, 160 samples in each
    pulses = (25.0 * (time - late) % 1.0 < 0.1).astype(float)
    channels = {
        "x": Channel(1e-4 * np.cos(50.0 * np.pi * (time - late)), "displacement", "", "x"),
        "tacho": Channel(pulses, "tacho"),
    }
    orders = ab.measure.orders(ab.measure.signals(time, channels), progress=False)
    known = MeasuredOrders(orders, "0.01 %")
    off = abs(float(np.angle(known.known.readings).mean()))
    assert off == pytest.approx(50.0 * np.pi * 0.45 / 4e3, rel=0.05)  # half a sample before the first that is high
    assert 0.5 * off < known.rows().error[-1] < 2.0 * off


def test_orders_that_cannot_be_followed_say_how_fast_the_speed_changed(
    rotor: ab.machine.Machine, tracked: xr.Dataset
) -> None:
    orders = MeasuredOrders(tracked)
    for speed, fast in (
        (orders.known.times, False),
        (16.25 * orders.known.times, True),
    ):  # decay 5 1/s: 1 and 16 rad/s^2
        known = replace(orders.known, course=None, speeds=94.0 + speed)
        orders.__dict__["known"] = known
        assert (
            "by up to 155 rpm/s, 0.65 of the squared decay rate: take steady = false"
            in orders.notes(Trial(rotor, {}))[0]
        ) == fast


def test_a_misfit_enlarges_the_uncertainties(rotor: ab.machine.Machine, tracked: xr.Dataset) -> None:
    start, free = ab.with_parameter(rotor, "rotor.damping", 130.0), {"rotor.damping": FREE["rotor.damping"]}
    table = tracked.sel(order=1.0).reset_coords().set_coords(["place", "direction", "quantity"]).swap_dims(time="speed")
    still = ab.rotor.identify(
        start, free, [MeasuredOrders(table.drop_vars("time"))]
    ).data  # without times it is taken as steady
    ratio = still.attrs["scatter_ratio"]
    assert float(still["value"][0]) > 105.0
    assert ratio > 2.0
    alone = 1.0 / np.sqrt(float(still["singular_value"][0]) ** 2)  # of the logarithm of the damping
    assert float(still["uncertainty"][0]) == pytest.approx(ratio * alone * float(still["value"][0]), rel=0.01)
    assert any(f"the uncertainties above are enlarged {ratio:.1f} times" in note for note in still.attrs["notes"])
    decay = float(still["value"][0]) / 20.0  # of 10 kg
    assert (
        f"below {0.1 * decay**2 * 30.0 / np.pi:.3g} rpm/s; of a faster run-up give orders over time"
        in still.attrs["notes"][-1]
    )


def test_a_rotor_that_passes_its_resonance_moves_as_its_equation_says(rotor: ab.machine.Machine) -> None:
    time = np.linspace(0.0, 8.0, 801)

    def rates(t: float, s: np.ndarray) -> list[complex]:  # q = Re(Q e^(i theta)) of 10 kg, 100 kN/m, 100 N s/m
        w, force = 50.0 + 16.25 * t, 400e-6 * np.exp(1j * np.pi / 6.0)
        here = 10.0 * (16.25j - w**2) + 100j * w + 100e3
        return [s[1], (force * (w**2 - 16.25j) - (20j * w + 100.0) * s[1] - here * s[0]) / 10.0]

    found = ab.rotor.response(rotor, 50.0 + 16.25 * time, time=time)
    begin = [400e-6 * np.exp(1j * np.pi / 6.0) * 2500.0 / (75e3 + 5e3j), 0j]
    exact = solve_ivp(rates, (0.0, 8.0), begin, t_eval=time, rtol=1e-8, atol=1e-13, method="DOP853").y[0]
    away = np.abs((found["x_real"] + 1j * found["x_imag"]).values[:, 0] - exact)
    assert away[200:].max() < 1e-5 * np.abs(exact).max()  # both begin a little differently
    steady_one = ab.rotor.response(rotor, 50.0 + 16.25 * time)
    assert (
        np.abs((steady_one["x_real"] + 1j * steady_one["x_imag"]).values[:, 0] - exact).max()
        > 0.2 * np.abs(exact).max()
    )


def test_a_tilting_rotor_on_uneven_supports_passes_its_resonances_as_its_equations_say() -> None:
    support = 'stiffness = ["40 kN/m", "70 kN/m"], damping = "40 N*s/m"'
    body = 'mass = "10 kg", polar_inertia = "0.2 kg*m^2", transverse_inertia = "0.12 kg*m^2"'
    rotor = ab.parse_machine(
        f'''name = "uneven"
        axis = "vertical"
        stations = [{{ name = "disk", position = "50 mm" }}]
        unbalances = [{{ moment = "400 g*mm", station = "disk" }}]
        [rotor]
        kind = "rigid"
        {body.replace(", ", chr(10))}
        supports = [{{ position = "-0.1 m", {support} }}, {{ position = "0.2 m", {support} }}]
        [drive]
        kind = "speed"
        profile = {{ kind = "ramp", start = "50 rad/s", end = "180 rad/s", duration = "8 s" }}
        [run]
        duration = "8 s"'''
    )
    grow, z = 16.25, np.array([-0.1, 0.2])
    lever = np.array([np.ones(2), z])
    stiffness = [lever * k @ lever.T for k in (40e3, 70e3)]
    damping = lever * 40.0 @ lever.T

    def rates(
        t: float, s: np.ndarray
    ) -> np.ndarray:  # x, slope of x, y, slope of y; the spin turns one slope into the other
        w, theta = 50.0 + grow * t, 50.0 * t + 0.5 * grow * t**2
        q, v = s[:4], s[4:]
        force = -400e-6 * (1j * grow - w**2) * np.exp(1j * theta)
        x, y = (-k @ q[p] - damping @ v[p] for k, p in zip(stiffness, (slice(0, 2), slice(2, 4)), strict=True))
        x, y = x + force.real * np.array([1.0, 0.05]), y + force.imag * np.array([1.0, 0.05])
        turn = 0.2 * (w * v[[3, 1]] + grow * q[[3, 1]])
        return np.r_[v, x[0] / 10.0, (x[1] - turn[0]) / 0.12, y[0] / 10.0, (y[1] + turn[1]) / 0.12]

    time = np.linspace(0.0, 8.0, 1601)
    angle = 50.0 * time + 0.5 * grow * time**2
    exact = solve_ivp(rates, (0.0, 8.0), np.zeros(8), t_eval=time, rtol=1e-8, atol=1e-12, method="DOP853").y
    found = ab.rotor.response(rotor, 50.0 + grow * time, stations=["disk"], time=time)
    for axis, (move, slope) in {"x": (0, 1), "y": (2, 3)}.items():
        amplitude = (found[f"{axis}_real"] + 1j * found[f"{axis}_imag"]).values[:, 0]
        true = exact[move] + 0.05 * exact[slope]
        away = np.abs((amplitude * np.exp(1j * angle)).real - true)
        assert away[600:].max() < 2e-3 * np.abs(true).max()  # it began at rest


def test_an_own_run_up_has_the_orders_that_were_tracked_in_it(run: xr.Dataset, tracked: xr.Dataset) -> None:
    found = ab.compare(run, tracked)
    sure = np.hypot(found["order_amplitude_deviation"], 2e-3 * found["order_amplitude"].max())
    assert float((np.abs(found["order_amplitude"] - found["order_amplitude_simulated"]) / sure).max()) < 5.0
    assert found["rms_away"].values == pytest.approx(found["rms_expected"].values, rel=0.3)
    peak = found.isel(measure=0)
    assert peak["measure_of"].item() == "displacement_x"
    assert abs(float(peak["measured_value"] - peak["simulated_value"])) < 5.0 * float(peak["value_deviation"])
    over_speed = (
        tracked.sel(order=1.0).reset_coords().set_coords(["place", "direction", "quantity"]).swap_dims(time="speed")
    )
    again = ab.compare(run, over_speed)
    np.testing.assert_allclose(again["rms_away"], found["rms_away"], rtol=0.15)


@pytest.mark.filterwarnings("ignore::autobalancer.errors.RangeWarning")  # its law of drag is linear
def test_a_photograph_is_compared_with_the_end_of_the_run() -> None:
    machine = ab.example("variant_plain")
    whole = ab.simulate(machine, save=ab.Samples(41), duration="0.2 s", progress=False)
    rest = whole["ball_angle_in_rotor"].values[-1][::-1] % (2.0 * np.pi)
    photograph = xr.Dataset(
        {"ball_angle": ("ball", rest + 0.01), "ball_angle_deviation": ("ball", np.full(rest.size, 0.01))}
    )
    found = ab.compare(whole, photograph)
    np.testing.assert_allclose(found["rms_away"], 0.01, rtol=1e-6)
    assert any("one picture" in note for note in found.attrs["notes"])


def test_what_orders_lack_is_said(rotor: ab.machine.Machine, run: xr.Dataset, tracked: xr.Dataset) -> None:
    orders = steady(rotor, np.linspace(70.0, 140.0, 8), 0.01)
    bare = orders.drop_vars("amplitude_deviation")
    with pytest.raises(QuestionError, match="orders: the deviation of the amplitudes is not known; give error"):
        MeasuredOrders(bare).rows()
    assert MeasuredOrders(bare, "2 %").rows().error[0] == pytest.approx(0.02 * float(bare["amplitude"][0, 0]))
    with pytest.raises(QuestionError, match="channels have several units; give it in percent"):
        MeasuredOrders(bare, "2 um").rows()
    with pytest.raises(QuestionError, match=r"orders, x: .* times the simulated one; is its unit right"):
        ab.rotor.identify(rotor, FREE, [MeasuredOrders(orders.assign(amplitude=1000.0 * orders["amplitude"]))])
    with pytest.raises(QuestionError, match="no speed from 500 to inf rad/s was measured; there are 70 to 140"):
        MeasuredOrders(orders, lowest="500 rad/s").rows()
    with pytest.raises(QuestionError, match="0 of 8 orders are within the run"):
        ab.compare(run, orders.isel(channel=[0]).assign_coords(speed=orders["speed"] + 500.0))
    with pytest.raises(QuestionError, match="orders have their speed already"):
        ab.compare(run, tracked, tacho="tacho")
    with pytest.raises(QuestionError, match=r"no amplitude and phase at 668.45 rpm"):
        first_orders(orders.assign(amplitude=orders["amplitude"].where(orders["speed"] > 75.0)), "orders")


def test_a_measurement_file_names_orders_signals_and_films(
    rotor: ab.machine.Machine, run: xr.Dataset, tracked: xr.Dataset, tmp_path: Path
) -> None:
    ab.save_machine(ab.with_parameter(rotor, "rotor.damping", 120.0), tmp_path / "rotor.toml")
    ab.save_run(tracked, tmp_path / "orders.nc")
    ab.save_run(run, tmp_path / "run.nc")
    part = record(run, [Sensor("displacement", noise="20 um")], "500 Hz", end="4 s")
    ab.save_run(part, tmp_path / "logger.nc")
    begin = '[[parameters]]\npaths = ["rotor.damping"]\nlower = "10 N*s/m"\nupper = "1 kN*s/m"\n'
    (tmp_path / "test.toml").write_text(
        begin + '[[orders]]\nfile = "orders.nc"\nhighest = "110 rad/s"\n[[run_ups]]\nfile = "logger.nc"\nend = "3 s"\n'
    )
    words = ["identify", str(tmp_path / "rotor.toml"), "--measurements", str(tmp_path / "test.toml"), "--json"]
    answer = CliRunner().invoke(app, [*words, "--plot", str(tmp_path / "fit.png")])
    assert answer.exit_code == 0, answer.output
    assert '"rotor.damping"' in answer.output
    wrong = begin + '[[run_ups]]\nfile = "orders.nc"\n'
    (tmp_path / "test.toml").write_text(wrong)
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 2
    assert "run_ups[1].file: orders.nc has neither signals nor ball angles" in " ".join(answer.output.split())
    path = ab.catalog.example_path("run_down_orders")
    assert load_orders(path).equals(load_measured(path))
    answer = CliRunner().invoke(app, ["compare", str(tmp_path / "run.nc"), str(tmp_path / "orders.nc")])
    assert answer.exit_code == 0, answer.output
    assert "peak_amplitude" in answer.output
    answer = CliRunner().invoke(app, ["compare", str(tmp_path / "logger.csv"), str(tmp_path / "run.nc")])
    assert "a run comes first" in answer.output

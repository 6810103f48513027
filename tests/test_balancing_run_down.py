"""Unbalance from one run-down and a model, splitting over holes, trial masses."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.errors import QuestionError, ResultError
from autobalancer.machine import Unbalance
from autobalancer.measure import split_mass, trial_mass, unbalance_from_run_down
from autobalancer.measurement.balancing.run_down import load_orders
from autobalancer.plots.balancing import balancing, four_run, run_down

RPM = np.pi / 30.0


def seen(machine, parts, speeds, directions=("x",), share: float = 0.0, seed: int = 0, quantity: str = "displacement"):
    """Orders as sensors at both named stations would see them."""
    names = [station.name for station in machine.stations]
    found = ab.rotor.response(machine, speeds, names, parts, balls=True, quantity=quantity)
    values = np.concatenate([(found[f"{k}_real"] + 1j * found[f"{k}_imag"]).values for k in directions], axis=1)
    spread = share * np.abs(values).mean() + 0.0 * np.abs(values)
    rng = np.random.default_rng(seed)
    values = values + spread * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    both = ("speed", "channel")
    data = {"amplitude": (both, np.abs(values)), "phase": (both, np.angle(values))}
    if share:
        data["amplitude_deviation"] = (both, spread)
    text = {
        "place": names * len(directions),
        "direction": [k for k in directions for _ in names],
        "quantity": [quantity] * values.shape[1],
    }
    return xr.Dataset(data, {"speed": speeds, **{k: ("channel", np.array(v, object)) for k, v in text.items()}})


@pytest.fixture(scope="module")
def rotor():
    return ab.example("two_plane_rotor")


PARTS = (Unbalance(moment=40e-6, angle=1.0, station="lower"), Unbalance(moment=25e-6, angle=3.5, station="upper"))
TRUE = np.array([part.vector for part in PARTS])


def vectors(found) -> np.ndarray:
    return found["unbalance"].values * np.exp(1j * found["unbalance_angle"].values)


@pytest.mark.parametrize("quantity", ["displacement", "acceleration"])
def test_exact_orders_give_the_exact_unbalance_of_both_planes(rotor, quantity):
    orders = seen(rotor, PARTS, np.linspace(40.0, 300.0, 12), quantity=quantity)
    np.testing.assert_allclose(vectors(unbalance_from_run_down(rotor, orders)), TRUE, rtol=1e-9)


def test_the_stated_deviation_is_that_of_many_run_downs(rotor):
    speeds = np.linspace(60.0, 200.0, 8)
    off = []
    for seed in range(12):
        found = unbalance_from_run_down(rotor, seen(rotor, PARTS, speeds, share=0.05, seed=seed))
        off.append((np.abs(vectors(found)) - np.abs(TRUE)) / found["unbalance_deviation"].values)
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(1.0, abs=0.45)  # of 24 values: 15 %, three times


def test_one_speed_far_above_both_critical_speeds_still_tells_two_planes_but_no_rotor_tells_three(rotor):
    orders = seen(rotor, PARTS, np.array([60.0, 200.0, 400.0]))
    np.testing.assert_allclose(vectors(unbalance_from_run_down(rotor, orders.isel(speed=[2]))), TRUE, rtol=1e-6)
    with pytest.raises(
        QuestionError,
        match=r"cannot be told apart.*0.6 in lower at -?180 deg with 0.4 in upper at -?180 deg with 1 in 0.0",
    ):
        unbalance_from_run_down(rotor, orders, planes=["lower", "upper", 0.0])  # the balance of forces and of moments


def test_tracked_orders_over_time_are_taken_and_those_without_order_1_or_place_are_refused(rotor):
    orders = seen(rotor, PARTS, np.linspace(40.0, 300.0, 12)).isel(speed=slice(None, None, -1))  # down
    tracked = orders.assign_coords(time=("speed", np.arange(12.0))).swap_dims(speed="time").expand_dims(order=[1.0])
    np.testing.assert_allclose(vectors(unbalance_from_run_down(rotor, tracked)), TRUE, rtol=1e-9)
    with pytest.raises(QuestionError, match="no order 1"):
        unbalance_from_run_down(rotor, tracked.assign_coords(order=[2.0]))
    with pytest.raises(QuestionError, match="channel 1 has no place"):
        unbalance_from_run_down(rotor, tracked.assign_coords(place=("channel", ["", "upper"])))


def test_a_wrong_model_is_told(rotor):
    from autobalancer.assembly.quantities import with_value_at

    wrong = with_value_at(rotor, "rotor.mass", 6.0)
    found = unbalance_from_run_down(wrong, seen(rotor, PARTS, np.linspace(40.0, 300.0, 12), share=0.01))
    assert "the model does not describe the rotor" in found.attrs["warnings"]


def test_a_table_of_orders_names_the_line_that_is_missing(rotor, tmp_path):
    path = ab.catalog.example_path("run_down_orders")
    np.testing.assert_allclose(
        np.abs(vectors(unbalance_from_run_down(rotor, path))), [40e-6, 25e-6], rtol=0.01
    )  # noise 0.5 um
    lines = path.read_text().splitlines()
    bad = tmp_path / "orders.csv"
    bad.write_text("\n".join(lines[:-1]))
    with pytest.raises(QuestionError, match="upper x has no line at 300 rpm"):
        load_orders(bad)
    bad.write_text("\n".join([*lines, lines[-1]]))
    with pytest.raises(QuestionError, match="upper x has two lines at this speed"):
        load_orders(bad)
    bad.write_text("\n".join(lines).replace("amplitude [um]", "amplitude [kg]"))
    with pytest.raises(ResultError, match="amplitude in 'kg'"):
        load_orders(bad)
    with pytest.raises(QuestionError, match="no speed from 1000 to"):
        unbalance_from_run_down(rotor, path, lowest=1000.0)


def test_the_published_splits_come_out_to_the_printed_digit():
    # calculator of Vibromera: 15 g at 40 deg over 6 blades; Shreve, Radius Changes and Splitting: 1.925 oz at 250 deg, 9 bolts
    blades = split_mass("15 g", "40 deg", holes=6)
    assert np.round(np.multiply(blades.masses, 1e3), 2).tolist() == [5.92, 11.13]
    bolts = split_mass(1.925, "250 deg", holes=9)
    assert np.degrees(bolts.angles).round().tolist() == [240.0, 280.0]
    np.testing.assert_allclose(bolts.masses, 1.925 * np.sin(np.radians([30.0, 10.0])) / np.sin(np.radians(40.0)))


def test_a_limit_spreads_a_split_over_more_holes_and_leaves_nothing():
    found = split_mass(0.015, 0.7, holes=12, largest=0.006)
    assert max(found.masses) <= 0.006 * (1 + 1e-9)
    assert len(found.masses) > 2
    assert found.residual < 1e-9
    with pytest.raises(QuestionError, match="cannot hold this mass"):
        split_mass(0.015, 0.7, holes=12, largest=0.001)
    with pytest.raises(QuestionError, match="cannot hold this mass"):
        split_mass(0.015, "180 deg", holes=["0 deg", "30 deg"])


def test_a_split_with_given_masses_is_the_best_of_all_choices():
    places, sizes, wanted = 2.0 * np.pi * np.arange(7) / 7, [1.0, 2.5], 3.3 * np.exp(1j * 0.9)
    found = split_mass(abs(wanted), float(np.angle(wanted)), holes=7, masses=sizes, most=2)
    every = [abs(wanted)]
    for i in range(7):
        for a in sizes:
            every.append(abs(wanted - a * np.exp(1j * places[i])))
            every += [
                abs(wanted - a * np.exp(1j * places[i]) - b * np.exp(1j * places[j])) for j in range(i) for b in sizes
            ]
    assert found.residual == pytest.approx(min(every), rel=1e-9)
    with pytest.raises(QuestionError, match="too many"):
        split_mass(1.0, 0.0, holes=60, masses=[0.1 * k for k in range(1, 30)], most=4)


def test_a_trial_mass_by_the_model_changes_the_reading_by_a_third_and_takes_unbalance_away(rotor):
    machine = ab.example("discoidal")
    speed = 60.0
    before = ab.rotor.response(machine, [speed]).isel(speed=0, station=0)
    z = complex(before.x_real, before.x_imag)
    plan = trial_mass(radius=0.1, speed=speed, machine=machine, reading=abs(z), phase=float(np.angle(z)))
    mass = Unbalance(moment=plan.unbalance, angle=plan.angle)
    after = ab.rotor.response(machine, [speed], unbalance=[*machine.unbalances, mass], balls=False).isel(
        speed=0, station=0
    )
    assert abs(complex(after.x_real, after.x_imag)) == pytest.approx(0.7 * abs(z), rel=1e-6)
    rule = trial_mass(radius=0.1, speed="1500 rpm", rotor_mass=20.0, phase=0.5, running="above")
    assert rule.force == pytest.approx(0.1 * 20.0 * 9.80665)
    assert rule.angle == pytest.approx(0.5)  # above, the rotor moves away from its heavy side
    graded = trial_mass(radius=0.1, speed=100.0, rotor_mass=20.0, grade="G 6.3")
    assert graded.unbalance == pytest.approx(5.0 * 6.3e-3 * 20.0 / 100.0)
    with pytest.raises(QuestionError, match="give a machine and a reading"):
        trial_mass(radius=0.1, speed=100.0)


def test_pictures_show_corrections_where_the_answer_has_them(rotor):
    job = ab.measure.balance(ab.catalog.example_path("two_plane_job"))
    ends = [line.get_xydata()[-1] for line in balancing(job).axes[1].lines]
    wanted = 1e3 * job["correction"].values[0] * np.exp(1j * job["correction_angle"].values[0])
    assert min(abs(complex(*end) - wanted) for end in ends) < 1e-9
    runs = ab.measure.four_run(ab.catalog.example_path("four_runs"))
    circles = [patch for patch in four_run(runs).axes[0].patches if hasattr(patch, "radius")]
    meeting = 1e6 * runs["correction"].values[0, 0] * np.exp(1j * runs["correction_angle"].values[0, 0])
    for circle in circles:
        assert abs(abs(complex(*circle.center) - meeting) / circle.radius - 1.0) < 0.03  # noise of 1 %
    down = unbalance_from_run_down(rotor, ab.catalog.example_path("run_down_orders"))
    assert len(run_down(down).axes[0].lines) == 4


def test_sensors_of_several_units_have_an_axis_each_in_the_picture_of_a_run_down(rotor):
    speeds = np.linspace(60.0, 200.0, 9)
    both = [seen(rotor, PARTS, speeds, quantity=quantity) for quantity in ("displacement", "velocity")]
    panels = run_down(unbalance_from_run_down(rotor, xr.concat(both, "channel"))).axes
    assert [axes.get_ylabel() for axes in panels[:2]] == ["amplitude (µm)", "amplitude (mm/s)"]
    lengths, rates = (axes.lines[0].get_ydata() for axes in panels[:2])
    np.testing.assert_allclose(rates, 1e-3 * lengths * speeds, rtol=1e-9)

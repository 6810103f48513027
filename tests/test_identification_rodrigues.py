"""The rig of Rodrigues et al. (2011): its parameters follow from its critical speeds and from its curve."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autobalancer.files.examples import rig
from autobalancer.measurement.run_up_fit import load_measurements
from autobalancer.rotordynamics.campbell import critical_speeds
from autobalancer.rotordynamics.identify import Identification, identify

MACHINE, DATA = rig("rodrigues_rig"), Path("examples/measurements")
RPM = np.pi / 30.0
MEASURED = np.array([1415.0, 1675.0, 1944.0, 2310.0])


@pytest.fixture(scope="module")
def by_speeds() -> Identification:
    return identify(MACHINE, *load_measurements(DATA / "rodrigues_critical_speeds.toml"))


@pytest.fixture(scope="module")
def by_curve() -> Identification:
    return identify(MACHINE, *load_measurements(DATA / "rodrigues_plain_rotor.toml"), loss="cauchy")


def test_the_measured_critical_speeds_are_met_within_a_percent(by_speeds: Identification) -> None:
    deviation = critical_speeds(by_speeds.machine, balls=False)["critical_speed"].values / RPM / MEASURED - 1.0
    assert np.abs(deviation).max() < 0.008  # by hand, with l_1 = 104, l_2 = 156 mm and 1.98 times the stiffness
    before = critical_speeds(MACHINE, balls=False)["critical_speed"].values / RPM / MEASURED - 1.0
    assert np.abs(before).max() > 0.025


def test_the_mass_center_lies_within_the_error_of_its_position(by_speeds: Identification) -> None:
    first, second = (float(support.position) for support in by_speeds.machine.rotor.supports)
    assert first - second == pytest.approx(0.26, rel=1e-9)
    assert first == pytest.approx(0.104, abs=0.002)
    assert by_speeds.machine.rotor.transverse_inertia == pytest.approx(0.0138, abs=0.0005)
    assert by_speeds.machine.stations[2].position == pytest.approx(first - 0.13, rel=1e-9)


def test_the_stiffness_is_twice_the_printed_one(by_speeds: Identification) -> None:
    along_x, along_y = by_speeds.machine.rotor.supports[0].stiffness
    assert along_x / 10750.0 == pytest.approx(2.0, abs=0.05)
    assert along_y / 7900.0 == pytest.approx(2.0, abs=0.05)
    assert by_speeds.machine.rotor.supports[1].stiffness == (along_x, along_y)


def test_the_fitted_rig_of_the_catalog_is_this_fit(by_speeds: Identification) -> None:
    stored = rig("rodrigues_rig_fitted")
    for mine, theirs in zip(by_speeds.machine.rotor.supports, stored.rotor.supports, strict=True):
        assert mine.position == pytest.approx(theirs.position, abs=1e-5)
        assert mine.stiffness == pytest.approx(theirs.stiffness, rel=1e-4)
    assert stored.rotor.transverse_inertia == pytest.approx(by_speeds.machine.rotor.transverse_inertia, rel=1e-3)
    assert [s.name for s in stored.stations] == ["B1", "B2", "disk"]


def test_the_simulated_curve_gives_the_parameters_behind_it(by_curve: Identification) -> None:
    """Tables 2 and 3 of the source, to half of their last digit, with twice the printed stiffness."""
    values = dict(zip(by_curve.data["parameter"].values, by_curve.data["value"].values, strict=True))
    assert values["stiffness along x"] == pytest.approx(2.0 * 10750.0, abs=10.0)
    assert values["stiffness along y"] == pytest.approx(2.0 * 7900.0, abs=100.0)
    assert values["damping over stiffness"] == pytest.approx(2.5e-4, abs=0.05e-4)
    assert values["unbalance"] / 1.28 == pytest.approx(2.9e-5, abs=0.05e-5)
    assert values["misalignment"] == pytest.approx(6.8e-5, abs=0.05e-5)
    assert np.rad2deg(values["angle of the unbalance"]) == pytest.approx(224.0, abs=0.5)


def test_the_curve_is_met_to_the_accuracy_of_its_reading(by_curve: Identification) -> None:
    """All but two vertices, at 1470 and 3000 rpm."""
    relative = np.log(by_curve.data["after"].values / by_curve.data["measured"].values)
    counted = by_curve.data["weight"].values > 0.5
    assert counted.sum() >= counted.size - 3
    assert np.sqrt(np.mean(relative[counted] ** 2)) < 0.0008


def test_the_other_amplitude_measure_does_not_fit_the_curve() -> None:
    """The mean of the greatest deflections, equation (3), differs from the greatest mean that is drawn."""
    free, (curve,) = load_measurements(DATA / "rodrigues_plain_rotor.toml")
    other = identify(MACHINE, free, [replace(curve, measure="mean_of_greatest")])  # type: ignore[type-var]
    assert other.data.attrs["scatter_ratio"] > 10.0

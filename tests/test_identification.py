"""Parameters of a machine come back from what was computed of it."""

import math
from itertools import pairwise

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.campbell import modes
from autobalancer.rotordynamics.identify import identify
from autobalancer.rotordynamics.parameter_fit import (
    FreeParameter,
    KnownValue,
    MeasuredCriticalSpeed,
    MeasuredMode,
    MeasuredResponse,
    MeasuredStiffness,
    weights,
)

RIGID = Machine(
    name="rigid", axis="vertical",
    rotor={
        "kind": "rigid", "mass": 10.0, "transverse_inertia": 0.2, "polar_inertia": 0.1,
        "supports": [
            {"position": 0.2, "stiffness": (4e5, 3e5), "damping": 40.0},
            {"position": -0.3, "stiffness": (4e5, 3e5), "damping": 40.0},
        ],
    },
    stations=[{"name": "top", "position": 0.2}, {"name": "foot", "position": -0.3}],
    unbalances=[{"moment": 2e-4, "station": 0.1}],
    drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
)  # fmt: skip
PLANAR = Machine(
    name="planar", axis="vertical", rotor={"kind": "planar", "mass": 10.0, "stiffness": 9e4, "damping": 30.0},
    unbalances=[{"moment": 1e-4}], drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
)  # fmt: skip


def stiffness_along(axis: int) -> list[str]:
    return [f"rotor.supports[{i}].stiffness[{axis}]" for i in (1, 2)]


TRUE = {"k_x": 5.1e5, "k_y": 2.6e5, "c": 55.0, "J": 0.26}
FREE = [
    FreeParameter(stiffness_along(1), 1e5, 9e5, name="k_x"),
    FreeParameter(stiffness_along(2), 1e5, 9e5, name="k_y"),
    FreeParameter(["rotor.supports[1].damping", "rotor.supports[2].damping"], 1.0, 500.0, name="c"),
    FreeParameter("rotor.transverse_inertia", 0.1, 0.5, name="J"),
]


def changed(machine: Machine, **values: float) -> Machine:
    for parameter in FREE:
        for path in parameter.paths if isinstance(parameter.paths, list) else [parameter.paths]:
            machine = with_value_at(machine, path, values[parameter.name])
    return machine


def measured_on(machine: Machine) -> list:
    """One of everything."""
    rest, turning = modes(machine), modes(machine, 80.0)
    speeds = np.linspace(50.0, 500.0, 60)
    response = ab.rotor.response(machine, speeds, ["top", "foot"])
    found: list = [MeasuredMode(float(rest["frequency"][i]), 0.1, order=i + 1) for i in range(3)]
    found.append(MeasuredMode(float(turning["decay_rate"][0]), 0.1, "decay_rate", speed=80.0))
    found.append(MeasuredMode(float(turning["damping_ratio"][3]), 1e-3, "damping_ratio", speed=80.0, order=4))
    found.append(MeasuredStiffness(7.0e5, 1e9, "top"))  # of no weight
    found.append(MeasuredResponse(speeds, response["mean_of_greatest"].values, 0.01))
    return found


def test_parameters_come_back_exactly_from_data_without_noise() -> None:
    found = identify(RIGID, FREE, measured_on(changed(RIGID, **TRUE)))
    values = dict(zip(found.data["parameter"].values, found.data["value"].values, strict=True))
    for name, true in TRUE.items():
        assert values[name] == pytest.approx(true, rel=1e-8)
    assert found.machine.rotor.transverse_inertia == pytest.approx(0.26, rel=1e-8)
    assert found.machine.rotor.supports[1].stiffness == pytest.approx((5.1e5, 2.6e5), rel=1e-8)
    assert "Identified" in found.machine.description
    assert found.data.attrs["rank"] == 4
    assert not found.data.attrs["notes"]


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
def test_a_robust_fit_finds_the_same_without_outliers(loss: str) -> None:
    found = identify(RIGID, FREE, measured_on(changed(RIGID, **TRUE)), loss=loss)
    np.testing.assert_allclose(found.data["value"], list(TRUE.values()), rtol=1e-8)


def test_static_stiffness_tells_where_the_springs_are() -> None:
    """A force at the first support bends only this one: its stiffness, to the last digit."""
    found = identify(RIGID, {"rotor.supports[1].stiffness[1]": (1e5, 1e6)}, [MeasuredStiffness(6.5e5, 1e3, "top")])
    assert found.machine.rotor.supports[0].stiffness == pytest.approx((6.5e5, 3e5), rel=1e-10)
    assert found.data["uncertainty"].item() == pytest.approx(1e3, rel=1e-6)


def test_the_uncertainty_of_a_known_frequency_is_that_of_the_formula() -> None:
    """w = sqrt(k/M): du(k)/k = 2 du(w)/w; undamped."""
    free = {"rotor.stiffness": (1e4, 2e5)}
    found = identify(PLANAR, free, [MeasuredCriticalSpeed(100.0, 0.7, whirl="forward")])
    assert found.data["value"].item() == pytest.approx(1e5, rel=1e-10)
    assert found.data["uncertainty"].item() == pytest.approx(2.0 * 1e5 * 0.7 / 100.0, rel=1e-6)


@pytest.mark.slow
def test_fits_of_noisy_data_lie_within_their_uncertainty() -> None:
    speeds = np.linspace(60.0, 140.0, 25)
    true = ab.rotor.response(PLANAR, speeds)["semi_major"].values[:, 0]
    free = {"rotor.stiffness": (5e4, 2e5), "rotor.damping": (5.0, 200.0), "unbalances[1].moment": (1e-5, 1e-3)}
    target, normal = np.array([9e4, 30.0, 1e-4]), []
    for seed in range(25):
        noisy = true * np.exp(0.02 * np.random.default_rng(seed).standard_normal(25))
        start = with_value_at(PLANAR, "rotor.stiffness", 9.3e4)
        data = identify(start, free, [MeasuredResponse(speeds, noisy, 0.02, measure="semi_major")]).data
        normal.append((data["value"].values - target) / data["uncertainty"].values)
    score = np.array(normal)
    assert (np.abs(score) < 3.0).mean() > 0.98
    assert (np.abs(score) < 1.0).mean() == pytest.approx(0.683, abs=0.16)  # 75 values, three deviations
    assert (np.abs(score.mean(axis=0)) < 0.45).all()


def test_an_outlier_does_not_move_a_robust_fit() -> None:
    speeds = np.linspace(60.0, 140.0, 25)
    values = ab.rotor.response(PLANAR, speeds)["semi_major"].values[:, 0].copy()
    values[12] *= 3.0
    free = {"rotor.stiffness": (5e4, 2e5), "rotor.damping": (5.0, 200.0)}
    curve = [MeasuredResponse(speeds, values, 0.02, measure="semi_major")]
    start = with_value_at(PLANAR, "rotor.damping", 40.0)
    plain, robust = identify(start, free, curve), identify(start, free, curve, loss="cauchy")
    away = [abs(found.machine.rotor.damping - 30.0) / 30.0 for found in (plain, robust)]
    assert away[0] > 0.05
    assert away[1] < 0.01
    assert robust.data["weight"][12] < 0.01
    assert (np.delete(robust.data["weight"].values, 12) > 0.9).all()


def test_mass_and_stiffness_cannot_both_follow_from_one_frequency() -> None:
    free = {"rotor.mass": (1.0, 50.0), "rotor.stiffness": (1e4, 1e6)}
    found = identify(PLANAR, free, [MeasuredCriticalSpeed(100.0, 0.1, whirl="forward")])
    assert found.data.attrs["rank"] == 1
    assert np.isinf(found.data["uncertainty"]).all()
    (note,) = [note for note in found.data.attrs["notes"] if "do not determine" in note]
    assert "rotor.mass" in note
    assert "rotor.stiffness" in note
    assert math.sqrt(found.machine.rotor.stiffness / found.machine.rotor.mass) == pytest.approx(100.0, rel=1e-9)


def test_a_known_mass_makes_the_stiffness_known() -> None:
    free = {"rotor.mass": (1.0, 50.0), "rotor.stiffness": (1e4, 1e6)}
    rows = [MeasuredCriticalSpeed(100.0, 0.1, whirl="forward"), KnownValue(12.0, 0.24, "rotor.mass")]
    found = identify(PLANAR, free, rows)
    np.testing.assert_allclose(found.data["value"], [12.0, 1.2e5], rtol=1e-8)
    spread = 1.2e5 * math.hypot(0.02, 2.0 * 0.001)
    np.testing.assert_allclose(found.data["uncertainty"], [0.24, spread], rtol=1e-5)
    assert found.data["correlation"].values[0, 1] == pytest.approx(0.02 / math.hypot(0.02, 0.002), rel=1e-5)
    assert any("can hardly be distinguished" in note for note in found.data.attrs["notes"])


def test_a_parameter_without_effect_is_named() -> None:
    free = {"rotor.stiffness": (1e4, 1e6), "unbalances[1].moment": (1e-5, 1e-3)}
    found = identify(PLANAR, free, [MeasuredCriticalSpeed(100.0, 0.1, whirl="forward")])
    assert np.isinf(found.data["uncertainty"][1])
    assert np.isfinite(found.data["uncertainty"][0])
    assert any("do not determine unbalances[1].moment" in note for note in found.data.attrs["notes"])


def test_a_fit_stays_within_its_bounds_and_says_so() -> None:
    found = identify(PLANAR, {"rotor.stiffness": (8e4, 9.5e4)}, [MeasuredCriticalSpeed(100.0, 0.1, whirl="forward")])
    assert found.machine.rotor.stiffness == 9.5e4
    assert bool(found.data["at_bound"][0])
    assert np.isnan(found.data["uncertainty"][0])
    assert any("lies at its bound" in note for note in found.data.attrs["notes"])


def test_tied_parameters_move_together() -> None:
    start = with_value_at(RIGID, "rotor.supports[2].stiffness[1]", 8e5)
    seen = modes(start)
    number = seen["name"].values.tolist().index("cylindrical x")
    rows = [MeasuredMode(float(seen["frequency"][number]), 0.1, mode="cylindrical x")]
    by_factor = identify(start, [FreeParameter(stiffness_along(1), 0.2, 5.0, "factor", "f", 0.6)], rows)
    assert [s.stiffness[0] for s in by_factor.machine.rotor.supports] == pytest.approx([4e5, 8e5], rel=1e-8)
    rows = [KnownValue(0.25, 0.01, "rotor.supports[1].position")]
    places = ["rotor.supports[1].position", "rotor.supports[2].position", "stations[1].position"]
    by_offset = identify(RIGID, [FreeParameter(places, -0.1, 0.1, "offset", "shift")], rows).machine
    assert by_offset.rotor.supports[0].position == pytest.approx(0.25, rel=1e-10)
    assert by_offset.rotor.supports[1].position == pytest.approx(-0.25, rel=1e-10)
    assert by_offset.stations[0].position == pytest.approx(0.25, rel=1e-10)


def test_modes_are_found_by_direction_and_name() -> None:
    """The conical mode along y alone decides on J, whatever its number."""
    true = changed(RIGID, **TRUE)
    seen = modes(true)
    number = seen["name"].values.tolist().index("conical y")
    start = changed(RIGID, **{**TRUE, "J": 0.22})
    rows = [MeasuredMode(float(seen["frequency"][number]), 0.1, mode="conical y")]
    found = identify(start, {"rotor.transverse_inertia": (0.1, 0.5)}, rows)
    assert found.machine.rotor.transverse_inertia == pytest.approx(0.26, rel=1e-8)


@pytest.mark.slow
def test_several_starts_find_the_deeper_hollow() -> None:
    """A resonance peak far from the start has no slope there; searches spread over the bounds find it."""
    speeds = np.linspace(60.0, 140.0, 60)
    true = with_value_at(PLANAR, "rotor.damping", 3.0)
    curve = ab.rotor.response(true, speeds)["semi_major"].values[:, 0]
    start = with_value_at(true, "rotor.stiffness", 1.8e5)
    rows = [MeasuredResponse(speeds, curve, 1e-6, measure="semi_major", logarithmic=False)]
    free = {"rotor.stiffness": (4e4, 2e5)}
    one, many = identify(start, free, rows), identify(start, free, rows, starts=16)
    assert abs(one.machine.rotor.stiffness / 9e4 - 1.0) > 0.05
    assert many.machine.rotor.stiffness == pytest.approx(9e4, rel=1e-8)
    assert many.data.attrs["cost"] < one.data.attrs["cost"]


def test_errors_stated_too_small_are_noticed() -> None:
    rows = [MeasuredCriticalSpeed(v, 0.01, whirl="forward") for v in (99.0, 101.0)]
    found = identify(PLANAR, {"rotor.stiffness": (1e4, 1e6)}, rows)
    assert found.data.attrs["scatter_ratio"] == pytest.approx(math.sqrt(2.0) * 100.0, rel=1e-4)
    assert any("times the stated errors" in note for note in found.data.attrs["notes"])


def test_weights_are_the_slopes_of_the_losses() -> None:
    residuals = np.array([0.5, 1.9, 2.1, 8.0])
    losses = {
        "soft_l1": lambda z: 2.0 * (np.sqrt(1.0 + z) - 1.0),
        "huber": lambda z: np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0),
        "cauchy": np.log1p,
    }
    square, step = (residuals / 2.0) ** 2, 1e-6
    for loss, function in losses.items():
        slope = (function(square + step) - function(square - step)) / (2.0 * step)
        np.testing.assert_allclose(weights(residuals, loss, 2.0), slope, rtol=1e-8)


def test_the_report_says_everything() -> None:
    found = identify(PLANAR, {"rotor.stiffness": (8e4, 9.5e4)}, [MeasuredCriticalSpeed(100.0, 0.1, whirl="forward")])
    text = found.report()
    for part in ("rotor.stiffness = 95000", "at its bound", "critical speed 1 forward", "954.93", "rpm", "chi square"):
        assert part in text


SPEED = [MeasuredCriticalSpeed(100.0, 0.1, whirl="forward")]


@pytest.mark.parametrize(
    ("free", "rows", "says"),
    [
        ({}, SPEED, "free: given none"),
        ({"rotor.stiffness": (1e4, 1e6)}, [], "measurements: given none"),
        ({"rotor.stiffnes": (1e4, 1e6)}, SPEED, "no 'stiffnes' there; there is kind, mass"),
        ({"rotor.stiffness": (1e6, 1e4)}, SPEED, "must ascend"),
        ({"rotor.stiffness": (1e5, 1e6)}, SPEED, "outside the bounds"),
        ({"rotor.stiffness": ("10 kg", "1 kN/m")}, SPEED, "given '10 kg'"),
        ([FreeParameter("rotor.stiffness"), FreeParameter("rotor.stiffness", name="k")], SPEED, "given twice"),
        ([FreeParameter("rotor.stiffness", tie="both")], SPEED, "tie: given 'both'"),
        ({"drive": (0.0, 1.0)}, SPEED, "not a number"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredCriticalSpeed(100.0, 0.0)], "standard deviation greater than zero"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredCriticalSpeed(100.0, 1.0, order=0)], "whole number from 1"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredCriticalSpeed(100.0, 1.0, order=3)], "lacks something that was measured"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredMode(1.0, 1.0, "shape")], "quantity: given 'shape'"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredResponse([1.0, 2.0], [1.0], 0.1)], "as many of both"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredResponse([1.0], [1.0], 0.1, "top")], "no station is named 'top'"),
        ({"rotor.stiffness": (1e4, 1e6)}, [MeasuredResponse([1.0], [1.0], 0.1, measure="top")], "measure: given 'top'"),
    ],
)  # fmt: skip
def test_impossible_questions_are_refused(free: object, rows: list, says: str) -> None:
    with pytest.raises(QuestionError, match=r"[\s\S]*".join(map(__import__("re").escape, says.split("; ")))):
        identify(PLANAR, free, rows)  # type: ignore[arg-type]


def test_odd_options_are_refused() -> None:
    for options, says in (
        ({"loss": "l7"}, "loss: given 'l7'"),
        ({"loss_scale": 0.0}, "loss_scale"),
        ({"starts": 0}, "starts"),
    ):
        with pytest.raises(QuestionError, match=says):
            identify(PLANAR, {"rotor.stiffness": (1e4, 1e6)}, SPEED, **options)  # type: ignore[arg-type]
    with pytest.raises(QuestionError, match="several starts need bounds"):
        identify(PLANAR, [FreeParameter("rotor.stiffness")], SPEED, starts=3)


def test_singular_values_are_sorted_and_directions_orthonormal() -> None:
    data = identify(RIGID, FREE, measured_on(changed(RIGID, **TRUE))).data
    assert all(a >= b for a, b in pairwise(data["singular_value"].values))
    parts = data["direction_part"].values
    np.testing.assert_allclose(parts @ parts.T, np.eye(4), atol=1e-12)

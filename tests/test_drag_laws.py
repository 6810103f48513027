"""Drag coefficients: continuous, anchored where the sources say so, the same in the compiled kernel."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.guided_balls import FluidRows, UniformTable
from autobalancer.errors import QuestionError, RangeWarning
from autobalancer.kernels.laws.curves import drag_force
from autobalancer.laws import drag_coefficient as laws
from autobalancer.laws.drag_coefficient import DragCurve, annulus_cd_times_re, linear_drag

MEASURED = laws.table([0.5, 3.0, 40.0, 55.0, 2500.0, 2e4], [760.0, 131.0, 12.0, 9.3, 0.81, 0.6])
GEOMETRY = ab.laws.race_geometry(annulus_cd_times_re(2.10, 0.07))
LAWS = [*ab.laws.drag_laws(), GEOMETRY, laws.joined(300.0, 0.5), MEASURED]
NAMES = [f"{law.name}-{i}" for i, law in enumerate(LAWS)]


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_the_drag_coefficient_never_jumps(law: laws.DragLaw) -> None:
    for place in (law.stokes_end, 10.0, law.kept_from, 2e4, 2e5):
        below, above = law.product(place * (1.0 - 1e-12)), law.product(place * (1.0 + 1e-12))
        assert above == pytest.approx(below, rel=1e-10)


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_a_drag_belongs_to_one_velocity(law: laws.DragLaw) -> None:
    re = np.geomspace(1e-4, 1e6, 5001)
    assert (np.diff(law.product(re) * re) > 0.0).all()


@pytest.mark.parametrize("law", [ab.laws.discoidal(), ab.laws.discoidal(0.74), GEOMETRY, laws.joined(300.0, 0.5)])
def test_joined_laws_lie_between_linear_and_quadratic_drag(law: laws.DragLaw) -> None:
    re = np.geomspace(1.0, 1e6, 5001)
    product = law.product(re)
    assert (np.diff(product) >= -1e-12 * product[:-1]).all()
    assert (np.diff(product / re) <= 1e-12).all()


def test_the_published_law_of_the_plane_dips_five_percent_below_linear_drag_at_re_19() -> None:
    re = np.geomspace(10.0, 100.0, 20001)
    product = ab.laws.sphere_on_plane().product(re)
    assert re[product.argmin()] == pytest.approx(19.1, abs=0.1)
    assert product.min() / 322.0 == pytest.approx(0.9485, abs=0.0005)


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_the_slope_is_the_derivative_of_the_law(law: laws.DragLaw) -> None:
    re = np.geomspace(law.stokes_end * 1.02, law.kept_from * 0.98, 400)
    step = 1e-6
    up, down = law.product(re * np.exp(step)), law.product(re * np.exp(-step))
    np.testing.assert_allclose(law.log_slope(re), np.log(up / down) / (2.0 * step) - 1.0, atol=3e-7)


def test_a_sphere_on_a_plane_has_the_printed_anchors_and_departs_from_print_by_the_jumps_only() -> None:
    law = ab.laws.sphere_on_plane()
    assert law.product([0.0, 1.0, 10.0]) == pytest.approx([322.0] * 3, rel=1e-14)
    assert law.coefficient([2e4, 1e5]) == pytest.approx([0.74] * 2, rel=1e-12)
    x = np.linspace(1.0, np.log10(2e4), 500)
    printed = 10.0 ** (3.02 - 1.89 * x + 0.411 * x**2 - 0.033 * x**3)
    off = law.coefficient(10.0**x) / printed - 1.0
    assert off[0] == pytest.approx(-0.00033, abs=1e-5)
    assert np.abs(off).max() < 0.0019


def test_the_discoidal_law_has_the_coefficients_of_both_plateaus() -> None:
    assert ab.laws.discoidal().coefficients == pytest.approx((2.68655, -1.18883, 0.0811522, 0.00884302), rel=5e-6)
    refit = ab.laws.discoidal(0.74).coefficients
    assert refit == pytest.approx((2.71669, -1.25418, 0.12142, 0.00377887), rel=5e-6)
    assert [round(c, d) for c, d in zip(refit, (2, 2, 3, 4), strict=True)] == [2.72, -1.25, 0.121, 0.0038]


@pytest.mark.parametrize("plateau", [0.6, 0.74])
def test_the_discoidal_law_joins_both_ends_without_a_bend(plateau: float) -> None:
    law = ab.laws.discoidal(plateau)
    assert law.coefficient(10.0) == pytest.approx(38.7, rel=1e-12)
    assert law.coefficient(2e4) == pytest.approx(plateau, rel=1e-12)
    assert law.log_slope(10.0) == pytest.approx(-1.0, abs=1e-12)
    assert law.log_slope(2e4) == pytest.approx(0.0, abs=1e-12)


def test_the_race_geometry_goes_on_beyond_ten_from_its_stokes_value() -> None:
    assert GEOMETRY.product(10.0) == pytest.approx(248.0 * 2.1 ** (-11.0 / 8.0) + 245.0 - 8.13, rel=1e-13)
    assert GEOMETRY.log_slope(10.0) == pytest.approx(-1.0, abs=1e-12)
    assert GEOMETRY.coefficient(1e5) == pytest.approx(0.74, rel=1e-12)
    # the cross section behind (6.9)
    assert ab.laws.race_geometry(annulus_cd_times_re(1.5, 0.0799)).coefficient(500.0) == pytest.approx(
        ab.laws.discoidal(0.74).coefficient(500.0), rel=1e-3
    )


def clift(re: float) -> float:
    """The standard drag curve in pieces, Clift, Grace and Weber (1978), table 5.2."""
    w = np.log10(re)
    if re < 20.0:
        return float(24.0 / re * (1.0 + 0.1315 * re ** (0.82 - 0.05 * w)))
    if re < 260.0:
        return float(24.0 / re * (1.0 + 0.1935 * re**0.6305))
    if re < 1500.0:
        return float(10.0 ** (1.6435 - 1.1242 * w + 0.1558 * w**2))
    if re < 1.2e4:
        return float(10.0 ** (-2.4571 + 2.5558 * w - 0.9295 * w**2 + 0.1049 * w**3))
    if re < 4.4e4:
        return float(10.0 ** (-1.9181 + 0.6370 * w - 0.0636 * w**2))
    return float(10.0 ** (-4.3390 + 1.5809 * w - 0.1546 * w**2))


@pytest.mark.parametrize("re", [0.05, 0.5, 3.0, 15.0, 100.0, 200.0, 800.0, 3000.0, 2e4, 1e5])
def test_a_free_sphere_follows_the_standard_drag_curve(re: float) -> None:
    law = ab.laws.free_sphere()
    assert float(law.coefficient(re)) == pytest.approx(clift(re), rel=0.045 if re < 5e4 else 0.07)
    cheng = 24.0 / re * (1.0 + 0.27 * re) ** 0.43 + 0.47 * (1.0 - np.exp(-0.04 * re**0.38))
    assert cheng - float(law.coefficient(re)) == pytest.approx(0.00279 / re, rel=0.01)


def test_a_table_goes_through_its_points_and_is_linear_below_the_first() -> None:
    np.testing.assert_allclose(MEASURED.coefficient(MEASURED.reynolds), MEASURED.coefficients, rtol=1e-12)
    assert MEASURED.product(0.001) == pytest.approx(380.0, rel=1e-14)
    exact = ab.laws.discoidal()
    re = np.geomspace(10.0, 2e4, 30)
    between = np.sqrt(re[1:] * re[:-1])
    copy = laws.table(re, exact.coefficient(re))
    np.testing.assert_allclose(copy.coefficient(between), exact.coefficient(between), rtol=2e-3)


@pytest.mark.parametrize(
    ("re", "cd", "message"),
    [
        ([1.0, 10.0, 100.0], [300.0, 40.0, 3.9], "falls from 400 at Re = 10 to 390 at 100"),
        ([1.0, 1.0], [300.0, 300.0], "must increase"),
        ([1.0, 10.0], [300.0, -3.0], "positive"),
        ([1.0], [300.0], "two or more"),
        ([1.0, 2.0, 3.0], [300.0, 200.0], "given 3 Reynolds numbers and 2"),
    ],
)
def test_a_table_that_is_no_drag_law_is_refused(re: list[float], cd: list[float], message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        laws.table(re, cd)


def test_a_plateau_that_does_not_fit_is_refused_and_the_ones_that_fit_are_named() -> None:
    with pytest.raises(QuestionError, match=r"plateaus from 0\.0151 to 0\.19"):
        laws.joined(24.0, 0.4)
    for plateau in (0.245, 3.06):  # just inside for 387
        assert (np.diff(laws.joined(387.0, plateau).product(np.geomspace(10.0, 2e4, 3000))) > 0.0).all()


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_beyond_its_range_a_law_keeps_its_coefficient_and_warns_once(law: laws.DragLaw) -> None:
    with pytest.warns(RangeWarning, match="holds up to") as caught:
        far = law.coefficient([2.0 * law.highest, 3.0 * law.highest, 1.0])
    assert [one.filename for one in caught] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert far[:2] == pytest.approx(float(law.coefficient(law.highest)), rel=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_the_compiled_curve_is_the_law(law: laws.DragLaw) -> None:
    curve = DragCurve(law, 760.0, 0.65e-6, 0.0123)
    log_velocity, log_force, slope = curve.points()
    step = np.diff(log_velocity)
    np.testing.assert_allclose(step, step[0], rtol=1e-9)
    rows = FluidRows((), {}, 0)
    rows.add_table(UniformTable(log_velocity[0], step.mean(), log_force, slope))
    fluid = rows.fluid
    re = np.concatenate([np.geomspace(1e-5, 1e6, 4001), [law.stokes_end, law.kept_from, 2e4]])
    velocity = re * 0.65e-6 / 0.0123
    compiled = np.array([drag_force.py_func(fluid, 0, curve.viscous, u) for u in velocity])
    np.testing.assert_allclose(compiled, curve.force(velocity), rtol=1e-5)
    slow = velocity[re < 0.999 * law.stokes_end]
    np.testing.assert_array_equal([drag_force.py_func(fluid, 0, curve.viscous, u) for u in slow], curve.viscous * slow)
    np.testing.assert_allclose(curve.force(slow), curve.viscous * slow, rtol=1e-15)
    assert drag_force.py_func(fluid, 0, curve.viscous, -1.3) == -drag_force.py_func(fluid, 0, curve.viscous, 1.3)


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_force_is_half_rho_a_cd_u_squared_against_the_motion_and_beta_at_rest(law: laws.DragLaw) -> None:
    curve = DragCurve(law, 886.0, 3.1e-5, 0.0123)
    u = np.array([-2.0, -1e-3, 0.4, 3.0])
    area = np.pi * 0.0123**2 / 4.0
    expected = 0.5 * 886.0 * area * law.coefficient(np.abs(u) * 0.0123 / 3.1e-5) * u * np.abs(u)
    np.testing.assert_allclose(curve.force(u), expected, rtol=1e-13)
    beta = linear_drag(law.cd_times_re, 886.0, 3.1e-5, 0.5 * 0.0123, 0.077)
    assert curve.viscous * 0.077**2 == pytest.approx(beta, rel=1e-14)
    assert curve.torque(1e-9, 0.077) == pytest.approx(beta * 1e-9, rel=1e-12)
    assert pickle.loads(pickle.dumps(curve)) == curve


def test_the_record_of_a_run_says_how_far_the_law_was_stretched() -> None:
    curve = DragCurve(ab.laws.discoidal(), 760.0, 0.65e-6, 0.0123)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        inside = curve.range_record(2.0)
    assert inside["drag_warning"] == ""
    assert inside["drag_reynolds"] == pytest.approx(2.0 * 0.0123 / 0.65e-6)
    with pytest.warns(RangeWarning):
        assert "2.84e+05" in curve.range_record(-15.0)["drag_warning"]

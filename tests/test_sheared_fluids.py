"""Fluids whose viscosity depends on the rate of shear: laws, drag on balls, runs, and what is refused."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import MachineError
from autobalancer.laws.drag_coefficient import ShearedDragCurve
from autobalancer.machine import Machine, ShearLaw
from autobalancer.machine import plugins as leaves
from autobalancer.machine.part import ShearRate, key

THIN = {"law": "power_law", "exponent": 0.5, "lowest": 1e-3, "at_ball": 0.5}
SMOOTH = {"law": "carreau", "time": "10 ms", "exponent": 0.5, "at_ball": 0.5}


def machine(shear: dict[str, Any] | ShearLaw | None, fluid: dict[str, Any] | None = None, **more: Any) -> Machine:
    given = fluid or {"density": 900.0, "viscosity": 1e-4}
    race = {
        "orbit_radius": 0.1,
        "drag": more.pop("drag", {"law": "cd_times_re", "cd_times_re": 387.0}),
        "fluid": given | ({} if shear is None else {"shear": shear}),
        "balls": [
            {"count": 2, "diameter": 0.009, "density": 7800.0, "start_angles": [0.0, math.pi], **more.pop("balls", {})}
        ],
    }
    return Machine(
        name="rig",
        axis="vertical",
        rotor={"mass": 10.0, "stiffness": more.pop("stiffness", 625e3), "damping": 100.0},
        unbalances=more.pop("unbalances", [{"mass": 0.004, "radius": 0.1}]),
        balancers=[{"races": [race | more]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 500.0}},
    )


def curve(built: Machine) -> ShearedDragCurve:
    found = resolve(built)[0].drag_curve
    assert isinstance(found, ShearedDragCurve)
    return found


def test_drag_grows_with_the_exponent_of_a_power_law_and_is_linear_below_its_lowest_rate() -> None:
    found = curve(machine(THIN))
    assert found.force(2.0) / found.force(0.5) == pytest.approx(2.0, rel=1e-12)  # 4^0.5
    k_rate = 0.5 * 2.0 / 0.009
    assert found.force(2.0) == pytest.approx(found.viscous * 2.0 * math.sqrt(1e-3 / k_rate), rel=1e-12)
    assert found.force(-1e-5) == pytest.approx(-found.viscous * 1e-5, rel=1e-12)


def test_smooth_laws_have_the_limits_of_their_formulas() -> None:
    carreau = ab.machine.plugins.find(ShearLaw, "carreau")(time=0.1, exponent=0.4, high=0.01)
    rates = np.array([0.0, 1e-3, 1e9])
    assert carreau.share(rates) == pytest.approx([1.0, 1.0, 0.01 + 0.99 * 1e8**-0.6], rel=1e-6)
    half = leaves.find(ShearLaw, "cross")(time=0.1, power=0.8, high=5.0)
    assert half.share(np.array([10.0])) == pytest.approx([3.0], rel=1e-12)  # half of the way from 1 to 5
    wide = leaves.find(ShearLaw, "carreau")(time=0.1, exponent=0.4, width=0.7)
    assert wide.share(np.array([10.0])) == pytest.approx([2.0 ** (-0.6 / 0.7)], rel=1e-12)


def test_balls_slow_down_in_a_thinning_fluid_as_the_closed_form_says() -> None:
    # u' = -c u^n from u0: u^(1-n) = u0^(1-n) - (1-n) c t, so with n = 1/2 a ball stops in a finite time
    thin = THIN | {"lowest": 1.0}
    built = machine(thin, stiffness=1e12, unbalances=[], balls={"start_speeds": [2.0, 2.0]})
    ball = resolve(built)[0]
    found = curve(built)
    inertia = ball.mass * 1.4 + ball.virtual_mass * ball.displaced
    u0, end = 2.0 * 0.1, 0.1
    c = float(found.force(u0)) / inertia / math.sqrt(u0)
    run = ab.simulate(built, duration=end, save=ab.Samples(21))
    expected = (math.sqrt(u0) - 0.5 * c * run["time"].values) ** 2
    assert 0.02 < expected[-1] < 0.6 * u0
    assert run["ball_speed_in_rotor"].isel(ball=0).values * 0.1 == pytest.approx(expected, rel=2e-4)


def test_a_law_that_stays_at_one_is_a_fluid_without_a_law() -> None:
    flat = {"law": "table", "rates": [1.0, 20.0, 400.0], "shares": [1.0, 1.0, 1.0], "at_ball": 0.5}
    same = {"law": "discoidal"}
    velocities = np.geomspace(1e-4, 100.0, 50)
    plain = resolve(machine(None, drag=same))[0].drag_curve
    assert plain is not None
    assert curve(machine(flat, drag=same)).force(velocities) == pytest.approx(plain.force(velocities), rel=1e-12)
    times = {"duration": 0.05, "save": ab.Samples(11)}
    turning = {"balls": {"start_speeds": [20.0, -20.0]}, "drag": same}
    one, other = (ab.simulate(machine(law, **turning), **times) for law in (flat, None))
    assert one["ball_speed_in_rotor"].values == pytest.approx(other["ball_speed_in_rotor"].values, rel=1e-4, abs=1e-4)


def test_thickening_balls_are_released_at_a_lower_speed_by_the_closed_form() -> None:
    # the same torque of the rotor stalls the balls: slip s with beta share(k eps s/d) s = beta s_0
    def release(shear: dict[str, Any] | None) -> float:
        found = ab.stability.borders(machine(shear))
        return next(float(b.speed) for b in found if "release" in b.name)

    linear, critical = release(None), math.sqrt(625e3 / 10.0106)
    thick = {"law": "power_law", "exponent": 1.5, "lowest": 1.0, "at_ball": 0.5}
    slip = linear - critical
    rate = 0.5 * 0.1 * slip / 0.009
    expected = slip * rate ** (-0.5 / 1.5)  # share s / slip = 1 with share = (rate s/slip)^0.5
    assert release(thick) - critical == pytest.approx(
        expected, rel=0.1
    )  # the fold is not exactly at the critical speed
    assert expected < 0.6 * slip


def test_rates_of_shear_follow_the_viscosity_at_another_temperature() -> None:
    cold = {"name": "silicone oil 100", "temperature": "25 degC"}
    hot = {"name": "silicone oil 100", "temperature": "60 degC"}
    law = SMOOTH | {"measured_at": "25 degC"}
    ratio = ab.catalog.fluid("silicone oil 100", 333.15).viscosity / ab.catalog.fluid("silicone oil 100").viscosity
    shift = ratio * 298.15 / 333.15
    assert curve(machine(law, hot)).share(1.0 / shift) == pytest.approx(curve(machine(law, cold)).share(1.0), rel=1e-12)
    assert curve(machine(SMOOTH, hot)).share(1.0) == pytest.approx(curve(machine(SMOOTH, cold)).share(1.0), rel=1e-12)


class Slimy(ShearLaw):
    """A law from outside."""

    law: Literal["slimy"] = "slimy"
    interface: ClassVar[int] = 1
    half: ShearRate = key("rate at which half remains")
    slope: float = key("power", 0.8)

    def share(self, rate: Any) -> Any:
        return 1.0 / (1.0 + (rate / self.half) ** self.slope)


def test_a_law_of_ones_own_is_the_same_as_the_one_from_within() -> None:
    ab.laws.register(Slimy)
    own = curve(machine({"law": "slimy", "half": "50 1/s", "at_ball": 0.5}))
    built_in = curve(machine({"law": "cross", "time": "20 ms", "power": 0.8, "high": 0.0, "at_ball": 0.5}))
    assert own.force(np.geomspace(1e-3, 10, 20)) == pytest.approx(built_in.force(np.geomspace(1e-3, 10, 20)), rel=1e-12)
    with pytest.raises(MachineError, match="'slimy': the stress falls while the rate of shear grows"):
        resolve(machine({"law": "slimy", "half": "50 1/s", "slope": 1.4, "at_ball": 0.5}))


@pytest.mark.parametrize(
    ("shear", "message"),
    [
        (SMOOTH | {"exponent": 0}, "exponent: given 0; must be greater than zero"),
        (SMOOTH | {"exponent": -0.5}, "exponent: given -0.5; must be greater than zero"),
        (SMOOTH | {"exponent": 1.5, "high": 0.1}, "high: a fluid that thickens"),
        (
            {"law": "power_law", "exponent": 0.5, "at_ball": 0.5},
            "lowest: missing; .* viscosity at rest would be infinite",
        ),
        ({"law": "power_law", "exponent": 1.5, "at_ball": 0.5}, "lowest: missing; .* viscosity at rest would be zero"),
        (THIN | {"exponent": 1.0}, "exponent: given 1, which is a fluid of constant viscosity"),
        (THIN | {"highest_rate": 1e-4}, "highest_rate: given 0.0001 1/s; must be more than 'lowest'"),
        (
            {"law": "table", "rates": [1, 10, 1000], "shares": [1, 0.5, 0.1], "at_ball": 1},
            "rates: given 1000 1/s after 10 1/s",
        ),
        (
            {"law": "table", "rates": [1, 10, 5], "shares": [1, 0.5, 0.1], "at_ball": 1},
            "5 1/s after 10 1/s; must increase",
        ),
        ({"law": "table", "rates": [1, 10], "shares": [0.9, 0.5], "at_ball": 1}, "the first is 0.9; must be 1"),
        ({"law": "table", "rates": [1, 10], "shares": [1], "at_ball": 1}, "given an empty|at least|shares"),
        ({"law": "cross", "time": 1, "power": 1.5, "high": 0, "at_ball": 1}, "the stress falls"),
        ({"law": "carreau", "time": 1, "exponent": 0.5}, "fluid.shear.at_ball: missing; .* plot_sheared_drag"),
        (SMOOTH | {"measured_at": "25 degC"}, "measured_at: has no effect"),
    ],
)
def test_what_is_no_viscosity_is_named(shear: dict[str, Any], message: str) -> None:
    with pytest.raises(MachineError, match=message):
        resolve(machine(shear))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"drag": {"law": "viscous", "damping": 1e-4}}, "gives the torque without the viscosity"),
        ({"slipstream": True}, "slipstream: known for fluids of constant viscosity only"),
        ({"contact": {"rebound": {"critical_stokes": 10.0}, "restitution": 0.9}}, "constant viscosity"),
    ],
)
def test_what_needs_a_constant_viscosity_is_refused(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(MachineError, match=message):
        machine(SMOOTH, **changed)


def test_a_run_beyond_the_rates_of_a_table_says_so() -> None:
    short = {"law": "table", "rates": [1.0, 10.0], "shares": [1.0, 0.5], "at_ball": 0.5}
    turning = machine(short, drag={"law": "discoidal"}, balls={"start_speeds": [20.0, 20.0]})
    with pytest.warns(ab.errors.RangeWarning, match=r"reaches \d+ 1/s, but the viscosity is known up to 10"):
        run = ab.simulate(turning, duration=0.001, save=ab.Samples(3))
    assert run.attrs["drag_shear_rate"] == pytest.approx(0.5 * 2.0 / 0.009, rel=0.05)

"""Drag laws in a machine: default linear, whole on request, following size, fluid and temperature."""

from __future__ import annotations

import cmath
import math
import warnings
from pathlib import Path
from typing import Any

import pytest

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.catalog.resolve import occupied_angle, resolve
from autobalancer.errors import MachineError, RangeWarning
from autobalancer.laws import drag_coefficient as laws
from autobalancer.machine import Machine

OIL = {"name": "silicone oil 20", "temperature": "25 degC"}


def machine(drag: dict[str, Any], fluid: dict[str, Any] | None = None) -> Machine:
    race = {"orbit_radius": 0.07695, "drag": drag, "balls": [{"count": 2, "diameter": 0.0123, "density": 7800.0}]}
    return Machine(
        name="rig",
        axis="vertical",
        rotor={"mass": 12.27, "stiffness": 44654.0, "damping": 68.37},
        balancers=[{"races": [race | {"fluid": fluid or OIL}]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 120.0}},
    )


@pytest.mark.parametrize(
    ("drag", "cd_times_re"),
    [
        ({"law": "sphere_on_plane"}, 322.0),
        ({"law": "race_geometry", "clear_width": 0.009225}, 386.949),
        ({"law": "cd_times_re", "cd_times_re": 387.0}, 387.0),
        ({"law": "discoidal", "range": "linear"}, 387.0),
        ({"law": "free_sphere", "range": "linear"}, 24.0),
    ],
)
def test_a_linear_law_has_beta_and_no_curve(drag: dict[str, Any], cd_times_re: float) -> None:
    ball = resolve(machine(drag))[0]
    oil = ab.catalog.fluid("silicone oil 20", 298.15)
    beta = cd_times_re * 0.7853981633974483 * oil.density * oil.viscosity * 0.00615 * 0.07695**2
    assert ball.drag_curve is None
    assert ball.drag == pytest.approx(beta, rel=1e-4)


@pytest.mark.parametrize(
    ("drag", "law"),
    [
        ({"law": "sphere_on_plane", "range": "whole"}, ab.laws.sphere_on_plane()),
        ({"law": "discoidal"}, ab.laws.discoidal(0.60)),
        ({"law": "discoidal", "plateau": 0.74}, ab.laws.discoidal(0.74)),
        ({"law": "free_sphere"}, ab.laws.free_sphere()),
        ({"law": "cd_times_re", "cd_times_re": 300.0, "range": "whole", "plateau": 0.5}, laws.joined(300.0, 0.5)),
        ({"law": "table", "reynolds": [1, 100], "coefficient": [300, 9]}, laws.table([1, 100], [300, 9])),
    ],
)
def test_a_whole_law_starts_with_the_beta_of_the_linear_one(drag: dict[str, Any], law: laws.DragLaw) -> None:
    ball = resolve(machine(drag))[1]
    assert ball.drag_curve is not None
    assert ball.drag_curve.law == law
    assert ball.drag_curve.viscous * ball.orbit_radius**2 == pytest.approx(ball.drag, rel=1e-14)
    assert ball.drag_curve.torque(1e-6, ball.orbit_radius) == pytest.approx(1e-6 * ball.drag, rel=1e-12)
    assert ball.drag_curve.torque(500.0, ball.orbit_radius) > 500.0 * ball.drag


def test_the_race_geometry_over_the_whole_range_takes_the_plateau_of_the_plane_unless_told() -> None:
    part = {"law": "race_geometry", "clear_width": 0.0129, "range": "whole"}
    for given, plateau in (({}, 0.74), ({"plateau": 0.6}, 0.6)):
        curve = resolve(machine(part | given))[0].drag_curve
        assert curve is not None
        assert float(curve.law.coefficient(1e5)) == pytest.approx(plateau, rel=1e-12)


def test_warm_oil_drags_less_slowly_and_hardly_less_fast() -> None:
    cold = resolve(machine({"law": "discoidal"}))[0]
    warm = resolve(machine({"law": "discoidal"}, OIL | {"temperature": "60 degC"}))[0]
    at = [ab.catalog.fluid("silicone oil 20", kelvin) for kelvin in (298.15, 333.15)]
    assert (warm.fluid_density, warm.fluid_viscosity) == (at[1].density, at[1].viscosity)
    ratio = at[1].density * at[1].viscosity / (at[0].density * at[0].viscosity)
    assert ratio < 0.65
    assert warm.drag / cold.drag == pytest.approx(ratio, rel=1e-13)
    assert cold.drag_curve is not None
    assert warm.drag_curve is not None
    fast = 2e5 * cold.fluid_viscosity / 0.0123
    force = float(warm.drag_curve.force(fast) / cold.drag_curve.force(fast))
    assert force == pytest.approx(at[1].density / at[0].density, rel=1e-12)
    assert warm.effective_mass > cold.effective_mass  # lighter oil, less buoyancy


@pytest.mark.parametrize(
    ("drag", "message"),
    [
        (
            {"law": "cd_times_re", "cd_times_re": 300.0, "range": "whole"},
            "give the drag coefficient at high Reynolds numbers",
        ),
        ({"law": "cd_times_re", "cd_times_re": 300.0, "plateau": 0.6}, "no effect on a linear law"),
        ({"law": "race_geometry", "clear_width": 0.01, "plateau": 0.6}, "no effect on a linear law"),
        ({"law": "sphere_on_plane", "range": "all"}, "'linear' or 'whole'"),
        ({"law": "stokes"}, "given 'stokes'; must be one of .*'discoidal', 'free_sphere', "),
    ],
)
def test_a_law_that_makes_no_sense_is_refused(drag: dict[str, Any], message: str) -> None:
    with pytest.raises(MachineError, match=message):
        machine(drag)


@pytest.mark.parametrize(
    ("drag", "message"),
    [
        ({"law": "discoidal", "plateau": 30.0}, r"races\[1\]\.drag: given a plateau of 30"),
        ({"law": "table", "reynolds": [1, 10], "coefficient": [300, 20]}, r"races\[1\]\.drag: .*falls from 300"),
    ],
)
def test_numbers_that_make_no_curve_are_refused_with_their_place(drag: dict[str, Any], message: str) -> None:
    with pytest.raises(MachineError, match=message):
        resolve(machine(drag))


def test_a_linear_law_far_beyond_its_range_is_told_and_a_given_beta_is_not() -> None:
    thin = ab.load_machine("docs/machines/thin_oil.toml")
    with pytest.warns(RangeWarning, match="drag is linear up to about 10") as caught:
        run = ab.simulate(thin, duration=2.0)
    assert [one.filename for one in caught] == [__file__]  # the line that asked, not one of the package
    ball = resolve(thin)[0]
    slip = float(abs(run["ball_speed_in_rotor"]).max()) * ball.orbit_radius
    assert run.attrs["drag_reynolds"] >= slip * ball.diameter / ball.fluid_viscosity * (1.0 - 1e-12)
    assert run.attrs["drag_reynolds_limit"] == 10.0
    assert "drag_reynolds" not in ab.simulate("examples/machines/stall_and_release.toml", duration=0.1).attrs


def test_balls_of_any_sizes_that_touch_are_the_sum_of_their_radii_apart() -> None:
    sizes = [{"count": 1, "diameter": d, "density": 7800.0} for d in ("10 mm", "6 mm")]
    race = {"race_radius": 0.08, "drag": {"law": "viscous", "damping": 1e-4}, "balls": sizes}
    machine = with_value_at(
        ab.load_machine("examples/machines/stall_and_release.toml"), "balancers", [{"races": [race]}]
    )
    one, other = resolve(machine)
    angle = 0.5 * occupied_angle([one, other])
    apart = abs(one.orbit_radius - other.orbit_radius * cmath.exp(1j * angle))
    assert one.orbit_radius != other.orbit_radius
    assert apart == pytest.approx(one.radius + other.radius, rel=1e-12)


def test_the_quick_start_says_rightly_what_the_whole_drag_law_of_its_disc_changes() -> None:
    linear = ab.load_machine(Path("examples/machines/discoidal.toml"))
    whole = ab.with_parameter(linear, "balancers[1].races[1].drag", {"law": "discoidal"})
    release, peak = [], []
    for machine in (whole, linear):
        borders = {border.name: border.speed for border in ab.stability.borders(machine)}
        release.append(round(borders["release speed"] * 30.0 / math.pi))
        with warnings.catch_warnings():
            warnings.simplefilter("error" if machine is whole else "ignore", RangeWarning)
            run = ab.simulate(machine, save=ab.Envelope())
        peak.append(f"{1e3 * float(ab.run_measures(run, 'peak_deflection')['deflection']):.2f}")
    text = Path("docs/quickstart.md").read_text(encoding="utf-8")
    assert f"released at {release[0]} in place of\n{release[1]} rpm" in text
    assert f"{peak[0]} in place of {peak[1]} mm" in text

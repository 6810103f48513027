"""Fluid that lags behind its chamber, in time integration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from autobalancer.api import simulate
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import MachineError
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.relaxation import relaxation_modes
from autobalancer.machine import Machine
from autobalancer.simulation import fluid_lag
from autobalancer.simulation.fluid_lag import prepare
from autobalancer.simulation.record import Envelope, Event, Samples, SampleTimes, Sampling
from autobalancer.studies.basin import basin

RATE, END = 20.0, 0.5  # rad/s^2, s; slow enough for the secondary flow to carry less than a percent of the lag


def ramp(lag: str, **changes: Any) -> Machine:
    """One ball so strongly dragged that it goes with the fluid, on a rotor too heavy to be moved by it."""
    race = {
        "orbit_radius": "76.95 mm",
        "width": "13.8 mm",
        "height": "20 mm",
        "fluid": {"density": 900.0, "viscosity": "1000 mm^2/s", "lag": lag},
        "drag": {"law": "viscous", "damping": 1.0},
        "balls": [{"diameter": "12.3 mm", "density": 7800.0, "start_angles": [0.3]}],
    }
    data: dict[str, Any] = {
        "name": "ramp",
        "axis": "vertical",
        "rotor": {"mass": 1e4, "stiffness": 1e9, "damping": 1e5, "inertia": 1e3},
        "balancers": [{"races": [race]}],
        "drive": {"kind": "speed", "profile": {"kind": "ramp", "end": RATE, "duration": 1.0}},
    }
    return Machine(**(data | changes))


@pytest.mark.parametrize("lag", ["modes", "auto", "full"])
def test_a_strongly_dragged_ball_falls_behind_in_a_long_ramp_by_what_its_fluid_does(lag: str) -> None:
    machine = ramp(lag)
    speed = float(simulate(machine, duration=END, save=Samples(20))["ball_speed_in_rotor"][-1, 0])
    modes = relaxation_modes(annulus_of(machine))
    assert speed == pytest.approx(-modes.ramp_lag * RATE, rel=5e-3)


def test_secondary_flow_carries_a_thinner_fluid_along_sooner_than_diffusion_does() -> None:
    """At 38 rad/s in 100 mm^2/s oil; the modes know nothing of it."""
    fast = {"kind": "speed", "profile": {"kind": "ramp", "end": 40.0, "duration": 20.0}}
    speeds = []
    for lag in ("modes", "auto"):
        machine = with_value_at(ramp(lag, drive=fast), "balancers[1].races[1].fluid.viscosity", "100 mm^2/s")
        speeds.append(float(simulate(machine, duration=19.0, save=Samples(20))["ball_speed_in_rotor"][-1, 0]))
    assert speeds[0] < 1.5 * speeds[1] < 0.0


def test_without_lag_the_same_ball_stays_behind_by_its_own_inertia_only() -> None:
    still, lagging = (
        float(simulate(ramp(lag), duration=END, save=Samples(20), tolerance=1e-12)["ball_speed_in_rotor"][-1, 0])
        for lag in ("none", "modes")
    )
    radius, orbit, volume = 6.15e-3, 76.95e-3, np.pi / 6.0 * 12.3e-3**3
    coupling = (7800.0 - 900.0) * volume * orbit**2 - 0.4 * 7800.0 * volume * radius * orbit
    assert still == pytest.approx(-coupling * RATE / 1.0, rel=1e-6)
    ramp_lag = relaxation_modes(annulus_of(ramp("modes"))).ramp_lag
    assert lagging - still == pytest.approx(-ramp_lag * RATE, rel=1e-6)


@pytest.mark.parametrize("resolved", [False, True])
@pytest.mark.parametrize("lag", ["modes", "full"])
@pytest.mark.parametrize("save", [SampleTimes([END]), Envelope(1)], ids=["samples", "envelope"])
def test_the_recorded_reynolds_number_is_that_of_the_flow_past_the_ball(
    save: Sampling, lag: str, resolved: bool
) -> None:
    place = "balancers[1].races[1]"
    machine = with_value_at(ramp(lag), f"{place}.drag", {"law": "sphere_on_plane", "range": "whole"})
    if resolved:
        contact = {"stiffness": 1e5, "restitution": 0.3, "sliding_friction": 0.5, "slip_speed": 0.01}
        machine = with_value_at(machine, f"{place}.resolved", contact)
    run = simulate(machine, duration=END, save=save)
    name = "ball_speed_in_rotor" if isinstance(save, SampleTimes) else "envelope_ball_speed_in_rotor"
    behind, fluid = float(run[name][-1, 0]), -RATE * relaxation_modes(annulus_of(machine)).ramp_lag
    per_rate = 76.95e-3 * 12.3e-3 / 1e-3
    assert run.attrs["drag_reynolds"] == pytest.approx(
        abs(behind - fluid) * per_rate, rel=1e-4 if lag == "modes" else 5e-3
    )
    assert abs(fluid) > 0.1 * abs(behind - fluid)


def test_modes_step_along_with_a_speed_that_a_torque_drives() -> None:
    torque = {"kind": "torque", "torque": 1e3 * RATE}
    run = simulate(ramp("modes", drive=torque), duration=END, save=Samples(20))
    pushed = float(simulate(ramp("modes"), duration=END, save=Samples(20))["ball_speed_in_rotor"][-1, 0])
    np.testing.assert_allclose(run["speed"].values[-1], END * RATE, rtol=1e-5)
    assert float(run["ball_speed_in_rotor"][-1, 0]) == pytest.approx(pushed, rel=1e-4)


@pytest.mark.parametrize("viscosity", ["1000 mm^2/s", "100 mm^2/s"])
def test_a_torque_that_makes_a_prescribed_ramp_gives_the_lag_of_that_ramp(viscosity: str) -> None:
    ends = []
    for drive in ({"kind": "torque", "torque": 1e3 * RATE}, ramp("full").drive.model_dump()):
        machine = with_value_at(ramp("full", drive=drive), "balancers[1].races[1].fluid.viscosity", viscosity)
        ends.append(simulate(machine, duration=END, save=Samples(20)))
    np.testing.assert_allclose(ends[0]["speed"].values, ends[1]["speed"].values, atol=1e-4)
    np.testing.assert_allclose(
        ends[0]["ball_speed_in_rotor"].values, ends[1]["ball_speed_in_rotor"].values, atol=1e-3 * END * RATE
    )
    assert ends[0].attrs["flow_converged"] == 1
    assert ends[0].attrs["flow_passes"] == 1  # so heavy a rotor does not notice its balls
    assert "flow_passes" not in ends[1].attrs


def test_full_equations_of_a_thick_oil_give_what_the_modes_give_whatever_drives() -> None:
    light = {"mass": 1e4, "stiffness": 1e9, "damping": 1e5, "inertia": 1e-4}
    torque = {"kind": "torque", "torque": 1.4e-4 * RATE}
    full, modes = (
        simulate(ramp(lag, rotor=light, drive=torque), duration=END, save=Samples(20)) for lag in ("full", "modes")
    )
    np.testing.assert_allclose(full["speed"].values, modes["speed"].values, atol=2e-3 * END * RATE)
    np.testing.assert_allclose(
        full["ball_speed_in_rotor"].values, modes["ball_speed_in_rotor"].values, atol=2e-3 * END * RATE
    )


def test_the_lag_of_a_light_rotor_belongs_to_the_speed_that_its_balls_leave_it() -> None:
    """Balls of a third of the inertia; the run is repeated as one with a prescribed speed, that of its result."""
    light = {"mass": 1e4, "stiffness": 1e9, "damping": 1e5, "inertia": 1e-4}
    torque = {"kind": "torque", "torque": 1.4e-4 * 4.0 * RATE}
    machine = with_value_at(
        ramp("auto", rotor=light, drive=torque), "balancers[1].races[1].fluid.viscosity", "100 mm^2/s"
    )
    run = simulate(machine, duration=END, save=Samples(200))
    assert run.attrs["flow_model"] == "chebyshev"
    assert 2 <= run.attrs["flow_passes"] <= 5
    assert run.attrs["flow_change"] <= run.attrs["flow_tolerance"]
    table = {"kind": "table", "time": run["time"].values.tolist(), "speed": run["speed"].values.tolist()}
    again = with_value_at(machine, "drive", {"kind": "speed", "profile": table})
    fast = float(run["speed"][-1])
    other = simulate(again, duration=END, save=Samples(200))
    np.testing.assert_allclose(other["ball_speed_in_rotor"].values, run["ball_speed_in_rotor"].values, atol=3e-3 * fast)


def test_passes_that_do_not_agree_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fluid_lag, "SAME_SPEED", -1.0)
    monkeypatch.setattr(fluid_lag, "MOST_PASSES", 2)
    run = simulate(ramp("full", drive={"kind": "torque", "torque": 1e3 * RATE}), duration=0.1, save=Samples(5))
    assert run.attrs["flow_converged"] == 0
    assert run.attrs["flow_passes"] == 2
    assert "did not agree after 2 passes" in " ".join(run.attrs["remarks"])


def test_a_stop_does_not_change_the_motion_before_it() -> None:
    """The flow is solved for the whole duration, wherever the run ends."""
    machine = ramp("full", drive={"kind": "torque", "torque": 1e3 * RATE})
    whole = simulate(machine, duration=END, save=Samples(21))
    stopped = simulate(
        machine, duration=END, save=Samples(21), events=[Event("speed", 0.5 * END * RATE, ends_run=True)]
    )
    assert stopped.attrs["outcome"] == "event"
    count = int(np.isfinite(stopped["ball_speed_in_rotor"].values[:, 0]).sum())
    assert 9 <= count <= 12
    np.testing.assert_allclose(
        stopped["ball_speed_in_rotor"].values[: count - 1], whole["ball_speed_in_rotor"].values[: count - 1], atol=1e-7
    )


def test_a_flow_that_cannot_be_solved_beforehand_is_refused_with_the_key_and_a_cure() -> None:
    with pytest.raises(MachineError, match=r"balancers\[1\]\.races\[1\]\.fluid\.lag: given 'full'.*'auto' or 'modes'"):
        prepare(ramp("full"), None)


def test_basins_take_fluid_along_that_a_run_up_left_behind_and_at_constant_speed_none_is() -> None:
    """After a jump of the speed w the ball has turned back by w times the lag of a ramp over its rate, plus less than a turn."""
    soft = {"mass": 10.0, "stiffness": 4e4, "damping": 100.0, "inertia": 0.1}
    held, ramped = [], []
    for lag in ("none", "full"):
        machine = ramp(lag, rotor=soft, unbalances=[{"mass": "5 g", "radius": "100 mm"}])
        machine = with_value_at(machine, "balancers[1].races[1].drag.damping", 1e-3)
        machine = with_value_at(machine, "balancers[1].races[1].fluid.viscosity", "20 mm^2/s")
        held.append(basin(machine, 30.0, {"ball_angle[1]": [0.3, 2.0]}))
        ramped.append(float(basin(machine, 30.0, {"acceleration": [3000.0]})["final_ball_angle_in_rotor"][0, 0]))
        assert held[-1].attrs.get("flow_model", "none") == ("none" if lag == "none" else "modes")
    assert np.array_equal(held[0]["state"], held[1]["state"])
    np.testing.assert_allclose(held[0]["time"], held[1]["time"], rtol=0.02)
    lost = 30.0 * relaxation_modes(annulus_of(machine)).ramp_lag
    assert abs(ramped[0]) < np.pi
    assert ramped[1] == pytest.approx(-lost, abs=2.0 * np.pi)


def test_a_fluid_that_lags_needs_the_size_of_its_chamber() -> None:
    machine = with_value_at(ramp("modes"), "balancers[1].races[1].width", None)
    with pytest.raises(MachineError, match=r"width: missing; the flow in the race needs it"):
        simulate(machine, duration=1.0)

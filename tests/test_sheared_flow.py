"""Flow in an annulus of a fluid whose viscosity depends on the rate of shear: closed forms, limits, balances, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import MachineError, QuestionError, RangeWarning
from autobalancer.flow.annulus import Annulus, Walls
from autobalancer.flow.annulus_problem import ShearFlow
from autobalancer.flow.relaxation import wall_speed
from autobalancer.laws.drag_coefficient import Sheared
from autobalancer.machine import Machine, Ramp, ShearLaw
from autobalancer.machine import plugins as leaves


def power(exponent: float, lowest: float = 1e-6) -> Sheared:
    return Sheared(leaves.find(ShearLaw, "power_law")(exponent=exponent, lowest=lowest))


def annulus(sheared: Sheared | None = None, **changed: float) -> Annulus:
    numbers = {
        "inner": 0.07,
        "outer": 0.085,
        "height": 0.02,
        "orbit_radius": 0.077,
        "viscosity": 1e-4,
        "density": 900.0,
    }
    return Annulus(**(numbers | changed), sheared=sheared)


@pytest.mark.parametrize("n", [0.3, 0.5, 0.8, 1.5, 2.5])
def test_between_turning_cylinders_a_power_law_fluid_flows_as_the_closed_form_with_error_of_second_order(
    n: float,
) -> None:
    # r^2 tau is constant and tau = K (r |W'|)^n, so W' ~ r^(-1 - 2/n)
    errors = []
    for count in (12, 24, 48):
        flow = ShearFlow(annulus(power(n), inner=0.05, outer=0.1), count, 4, Walls(inner=10.0))
        r, k = flow.radius, -2.0 / n
        expected = 10.0 * (r**k - 0.1**k) / (0.05**k - 0.1**k)
        errors.append(np.abs(flow.steady()[:, -1] - expected).max() / 10.0)
    assert errors[-1] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("n", [0.5, 1.6])
def test_behind_a_ramp_the_lag_in_a_narrow_gap_is_the_profile_of_a_slit(n: float) -> None:
    # the inertia of the ramp is a constant force along a slit: lag n/(n+1) (rho r w'/K)^(1/n) (W/2)^((n+1)/n) in the middle
    law, rate, gap = power(n, lowest=1e-4), 0.2, 0.01
    wide = annulus(law, inner=1.0 - 0.5 * gap, outer=1.0 + 0.5 * gap, orbit_radius=1.0, viscosity=1e-2)
    flow = ShearFlow(wide, 32, 4, Walls())
    swirl, _ = flow.march(wall_speed(Ramp(start=0.0, end=20.0, duration=100.0)), 50.0, np.array([50.0]), 1e-5)
    consistency = 1e-2 * 1e-4 ** (1.0 - n)
    lag = n / (n + 1.0) * (rate / consistency) ** (1.0 / n) * (0.5 * gap) ** ((n + 1.0) / n)
    assert -flow.at_orbit(swirl)[0] == pytest.approx(lag, rel=0.005)  # curvature of the gap and the mesh


def test_with_constant_viscosity_it_is_diffusion_with_error_of_second_order() -> None:
    plain, asked = annulus(), {"initial_speed": 0.0, "duration": 0.5, "samples": 26}
    modes = ab.flow.annulus_flow(plain, 60.0, model="modes", **asked)["fluid_speed"].values
    errors = []
    for points in ((12, 8), (24, 16), (48, 32)):
        with pytest.warns(RangeWarning, match="leaves out the secondary flow"):
            found = ab.flow.annulus_flow(plain, 60.0, model="azimuthal", points=points, error=1e-4, **asked)
        errors.append(np.abs(found["fluid_speed"].values - modes)[1:].max() / 60.0)
    assert errors[-1] < 1.2e-3
    assert errors[1] < 0.35 * errors[0]
    assert errors[2] < 0.35 * errors[1]


def test_the_torque_of_the_walls_is_what_the_fluid_gains() -> None:
    times = np.linspace(0.02, 0.3, 141)
    with pytest.warns(RangeWarning):
        found = ab.flow.annulus_flow(
            annulus(power(0.6, 1.0)), 60.0, initial_speed=0.0, duration=0.3, times=times.tolist(), error=1e-4
        )
    gained = found["angular_momentum"].values - float(found["angular_momentum"][0])
    torque = found["wall_torque"].values
    work = np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1]) * np.diff(times))])
    assert gained == pytest.approx(work, abs=2e-3 * gained[-1])
    assert found.attrs["model"] == "azimuthal"


def test_a_fluid_that_thins_lags_longer_and_one_that_thickens_less() -> None:
    def lag(sheared: Sheared | None) -> float:
        thick = annulus(sheared, viscosity=1e-3)
        found = ab.flow.annulus_flow(thick, Ramp(start=0.0, end=20.0, duration=2.0), duration=2.0, model="azimuthal")
        return float(found["speed"][-1] - found["fluid_speed"][-1])

    assert lag(power(0.5, 1.0)) > 1.2 * lag(None) > 1.2 * 1.2 * lag(power(1.5, 1.0))


def machine(**fluid: Any) -> Machine:
    law = {"law": "carreau", "time": "1 ms", "exponent": 0.5, "at_ball": 0.5}
    race = {
        "orbit_radius": 0.077,
        "width": 0.015,
        "height": 0.02,
        "drag": {"law": "cd_times_re", "cd_times_re": 387.0},
        "fluid": {"density": 900.0, "viscosity": 1e-3, "shear": law} | fluid,
        "balls": [{"count": 2, "diameter": 0.012, "density": 7800.0, "start_angles": [0.0, 3.0]}],
    }
    return Machine(
        name="rig",
        axis="vertical",
        rotor={"mass": 12.0, "stiffness": 44654.0, "damping": 68.0},
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "ramp", "start": 0.0, "end": 20.0, "duration": 0.5}},
    )


def test_balls_of_a_run_follow_a_sheared_fluid_that_lags() -> None:
    built = machine(lag="auto")
    run = ab.simulate(built, duration=0.5, save=ab.Samples(11))
    assert run.attrs["flow_model"] == "azimuthal"
    flow = ab.flow.annulus_flow(built, duration=0.5)
    lag = float(flow["speed"][-1] - flow["fluid_speed"][-1])
    still = ab.simulate(machine(), duration=0.5, save=ab.Samples(11))
    behind = float(still["ball_speed_in_rotor"][-1, 0] - run["ball_speed_in_rotor"][-1, 0])
    assert behind == pytest.approx(
        lag, rel=0.05
    )  # balls of strong drag go with their fluid, and reach it after a few 10 ms
    assert lag > 0.2


@pytest.mark.parametrize("lag", ["modes", "full"])
def test_lags_of_constant_viscosity_are_refused(lag: str) -> None:
    with pytest.raises(MachineError, match=f"lag: given '{lag}', which is for constant viscosity"):
        machine(lag=lag)


@pytest.mark.parametrize("model", ["modes", "chebyshev"])
def test_models_of_constant_viscosity_are_refused(model: Any) -> None:
    with pytest.raises(QuestionError, match=f"model: given '{model}', which is for constant viscosity"):
        ab.flow.annulus_flow(machine(), duration=0.1, model=model)


def test_a_result_with_a_shear_law_is_written_and_read(tmp_path: Any) -> None:
    found = ab.flow.annulus_flow(machine(), duration=0.1)
    ab.save_run(found, tmp_path / "flow.nc")
    assert ab.load_run(tmp_path / "flow.nc").attrs["model"] == "azimuthal"
    assert ab.plot.answer(found).axes


def test_analyses_with_speeds_of_their_own_refuse_a_sheared_lag() -> None:
    with pytest.raises(MachineError, match="lags by no fixed modes"):
        ab.stepped_response(machine(lag="auto"), [10.0], dwell=0.1, window=0.05)

"""Fluid that lags behind its chamber, in time integration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from autobalancer import simulate
from autobalancer.assembly.parameters import with_parameter
from autobalancer.errors import MachineError
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.relaxation import relaxation_modes
from autobalancer.machine import Machine
from autobalancer.simulation.sampling import Samples

RATE, END = 20.0, 0.5  # rad/s^2, s; slow enough for the secondary flow to carry less than a percent of the lag


def ramp(lag: str, **changes: Any) -> Machine:
    """One ball so strongly dragged that it goes with the fluid, on a rotor too heavy to be moved by it."""
    race = {
        "orbit_radius": "76.95 mm",
        "width": "13.8 mm",
        "height": "20 mm",
        "fluid": {"density": 900.0, "viscosity": "1000 mm^2/s", "lag": lag},
        "drag": {"law": "beta", "beta": 1.0},
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
        machine = with_parameter(ramp(lag, drive=fast), "balancers[1].races[1].fluid.viscosity", "100 mm^2/s")
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


def test_modes_step_along_with_a_speed_that_a_torque_drives() -> None:
    torque = {"kind": "torque", "torque": 1e3 * RATE}
    run = simulate(ramp("modes", drive=torque), duration=END, save=Samples(20))
    pushed = float(simulate(ramp("modes"), duration=END, save=Samples(20))["ball_speed_in_rotor"][-1, 0])
    np.testing.assert_allclose(run["speed"].values[-1], END * RATE, rtol=1e-5)
    assert float(run["ball_speed_in_rotor"][-1, 0]) == pytest.approx(pushed, rel=1e-4)


def test_a_flow_that_cannot_be_solved_beforehand_is_refused_with_the_key_and_a_cure() -> None:
    with pytest.raises(MachineError, match=r"balancers\[1\]\.races\[1\]\.fluid\.lag: given 'full'.*take 'modes'"):
        simulate(ramp("full", drive={"kind": "torque", "torque": 1.0}), duration=1.0)


def test_a_fluid_that_lags_needs_the_size_of_its_chamber() -> None:
    machine = with_parameter(ramp("modes"), "balancers[1].races[1].width", None)
    with pytest.raises(MachineError, match=r"width: missing; the flow in the race needs it"):
        simulate(machine, duration=1.0)

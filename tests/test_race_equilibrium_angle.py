"""One ball in a slowly turned horizontal race: statics against simulation, and what the angles say of drag and friction."""

from __future__ import annotations

import math

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.drag.discoidal import discoidal
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.equilibrium_angles import (
    TurnedRace,
    drag_coefficients,
    equilibrium_angles,
    fit_rolling_resistance,
)
from autobalancer.simulation.record import Samples

DIAMETER, ORBIT, STEEL = 0.0123, 0.07695, 7800.0
FLUIDS = [(953.0, 298e-6), (950.0, 50e-6), (876.0, 10e-6), (844.0, 5e-6), (760.0, 0.65e-6)]


def race(density: float, viscosity: float, pressure: float = 0.0) -> TurnedRace:
    return TurnedRace(DIAMETER, STEEL * math.pi / 6.0 * DIAMETER**3, ORBIT, density, viscosity, pressure)


def measured(one: TurnedRace, rolling: float, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and angles up to 85 degrees."""
    speeds = np.geomspace(0.02, 300.0, 4000)
    angles = equilibrium_angles(one, discoidal(0.6), speeds, rolling)
    use = np.flatnonzero((angles > math.atan(rolling) + 0.01) & (angles < 1.48))
    pick = use[np.linspace(0, use.size - 1, count).astype(int)]
    return speeds[pick], angles[pick]


@pytest.mark.parametrize("rolling", [0.0, 0.05])
@pytest.mark.parametrize(("density", "viscosity"), [FLUIDS[1], FLUIDS[3]])
def test_a_simulated_ball_stands_where_the_statics_say(rolling: float, density: float, viscosity: float) -> None:
    one = race(density, viscosity)
    speeds = measured(one, rolling)[0]
    top, duration = float(speeds[-1]), 300.0
    ball = {"diameter": DIAMETER, "density": STEEL, "start_angles": [-0.5 * math.pi + math.atan(rolling)]}
    friction = {"rolling_resistance": rolling}
    machine = Machine(
        name="turned",
        axis="horizontal",
        rotor={"mass": 1e6, "stiffness": 1e11, "damping": 3e8},
        balancers=[
            {
                "races": [
                    {
                        "orbit_radius": ORBIT,
                        "drag": {"law": "discoidal"},
                        "fluid": {"density": density, "viscosity": viscosity},
                        "friction": friction,
                        "balls": [ball],
                    }
                ]
            }
        ],
        drive={"kind": "speed", "profile": {"kind": "ramp", "start": 0.2 * top, "end": top, "duration": duration}},
    )
    run = ab.simulate(machine, duration=duration, save=Samples(241))
    found = (run["rotor_angle"] + run["ball_angle_in_rotor"][:, 0]).values + 0.5 * math.pi
    expected = equilibrium_angles(one, discoidal(0.6), run["speed"].values, rolling)
    settled = (run["time"].values > 60.0) & (expected < 1.1)  # near 90 degrees the ball follows slowly
    np.testing.assert_allclose(found[settled], expected[settled], rtol=0.0, atol=3e-3)
    assert expected[settled].max() > 1.0


@pytest.mark.parametrize("pressure", [0.0, 1.0, 3.0])
def test_the_angles_give_back_the_drag_coefficient_they_come_from(pressure: float) -> None:
    for density, viscosity in FLUIDS:
        one = race(density, viscosity, pressure)
        speeds, angles = measured(one, 0.05)
        np.testing.assert_allclose(
            drag_coefficients(one, speeds, angles, 0.05), discoidal(0.6).coefficient(one.reynolds(speeds)), rtol=1e-9
        )


def test_leaving_out_the_pressure_matters_at_low_drag_coefficients_only() -> None:
    """P over the weight is (8/3) (r_b/eps)/c_d at 90 degrees."""
    for (density, viscosity), small in ((FLUIDS[0], True), (FLUIDS[4], False)):
        one = race(density, viscosity, 1.0)
        speeds, angles = measured(one, 0.0)
        share = float(one.inward(speeds[-1])) / one.weight
        coefficient = float(discoidal(0.6).coefficient(one.reynolds(speeds[-1])))
        expected = 8.0 / 3.0 * (0.5 * DIAMETER / ORBIT) / coefficient * math.sin(angles[-1])
        assert share == pytest.approx(expected, rel=1e-9)
        assert (share < 0.01) == small


def test_overlapping_series_give_the_rolling_resistance() -> None:
    series = [(race(*fluid), *measured(race(*fluid), 0.05)) for fluid in FLUIDS]
    assert fit_rolling_resistance(series) == pytest.approx(0.05, abs=5e-4)


def test_series_that_do_not_overlap_and_balls_that_float_are_refused() -> None:
    with pytest.raises(QuestionError, match="no two series have overlapping"):
        fit_rolling_resistance([(race(*FLUIDS[0]), *measured(race(*FLUIDS[0]), 0.05))])
    with pytest.raises(QuestionError, match="floats"):
        TurnedRace(DIAMETER, 1e-4, ORBIT, 900.0, 1e-5)
    with pytest.raises(QuestionError, match="at most 90 deg"):
        drag_coefficients(race(*FLUIDS[0]), [1.0], [1.7])

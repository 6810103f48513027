"""Figures 6.25 to 6.27 in kind: run-ups with one ball in three oils, on the planar stand-in of table 6.4.

The rig tilts and stands on rubber whose stiffness grows with frequency; the planar stand-in has one stiffness, so its
resonance is that of the rig at rest. What the plane can say is how much unbalance the ball takes away.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.parameters import with_parameter
from autobalancer.plots.save import save_picture
from reproductions import compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "one_ball_run_up.toml"
DENSITY = {5: 844.0, 20: 955.0, 50: 950.0}  # kg/m^3 by mm^2/s: tables 6.3 and 6.1
EFFECTIVE, ORBIT, UNBALANCE = 4.75, 77.0, 594.0  # g and mm of section 6.1.6, g mm of section 6.1.3


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Residual deflection with the ball against without, ball position, resonance."""
    machine = ab.load_machine(MACHINE)
    bare = ab.simulate(with_parameter(machine, "balancers", ()))
    rows = []
    turns = []
    for viscosity, density in DENSITY.items():
        race = "balancers[1].races[1].fluid"
        oil = with_parameter(with_parameter(machine, f"{race}.viscosity", viscosity * 1e-6), f"{race}.density", density)
        run = ab.simulate(oil)
        save_picture(ab.plot_run_up(run), out / f"one_ball_{viscosity}_mm2_s.png")
        moment = 1e6 * float(run["ball_moment"][0])
        angle = abs(float(np.degrees(ab.ball_angle_to_unbalance(run)[-1, 0])))
        turns.append(abs(float(run["ball_angle_in_rotor"][-1, 0] - run["ball_angle_in_rotor"][0, 0])) / (2.0 * np.pi))
        figure = f"6.{ {5: 25, 20: 26, 50: 27}[viscosity] } in kind"
        ratio = ab.residual_vibration(run) / ab.residual_vibration(bare)
        rows += [
            (
                figure,
                "deflection at 1200 rpm with ball / without",
                "1",
                1.0 - moment / UNBALANCE,
                ratio,
                0.02,
            ),
            (figure, "ball opposite to the unbalance at the end", "deg", 180.0, angle, 3.0),
        ]
        if viscosity == 20:
            rows.append(("section 6.1.6", "moment of the ball", "g mm", EFFECTIVE * ORBIT, moment, 1.0))
    fewer = float(turns[0] > turns[1] > turns[2])
    rows += [
        ("6.25-6.27", "the thinner the oil, the more turns the ball lags (1 = true)", "1", 1.0, fewer, 0.0),
        (
            "section 6.1.2",
            "resonance passed at (planar: no stiffening rubber)",
            "Hz",
            10.7,
            _resonance(bare),
            0.1,
        ),
    ]
    return compared_all("Spannan 2021", None, rows)


def _resonance(run: Any) -> float:
    return float(ab.peak_deflection(run)["speed"]) / (2.0 * np.pi)

"""Figure 4.5a in kind: stability map of two balls on isotropic supports, all criteria in one picture.

The source does not print the set behind its figures 4.2 and 4.5, so this is the project's stall-and-release machine,
with the unbalance reduced by ten percent as the source does (4.5 g for 5 g), because balls that just balance stand in
line. (4.74) is met by the averaged eigenvalue problem. The exact border is far below, because the averaged equations
leave out the inertia of the balls; it is met by a simulation of the full equations.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine
from autobalancer.plots.style import save_picture
from autobalancer.simulation.record import Samples
from autobalancer.stability.maps.exact import averaged_border
from reproductions import Found, compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "stall_and_release.toml"
BALL, CRITICAL, DAMPING = 2.5e-3 * 0.1, 250.0, 100.0  # kg m, rad/s, N s/m


def reproduce(out: Path) -> list[dict[str, Any]]:
    """(4.70) against (4.74), simulated growth against the exact border, and the picture."""
    machine = with_value_at(load_race_machine(MACHINE), "unbalances[1].mass", "4.5 g")
    drag = float(machine.balancers[0].races[0].drag.damping)  # type: ignore[attr-defined]
    share = (BALL * CRITICAL) ** 2 / (DAMPING * drag)
    axes = {"speed": np.linspace(220.0, 500.0, 281), "drag": np.geomspace(2e-5, 2e-3, 241)}
    points = {"figure 4.2 in kind": (250.0 * (1.0 + 2.0 * share), drag)}
    found = ab.stability.map(machine, axes, operating_points=points)
    save_picture(ab.plot.map(found, speed_unit="rad/s"), out / "figure_4_5a.png")
    exact = next(border.speed for border in ab.stability.borders(machine) if border.name == "exact border")
    rows = [
        Found(
            "closed form",
            "border of (4.69) and (4.70), worst position of the balls, against (4.74)",
            "rad/s",
            CRITICAL * ((1.0 + share) / (1.0 - share)) ** 0.5,
            averaged_border(machine, worst_case=True).speed,
            1e-3,
        ),
        Found(
            "internal",
            "border of the simulated full equations, against its eigenvalues",
            "rad/s",
            exact,
            simulated_border(machine, exact),
            0.05,
        ),
    ]
    return compared_all("Spannan 2021", "4.5a in kind", rows)


def simulated_border(machine: Machine, near: float) -> float:
    """Zero of the growth rate of simulated small disturbances, from runs just below and above."""
    speeds = np.array([0.998, 1.002]) * near
    rates = [simulated_growth(machine, float(speed)) for speed in speeds]
    return float(np.interp(0.0, -np.array(rates), speeds)) if rates[0] > 0.0 > rates[1] else float("nan")


def simulated_growth(machine: Machine, speed: float) -> float:
    """Growth rate of the ball speeds in the rotor after a push from the balanced state."""
    states = ab.stability.equilibria(machine, speed)
    angles = states["ball_angle_in_rotor"].values[0]
    for path, value in (
        ("drive", {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}),
        ("balancers[1].races[1].balls[1].start_angles", tuple(angles + np.array([1e-6, 0.5e-6]))),
    ):
        machine = with_value_at(machine, path, value)
    run = ab.simulate(machine, duration=16.0, save=(Samples(160_001),), tolerance=1e-11)
    time, slip = run["time"].values, np.abs(run["ball_speed_in_rotor"].values).max(axis=1)
    bins = [(a, a + 0.25) for a in np.arange(8.0, 15.9, 0.25)]
    heights = [np.log(slip[(time >= a) & (time < b)].max()) for a, b in bins]
    return float(np.polyfit([a for a, _ in bins], heights, 1)[0])

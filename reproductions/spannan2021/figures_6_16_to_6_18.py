"""Figures 6.16 to 6.18 in kind: one ball in a slowly turned horizontal race, with the fluids of table 6.3.

The measured points of the source are pictures only. Angles come from simulated runs up to 90 degrees with the drag law
(6.9), repaired, and mu = 0.05 as the source found, as in its section 6.1.4.1; the evaluation (6.6) and the fit of mu by
overlapping series are then applied to them as to measured ones, and give back what was put in.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab
from autobalancer.catalog.product_tables import rows as table
from autobalancer.drag.discoidal import discoidal
from autobalancer.drag.sphere_on_plane import sphere_on_plane
from autobalancer.machine import Machine
from autobalancer.measurement.equilibrium_angles import (
    TurnedRace,
    drag_coefficients,
    equilibrium_angles,
    fit_rolling_resistance,
)
from autobalancer.plots.style import save_picture
from autobalancer.simulation.record import Samples
from reproductions import Found, compared_all

DIAMETER, ORBIT, STEEL, ROLLING = 0.0123, 0.07695, 7800.0, 0.05
MASS = STEEL * math.pi / 6.0 * DIAMETER**3
STEEPEST = math.radians(85.0)
LAW = discoidal(0.6)


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Statics against simulation, drag coefficients from the angles, the fitted rolling resistance."""
    series = {row["fluid"]: measured(fluid(row)) for row in table("experiment_fluids.csv")}
    draw(series, out)
    misses, products = [], []
    for race, speeds, angles in series.values():
        slow = angles < math.radians(60.0)
        statics = equilibrium_angles(race, LAW, speeds, ROLLING)
        misses.append(float(np.abs(angles - statics)[slow].max()))
        stokes = slow & (race.reynolds(speeds) < 10.0)
        products += (drag_coefficients(race, speeds, angles, ROLLING) * race.reynolds(speeds))[stokes].tolist()
    fitted = fit_rolling_resistance(list(series.values()))
    found = [
        Found("internal", "rolling resistance put in, from overlapping series", "1", ROLLING, fitted, 1e-3,
              figure="6.16 in kind"),
        Found("internal", "c_d Re put in, from the angles, Re < 10", "1", 387.0, float(np.mean(products)), 4.0,
              figure="6.17 in kind"),
        Found("internal", "simulated angle against statics, up to 60 deg", "deg", 0.0, math.degrees(max(misses)), 1.0,
              figure="6.18 in kind"),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "6.16 to 6.18 in kind", found)


def fluid(row: dict[str, str]) -> TurnedRace:
    """The ball of table 6.2 in a fluid of table 6.3."""
    return TurnedRace(DIAMETER, MASS, ORBIT, float(row["density_kg_m3"]), 1e-6 * float(row["nu_mm2_s"]))


def measured(race: TurnedRace) -> tuple[TurnedRace, np.ndarray, np.ndarray]:
    """Thirty simulated speeds and angles in a run-up of 300 s."""
    grid = np.geomspace(1e-2, 300.0, 20_000)
    statics = equilibrium_angles(race, LAW, grid, ROLLING)
    top = float(grid[np.flatnonzero(statics < STEEPEST)[-1]])
    first = float(equilibrium_angles(race, LAW, 0.1 * top, ROLLING))
    run = ab.simulate(turned(race, top, first), duration=300.0, save=Samples(301))
    angles = (run["rotor_angle"] + run["ball_angle_in_rotor"][:, 0]).values + 0.5 * math.pi
    pick = np.unique(np.geomspace(20, 300, 30).astype(int))
    return race, run["speed"].values[pick], np.minimum(angles[pick], 0.5 * math.pi)


def turned(race: TurnedRace, top: float, first: float) -> Machine:
    """A rotor that does not give way, brought linearly to the speed at which the ball is nearly at 90 degrees."""
    one = {
        "orbit_radius": ORBIT,
        "drag": {"law": "discoidal"},
        "fluid": {"density": race.fluid_density, "viscosity": race.viscosity},
        "friction": {"rolling_resistance": ROLLING},
        "balls": [
            {
                "diameter": DIAMETER,
                "density": STEEL,
                "start_angles": [first - 0.5 * math.pi],
                "start_speeds": [-0.1 * top],
            }
        ],
    }
    profile = {"kind": "ramp", "start": 0.1 * top, "end": top, "duration": 300.0}
    return Machine(
        name="Discoidal rotor on a horizontal shaft",
        axis="horizontal",
        rotor={"mass": 1e6, "stiffness": 1e10, "damping": 1e8},
        balancers=[{"races": [one]}],
        drive={"kind": "speed", "profile": profile},
    )


def draw(series: dict[str, Any], out: Path) -> None:
    """Drag coefficient over Reynolds number, and angle over speed with the statics."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    for number, (name, (race, speeds, angles)) in enumerate(series.items()):
        color = plt.cm.viridis(number / len(series))
        left.loglog(
            race.reynolds(speeds), drag_coefficients(race, speeds, angles, ROLLING), ".", color=color, label=name
        )
        right.semilogx(speeds, np.degrees(angles), ".", color=color)
        grid = np.geomspace(speeds[0], speeds[-1], 200)
        right.semilogx(grid, np.degrees(equilibrium_angles(race, LAW, grid, ROLLING)), color=color, lw=0.8)
    re = np.geomspace(0.1, 1e5, 300)
    left.loglog(re, LAW.coefficient(re), "k", lw=0.8, label="(6.9), repaired")
    left.loglog(re, sphere_on_plane().coefficient(re), "k--", lw=0.8, label="sphere on a plane")
    left.set(xlabel="Reynolds number", ylabel="drag coefficient")
    right.set(xlabel="rotor speed in rad/s", ylabel="angle from the lowest point in deg")
    left.legend(fontsize=6)
    save_picture(figure, out / "figures_6_16_to_6_18.png")

"""Figure 5.6 in kind: velocity of the fluid over the gap in the plane of the orbit, at constant speed and during acceleration.

The source draws these profiles without numbers. Checked is what it says of them: a straight line at constant speed; in the
picture the fluid hangs back in the middle during acceleration. The chamber is that of table 6.2. Spin-up of thin oil is
held against the theory of Greenspan and Howard (1963).
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.files.machine_file import load_race_machine
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.annulus_problem import annulus_flow
from autobalancer.machine import Ramp
from autobalancer.plots.style import save_picture
from reproductions import Found, compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "discoidal.toml"
HARD = 870.0  # rad/s^2, a thousand times as much as in the source, to see something


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Straightness at constant speed, spin-up of thin oil, and the picture."""
    annulus = replace(annulus_of(load_race_machine(MACHINE)), viscosity=715e-6)
    hard = annulus_flow(annulus, Ramp(end=120.0, duration=120.0 / HARD), duration=0.5, times=[0.03, 0.06, 0.1, 0.5])
    save_picture(ab.plot.answer(hard, "velocity_profiles"), out / "figure_5_6.png")
    thin = replace(annulus, viscosity=0.65e-6)
    theory = thin.height / (2.0 * math.sqrt(thin.viscosity * 60.0))
    spin_up = annulus_flow(thin, 60.0, initial_speed=59.4, duration=2.0 * theory, samples=1001)
    rows = [
        Found("words", "greatest departure from a straight profile at constant speed, over the wall's", "1", 0.0,
              bend(hard), 1e-3, figure="5.6a"),
        Found("closed form", "spin-up time in 0.65 mm^2/s at 60 rad/s, against H/(2 sqrt(nu w))", "s", theory,
              float(spin_up.attrs["spin_up_time"]), 0.02 * theory, figure="section 5.2.1"),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "5.6", rows)


def bend(flow: xr.Dataset) -> float:
    """Greatest distance of the last velocity profile at mid-height from its chord, over the velocity of the outer wall."""
    radius = flow["radius"].values
    middle = float(flow["height"][-1]) / 2.0
    velocity = radius * flow["fluid_angular_velocity"].isel(moment=-1).interp(height=middle).values
    chord = np.interp(radius, radius[[0, -1]], velocity[[0, -1]])
    return float(np.abs(velocity - chord).max() / velocity[-1])

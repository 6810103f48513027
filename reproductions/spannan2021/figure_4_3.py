"""Figure 4.3 in kind: with an eccentric race the deflection that stays is the eccentricity.

The paper behind the figure is dimensionless, so the machine is the project's own; speed and start angles are the
paper's. By (4.47)-(4.49) the forward component of the whirl is -E e^(i gamma), on isotropic and orthotropic supports.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.plots.style import save_picture
from autobalancer.simulation.record import Envelope, LastRevolutions, Samples
from reproductions import Found, compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "eccentric_race.toml"
SUPPORTS = {"isotropic": "625 kN/m", "orthotropic": ("500 kN/m", "750 kN/m")}


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Size and direction of the forward whirl, for both supports."""
    rows = []
    for name, stiffness in SUPPORTS.items():
        machine = with_value_at(ab.load_machine(MACHINE), "rotor.stiffness", stiffness)
        run = ab.simulate(machine, save=(Samples(), Envelope(), LastRevolutions(20)))
        save_picture(ab.plot.orbit(run), out / f"figure_4_3_{name}.png")
        z = run["turn_x"].values + 1j * run["turn_y"].values
        forward = complex((z * np.exp(-1j * run["turn_rotor_angle"].values))[:-1].mean())
        angle = float(np.degrees(np.angle(forward)) % 360.0)
        rows += [
            Found("closed form", f"mean deflection = E, {name}", "mm", 0.1, 1e3 * abs(forward), 1e-4),
            Found("closed form", f"its direction in the rotor = gamma + 180 deg, {name}", "deg", 250.0, angle, 0.01),
        ]
    return compared_all("Spannan 2021", "4.3 in kind", rows)

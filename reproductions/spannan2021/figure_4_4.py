"""Figure 4.4 in kind: feasible operating ranges on orthotropic supports.

The source finds them without damping from the sign of the forward whirl: between w_x and w_r, and above w_y, with w_r
of (4.71). Here the balanced state of a lightly damped machine of ours (two light balls in a thick fluid, w_y/w_x =
1.30) is judged by its multipliers over a revolution; damping and ball mass move the edges by a fraction of a percent.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.machine import Machine
from autobalancer.plots.style import save_picture
from autobalancer.stability.maps.exact import stable_windows
from autobalancer.stability.states.questions import eigenvalues
from reproductions import Found, compared_all

STIFFNESS = (1.0e5, 1.7e5)  # N/m
MASS, BALL, ORBIT = 10.0, 2.0e-3, 0.1  # kg, kg, m; the mass with the balls


def reproduce(out: Path) -> list[dict[str, Any]]:
    """The four edges of the two ranges."""
    machine = rig()
    low, high = (math.sqrt(k / MASS) for k in STIFFNESS)
    middle = math.sqrt(0.5 * (low**2 + high**2))
    found = stable_windows(machine, 2.0 * high, lowest=0.8 * low)
    edges = [edge for window in found.windows for edge in window]
    speeds = np.linspace(0.85 * low, 1.3 * high, 161)
    save_picture(ab.plot.answer(eigenvalues(machine, list(speeds)), speed_unit="rad/s"), out / "figure_4_4.png")
    rows = [Found("words", "ranges", "1", 2.0, float(len(found.windows)), 0.0)]
    names = ("lower range begins at w_x", "lower range ends at w_r (4.71)", "upper range begins at w_y")
    rows += [
        Found("closed form", name, "rad/s", target, edge, 0.005 * target)
        for name, target, edge in zip(names, (low, middle, high), edges, strict=False)
    ]
    return compared_all("Spannan 2021", "4.4 in kind", rows)


def rig() -> Machine:
    """Two light balls in a thick fluid on orthotropic supports with a damping ratio of about 1 %."""
    race = {
        "orbit_radius": ORBIT,
        "drag": {"law": "viscous", "damping": 1e-2},
        "balls": [{"count": 2, "mass": BALL, "motion": "point"}],
    }
    return Machine(
        name="orthotropic supports",
        axis="vertical",
        rotor={"mass": MASS - 2.0 * BALL, "stiffness": STIFFNESS, "damping": 20.0},
        unbalances=[{"moment": 1.2 * BALL * ORBIT}],
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 200.0}},
    )

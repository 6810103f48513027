"""Figures 13 and 14 and section 4.3: reactions that hold the body in planar motion, and the body released under them.

The source takes five balls and a friction of 0.5, which on our reference machine stay at the bottom; twelve are carried, and
settle after as long a time as its five do. Orders of magnitude are compared, in decades. Equation (52) is taken with the
squares of its lengths; h is not printed, 0.15 m is that of our reference machine. As in the source, reactions after the balls
have settled do not drive the body.

The body is hit harder here, along the axis by half a decade: balls reach 4 m/s along it on the way through the critical
speeds, and mass and speed of those of the source are not printed. The forces of the source in steady state are those of a
friction that changes its sign at nearly each step, of +-1500 N around a mean of 0.12 N. Here friction goes through zero within
a slope, the balls come to rest along the axis, and the force falls to zero by itself, so its mean has no row; what stays is
the moment of the couple that balls at rest leave, +-13 N m, which turns with the rotor.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.files.machine_file import load_chamber_machine
from autobalancer.plots.drawing.save import save_picture
from autobalancer.results.chamber.balls import ball_settling_time
from autobalancer.results.chamber.measures import chamber_measures
from autobalancer.results.chamber.unconstrained import pakula_body, unconstrained_motion
from autobalancer.simulation.chamber import simulate_chamber
from reproductions import Found, compared_all
from reproductions.pakula2021._grid import MACHINE

HEIGHT = 0.15  # m
ORDER = 0.3  # decades, a factor of two
OTHER = "the machine of the source is not printed; ours carries 12 balls, not 5"
CHATTER = "the source has the chatter of a friction that changes its sign at every step; ours goes through zero"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Greatest motion of the loose body and reactions, against the printed ones."""
    machine = ab.chamber.variant(load_chamber_machine(MACHINE), balls=12, friction=0.5)
    run = simulate_chamber(machine, duration=16.0)
    settled = float(ball_settling_time(run, last=1.0).max())
    body = pakula_body(HEIGHT)
    title = "12 balls, friction 0.5 (Pakuła 2021, figures 13 and 14)"
    save_picture(ab.plot.chamber_reactions(run, title=title), out / "figure_13.png")
    save_picture(ab.plot.chamber_reactions(run, body, until=settled, title=title), out / "figure_14.png")
    moved = unconstrained_motion(run, body, settled)
    greatest = {name: float(np.abs(moved[name].values).max()) for name in ("x", "rotation_y", "rotation_z")}
    steady = chamber_measures(run, last=1.0).sel(stage="steady")
    rows = [
        Found("words", "duration of the transient, 12 balls in place of 5", "s", 8.6, settled, 0.86, OTHER),
        _order("displacement along x", "um", 50.0, 1e6 * greatest["x"]),
        _order("rotation about y", "°", 0.015, np.rad2deg(greatest["rotation_y"])),
        _order("rotation about z", "°", 0.0028, np.rad2deg(greatest["rotation_z"])),
        Found("printed", "greatest force along x in steady state", "N", 1500.0, steady["constraint_x_greatest"], 750.0,
              CHATTER),
        Found("printed", "greatest moment about y in steady state", "N m", 350.0,
              steady["constraint_moment_y_greatest"], 175.0, CHATTER),
    ]  # fmt: skip
    return compared_all("Pakuła 2021", "13 and 14", rows)


def _order(what: str, unit: str, target: float, obtained: float) -> Found:
    """A row of decades, for a motion of the body that is let go."""
    quantity = f"order of the greatest {what}, body released"
    return Found("printed", quantity, f"decades over 1 {unit}", math.log10(target), math.log10(obtained), ORDER, OTHER)

"""Figure 13 and section 4.3: the reactions that hold the body in planar motion, and how long the transient lasts.

The source takes five balls and a friction of 0.5, which on our reference machine stay at the bottom; twelve are carried, and
settle after 10.5 s in place of 8.6 s. The forces of the source in steady state, of +-1500 N around a mean of 0.12 N and
350 N m, are those of a friction that changes its sign at nearly each step. Here friction goes through zero within a slope, the
balls come to rest along the axis and the force falls to zero, so these numbers are no target: lost_machine has the bound that
such a chatter has, and the released body of figure 14, on the machine that carries five balls.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import autobalancer as ab
from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.plots.style import save_picture
from autobalancer.results.chamber_measures import ball_settling_time
from autobalancer.simulation.chamber import simulate_chamber
from reproductions import Found, compared_all
from reproductions.pakula2021._grid import MACHINE

OTHER = "the machine of the source is not printed; ours carries 12 balls, not 5"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Duration of the transient, and the reactions as a picture."""
    machine = ab.chamber.variant(balls_in_chambers(MACHINE), balls=12, friction=0.5)
    run = simulate_chamber(machine, duration=16.0)
    settled = float(ball_settling_time(run, last=1.0).max())
    title = "12 balls, friction 0.5 (Pakuła 2021, figure 13)"
    save_picture(ab.plot.answer(run, "reactions", title=title), out / "figure_13.png")
    rows = [
        Found("words", "duration of the transient, 12 balls in place of 5", "s", 8.6, settled, 0.86, OTHER),
    ]  # fmt: skip
    return compared_all("Pakuła 2021", "13", rows)

"""Drag of the ball of the discoidal rig from the equations of the fluid, against (5.21) and (6.9).

The sources do not say how narrow the gap between ball and wall is; here it is 1 micrometre in the race, and 1e-5 radii on the
plane. The groove of the bearing ring is left out: the race is the rectangle of table 6.2. Nothing was fitted.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import autobalancer as ab
from autobalancer.plots.style import save_picture
from reproductions import Found, compared_all

ORBIT = 76.95e-3
ROLLS = "c_d Re of the ball that rolls in the closed race, Re = "
SLOW = 387.0  # c_d Re of slow flow in (6.9), printed
PRINT = "the cubic of (6.9) as printed, with 0.038, grows 2.6-fold; its last decimal point is moved, see drag_laws"
GROOVE = "a gap of 1 um assumed, ten times more gives 48 less; groove of the bearing ring left out"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """c_d Re, and the picture of the flow."""
    race = ab.flow.Channel(12.3e-3, 13.8e-3, 20e-3, ORBIT, 2.0 * math.pi * ORBIT)
    rolls = ab.flow.ball_drag(race, [0.0, 10.0, 30.0, 100.0], gap=1e-6)
    slides = ab.flow.ball_drag(race, [0.0], gap=1e-6, motion="sliding")
    plane = ab.flow.ball_drag(ab.flow.Channel(2.0, 40.0, 40.0), [0.0], gap=1e-5, fineness=1.5)
    save_picture(ab.plot.answer(rolls), out / "ball_drag.png")
    slow, fast = float(rolls["cd_times_re"][0]), float(rolls["cd_times_re"][-1])
    grows = 10.0 ** sum(c * 2.0**power for power, c in enumerate((2.72, -1.25, 0.121, 0.0038))) * 100.0 / SLOW
    rows = [
        Found("printed", f"{ROLLS}1", "1", SLOW, slow, 39.0, GROOVE, "6.9"),
        Found("misprint", "c_d Re at Re = 100 over that of slow flow", "1", grows, fast / slow, 0.1, PRINT, "6.9"),
    ]
    still = "c_d Re of the ball that slides without turning, slow"
    rows.append(Found("printed", still, "1", SLOW, float(slides["cd_times_re"][0]), 39.0, GROOVE, "6.9"))
    note = "a gap of 1e-5 radii assumed; 6e-7 radii would give 322"
    rows.append(
        Found(
            "printed",
            "c_d Re of a sphere that rolls on a plane, slow",
            "1",
            322.0,
            float(plane["cd_times_re"][0]),
            32.0,
            note,
            "5.21",
        )
    )
    return compared_all("Spannan 2021", "6.9", rows)

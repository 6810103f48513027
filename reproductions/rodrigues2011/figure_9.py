"""Figure 9a: measured response with two balls, upwards and downwards, against the model with c_b = 0.1.

Done as in the experiment, with balls that roll and touch. Compared are levels (ratios of geometric means) over bands of the
speed. The race runs out by 5 um in a direction that is not printed: at high speed the level is 1.07 to 1.65 times the measured
one over eight directions, 1.29 without any; the direction 91 degrees ahead of the heavy spot is nearest and is taken, so rows of
it are fitted. The model has neither the resonances of motor and bearing near 1000 and 3300 rpm, nor the friction between balls
and race; without friction the balls lag behind on the way up from rest, and fall out of step at resonances that they passed in
the rig. So the hysteresis is there below the second critical speed and missing at the fourth.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import autobalancer as ab
from autobalancer.plots.style import UNBALANCE, save_picture
from reproductions import Found, compared_all
from reproductions.rodrigues2011.balls import as_measured, geometric_mean, level, stepped
from reproductions.rodrigues2011.rig import columns

MOTOR = "the peaks near 1000 and 1170 rpm are not in the model; what they may be is compared in torsional_resonance"
FRICTION = "friction between balls and race is not in the model; one measured run"
FAST = (4000.0, 5000.0)  # rpm
WITHIN = 0.25


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Levels against the measured curves, and the picture."""
    found = stepped(as_measured(3))
    up, down = found.sel(direction="up"), found.sel(direction="down")
    slow = level(up, 800.0, 1200.0) / measured("up", 800.0, 1200.0)
    rows = [Found("printed", "level upwards from 800 to 1200 rpm, ours over measured", "1", 1.0, slow, WITHIN, MOTOR)]
    for way, leg in (("up", up), ("down", down)):
        text = f"level {way}wards from 4000 to 5000 rpm, ours over measured"
        rows.append(Found("fitted", text, "1", 1.0, level(leg, *FAST) / measured(way, *FAST), WITHIN))
    for low, high in ((1200.0, 1500.0), (2200.0, 2500.0)):  # where the source sees hysteresis
        ours, theirs = (
            level(up, low, high) / level(down, low, high),
            measured("up", low, high) / measured("down", low, high),
        )
        text = f"run-up over run-down from {low:g} to {high:g} rpm"
        rows.append(Found("fitted", text, "1", theirs, ours, WITHIN * theirs, FRICTION if low > 2000.0 else ""))
    figure = ab.plot.stepped_response(found, deflection_unit="mm")
    for way, mark in (("up", "^"), ("down", "v")):
        speed, amplitude = columns(f"fig09_abb_3washers_run{way}")
        kept = speed > 590.0
        figure.axes[0].plot(
            speed[kept], amplitude[kept], mark, ms=2.2, mew=0.5, mfc="none", color=UNBALANCE, zorder=1.2
        )
    figure.axes[0].set_title("Rodrigues 2011, figure 9a, c_b = 0.1; measured in vermilion", loc="left")
    save_picture(figure, out / "figure_9.png")
    return compared_all("Rodrigues 2011", "9a", rows)


def measured(way: str, low: float, high: float) -> float:
    """Geometric mean of the measured amplitudes in a band, mm."""
    return geometric_mean(*columns(f"fig09_abb_3washers_run{way}"), low, high)

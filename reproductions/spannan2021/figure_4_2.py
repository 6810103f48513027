"""Figure 4.2 in kind: balls stall at the critical speed, break away, and balance.

The source prints no complete parameter set; this is the project's own stall-and-release machine, with targets from the
closed forms and from the set's own statement.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.plots.save import save_picture
from autobalancer.simulation.sampling import Envelope, Samples
from reproductions import compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "stall_and_release.toml"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Speed of the hanging balls, release, peak, residual deflection."""
    run = ab.simulate(MACHINE, save=(Samples(40_001), Envelope(4000)), tolerance=1e-9)
    save_picture(ab.plot_run_up(run, speed_unit="rad/s"), out / "figure_4_2.png")
    hanging = (run["speed"] > 265.0) & (run["speed"] < 383.0)
    in_space = run["ball_speed_in_space"].where(hanging, drop=True)
    peak = ab.peak_deflection(run)
    ball, critical, drag, damping = 2.5e-3 * 0.1, 250.0, 1.4685e-4, 100.0
    release = critical * (1.0 + 2.0 * (ball * critical) ** 2 / (damping * drag))
    rows = [
        (
            "speed in space of the hanging balls, mean from 265 to 383 rad/s",
            "rad/s",
            248.0,
            float(in_space.mean()),
            2.0,
        ),
        (
            "release speed, against (4.73)",
            "rad/s",
            release,
            float(ab.release_speed(run).max()),
            0.02 * release,
        ),
        ("peak deflection at release", "mm", 1.33, 1e3 * float(peak["deflection"]), 0.01),
        ("peak deflection, against 2 m_b eps w_c / b", "mm", 1.25, 1e3 * float(peak["deflection"]), 0.1),
        ("rotor speed at the peak", "rad/s", 387.0, float(peak["speed"]), 2.0),
        ("deflection at the end, to be below 1 um", "um", 0.0, 1e6 * ab.residual_vibration(run, 0.5), 1.0),
        (
            "ball speed in the rotor at the end",
            "rad/s",
            0.0,
            float(np.abs(run["ball_speed_in_rotor"][-1]).max()),
            1e-3,
        ),
    ]
    return compared_all("Spannan 2021", "4.2 in kind", rows)

"""Table 5 and appendix 2: energy error of a fixed Runge-Kutta step in a head-on elastic collision.

The source prints neither k nor m nor where in a step the contact begins, so that only the order of magnitude and the growth
with the step can be compared. k/m = 1e10 m^-0.5 s^-2 of one ball is taken; a fixed phase makes each entry of the table one
sample of a distribution that is symmetric about zero. Its errors are all positive or zero; that is neither a property of the
scheme nor of the contact law (see the study of the step size in the documentation).
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.plots.style import save_picture
from reproductions import Found, compared_all

DATA = Path(__file__).parent / "data" / "central_collision_table5.csv"
STIFFNESS_OVER_MASS = 1e10
ORDER = 0.3  # decades, a factor of two
SAMPLE = "the source samples one phase of the contact in its step; the error is symmetric about zero"
SPEEDS, STEPS = (4.0, 6.0, 8.0, 10.0), (1e-4, 1e-5, 1e-6, 1e-7)


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Root mean square over phases against the table, per step; growth with the step; sign."""
    found = ab.chamber.step_size(SPEEDS, STEPS, stiffness_over_mass=STIFFNESS_OVER_MASS, phases=200)
    figure = ab.plot.answer(found, title="Central elastic collision (Pakuła 2021, table 5)")
    printed = table()
    panel = figure.axes[0]
    for (_, step), error in printed.items():
        if error > 0.0:
            panel.plot([step], [error], "k+", ms=8)
    panel.plot([], [], "k+", ms=8, label="Pakuła 2021")
    panel.legend(loc="upper left")
    save_picture(figure, out / "table_5.png")
    rows = []
    for step in (1e-4, 1e-5):
        ours = 100.0 * math.sqrt(float((found["root_mean_square"].sel(step=step) ** 2).mean()))
        theirs = math.sqrt(np.mean([printed[speed, step] ** 2 for speed in SPEEDS]))
        quantity = f"order of magnitude of the error at a step of {step:g} s"
        rows.append(Found("fitted", quantity, "decades", math.log10(theirs), math.log10(ours), ORDER, SAMPLE))
    inside = [
        100.0 * float(found["least"].sel(relative_speed=speed, step=step)) <= error
        and error <= 1.05 * 100.0 * float(found["greatest"].sel(relative_speed=speed, step=step))
        for (speed, step), error in printed.items()
    ]
    share = 100.0 * float(np.mean(inside))
    rows.append(Found("fitted", "entries within the range over the phases", "%", 100.0, share, 10.0))
    size = found["typical_root_mean_square"].sel(relative_speed=8.0).values
    power = float(np.log10(size[1] / size[2]))
    theirs = math.log10(printed[8.0, 1e-5] / printed[8.0, 1e-6])
    rows.append(Found("fitted", "power of the step from 1e-5 to 1e-6 s at 8 m/s", "1", theirs, power, 0.2, SAMPLE))
    gains = 100.0 * float(found["share_of_gains"].sel(step=[1e-6, 1e-7]).mean())
    rows.append(Found("words", "collisions that gain energy; the table has no loss", "%", 100.0, gains, 10.0, SAMPLE))
    return compared_all("Pakuła 2021", "table 5", rows)


def table() -> dict[tuple[float, float], float]:
    """(relative speed, step) to the error in percent."""
    with DATA.open(encoding="utf-8", newline="") as file:
        return {
            (float(row["relative_speed_m_s"]), float(row["step_s"])): float(row["energy_error_percent"])
            for row in csv.DictReader(file)
        }

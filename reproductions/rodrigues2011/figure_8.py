"""Figure 8a: response of the rotor without balls, three washers removed.

The curve of the source is the greatest value in time of the mean over the bearings. The vertex at 1470 rpm, next to the
part that the frame of the figure cuts off, does not lie on the curve through its neighbors and has a row of its own. The
peaks of (3) are compared with 1455, 1700, 1920 and 2280 rpm, where the source has those of its simulation. The rig is fitted to
this very curve.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.plots.style import ALL_BALLS, BALLS, INK, UNBALANCE, look, picture, save_picture
from autobalancer.rotordynamics.response import response_peaks
from reproductions import Found, compared_all
from reproductions.rodrigues2011.rig import BEARINGS, RPM, columns, fitted

PRINTED = (1455.0, 1700.0, 1920.0, 2280.0)  # rpm
OFF = 1470.0  # rpm


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Curve, peaks, and the picture with the measured points."""
    machine = fitted()
    speed, amplitude = columns("fig08_sim_plain_3washers")
    obtained = ab.rotor.response(machine, speed * RPM, BEARINGS)["greatest_mean"].values * 1e3
    deviation = 100.0 * (obtained / amplitude - 1.0)
    kept = speed != OFF
    worst = deviation[kept][np.argmax(np.abs(deviation[kept]))]
    rows = [
        Found("fitted", "simulated curve, greatest deviation of all vertices but 1470 rpm", "%", 0.0, worst, 1.0),
        Found("fitted", "simulated curve, deviation at 1470 rpm", "%", 0.0, deviation[~kept][0], 1.0,
              "beside the part that the frame of the figure cuts off; not on the curve through its neighbors"),
        Found("fitted", "simulated curve, root mean square of the deviations but 1470 rpm", "%", 0.0,
              float(np.sqrt((deviation[kept] ** 2).mean())), 0.2),
    ]  # fmt: skip
    means = response_peaks(machine, 1000.0 * RPM, 3000.0 * RPM, BEARINGS)["peak_speed"].values / RPM
    for number, (target, found) in enumerate(zip(PRINTED, means, strict=True), 1):
        quantity = f"peak {number} of (3), against the printed speed"
        rows.append(Found("fitted", quantity, "rpm", target, found, 0.005 * target))
    _draw(out)
    return compared_all("Rodrigues 2011", "8a", rows)


def _draw(out: Path) -> None:
    grid = np.linspace(600.0, 5500.0, 3000)
    found = ab.rotor.response(fitted(), grid * RPM, BEARINGS)
    with look():
        figure = picture(8.0, 4.6)
        axes = figure.subplots()
        for name, mark, color in (("runup", "^", ALL_BALLS), ("rundown", "o", BALLS[4])):
            measured = columns(f"fig08_plain_3washers_{name}")
            axes.plot(*measured, mark, ms=2.5, color=color, label=f"measured, {name.replace('run', 'run-')}")
        axes.plot(*columns("fig08_sim_plain_3washers"), "x", ms=4, color=UNBALANCE, label="simulation of the source")
        axes.plot(grid, found["greatest_mean"].values * 1e3, color=INK, label="greatest mean")
        axes.plot(grid, found["mean_of_greatest"].values * 1e3, color=BALLS[2], lw=1.0, label="mean of greatest, (3)")
        axes.set(yscale="log", xlim=(300.0, 5500.0), xlabel="rotor speed (rpm)", ylabel="amplitude (mm)")
        axes.set_title("Rodrigues 2011, figure 8a")
        figure.legend(loc="outside lower center", ncols=3)
        save_picture(figure, out / "figure_8.png")

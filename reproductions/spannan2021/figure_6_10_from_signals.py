"""Figure 6.10 as it was measured: the run-up with its own small unbalance, seen by the laser.

The envelope of the signal, turn by turn, gives the passage. The rig on softening bushings meets it with an own unbalance that was
chosen for figure 6.10. On rubber of one stiffness the damping of the first mode follows from the width of the resonance at half
of its power; the rig has the 4.6 % that the source found after a blow, so this checks the evaluation alone. It warns that the
run-up is fast for this: the speed grows by a tenth of the squared decay rate.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.plots.style import BALLS, CRITICAL, heading, legend, look, picture, save_picture
from reproductions import Found, compared_all
from reproductions.spannan2021._logger import ENCODER, KEPT, LASER, RATE, SURE
from reproductions.spannan2021.figure_6_10 import END, MIDDLE, SEEN, own_unbalance, passage
from reproductions.spannan2021.figure_6_12 import HERTZ, run_up_and_down
from reproductions.spannan2021.softening_rubber import NOT_PRINTED, PASSAGE

BROAD = (
    0.1  # Hz, in which the greatest of turns with noise of 2 um may fall: there the amplitude changes by less than 1 %
)


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Passage from the envelope, damping from the width."""
    run, turns = measured("discoidal_rig_rubber")
    ends = ab.measure.envelope(turns)
    size = 0.5 * (ends["envelope_high"] - ends["envelope_low"]).values[0]
    greatest = int(np.argmax(size))
    found = float(ends["envelope_speed"][greatest]) / HERTZ
    when = float(ends["envelope_time"][greatest])
    order = ab.measure.orders(measured("discoidal_rig")[1], 1.0)
    width = ab.measure.half_power(order.sel(time=slice(20.0, END)))
    true = float(ab.rotor.modes(own_unbalance(MIDDLE, "discoidal_rig"), 0.0, balls=False, modes=2)["damping_ratio"][0])
    at = f"own unbalance of {1e6 * MIDDLE:g} g mm, softening rubber"
    rows = [
        Found("fitted", f"speed of the greatest deflection in the envelope of the signal, {at}", "Hz", PASSAGE, found, 0.2,
              NOT_PRINTED),
        Found("fitted", f"time of it, {at}", "s", SEEN, when, 2.0, NOT_PRINTED),
        Found("internal", f"speed of the greatest deflection, signal against motion, {at}", "Hz", passage(run), found, BROAD),
        Found("internal", "damping ratio by the width of the resonance, linear rubber", "%", 100.0 * true,
              100.0 * float(width["damping_ratio"]), 100.0 * SURE * float(width["damping_ratio_deviation"])),
    ]  # fmt: skip
    draw(ends, size, out)
    return compared_all("Spannan 2021", "6.10 in kind", rows)


def measured(name: str) -> tuple[xr.Dataset, xr.Dataset]:
    """The run-up and what the laser sees of it, with the angle of the rotor."""
    run = run_up_and_down(own_unbalance(MIDDLE, name), KEPT)
    signals = ab.measure.record(run, (LASER, ENCODER), RATE, end=END, seed=1)
    return run, ab.measure.rotor_angle(signals)


def draw(ends: xr.Dataset, size: np.ndarray, out: Path) -> None:
    """Least and greatest value of each turn over the time."""
    with look():
        figure = picture(7.6, 3.8)
        axes = figure.subplots()
        low, high = (1e6 * ends[f"envelope_{name}"].values[0] for name in ("low", "high"))
        axes.fill_between(
            ends["envelope_time"], low, high, color=BALLS[0], alpha=0.5, lw=0, label="envelope of the signal"
        )
        k = int(np.argmax(size))
        axes.plot(float(ends["envelope_time"][k]), high[k], "v", color="black", ms=5, label="greatest deflection")
        axes.axvline(SEEN, color=CRITICAL, ls=(0, (5, 3)), label="measured: 70 s, 10.7 Hz")
        axes.set(xlabel="time (s)", ylabel="deflection at the laser (µm)", xlim=(15.0, END))
        legend(axes)
        heading(figure, "Spannan 2021, figure 6.10 from the signal of the laser: own unbalance")
        save_picture(figure, out / "figure_6_10_from_signals.png")

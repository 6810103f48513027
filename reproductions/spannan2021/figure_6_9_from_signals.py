"""Figure 6.9 in kind: the blow at the rig at rest, evaluated from what noisy sensors would have written of the simulated rig.

The rig has the linear bushings of the catalog, without balls and at rest. A displacement sensor at the laser and an
accelerometer, at 1 kHz and 40 dB above their noise, see two seconds after a blow at the race. Two oscillations are fitted to each
signal; they are compared with the modes of the rig, whose first frequency and decay were fitted to the 9.6 Hz and 2.8 1/s that
the source prints. So these rows show what the evaluation of signals adds, and nothing of the rig. The tolerance is three standard
deviations as the fit states them.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.machine import Machine
from autobalancer.plots.style import BALLS, INK, heading, legend, look, picture, save_picture
from reproductions import Found, compared_all
from reproductions.spannan2021.figure_6_10 import mass_at_the_race, own_unbalance
from reproductions.spannan2021.softening_rubber import BLOW

HERTZ = 2.0 * math.pi
LINEAR = "discoidal_rig"
SENSORS = (
    ab.measure.Sensor("displacement", "laser", noise="40 dB"),
    ab.measure.Sensor("acceleration", "accelerometer", noise="40 dB"),
)
SURE = 3.0  # standard deviations


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Frequency and decay of both modes across, from either sensor."""
    machine = struck()
    signals = ab.measure.record(ab.simulate(machine, duration=2.0, save=ab.Samples(4001)), SENSORS, "1 kHz", seed=1)
    modes = ab.rotor.modes(machine, 0.0, balls=False, modes=4)
    frequency, decay = (modes[name].values[[0, 2]] for name in ("frequency", "decay_rate"))
    rows, fits = [], {}
    for sensor in SENSORS:
        fits[sensor.channel] = fit = ab.measure.decay_rate(
            signals["time"].values, signals[sensor.channel].values, modes=2
        )
        for true, mode in enumerate(np.argsort(fit["frequency"].values)):
            seen = fit.isel(mode=int(mode))
            of = f"of mode {true + 1} across, from {sensor.quantity} with noise"
            for name, unit, target, factor in (
                ("frequency", "Hz", frequency, HERTZ),
                ("decay_rate", "1/s", decay, 1.0),
            ):
                sure = SURE * float(seen[f"{name}_uncertainty"]) / factor
                words = f"{name.replace('_rate', '')} {of}"
                rows.append(
                    Found("internal", words, unit, float(target[true]) / factor, float(seen[name]) / factor, sure)
                )
    draw(signals, fits, out)
    return compared_all("Spannan 2021", "6.9 in kind", rows)


def struck() -> Machine:
    """The rig at rest without balls and unbalance, just after the blow."""
    still = with_value_at(own_unbalance(0.0, LINEAR), "unbalances", ())
    still = with_value_at(still, "drive", {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}})
    return with_value_at(still, "start", {"velocity": [BLOW / mass_at_the_race(still), 0.0]})


def draw(signals: xr.Dataset, fits: dict[str, xr.Dataset], out: Path) -> None:
    """Each signal with the two oscillations that were fitted to it."""
    scales = {"displacement": (1e3, "mm"), "acceleration": (1.0, "m/s²")}
    with look():
        figure = picture(7.6, 4.6)
        for axes, (name, fit) in zip(figure.subplots(2, 1, sharex=True), fits.items(), strict=True):
            factor, unit = scales[str(signals[name].attrs["quantity"])]
            axes.plot(fit["time"], factor * fit["signal"], color=BALLS[4], lw=2.5, alpha=0.7, label="sensor")
            axes.plot(fit["time"], factor * fit["fitted"], color=INK, lw=0.8, label="two fitted oscillations")
            axes.set(ylabel=f"{signals[name].attrs['quantity']}\n({unit})")
            axes.margins(x=0.0)
        heading(figure, "Spannan 2021, figure 6.9 in kind: after a blow, from signals of the simulated rig")
        figure.axes[1].set(xlabel="time (s)")
        legend(figure.axes[0])
        save_picture(figure, out / "figure_6_9_from_signals.png")

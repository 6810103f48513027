"""Figures 6.9 and 6.10 on the rig of bodies on softening bushings: after a blow, and in the run-up with its own small unbalance.

The source prints three numbers of both tests: 9.6 Hz and 2.8 1/s after a blow at rest, and the greatest deflection of the run-up
at t = 70 s and 10.7 Hz. The curves of its pictures are lost, so the picture here has that point in place of a measured
curve. Blow and own unbalance are not printed and were chosen, within what "negligible" beside 594 g mm allows; the rubber was
fitted to these frequencies on the planar sample and moved to the bushings as it is. The run-up with one stiffness for all
amplitudes is that of figure 6.11, whose passage misses.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.reduced_rotor import spatial_parts
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.plots.style import BALLS, CRITICAL, INK, look, picture, save_picture
from reproductions import Found, compared_all, said
from reproductions.spannan2021.figure_6_12 import HERTZ, JUMP, RATE, START, run_up_and_down, seen_by_laser
from reproductions.spannan2021.softening_rubber import BLOW, DECAY, FREQUENCY, NOT_PRINTED, PASSAGE, frequency_and_decay

SEEN = 70.0  # s
OWN = (20e-6, 30e-6, 40e-6)  # kg m, not printed
MIDDLE = 30e-6
END = 100.0  # s, of the picture


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Frequency and decay after a blow, the passage of the run-up, and the steady resonance before it."""
    runs = {own: run_up_and_down(own_unbalance(own)) for own in OWN}
    passages = {own: passage(run) for own, run in runs.items()}
    draw(runs, out)
    steady = ab.rotor.response_peaks(own_unbalance(MIDDLE), "8 Hz", "12 Hz")
    peak = float(steady["peak_speed"][int(steady["peak_amplitude"].values.argmax())]) / HERTZ
    frequency, decay = frequency_and_decay(after_a_blow())
    on = "rig of bodies on softening bushings"
    rows = [
        Found("fitted", f"frequency after a blow of 0.4 N s, {on}", "Hz", FREQUENCY, frequency, 0.1, NOT_PRINTED, "6.9"),
        Found("fitted", f"decay of the first second after it, {on}", "1/s", DECAY, decay, 0.3, NOT_PRINTED, "6.9"),
        *(
            Found("fitted", f"speed of the greatest deflection, own unbalance of {1e6 * own:g} g mm, {on}", "Hz", PASSAGE,
                  found, 0.2, NOT_PRINTED)
            for own, found in passages.items()
        ),
        said("the resonance itself lies below the speed of the greatest deflection, and below 10.7 Hz",
             peak < min(passages[MIDDLE], PASSAGE)),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "6.10", rows)


def own_unbalance(moment: float, name: str = "discoidal_rig_rubber") -> Machine:
    """The rig without balls, with this unbalance in the plane of the race, kg m."""
    machine = with_value_at(rig(name), "balancers", ())
    return with_value_at(machine, "unbalances", [{"moment": moment, "station": "race"}])


def passage(run: xr.Dataset) -> float:
    """Speed at which the deflection is greatest in the run-up, Hz."""
    size, time = seen_by_laser(run)[0], run["time"].values
    return float(run["speed"][int(np.argmax(size * (time < END)))]) / HERTZ


def after_a_blow() -> xr.Dataset:
    """Two seconds after a radial blow at the race of the rig at rest."""
    still = with_value_at(own_unbalance(MIDDLE), "unbalances", ())
    still = with_value_at(still, "drive", {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}})
    still = with_value_at(still, "start", {"velocity": [BLOW / mass_at_the_race(still), 0.0]})
    return ab.simulate(still, duration=2.0, save=ab.Samples(4001))


def mass_at_the_race(machine: Machine) -> float:
    """Impulse over the velocity that it gives the race, which is the reference station, kg."""
    return float(1.0 / np.linalg.inv(spatial_parts(machine, ()).mass)[0, 0])


def curve(axes: Axes, run: xr.Dataset, **look: Any) -> None:
    """Deflection of the run-up."""
    part = run["time"].values < END
    axes.plot(run["time"][part], 1e6 * seen_by_laser(run)[0][part], **look)


def draw(runs: dict[float, xr.Dataset], out: Path) -> None:
    """Deflection over time for each own unbalance and for linear rubber, with what is known of the measurement."""
    linear = run_up_and_down(own_unbalance(MIDDLE, "discoidal_rig"))
    with look():
        figure = picture(7.6, 4.2)
        axes = figure.subplots()
        for (own, run), color in zip(runs.items(), BALLS, strict=False):
            curve(axes, run, color=color, label=f"softening rubber, {1e6 * own:g} g mm")
        curve(axes, linear, color=INK, lw=0.9, label=f"one stiffness for all amplitudes, {1e6 * MIDDLE:g} g mm")
        axes.axvline(SEEN, color=CRITICAL, ls=(0, (5, 3)), label="measured: greatest deflection at 70 s, 10.7 Hz")
        axes.set(xlabel="time (s)", ylabel="deflection at the laser (µm)", xlim=(15.0, END), ylim=(0.0, None))
        first = (JUMP - RATE * START) / HERTZ
        other = axes.secondary_xaxis(
            "top",
            functions=(
                lambda t: first + RATE / HERTZ * np.asarray(t),
                lambda f: (np.asarray(f) - first) * HERTZ / RATE,
            ),
        )
        other.set_xlabel("rotor speed (Hz)")
        axes.set_title("Spannan 2021, figure 6.10: own unbalance; its measured curves are lost", pad=38.0)
        axes.legend(loc="upper left")
        save_picture(figure, out / "figure_6_10.png")

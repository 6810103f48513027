"""The four-run method of section 4 from signals: accelerometers on both bearing housings at 4000 rpm, no tacho.

Each of the four runs of the rig without balls is simulated and its noisy signals are recorded. Their mean is the motion of the
disk, which is midway; the amplitude is that of the strongest line of its spectrum, in which there is no phase. Four such
numbers give the unbalance. It is compared with four amplitudes of the steady motion without noise, since both see the
misalignment of the rig as unbalance, and what is left with the words of the source.
"""

from __future__ import annotations

import cmath
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine, Unbalance
from autobalancer.measure import BalanceRun, Reading, TrialMass, four_run
from autobalancer.plots.style import save_picture
from reproductions import Found, compared_all, said
from reproductions.rodrigues2011.balls import without_balls
from reproductions.rodrigues2011.four_run import LEFT, PLACES, SPEED, WASHER

HOUSINGS = ("B1", "B2")
NOISE = 0.1  # m/s^2, a hundredth of the vibration, in each sample
RATE, KEPT = "2 kHz", 2000.0  # of the logger; samples of a run per second
SETTLED, END = 2.0, 3.0  # s


def reproduce(out: Path) -> list[dict[str, Any]]:
    """What the signals give, and what would be left of the unbalance."""
    machine = with_value_at(without_balls(rig("rodrigues_rig")), "drive", {
        "kind": "speed", "profile": {"kind": "constant", "speed": SPEED}})  # fmt: skip
    signals = [measured(with_washer(machine, place)) for place in PLACES]
    exact = [Reading(steady(with_washer(machine, place))) for place in PLACES]
    found, true = (four_run(as_runs(readings)) for readings in (signals, exact))
    save_picture(ab.plot.answer(found), out / "four_runs_from_signals.png")
    seen, target = correction(found), correction(true)
    own = complex(machine.unbalances[0].vector)
    left = abs(own + seen)
    off = np.degrees(cmath.phase(seen / target))
    rows = [
        said(f"unbalance left by the four-run method from signals, {1e6 * left:.2g} g mm, is below 6 g mm", left < LEFT),
        Found("internal", "correction by four runs, from signals against steady amplitudes", "g mm", 1e6 * abs(target),
              1e6 * abs(seen), 0.03e6 * abs(target)),
        Found("internal", "direction of the correction by four runs, from signals against steady amplitudes", "deg",
              0.0, off, 2.0),
    ]  # fmt: skip
    return compared_all("Rodrigues 2011", "section 4", rows)


def with_washer(machine: Machine, place: float | None) -> Machine:
    """The rig with a washer on a screw (deg), or without one."""
    if place is None:
        return machine
    washer = Unbalance(moment=WASHER, angle=np.radians(place), station="disk")
    return with_value_at(machine, "unbalances", (*machine.unbalances, washer))


def measured(machine: Machine) -> Reading:
    """Amplitude of the disk by the sensors on the housings and its standard deviation, m/s^2."""
    run = ab.simulate(machine, duration=END, save=ab.Samples(round(KEPT * END) + 1))
    sensors = [ab.measure.Sensor("acceleration", place, noise=NOISE, name=place) for place in HOUSINGS]
    signals = ab.measure.record(run, sensors, RATE, start=SETTLED, seed=len(machine.unbalances))
    mean = 0.5 * sum(signals[place].values for place in HOUSINGS)
    disk = ab.measure.signals(signals["time"].values, {"disk": ab.measure.Channel(mean, "acceleration", "disk", "x")})
    lines: xr.Dataset = ab.measure.spectrum(disk, resolution="2 Hz")
    strongest = lines.isel(line=int(np.argmax(lines["line_amplitude"].values)))
    size, sure = (float(strongest[f"line_amplitude{end}"]) for end in ("", "_deviation"))
    return Reading(size, amplitude_deviation=sure)


def steady(machine: Machine) -> float:
    """Amplitude of the disk in its steady motion, m/s^2."""
    seen = ab.rotor.response(machine, [SPEED], ["disk"], machine.unbalances).isel(speed=0, station=0)
    return SPEED**2 * abs(complex(float(seen.x_real), float(seen.x_imag)))


def as_runs(readings: list[Reading]) -> list[BalanceRun]:
    """The four runs with what was read."""
    return [
        BalanceRun("original" if place is None else f"washer at {place:g} deg", [reading],
                   [] if place is None else [TrialMass("disk", f"{WASHER} kg*m", f"{place} deg")])
        for place, reading in zip(PLACES, readings, strict=True)
    ]  # fmt: skip


def correction(found: xr.Dataset) -> complex:
    """As four runs say, kg m."""
    return cmath.rect(float(found["correction"][0, 0]), float(found["correction_angle"][0, 0]))

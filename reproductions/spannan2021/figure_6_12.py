"""Figure 6.12: run-up and run-down of the discoidal rig with 594 g mm, without balls.

Speed curve of the test: 12.7 rad/s in the first 5 s, then 0.837 rad/s^2 to 1200 rpm at 140 s, run-down from 145 s. How it
slowed down is not printed; the speed at the ends of the range of phases, 57 s and 170 s, is taken as equal. Deflections of
the figure are lost with it; what the text says of the phase is compared. The 70 s of the passage that the source prints belong to
figure 6.10, a run-up without the 594 g mm.

The rubber of the rig has one stiffness and damping; that of the source was tabled, stiff in small motion below the resonance
and, raised to meet measured deflections, above 15 Hz. So the rig passes its resonance earlier, and its second mode with
its viscous damping pulls the lag away from 180 degrees. Rows of *tabled rubber* have what the text of the source says
of its tables: shear 39 % stiffer than at the resonance below 5 Hz and above 15 Hz (the static stiffness of table 6.4
asks for that), and a loss factor that does not change with frequency; these tables were made to fit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.parameters import with_value_at
from autobalancer.files.rigs import rig
from autobalancer.machine import Machine
from autobalancer.plots.drawing.save import save_picture
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, look, picture
from reproductions import Found, compared_all, said

NOMINAL = 1200.0 * np.pi / 30.0
JUMP, RATE = 12.7, 0.837  # rad/s and rad/s^2
START, REACHED, DOWN = 5.0, 140.0, 145.0  # s
SEEN, UNSEEN = 57.0, 170.0  # s, between which the phase is measured
HERTZ = 2.0 * np.pi
LASER = "laser"
FREQUENCIES = (0.0, 5.0, 9.6, 12.0, 15.0, 21.0)  # Hz
RESONANCE, STIFFER = 9.6, 1.39


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Phase, for both kinds of rubber, and the picture of the figure."""
    machine = with_value_at(rig("discoidal_rig"), "balancers", ())
    rows = []
    for rubber, model, kind, note in (
        (
            "constant rubber",
            machine,
            "words",
            "stiffness and damping of the rubber are tabled in the source, the tables lost",
        ),
        ("tabled rubber", tabled(machine), "fitted", ""),
    ):
        run = run_up_and_down(model)
        time = run["time"].values
        size, lag = seen_by_laser(run)
        steady = (time > 100.0) & (time < DOWN)
        below = max(at(time, lag, SEEN), at(time, lag, UNSEEN)) < 90.0
        rows += [
            Found(kind, f"mean lag from 100 s to 145 s, {rubber}", "deg", 180.0, lag[steady].mean(), 10.0, note),
            Found(kind, f"lag at 1200 rpm, {rubber}", "deg", 180.0, at(time, lag, DOWN), 10.0, note),
            said(f"lag below 90 deg at 57 s and 170 s, {rubber}", below),
        ]
        draw(run, size, lag, rubber, out)
    return compared_all("Spannan 2021", "6.12", rows)


def run_up_and_down(machine: Machine) -> xr.Dataset:
    """Run-up and run-down with the speed curve of the test."""
    at_seen = JUMP + RATE * (SEEN - START)
    rest = DOWN + (UNSEEN - DOWN) * NOMINAL / (NOMINAL - at_seen)
    table = {"time": [0.0, START, REACHED, DOWN, rest], "speed": [0.0, JUMP, NOMINAL, NOMINAL, 0.0]}
    machine = with_value_at(machine, "drive.profile", {"kind": "table", **table})
    return ab.simulate(machine, duration=rest, save=ab.Samples(round(rest * 200.0)))


def tabled(machine: Machine) -> Machine:
    """The rig on rubber with tables of stiffness and a constant loss factor."""
    bushing = machine.rotor.joints[5]
    changes: dict[str, object] = {}
    for name, factor in (("shear", np.array([STIFFER, STIFFER, 1.0, 1.0, STIFFER, STIFFER])), ("axial", np.ones(6))):
        k, c = (float(getattr(bushing, f"{name}_{what}")) for what in ("stiffness", "damping"))
        damping = c * factor * RESONANCE / np.maximum(FREQUENCIES, FREQUENCIES[1])
        changes[f"{name}_table"] = {
            "speed": [f"{f} Hz" for f in FREQUENCIES],
            "stiffness": (k * factor).tolist(),
            "damping": damping.tolist(),
        }
    kept = {key: value for key, value in bushing.model_dump().items() if key.split("_")[0] not in ("shear", "axial")}
    return with_value_at(machine, "rotor.joints[6]", kept | changes)


def seen_by_laser(run: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Deflection at the station of the laser, m, and its angle of lag behind the unbalance, degrees."""
    there = run.sel(station=LASER)
    z = there["station_x"].values + 1j * there["station_y"].values
    ahead = np.exp(1j * (run["rotor_angle"].values + run["unbalance_angle_in_rotor"].values))
    return np.abs(z), np.degrees(np.angle(ahead * z.conj())) % 360.0


def at(time: np.ndarray, values: np.ndarray, when: float) -> float:
    """The value at a time."""
    return float(np.interp(when, time, values))


def draw(run: xr.Dataset, size: np.ndarray, lag: np.ndarray, rubber: str, out: Path) -> None:
    """Deflection along x with its envelope, speed, angle of lag."""
    time = run["time"].values
    with look():
        figure = picture(7.6, 6.0)
        above, below = figure.subplots(2, 1, sharex=True)
        above.plot(time, 1e3 * run.sel(station=LASER)["station_x"], color=BALLS[0], lw=0.2)
        above.plot(time, 1e3 * size, color=INK, lw=1.0, label="envelope")
        above.plot(time, -1e3 * size, color=INK, lw=1.0)
        above.set(ylabel="deflection at the laser (mm)", title=f"Spannan 2021, figure 6.12: {rubber}")
        other = above.twinx()
        other.plot(time, run["speed"].values / HERTZ, color=CRITICAL, ls=(0, (5, 3)), label="speed")
        other.set(ylabel="rotor speed (Hz)", ylim=(0.0, 22.0))
        part = (time >= SEEN) & (time <= UNSEEN)
        below.plot(time[part], lag[part], color=BALLS[1])
        below.axhline(180.0, color=CRITICAL, lw=0.8)
        below.set(xlabel="time (s)", ylabel="angle of lag (deg)", ylim=(0.0, 210.0), yticks=[0, 45, 90, 135, 180])
        save_picture(figure, out / f"figure_6_12_{rubber.replace(' ', '_')}.png")

"""Figure 6.22: two balls in 0.65 mm^2/s oil, the speed stepped upwards by 1 Hz, each held for 70 s.

Measured on the discoidal rig: a line at 53 rad/s from 57.5 to 64 rad/s, which are the middles of the steps from 520 to 580 and
from 580 to 640 rpm; above it, it vanishes and the synchronous vibration falls. Done here in the same way with the drag law (6.9),
repaired: the speeds are 460 to 700 rpm, and the line is the speed in space of the slowest ball over the last 10 s of each, where
it differs from that of the rotor by more than the resolution of such a record. Rolling resistance is not known; those above zero
were chosen after seeing. On linear rubber the line is near the natural frequency of the stand-in of table 6.4, 60 rad/s, so it is
missed with any rolling resistance. Rubber that softens with the amplitude, fitted to this line among others, meets it: on the
stand-in, and on the rig of bodies and bushings with guided balls and with balls resolved in contact.

Of the rig there is also the spectrum of the acceleration of the lid, where the sensor of the source was.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.machine import Rubber
from autobalancer.plots.style import BALLS, CRITICAL, look, picture, save_picture
from reproductions import Found, Kind, compared_all, said
from reproductions.spannan2021._five_speeds import (
    HELD,
    LINE,
    LINE_WITHIN,
    ONSET,
    RECORD,
    RELEASE,
    SPEEDS,
    STARTS,
    STEP,
    lines,
    onset_and_release,
    profile,
    slowest,
    soft_rubber,
)
from reproductions.spannan2021._rig_on_rubber import on_the_rig
from reproductions.spannan2021.figure_6_24 import HALF_STEP, RUBBER

ROLLING = 0.001
RATE = 80.0  # samples per second
LID = "accelerometer"
RIGS = {"guided": "rig of bodies, guided balls, 0.001", "resolved": "rig of bodies, resolved balls, 0.001"}


def stand_ins() -> dict[str, tuple[float, Rubber | None, Kind]]:
    """Rolling resistance, rubber and kind of the rows of each case on the planar stand-in."""
    return {
        "linear rubber, no rolling resistance": (0.0, None, "excluded model"),
        "linear rubber, 0.002": (0.002, None, "fitted"),
        "softening rubber, 0.001": (0.001, soft_rubber(), "fitted"),
    }


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Onset, release and line of each case, the lines over the speed, and the spectra of the lid."""
    rows, found = [], {}
    for name, (rolling, rubber, kind) in stand_ins().items():
        found[name] = lines(rolling, rubber=rubber)
        rows += three(name, found[name], kind) if rubber else [onset_of(name, found[name], kind)]
    rows += linear(np.array([line for name, line in found.items() if "linear" in name]))
    runs = {balls: stepped_on_the_rig(balls == "resolved") for balls in RIGS}
    for balls, run in runs.items():
        found[RIGS[balls]] = slowest(run)
        rows += three(RIGS[balls], found[RIGS[balls]], "fitted")
        size = synchronous(run)
        rows.append(said(f"synchronous vibration of the lid is less at 640 and 700 rpm than at 580, {RIGS[balls]}",
                         bool((size[3:] < size[2]).all())))  # fmt: skip
    apart = float(np.abs(found[RIGS["resolved"]] - found[RIGS["guided"]]).max())
    rows.append(
        Found(
            "internal",
            "speeds of the slowest ball, resolved against guided, farthest of five",
            "rad/s",
            0.0,
            apart,
            0.1,
        )
    )
    draw(found, out)
    draw_spectra(runs, out)
    return compared_all("Spannan 2021", "6.22", rows)


def onset_of(name: str, line: np.ndarray, kind: Kind) -> Found:
    """Where the line begins."""
    note = RUBBER if kind == "excluded model" else ""
    onset, _ = onset_and_release(line)
    return Found(kind, f"onset of the line, stepping upwards, {name}", "rad/s", ONSET, onset, HALF_STEP, note)


def three(name: str, line: np.ndarray, kind: Kind) -> list[Found]:
    """The three numbers that the source prints."""
    at = f"stepping upwards, {name}"
    return [
        onset_of(name, line, kind),
        Found(kind, f"line at 580 rpm, {at}", "rad/s", LINE, line[2], LINE_WITHIN),
        Found(kind, f"release, {at}", "rad/s", RELEASE, onset_and_release(line)[1], HALF_STEP),
    ]


def linear(lines: np.ndarray) -> list[Found]:
    """Line and release on linear rubber, each of the rolling resistance that comes nearest."""
    line, release = (
        min(values, key=lambda value, target=target: abs(value - target))
        for values, target in ((lines[:, 2], LINE), ([onset_and_release(each)[1] for each in lines], RELEASE))
    )
    at = "linear rubber, nearest of rolling resistances 0 and 0.002"
    return [
        Found("excluded model", f"line at 580 rpm, {at}", "rad/s", LINE, line, LINE_WITHIN, RUBBER),
        Found("excluded model", f"release, {at}", "rad/s", RELEASE, release, HALF_STEP, RUBBER),
    ]


def stepped_on_the_rig(resolved: bool) -> xr.Dataset:
    """A run through all speeds."""
    machine = on_the_rig(profile(), ROLLING, resolved=resolved, start=STARTS[0])
    end = float(profile()["time"][-1])
    return ab.simulate(machine, duration=end, save=ab.Samples(round(RATE * end) + 1), tolerance=1e-7)


def spectra(run: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequency (rad/s) and RMS amplitude of the acceleration of the lid (m/s^2), one row for each speed."""
    count, time = round(RATE * RECORD), run["time"].values
    x = run.sel(station=LID)["station_x"].values
    frequency = 2.0 * np.pi * np.fft.rfftfreq(count, 1.0 / RATE)
    ends = [round(RATE * (number * (HELD + STEP) - STEP)) for number in range(1, SPEEDS.size + 1)]
    assert abs(time[ends[0]] - HELD) < 1e-6
    window = np.hanning(count)
    records = np.array([x[end - count : end] for end in ends])
    size = np.abs(np.fft.rfft((records - records.mean(axis=1, keepdims=True)) * window)) * 2.0 / window.sum()
    return frequency, size * frequency**2 / np.sqrt(2.0)


def synchronous(run: xr.Dataset) -> np.ndarray:
    """RMS amplitude of the acceleration of the lid at the speed of the rotor, for each speed, m/s^2."""
    frequency, size = spectra(run)
    return np.array([row[np.abs(frequency - speed) < 1.0].max() for row, speed in zip(size, SPEEDS, strict=True)])


def draw(found: dict[str, np.ndarray], out: Path) -> None:
    """Lines over the rotor speed."""
    with look():
        figure = picture(6.8, 4.6)
        axes = figure.subplots()
        axes.plot(SPEEDS, SPEEDS, color=CRITICAL, lw=0.9, ls="--", label="rotor speed")
        axes.hlines(LINE, ONSET, RELEASE, color="black", lw=3.0, label="measured line")
        for (name, line), color, mark in zip(found.items(), BALLS, "osDvx", strict=False):
            axes.plot(SPEEDS, line, f"{mark}-", ms=6, mfc="none", color=color, label=name)
        axes.set(xlabel="rotor speed (rad/s)", ylabel="speed of the slowest ball in space (rad/s)")
        axes.set_title("Spannan 2021, figure 6.22: speed stepped upwards by 1 Hz")
        axes.legend(loc="upper left")
        save_picture(figure, out / "figure_6_22.png")


def draw_spectra(runs: dict[str, xr.Dataset], out: Path) -> None:
    """RMS acceleration of the lid over the frequency, one line for each speed, one panel for each kind of balls."""
    with look():
        figure = picture(7.6, 4.4)
        panels = figure.subplots(1, len(runs), sharex=True, sharey=True)
        top = max(float(spectra(run)[1].max()) for run in runs.values())
        for panel, (balls, run) in zip(panels, runs.items(), strict=True):
            frequency, size = spectra(run)
            near = (frequency > 42.0) & (frequency < 80.0)
            for number, (speed, row) in enumerate(zip(SPEEDS, size, strict=True)):
                panel.plot(frequency[near], speed + 5.5 * row[near] / top, color=BALLS[0], lw=1.1)
                mark = {"label": "rotor speed"} if number == 0 else {}
                panel.plot(speed, speed - 0.7, "^", color=CRITICAL, ms=4, ls="none", **mark)
            panel.plot(
                [LINE, LINE], [ONSET, RELEASE], color="black", lw=3.0, alpha=0.35, zorder=1, label="measured line"
            )
            panel.set(xlabel="frequency (rad/s)", title=f"{balls} balls")
        panels[0].set(ylabel="rotor speed (rad/s)")
        panels[0].legend(loc="lower right")
        figure.suptitle(f"Figure 6.22 on the rig: acceleration of the lid, highest peak {top:.2f} m/s² RMS")
        save_picture(figure, out / "figure_6_22_spectra.png")

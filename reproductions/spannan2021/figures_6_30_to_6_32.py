"""Figures 6.30 to 6.32: blows on the CFRP rotor, at rest and at 15 rad/s, seen at the sleeve of its dampers.

Figure 6.30 is a photograph; here it is a drawing of where the blows fall. The source hits the rotor at its widest point, and its
lower bearing; the height of the first is not printed, so the blow goes to the mass center, the second to the clamp of the shaft.
Blow and length of the records are not printed either: 10 ms, 2 s at rest, chosen after seeing that in long records the first
natural frequency, which decays more slowly, is as high as the second after a blow on the bearing. The rig of the catalog was
fitted to the simulated frequencies of table 6.5, from which the measured ones deviate by up to 6 %, not to measured spectra. At
15 rad/s the source has one sensor; here spectra of x + iy tell backward from forward whirl, and the spectrogram is that of x.

Balls are in at 15 rad/s: two of 4.4 g in 10 mm^2/s oil, guided, and resolved, which lie on the floor of the annulus at this
speed: friction of 0.1 carries them from 36.5 rad/s on. Number of balls, oil and unbalance are not printed.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.signal import ShortTimeFFT
from scipy.signal.windows import hann

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.plots.style import BALLS, CRITICAL, INK, UNBALANCE, look, picture, save_picture
from autobalancer.rotordynamics.campbell import modes
from reproductions import Found, compared_all, said

WIDEST, CLAMP = 0.2312, 0.0  # m from the clamp: mass center, and lower bearing
PLACES = {"a": ("widest point", WIDEST, 3.4), "b": ("lower bearing", CLAMP, 21.2)}  # with the measured peak, Hz
SPEED, WHIRLS = 15.0, {"backward": 3.25, "forward": 3.96}  # rad/s, measured, Hz
BLOWS, RECORD, END = (5.0, 17.0, 29.0, 41.0, 53.0), 10.0, 65.0  # s
RATE = 500  # samples per second
AS_MEASURED = 0.07
FLOOR = {
    "stiffness": 3e4, "restitution": 0.3, "sliding_friction": 0.1, "floor_friction": 0.15, "slip_speed": 0.02, "rest_speed": 1e-3,
}  # fmt: skip
HERTZ = 2.0 * math.pi


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Peaks and decay at rest, whirl at 15 rad/s without balls, with guided and with resolved ones."""
    rest = {name: struck(blown(still(), place, (0.1,)), 2.1) for name, (_, place, _) in PLACES.items()}
    rows: list[Found] = []
    for name, (where, _, target) in PLACES.items():
        low, high = peaks(rest[name])
        first = name == "a"
        kind, which, asked = ("words", "first", low) if first else ("fitted", "second", high)
        rows += [
            Found("printed", f"peak of a blow at rest, {where}", "Hz", target, asked[0], AS_MEASURED * target, figure="6.31"),
            Found(kind, f"the {which} natural frequency dominates, {where} (1 = true)", "1", 1.0,
                  float((low[1] > high[1]) == first), 0.0, figure="6.31"),
        ]  # fmt: skip
    rows += [*damping_rows(), *turning(out)]
    draw_places(out)
    draw_spectra(rest, out)
    return compared_all("Spannan 2021", "6.32", rows)


def still(dampers: bool = True) -> Machine:
    """The rig at rest, without balls and unbalance."""
    machine = with_value_at(with_value_at(rig("cfrp_rig"), "balancers", ()), "unbalances", ())
    if not dampers:
        machine = with_value_at(machine, "rotor.supports", machine.rotor.supports[:1])
    return with_value_at(machine, "drive.profile", {"kind": "constant", "speed": 0.0})


def blown(machine: Machine, place: float, times: tuple[float, ...]) -> Machine:
    """The machine with blows of 0.64 N s along x."""
    shape = [0.0, 60.0, 100.0, 100.0, 60.0, 0.0]
    blows = [
        {"kind": "recorded_force", "station": place, "time": [t + 2e-3 * k for k in range(6)], "force": shape}
        for t in times
    ]
    return with_value_at(machine, "excitations", blows)


def struck(machine: Machine, end: float) -> xr.Dataset:
    """A run, sampled."""
    return ab.simulate(machine, duration=end, save=ab.Samples(round(RATE * end) + 1))


def at_sleeve(run: xr.Dataset) -> np.ndarray:
    """x + iy of the sleeve, m."""
    there = run.sel(station="sleeve")
    return np.asarray(there["station_x"].values + 1j * there["station_y"].values)


def spectrum(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (Hz) and size of the spectrum of a record that decays, with the second half of a Hann window; by frequency."""
    window = hann(2 * z.size)[z.size :]
    size = np.abs(np.fft.fft(z * window, 2**16)) / window.sum()
    frequency = np.fft.fftfreq(2**16, 1.0 / RATE)
    order = np.argsort(frequency)
    return frequency[order], size[order]


def peaks(run: xr.Dataset) -> tuple[tuple[float, float], tuple[float, float]]:
    """Frequency (Hz) and height of the peaks of x near the first and the second natural frequency."""
    frequency, size = spectrum(at_sleeve(run)[round(0.11 * RATE) :].real)
    first, second = (highest(frequency, size, *band) for band in ((2.0, 8.0), (15.0, 35.0)))
    return first, second


def highest(frequency: np.ndarray, size: np.ndarray, low: float, high: float) -> tuple[float, float]:
    """Frequency and height of the highest peak in a band."""
    inside = np.flatnonzero((frequency > low) & (frequency < high))
    top = int(inside[size[inside].argmax()])
    return float(frequency[top]), float(size[top])


def damping_rows() -> list[Found]:
    """Damping ratio by decay with and without the piston dampers, which table 6.6 has, and their effect on the frequencies."""
    rows = []
    for name, dampers, ratio in (("with", True, 12.8), ("without", False, 0.7)):
        target = 50.0 * ratio / math.sqrt(2543.0 * 5.573)
        run = struck(blown(still(dampers), WIDEST, (0.1,)), 4.1)
        size = np.abs(at_sleeve(run).real[round(0.6 * RATE) :])
        tops = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
        decay = -float(np.polyfit(tops / RATE, np.log(size[tops]), 1)[0])
        found = 100.0 * decay / (math.pi * (tops.size - 1) / ((tops[-1] - tops[0]) / RATE))
        rows.append(
            Found(
                "fitted",
                f"damping ratio by decay, {name} piston dampers",
                "%",
                target,
                found,
                0.05 * target,
                figure="6.31",
            )
        )
    # the dampers are the only difference
    free, damped = (modes(still(dampers), 0.0, balls=False, modes=4)["frequency"].values for dampers in (False, True))
    change = 100.0 * float(np.abs(damped / free - 1.0).max())
    return [*rows, said("the piston dampers change both frequencies by less than 2 %", change < 2.0, figure="6.31")]


def turning(out: Path) -> list[Found]:
    """Whirl at 15 rad/s without balls, with guided and with resolved ones, and the spectrogram with the guided ones."""
    machine = with_value_at(rig("cfrp_rig"), "drive.profile", {"kind": "constant", "speed": SPEED})
    race = machine.balancers[0].races[0]
    resolved = with_value_at(machine, "balancers[1].races[1].resolved", FLOOR)
    found, rows = {}, []
    for name, given, blows, end in (
        ("no balls", with_value_at(machine, "balancers", ()), BLOWS[:1], BLOWS[0] + RECORD),
        ("guided", machine, BLOWS, END),
        ("resolved", resolved, BLOWS[:1], BLOWS[0] + RECORD),
    ):
        run = struck(blown(given, WIDEST, blows), end)
        found[name] = whirl(run)
        if name == "guided":
            draw_spectrogram(run, out)
            line = synchronous(run)
        if name == "resolved":
            floor = float(run["ball_floor_force"].values[-RATE:].mean()) / (
                float(run["ball_moment"][0]) / float(race.orbit_radius) * 9.80665
            )
    for way, target in WHIRLS.items():
        rows.append(Found("printed", f"{way} whirl at 15 rad/s after blows, two guided balls", "Hz", target, found["guided"][way],
                          AS_MEASURED * target))  # fmt: skip
    for name in ("guided", "resolved"):
        change = max(abs(100.0 * (found[name][way] / found["no balls"][way] - 1.0)) for way in WHIRLS)
        rows.append(
            Found("internal", f"whirl frequencies, two {name} balls against none, farthest", "%", 0.0, change, 1.0)
        )
    rows.append(said("between blows the strongest line is synchronous, guided balls and 300 g mm", line))
    rows.append(Found("internal", "share of their weight that the floor carries at 15 rad/s, resolved balls", "1",
                      1.0 - 0.1 * SPEED**2 * float(race.orbit_radius) / 9.80665, floor, 0.02))  # fmt: skip
    return rows


def whirl(run: xr.Dataset) -> dict[str, float]:
    """Peaks of backward and forward whirl after the first blow, Hz."""
    time = run["time"].values
    part = (time > BLOWS[0] + 0.01) & (time < BLOWS[0] + RECORD)
    frequency, size = spectrum(at_sleeve(run)[part])
    return {"backward": highest(-frequency, size, 2.6, 6.0)[0], "forward": highest(frequency, size, 2.9, 6.0)[0]}


def synchronous(run: xr.Dataset) -> bool:
    """Whether the highest peak of the last 3 s before blows is at the speed of the rotor."""
    time, x = run["time"].values, at_sleeve(run).real
    spectra = [spectrum(x[(time > blow - 3.0) & (time < blow)]) for blow in BLOWS[1:]]
    total = np.sum([size for _, size in spectra], axis=0)
    return abs(highest(spectra[0][0], total, 0.5, 40.0)[0] - SPEED / HERTZ) < 0.2


def draw_places(out: Path) -> None:
    """In place of the photograph: where the rig is hit and seen, and the shapes of its first two modes."""
    shapes = modes(still(), 0.0, balls=False, modes=4)
    with look():
        figure = picture(6.4, 4.6)
        axes = figure.subplots()
        place = 1e3 * shapes["place"].values
        for mode, color, name in ((0, BALLS[0], "first mode"), (2, BALLS[1], "second mode")):
            line = shapes["x_real"].values[mode] + 1j * shapes["x_imag"].values[mode]
            line = (line * np.exp(-1j * np.angle(line[np.argmax(np.abs(line))]))).real
            axes.plot(
                line / np.abs(line).max(),
                place,
                color=color,
                label=f"{name}, {shapes['frequency'].values[mode] / HERTZ:.1f} Hz",
            )
        axes.axvline(0.0, color=CRITICAL, lw=0.8)
        for where, at, _ in PLACES.values():
            axes.annotate(f"blow, {where}", (0.0, 1e3 * at), (-1.05, 1e3 * at), va="center", color=UNBALANCE,
                          arrowprops={"arrowstyle": "->", "color": UNBALANCE})  # fmt: skip
        for name, at in (("sleeve: dampers and sensor", 165.5), ("annulus", 275.72)):
            axes.plot(0.0, at, "o", color=INK, mfc="none")
            axes.annotate(name, (0.0, at), (-0.06, at), va="center", ha="right")
        axes.set(xlabel="deflection of the mode", ylabel="below the clamp (mm)", ylim=(300.0, -15.0), xlim=(-1.1, 1.1))
        axes.set_title("Spannan 2021, figure 6.30: blows on the CFRP rotor", pad=24)
        figure.legend(loc="outside lower center", ncols=2)
        save_picture(figure, out / "figure_6_30.png")


def draw_spectra(rest: dict[str, xr.Dataset], out: Path) -> None:
    """Figure 6.31: one panel for each blow."""
    with look():
        figure = picture(7.4, 3.8)
        for axes, (name, run) in zip(figure.subplots(1, 2), rest.items(), strict=True):
            frequency, size = spectrum(at_sleeve(run)[round(0.11 * RATE) :].real)
            part = (frequency > 0.5) & (frequency < 30.0)
            axes.plot(frequency[part], size[part] / size[part].max(), color=BALLS[0])
            axes.axvline(PLACES[name][2], color=CRITICAL, ls="--", lw=1.0, label=f"measured, {PLACES[name][2]} Hz")
            axes.set(xlabel="frequency (Hz)", xlim=(0.0, 30.0), ylim=(0.0, 1.3))
            axes.set_title(f"{name}) blow on the {PLACES[name][0]}")
            axes.legend(loc="upper right" if name == "a" else "upper left")
        figure.axes[0].set_ylabel("deflection of the sleeve, over its peak")
        figure.suptitle("Spannan 2021, figure 6.31: CFRP rotor at rest")
        save_picture(figure, out / "figure_6_31.png")


def draw_spectrogram(run: xr.Dataset, out: Path) -> None:
    """Figure 6.32."""
    x = at_sleeve(run).real
    count = 3 * RATE
    spectra = ShortTimeFFT(hann(count), hop=RATE // 5, fs=RATE, mfft=8 * count, scale_to="magnitude")
    size = np.abs(spectra.stft(x))
    time, frequency = spectra.t(x.size), spectra.f
    low = frequency <= 8.0
    with look():
        figure = picture(7.2, 4.2)
        axes = figure.subplots()
        level = 20.0 * np.log10(np.maximum(size[low], 1e-12) / size[low].max())
        mesh = axes.pcolormesh(time, frequency[low], level, vmin=-50.0, vmax=0.0, shading="nearest", rasterized=True)
        for way, target in WHIRLS.items():
            axes.axhline(target, color="white", ls="--", lw=0.9)
            axes.text(
                END - 0.5, target, f"{way}, measured {target} Hz", color="white", ha="right", va="bottom", fontsize=8
            )
        axes.axhline(SPEED / HERTZ, color="white", ls=":", lw=0.9)
        axes.text(END - 0.5, SPEED / HERTZ, "speed", color="white", ha="right", va="top", fontsize=8)
        axes.set(xlabel="time (s)", ylabel="frequency (Hz)", xlim=(0.0, END), ylim=(0.0, 8.0))
        axes.set_title("Spannan 2021, figure 6.32: CFRP rotor at 15 rad/s, hit five times")
        figure.colorbar(mesh, ax=axes, label="deflection of the sleeve (dB)")
        save_picture(figure, out / "figure_6_32.png")

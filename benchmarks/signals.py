"""What is found in measured signals of own run-ups and decays, against what was there; peers are the ways of textbooks."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from scipy.signal import find_peaks

import autobalancer as ab
from autobalancer.measurement.tracking import fitted_orders
from autobalancer.random_numbers import generator

RIG = """name = "discoidal rig without balls"
axis = "vertical"
rotor = {{ mass = "12.27 kg", stiffness = "44.654 kN/m", damping = "68.37 N*s/m" }}
unbalances = [{{ moment = "594 g*mm", angle = "30 deg" }}]
drive = {{ kind = "speed", profile = {{ kind = "ramp", start = "15 rad/s", end = "105 rad/s", duration = "{0} s" }} }}
run = {{ duration = "{0} s" }}
"""
DURATIONS = (20, 30, 60)  # s, of the run-ups: 4.5, 3 and 1.5 rad/s^2
RATE, REVOLUTIONS = 1000.0, 4.0
JUDGED = (25.0, 95.0)  # rad/s; the resonance is at 60.3
RATIO, NATURAL, DECAYS = 0.0461, 60.3, 100


def bench() -> list[dict[str, Any]]:
    """Greatest errors of the order through resonance, and of the damping of noisy decays."""
    ours, window = np.array([tracked(duration) for duration in DURATIONS]).max(axis=0)
    fitted, peaks = np.array([damped(seed) for seed in range(DECAYS)]).T
    note = f"run-ups of {', '.join(map(str, DURATIONS))} s through resonance, 15 to 105 rad/s, displacement and tacho at 1 kHz"
    peer = f"Fourier window of {REVOLUTIONS:g} revolutions with the true angle"
    many = f"greatest of {DECAYS} decays at 40 dB; standard deviation {fitted.std():.2g} % and {peaks.std():.2g} %"
    return [
        row("order_track_amplitude_percent", ours[0], "%", peer, window[0], f"{note}; 0.5 is wanted"),
        row("order_track_phase_deg", ours[1], "deg", peer, window[1], f"{note}; 0.5 is wanted"),
        row(
            "decay_damping_percent",
            float(np.abs(fitted).max()),
            "%",
            "logarithmic decrement of the peaks",
            float(np.abs(peaks).max()),
            f"{many}; 1 is wanted",
        ),
    ]


def row(name: str, error: float, unit: str, peer: str, theirs: float, note: str) -> dict[str, Any]:
    """An error, and by how much that of the peer is larger."""
    note = f"{note}; the peer {theirs:.3g} {unit}"
    return {
        "name": name,
        "value": float(error),
        "unit": unit,
        "peer": peer,
        "ratio": float(theirs / error),
        "note": note,
    }


def tracked(duration: float) -> np.ndarray:
    """Greatest errors of amplitude (%) and phase (deg): of the fit from signals, and of a plain window over the true angle."""
    run = ab.simulate(ab.parse_machine(RIG.format(duration)), save=ab.Samples(400 * int(duration)))
    sensors = [ab.measure.Sensor("displacement", name="x"), ab.measure.Tacho()]
    signals = ab.measure.record(run, sensors, RATE)
    found = ab.measure.orders(signals, revolutions=REVOLUTIONS)
    ours = errors(run, found["time"].values, found.complex_amplitude("x"))
    angle = np.interp(signals["time"].values, run["time"].values, run["rotor_angle"].values)
    centers = np.arange(angle[0] + 4.0 * np.pi, angle[-1] - 4.0 * np.pi, 0.5 * np.pi)
    plain = fitted_orders(angle, signals["x"].values[None], np.ones(1), centers, REVOLUTIONS, degree=0)
    return np.array([ours, errors(run, np.interp(centers, angle, signals["time"].values), plain.amplitude[0, 0])])


def errors(run: xr.Dataset, time: np.ndarray, amplitude: np.ndarray) -> tuple[float, float]:
    """Against the envelope of the run, whose center moves as its real part times e^(i rotor angle)."""
    true = (run["x"].values + 1j * run["y"].values) * np.exp(-1j * run["rotor_angle"].values)
    speed = np.interp(time, run["time"].values, run["speed"].values)
    judged = (speed > JUDGED[0]) & (speed < JUDGED[1])
    at = [np.interp(time[judged], run["time"].values, part) for part in (true.real, true.imag)]
    ratio = amplitude[judged] / (at[0] + 1j * at[1])
    return 100.0 * float(np.abs(np.abs(ratio) - 1.0).max()), float(np.degrees(np.abs(np.angle(ratio)).max()))


def damped(seed: int) -> tuple[float, float]:
    """Errors of the damping of one decay, %: of the fit, and of the line through the logarithms of its peaks."""
    t = np.arange(1500) / RATE
    pole = NATURAL * (-RATIO + 1j * np.sqrt(1.0 - RATIO**2))
    decay = np.exp(pole * t).real + 0.01 / np.sqrt(2.0) * generator(seed).standard_normal(t.size)
    signals = ab.measure.signals(t, {"x": ab.measure.Channel(decay, "displacement")})
    fitted = float(ab.measure.damping(signals)["damping_ratio"][0])
    at, _ = find_peaks(np.abs(decay), height=0.1, distance=int(0.7 * np.pi / NATURAL * RATE))
    slope = np.polyfit(t[at], np.log(np.abs(decay[at])), 1)[0]
    peaks = -slope / np.hypot(slope, pole.imag)
    return 100.0 * (fitted / RATIO - 1.0), 100.0 * (float(peaks) / RATIO - 1.0)

"""Figure 6.23 in kind: a slow run-up and run-down of the discoidal stand-in (table 6.4) with two balls in 0.65 mm^2/s oil.

Two balls of 6.656 g effective mass; drag law (6.9), its cubic branch repaired, and rolling resistances from 0 to 0.015,
which the source does not state. The speed changes by 0.1 rad/s^2 as in the source, with linear drag by 0.5. The balls hang
near the critical speed when a run begins, and are released where they leave it. Measured: subsynchronous vibration from
57.5 to 64 rad/s. The torque balance leaves the unbalance out; close to the critical speed, where the release would be with
a resistance of 0.01, the whirl of the unbalance tears the balls off before.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from scipy.signal import spectrogram

import autobalancer as ab
from autobalancer.laws.drag_coefficient import discoidal
from autobalancer.laws.drag_curve import DragCurve
from autobalancer.laws.stall import StalledBall, planar_receptance, release_speed
from autobalancer.machine import Machine
from autobalancer.plots.save import save_picture
from autobalancer.simulation.sampling import Samples
from reproductions import compared_all
from reproductions.spannan2021.figure_6_24 import (
    BALL,
    CRITICAL,
    DAMPING,
    DENSITY,
    HALF_STEP,
    MASS,
    ORBIT,
    RADIUS,
    STIFFNESS,
    UNBALANCE,
    VISCOSITY,
    drag_of,
)

MEASURED = (57.5, 64.0)
DISPLACED = DENSITY * math.pi / 6.0 * (2.0 * RADIUS) ** 3
RATE, BEFORE, HIGH = 0.1, 4.0, 82.0  # acceleration, start below the release speed, turning point
END = 50.0  # of the run-down


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Release and capture speeds, simulated and by torque balance, and the spectrogram."""
    run = simulated(machine(0.0, "linear", 340.0, 390.0, 0.5))
    rows = [("release, linear drag: simulated against torque balance", balance(0.0, "linear"), released(run), 0.02)]
    for rolling in (0.0, 0.005):
        expected = balance(rolling, "whole")
        run = simulated(machine(rolling, "whole", expected - BEFORE, HIGH, RATE))
        if rolling == 0.0:
            draw(run, out)
        about = f"drag law (6.9), rolling resistance {rolling:g} (assumed)"
        rows += [
            (f"release, {about}: simulated against torque balance", expected, released(run), 0.02),
            (f"release, {about}: simulated against measured", MEASURED[1], released(run), 0.05),
            (f"capture in the run-down, {about}: simulated against measured", MEASURED[0], caught(run), 0.05),
        ]
    expected = balance(0.01, "whole")
    for unbalance, tolerance in ((0.0, 0.02), (UNBALANCE, 0.0)):
        run = simulated(machine(0.01, "whole", expected - 0.7 * BEFORE, HIGH, RATE, unbalance))
        if unbalance == 0.0:
            name = "release, drag law (6.9), rolling resistance 0.01, no unbalance: simulated against torque balance"
            rows.append((name, expected, released(run), tolerance))
            name = (
                "release, drag law (6.9), rolling resistance 0.01 (assumed), no unbalance: simulated against measured"
            )
            rows.append((name, MEASURED[1], released(run), HALF_STEP / MEASURED[1]))
        else:
            name = "rolling resistance 0.01: share of the time at which balls stall, torn off by the unbalance's whirl"
            rows.append((name, 0.0, stalled_share(run), 0.02))
    run = simulated(machine(0.015, "whole", 61.5, HIGH, RATE))
    rows.append(("rolling resistance 0.015: share of the time at which balls stall", 0.0, stalled_share(run), 0.02))
    return compared_all(
        "Spannan 2021",
        "6.23 in kind",
        [
            (name, "rad/s", target, value, tolerance * target) if target else (name, "1", target, value, tolerance)
            for name, target, value, tolerance in rows
        ],
    )


def machine(rolling: float, law: str, low: float, high: float, rate: float, unbalance: float = UNBALANCE) -> Machine:
    """The planar stand-in, whose speed goes up from ``low`` to ``high`` and, with the nonlinear law, down again.

    The balls hang at the critical speed when it starts, and the rotor whirls as they make it.
    """
    times, speeds = [0.0, (high - low) / rate], [low, high]
    if law == "whole":
        times, speeds = [*times, times[1] + (high - END) / rate], [*speeds, END]
    drag = {"law": "discoidal"} if law == "whole" else {"law": "beta", "beta": drag_of(VISCOSITY)}
    race: dict[str, Any] = {
        "orbit_radius": ORBIT,
        "fluid": {"density": DENSITY, "viscosity": VISCOSITY},
        "drag": drag,
        "friction": {"rolling_resistance": rolling},
        "coincidence": True,
        "balls": [
            {
                "count": 2,
                "mass": BALL + DISPLACED,
                "diameter": 2.0 * RADIUS,
                "start_angles": [2.9, 3.2],
                "start_speeds": [CRITICAL - low] * 2,
            }
        ],
    }
    whirl = -1j * 2.0 * BALL * ORBIT * CRITICAL / DAMPING * np.exp(3.05j)
    moving = 1j * CRITICAL * whirl
    return Machine(
        name="Discoidal rotor, table 6.4",
        axis="vertical",
        rotor={"mass": MASS - 2.0 * BALL, "stiffness": STIFFNESS, "damping": DAMPING},
        unbalances=[{"moment": unbalance}],
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "table", "time": times, "speed": speeds}},
        start={"deflection": (whirl.real, whirl.imag), "velocity": (moving.real, moving.imag)},
    )


def simulated(given: Machine) -> xr.Dataset:
    """A run with 40 samples per second."""
    duration = float(given.drive.profile.time[-1])
    return ab.simulate(given, duration=duration, save=Samples(int(40 * duration) + 1), tolerance=1e-7)


def _stalled(run: xr.Dataset) -> np.ndarray:
    """Whether a ball, averaged over two seconds, is nearer to the critical speed than to the rotor's."""
    lag = -run["ball_speed_in_rotor"].values
    mean = np.array([np.convolve(one, np.full(81, 1.0 / 81.0), mode="same") for one in lag.T]).max(axis=0)
    above = run["speed"].values - CRITICAL
    return np.asarray((mean > 0.5 * above) & (above > 0.5))


def released(run: xr.Dataset) -> float:
    """Rotor speed in the run-up at which the last ball leaves the critical speed."""
    speed = run["speed"].values
    up = int(np.argmax(speed))
    hanging = np.flatnonzero(_stalled(run)[: up + 1])
    return float(speed[hanging[-1]]) if hanging.size else math.nan


def caught(run: xr.Dataset) -> float:
    """Rotor speed in the run-down at which a ball falls back to the critical speed; nan if none does."""
    speed = run["speed"].values
    up = int(np.argmax(speed))
    hanging = np.flatnonzero(_stalled(run)[up:])
    return float(speed[up + hanging[0]]) if hanging.size else math.nan


def stalled_share(run: xr.Dataset) -> float:
    """Share of the run after its first five seconds in which a ball stalls."""
    return float(_stalled(run)[200:].mean())


def balance(rolling: float, law: str) -> float:
    """Release speed by the torque balance on both stalled balls, with what the whirl adds to the normal force."""
    curve = DragCurve(discoidal(0.6), DENSITY, VISCOSITY, 2.0 * RADIUS)

    def drag(slip: np.ndarray) -> np.ndarray:
        return curve.torque(slip, ORBIT) if law == "whole" else drag_of(VISCOSITY) * slip

    ball = StalledBall(BALL * ORBIT, 2.0 * BALL * ORBIT, ORBIT, drag, rolling)
    return release_speed(ball, planar_receptance(MASS, STIFFNESS, DAMPING), [CRITICAL])


def draw(run: xr.Dataset, out: Path) -> None:
    """Spectrogram of the place of one ball in space, over time and rotor speed."""
    angle = run["rotor_angle"] + run["ball_angle_in_rotor"][:, 0]
    place = run["x"].values + ORBIT * np.cos(angle.values)
    frequency, time, power = spectrogram(place, fs=40.0, nperseg=512, noverlap=448)
    figure, axes = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    near = (frequency > 6.0) & (frequency < 14.0)
    picture = axes.pcolormesh(
        time, 2.0 * math.pi * frequency[near], 10.0 * np.log10(power[near] + 1e-12), vmin=-80.0, shading="auto"
    )
    axes.plot(run["time"], run["speed"], color="white", lw=0.6, ls="--")
    axes.set(xlabel="time in s", ylabel="frequency in rad/s", title="Place of one ball (Spannan 2021, figure 6.23)")
    figure.colorbar(picture, label="power density in dB")
    save_picture(figure, out / "figure_6_23.png")

"""Section 6.1.7 in closed form: where two balls hang on softening rubber, from where they are released, and the three resonances.

The rubber is that of the sample machine, fitted to the resonances of the rig and to the line of 53 rad/s at 580 rpm; so these
rows are of that kind. Rolling resistance of 0.001 is what runs through the five speeds allow, 0.003 what a slow ramp wants. The
unbalance of 594 g mm, which whirls at another speed, is not in a torque balance.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model, with_ball_mass
from autobalancer.assembly.rotors.equivalent_stiffness import softened
from autobalancer.laws.stall import StalledBall, stall_balance
from autobalancer.machine import Machine
from autobalancer.plots.style import BALLS, CRITICAL, look, picture, save_picture
from autobalancer.stability.stall.borders import whirl_receptance
from reproductions import Found, compared_all
from reproductions.spannan2021._five_speeds import soft_rubber
from reproductions.spannan2021.figure_6_24 import BALL, DENSITY, HALF_STEP, MASS, ORBIT, RADIUS, VISCOSITY

STEP, LINE, RELEASE = 580.0 * math.pi / 30.0, 53.0, 64.0  # rad/s
ROLLING = (0.0, 0.001, 0.002, 0.003)
OWN = 40e-6  # kg m, own unbalance, not printed
RESOLUTION = 0.6  # rad/s, of 10 s
HERTZ = 2.0 * math.pi


def reproduce(out: Path) -> list[dict[str, Any]]:
    """The line at 580 rpm and the release, for rolling resistances, and the resonance with the own unbalance."""
    curves = {rolling: balance(rolling) for rolling in ROLLING}
    draw(curves, out)
    lines = {rolling: float(np.interp(STEP, *first_rise(*curve))) for rolling, curve in curves.items()}
    released = ab.stability.borders(machine(0.003), only=("release speed",))[0].speed
    peak = ab.rotor.response_peaks(machine(0.0), "8 Hz", "12 Hz", unbalance=OWN)
    size = peak["peak_amplitude"].values
    resonance = float(peak["peak_speed"].values[int(size.argmax())]) / HERTZ
    rows = [
        Found("fitted", f"line at 580 rpm, torque balance, rolling resistance {rolling:g}", "rad/s", LINE, line, RESOLUTION,
              "" if abs(line - LINE) <= RESOLUTION else "rolling resistance drags the balls on")
        for rolling, line in lines.items() if rolling in (0.001, 0.003)
    ] + [
        Found("fitted", "release, torque balance, rolling resistance 0.003", "rad/s", RELEASE, released, HALF_STEP),
        Found("fitted", "resonance with 40 g mm, steady; the source says below 10.7 Hz", "Hz", 10.7, resonance, 0.3),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "6.1.7", rows)


def machine(rolling: float) -> Machine:
    """The planar stand-in on softening rubber, with two balls in 0.65 mm^2/s oil."""
    race = {
        "orbit_radius": ORBIT,
        "fluid": {"density": DENSITY, "viscosity": VISCOSITY},
        "drag": {"law": "discoidal"},
        "friction": {"rolling_resistance": rolling},
        "balls": [{"count": 2, "mass": BALL + DENSITY * math.pi / 6.0 * (2.0 * RADIUS) ** 3, "diameter": 2.0 * RADIUS}],
    }
    return Machine(
        name="discoidal rig", axis="vertical", rotor={"mass": MASS, "rubber": soft_rubber()}, balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": STEP}},
    )  # fmt: skip


def balance(rolling: float) -> tuple[np.ndarray, np.ndarray]:
    """Rotor speed that keeps two balls at each whirl speed, and these speeds."""
    one = machine(rolling)
    bare = lateral_model(one)
    soft = softened(one, bare, with_ball_mass(one, bare))
    assert soft is not None
    curve = ab.laws.DragCurve(ab.laws.discoidal(), DENSITY, VISCOSITY, 2.0 * RADIUS)
    ball = StalledBall(BALL * ORBIT, 2.0 * BALL * ORBIT, ORBIT, lambda slip: curve.torque(slip, ORBIT), rolling)
    whirl = np.linspace(40.0, 62.0, 2201)
    found = stall_balance(ball, whirl_receptance(soft, np.ones(1), 2.0 * BALL * ORBIT), whirl)
    return found.speed, whirl


def first_rise(speed: np.ndarray, whirl: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The curve to its highest point, only as far as it rises: what a slow run-up follows."""
    end = int(np.argmax(speed)) + 1
    rises = np.concatenate([[True], np.maximum.accumulate(speed[: end - 1]) < speed[1:end]])
    return speed[:end][rises], whirl[:end][rises]


def draw(curves: dict[float, tuple[np.ndarray, np.ndarray]], out: Path) -> None:
    """Whirl of hanging balls over the rotor speed, with the measured line."""
    with look():
        figure = picture(6.4, 4.0)
        axes = figure.subplots()
        for number, (rolling, (speed, whirl)) in enumerate(curves.items()):
            axes.plot(speed, whirl, color=BALLS[number], label=f"rolling resistance {rolling:g}")
        axes.plot([45.0, 70.0], [45.0, 70.0], color=CRITICAL, lw=0.9, ls="--", label="rotor speed")
        axes.plot(STEP, LINE, "o", color="black", label="measured line")
        axes.set(xlabel="rotor speed (rad/s)", ylabel="balls in space (rad/s)", xlim=(45.0, 72.0), ylim=(44.0, 64.0))
        axes.set_title("Two balls that hang on softening rubber: torque balance")
        axes.legend(loc="upper left")
        save_picture(figure, out / "hanging_balls.png")

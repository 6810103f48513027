"""Figure 6.23 in kind: a slow run-up and run-down of the discoidal stand-in (table 6.4) with two balls in 0.65 mm^2/s oil.

Two balls of 6.656 g effective mass; drag law (6.9), its cubic branch repaired, and rolling resistances from 0 to 0.015,
which the source does not state. The speed changes by 0.1 rad/s^2 as in the source. The balls hang near the critical speed when
a run-up begins, and are released where they leave it. Measured: subsynchronous vibration at 53 rad/s, from 57.5 to 64 rad/s.
The line is at the critical speed of the stand-in (60.3 rad/s) when the balls are released, and lower at lower speeds, where less
drag is to be held; the source gives one number for all speeds. Balls leave the critical speed within seconds. One then goes on
slower than the rotor for some time, since the whirl that both still make brakes it; in the source it does not.

The torque balance leaves the unbalance out and takes the balls to stand in line. So it has a release and a capture: below the
latter, balls in line that turn nearly with the rotor fall back. With linear drag they do so slowly, 4 % late at 0.1 rad/s^2, so
the speed changes by 0.02 rad/s^2 there; by 0.5 at the release. Balls that stand in their balanced places are not braked and hold
out longer in the run-down, but not below where the balanced state loses its stability: these captures are beside the measured
one. Close to the critical speed, where the release would be with a resistance of 0.01, the whirl of the unbalance tears the
balls off before.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from scipy.signal import spectrogram

from autobalancer.plots.save import save_picture
from reproductions import compared_all
from reproductions.spannan2021._stall_runs import (
    SAMPLES,
    balance,
    caught,
    machine,
    passages,
    released,
    simulated,
    stalled,
    whirl_of_balance,
)
from reproductions.spannan2021.figure_6_24 import CRITICAL, HALF_STEP, ORBIT

MEASURED, MEASURED_LINE = (57.5, 64.0), 53.0  # rad/s
RATE, BEFORE, HIGH, END = (
    0.1,
    4.0,
    82.0,
    50.0,
)  # acceleration, start below the release, turning point, end of the run-down
NEVER = 0.015  # rolling resistance above which balls do not stall; the balance has 0.0117
SUDDEN = 5.0  # s, in which the speed changes by 0.5 rad/s


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Release and capture speeds, simulated and by torque balance, the spectrogram and its line."""
    run = simulated(machine(0.0, "linear", (340.0, 390.0), 0.5))
    rows = [
        against(
            "release, linear drag: simulated against torque balance",
            balance(0.0, "linear").release,
            released(run),
            0.02,
        )
    ]
    rows.append(in_line(0.0, "linear", 0.02))
    for rolling in (0.0, 0.005, 0.01):
        expected = balance(rolling, "whole").release
        about = f"drag law (6.9), rolling resistance {rolling:g} (assumed)"
        if rolling < 0.01:
            run = simulated(machine(rolling, "whole", (expected - BEFORE, HIGH, END), RATE))
            name = f"capture in the run-down, {about}: simulated against measured"
            rows.append(against(name, MEASURED[0], caught(run), 0.05))
        else:
            about += ", no unbalance"
            run = simulated(machine(rolling, "whole", (expected - 0.7 * BEFORE, HIGH, END), RATE, unbalance=0.0))
        rows += [
            against(f"release, {about}: simulated against torque balance", expected, released(run), 0.02),
            against(
                f"release, {about}: simulated against measured", MEASURED[1], released(run), HALF_STEP / MEASURED[1]
            ),
            in_line(rolling, "whole", RATE),
        ]
        if rolling == 0.0:
            rows += in_spectrum(run, out)
    torn = simulated(machine(0.01, "whole", (balance(0.01, "whole").release - 0.7 * BEFORE, HIGH, END), RATE))
    never = simulated(machine(NEVER, "whole", (61.5, HIGH, END), RATE))
    by_balance = float(balance(NEVER, "whole") is not None)
    share = "share of the time at which balls stall"
    rows += [
        (f"rolling resistance 0.01: {share}, torn off by the unbalance's whirl", "1", 0.0, stalled_share(torn), 0.02),
        (f"rolling resistance 0.015: {share}", "1", 0.0, stalled_share(never), 0.02),
        ("rolling resistance 0.015: the torque balance has a release (1 = true)", "1", 0.0, by_balance, 0.0),
    ]
    return compared_all("Spannan 2021", "6.23 in kind", rows)


def against(name: str, target: float, obtained: float, share: float) -> tuple[str, str, float, float, float]:
    """A row of speeds whose tolerance is a share of the target."""
    return name, "rad/s", target, obtained, share * target


def in_line(rolling: float, law: str, rate: float) -> tuple[str, str, float, float, float]:
    """Capture in a run-down of balls in line, without unbalance, against the torque balance."""
    expected = balance(rolling, law).capture
    run = simulated(machine(rolling, law, (expected + 4.0, expected - 4.0), rate, unbalance=0.0, hanging=False))
    about = f"{'linear drag' if law == 'linear' else 'drag law (6.9)'}, rolling resistance {rolling:g}"
    return against(f"capture of balls in line, {about}: simulated against torque balance", expected, caught(run), 0.02)


def stalled_share(run: xr.Dataset) -> float:
    """Share of the run after its first five seconds in which a ball stalls."""
    return float(stalled(run)[int(5.0 * SAMPLES) :].mean())


def in_spectrum(run: xr.Dataset, out: Path) -> list[tuple[str, str, float, float, float]]:
    """The line in the spectrogram of the place of one ball, how suddenly it ends and begins, and the picture."""
    angle = run["rotor_angle"] + run["ball_angle_in_rotor"][:, 0]
    place = run["x"].values + ORBIT * np.cos(angle.values)
    frequency, time, power = spectrogram(place, fs=SAMPLES, nperseg=512, noverlap=448)
    frequency = 2.0 * math.pi * frequency
    speed, line = np.interp(time, run["time"].values, run["speed"].values), frequency[np.argmax(power, axis=0)]
    up = time < float(run["time"][int(np.argmax(run["speed"].values))])
    hangs = np.interp(time, run["time"].values, stalled(run)) > 0.99
    down = hangs & ~up
    whirl = np.array([whirl_of_balance(one) for one in speed[down]])
    slow = [float(np.interp(-one, -speed[~up], line[~up])) for one in MEASURED]
    last, far = float(line[hangs & up][-1]), float(np.abs(line[down] - whirl).max())
    half, whole, capture = passages(run)
    draw(run, frequency, time, power, out)
    return [
        against("line of the spectrogram before the release against the critical speed", CRITICAL, last, 0.02),
        ("line after the capture, farthest from the whirl of the torque balance", "rad/s", 0.0, far, 0.02 * CRITICAL),
        *(against(f"line at {at:g} rad/s in the run-down against measured", MEASURED_LINE, one, 0.05)
          for at, one in zip(MEASURED, slow, strict=True)),
        ("the line ends suddenly: from 90 % to half of the slip", "s", 0.0, half, SUDDEN),
        ("the ball reaches the speed of the rotor suddenly: from 90 % to 10 % of the slip", "s", 0.0, whole, SUDDEN),
        ("the line begins suddenly: from half to 90 % of the slip", "s", 0.0, capture, SUDDEN),
    ]  # fmt: skip


def draw(run: xr.Dataset, frequency: np.ndarray, time: np.ndarray, power: np.ndarray, out: Path) -> None:
    """Spectrogram over time, with the rotor speed."""
    figure, axes = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    near = (frequency > 37.0) & (frequency < 88.0)
    level = 10.0 * np.log10(power[near] + 1e-12)
    picture = axes.pcolormesh(time, frequency[near], level, vmin=-80.0, shading="auto")
    axes.plot(run["time"], run["speed"], color="white", lw=0.6, ls="--")
    axes.set(xlabel="time in s", ylabel="frequency in rad/s", title="Place of one ball (Spannan 2021, figure 6.23)")
    figure.colorbar(picture, label="power density in dB")
    save_picture(figure, out / "figure_6_23.png")

"""Figure 14 in kind: ball angles and motions over the speed, two washers, c_b = 0.1, and the phase of the plain rotor.

The source tells in words what its pictures show. Angles count from the light spot as there. A motion that it reports is a
row that is 1 if it occurs in the range that it names.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.machine import Machine
from autobalancer.plots.frequency_response import plot_frequency_response
from autobalancer.plots.save import save_picture
from autobalancer.plots.style import INK
from autobalancer.results.series import wrapped
from autobalancer.studies.frequency_response import frequency_response
from reproductions import compared_all
from reproductions.rodrigues2011.balls import BALL, ORBIT, from_heavy_spot, with_balls
from reproductions.rodrigues2011.rig import BEARINGS, RPM

SPEEDS = np.arange(360.0, 5401.0, 30.0)
SWINGING, STALLED = 1, 2


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Angles, motions, phases, and the picture."""
    machine = with_balls(0.1, washers=2)
    light = float(machine.unbalances[0].angle) + math.pi
    balls = {name: from_heavy_spot(with_balls(float(name), washers=2), SPEEDS, dwell=12.0, window=3.0)
             for name in ("0.01", "0.1", "1")}  # fmt: skip
    plain = frequency_response(without_balls(machine), SPEEDS * RPM, dwell=5.0, window=0.5, stations=BEARINGS)
    disk = plain.sel(station="disk")
    phase = np.degrees(wrapped(np.angle(disk["synchronous_x"].values + 1j * disk["synchronous_y"].values) - light))
    found = balls["0.1"]
    balanced = math.degrees(math.acos(machine.unbalances[0].size / (2.0 * BALL * ORBIT)))
    at = {speed: sorted(angles(found, speed, light)) for speed in (1200.0, 2100.0, 4500.0)}
    rows = [
        ("(c) 1200 rpm: distance of the balls from each other", "deg", 0.0, at[1200.0][1] - at[1200.0][0], 1.0),
        ("(c) 1200 rpm: farthest ball from the heavy spot (same side)", "deg", 0.0,
         180.0 - min(abs(a) for a in at[1200.0]), 90.0),
        ("(d) balls swing at some speed from 1400 to 1800 rpm", "1", 1.0, occurs(found, SWINGING, 1400, 1800), 0.0),
        ("(d) balls whirl about the race at some speed from 1400 to 1800 rpm", "1", 1.0,
         occurs(found, STALLED, 1400, 1800), 0.0),
        ("(e) 2100 rpm: half the angle between the balls, near the balanced one", "deg", balanced,
         0.5 * (at[2100.0][1] - at[2100.0][0]), 20.0),
        ("(f) balls swing at some speed from 2200 to 2450 rpm", "1", 1.0, occurs(found, SWINGING, 2200, 2450), 0.0),
        ("(g) 4500 rpm: half the angle between the balls, balanced", "deg", balanced,
         0.5 * (at[4500.0][1] - at[4500.0][0]), 10.0),
        ("(g) 4500 rpm: middle of the balls from the light spot", "deg", 0.0, 0.5 * sum(at[4500.0]), 10.0),
        ("(b) greatest phase from that of a subcritical rotor, 360 to 1200 rpm", "deg", 0.0,
         greatest(180.0 - np.abs(phase), 360, 1200), 45.0),
        ("(b) greatest phase from 1800 to 2200 rpm, near zero", "deg", 0.0, greatest(np.abs(phase), 1800, 2200), 45.0),
    ]  # fmt: skip
    above = SPEEDS > 2700.0
    for name, damped in balls.items():
        ratio = damped["amplitude"].values[above] / plain["amplitude"].values[above]
        rows.append((f"(a) c_b = {name}: share of the speeds above 2700 rpm where the balls reduce the vibration", "1",
                     1.0, float((ratio < 1.0).mean()), 0.0))  # fmt: skip
    draw(out, found, plain, phase, light)
    return compared_all("Rodrigues 2011", "14 in kind", rows)


def without_balls(machine: Machine) -> Machine:
    """The plain rotor."""
    return Machine(**{key: getattr(machine, key) for key in machine.model_fields_set if key != "balancers"})


def angles(found: xr.Dataset, speed: float, light: float) -> list[float]:
    """Middle of the range of each ball at a speed (rpm), degrees from the light spot."""
    at = found.sel(speed=speed * RPM, method="nearest")
    middle = 0.5 * (at["least_ball_angle_in_rotor"].values + at["greatest_ball_angle_in_rotor"].values)
    return [float(a) for a in np.degrees(wrapped(middle - light))]


def occurs(found: xr.Dataset, motion: int, low: float, high: float) -> float:
    """1 if any ball moves like that in a range of the speed, rpm."""
    part = found.sel(speed=slice(low * RPM, high * RPM))
    return float((part["ball_motion"].values == motion).any())


def greatest(values: np.ndarray, low: float, high: float) -> float:
    """Greatest value in a range of the speed, rpm."""
    return float(values[(low <= SPEEDS) & (high >= SPEEDS)].max())


def draw(out: Path, found: xr.Dataset, plain: xr.Dataset, phase: np.ndarray, light: float) -> None:
    """Amplitudes with those of the plain rotor, ball angles with its phase."""
    figure = plot_frequency_response(found, deflection_unit="mm", zero=light)
    figure.axes[0].plot(SPEEDS, plain["amplitude"].values * 1e3, color=INK, lw=0.9, ls="--", zorder=1.3)
    figure.axes[0].set_title("Rodrigues 2011, figure 14: two washers, c_b = 0.1; without balls dashed", loc="left")
    figure.axes[1].plot(SPEEDS, phase, color=INK, lw=0.9, ls="--", zorder=1.3)
    figure.axes[1].set_ylabel("ball angle from the light spot;\nphase of the disk (dashed) (°)")
    save_picture(figure, out / "figure_14.png")

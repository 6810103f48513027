"""Slow run-ups and run-downs of the discoidal stand-in (table 6.4), two balls in 0.65 mm^2/s oil, for figures 6.22 and 6.23."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.drag.discoidal import discoidal
from autobalancer.laws.drag_coefficient import DragCurve
from autobalancer.laws.stall import StalledBall, StallRange, planar_receptance, stall_ranges
from autobalancer.machine import Machine, Rubber
from autobalancer.simulation.record import Samples
from reproductions.spannan2021.figure_6_24 import (
    BALL,
    CRITICAL,
    DAMPING,
    DENSITY,
    MASS,
    ORBIT,
    RADIUS,
    STIFFNESS,
    UNBALANCE,
    VISCOSITY,
    drag_of,
)

DISPLACED = DENSITY * math.pi / 6.0 * (2.0 * RADIUS) ** 3
ROTOR = planar_receptance(MASS, STIFFNESS, DAMPING)
SAMPLES = 40.0  # per second
APART, MIDDLE = [2.9, 3.2], 3.05  # start angles, rad


def machine(
    rolling: float,
    law: str,
    speeds: Sequence[float],
    rate: float,
    *,
    unbalance: float = UNBALANCE,
    hanging: bool = True,
    rubber: Rubber | None = None,
    aside: float = 0.0,
) -> Machine:
    """The planar stand-in, whose speed goes through ``speeds`` (rad/s) with the acceleration ``rate``.

    With ``law`` *whole* the balls feel the drag law (6.9), with *linear* its linear range. They hang at the critical speed
    when it starts, or turn in line with the rotor, and the rotor whirls as they make it; the first one ``aside`` (rad) of where
    it begins otherwise. It stands on linear rubber unless some is given.
    """
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(speeds)) / rate)])
    whirl_speed = CRITICAL if hanging else speeds[0]
    balls = {"mass": BALL + DISPLACED, "diameter": 2.0 * RADIUS}
    race: dict[str, Any] = {
        "orbit_radius": ORBIT,
        "fluid": {"density": DENSITY, "viscosity": VISCOSITY},
        "drag": {"law": "discoidal"} if law == "whole" else {"law": "viscous", "damping": drag_of(VISCOSITY)},
        "friction": {"rolling_resistance": rolling},
        "collisions": False,
    }
    if hanging:
        slips = {"start_angles": [APART[0] + aside, APART[1]], "start_speeds": [CRITICAL - speeds[0]] * 2}
        races = [race | {"balls": [balls | {"count": 2} | slips]}]
    else:  # balls of one race must not begin at one place
        races = [race | {"balls": [balls | {"start_angles": [MIDDLE]}]}] * 2
    receptance = complex(ROTOR(np.array([whirl_speed]))[0])
    whirl = 2.0 * BALL * ORBIT * whirl_speed**2 * receptance * np.exp(1j * MIDDLE)
    moving = 1j * whirl_speed * whirl
    stands = {"stiffness": STIFFNESS, "damping": DAMPING} if rubber is None else {"rubber": rubber}
    return Machine(
        name="Discoidal rotor, table 6.4",
        axis="vertical",
        rotor={"mass": MASS - 2.0 * BALL, **stands},
        unbalances=[{"moment": unbalance}],
        balancers=[{"races": races}],
        drive={"kind": "speed", "profile": {"kind": "table", "time": times.tolist(), "speed": list(speeds)}},
        start={"deflection": (whirl.real, whirl.imag), "velocity": (moving.real, moving.imag)},
    )


def simulated(given: Machine) -> xr.Dataset:
    """A run with 40 samples per second."""
    duration = float(given.drive.profile.time[-1])
    return ab.simulate(given, duration=duration, save=Samples(int(SAMPLES * duration) + 1), tolerance=1e-7)


def balance(rolling: float, law: str) -> StallRange | None:
    """Release and capture by the torque balance on both balls in line, with what the whirl adds to the normal force."""
    found = stall_ranges(stalled_ball(rolling, law), ROTOR, [CRITICAL])
    return found[-1] if found else None


def stalled_ball(rolling: float, law: str) -> StalledBall:
    """One of both balls."""
    curve = DragCurve(discoidal(0.6), DENSITY, VISCOSITY, 2.0 * RADIUS)

    def drag(slip: np.ndarray) -> np.ndarray:
        return curve.torque(slip, ORBIT) if law == "whole" else drag_of(VISCOSITY) * slip

    return StalledBall(BALL * ORBIT, 2.0 * BALL * ORBIT, ORBIT, drag, rolling)


def share_of_slip(run: xr.Dataset, seconds: float) -> np.ndarray:
    """Lag of the slowest ball behind the rotor over that of the critical speed, averaged over a time; 0 below it."""
    count = int(SAMPLES * seconds) | 1
    mean = np.array(
        [np.convolve(-one, np.full(count, 1.0 / count), mode="same") for one in run["ball_speed_in_rotor"].values.T]
    )
    above = run["speed"].values - CRITICAL
    return np.where(above > 0.5, mean.max(axis=0) / np.maximum(above, 0.5), 0.0)


def stalled(run: xr.Dataset) -> np.ndarray:
    """Whether a ball, averaged over two seconds, is nearer to the critical speed than to the rotor's."""
    return np.asarray(share_of_slip(run, 2.0) > 0.5)


def released(run: xr.Dataset) -> float:
    """Rotor speed in the run-up at which the last ball leaves the critical speed; nan if none stalled."""
    speed = run["speed"].values
    up = int(np.argmax(speed))
    hanging = np.flatnonzero(stalled(run)[: up + 1])
    return float(speed[hanging[-1]]) if hanging.size else math.nan


def caught(run: xr.Dataset) -> float:
    """Rotor speed in the run-down at which a ball falls back to the critical speed; nan if none does."""
    speed = run["speed"].values
    up = int(np.argmax(speed))
    hanging = np.flatnonzero(stalled(run)[up:])
    return float(speed[up + hanging[0]]) if hanging.size else math.nan


def passages(run: xr.Dataset) -> tuple[float, float, float]:
    """How long passages last, s, by the slip averaged over half a second: from 90 % to half and to 10 % at the release, and
    from half to 90 % at the capture.
    """
    slip, time = share_of_slip(run, 0.5), run["time"].values
    up = int(np.argmax(run["speed"].values))
    most, half, least = (float(time[np.flatnonzero(slip[:up] > share)[-1]]) for share in (0.9, 0.5, 0.1))
    begun, caught_then = (float(time[up + np.flatnonzero(slip[up:] > share)[0]]) for share in (0.5, 0.9))
    return half - most, least - most, caught_then - begun

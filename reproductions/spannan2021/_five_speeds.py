"""The five speeds of section 6.1.7: two balls in 0.65 mm^2/s oil, stepped up by 1 Hz, each speed held and its last 10 s recorded.

The source stepped from 48 rad/s by 1 Hz until 700 rpm: 460, 520, 580, 640, 700 rpm. It prints balls that turn slower than the
rotor, a line at 53 rad/s, from 57.5 to 64 rad/s, which are the middles of 520/580 and 580/640 rpm.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.machine import Machine, Rubber
from reproductions.spannan2021._stall_runs import machine

SPEEDS = np.array([460.0, 520.0, 580.0, 640.0, 700.0]) * math.pi / 30.0
ONSET, RELEASE, LINE = 57.5, 64.0, 53.0  # rad/s
STEP, HELD, RECORD = 2.0, 70.0, 10.0  # s: to the next speed, at it, of it for the line
RESOLUTION = 2.0 * math.pi / RECORD
LINE_WITHIN = RESOLUTION + 0.5  # rad/s: the line is printed to 1 rad/s, from a record that resolves 0.63
STARTS = ((0.3, -0.5), (1.2, 2.9), (2.0, -2.5))  # rad, from the unbalance


def soft_rubber() -> Rubber:
    """The rubber of the sample machine, which is fitted."""
    rubber = ab.example("rubber").rotor.rubber
    assert isinstance(rubber, Rubber)
    return rubber


def stepped(
    rolling: float,
    *,
    rubber: Rubber | None = None,
    start: tuple[float, float] = STARTS[0],
    adherence: float | None = None,
    plateau: float = 0.60,
) -> Machine:
    """The planar stand-in with its drag law (6.9) that goes through the speeds; on linear rubber unless some is given."""
    plain = machine(rolling, "whole", SPEEDS[:2].tolist(), 1.0, rubber=rubber)
    race = plain.balancers[0].races[0]
    data: dict[str, Any] = plain.model_dump(exclude_unset=True)
    data["drive"]["profile"] = profile()
    found = data["balancers"][0]["races"][0]
    found["drag"] = {"law": "discoidal", "plateau": plateau}
    found["balls"] = [
        {"mass": race.balls[0].mass, "diameter": race.balls[0].diameter, "count": 2, "start_angles": start}
    ]
    if adherence is not None:
        found["friction"] = {"rolling_resistance": rolling, "adherence": adherence}
    del data["start"]
    return Machine(**data)


def profile() -> dict[str, Any]:
    """Through all speeds."""
    ends = np.arange(1, SPEEDS.size + 1) * (HELD + STEP) - STEP
    times = np.sort(np.concatenate([[0.0], ends, ends[:-1] + STEP]))
    return {"kind": "table", "time": times.tolist(), "speed": np.repeat(SPEEDS, 2).tolist()}


def slowest(run: xr.Dataset) -> np.ndarray:
    """Mean speed in space of the slowest ball at the end of each speed, rad/s."""
    ends = np.arange(1, SPEEDS.size + 1) * (HELD + STEP) - STEP
    angle = (run["rotor_angle"] + run["ball_angle_in_rotor"]).transpose("time", ...).values
    at = np.array([np.interp([end - RECORD, end], run["time"], ball) for ball in angle.T for end in ends])
    return np.asarray(((at[:, 1] - at[:, 0]) / RECORD).reshape(angle.shape[1], -1).min(axis=0))


def lines(rolling: float, **more: Any) -> np.ndarray:
    """:func:`slowest` of a run of :func:`stepped`."""
    return lines_of(stepped(rolling, **more))


def lines_of(given: Machine) -> np.ndarray:
    """:func:`slowest` of a run of a machine through all speeds."""
    end = float(profile()["time"][-1])
    return slowest(ab.simulate(given, duration=end, save=ab.Samples(2 * round(end) + 1), tolerance=1e-7))


def hangs(line: np.ndarray) -> np.ndarray:
    """At which of the speeds the slowest ball turns slower than the rotor, beyond the resolution of the record."""
    return np.asarray(SPEEDS - line > RESOLUTION)


def onset_and_release(line: np.ndarray) -> tuple[float, float]:
    """Middles of the steps at which a line appears and disappears, rad/s; nan if it does not."""
    hanging = np.flatnonzero(hangs(line))
    if not hanging.size:
        return math.nan, math.nan
    first, last = int(hanging[0]), int(hanging[-1])
    onset = 0.5 * (SPEEDS[first - 1] + SPEEDS[first]) if first > 0 else math.nan
    release = 0.5 * (SPEEDS[last] + SPEEDS[last + 1]) if last + 1 < SPEEDS.size else math.nan
    return onset, release


def meets_all(line: np.ndarray) -> bool:
    """Whether balls hang at 580 rpm only, at the printed line."""
    return bool((hangs(line) == [False, False, True, False, False]).all() and abs(line[2] - LINE) < LINE_WITHIN)

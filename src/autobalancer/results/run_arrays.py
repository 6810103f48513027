"""The arrays behind the measures, out of the labeled data of a run."""

from __future__ import annotations

import itertools
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.columns_of_measures import LAST
from autobalancer.results.places import Floats, plane_sizes, turns_of
from autobalancer.results.recorded import SETTLING_FROM, Balls, Bins, Links, Recorded, impacts_of
from autobalancer.results.series import NONE, lifted_from, load_of, standing_in, wrapped


def recorded_of(run: xr.Dataset, settling_from: str = SETTLING_FROM[0]) -> Recorded:
    """All that a run recorded; settling times count from the end of the run-up, or from the last release.

    Raises
    ------
    QuestionError
        If it kept neither samples nor an envelope.
    """
    bins, balls = bins_of(run), balls_of(run)
    told: dict[str, Any] = {}
    end, centered, of_turns = float(run.attrs["end_time"]), load_of(run.attrs) == NONE, _of_turns(run)
    if not (centered or of_turns) and "x" in run and (inside := run["time"].values >= end - LAST * end).any():
        told["late"] = away_from_standing(run.isel(time=inside))
    if balls is not None and "unbalance_angle_in_rotor" in run:
        told["final_angle"] = wrapped(balls.angle[-1] - run["unbalance_angle_in_rotor"].values[-1])
    if "link_torque" in run and run["time"].size:
        told["links"] = Links(*series(run, "time", "speed", "twist", "link_torque"))
    if "support_force_x" in run and run["time"].size and run.sizes["support"]:
        told["pushes"] = _vectors(run, "support_force_", "x", "y")
    if "ball_floor_force" in run:
        time, speed, floor = series(run, "time", "speed", "ball_floor_force")
        told["lifted"] = lifted_from(time, floor), lifted_from(speed, floor)
    jumps = jump_times(run)
    if jumps:
        parts = [part for begin, _, part in parts_between_jumps(run) if begin > 0.0]
        told["parts"] = tuple(_without_turns(part, settling_from) for part in parts)
    return Recorded(
        end=end,
        centered=centered,
        critical_speed=critical_speed_of(run),
        bins=bins,
        balls=balls,
        jumps=jumps,
        impacts=impacts_of(run),
        settling_from=settling_from,
        **told,
        **of_turns,
    )


def bins_of(run: xr.Dataset, count: int = 200) -> Bins:
    """The envelope that the run kept (exact), else that of its samples (with their resolution) in ``count`` parts.

    Raises
    ------
    QuestionError
        If the run kept neither.
    """
    if "envelope_high" in run:
        time, low, high, speed = series(run, *(f"envelope_{name}" for name in ("time", "low", "high", "speed")))
        end = _bin_ends(run)
        return Bins(time, 2.0 * (end - time), low, high, speed, end)
    t, r, w = series(run, "time", "deflection", "speed")
    edges = np.linspace(0, t.size, min(count, t.size) + 1).astype(int)
    pairs = [(a, b) for a, b in pairwise(edges) if b > a]
    return Bins(
        time=np.array([0.5 * (t[a] + t[b - 1]) for a, b in pairs]),
        width=np.array([t[min(b, t.size - 1)] - t[a] for a, b in pairs]),
        low=np.array([r[a:b].min() for a, b in pairs]),
        high=np.array([r[a:b].max() for a, b in pairs]),
        speed=np.array([w[b - 1] for _, b in pairs]),
        end=np.array([t[b - 1] for _, b in pairs]),
    )


def balls_of(run: xr.Dataset) -> Balls | None:
    """Motion of the balls from the samples, else at the ends of the bins; None of a machine without balls."""
    if not run.sizes.get("ball", 0):
        return None
    if "ball_angle_in_rotor" in run:
        time, speed, angle, rate = series(run, "time", "speed", "ball_angle_in_rotor", "ball_speed_in_rotor")
        return Balls(float(time[0]), time, speed, angle, rate)
    middle, speed, angle, rate = series(
        run, *(f"envelope_{name}" for name in ("time", "speed", "ball_angle_in_rotor", "ball_speed_in_rotor"))
    )
    ends = _bin_ends(run)
    return Balls(float(2.0 * middle[0] - ends[0]), ends, speed, angle, rate)


def known_balls(run: xr.Dataset) -> Balls:
    """The same of a machine that must have balls.

    Raises
    ------
    QuestionError
        If it has none.
    """
    balls = balls_of(run)
    if balls is None:
        raise QuestionError("the machine has no balls; there is nothing to measure on them")
    return balls


def critical_speed_of(run: xr.Dataset) -> float:
    """The lowest critical speed of the machine, rad/s; nan if it has none."""
    return float(np.min(run.attrs["critical_speeds"])) if np.size(run.attrs["critical_speeds"]) else np.nan


def series(run: xr.Dataset, *names: str) -> list[Floats]:
    """Variables of a run over time or bins.

    Raises
    ------
    QuestionError
        If the run has no such variable, or no entry of it.
    """
    if any(name not in run.variables for name in names):
        raise QuestionError(
            "the run kept neither samples over time nor an envelope; run it with save=Samples() or Envelope()"
        )
    if run[names[0]].size == 0:
        raise QuestionError("the run ended before its first sample; there is nothing to measure")
    return [run[name].values for name in names]


def away_from_standing(samples: xr.Dataset) -> Floats:
    """Distance of the reference station from its static deflection in these samples of a run, m."""
    x, y = series(samples, "x", "y")
    z = (x + 1j * y)[:, None]
    return np.abs(z - standing_in(samples, z, ""))[:, 0]


def _bin_ends(run: xr.Dataset) -> Floats:
    """Where the speed and the balls of an envelope are from, s; a file of version 0.1 has only the middle of each bin."""
    return np.asarray(run["envelope_end" if "envelope_end" in run else "envelope_time"].values, np.float64)


def _without_turns(part: xr.Dataset, settling_from: str) -> Recorded:
    """What a part of a run between jumps of the unbalance recorded."""
    return Recorded(
        end=float(part.attrs["end_time"]),
        centered=load_of(part.attrs) == NONE,
        critical_speed=critical_speed_of(part),
        bins=bins_of(part),
        balls=balls_of(part),
        jumps=jump_times(part),
        settling_from=settling_from,
    )


def _of_turns(run: xr.Dataset) -> dict[str, Any]:
    """What the last revolutions say of places, planes and supports; nothing without a whole one."""
    if "turn_rotor_angle" not in run or "turn_place_x" not in run:
        return {}
    turns = turns_of(run["turn_rotor_angle"].values)
    if turns.start == turns.stop:
        return {}
    last = run.isel(turn=turns)
    z, v = (_vectors(last, "turn_place_", *names) for names in (("x", "y"), ("vx", "vy")))
    told: dict[str, Any] = {"turns": (z, v, standing_in(last, z))}
    if run.sizes["support"]:
        force = _vectors(last, "turn_support_force_", "x", "y")
        told["forces"] = force, standing_in(last, force)
    if "plane" in run.coords:
        told["planes"] = sizes = plane_sizes(last)
        told["rotor"] = sum(sizes[0].T), sum(sizes[1].T)
        if run.sizes["plane"] == 1:
            told["rotor"] = last["turn_unbalance"].values, last["turn_residual_unbalance"].values
    if "vibration_without_balls" in run:
        told["without_balls"] = run["vibration_without_balls"].values
    return told


def _vectors(last: xr.Dataset, prefix: str, x: str, y: str) -> Any:
    return last[f"{prefix}{x}"].values + 1j * last[f"{prefix}{y}"].values


# Jumps of the unbalance in a run, and the parts of the run between them.


def jump_times(run: xr.Dataset) -> list[float]:
    """Times (s) at which the unbalance jumped, in order; a file keeps a list of one as a number."""
    return [float(time) for time in np.atleast_1d(run.attrs.get("unbalance_jumps", []))]


def parts_between_jumps(run: xr.Dataset) -> list[tuple[float, float, xr.Dataset]]:
    """Begin, end (s) and data over time and bins of each part; one part without jumps.

    A part without any data, such as one that an early end of the run cut off, is left out.
    """
    end = float(run.attrs["end_time"])
    edges = [0.0, *(time for time in jump_times(run) if time < end), end]
    found = []
    for begin, until in itertools.pairwise(edges):
        inside: dict[str, Any] = {
            dimension: _within(run[name].values, begin, until, until == end)
            for dimension, name in (("time", "time"), ("bin", "envelope_time"))
            if name in run
        }
        empty = [dimension for dimension, mask in inside.items() if not mask.any()]
        if len(empty) < len(inside):
            rows = {name: np.flatnonzero(mask) for name, mask in inside.items() if name not in empty}
            found.append((begin, until, run.drop_dims(empty).isel(rows)))
    return found


def _within(time: Any, begin: float, until: float, last: bool) -> Any:
    return (time >= begin) & ((time <= until) if last else (time < until))

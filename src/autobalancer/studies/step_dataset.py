"""A stepped response as a labelled result, and the names of what balls do at a speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.results.answers.stepped import SteppedResponse
from autobalancer.studies.stepping import Row

MOTIONS = ("at rest", "swinging", "stalled")
SWING = math.radians(1.0)  # a ball that moves less rests
TURNING = 0.01  # a ball whose mean speed in the rotor is a greater share of the rotor speed goes around

LABELS = {
    "amplitude": ("greatest deflection, mean over the stations", "m"),
    "greatest_mean_deflection": ("greatest value in time of the mean deflection of the stations", "m"),
    "greatest_deflection": ("greatest deflection of a station", "m"),
    "synchronous_x": ("deflection that turns with the rotor, along its zero mark", "m"),
    "synchronous_y": ("deflection that turns with the rotor, a quarter turn ahead of its zero mark", "m"),
    "amplitude_change": ("relative change of the amplitude from the first to the second half of the window", "1"),
    "least_ball_angle_in_rotor": ("least ball angle in the rotor", "rad"),
    "greatest_ball_angle_in_rotor": ("greatest ball angle in the rotor", "rad"),
    "mean_ball_speed_in_rotor": ("mean ball speed in the rotor", "rad/s"),
    "time_at_speed": ("time at the speed, window included", "s"),
}
PARTING = ("rate at which balls that stay at one place would separate; nan where none do", "1/s")
SOURCES = {
    "amplitude": "amplitude", "greatest_mean_deflection": "mean", "amplitude_change": "change", "time_at_speed": "hold",
    "greatest_deflection": "greatest", "least_ball_angle_in_rotor": "low", "greatest_ball_angle_in_rotor": "high",
    "mean_ball_speed_in_rotor": "ball_speed",
}  # fmt: skip


def ball_motions(swing: np.ndarray, mean_speed: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Number in :data:`MOTIONS` of each ball; ``swing`` (rad) and ``mean_speed`` are (..., ball), -1 where unknown.

    A ball is *stalled* while it goes around in the rotor, on the mean faster than 1/100 of the rotor speed; else
    *swinging* if its angle moves by more than 1 degree in the window; else *at rest*.
    """
    motion = np.where(np.abs(mean_speed) > TURNING * np.abs(speed), 2, np.where(swing > SWING, 1, 0))
    return np.asarray(np.where(np.isfinite(swing), motion, -1), np.int64)


def step_dataset(
    assembly: Assembly,
    speeds: Sequence[float],
    legs: Sequence[str],
    names: Sequence[str],
    rows: dict[tuple[int, int], Row],
) -> SteppedResponse:
    """Arrays over (direction, speed); what was not reached is nan."""
    count, n, s = len(speeds), len(assembly.balls), len(names)

    def column(key: str, *shape: int) -> np.ndarray:
        values = np.full((len(legs), count, *shape), np.nan)
        for (leg, number), row in rows.items():
            if key in row:
                values[leg, number] = np.reshape(row[key], shape)
        return values

    data: dict[str, Any] = {}
    for name, key in SOURCES.items():
        if "ball" in name:
            if n:
                data[name] = (("direction", "speed", "ball"), column(key, n))
        elif name == "greatest_deflection":
            data[name] = (("direction", "speed", "station"), column(key, s))
        else:
            data[name] = (("direction", "speed"), column(key))
    forward = column("forward", s, 2)
    data["synchronous_x"] = (("direction", "speed", "station"), forward[..., 0])
    data["synchronous_y"] = (("direction", "speed", "station"), forward[..., 1])
    result = SteppedResponse(data)
    for name in data:
        text, unit = LABELS[name]
        result[name].attrs.update(long_name=text, units=unit)
    outcomes = np.full((len(legs), count), "not reached", dtype=object)
    for place, row in rows.items():
        outcomes[place] = row["outcome"]
    result["outcome"] = (("direction", "speed"), outcomes, {"long_name": "how the integration ended"})
    result = result.assign_coords(
        speed=("speed", np.asarray(speeds, np.float64), {"long_name": "rotor speed", "units": "rad/s"}),
        station=("station", np.array(list(names), dtype=object), {"long_name": "station"}),
        direction=("direction", np.array(list(legs), dtype=object), {"long_name": "direction through the speeds"}),
    )
    if any("parting" in row for row in rows.values()):
        text, unit = PARTING
        result["parting_rate"] = (("direction", "speed"), column("parting"), {"long_name": text, "units": unit})
    if n:
        swing = result["greatest_ball_angle_in_rotor"].values - result["least_ball_angle_in_rotor"].values
        lag = result["mean_ball_speed_in_rotor"].values
        motion = ball_motions(swing, lag, np.asarray(speeds)[None, :, None])
        attrs = {"flag_values": list(range(len(MOTIONS))), "flag_meanings": list(MOTIONS)}
        result["ball_motion"] = (("direction", "speed", "ball"), motion, {"long_name": "what a ball does", **attrs})
        whole = motion.max(axis=2)
        result["motion"] = (
            ("direction", "speed"),
            whole,
            {"long_name": "the most severe motion class of all balls", **attrs},
        )
        result = result.assign_coords(
            ball=np.arange(1, n + 1), balancer=("ball", [ball.balancer + 1 for ball in assembly.balls])
        )
    return result if len(legs) > 1 else result.isel(direction=0)

"""Two balls on the rig of bodies and softening bushings, guided along their race or resolved in contact with it.

Nothing of the contact is printed. Walls of 1000 N/mm, friction of 0.1 and restitution of 0.5 are those of the sample
``resolved_balls``; others tried on the five speeds gave the same lines to 0.02 rad/s: Hertz contact of steel, friction of
0.01, 0.05 and 0.3, more of it at the onset of sliding, full friction from a tenth of that slip on, balls that start on the
floor of the annulus, friction between balls.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine

RACE = "balancers[1].races[1]."
CONTACT = {
    "stiffness": "1000 kN/m", "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": "10 mm/s", "rest_speed": "1 mm/s",
}  # fmt: skip
RIG = "rig of bodies on softening bushings"


def on_the_rig(
    profile: dict[str, Any],
    rolling: float,
    *,
    resolved: bool = False,
    start: tuple[float, float] | None = None,
    times: float = 1.0,
    plateau: float = 0.60,
) -> Machine:
    """The rig with 594 g mm and two balls in 0.65 mm^2/s oil; adherence is ``times`` the rolling resistance."""
    changes: dict[str, Any] = {
        "drive.profile": profile,
        RACE + "friction": {"rolling_resistance": rolling, "adherence": times * rolling},
        RACE + "drag": {"law": "discoidal", "plateau": plateau},
    }
    if start is not None:
        changes[RACE + "balls[1].start_angles"] = start
    if resolved:
        changes[RACE + "resolved"] = CONTACT
    machine = rig("discoidal_rig_rubber")
    for path, value in changes.items():
        machine = with_value_at(machine, path, value)
    return machine


def slowest_ball(run: xr.Dataset, seconds: float = 5.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (s), rotor speed and mean speed in space of the slowest ball over some seconds around them, rad/s."""
    time, speed = run["time"].values, run["speed"].values
    angle = (run["rotor_angle"] + run["ball_angle_in_rotor"]).transpose("time", ...).values
    count = round(seconds / (time[1] - time[0]))
    slow = ((angle[count:] - angle[:-count]) / (time[count:] - time[:-count])[:, None]).min(axis=1)
    middle = 0.5 * (time[count:] + time[:-count])
    return middle, np.interp(middle, time, speed), slow

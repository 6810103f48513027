"""Pictures of what a machine does at any speed, and its report: each asks public functions and draws what they say.

What brings compiled equations is imported when it is asked for, so that the page opens at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from autobalancer.assembly.quantities import value_of
from autobalancer.either_kind import check
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine import Machine
from autobalancer.patience import Progress
from autobalancer.plots.rotor.campbell import campbell as campbell_picture
from autobalancer.plots.rotor.unbalance_response import response as response_picture
from autobalancer.plots.stability.stability_map import map as map_picture

OILS = (("viscosity", 1e6, "mm^2/s"), ("drag", 1.0, "N*m*s"))
RPM = 30.0 / math.pi


def speed_range(machine: Machine) -> tuple[float, float]:
    """From half the lowest critical speed to somewhat above the highest speed of the drive, rpm.

    Raises
    ------
    QuestionError
        If the machine has neither.
    """
    found: Any = check(machine)
    lowest = min((speed for speed in found.critical_speeds if speed > 0.0), default=0.0)
    top = max(1.15 * (found.highest_speed or 0.0), 1.6 * lowest)
    if not top > 0.0:
        raise QuestionError("the machine has no critical speed and its drive no highest speed")
    return RPM * (0.5 * lowest if lowest else 0.02 * top), RPM * top


def drag_axis(machine: Machine) -> tuple[str, float, str]:
    """The quantity that damps the balls, its value in its unit, and the unit.

    Raises
    ------
    QuestionError
        If the balls have no single viscosity or drag.
    """
    for name, scale, unit in OILS:
        try:
            value = value_of(machine, name)
        except AutobalancerError:
            continue
        if value > 0.0:
            return name, scale * value, unit
    raise QuestionError("the balls of this machine have no single viscosity or drag that could be varied")


def map_of(machine: Machine) -> Callable[[], Any]:
    """The stability map over speed and viscosity, or drag."""
    from autobalancer.stability.maps.stability_map import map as stability_map

    low, high = speed_range(machine)
    name, value, unit = drag_axis(machine)
    axes: dict[str, Any] = {
        "speed": f"{low:.5g}:{high:.5g} rpm:61",
        name: f"{0.1 * value:.5g}:{10.0 * value:.5g} {unit}:41:log",
    }
    found = stability_map(machine, axes, borders=31, progress=_silent)
    return lambda: map_picture(found)


def campbell_of(machine: Machine) -> Callable[[], Any]:
    """Natural frequencies over the speed."""
    from autobalancer.rotordynamics.campbell import campbell

    low, high = speed_range(machine)
    found = campbell(machine, [f"{low + (high - low) * k / 80:.6g} rpm" for k in range(81)])
    return lambda: campbell_picture(found)


def response_of(machine: Machine) -> Callable[[], Any]:
    """Vibration by the unbalance alone, over the speed."""
    from autobalancer.rotordynamics.response import response

    low, high = speed_range(machine)
    found = response(machine, [f"{low + (high - low) * k / 300:.6g} rpm" for k in range(301)])
    return lambda: response_picture(found)


def report_file(machine: Any, path: Path, progress: Progress) -> Path:
    """The report of a machine as ``.html`` or ``.pdf``."""
    from autobalancer.reporting.report import report

    path.parent.mkdir(parents=True, exist_ok=True)
    return report(machine, path, starts=40, progress=progress)


def _silent(_done: float, _total: float) -> None:
    """The job shows its own."""

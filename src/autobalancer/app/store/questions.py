"""The questions of the page as functions: ``read_...`` makes arguments of the texts of a form, ``ask_...`` asks with them.

A text that is not possible raises a QuestionError that begins with the name of its entry. What brings compiled equations is
imported when it is asked for, so that the page opens at once.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from autobalancer.assembly.quantities import parameter_range, parameter_unit
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.patience import Progress
from autobalancer.units import argument, shortened
from autobalancer.units.ranges import ends, range_values

Given = Mapping[str, str]
MOST_POINTS, MOST_STARTS, MOST_SPEEDS, MOST_STEPS, MOST_MODES = 40_000, 5000, 5000, 1000, 40  # of one question here
NEAR = 2.0  # times the highest speed: modes above it say little about the machine


def _number(name: str, text: str, most: int) -> int:
    if not re.fullmatch(r"\s*[0-9]{1,9}\s*", text) or not 1 <= int(text) <= most:
        raise QuestionError(f"{name}: given {shortened(text)}; must be a whole number from 1 to {most}")
    return int(text)


def _some(name: str, text: str, unit: str, most: int = MOST_SPEEDS) -> Any:
    found = range_values(name, text, unit)
    if len(found) > most:
        raise QuestionError(f"{name}: given {len(found)} values; on this page at most {most}")
    return found


def _optional(name: str, given: Given, unit: str) -> float | None:
    return argument(name, given[name], unit) if given.get(name, "").strip() else None


def _over(machine: Machine, given: Given) -> Any:
    return parameter_range(machine, given["over"], given["values"], "values")


def read_map(machine: Machine, given: Given) -> dict[str, Any]:
    """Speeds and values of the other quantity, not too many together."""
    speeds, values = _some("speed", given["speed"], "rad/s"), _over(machine, given)
    if speeds.size * values.size > MOST_POINTS:
        raise QuestionError(
            f"values: {speeds.size} speeds by {values.size} values are {speeds.size * values.size} points; on this page "
            f"at most {MOST_POINTS}"
        )
    if min(speeds.size, values.size) < 3:
        raise QuestionError("values: a map has at least three values along each axis")
    return {"axes": {"speed": speeds, given["over"]: values}}


def ask_map(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """The stability map."""
    from autobalancer.stability.maps.stability_map import map as stability_map

    return stability_map(machine, asked["axes"], borders=31, progress=progress)


def read_borders(machine: Machine, given: Given) -> dict[str, Any]:
    """A quantity and its values."""
    values = _over(machine, given)
    if len(values) > MOST_SPEEDS:
        raise QuestionError(f"values: given {len(values)}; on this page at most {MOST_SPEEDS}")
    return {"parameter": given["over"], "values": values}


def ask_borders(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """Border speeds over a quantity."""
    from autobalancer.stability.maps.curve import border_curve

    return border_curve(machine, asked["parameter"], asked["values"], progress=progress)


def read_campbell(_machine: Machine, given: Given) -> dict[str, Any]:
    """Speeds, and how many modes; none where those near the speeds are meant."""
    few = given["modes"].strip()
    return {
        "speeds": _some("speeds", given["speeds"], "rad/s"),
        "modes": _number("modes", few, MOST_MODES) if few else None,
    }


def ask_campbell(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """Natural frequencies over the speed."""
    from autobalancer.rotordynamics.campbell import campbell

    progress(0.0, 1.0)
    count = asked["modes"] or _modes_near(machine, asked["speeds"])
    return campbell(machine, asked["speeds"], modes=count)


def _modes_near(machine: Machine, speeds: Any) -> int:
    """How many modes are slower than ``NEAR`` times the highest speed, at either end of the range; two at least."""
    from autobalancer.rotordynamics.modes import modes

    top = float(np.max(speeds))
    ends = [modes(machine, float(speed), modes=MOST_MODES)["frequency"].values for speed in (np.min(speeds), top)]
    return max(2, *(int(np.sum(frequencies < NEAR * top)) for frequencies in ends))


def read_response(_machine: Machine, given: Given) -> dict[str, Any]:
    """Speeds, and which quantity."""
    return {"speeds": _some("speeds", given["speeds"], "rad/s"), "quantity": given["quantity"]}


def ask_response(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """Vibration by the unbalance alone."""
    from autobalancer.rotordynamics.response import response

    progress(0.0, 1.0)
    return response(machine, asked["speeds"], quantity=asked["quantity"], smooth=True)


def read_stepped(machine: Machine, given: Given) -> dict[str, Any]:
    """Speeds, times at each, and the way."""
    return {
        "speeds": _some("speeds", given["speeds"], "rad/s", MOST_STEPS),
        "dwell": argument("dwell", given["dwell"], "s"),
        "window": argument("window", given["window"], "s"),
        "direction": given["direction"],
    }


def ask_stepped(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """Amplitudes speed by speed; one that is cancelled has those that were measured."""
    from autobalancer.studies.stepped_response import stepped_response

    return stepped_response(machine, **asked, keep_on_interrupt=True, progress=progress)


def read_branches(machine: Machine, given: Given) -> dict[str, Any]:
    """A quantity with its range, and where to begin."""
    first, last = ends("range", given["range"], parameter_unit(machine, given["over"]))
    speed = None if given["over"] == "speed" else _optional("speed", given, "rad/s")
    return {"parameter": given["over"], "start": first, "end": last, "speed": speed, "from_state": given["from_state"]}


def ask_branches(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """Branches; the share of the work is the number of the branch and its place in the range."""
    from autobalancer.stability.diagrams.branches import branches

    return branches(machine, **asked, progress=lambda number, share: progress(number + min(share, 0.99), 1.0))


def read_basin(machine: Machine, given: Given) -> dict[str, Any]:
    """A speed, and the starts."""
    asked: dict[str, Any] = {
        "speed": argument("speed", given["speed"], "rad/s"),
        "acceleration": _optional("acceleration", given, "rad/s^2"),
        "hold": _optional("hold", given, "s"),
    }
    if given["starts"] == "random":
        return {**asked, "random": _number("number", given["number"], MOST_STARTS)}
    count = _number("number", given["number"], int(math.sqrt(MOST_STARTS)))
    balls = sum(group.count for one in machine.balancers for race in one.races for group in race.balls)
    return {**asked, "axes": {f"ball_angle[{k + 1}]": f"-180:180 deg:{count + 1}" for k in range(min(balls, 2))}}


def ask_basin(machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
    """Ends of many starts."""
    from autobalancer.studies.basin import basin

    return basin(machine, **asked, progress=progress)

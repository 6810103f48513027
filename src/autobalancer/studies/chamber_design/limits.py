"""What a design is judged by: numbers of a run, and limits to them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from autobalancer.errors import QuestionError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.bounds import ChamberBounds, pressure_between_balls
from autobalancer.units import argument

PUSHED = 2.0  # times its friction lifts a ball that others push; without shaking none was seen to be lifted by less


class Judged(NamedTuple):
    """A number of a run: its unit, its meaning, and how it follows from the measures of the run."""

    unit: str
    text: str
    of: Callable[[Mapping[str, Any]], float]


def _greater(*names: str) -> Callable[[Mapping[str, Any]], float]:
    def found(measures: Mapping[str, Any]) -> float:
        values = [measures.get(name) for name in names]  # an archive keeps what is not known as None
        return math.nan if None in values else max(map(float, values))  # type: ignore[arg-type]

    return found


JUDGED = {
    "vibration": Judged(
        "m",
        "amplitude in steady state, the greater of both directions",
        _greater("vertical_amplitude", "horizontal_amplitude"),
    ),
    "synchronous": Judged(
        "m", "the part of it that turns with the rotor", _greater("vertical_synchronous", "horizontal_synchronous")
    ),
    "residual_unbalance": Judged("kg m", "mean residual unbalance in steady state", _greater("residual_unbalance")),
    "settling_time": Judged("s", "settling time of the last ball", _greater("settling_time")),
    "run_up_peak": Judged(
        "m", "greatest deflection before the steady state", _greater("vertical_peak", "horizontal_peak")
    ),
    "bearing_force": Judged(
        "N",
        "greatest radial force of a bearing in steady state",
        _greater("steady_bearing_1_greatest", "steady_bearing_2_greatest"),
    ),
    "contact_force": Judged("N", "force of the hardest contact", _greater("hardest_contact")),
    "contact_pressure": Judged(
        "Pa", "its pressure if it is between two balls, the greatest possible", _greater("contact_pressure")
    ),
    "share_carried": Judged("1", "share of the balls that go around with the rotor", _greater("share_carried")),
}
LIMITS = {name: entry.unit for name, entry in JUDGED.items() if name != "share_carried"} | {"pick_up": "1"}


def read_limits(given: Mapping[str, Any] | None) -> dict[str, float]:
    """Limits in SI by name: most values, of ``pick_up`` the least share of the runs in which all balls are carried."""
    found = {}
    for name, value in (given or {}).items():
        if name not in LIMITS:
            raise QuestionError(f"limits: given {name!r}; must be one of {', '.join(LIMITS)}")
        read = argument(f"limits: {name}", value, "" if LIMITS[name] == "1" else LIMITS[name].replace(" ", "*"))
        if not 0.0 < read < math.inf:
            raise QuestionError(f"limits: {name}: given {read:g}; must be above zero, and finite")
        if name == "pick_up" and read > 1.0:
            raise QuestionError(f"limits: pick_up: given {read:g}; it is a share of the runs, at most 1")
        found[name] = read
    return found


def numbers_of(machine: ChamberMachine, measures: Mapping[str, Any]) -> dict[str, float]:
    """What a run of a machine is judged by, from its measures; nan where one is not known."""
    hardest = measures.get("hardest_contact")
    pressure = math.nan if hardest is None else pressure_between_balls(machine, float(hardest))
    known = {**measures, "contact_pressure": pressure}
    return {name: float(entry.of(known)) for name, entry in JUDGED.items()}


def ruled_out(found: ChamberBounds, limits: Mapping[str, float]) -> list[str]:
    """Why no run of a machine with these bounds can be good; empty if nothing speaks against it."""
    reasons = []
    if found.capability < found.unbalance:
        reasons.append(f"the balls can balance {found.capability:.3g} of {found.unbalance:.3g} kg m")
    if not found.run_up_time < math.inf:
        reasons.append(f"the speed stays below the critical speed of {found.critical_speed:.4g} rad/s")
    if math.isnan(found.critical_speed):
        reasons.append("the body has no critical speed: the balls do not feel the unbalance")
    if "pick_up" in limits:
        reasons += _not_lifted(found)
    for name, least, unit in (
        ("vibration", found.least_vibration, "m"),
        ("synchronous", found.least_vibration, "m"),
        ("residual_unbalance", found.least_residual, "kg m"),
        ("settling_time", found.least_settling_time, "s"),
        ("bearing_force", found.least_bearing_force, "N"),
        ("contact_force", found.race_force, "N"),
        ("contact_pressure", found.race_pressure, "Pa"),
    ):
        if name in limits and least > limits[name]:
            reasons.append(
                f"{name.replace('_', ' ')} is at least {least:.3g} {unit}, the limit {limits[name]:.3g} {unit}"
            )
    return reasons


def _not_lifted(found: ChamberBounds) -> list[str]:
    """Why no ball is carried up from the bottom. A row along the axis acts as one ball, whether the rotor shakes or not."""
    needed = f"one ball needs {found.least_friction:.3g}"
    if found.axial_rows == 1 and found.friction < found.least_friction:
        return [
            f"friction {found.friction:g} does not lift the balls, which lie in one row and act as one ball: {needed}"
        ]
    if found.shaking < 1.0 and PUSHED * found.friction < found.least_friction:
        return [
            f"friction {found.friction:g} lifts no ball of a calm rotor: {needed}, and others that push do not halve that"
        ]
    return []

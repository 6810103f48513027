"""The trial mass for a balancing job: how large, where, and whether it will be seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.laws.balance_quality import grade_argument, permissible_unbalance
from autobalancer.machine import Machine
from autobalancer.measurement.balancing.runs import AMPLITUDES, one_of
from autobalancer.rotordynamics.response import response
from autobalancer.units import argument, optional_argument

GRAVITY = 9.80665
SHARE = 0.1  # of the weight that a trial mass may pull with, rule of practice
GRADE_TIMES = 5.0  # permissible unbalances that a trial mass makes
SEEN = 0.3  # share of the reading by which it should change it
Running = Literal["below", "above"]
QUANTITIES = {"m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}


@dataclass(frozen=True)
class TrialPlan:
    """A trial mass (kg) at ``radius`` (m), its unbalance (kg m), force (N), and angle (rad, nan where nothing says where).

    ``change`` is the share by which it changes the reading, nan where no model says so; ``remarks`` say what to be careful about.
    """

    mass: float
    unbalance: float
    radius: float
    angle: float
    force: float
    change: float
    rule: str
    remarks: tuple[str, ...]


def trial_mass(
    *,
    radius: float | str,
    speed: float | str,
    rotor_mass: float | str | None = None,
    grade: float | str | None = None,
    machine: Machine | str | Path | None = None,
    station: str | float | None = None,
    plane: str | float | None = None,
    direction: Literal["x", "y"] = "x",
    reading: float | str | None = None,
    phase: float | str | None = None,
    running: Running | None = None,
) -> TrialPlan:
    """Plan a trial mass.

    Its size comes from the model if there is one (it changes the ``reading`` by 30 %), else from the ``grade`` (five times what
    the grade allows), else it pulls with a tenth of the weight of the rotor. Its place takes unbalance away rather than adding
    to it.

    Parameters
    ----------
    radius
        At which it will be, m.
    speed
        At which it will run, rad/s.
    rotor_mass
        kg; not needed with a machine of one mass.
    grade
        Balance quality grade in mm/s, such as 6.3 or ``"G 6.3"``.
    machine, station, plane, direction
        Model, where it is read and where the mass will be (by default the plane of the first balancer), and along what.
    reading, phase
        Of the run without trial mass, amplitude (peak) with unit, and lead against the mark, rad.
    running
        Without a model: ``"below"`` the critical speed, where the rotor moves towards its heavy side, or ``"above"``, where it
        moves away from it.

    Raises
    ------
    QuestionError
        If neither of the three ways is possible.

    Source: ISO 21940-11:2016 for grades; the tenth of the weight is a rule of practice.
    """
    arm, w = argument("radius", radius, "m"), argument("speed", speed, "rad/s")
    heavy = optional_argument("rotor_mass", rotor_mass, "kg")
    lead = optional_argument("phase", phase, "rad")
    for name, value in (("radius", arm), ("speed", w)):
        if not value > 0.0:
            raise QuestionError(f"trial_mass: {name}: given {value:g}; must be above zero")
    amplitude, unit = (None, "m") if reading is None else one_of("reading", reading, AMPLITUDES, amplitude=True)
    remarks: list[str] = []
    gain = None if machine is None else _gain(machine, w, station, plane, direction, unit)
    if gain is not None and amplitude is not None:
        unbalance, rule = SEEN * amplitude / abs(gain), "30 % of the reading, by the model"
    elif heavy is not None and grade is not None:
        unbalance, rule = (
            GRADE_TIMES * permissible_unbalance(grade, heavy, w),
            f"five times what G {grade_argument(grade):g} allows",
        )
    elif heavy is not None:
        unbalance, rule = SHARE * heavy * GRAVITY / w**2, "a tenth of the weight"
    else:
        raise QuestionError("trial_mass: give a machine and a reading, or the 'rotor_mass', with or without a 'grade'")
    force = unbalance * w**2
    if heavy is not None and force > SHARE * heavy * GRAVITY * (1.0 + 1e-9):
        remarks.append(
            f"it pulls with {force / (heavy * GRAVITY):.2g} of the weight of the rotor, more than a tenth; start at a lower speed"
        )
    change = float("nan") if gain is None or amplitude is None else abs(gain) * unbalance / amplitude
    return TrialPlan(
        unbalance / arm, unbalance, arm, _place(lead, gain, running, remarks), force, change, rule, tuple(remarks)
    )


def _place(lead: float | None, gain: complex | None, running: Running | None, remarks: list[str]) -> float:
    """Opposite to where the unbalance is, as far as anything says."""
    if lead is None:
        remarks.append(
            "without a phase nothing says where; start anywhere, and move it by 120 deg if the vibration grows much"
        )
        return float("nan")
    if gain is not None:
        heavy_side = lead - float(np.angle(gain))
    elif running is None:
        remarks.append(
            "say whether the rotor runs below or above its critical speed, or give a model, to know where it goes"
        )
        return float("nan")
    else:
        heavy_side = lead - (0.0 if running == "below" else np.pi)
    return float(np.mod(heavy_side + np.pi, 2.0 * np.pi))


def _gain(
    machine: Machine | str | Path,
    speed: float,
    station: str | float | None,
    plane: str | float | None,
    direction: str,
    unit: str,
) -> complex:
    """Complex amplitude at the station for a unit unbalance in the plane, lead and sense of rotation."""
    from autobalancer.machine import Unbalance

    if unit not in QUANTITIES:
        raise QuestionError(
            f"trial_mass: reading: with a model a displacement, velocity or acceleration is needed, not {unit}"
        )
    load: Any = 1.0 if plane is None else (Unbalance(moment=1.0, station=plane),)
    quantity: Any = QUANTITIES[unit]
    found = response(machine, [speed], None if station is None else [station], load, quantity=quantity)
    one = found.isel(speed=0, station=0)
    return complex(float(one[f"{direction}_real"]), float(one[f"{direction}_imag"]))

"""Runs of a balancing job: which masses were on the rotor, and what was read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from autobalancer.errors import QuestionError, UnitError
from autobalancer.units import argument

AMPLITUDES = ("m", "m/s", "m/s^2", "N", "V")
MASSES = ("kg", "kg*m")
TURNS = 4.0 * math.pi  # a phase beyond it is hardly one in rad


@dataclass(frozen=True)
class TrialMass:
    """A mass on the rotor in a run.

    Parameters
    ----------
    plane
        Name of the balancing plane.
    mass
        kg, or a text such as ``"2.5 g"``; an unbalance as a text such as ``"25 g*mm"``. What is taken away is negative.
    angle
        On the rotor, rad, counted from the zero mark.
    """

    plane: str
    mass: float | str
    angle: float | str = 0.0
    unit: str = field(init=False, default="kg")

    def __post_init__(self) -> None:
        value, unit = one_of("mass", self.mass, MASSES)
        _set(self, plane=str(self.plane), mass=value, unit=unit, angle=argument("angle", self.angle, "rad"))


@dataclass(frozen=True)
class Reading:
    """What one sensor shows at one speed.

    Parameters
    ----------
    amplitude
        A number in SI or a text such as ``"7.2 mm/s"``: displacement, velocity, acceleration, force or voltage; the same kind of
        value in all runs. With ``pp`` or ``rms`` behind the unit, ``"7 mil pp"``, it becomes the peak of the sinusoid.
    phase
        Of the vibration against the mark, rad; without it only :func:`~autobalancer.measure.four_run` can use the reading.
    sensor
        Its name.
    speed
        Of the rotor, rad/s, where there are several.
    amplitude_deviation, phase_deviation
        One standard deviation, in the units of both.
    """

    amplitude: float | str
    phase: float | str | None = None
    sensor: str = "1"
    speed: float | str | None = None
    amplitude_deviation: float | str | None = None
    phase_deviation: float | str | None = None
    unit: str = field(init=False, default="m")

    def __post_init__(self) -> None:
        value, unit = one_of("amplitude", self.amplitude, AMPLITUDES, amplitude=True)
        if not value >= 0.0:
            raise QuestionError(f"amplitude: given {self.amplitude!r}; must not be below zero")
        found: dict[str, Any] = {"amplitude": value, "unit": unit, "sensor": str(self.sensor)}
        for name, si in (
            ("phase", "rad"),
            ("speed", "rad/s"),
            ("amplitude_deviation", unit),
            ("phase_deviation", "rad"),
        ):
            given = getattr(self, name)
            found[name] = (
                math.nan if given is None else argument(name, given, si, amplitude=name == "amplitude_deviation")
            )
        for name in ("amplitude_deviation", "phase_deviation"):
            if found[name] <= 0.0:
                raise QuestionError(f"{name}: given {getattr(self, name)!r}; must be above zero")
        if abs(found["phase"]) > TURNS:
            raise QuestionError(
                f"phase: given {found['phase']:g} rad, more than two turns; a phase in degrees needs its unit: "
                f"'{found['phase']:g} deg'"
            )
        _set(self, **found)


@dataclass(frozen=True)
class BalanceRun:
    """One run: all masses on the rotor besides its own unbalance, and the readings.

    ``name`` is used in messages; ``trim`` marks a run that only checks the correction.
    """

    name: str
    readings: Sequence[Reading]
    masses: Sequence[TrialMass] = ()
    trim: bool = False

    def __post_init__(self) -> None:
        _set(self, readings=tuple(self.readings), masses=tuple(self.masses))


def one_of(name: str, value: float | str, units: Sequence[str], amplitude: bool = False) -> tuple[float, str]:
    """A quantity that may have one of several dimensions, in SI, and its unit; a number has the first.

    The suffix of an ``amplitude`` is understood.

    Raises
    ------
    UnitError
        If it has none of them.
    """
    if not isinstance(value, str):
        return argument(name, value, units[0]), units[0]
    reason = ""
    for unit in units:
        try:
            return argument(name, value, unit, amplitude), unit
        except UnitError as error:
            reason = reason or str(error)
    other = " is wanted here" in reason  # it is a quantity, but none of these
    raise UnitError(
        f"{name}: given {value!r}; give a number with a unit, one of {', '.join(units)}" if other else reason
    )


def _set(record: Any, **values: Any) -> None:
    for name, value in values.items():
        object.__setattr__(record, name, value)

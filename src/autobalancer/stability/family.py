"""A machine with one or several of its numbers free: the vector field as a function of parameters.

A parameter is a name of :data:`NAMES`, or a path of :func:`autobalancer.assembly.parameters.with_parameter` such as
``"balancers[1].races[1].drag.beta"``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from autobalancer.assembly.parameters import with_parameter
from autobalancer.catalog.resolve import fluid_numbers, resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, PrescribedSpeed
from autobalancer.machine.balancer.drag import DragTorque
from autobalancer.machine.profile import Constant
from autobalancer.stability.lateral import Floats, Plane, plane
from autobalancer.stability.vector_field import Field
from autobalancer.units import to_si

NAMES = {
    "speed": ("rotor speed", "rad/s"),
    "unbalance": ("unbalance", "kg*m"),
    "drag": ("drag torque of a ball over its speed", "N*m*s"),
    "viscosity": ("kinematic viscosity", "m^2/s"),
    "ball_mass": ("mass of a ball", "kg"),
    "damping": ("damping of the supports", "N*s/m"),
    "stiffness": ("stiffness of the supports", "N/m"),
}
_UNITS = {
    "mass": "kg", "stiffness": "N/m", "damping": "N*s/m", "moment": "kg*m", "radius": "m", "angle": "rad", "beta": "N*m*s",
    "orbit_radius": "m", "race_radius": "m", "eccentricity": "m", "eccentricity_angle": "rad", "diameter": "m", "temperature": "K",
    "density": "kg/m^3", "viscosity": "m^2/s", "clear_width": "m",
}  # fmt: skip


class Family:
    """Vector fields of a machine at values of its free parameters, SI.

    Parameters
    ----------
    machine
        Isotropic, without gravity in the plane.
    parameters
        Names or paths; every later call gives one value for each.
    speed
        Rotor speed where it is not a parameter; by default that of a machine with a prescribed constant speed.

    Raises
    ------
    QuestionError
        For an unknown parameter, one that has no effect or is no number, a missing speed, orthotropic supports, gravity.
    """

    def __init__(self, machine: Machine, parameters: Sequence[str], speed: float | None = None) -> None:
        if not machine.rotor.isotropic:
            raise QuestionError(
                "branches: the supports are not isotropic, so that no state rests in the rotor; "
                "use stability() for its Floquet multipliers, or simulate it"
            )
        self.machine, self.parameters = machine, tuple(parameters)
        for name in self.parameters:
            self._check(name)
        if "speed" not in self.parameters:
            speed = _speed_of(machine) if speed is None else speed
            if not (math.isfinite(speed) and speed > 0.0):
                raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")
        self._speed = speed
        self._at = lru_cache(maxsize=64)(self._build)

    def __call__(self, *values: float) -> Field:
        """The field at these values."""
        return self._at(tuple(float(value) for value in values))

    def read(self, index: int, value: float | str) -> float:
        """A value of parameter ``index`` in SI; texts have a unit."""
        name = self.parameters[index]
        if name in NAMES:
            return float(to_si(value, NAMES[name][1]))
        return _entry(with_parameter(self.machine, name, value), name)

    def now(self, index: int) -> float:
        """The value that the machine itself has."""
        name = self.parameters[index]
        if name not in NAMES:
            return _entry(self.machine, name)
        p = plane(self.machine)
        if name == "speed":
            return _speed_of(self.machine)
        if name == "ball_mass":
            return resolve(self.machine)[0].mass
        if name == "viscosity":
            return float(_viscosities(self.machine)[0])
        values = {"unbalance": abs(p.unbalance), "damping": p.damping[0], "stiffness": p.stiffness[0]}
        return values[name] if name in values else float(p.drag[0])

    def label(self, index: int) -> tuple[str, str]:
        """Long name and SI unit of a parameter."""
        name = self.parameters[index]
        return NAMES[name] if name in NAMES else (name, _UNITS.get(name.rsplit(".", 1)[-1], ""))

    def _build(self, values: tuple[float, ...]) -> Field:
        machine, speed = self.machine, self._speed
        named: dict[str, float] = {}
        for name, value in zip(self.parameters, values, strict=True):
            if name in NAMES:
                named[name] = value
            else:
                machine = with_parameter(machine, name, value)
        p = plane(machine)
        for name, value in named.items():
            if name == "speed":
                speed = value
            else:
                p = _changed(p, machine, name, value)
        assert speed is not None
        return Field(p, speed)

    def _check(self, name: str) -> None:
        if name in NAMES:
            if name in ("drag", "viscosity", "ball_mass") and not resolve(self.machine):
                raise QuestionError(f"parameter {name!r}: the machine has no balls")
            if name == "viscosity":
                _viscosities(self.machine)
            return
        if re.match(r"(drive|start|run)\b", name):
            raise QuestionError(
                f"parameter {name!r}: has no effect on steady states; for the rotor speed write 'speed'"
            )
        if "." not in name:
            raise QuestionError(
                f"parameter: given {name!r}; must be a path like 'rotor.mass', or one of {', '.join(NAMES)}"
            )
        try:
            _entry(self.machine, name)
        except (AttributeError, IndexError):
            with_parameter(self.machine, name, 1.0)  # says what there is
            raise


def _changed(p: Plane, machine: Machine, name: str, value: float) -> Plane:
    ones = np.ones(p.moment.size)
    if name == "unbalance":
        size = abs(p.unbalance)
        return replace(p, unbalance=value * (p.unbalance / size if size else 1.0))
    if name == "damping":
        return replace(p, damping=(value, value))
    if name == "stiffness":
        return replace(p, stiffness=(value, value))
    if name == "drag":
        return replace(p, drag=value * ones)
    if name == "viscosity":
        return replace(p, drag=p.drag * value / _viscosities(machine))
    balls = resolve(machine)
    mass = np.array([value - ball.displaced for ball in balls])
    orbit = np.array([ball.orbit_radius for ball in balls])
    spin = np.array([ball.spin_ratio for ball in balls])
    fluid = np.array([ball.virtual_mass * ball.displaced for ball in balls])
    inertia = ((1.0 + spin) * value + fluid) * orbit**2
    total = float(machine.rotor.mass) + float(mass.sum())
    return replace(p, mass=total, ball_mass=mass, moment=mass * orbit, inertia=inertia)


def _viscosities(machine: Machine) -> Floats:
    """Kinematic viscosity at every ball, m^2/s."""
    found = []
    for b, balancer in enumerate(machine.balancers, 1):
        for r, race in enumerate(balancer.races, 1):
            if race.fluid is None or isinstance(race.drag, DragTorque):
                raise QuestionError(
                    f"parameter 'viscosity': the drag in balancers[{b}].races[{r}] does not follow from a fluid; take 'drag'"
                )
            found += [fluid_numbers(race.fluid)[1]] * race.ball_count
    return np.array(found)


def _speed_of(machine: Machine) -> float:
    if isinstance(machine.drive, PrescribedSpeed) and isinstance(machine.drive.profile, Constant):
        return float(machine.drive.profile.speed)
    raise QuestionError("speed: the machine has no constant prescribed speed; give one, in rad/s")


def _entry(machine: Machine, path: str) -> float:
    entry: Any = machine
    for piece in path.split("."):
        name, *places = piece.replace("]", "").split("[")
        entry = getattr(entry, name)
        for place in places:
            entry = entry[int(place) - 1]
    if isinstance(entry, bool) or not isinstance(entry, float):
        raise QuestionError(
            f"parameter {path!r}: is {entry!r} in this machine; must be a number that can change smoothly"
        )
    return float(entry)

"""A machine with one or several of its numbers free: the vector field as a function of parameters.

A parameter is ``speed``, a name of :data:`autobalancer.machine.plain_names.QUANTITIES` but ``count``, ``plateau`` and
``rolling_resistance``, or several joined by ``&``, or a path such as ``"balancers[1].races[1].balls[1].diameter"``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from autobalancer.assembly.forces.rows import has_forces
from autobalancer.assembly.quantities import si_value, value_of, with_quantity
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, PlanarRotor, PrescribedSpeed
from autobalancer.machine.plain_names import QUANTITIES, axis_attributes, named_unit, parts_of
from autobalancer.machine.profile import Constant
from autobalancer.stability.continuation.symmetry import Groups, merged
from autobalancer.stability.host.cycle import Cycle, Equations
from autobalancer.stability.host.planar import Matrix, Plane, plane
from autobalancer.stability.host.reduction import basis_for, projected
from autobalancer.stability.host.stations import (
    Stations,
    in_plane,
    of_plane,
    refuse_motion_along_the_axis,
    stations,
)
from autobalancer.stability.host.vector_field import Field
from autobalancer.units import to_si
from autobalancer.units.ranges import ends, example, is_range

FIXED = ("count", "plateau", "rolling_resistance")  # no number that varies, or without effect where balls move slowly
QUICK = ("unbalance", "drag")  # changed without going through the description of the machine
QUICK_IN_PLANE = (*QUICK, "damping", "stiffness", "viscosity", "ball_mass")
FIRST_COUNT = 9  # harmonics of a state on anisotropic supports, until more are needed
SMOOTH = ("speed", *(name for name in QUANTITIES if name not in FIXED))


class Family:
    """Vector fields of a machine at values of its free parameters, SI.

    Parameters
    ----------
    machine
        With any rotor, without gravity across its axis.
    parameters
        Names or paths; every later call gives one value for each.
    speed
        Rotor speed where it is not a parameter; by default that of a machine with a prescribed constant speed.

    Raises
    ------
    QuestionError
        For an unknown parameter, one that has no effect or is no number, a missing speed, gravity, or anisotropic supports that
        push along the axis or turn the rotor about it, too.
    """

    def __init__(self, machine: Machine, parameters: Sequence[str], speed: float | None = None) -> None:
        self.machine, self.parameters = machine, tuple(parameters)
        planar = isinstance(machine.rotor, PlanarRotor)
        self._plane = plane(machine) if planar and not has_forces(machine) else None
        self._stations = in_plane if planar else stations
        self._base = self._stations(machine)
        self._basis: Matrix | None = None
        self.count = 1 if self._base.isotropic else FIRST_COUNT  # of harmonics of a state
        if self.count > 1:
            refuse_motion_along_the_axis(self._base.model)
        for name in self.parameters:
            for part in parts_of(name):
                self._check(part)
        if "speed" not in self.parameters:
            speed = _constant_speed(machine) if speed is None else speed
            if not (math.isfinite(speed) and speed > 0.0):
                raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")
        self._speed = speed
        self._at = lru_cache(maxsize=64)(self._build)
        self.merged = lru_cache(maxsize=64)(self._merged)

    def __call__(self, *values: float) -> Equations:
        """The field at these values."""
        return self._at(tuple(float(value) for value in values))

    def reduce(self, highest: float) -> None:
        """Take fewer coordinates of a rotor that has many, for speeds up to ``highest``, rad/s."""
        self._basis = basis_for(self._base, highest)
        self._forget()

    def refine(self, count: int) -> None:
        """Count so many harmonics of a state."""
        self.count = count
        self._forget()

    def _forget(self) -> None:
        self._at.cache_clear()
        self.merged.cache_clear()

    def _merged(self, groups: Groups, *values: float) -> Equations:
        """The field at these values with every group of balls as one ball."""
        whole = self(*values)
        return self._equations(merged(whole.host, groups), whole.speed)

    def _equations(self, host: Stations, speed: float) -> Equations:
        if self.count > 1:
            return Cycle(host, speed, self.count)
        if not host.isotropic:
            raise QuestionError(
                "branches: the supports become different along x and y on the way; begin with a machine on which they differ"
            )
        return Field(host, speed)

    def read(self, index: int, value: float | str) -> float:
        """A value of parameter ``index`` in SI; texts have a unit."""
        name = self.parameters[index]
        return float(to_si(value, "rad/s") if name == "speed" else si_value(self.machine, name, value))

    def ends(self, index: int, start: float | str, end: float | str | None) -> tuple[float, float]:
        """Both ends of the range of a parameter in SI; without ``end`` the first is a text with both."""
        name = self.parameters[index]
        if end is not None:
            return self.read(index, start), self.read(index, end)
        if not is_range(start):
            raise QuestionError(
                f"{name}: given {start!r} only; give the other end too, or both as {example(named_unit(name))}"
            )
        first, last = ends(name, str(start), named_unit(name))
        return self.read(index, first), self.read(index, last)

    def now(self, index: int) -> float:
        """The value that the machine itself has; nan if it has none, or not one for all."""
        if self._plane is None and self.parameters[index] == "unbalance":
            return abs(self._base.unbalance)
        return value_of(self.machine, self.parameters[index])

    def attributes(self, index: int) -> dict[str, str]:
        """Long name, SI unit and symbol of a parameter."""
        return axis_attributes(self.parameters[index])

    def _build(self, values: tuple[float, ...]) -> Equations:
        machine, speed = self.machine, self._speed
        quick: dict[str, float] = {}
        for name, value in zip(self.parameters, values, strict=True):
            if name == "speed":
                speed = value
            elif name in (QUICK if self._plane is None else QUICK_IN_PLANE):
                quick[name] = value
            else:
                machine = with_quantity(machine, name, value)
        assert speed is not None
        if self._plane is not None:
            p = self._plane if machine is self.machine else plane(machine)
            for name, value in quick.items():
                p = _changed(p, machine, name, value)
            return self._equations(of_plane(p), speed)
        host = self._base if machine is self.machine else self._stations(machine)
        for name, value in quick.items():
            host = _scaled(host, name, value)
        return self._equations(host if self._basis is None else projected(host, self._basis), speed)

    def _check(self, name: str) -> None:
        if name != "speed" and "." not in name and name not in SMOOTH:
            raise QuestionError(
                f"parameter: given {name!r}; must be one of {', '.join(SMOOTH)}, or a path like 'rotor.mass'"
            )
        if re.match(r"(drive|start|run)\b", name):
            raise QuestionError(
                f"parameter {name!r}: has no effect on steady states; for the rotor speed write 'speed'"
            )
        if name == "speed":
            return
        try:
            value = value_of(self.machine, name)
        except (AttributeError, IndexError):
            with_quantity(self.machine, name, 1.0)  # says what there is
            raise
        if name in ("stiffness", "damping") and math.isnan(value) and isinstance(self.machine.rotor, PlanarRotor):
            raise QuestionError(
                f"parameter {name!r}: would make x and y alike, and those of this machine differ; give the path of one of them, "
                f"'rotor.{name}[1]', or both in proportion, 'rotor.{name}[1] & rotor.{name}[2]'"
            )
        if name in ("viscosity", "ball_diameter"):
            with_quantity(self.machine, name, 1e-3 if math.isnan(value) else value)  # says why it cannot change
        if name.endswith(".count"):
            raise QuestionError(f"parameter {name!r}: must be a number that can change smoothly")


def _scaled(host: Stations, name: str, value: float) -> Stations:
    """The same for any rotor; all its unbalances keep their proportions."""
    if name == "drag":
        return replace(host, drag=np.full(host.moment.size, value))
    size = abs(host.unbalance)
    if size == 0.0:
        raise QuestionError(
            "parameter 'unbalance': the unbalances of this machine have no resultant; give the path of one of them, such as "
            "'unbalances[1].moment'"
        )
    return replace(host, load=host.load * (value / size), unbalance=host.unbalance * (value / size))


def _changed(p: Plane, machine: Machine, name: str, value: float) -> Plane:
    """What ``with_quantity`` would give, without going through the description of the machine."""
    if name == "unbalance":
        size = abs(p.unbalance)
        return replace(p, unbalance=value * (p.unbalance / size if size else 1.0))
    if name == "damping":
        return replace(p, damping=(value, value))
    if name == "stiffness":
        return replace(p, stiffness=(value, value))
    if name == "drag":
        return replace(p, drag=np.full(p.moment.size, value))
    if name == "viscosity":
        now = value_of(machine, "viscosity")
        if math.isnan(now):
            return plane(with_quantity(machine, name, value), p.unbalance)
        return replace(p, drag=p.drag * value / now)
    balls, rotor = resolve(machine), machine.rotor
    assert isinstance(rotor, PlanarRotor)
    mass = np.array([value - ball.displaced for ball in balls])
    orbit = np.array([ball.orbit_radius for ball in balls])
    kept = [ball.mass / value if ball.body == "pendulum" else 1.0 for ball in balls]  # whose own inertia stays
    spin = np.array([ball.spin_ratio * share for ball, share in zip(balls, kept, strict=True)])
    fluid = np.array([ball.virtual_mass * ball.displaced for ball in balls])
    inertia = ((1.0 + spin) * value + fluid) * orbit**2
    return replace(p, mass=float(rotor.mass) + float(mass.sum()), ball_mass=mass, moment=mass * orbit, inertia=inertia)


def _constant_speed(machine: Machine) -> float:
    if isinstance(machine.drive, PrescribedSpeed) and isinstance(machine.drive.profile, Constant):
        return float(machine.drive.profile.speed)
    raise QuestionError("speed: the machine has no constant prescribed speed; give one, in rad/s")

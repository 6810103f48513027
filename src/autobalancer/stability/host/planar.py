"""What stability needs of a machine at one speed: the rotor's receptance, unbalance, and the balls with their races."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.profile import unbalance_vector
from autobalancer.assembly.rotors.hardening import planar_springs
from autobalancer.assembly.system import total_mass
from autobalancer.catalog.resolve import Ball, capability_of, resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, PlanarRotor

Floats = NDArray[np.float64]
Matrix = NDArray[np.float64]
Complexes = NDArray[np.complex128]

STAND_IN = (
    "or use the equivalent planar machine near one critical speed: equivalent_planar(machine), or "
    "'autobalancer equivalent-planar FILE --out planar.toml'"
)


@dataclass(frozen=True)
class Plane:
    """A planar machine at constant speed W without gravity, SI; mass includes the balls (effective)."""

    mass: float
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    unbalance: complex  # in the rotor, kg m
    ball_mass: Floats  # (n,) effective
    moment: Floats  # (n,) effective mass x orbit radius
    inertia: Floats  # (n,) of the ball angle
    drag: Floats  # (n,)
    race: NDArray[np.int64]  # (n,) number of the ball's race, from 0
    offset: Complexes  # (n,) race center in the rotor
    capability: float = math.inf  # of balls side by side, kg m

    @property
    def isotropic(self) -> bool:
        """Whether x and y are alike."""
        return self.stiffness[0] == self.stiffness[1] and self.damping[0] == self.damping[1]

    @property
    def critical_speeds(self) -> tuple[float, ...]:
        """sqrt(k/M), rad/s, ascending."""
        return tuple(math.sqrt(k / self.mass) for k in sorted(set(self.stiffness)))

    def dynamic_stiffness(self, speed: float) -> complex:
        """Force over forward whirl, N/m; on orthotropic supports that of the forward component of the whirl."""
        x, y = (complex(k - self.mass * speed**2, b * speed) for k, b in zip(self.stiffness, self.damping, strict=True))
        if x == 0.0 or y == 0.0:
            return 0.0
        total = x + y
        if total == 0.0:
            return complex(math.inf)
        return 2.0 * x * y / total

    def backward(self, speed: float, whirl: complex) -> complex:
        """Backward component of the whirl that comes with the forward component ``whirl``: z = a e^iWt + b e^-iWt."""
        x, y = (complex(k - self.mass * speed**2, b * speed) for k, b in zip(self.stiffness, self.damping, strict=True))
        return complex(np.conj(whirl * (y - x) / (y + x)))

    @property
    def fixed_load(self) -> complex:
        """Unbalance and the eccentric masses of the balls, kg m."""
        return self.unbalance + complex((self.ball_mass * self.offset).sum())


def refuse_forces(machine: Machine) -> None:
    """Refuse a machine with forces on its balls.

    Raises
    ------
    QuestionError
        If it has any.
    """
    found = [
        f"balancers[{b + 1}].races[{r + 1}].forces"
        for b, balancer in enumerate(machine.balancers)
        for r, race in enumerate(balancer.races)
        if race.forces
    ]
    if found:
        raise QuestionError(
            f"{found[0]}: this question does not know forces on the balls; simulate the machine instead, or ask without them"
        )


def plane(machine: Machine, unbalance: complex | float | None = None, *, with_forces: bool = False) -> Plane:
    """The plane of a machine; its unbalance is, unless given, the resultant at the end of all schedules.

    It knows nothing of forces on the balls; ``with_forces`` if the caller does.

    Raises
    ------
    QuestionError
        If gravity acts in the plane: then there is no steady state at rest in the rotor. If the rotor is not planar.
    """
    rotor = machine.rotor
    if not isinstance(rotor, PlanarRotor):
        raise QuestionError(
            f"rotor: given one of kind {rotor.kind!r}; this analysis supports planar rotors only. For any rotor use "
            f"equilibria, eigenvalues, borders, stable_windows or border_curve; {STAND_IN}"
        )
    if machine.axis == "horizontal" and machine.gravity > 0.0:
        raise QuestionError(
            "steady states: gravity acts in the plane of this machine (horizontal axis); simulate it instead, "
            "or ask basin with random starts"
        )
    if not with_forces:
        refuse_forces(machine)
    balls: tuple[Ball, ...] = resolve(machine)
    races = sorted({(ball.balancer, ball.race) for ball in balls})
    stiffness, damping = planar_springs(machine, "steady states")
    return Plane(
        mass=total_mass(machine, balls),
        stiffness=stiffness,
        damping=damping,
        unbalance=unbalance_vector(machine, math.inf) if unbalance is None else complex(unbalance),
        ball_mass=np.array([ball.effective_mass for ball in balls]),
        moment=np.array([ball.moment for ball in balls]),
        inertia=np.array([ball.inertia for ball in balls]),
        drag=np.array([ball.drag for ball in balls]),
        race=np.array([races.index((ball.balancer, ball.race)) for ball in balls], np.int64),
        offset=np.array([ball.eccentricity for ball in balls], np.complex128),
        capability=capability_of(balls),
    )

"""What joins the bodies of a rig to each other and to the ground: what a joint is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

from pydantic import model_validator

from autobalancer.errors import Problem
from autobalancer.machine.part import Position, Quantity, key
from autobalancer.machine.plugins import Leaf
from autobalancer.machine.rotors.body import GROUND
from autobalancer.machine.rotors.support import Hardening, Rubber, SpeedTable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

SpringStiffness = Annotated[float, Quantity("N/m", non_negative=True)]
DamperConstant = Annotated[float, Quantity("N*s/m", non_negative=True)]
Direction = tuple[float, float, float]

BESIDE = "along x and y, beside the axis; only if no body of the joint rotates"
RUBBER = "that softens with the amplitude, in place of the two constants"
TABLE = "over the speed, in place of the two constants"
TILT = "against tilting"
TURN = "against rotation about the axis"
HARDENING = "a force across the axis beside the spring, that grows faster than the deflection"
ALONG = "along the axis"
ACROSS = "across the axis"


class Spot(NamedTuple):
    """Where a joint acts: a point (m), and the directions of its own three axes; those of the rig by default."""

    point: Direction
    axes: tuple[Direction, Direction, Direction] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Elements(NamedTuple):
    """Rubber of a joint: the one or two of its six motions that stretch it, from 0, and the rubber."""

    motions: tuple[int, ...]
    rubber: Rubber
    name: str  # of this direction, for people


class Joint(Leaf):
    """Joins the two bodies named in ``between``; the one may be ``"ground"``.

    One that is no :class:`PointJoint` merges them.
    """

    family: ClassVar[str] = "joints"
    one: ClassVar[str] = "joint"
    current: ClassVar[int] = 1
    between: tuple[str, str] = key("names of two bodies, or of one and `ground`")

    @model_validator(mode="after")
    def _two_bodies(self) -> Joint:
        if self.between[0] == self.between[1]:
            raise ValueError(f"between: given {self.between[0]!r} twice; give two bodies, or a body and {GROUND!r}")
        return self

    def unfit(self, turning: int) -> list[Problem]:
        """What is wrong with it where ``turning`` of its two bodies rotate: paths of keys, and messages."""
        return []


class PointJoint(Joint):
    """Springs and dampers at a point: two matrices for the motion of the first body relative to the second.

    The six motions are displacements (m) along x, y and z and rotations (rad) about them, in the axes of the joint. So
    ``matrices`` gives forces (N) and torques (N m) over these, both (6, 6), at an angular frequency of the load, rad/s.

    A joint whose matrices change with the frequency names ``frequencies`` from 0 on, between which they are linear, and beyond
    which it is not used. ``symmetric`` says whether its stiffness and damping are; those of a fluid film are not.
    """

    symmetric: ClassVar[bool] = True
    position: Position = key(ALONG)

    def spots(self) -> tuple[Spot, ...]:
        """Where it acts; the matrices count at each of them."""
        return (Spot((0.0, 0.0, float(self.position))),)

    def matrices(self, speed: float) -> tuple[Matrix, Matrix]:
        """Stiffness and damping, each (6, 6)."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'matrices'")

    def frequencies(self) -> tuple[tuple[float, ...], ...]:
        """Angular frequencies of each of its tables, and of rubber that relaxes, ascending, rad/s."""
        tabled = [tuple(map(float, table.speed)) for table in self.tables() if table is not None]
        return *tabled, *filter(None, (rubber.rubber.frequencies() for rubber in self.rubbers()))

    def tables(self) -> tuple[SpeedTable | None, ...]:
        """Its tables over the speed."""
        return ()

    def rubbers(self) -> tuple[Elements, ...]:
        """Its rubber that softens with the amplitude; in ``matrices`` it counts as in small motions."""
        return ()

    def hardenings(self) -> tuple[Hardening, ...]:
        """Its forces that grow faster than the deflection, along the first two motions; not in ``matrices``."""
        return ()

    @staticmethod
    def _there(*values: tuple[tuple[int, ...], Rubber | None, str]) -> tuple[Elements, ...]:
        return tuple(Elements(motions, rubber, name) for motions, rubber, name in values if rubber is not None)


def exclude_constants(
    table: SpeedTable | None, name: str, constants: tuple[tuple[str, object], ...], pairs: bool = False
) -> None:
    """Refuse a table beside the constants it stands for, and pairs along x and y where there is one direction only."""
    if table is None:
        return
    for other, value in constants:
        if value:
            raise ValueError(f"{other}: '{name}' contains it already; give one or the other")
    if not pairs and any(isinstance(entry, tuple) for entry in (*table.stiffness, *table.damping)):
        raise ValueError(f"{name}: given a pair; this direction has one value at each speed")


def exclude_beside_rubber(rubber: Rubber | None, name: str, constants: tuple[tuple[str, object], ...]) -> None:
    """Refuse rubber beside what it stands for."""
    for other, value in constants:
        if rubber is not None and value:
            raise ValueError(f"{other}: '{name}' contains it already; give one or the other")


def unfit_at(joint: PointJoint, turning: int, offset: tuple[float, float], damped: bool) -> list[Problem]:
    """What is wrong with springs and dampers at a point where ``turning`` of their two bodies rotate."""
    problems: list[Problem] = []
    if turning and offset != (0.0, 0.0):
        problems.append((("offset",), "a joint on a rotating body must be on its axis; leave it out"))
    for name in ("torsional_stiffness", "torsional_damping"):
        if turning and getattr(joint, name, None):
            text = "a body that rotates with the rotor cannot be held against rotation; leave it out"
            problems.append(((name,), text))
    hardening = getattr(joint, "hardening", None)
    if turning == 2 and hardening is not None and hardening.center != (0.0, 0.0):
        text = "between two rotating bodies the middle would rotate with them; leave it out"
        problems.append((("hardening", "center"), text))
    if turning == 2 and damped:
        text = "damping between two rotating bodies rotates with them and can cause whirl; this is not modelled, leave it out"
        problems.append((("damping",), text))
    return problems

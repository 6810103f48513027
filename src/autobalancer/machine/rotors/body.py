"""What every rotor model has, places along its axis, and the rigid body of a rig."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import model_validator

from autobalancer.machine.part import Mass, Name, Part, Position, Quantity, key

GROUND = "ground"
BodyInertia = Annotated[float, Quantity("kg*m^2", non_negative=True)]


class RotorModel(Part):
    """A rotor on its supports; ``kind`` is a ``Literal`` of one word, by which machine files name it.

    It has ``inertia``, ``supports`` and ``stiffness_proportional_damping``, which drives and support forces ask for. Its keys are
    mass, springs and dampers to every theory, unless ``assembly/terms.py`` says otherwise.
    """

    @property
    def one_plane(self) -> bool:
        """Whether it has no length and no tilt, so that all is in one plane."""
        return False


class PlaceQuantity(Quantity):
    """A position along the axis, or the name of a station."""

    def one(self, value: Any) -> Any:
        """The position, m, or the name as it is."""
        if isinstance(value, str) and value.strip()[:1] not in set("+-.0123456789"):
            if not value.strip():
                raise ValueError("given an empty text; give a position along the axis, or the name of a station")
            return value
        return super().one(value)

    @property
    def words(self) -> str:
        """What may be given."""
        return "m, or the name of a station"


Place = Annotated[float | str, PlaceQuantity("m")]


class Station(Part):
    """A named plane across the rotor, to put balancers and unbalances in and to look at.

    ``position`` is along the axis: from the mass center of a rigid rotor, from the left (or upper) end of a shaft, from
    the origin of a rig. In a rig with several bodies ``body`` says which one.
    """

    name: Name = key("given once; balancers, unbalances, forces and results refer to it")
    position: Position = key(
        "along the axis, from the mass center of a rigid rotor, the left end of a shaft, the origin of a rig"
    )
    body: str | None = key("name of a body of a rig or of a disk on a shaft, if the position alone is ambiguous", None)


class Body(Part):
    """A rigid body with its mass center at ``position`` along the axis and at ``offset`` (x, y) beside it.

    Inertias are about the mass center: ``transverse_inertia`` and ``polar_inertia``, or the three of ``inertia`` about
    axes parallel to x, y and z. A ``rotating`` body turns with the rotor; it is round and sits on the axis. A point
    mass has inertias zero and is locked to a body that has some.
    """

    name: Name = key("any except `ground`")
    mass: Mass = key("with all attached parts, without balls")
    position: Position = key("of the mass center along the axis, from an origin of your choice")
    offset: tuple[Position, Position] = key("of the mass center beside the axis, along x and y", (0.0, 0.0))
    transverse_inertia: BodyInertia | None = key("about x and y, through the mass center", None)
    polar_inertia: BodyInertia | None = key("about z, through the mass center", None)
    inertia: tuple[BodyInertia, BodyInertia, BodyInertia] | None = key("about x, y and z, in place of these two", None)
    rotating: bool = key("whether it rotates with the rotor", False)

    @model_validator(mode="after")
    def _possible(self) -> Body:
        if not self.name.strip() or self.name == GROUND:
            raise ValueError(
                f"name: given {self.name!r}; give a non-empty name other than {GROUND!r}, the fixed ground"
            )
        pair = (self.transverse_inertia, self.polar_inertia)
        if (self.inertia is None) == (None in pair) or (self.inertia is not None and pair != (None, None)):
            raise ValueError("give either 'transverse_inertia' and 'polar_inertia', or the three values of 'inertia'")
        jx, jy, jz = self.inertias
        if 2.0 * max(jx, jy, jz) > (jx + jy + jz) * (1.0 + 1e-9):
            raise ValueError(
                f"inertia: given {jx:g}, {jy:g} and {jz:g} kg m^2 about x, y and z; none can be larger than the sum "
                "of the other two"
            )
        if self.rotating and (jx != jy or self.offset != (0.0, 0.0)):
            raise ValueError(
                "rotating: a rotating body needs equal inertias about x and y, and no 'offset'; describe what is "
                "missing to that as an unbalance"
            )
        return self

    @property
    def inertias(self) -> tuple[float, float, float]:
        """About axes through the mass center parallel to x, y and z, kg m^2."""
        if self.inertia is not None:
            return (float(self.inertia[0]), float(self.inertia[1]), float(self.inertia[2]))
        across = float(self.transverse_inertia or 0.0)
        return across, across, float(self.polar_inertia or 0.0)

    @property
    def center(self) -> tuple[float, float, float]:
        """Place of the mass center, x, y, z, m."""
        return float(self.offset[0]), float(self.offset[1]), float(self.position)

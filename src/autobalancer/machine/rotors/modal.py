"""A rotor that is known by its matrices, as finite elements give them, or by its modes at one plane, as a hammer test does."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator, model_validator

from autobalancer.machine.part import Inertia, Label, Listed, Mass, Part, Position, Quantity, Rate, Time, key
from autobalancer.machine.rotors.body import RotorModel
from autobalancer.machine.rotors.support import Support


class Resonance(Part):
    """One mode: it moves the plane as a mass on a spring and a damper would on which the same force acts."""

    mass: Mass = key("modal mass at the plane, without balls: the mode has deflection one there", symbol="m_k")
    frequency: Annotated[float, Quantity("rad/s", positive=True)] = key("undamped natural frequency", symbol="w_k")
    damping_ratio: Annotated[float, Quantity("", non_negative=True)] = key(
        "over critical damping, such as `2 %`", symbol="D_k"
    )


class ModalRotor(RotorModel):
    r"""Modes at the one plane in which unbalance and balls are, alike in all directions.

    The receptance there is $\sum_k 1 / (m_k (\sigma^2 + 2 D_k w_k \sigma + w_k^2))$: each mode is damped by itself, and
    gyroscopic moments do not change them. ``inertia`` (about the shaft, without balls) is needed only where a torque drives.
    """

    kind: Literal["modal"] = "modal"
    one_plane: ClassVar[bool] = True
    resonances: Annotated[tuple[Resonance, ...], Field(min_length=1), Listed] = key("of the rotor on its supports")
    inertia: Inertia | None = key(
        "polar, about the shaft, without balls; required where a torque drives", None, symbol="J_p"
    )

    @property
    def mass(self) -> float:
        """What a fast force at the plane feels, kg."""
        return 1.0 / sum(1.0 / float(mode.mass) for mode in self.resonances)

    @property
    def supports(self) -> tuple[Support, ...]:
        """Not known one by one: they are in the modes."""
        return ()

    @property
    def stiffness_proportional_damping(self) -> float:
        """None beside that of the modes."""
        return 0.0


Direction = Literal["ux", "uy", "uz", "rx", "ry", "rz", "modal", "modal x", "modal y"]
SYMMETRIC = 1e-6  # greatest difference of a matrix from its transpose, over its greatest entry


def _square(value: Any) -> tuple[tuple[float, ...], ...]:
    """Rows of a square matrix of finite numbers, in SI."""
    rows = value if isinstance(value, (list, tuple)) else ()
    if not rows or any(not isinstance(row, (list, tuple)) or len(row) != len(rows) for row in rows):
        raise ValueError("must be a square matrix, row by row")
    for number, row in enumerate(rows, 1):
        if not all(isinstance(entry, (int, float)) and math.isfinite(entry) for entry in row):
            raise ValueError(f"row {number}: must have plain finite numbers, in SI")
    return tuple(tuple(map(float, row)) for row in rows)


SquareMatrix = Annotated[
    tuple[tuple[float, ...], ...], PlainValidator(_square, json_schema_input_type=list[list[float]])
]


class Coordinate(Part):
    """What one row of the matrices is: a motion of a node on the axis, or a mode."""

    direction: Direction = key(
        "`ux uy uz` deflections, `rx ry rz` rotations about these axes, as in programs of finite elements; `modal` is none "
        "of a node, `modal x` moves along x alone"
    )
    position: Position | None = key("of the node along the axis; a mode has none", None)
    translation: tuple[float, float] | None = key(
        "how much it moves as the whole rotor moves by one along x, and along y; of `ux uy` it is one without it", None
    )

    @model_validator(mode="after")
    def _placed(self) -> Coordinate:
        if (self.position is None) != self.direction.startswith("modal"):
            raise ValueError("position: a deflection or a rotation has one, a mode has none")
        return self

    @property
    def moved(self) -> tuple[float, float]:
        """How much it moves as the whole rotor moves by one along x, and along y."""
        return self.translation or (float(self.direction == "ux"), float(self.direction == "uy"))


class MatrixFiles(Part):
    """Files with the matrices, and how many coordinates are made of them; read with the machine file, and replaced by numbers.

    All files lie beside the machine file. A format is known by the end of the name: Matrix Market, NPZ, MAT, Harwell-Boeing,
    triplets as text.
    """

    file: Label | None = key("one file with the matrices M, K, C, G by these names: NPZ or MAT", None)
    mass: Label | None = key("file of the mass matrix", None)
    stiffness: Label | None = key("file of the stiffness matrix", None)
    damping: Label | None = key("file of the damping matrix", None)
    gyroscopic: Label | None = key("file of the gyroscopic matrix at one radian a second", None)
    nodes: Label = key("table with a line for each row of the matrices: `node`, `direction`, `position [mm]`")
    length_unit: Literal["m", "mm", "in"] = key("of the matrices; times are in seconds, rotations in radians")
    mass_unit: Literal["kg", "t", "g", "lb", "lbf*s^2/in"] = key("of the matrices")
    keep: Annotated[tuple[Position, ...], Listed] | None = key(
        "nodes whose motion is kept: supports, stations; without it all, which large matrices do not allow", None
    )
    modes: Annotated[int, Field(strict=True, ge=0)] = key("of the rotor with these nodes held, kept beside them", 20)


class MatricesRotor(RotorModel):
    """A rotor as M, C, G, K over coordinates that are motions of nodes on its axis, and modes.

    M, K and C are symmetric, G antisymmetric. ``supports`` are added to what the matrices contain.
    """

    kind: Literal["matrices"] = "matrices"
    files: MatrixFiles | None = key("read the matrices from files, in place of all keys below but `supports`", None)
    coordinates: Annotated[tuple[Coordinate, ...], Listed] = key("what the rows of the matrices are", ())
    mass_matrix: SquareMatrix = key("M, without balls", (), symbol="M")
    stiffness_matrix: SquareMatrix = key("K", (), symbol="K")
    damping_matrix: SquareMatrix | None = key("C", None, symbol="C")
    gyroscopic_matrix: SquareMatrix | None = key("G at one radian a second; a rotor without it does not gyrate", None)
    supports: Annotated[tuple[Support, ...], Listed] = key("added to what the matrices contain", ())
    inertia: Inertia | None = key("polar, of all that turns; required where a torque drives", None, symbol="J_p")
    total_mass: Mass | None = key("of all that moves across the axis; from M without it", None)
    stiffness_proportional_damping: Time = key("factor t in C = t K, added to C", 0.0)
    source: Label = key("where the matrices come from, for people", "")
    valid_to: Rate | None = key(
        "frequency up to which few coordinates stand for all rows of the files within 1 %", None
    )

    @model_validator(mode="after")
    def _fitting(self) -> MatricesRotor:
        count = len(self.coordinates)
        if not count:
            raise ValueError("coordinates: missing; give them and the matrices, or 'files'")
        for name in ("mass_matrix", "stiffness_matrix", "damping_matrix", "gyroscopic_matrix"):
            rows = getattr(self, name)
            if rows is None:
                continue
            if len(rows) != count:
                raise ValueError(f"{name}: has {len(rows)} rows for {count} coordinates; give one for each")
            sign, word = (-1.0, "antisymmetric") if name == "gyroscopic_matrix" else (1.0, "symmetric")
            limit = SYMMETRIC * max(abs(entry) for row in rows for entry in row)
            for i, j in ((row, column) for row in range(count) for column in range(row + 1)):
                if abs(rows[i][j] - sign * rows[j][i]) > limit:
                    raise ValueError(
                        f"{name}: must be {word}; entries {i + 1}, {j + 1} and {j + 1}, {i + 1} are {rows[i][j]:.6g} "
                        f"and {rows[j][i]:.6g}"
                    )
        nodes = [
            sorted(float(one.position or 0.0) for one in self.coordinates if one.direction == way)
            for way in ("ux", "uy")
        ]
        if nodes[0] != nodes[1] or not nodes[0] or len(set(nodes[0])) < len(nodes[0]):
            raise ValueError("coordinates: each node needs one 'ux' and one 'uy'; the axis of the rotor is z")
        return self

    @property
    def mass(self) -> float:
        """Of all that moves across the axis, kg."""
        if self.total_mass is not None:
            return float(self.total_mass)
        moved = [one.moved[0] for one in self.coordinates]
        return math.fsum(
            a * entry * b
            for a, row in zip(moved, self.mass_matrix, strict=True)
            for entry, b in zip(row, moved, strict=True)
        )

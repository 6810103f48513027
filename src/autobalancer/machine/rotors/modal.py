"""A rotor that is known by its matrices, as finite elements give them, or by its modes, as a modal or a hammer test does."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, model_validator

from autobalancer.errors import MachineError, Problem
from autobalancer.machine.part import Inertia, Label, Listed, Mass, Part, Position, Quantity, Rate, Time, key
from autobalancer.machine.rotors.body import BodyInertia, RotorModel
from autobalancer.machine.rotors.support import Support

LengthUnit = Literal["m", "mm", "in"]
MassUnit = Literal["kg", "t", "g", "lb", "lbf*s^2/in"]
Motions = Annotated[tuple[float, ...], Listed]
# of the mass of the rotor: between these is what moves in any mode as its greatest deflection does
LIGHTEST, HEAVIEST = 1e-3, 10.0
STEEPER = 30.0  # by which slopes of a shape may differ from those between its deflections


class Resonance(Part):
    """One mode: it moves the plane as a mass on a spring and a damper would on which the same force acts.

    Of a rotor with stations along its axis it has a ``shape``, its deflections there; it moves along x and along y alike, or with
    ``shape_y`` along y as that says, as modes of rotors on supports that are not alike do.
    """

    mass: Mass | None = key(
        "modal mass, without balls: of a rotor that is known at one plane that of a mode with deflection one there; else that of "
        "the mode with its `shape`, 1 kg without it, as shapes have that are normalised to the mass matrix",
        None,
        symbol="m_k",
    )
    frequency: Annotated[float, Quantity("rad/s", non_negative=True)] = key(
        "undamped natural frequency; zero is the motion of a rotor without its supports", symbol="w_k"
    )
    damping_ratio: Annotated[float, Quantity("", non_negative=True)] = key(
        "over critical damping, such as `2 %`", symbol="D_k"
    )
    shape: Motions = key("deflection at each of the `positions`", ())
    slope: Annotated[tuple[Annotated[float, Quantity("1/m")], ...], Listed] = key("of the shape there, dx/dz", ())
    shape_y: Motions = key("deflections along y, of a rotor that is not round; `shape` is along x then", ())
    slope_y: Annotated[tuple[Annotated[float, Quantity("1/m")], ...], Listed] = key("of these, dy/dz", ())
    participation: Motions = key(
        "how much the mode moves as the whole rotor moves by one along x and along y, one number if these are alike; "
        "needed for the weight across a horizontal axis and for motions of the base",
        (),
    )

    @property
    def modal_mass(self) -> float:
        """As given, or 1 kg of a shape that is normalised to the mass matrix."""
        return 1.0 if self.mass is None else float(self.mass)


class ModeFiles(Part):
    """A file with modes and their shapes, which lies beside the machine file; read with it, and replaced by numbers."""

    file: Label = key(
        "table with a line for each mode, as `frequency [Hz], damping ratio [%], mass [kg], x at 0 mm, slope at 0 mm [1/m]`, "
        "or a universal file with data sets 55"
    )
    nodes: Label | None = key(
        "table `node, position [mm]` for a universal file; without it the z of its data set 15 or 2411 is taken", None
    )
    length_unit: LengthUnit | None = key("of a universal file, which says it itself in data set 164", None)
    mass_unit: MassUnit | None = key("of modal masses of a universal file", None)
    keep: Annotated[tuple[Position, ...], Listed] | None = key(
        "positions of the stations whose shapes are taken; without it all", None
    )
    modes: Annotated[int, Field(strict=True, ge=1)] | None = key(
        "how many of them, from the lowest; all without it", None
    )


class ModalRotor(RotorModel):
    r"""Modes of a rotor: with shapes at stations along its axis, or at the one plane in which unbalance and balls are.

    The receptance at one plane is $\sum_k 1 / (m_k (\sigma^2 + 2 D_k w_k \sigma + w_k^2))$, between stations with
    the shapes there in place of the one: each mode is damped by itself. Gyroscopic moments are those of
    ``polar_inertias``, ``supports`` are added. ``inertia`` (about the shaft, without balls) is needed only where a torque drives.
    """

    kind: Literal["modal"] = "modal"
    files: ModeFiles | None = key("read `positions` and `resonances` from a file", None)
    resonances: Annotated[tuple[Resonance, ...], Listed] = key("of the rotor on its supports, one at least", ())
    positions: Annotated[tuple[Position, ...], Listed] = key(
        "of the stations at which shapes are given; without it the rotor is known at one plane", ()
    )
    polar_inertias: Annotated[tuple[BodyInertia, ...], Listed] = key(
        "of what sits at each of the `positions`, for gyroscopic moments; modes need a `slope` there", (), symbol="J_p"
    )
    supports: Annotated[tuple[Support, ...], Listed] = key("at stations, added to what the modes contain", ())
    stiffness_proportional_damping: Time = key("factor t in C = t K, added to the damping of modes and supports", 0.0)
    inertia: Inertia | None = key(
        "polar, about the shaft, without balls; required where a torque drives", None, symbol="J_p"
    )
    total_mass: Mass | None = key("of all that moves across the axis, beside shapes", None)
    modes: Annotated[int, Field(strict=True, ge=1)] | None = key(
        "pairs of modes that a simulation in time keeps; as many as are needed if left out", None
    )
    source: Label = key("where the modes come from, for people", "")

    @property
    def one_plane(self) -> bool:
        """Whether no shapes are given."""
        return not self.positions

    @model_validator(mode="after")
    def _fitting(self) -> ModalRotor:
        if not self.resonances:
            raise ValueError("resonances: missing; give one at least, or 'files'")
        problems: list[Problem] = []
        if self.one_plane:
            others = ("polar_inertias", "supports")
            problems += [
                ((key,), "needs 'positions', and a 'shape' of each mode") for key in others if getattr(self, key)
            ]
        elif (places := [float(z) for z in self.positions]) != sorted(set(places)):
            problems.append((("positions",), "must ascend, each once"))
        elif self.polar_inertias and len(self.polar_inertias) != len(places):
            problems.append((("polar_inertias",), f"has {len(self.polar_inertias)} values for {len(places)} positions"))
        if not self.one_plane and self.total_mass is None and not self.knows_whole:
            problems.append(
                (("total_mass",), "missing; shapes do not say it; or give the 'participation' of each mode")
            )
        uneven = any(mode.shape_y for mode in self.resonances)
        for number, mode in enumerate(self.resonances):
            if self.one_plane and (mode.mass is None or not mode.frequency):
                name = "mass" if mode.mass is None else "frequency"
                problems.append((("resonances", number, name), "must be above zero at one plane; or give 'positions'"))
            for name in ("shape", "slope", "shape_y", "slope_y"):
                given = len(getattr(mode, name))
                wanted = name == "shape" or (name == "shape_y" and uneven) or (name == "slope" and self.polar_inertias)
                if given != len(self.positions) and (given or wanted):
                    text = f"has {given} values for {len(self.positions)} positions of the rotor"
                    problems.append((("resonances", number, name), text))
            if bool(mode.slope) != bool(self.resonances[0].slope) or (
                uneven and bool(mode.slope) != bool(mode.slope_y)
            ):
                problems.append(
                    (("resonances", number, "slope"), "give slopes of all modes, along x and y, or of none")
                )
            if self.knows_whole and len(mode.participation) != 1 + uneven:
                text = f"has {len(mode.participation)} values; give {1 + uneven} of each mode"
                problems.append((("resonances", number, "participation"), text))
        problems = problems or [(("resonances",), text) for text in self._out_of_scale()]
        if problems:
            raise MachineError.of("ModalRotor", problems)
        return self

    def _out_of_scale(self) -> list[str]:
        """Why no body of this mass has these shapes: another unit, or another mass that they are normalised to."""
        modes, found = self.resonances, []
        greatest = [max(map(abs, (*mode.shape, *mode.shape_y)), default=0.0) for mode in modes]
        moved = [mode.modal_mass / size**2 for mode, size in zip(modes, greatest, strict=True) if size]
        if moved and not (max(moved) > LIGHTEST * self.mass and min(moved) < HEAVIEST * self.mass):
            found.append(
                f"shapes out of scale: a mode moves as {min(moved):.3g} to {max(moved):.3g} kg would where it moves most, the "
                f"rotor has {self.mass:.4g} kg; mind the units of shapes and masses, or give each mode its 'mass'"
            )
        elif len(modes) > 1 and all(
            mode.mass is None and abs(one - 1.0) < 1e-6 for mode, one in zip(modes, greatest, strict=True)
        ):
            found.append(
                "the greatest deflection of each mode is one, so they are not normalised to 1 kg: give each its 'mass'"
            )
        # between two positions a shape rises by about the mean of its slopes there
        steps = [b - a for a, b in zip(self.positions[:-1], self.positions[1:], strict=True)]
        curves = [
            (of, its) for mode in modes for of, its in ((mode.shape, mode.slope), (mode.shape_y, mode.slope_y)) if its
        ]
        rise = [(of[i + 1] - of[i]) / step for of, _ in curves for i, step in enumerate(steps)]
        lean = [0.5 * (its[i] + its[i + 1]) for _, its in curves for i in range(len(steps))]
        # not where all of it is left by symmetry
        if (
            not rise
            or math.hypot(*rise) * sum(steps) < 0.1 * max(greatest)
            or math.hypot(*lean) < 0.1 * max(abs(one) for _, its in curves for one in its)
        ):
            return found
        ratio = math.hypot(*lean) / math.hypot(*rise)
        alike = sum(a * b for a, b in zip(lean, rise, strict=True)) / (math.hypot(*lean) * math.hypot(*rise))
        if not 1.0 / STEEPER < ratio < STEEPER:
            found.append(
                f"slopes are {ratio:.3g} times as steep as deflections between positions say: mind their unit, 1/m"
            )
        elif alike < -0.5:
            found.append("slopes fall where deflections rise: mind their sign, and the order of the positions")
        return found

    @property
    def knows_whole(self) -> bool:
        """Whether it is said how the modes move as the whole rotor does."""
        return any(mode.participation for mode in self.resonances)

    @property
    def mass(self) -> float:
        """Of all that moves across the axis; at one plane what a fast force there feels, kg."""
        if self.one_plane:
            return 1.0 / sum(1.0 / mode.modal_mass for mode in self.resonances)
        return self.carried if self.total_mass is None else float(self.total_mass)

    @property
    def carried(self) -> float:
        """The mass that the modes move as the whole rotor moves along x, kg."""
        return math.fsum(mode.modal_mass * mode.participation[0] ** 2 for mode in self.resonances)


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
    OP4 and punch of Nastran, triplets as text.
    """

    file: Label | None = key("one file with the matrices M, K, C, G by these names: NPZ, MAT, OP4 or punch", None)
    mass: Label | None = key("file of the mass matrix", None)
    stiffness: Label | None = key("file of the stiffness matrix", None)
    damping: Label | None = key("file of the damping matrix", None)
    gyroscopic: Label | None = key("file of the gyroscopic matrix at one radian a second", None)
    nodes: Label = key("table with a line for each row of the matrices: `node`, `direction`, `position [mm]`")
    rows: Label | None = key(
        "mapping file of Ansys, with number, node and direction of each row; `nodes` is a table `node, position [mm]` then",
        None,
    )
    length_unit: LengthUnit = key("of the matrices; times are in seconds, rotations in radians")
    mass_unit: MassUnit = key("of the matrices")
    keep: Annotated[tuple[Position, ...], Listed] | None = key(
        "nodes whose motion is kept: supports, stations; without it all, which large matrices do not allow", None
    )
    modes: Annotated[int, Field(strict=True, ge=0)] = key("of the rotor with these nodes held, kept beside them", 20)


class MatricesRotor(RotorModel):
    """A rotor as M, C, G, K over coordinates that are motions of nodes on its axis, and modes.

    M, K and C are symmetric, G antisymmetric. ``supports`` are added to what the matrices contain. Those of files are reduced
    to the nodes that are kept, and modes with these held (Craig and Bampton 1968).
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
    modes: Annotated[int, Field(strict=True, ge=1)] | None = key(
        "pairs of modes that a simulation in time keeps; as many as are needed if left out", None
    )
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

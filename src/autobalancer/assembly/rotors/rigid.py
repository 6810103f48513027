"""The rigid rotor; the planar one, which is its limit without tilt; modes; and any rotor by its matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.rotors.lateral_model import Axis, LateralModel, Rows, add_support, matrices, table_speeds
from autobalancer.errors import MachineError
from autobalancer.machine import MatricesRotor, ModalRotor, PlanarRotor, RigidRotor


@dataclass(frozen=True)
class RigidAxis:
    """A straight axis: deflection x + z slope; ``reach`` are the outermost places that matter."""

    reach: tuple[float, float]

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        if body is not None:
            raise ValueError(f"body {body!r}: a rigid rotor is one body; leave it out")
        return Rows(np.array([1.0, float(position or 0.0)]), np.array([0.0, 1.0]))

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        return [(z, self.rows(z, None)) for z in self.reach]


@dataclass(frozen=True)
class Point:
    """The one plane of a rotor that has no length; it moves as all its coordinates together."""

    pairs: int = 1

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        if position or body is not None:
            raise ValueError("this rotor has one plane only; leave the place out")
        return Rows(np.ones(self.pairs), np.zeros(self.pairs))

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        return [(0.0, self.rows(None, None))]


@matrices.register
def rigid(rotor: RigidRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates X, phi_Y, Y, -phi_X of Rodrigues et al. 2011, (1)."""
    positions = [float(support.position) for support in rotor.supports]
    axis = RigidAxis((min(positions), max(positions)))
    speeds, damping, stiffness = _supported(rotor, axis, *np.zeros((2, 4, 4)))
    mass, gyroscopic = np.diag([rotor.mass, rotor.transverse_inertia] * 2), np.zeros((4, 4))
    gyroscopic[1, 3], gyroscopic[3, 1] = rotor.polar_inertia, -rotor.polar_inertia
    return LateralModel(
        mass, gyroscopic, speeds, damping, stiffness, 2, ("x", "slope of x", "y", "slope of y"), axis,
        float(rotor.polar_inertia), float(rotor.mass),
    )  # fmt: skip


@matrices.register
def planar(rotor: PlanarRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates X, Y."""
    inertia = None if rotor.inertia is None else float(rotor.inertia)
    return LateralModel(
        float(rotor.mass) * np.eye(2), np.zeros((2, 2)), np.zeros(1), np.diag(rotor.damping_xy)[None],
        np.diag(rotor.stiffness_xy)[None], 1, ("x", "y"), Point(), inertia, float(rotor.mass),
    )  # fmt: skip


@matrices.register
def modal(rotor: ModalRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates: the deflection that each mode brings to the plane along x, then along y; with shapes those of stations."""
    mass, frequency, ratio = np.array(
        [(mode.modal_mass, mode.frequency, mode.damping_ratio) for mode in rotor.resonances], np.float64
    ).T
    inertia = None if rotor.inertia is None else float(rotor.inertia)
    if not rotor.one_plane:
        return _with_shapes(rotor, np.array([mass, frequency, ratio]), inertia)
    count = mass.size
    mass, frequency, ratio = (np.tile(values, 2) for values in (mass, frequency, ratio))
    names = tuple(f"mode {number} along {axis}" for axis in "xy" for number in range(1, count + 1))
    return LateralModel(
        np.diag(mass), np.zeros((2 * count, 2 * count)), np.zeros(1), np.diag(2.0 * ratio * frequency * mass)[None],
        np.diag(mass * frequency**2)[None], count, names, Point(count), inertia, rotor.mass,
    )  # fmt: skip


# Modes with shapes at stations. Where all move along x and y alike, their amplitudes are the coordinates. Else these are
# the deflections (and slopes) of the stations along x and along y, and combinations of modes that move none of them.


RANK = 1e-6  # of the greatest singular value of the shapes, below which they do not move stations by themselves


def _with_shapes(rotor: ModalRotor, modes: Floats, inertia: float | None) -> LateralModel:
    """A rotor of modes with shapes at stations; ``modes`` are masses, frequencies and damping ratios, (3, modes)."""
    places, count = np.array([float(z) for z in rotor.positions]), len(rotor.resonances)
    listed = [(m.shape, m.slope, m.shape_y or m.shape, m.slope_y or m.slope) for m in rotor.resonances]
    x, slope_x, y, slope_y = (np.array(rows, np.float64).reshape(count, -1).T for rows in zip(*listed, strict=True))
    whole = np.array([(m.participation[0], m.participation[-1]) for m in rotor.resonances if m.participation])
    alike = not rotor.resonances[0].shape_y
    if alike:
        modes = np.tile(modes, 2)
        x, slope_x, y, slope_y = (
            np.hstack([part * (axis == "x"), part * (axis == "y")])
            for part, axis in ((x, "x"), (slope_x, "x"), (y, "y"), (slope_y, "y"))
        )
        whole = np.kron(np.eye(2), whole[:, :1]) if whole.size else whole
        basis, pairs = np.eye(2 * count), count
        names = [f"mode {number} along {axis}" for axis in "xy" for number in range(1, count + 1)]
    else:
        basis, pairs = _stations_first(np.vstack([x, slope_x, y, slope_y]), modes[0]), x.shape[0] + slope_x.shape[0]
        at = [f"{what} at {1e3 * z:.6g} mm" for what in ("", "slope")[: 1 + bool(slope_x.size)] for z in places]
        names = [f"{axis} {place}".replace("  ", " ") for axis in "xy" for place in at]
        names += [f"modes {number}" for number in range(1, count - 2 * pairs + 1)]
    mass, frequency, ratio = modes
    if not whole.size:  # what moves all stations most nearly by one
        scale = mass[:, None] ** -0.5
        whole = scale * np.linalg.lstsq(np.vstack([x, y]) * scale.T, np.kron(np.eye(2), np.ones((places.size, 1))))[0]
    deflections, slopes = (np.asarray((part @ basis)[:, :pairs]) for part in (x, slope_x))
    axis = NodalAxis(
        places, deflections, slopes if slope_x.size else _between(places, deflections), "give its shapes there"
    )
    twist = (
        slope_x.T @ (np.array(rotor.polar_inertias, np.float64)[:, None] * slope_y)
        if rotor.polar_inertias
        else 0.0 * basis
    )

    def over(values: Floats) -> Matrix:
        return np.asarray(basis.T @ (values[:, None] * basis))

    speeds, damping, stiffness = _supported(
        rotor, axis, over(mass * frequency**2), over(2.0 * ratio * frequency * mass)
    )
    _refuse_loose(stiffness[0])
    return LateralModel(
        over(mass), basis.T @ (twist - twist.T) @ basis, speeds, damping, stiffness, pairs, tuple(names), axis, inertia,
        rotor.mass, np.linalg.solve(basis, whole),
    )  # fmt: skip


def _stations_first(rows: Matrix, mass: Floats) -> Matrix:
    """Amplitudes of modes from coordinates of which the first are what the rows (R, N) give."""
    left, size, right = np.linalg.svd(rows * mass**-0.5)
    if rows.shape[0] > rows.shape[1] or size[-1] < RANK * size[0]:
        text = (
            f"{rows.shape[1]} modes that are not alike along x and y cannot move {rows.shape[0]} deflections and slopes of "
            "stations each by itself; keep fewer stations (those of supports, balancers and unbalances), or give more modes"
        )
        raise MachineError.of("Machine", [(("rotor", "positions"), text)])
    inverse = right[: size.size].T @ (left.T / size[:, None])
    return np.asarray(mass[:, None] ** -0.5 * np.hstack([inverse, right[size.size :].T]))


def _supported(
    rotor: ModalRotor | MatricesRotor | RigidRotor, axis: Axis, stiffness: Matrix, damping: Matrix
) -> tuple[Floats, Matrix, Matrix]:
    """Speeds of the tables, C and K, with what the supports add."""
    speeds = table_speeds(filter(None, (support.frequencies() for support in rotor.supports)))
    c, k = np.zeros((2, speeds.size, *stiffness.shape))
    k += stiffness
    for support in rotor.supports:
        add_support(support, axis.rows(float(support.position), None), speeds, c, k)
    c += damping + float(rotor.stiffness_proportional_damping) * k
    return speeds, c, k


# A rotor that is given by its matrices.


LOOSE = 1e-12  # stiffness over the greatest, below which there is none
NEAR = 1e-6  # of the length of the axis: so near a place is a node
NAMES = {"ux": "x", "uy": "y", "ry": "slope of x", "rx": "slope of y"}


@dataclass(frozen=True)
class NodalAxis:
    """The nodes of a rotor; its coordinates along x are their deflections, slopes, and modes."""

    places: Floats  # (nodes,) ascending, m
    deflections: Matrix  # (nodes, pairs)
    slopes: Matrix  # (nodes, pairs)
    hint: str = "with 'files' add it to 'keep'"

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        if body is not None:
            raise ValueError(f"body {body!r}: matrices and modes know no bodies; leave it out")
        if position is None:
            if self.places.size > 1:
                raise ValueError(f"missing; the rotor has {self.places.size} nodes, so say where along it")
            position = float(self.places[0])
        number = int(np.argmin(np.abs(self.places - position)))
        if abs(self.places[number] - position) > NEAR * max(float(np.ptp(self.places)), abs(position)):
            near = ", ".join(f"{place:.6g} m" for place in self.places[max(0, number - 1) : number + 2])
            raise ValueError(f"position {position:.6g} m: no node is there; the nearest are at {near}; {self.hint}")
        return Rows(self.deflections[number], self.slopes[number])

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        return [(float(z), self.rows(float(z), None)) for z in self.places]


@matrices.register
def given(rotor: MatricesRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates: deflections, slopes and modes along x; the same along y; then all that is neither.

    With small rotations dx/dz = ry and dy/dz = -rx, so rows and columns of rx change their sign.
    """
    ways = [coordinate.direction for coordinate in rotor.coordinates]
    position = np.array([np.nan if c.position is None else float(c.position) for c in rotor.coordinates])
    plane = [_ordered(ways, position, of) for of in (("ux", "ry", "modal x"), ("uy", "rx", "modal y"))]
    rest = [i for i in range(len(ways)) if i not in plane[0] and i not in plane[1]]
    order, pairs = [*plane[0], *plane[1], *rest], len(plane[0])
    sign = np.array([-1.0 if ways[i] == "rx" else 1.0 for i in order])

    def arranged(rows: tuple[tuple[float, ...], ...] | None) -> Matrix:
        matrix = np.zeros((len(ways), len(ways))) if rows is None else np.array(rows)
        return np.asarray(sign[:, None] * matrix[np.ix_(order, order)] * sign)

    mass, gyroscopic = arranged(rotor.mass_matrix), arranged(rotor.gyroscopic_matrix)
    mass, gyroscopic = 0.5 * (mass + mass.T), 0.5 * (gyroscopic - gyroscopic.T)
    axis = _axis([ways[i] for i in plane[0]], position[plane[0]])
    speeds, damping, stiffness = _supported(
        rotor, axis, arranged(rotor.stiffness_matrix), arranged(rotor.damping_matrix)
    )
    _refuse_loose(stiffness[0, : 2 * pairs, : 2 * pairs])
    names = [NAMES.get(ways[i], ways[i]) for i in order]
    names = [
        name if np.isnan(position[i]) else f"{name} at {1e3 * position[i]:.6g} mm"
        for name, i in zip(names, order, strict=True)
    ]
    return LateralModel(
        mass, gyroscopic, speeds, damping, stiffness, pairs, tuple(names), axis,
        None if rotor.inertia is None else float(rotor.inertia), rotor.mass,
        np.array([rotor.coordinates[i].moved for i in order]) * sign[:, None],
    )  # fmt: skip


def _refuse_loose(stiffness: Matrix) -> None:
    """Refuse a rotor that nothing holds across its axis, or that its stiffness drives away."""
    scale = np.sqrt(np.abs(np.diag(stiffness)))
    least, most = -1.0 if (np.diag(stiffness) < 0.0).any() else 0.0, 1.0
    if scale.all() and least == 0.0:
        least, *_, most = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) / np.outer(scale, scale))
    if least < LOOSE * most:
        text = (
            "nothing holds the rotor across its axis; give it supports, or matrices that contain those of its bearings"
            if least > -LOOSE * most
            else "the stiffness of the rotor with its supports is negative for some motion, so it does not rest; "
            "K is that of M q'' + K q = f, with a positive diagonal"
        )
        raise MachineError.of("Machine", [(("rotor", "supports"), text)])


def _ordered(ways: Sequence[str], position: Floats, plane: tuple[str, str, str]) -> list[int]:
    """Rows of a plane, node by node, deflection before slope, then its modes."""
    rank = {way: number for number, way in enumerate(plane)}
    chosen = [i for i, way in enumerate(ways) if way in rank]
    return sorted(chosen, key=lambda i: (np.inf if np.isnan(position[i]) else position[i], rank[ways[i]]))


def _axis(ways: list[str], position: Floats) -> NodalAxis:
    """Nodes with a deflection; where a node has no rotation, the slope is that of the line through its neighbors."""
    at = [number for number, way in enumerate(ways) if way == "ux"]
    places, deflections = position[at], np.eye(len(ways))[at]
    slopes = _between(places, deflections)
    for number, way in enumerate(ways):
        if way == "ry" and (same := np.flatnonzero(places == position[number])).size:
            slopes[same[0]] = np.eye(len(ways))[number]
    return NodalAxis(places, deflections, slopes)


def _between(places: Floats, deflections: Matrix) -> Matrix:
    """Slopes of the lines through the neighbors of each node."""
    if places.size < 2:
        return np.zeros_like(deflections)
    return np.asarray(np.gradient(deflections, places, axis=0))

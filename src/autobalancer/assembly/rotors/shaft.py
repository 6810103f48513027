"""The flexible shaft with its disks, supports and weight as matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows, add_support, matrices, table_speeds
from autobalancer.cache import remembered
from autobalancer.errors import MachineError
from autobalancer.machine import Disk, ShaftRotor, ShaftSegment
from autobalancer.machine.rotors.shaft import SAME

# The nodes of a shaft: ends of elements, disks, supports and thrust bearing.


# One Timoshenko beam element with two nodes, in one plane.
#
# Its coordinates are the deflection w and the rotation psi of the section at both ends; without shear psi = dw/dz.
# The shapes are the deflections under end loads, with the shear parameter Phi = 12 E I/(kappa G A L^2), as in
# Przemieniecki (1968), section 5.6, and Friswell et al. (2010), section 5.4: cubic in w, quadratic in psi, with
# constant shear w' - psi. All matrices are their integrals, which four Gauss points take exactly.


POINTS, WEIGHTS = (np.array(part) for part in np.polynomial.legendre.leggauss(4))
POINTS, WEIGHTS = 0.5 * (1.0 + POINTS), 0.5 * WEIGHTS  # on (0, 1)


@dataclass(frozen=True)
class Element:
    """A cylindrical element, SI."""

    length: float
    bending: float  # E I, N m^2
    shearing: float  # kappa G A, N
    mass: float  # rho A, kg/m
    rotary: float  # rho I, kg m; the polar one is twice that

    @property
    def phi(self) -> float:
        """Shear parameter: compliance in shear over that in bending."""
        return 12.0 * self.bending / (self.shearing * self.length**2)

    def shapes(self, s: Floats) -> tuple[Matrix, Matrix]:
        """w and psi at s = z/length (p,) for unit (w, psi, w, psi) at the ends, each (p, 4)."""
        length, phi = self.length, self.phi
        s = np.asarray(s, np.float64)
        bow = 0.5 * phi * s * (1.0 - s)
        w = np.stack([
            1.0 + phi * (1.0 - s) - 3.0 * s**2 + 2.0 * s**3,
            length * (s - 2.0 * s**2 + s**3 + bow),
            phi * s + 3.0 * s**2 - 2.0 * s**3,
            length * (s**3 - s**2 - bow),
        ], axis=-1)  # fmt: skip
        turn = 6.0 * (s**2 - s) / length
        psi = np.stack([
            turn, 1.0 - 4.0 * s + 3.0 * s**2 + phi * (1.0 - s), -turn, 3.0 * s**2 - 2.0 * s + phi * s,
        ], axis=-1)  # fmt: skip
        return w / (1.0 + phi), psi / (1.0 + phi)

    def curvature(self, s: Floats) -> Matrix:
        """dpsi/dz, (p, 4)."""
        length, phi = self.length, self.phi
        s = np.asarray(s, np.float64)
        bend = (12.0 * s - 6.0) / length
        rows = np.stack([bend, 6.0 * s - 4.0 - phi, -bend, 6.0 * s - 2.0 + phi], axis=-1)
        return np.asarray(rows / (length * (1.0 + phi)))

    @property
    def shear(self) -> Floats:
        """w' - psi, constant along the element, (4,)."""
        both = np.array([-1.0 / self.length, -0.5, 1.0 / self.length, -0.5])
        return both * self.phi / (1.0 + self.phi)

    def inertia(self) -> Matrix:
        """Mass matrix with the inertia of the sections against turning, (4, 4)."""
        w, _ = self.shapes(POINTS)
        return self.length * self.mass * _product(w, WEIGHTS) + 0.5 * self.gyroscopic()

    def gyroscopic(self) -> Matrix:
        """Polar inertia of the sections over their rotations, (4, 4), symmetric: g of G = [[0, g], [-g, 0]]."""
        return 2.0 * self.length * self.rotary * _product(self._turning, WEIGHTS)

    def stiffness(self) -> Matrix:
        """Stiffness in bending and shear, (4, 4)."""
        bent = self.length * self.bending * _product(self.curvature(POINTS), WEIGHTS)
        return bent + self.length * self.shearing * np.outer(self.shear, self.shear)

    def tension(self, first: float, last: float) -> Matrix:
        """Geometric stiffness under a tension that goes linearly from ``first`` to ``last``, N, (4, 4)."""
        force = first + (last - first) * POINTS
        return self.length * _product(self._turning + self.shear, WEIGHTS * force)

    @cached_property
    def _turning(self) -> Matrix:
        """psi at the points of the quadrature."""
        return self.shapes(POINTS)[1]


def cowper(poisson: float, hollow: float) -> float:
    """Shear coefficient of a round section whose inner diameter is ``hollow`` of the outer one: Cowper (1966)."""
    both, square = (1.0 + hollow**2) ** 2, hollow**2
    return 6.0 * (1.0 + poisson) * both / ((7.0 + 6.0 * poisson) * both + (20.0 + 12.0 * poisson) * square)


def _product(rows: Matrix, weights: Floats) -> Matrix:
    product = rows.T @ (weights[:, None] * rows)
    return np.asarray(0.5 * (product + product.T))  # exactly symmetric


NEAR = 0.01  # share of an element below which its end gives way to a place that must be a node


@dataclass(frozen=True)
class Mesh:
    """Nodes along a shaft and the elements between them."""

    nodes: Floats  # (n,) ascending, m
    elements: tuple[Element, ...]  # (n - 1,)

    def node(self, position: float) -> int:
        """The node nearest to a position, m."""
        return int(np.argmin(np.abs(self.nodes - position)))


def mesh(rotor: ShaftRotor) -> Mesh:
    """Cut the segments into their elements, and these again where a disk, a support or the thrust bearing is."""
    places = [float(disk.position) for disk in rotor.disks] + [float(support.position) for support in rotor.supports]
    if rotor.thrust_bearing is not None:
        places.append(float(rotor.thrust_bearing))
    same = SAME * rotor.length
    nodes, elements, start = [0.0], [], 0.0
    for segment in rotor.segments:
        end = start + float(segment.length)
        size = float(segment.length) / segment.elements
        fixed = [start, *sorted(p for p in places if start + same < p < end - same), end]
        grid = start + size * np.arange(1, segment.elements)
        free = [z for z in grid if np.abs(np.array(fixed) - z).min() > NEAR * size]
        for z in sorted([*fixed[1:], *free]):
            if z - nodes[-1] > same:
                elements.append(_element(rotor, segment, z - nodes[-1]))
                nodes.append(float(z))
        start = end
    return Mesh(np.array(nodes), tuple(elements))


def _element(rotor: ShaftRotor, segment: ShaftSegment, length: float) -> Element:
    material = rotor.material_of(segment)
    kappa = segment.shear_coefficient
    if kappa is None:
        kappa = cowper(material.poisson, float(segment.inner_diameter) / float(segment.diameter))
    density, young = float(material.density), float(material.youngs_modulus)
    return Element(
        length=length,
        bending=young * segment.second_moment,
        shearing=float(kappa) * material.shear * segment.area,
        mass=density * segment.area,
        rotary=density * segment.second_moment,
    )


@matrices.register
def shaft(rotor: ShaftRotor, gravity: float) -> LateralModel:
    """Coordinates: deflection and rotation of the section of each node along x, then along y.

    ``gravity`` along the axis, m/s^2, 0 if it is horizontal.

    Raises
    ------
    MachineError
        If the rotor falls over or buckles under its weight.
    """
    cut, *bare = _without_disks(rotor)
    axis = ShaftAxis(cut, rotor.disks)
    mass, polar, elastic = (matrix.copy() for matrix in bare)
    for disk in rotor.disks:
        place = axis.on_disk(disk)
        tilting = np.outer(place.slope, place.slope)
        mass += float(disk.mass) * np.outer(place.deflection, place.deflection)
        mass += float(disk.transverse_inertia) * tilting
        polar += float(disk.polar_inertia) * tilting
    n = mass.shape[0]
    speeds = table_speeds(filter(None, (support.frequencies() for support in rotor.supports)))
    damping, stiffness = np.zeros((2, speeds.size, 2 * n, 2 * n))
    stiffness += _both(elastic)
    for support in rotor.supports:
        add_support(support, axis.on_shaft(float(support.position)), speeds, damping, stiffness)
    damping += float(rotor.stiffness_proportional_damping) * stiffness
    if rotor.up is not None and gravity > 0.0:
        stiffness += _both(weight_stiffness(rotor, axis, gravity))
        _refuse_falling(0.5 * (stiffness[0] + stiffness[0].T))
    gyroscopic = np.zeros((2 * n, 2 * n))
    gyroscopic[:n, n:], gyroscopic[n:, :n] = polar, -polar
    names = [f"{name} {1e3 * z:.6g} mm" for z in cut.nodes for name in ("at", "slope at")]
    return LateralModel(
        _both(mass), gyroscopic, speeds, damping, stiffness, n, tuple(f"{way} {name}" for way in "xy" for name in names),
        axis, rotor.inertia, rotor.mass,
    )  # fmt: skip


def _cut_key(rotor: ShaftRotor) -> tuple[Any, ...]:
    places = *(float(disk.position) for disk in rotor.disks), *(float(support.position) for support in rotor.supports)
    return rotor.segments, rotor.material, places, rotor.thrust_bearing


@remembered(8, by=_cut_key)
def _without_disks(rotor: ShaftRotor) -> tuple[Mesh, Matrix, Matrix, Matrix]:
    """The mesh of a shaft; mass, gyroscopic part and stiffness of its elements in one plane."""
    cut = mesh(rotor)
    inertia, polar, elastic = zip(
        *((element.inertia(), element.gyroscopic(), element.stiffness()) for element in cut.elements), strict=True
    )
    return cut, assembled(cut, inertia), assembled(cut, polar), assembled(cut, elastic)


def assembled(cut: Mesh, parts: Sequence[Matrix]) -> Matrix:
    """The matrices (4, 4) of the elements one after the other, (2 nodes, 2 nodes)."""
    total = np.zeros((2 * cut.nodes.size, 2 * cut.nodes.size))
    for i, part in enumerate(parts):
        total[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += part
    return total


def tensions(rotor: ShaftRotor, cut: Mesh, gravity: float) -> list[tuple[float, float]]:
    """Tension at both ends of each element, N.

    The shaft below the thrust bearing carries the weight of all that hangs below; above it, it is compressed by all that
    stands on it.
    """
    carried = cut.node(float(rotor.thrust_bearing or 0.0))
    weights = np.zeros(cut.nodes.size)
    for disk in rotor.disks:
        weights[cut.node(float(disk.position))] += gravity * float(disk.mass)
    own = np.array([gravity * element.mass * element.length for element in cut.elements])
    sign = 1.0 if rotor.up == "-z" else -1.0  # of the pull on the part towards greater z
    tensions = []
    for i in range(own.size):
        if i >= carried:
            outer = sign * (weights[i + 1 :].sum() + own[i + 1 :].sum())
            tensions.append((outer + sign * own[i], outer))
        else:
            outer = -sign * (weights[: i + 1].sum() + own[:i].sum())
            tensions.append((outer, outer - sign * own[i]))
    return tensions


def weight_stiffness(rotor: ShaftRotor, axis: ShaftAxis, gravity: float) -> Matrix:
    """What weight adds to K in one plane: tension of the shaft, and the moment m g offset of what hangs on an arm."""
    cut = axis.mesh
    ends = tensions(rotor, cut, gravity)
    total = assembled(cut, [element.tension(*pull) for element, pull in zip(cut.elements, ends, strict=True)])
    down = 1.0 if rotor.up == "-z" else -1.0
    for disk in rotor.disks:
        slope = axis.on_shaft(float(disk.position)).slope
        total += down * gravity * float(disk.mass) * float(disk.offset) * np.outer(slope, slope)
    return np.asarray(total)


def _both(plane: Matrix) -> Matrix:
    return np.asarray(np.kron(np.eye(2), plane), np.float64)


def _refuse_falling(stiffness: Matrix) -> None:
    scale = np.sqrt(np.abs(np.diag(stiffness)))
    if np.diag(stiffness).min() <= 0.0 or np.linalg.eigvalsh(stiffness / np.outer(scale, scale))[0] <= 0.0:
        text = "the rotor falls over or buckles under its weight; use stiffer supports, suspend it from above, or leave 'up' out"
        raise MachineError.of("Machine", [(("rotor", "up"), text)])


# Places on a shaft and on the rigid bodies fixed to it.


INSIDE = 4  # places drawn along an element


@dataclass(frozen=True)
class ShaftAxis:
    """The axis of a shaft; coordinates are deflection and rotation of each node in turn."""

    mesh: Mesh
    disks: tuple[Disk, ...]

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`; ``None`` is the mass center of the only disk."""
        if body is not None:
            return self._named(position, body)
        if position is None:
            if len(self.disks) > 1:
                raise ValueError(f"missing; the shaft carries {len(self.disks)} disks, so say where along it")
            return self.on_disk(self.disks[0]) if self.disks else self.on_shaft(0.5 * float(self.mesh.nodes[-1]))
        end = float(self.mesh.nodes[-1])
        if -SAME * end <= position <= end * (1.0 + SAME):
            return self.on_shaft(position)
        reaching = [disk for disk in self.disks if _reaches(disk, position)]
        if len(reaching) == 1:
            return self.on_disk(reaching[0], position)
        if reaching:
            raise ValueError(f"position {position:g} m: {len(reaching)} disks reach there; name one of them as 'body'")
        arms = "".join(
            f"; disk {disk.name or number} from {disk.reach[0]:g} to {disk.reach[1]:g} m"
            for number, disk in enumerate(self.disks, 1)
            if disk.reach[0] < 0.0 or disk.reach[1] > end
        )
        raise ValueError(
            f"position {position:g} m: nothing is there; the shaft reaches from 0 to {end:g} m{arms}; "
            "a longer 'extent' of a disk reaches farther"
        )

    def on_shaft(self, position: float) -> Rows:
        """Rows of a position on the shaft, between nodes by the shapes of the element."""
        return _rows_of(self.mesh, float(position))

    def on_disk(self, disk: Disk, position: float | None = None) -> Rows:
        """Rows of a position on the rigid arm of a disk, by default of its mass center."""
        foot = self.on_shaft(float(disk.position))
        arm = float(disk.offset) if position is None else position - float(disk.position)
        return Rows(foot.deflection + arm * foot.slope, foot.slope)

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`; with the arms that stick out of the ends."""
        nodes = self.mesh.nodes
        places = [z + share * (after - z) for z, after in pairwise(nodes) for share in np.arange(INSIDE) / INSIDE]
        line = [(float(z), self.on_shaft(float(z))) for z in [*places, nodes[-1]]]
        for disk in self.disks:
            low, high = disk.reach
            if low < 0.0 and all(other is disk or other.reach[0] >= 0.0 for other in self.disks):
                line.insert(0, (low, self.on_disk(disk, low)))
            if high > nodes[-1] and all(other is disk or other.reach[1] <= nodes[-1] for other in self.disks):
                line.append((high, self.on_disk(disk, high)))
        return line

    def _named(self, position: float | None, body: str) -> Rows:
        rows = [disk for disk in self.disks if disk.name == body]
        if not body or not rows:
            known = ", ".join(repr(disk.name) for disk in self.disks if disk.name) or "none with a name"
            raise ValueError(f"body {body!r}: no disk has this name; there is {known}")
        if position is not None and not _reaches(rows[0], position):
            low, high = rows[0].reach
            raise ValueError(f"position {position:g} m: disk {body!r} reaches from {low:g} to {high:g} m only")
        return self.on_disk(rows[0], position)


@remembered(256)
def _rows_of(mesh: Mesh, position: float) -> Rows:
    nodes = mesh.nodes
    i = min(max(int(np.searchsorted(nodes, position)) - 1, 0), nodes.size - 2)
    share = np.clip((position - nodes[i]) / (nodes[i + 1] - nodes[i]), 0.0, 1.0)
    deflection, slope = np.zeros((2, 2 * nodes.size))
    deflection[2 * i : 2 * i + 4], slope[2 * i : 2 * i + 4] = mesh.elements[i].shapes(share)
    return Rows(deflection, slope)


def _reaches(disk: Disk, position: float) -> bool:
    low, high = disk.reach
    slack = SAME * max(abs(low), abs(high), high - low)
    return low - slack <= position <= high + slack

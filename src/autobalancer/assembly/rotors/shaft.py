"""The flexible shaft with its disks, supports and weight as matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalancer.assembly.rotors.model import LateralModel, Matrix, matrices
from autobalancer.assembly.rotors.shaft_axis import ShaftAxis
from autobalancer.assembly.rotors.shaft_mesh import Mesh, mesh
from autobalancer.assembly.rotors.supports import add_support, table_speeds
from autobalancer.machine import ShaftRotor
from autobalancer.machine.part import ImpossiblePart
from autobalancer.remembered import remembered


@matrices.register
def shaft(rotor: ShaftRotor, gravity: float) -> LateralModel:
    """Coordinates: deflection and rotation of the section of each node along x, then along y.

    ``gravity`` along the axis, m/s^2, 0 if it is horizontal.

    Raises
    ------
    ImpossiblePart
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
    places = *(float(disk.position) for disk in rotor.disks), *(float(one.position) for one in rotor.supports)
    return rotor.segments, rotor.material, places, rotor.thrust_bearing


@remembered(8, by=_cut_key)
def _without_disks(rotor: ShaftRotor) -> tuple[Mesh, Matrix, Matrix, Matrix]:
    """The mesh of a shaft; mass, gyroscopic part and stiffness of its elements in one plane."""
    cut = mesh(rotor)
    inertia, polar, elastic = zip(
        *((one.inertia(), one.gyroscopic(), one.stiffness()) for one in cut.elements), strict=True
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
    found = []
    for i in range(own.size):
        if i >= carried:
            outer = sign * (weights[i + 1 :].sum() + own[i + 1 :].sum())
            found.append((outer + sign * own[i], outer))
        else:
            outer = -sign * (weights[: i + 1].sum() + own[:i].sum())
            found.append((outer, outer - sign * own[i]))
    return found


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
        raise ImpossiblePart("Machine", [(("rotor", "up"), text)])

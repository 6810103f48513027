"""The effect of weight on the tilting of a rig with a vertical axis.

A force F that acts at the arm s of a body does the second-order work F . phi x (phi x s)/2 when the body turns by the
rotation vector phi. With the weights, and the loads of the joints that carry them at rest, the sum is the stiffness
of a pendulum: a body of weight m g whose center is h above the soft joint it stands on gets -m g h.
"""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.assembly.rotors.rig_bodies import SLOPE_X, SLOPE_Y, TURN, Rig
from autobalancer.assembly.rotors.rig_joints import Point, Strut
from autobalancer.machine import MultibodyRotor
from autobalancer.machine.part import ImpossiblePart


def weight_stiffness(rotor: MultibodyRotor, rig: Rig, parts: list[Strut], kept: list[int], gravity: float) -> Matrix:
    """What weight adds to K, (N, N), with the joints loaded as at speed zero.

    ``kept`` are the coordinates in use, ``gravity`` counts along +z, m/s^2.
    """
    load, added = np.zeros(rig.size), np.zeros((rig.size, rig.size))
    for body in rotor.bodies:
        force = np.array([0.0, 0.0, float(body.mass) * gravity])
        load += force @ rig.motion(body.name, body.center)[:3]
        added += _second_order(rig, body.name, body.center, force)
    if not set(np.flatnonzero(load)) <= set(kept):
        text = "no joint carries the weight along the axis; give axial stiffness, or leave 'up' out"
        raise ImpossiblePart("Machine", [(("rotor", "up"), text)])
    rows = np.array([strut.row for strut in parts])[:, kept]
    springs = np.array([strut.stiffness[0] for strut in parts])
    rest = np.linalg.solve(rows.T @ (springs[:, None] * rows), load[kept])
    for strut, stretch in zip(parts, rows @ rest, strict=True):
        force = -strut.stiffness[0] * stretch * strut.direction
        if force.any():
            added += _second_order(rig, strut.between[0], strut.point, force)
            added -= _second_order(rig, strut.between[1], strut.point, force)
    return added


def refuse_falling(stiffness: Matrix) -> None:
    """Raise :class:`ImpossiblePart` if weight overcomes the springs, K (N, N)."""
    if np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0] <= 0.0:
        text = "the bodies fall over under their weight; make the joints stiffer, or leave 'up' out"
        raise ImpossiblePart("Machine", [(("rotor", "up"), text)])


def _second_order(rig: Rig, name: str, point: Point, force: Floats) -> Matrix:
    merged = rig.of(name)
    if merged is None:
        return np.zeros((rig.size, rig.size))
    rows = rig.motion(name, point)
    rotation = np.array([-rows[SLOPE_Y], rows[SLOPE_X], rows[TURN]])
    arm = np.array([point[0], point[1], point[2] - merged.height])
    middle = float(force @ arm) * np.eye(3) - 0.5 * (np.outer(force, arm) + np.outer(arm, force))
    return np.asarray(rotation.T @ middle @ rotation)

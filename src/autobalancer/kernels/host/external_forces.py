"""What acts on a linear rotor besides its unbalance and its balls, for the machines that have it."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.compiler.flags import EQUATIONS_PART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data, deref, row
from autobalancer.kernels.host.linear import Motion, dot
from autobalancer.kernels.host.shaft_train import unbalance_value
from autobalancer.kernels.laws.curves import table_value
from autobalancer.kernels.records import ELASTOPLASTIC, ENDOCHRONIC, PRESCRIBED, RECORDED
from autobalancer.kernels.system import THETA, System, system_at
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**EQUATIONS_PART)
def add_external_forces(time: float, y: Any, dy: Any, system: Any, motion: Motion) -> Motion:
    """Add to f the accelerations by excitations, rubber and bearings; returns the motion with gravity as felt on the base.

    A function of its own: else what it reads would be read in all machines.
    """
    p = deref(system_at(system))
    return bearing_forces(p, rubber_forces(y, dy, p, base_excitation(time, y, p, motion)))


# What shakes a machine from outside: motion of its base, and forces on its rotor.


@njit(**INLINE)
def base_excitation(time: float, y: Any, p: System, motion: Motion) -> Motion:
    """Add the accelerations of the coordinates to f; returns the motion with gravity as felt on the base, and its torque."""
    size, width, f, vectors = p.host.size, p.host.width, data(p.work.f), data(p.shake_vectors)
    gx, gy, torque = motion.gravity_x, motion.gravity_y, motion.torque
    for e in range(p.shakes.shape[0]):
        shake = p.shakes[e]
        if shake.kind == RECORDED:
            along_x = table_value(p.fluid, shake.table_x, time)
            along_y = table_value(p.fluid, shake.table_y, time)
        else:
            s, c = sine_cosine(shake.frequency * (y[THETA] if shake.by_angle == 1 else time))
            along_x, along_y = shake.x_real * c - shake.x_imaginary * s, shake.y_real * c - shake.y_imaginary * s
        at = 2 * e * width
        for i in range(size):
            f[i] += vectors[at + i] * along_x + vectors[at + width + i] * along_y
        if shake.felt == 1:
            gx -= along_x
            gy -= along_y
            if p.drive.kind != PRESCRIBED:
                ux, uy = unbalance_value(time, p.drive)
                ux, uy = motion.cosine * ux - motion.sine * uy, motion.sine * ux + motion.cosine * uy
                torque -= ux * along_y - uy * along_x
    return Motion(motion.speed, motion.acceleration, motion.sine, motion.cosine, gx, gy, torque)


# Rubber between a linear rotor and what carries it: elements that slide or relax, each with a force of two components.
#
#     f' = k z' - g f,    g = k <f . z'> / F^2  elastoplastic,    k |z'| / F  endochronic,    1/tau  Maxwell
#
# with the stretch z = B q of its piece of rubber in the plane, so that x and y are coupled and no direction is
# preferred. The force never leaves |f| <= F, stores |f|^2 / (2 k) and loses g |f|^2 / k. In axes that turn with the
# rotor f' has -i w f more.


@njit(**INLINE)
def rubber_forces(y: Any, dy: Any, p: System, motion: Motion) -> Motion:
    """Add the accelerations by all rubber to f, and write the rates of its elements; returns the motion as it is."""
    size, width, f, v = p.host.size, p.host.width, data(p.work.f), data(p.work.v)
    rows, reach = data(p.rubber.rows), data(p.rubber.reach)
    turning = motion.speed if p.rotating == 1 else 0.0
    for m in range(p.rubber.mounts.shape[0]):
        mount, at = row(p.rubber.mounts, m), 2 * m * width
        vx, vy = dot(rows, at, v, 0, size), dot(rows, at + width, v, 0, size)
        pace, push_x, push_y = math.sqrt(vx * vx + vy * vy), 0.0, 0.0
        for e in range(mount.first, mount.first + mount.elements):
            one = row(p.rubber.elements, e)
            fx, fy = y[one.state], y[one.state + 1]
            give = one.give
            if one.law == ELASTOPLASTIC:
                give *= max(fx * vx + fy * vy, 0.0)
            elif one.law == ENDOCHRONIC:
                give *= pace
            dy[one.state] = one.stiffness * vx - give * fx + turning * fy
            dy[one.state + 1] = one.stiffness * vy - give * fy - turning * fx
            push_x += fx
            push_y += fy
        for i in range(size):
            f[i] -= reach[at + i] * push_x + reach[at + width + i] * push_y
    return motion


# Bearings that become stiffer as they deflect: a force towards the middle of each, (k r^2 + (K max(r - g, 0) +
# T(r))/r) d.
#
# T is the force of a table in cubic pieces, the first of which begins at r = 0 without a force. d is the way of the
# rotor from the middle, r its length. Deflections count from where the rotor rests, so the force there is taken off.
# In axes that turn with the rotor the middles are where it rests, and nothing turns.


@njit(**INLINE)
def tabled(one: Any, tables: Any, distance: float) -> float:
    """Force of the table of a bearing over the distance from its middle, N/m."""
    at = 5 * (one.first + one.pieces - 1)
    while at > 5 * one.first and tables[at] > distance:
        at -= 5
    way = distance - tables[at]
    rising = (tables[at + 1] * way + tables[at + 2]) * way + tables[at + 3]
    if at == 5 * one.first:
        return rising
    return (rising * way + tables[at + 4]) / distance


@njit(**INLINE)
def central(one: Any, tables: Any, x: float, y: float) -> tuple[float, float]:
    """Force of the rotor on a bearing at a deflection, N, less that at rest."""
    x -= one.center_x
    y -= one.center_y
    square = x * x + y * y
    rate, distance = one.cubic * square, math.sqrt(square)
    if distance > one.clearance:
        rate += one.contact * (1.0 - one.clearance / distance)
    if one.pieces > 0:
        rate += tabled(one, tables, distance)
    return rate * x - one.rest_x, rate * y - one.rest_y


@njit(**INLINE)
def bearing_forces(p: System, motion: Motion) -> Motion:
    """Add the accelerations by all such bearings to f; returns the motion as it is."""
    size, width, q, f = p.host.size, p.host.width, data(p.work.q), data(p.work.f)
    rows, reach, tables = data(p.bearings.rows), data(p.bearings.reach), data(p.bearings.tables)
    for b in range(p.bearings.springs.shape[0]):
        at = 2 * b * width
        x, y = dot(rows, at, q, 0, size), dot(rows, at + width, q, 0, size)
        push_x, push_y = central(row(p.bearings.springs, b), tables, x, y)
        for i in range(size):
            f[i] -= reach[at + i] * push_x + reach[at + width + i] * push_y
    return motion

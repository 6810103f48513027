"""What shakes a machine from outside: motion of its base, and forces on its rotor."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.host.drive import unbalance_value
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.laws.curves import table_value
from autobalancer.kernels.pointers import data
from autobalancer.kernels.records.drive import PRESCRIBED, RECORDED
from autobalancer.kernels.system import THETA, System
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def shaken(time: float, y: Any, p: System, motion: Motion) -> Motion:
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

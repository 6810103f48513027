"""What acts on a linear rotor besides its unbalance and its balls, for the machines that have it."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import EQUATIONS_PART, njit
from autobalancer.kernels.host.hardening import hardened
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.host.rubber import stretched
from autobalancer.kernels.host.shaking import shaken
from autobalancer.kernels.pointers import behind
from autobalancer.kernels.system import system_at


@njit(**EQUATIONS_PART)
def acted(time: float, y: Any, dy: Any, system: Any, motion: Motion) -> Motion:
    """Add to f the accelerations by excitations, rubber and bearings; returns the motion with gravity as felt on the base.

    A function of its own: else what it reads would be read in all machines.
    """
    p = behind(system_at(system))
    return hardened(p, stretched(y, dy, p, shaken(time, y, p, motion)))

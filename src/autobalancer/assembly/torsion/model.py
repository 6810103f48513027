"""The drive train as a torsional model: what turns, inertia, damping and stiffness about a steady speed, and what shakes it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.profile import unbalance_vector
from autobalancer.assembly.torsion.links import link_names, links_of
from autobalancer.errors import MachineError
from autobalancer.machine import AsynchronousDrive, Machine, PrescribedSpeed, TorqueTable
from autobalancer.machine.drive import twists

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class Torsion(NamedTuple):
    """Angles of n parts: the rotor first, then the inertias towards the motor, the stator last.

    A motor whose speed is prescribed is no part; its coupling holds the part before it.
    """

    names: tuple[str, ...]
    inertia: Floats  # (n,)
    damping: Floats  # (n, n) without the motor
    stiffness: Floats  # (n, n)
    motor: Floats  # (n,) angle of the motor against its stator, as a row; zero where its speed is prescribed
    twist: Floats  # (links, n) twist of each link, as rows
    own: Floats  # (links, 2) stiffness and damping of each link
    links: tuple[str, ...]


class Shake(NamedTuple):
    """A torque, or an error of alignment, that comes ``order`` times per turn: amplitude times cos(order angle + phase)."""

    what: str
    order: float
    row: Floats  # (n,) torques per amplitude, or the twist of the coupling with the error
    amplitude: complex  # N m, or rad
    link: int = -1  # of an error


def torsion_of(machine: Machine) -> Torsion:
    """The torsional model of a machine; its balls run freely in their races and are left out.

    Raises
    ------
    MachineError
        If nothing in its drive turns elastically.
    """
    drive = machine.drive
    if not twists(drive):
        raise MachineError(
            "drive: it has no couplings and no mount, so nothing twists; give 'couplings' with their stiffness and inertia"
        )
    links, names = links_of(drive), link_names(machine)
    held = isinstance(drive, PrescribedSpeed)
    couplings = len(drive.couplings)
    inertia = [float(machine.rotor.inertia or 0.0), *(float(part.inertia or 0.0) for part in links)]
    size = len(inertia) - held
    twist = np.zeros((len(links), len(inertia)))
    for i in range(len(links)):
        twist[i, i + 1] = 1.0
        twist[i, i] = -1.0 if i < couplings else 0.0
    twist = twist[:, :size]
    own = np.array([[part.stiffness, part.damping] for part in links])
    motor = np.zeros(size)
    if not held:
        motor[couplings] = 1.0
        if len(links) > couplings:
            motor[-1] = -1.0
    k, c = ((twist.T * own[:, i]) @ twist for i in (0, 1))
    return Torsion(("rotor", *names)[:size], np.array(inertia[:size]), c, k, motor, twist, own, names)


def damping_at(machine: Machine, model: Torsion, speed: float) -> Floats:
    """Damping about a steady speed (rad/s), with what the torque of the motor loses as it turns faster, N m s."""
    return np.asarray(model.damping - motor_slope(machine.drive, speed) * np.outer(model.motor, model.motor))


def motor_slope(drive: Any, speed: float) -> float:
    """How the torque of a motor changes with its speed, N m s; 0 where its speed is prescribed."""
    if isinstance(drive, PrescribedSpeed):
        return 0.0
    slope = -float(drive.damping)
    if isinstance(drive, TorqueTable):
        speeds, torques = np.array(drive.speed, float), np.array(drive.torque, float)
        i = int(np.searchsorted(speeds, speed))
        if 0 < i < speeds.size:
            slope += float((torques[i] - torques[i - 1]) / (speeds[i] - speeds[i - 1]))
    if isinstance(drive, AsynchronousDrive):
        width = float(drive.breakdown_slip * drive.synchronous_speed)
        slip = float(drive.synchronous_speed) - speed
        most = float(drive.rated_torque * drive.overload)
        slope -= 2.0 * most * width * (width**2 - slip**2) / (width**2 + slip**2) ** 2
    return slope


def shakes_of(machine: Machine, model: Torsion) -> Iterator[Shake]:
    """What shakes the drive train by itself: weight of the unbalance, errors of alignment, ripples of the torque."""
    drive = machine.drive
    unbalance = unbalance_vector(machine, np.inf)
    pull = float(machine.gravity) if machine.axis == "horizontal" else 0.0
    if abs(unbalance) * pull > 0.0:
        row = np.zeros(model.inertia.size)
        row[0] = 1.0
        yield Shake("weight of the unbalance", 1.0, row, -pull * unbalance)
    for i, part in enumerate(drive.couplings):
        if part.error > 0.0:
            amplitude = part.error * np.exp(1j * part.phase)
            yield Shake(f"alignment of coupling {i + 1}", float(part.order), model.twist[i], amplitude, i)
    for i, ripple in enumerate(getattr(drive, "ripples", ())):
        yield Shake(f"ripple {i + 1}", float(ripple.order), model.motor, ripple.torque * np.exp(1j * ripple.phase))

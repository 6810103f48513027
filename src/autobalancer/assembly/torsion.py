"""What twists between motor and rotor: links for runs, and their matrices."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.profile import unbalance_vector
from autobalancer.errors import MachineError
from autobalancer.machine import AsynchronousDrive, Machine, PrescribedSpeed, TorqueTable
from autobalancer.machine.drive import Coupling, MotorMount, twists

# The drive train as a torsional model: what turns, inertia, damping and stiffness about a steady speed, and what
# shakes it.


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


# The links between rotor and motor: as rows of the kernels, and what is the same machine without them.


def links_of(drive: Any) -> list[Coupling | MotorMount]:
    """Couplings from the rotor to the motor, then the mount of its stator if there is one."""
    mount = getattr(drive, "mount", None)
    return [*drive.couplings, *([] if mount is None else [mount])]


def link_names(machine: Machine) -> tuple[str, ...]:
    """What is behind each link: the names of the file, else numbers; the motor is the last coupling's, the stator the mount's."""
    drive = machine.drive
    last = len(drive.couplings)
    names = [c.name or ("motor" if i == last else f"inertia {i}") for i, c in enumerate(drive.couplings, start=1)]
    return (*names, *(["stator"] if getattr(drive, "mount", None) is not None else []))


def start_of_links(machine: Machine, speed: float) -> Floats:
    """State of the links at time zero: no twist, all at the speed of the rotor, the stator at rest."""
    return np.array(
        [x for part in links_of(machine.drive) for x in (0.0, speed if isinstance(part, Coupling) else 0.0)]
    )


def scale_of_links(machine: Machine, frequency: float) -> Floats:
    """Size of their motions: speeds as all others, twists as they belong to such speeds."""
    values: list[float] = []
    for part in links_of(machine.drive):
        inertia = min(float(machine.rotor.inertia or math.inf), float(part.inertia or math.inf))
        values += [min(1.0, frequency / math.sqrt(part.stiffness / inertia)), frequency]
    return np.array(values)


def is_linked(machine: Machine) -> bool:
    """Whether the rotor is driven by links, or by a torque with ripples."""
    return twists(machine.drive) or bool(getattr(machine.drive, "ripples", ()))


def without_links(machine: Machine) -> Machine:
    """The machine with a rigid drive train, for questions at a constant speed."""
    if not is_linked(machine):
        return machine
    plain = {"couplings": (), "mount": None, "ripples": ()}
    known = {name: value for name, value in plain.items() if name in type(machine.drive).model_fields}
    return machine.model_copy(update={"drive": machine.drive.model_copy(update=known)})

"""The links between rotor and motor: as rows of the kernels, and what is the same machine without them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.kernels.records.drive import COUPLING, LINK, MOUNT, RIPPLE
from autobalancer.kernels.system import Floats, Rows
from autobalancer.machine import Machine
from autobalancer.machine.drive import twists
from autobalancer.machine.drive_train import Coupling, MotorMount

LINK_STATES = 2  # twist and speed


def links_of(drive: Any) -> list[Coupling | MotorMount]:
    """Couplings from the rotor to the motor, then the mount of its stator if there is one."""
    mount = getattr(drive, "mount", None)
    return [*drive.couplings, *([] if mount is None else [mount])]


def link_rows(drive: Any, first_state: int) -> Rows:
    """Records of all links, their states from ``first_state`` on."""
    found = links_of(drive)
    rows = LINK.rows(len(found))
    for number, (row, part) in enumerate(zip(rows, found, strict=True)):
        row.kind = COUPLING if isinstance(part, Coupling) else MOUNT
        row.state = first_state + LINK_STATES * number
        row.inertia, row.stiffness, row.damping = float(part.inertia or 0.0), part.stiffness, part.damping
        if isinstance(part, Coupling):
            row.error, row.order, row.phase = part.error, part.order, part.phase
    if drive.kind == "speed" and len(rows):
        rows[-1].inertia = 0.0  # nothing asks for it
    return rows


def ripple_rows(drive: Any) -> Rows:
    """Records of all ripples of the torque."""
    found = getattr(drive, "ripples", ())
    rows = RIPPLE.rows(len(found))
    for row, part in zip(rows, found, strict=True):
        row.torque, row.order, row.phase = part.torque, part.order, part.phase
    return rows


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
    found: list[float] = []
    for part in links_of(machine.drive):
        inertia = min(float(machine.rotor.inertia or math.inf), float(part.inertia or math.inf))
        found += [min(1.0, frequency / math.sqrt(part.stiffness / inertia)), frequency]
    return np.array(found)


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

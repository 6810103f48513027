"""First flexible critical speed near 9000 rpm, from a shaft model of the rig.

The source got it with finite elements whose data it does not print. Printed are the shaft of 10 mm silver steel, the motor of
120 g beyond bearing B1, the disk in the middle of the bearings, total mass, mass center, both inertias and the springs.
Assumed here: the shaft ends at the motor's mass center and at B2; both bearing housings have the same mass, which moves
with the rotor and does not turn; disk and motor are fixed at one place each, a flat disk and a cylinder of 35 mm diameter
and length. Then total mass, mass center and transverse inertia give the mass of disk and housing and the place of the
motor. The disk may be thin, or have a hub that holds the shaft straight over some length; its race is 11 mm wide.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import root

import autobalancer as ab
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine
from autobalancer.plots.style import save_picture
from autobalancer.rotordynamics.campbell import critical_speeds, modes
from reproductions import Found, compared_all

MASS, TRANSVERSE, POLAR = 1.28, 0.0138, 0.00124  # table 1
FIRST, SECOND = 0.110, 0.150  # from the mass center to the bearings, m
DISK = 0.5 * (FIRST + SECOND)  # beyond B1, m
DIAMETER, DENSITY = 0.010, 7850.0
MOTOR, MOTOR_SIZE = 0.120, 0.035  # kg; m, assumed
RPM = math.pi / 30.0
PRINTED, ABOUT = 9000.0, 500.0  # rpm; one digit is printed
HUB = 0.020  # m; the race in it is 11 mm wide


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Bending speed, and the speeds of the rigid body as a check of the model."""
    machine = shaft_model()
    hub = bending_speed(shaft_model(HUB))
    rows = [
        Found("printed", "first flexible critical speed, thin disk", "rpm", PRINTED, bending_speed(machine), ABOUT,
              f"the hub of the disk is not printed; one of 20 mm gives {hub:.0f} rpm"),
    ]  # fmt: skip
    found = critical_speeds(machine, highest=4000.0 * RPM)["critical_speed"].values / RPM
    stiff = critical_speeds(rig("rodrigues_rig"), balls=False)["critical_speed"].values / RPM
    farthest = 100.0 * float(np.abs(found / stiff - 1.0).max())
    rows.append(Found("internal", "critical speeds below, farthest from the rigid rotor", "%", 0.0, farthest, 2.0))
    save_picture(ab.plot.modes(modes(machine, 0.0, modes=6)), out / "first_bending.png")
    return compared_all("Rodrigues 2011", "section 4", rows)


def bending_speed(machine: Machine) -> float:
    """Lowest critical speed above those of the rigid body, rpm."""
    found = critical_speeds(machine, highest=20000.0 * RPM)["critical_speed"].values / RPM
    return float(min(speed for speed in found if speed > 4000.0))


def distribution() -> tuple[float, float, float]:
    """Mass of the disk, of one housing (kg), and distance of the motor beyond B1 (m)."""
    line = DENSITY * 0.25 * math.pi * DIAMETER**2
    own = MOTOR * MOTOR_SIZE**2 * (1.0 / 16.0 + 1.0 / 12.0)

    def miss(unknown: Any) -> list[float]:
        disk, housing, arm = unknown
        length = FIRST + SECOND + arm
        parts = [
            (disk, DISK),
            (housing, 0.0),
            (housing, FIRST + SECOND),
            (MOTOR, -arm),
            (line * length, 0.5 * length - arm),
        ]
        about = sum(m * (z - FIRST) ** 2 for m, z in parts) + line * length**3 / 12.0 + own + 0.5 * _polar(length)
        return [
            sum(m for m, _ in parts) / MASS - 1.0,
            sum(m * (z - FIRST) for m, z in parts) / (MASS * FIRST),
            about / TRANSVERSE - 1.0,
        ]

    found = root(miss, [0.6, 0.2, 0.05], tol=1e-12)
    assert found.success, found.message
    disk, housing, arm = (float(value) for value in found.x)
    return disk, housing, arm


def shaft_model(hub: float = 0.0) -> Machine:
    """The rig as a shaft; ``hub`` is the length over which the disk holds it straight, m."""
    disk, housing, arm = distribution()
    length = FIRST + SECOND + arm
    polar = _polar(length)
    before, after = arm + DISK - 0.5 * hub, SECOND + FIRST - DISK - 0.5 * hub
    steel = f'material = {{ density = {DENSITY}, youngs_modulus = "206 GPa", poisson_ratio = 0.3 }}'
    rigid = 'material = { density = 7850, youngs_modulus = "20600 GPa", poisson_ratio = 0.3 }'
    pieces = [(before, 12, steel), *([(hub, 2, rigid)] if hub else []), (after, 10, steel)]
    segments = ", ".join(f"{{ length = {x}, diameter = {DIAMETER}, elements = {n}, {m} }}" for x, n, m in pieces)
    own = (MOTOR * MOTOR_SIZE**2 * (1.0 / 16.0 + 1.0 / 12.0), MOTOR * MOTOR_SIZE**2 / 8.0)
    disks = [
        (0.0, MOTOR, *own),
        (arm + DISK, disk, 0.5 * polar, polar),
        (arm, housing, 0.0, 0.0),
        (length, housing, 0.0, 0.0),
    ]
    text = f'name = "Rig as a shaft"\naxis = "horizontal"\n[rotor]\nkind = "shaft"\nsegments = [{segments}]\n'
    for z, mass, transverse, round_axis in disks:
        text += f"[[rotor.disks]]\nposition = {z}\nmass = {mass}\n"
        text += f"transverse_inertia = {transverse}\npolar_inertia = {round_axis}\n"
    for z in (arm, length):
        text += f"[[rotor.supports]]\nposition = {z}\nstiffness = [21500, 15800]\n"
    text += f'[[stations]]\nname = "disk"\nposition = {arm + DISK}\n'
    text += '[drive]\nkind = "speed"\nprofile = { kind = "constant", speed = "4500 rpm" }\n'
    return parse_race_machine(text, "the rig as a shaft")


def _polar(length: float) -> float:
    """Polar inertia of the disk: of the whole less that of shaft and motor, kg m^2."""
    shaft = DENSITY * math.pi * DIAMETER**4 / 32.0 * length
    return POLAR - shaft - MOTOR * MOTOR_SIZE**2 / 8.0

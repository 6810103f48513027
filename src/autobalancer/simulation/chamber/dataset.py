"""From raw samples to a labelled result."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.chamber import ChamberNumbers
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.chamber import layout as at
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.labels import label
from autobalancer.results.provenance import provenance
from autobalancer.simulation.chamber.energy import energies

Array = Any


def chamber_dataset(
    machine: ChamberMachine, p: ChamberNumbers, times: Array, rows: Array, balls: Array, ledgers: Array, energy: float
) -> xr.Dataset:
    """Samples as ``verlet`` keeps them as a dataset; ``energy`` is that at time 0."""
    kinetic, potential = energies(p, rows, balls)
    after = rows[:, at.HOST :]
    stored = after[:, 15]
    losses = {
        "loss_contact": at.P_CONTACT,
        "loss_friction": at.P_FRICTION,
        "loss_rolling": at.P_ROLLING,
        "loss_supports": at.P_SUPPORTS,
        "loss_bearings": at.P_BEARINGS,
        "loss_drag": at.P_DRAG,
    }
    work = ledgers[:, at.P_MOTOR]
    lost = sum(ledgers[:, place] for place in losses.values())
    vector, each = ("time", "axis"), ("time", "ball", "axis")
    data: dict[str, Any] = {
        "rotor_angle": ("time", rows[:, at.Q + 6]),
        "speed": ("time", rows[:, at.V + 6]),
        "body_position": (vector, rows[:, at.Q : at.Q + 3]),
        "body_rotation": (vector, rows[:, at.Q + 3 : at.Q + 6]),
        "ball_position": (each, balls[:, :, 0:3]),
        "ball_velocity": (each, balls[:, :, 3:6]),
        "ball_spin": (each, balls[:, :, 6:9]),
        "bearing_force": (("time", "bearing", "axis"), after[:, 0:6].reshape(-1, 2, 3)),
        "constraint_force": (vector, after[:, 6:9]),
        "constraint_moment": (vector, after[:, 9:12]),
        "motor_torque": ("time", rows[:, at.TORQUE]),
        "energy_kinetic": ("time", kinetic),
        "energy_potential": ("time", potential),
        "energy_contact": ("time", stored),
        "work_motor": ("time", work),
        **{name: ("time", ledgers[:, place]) for name, place in losses.items()},
        "energy_error": ("time", kinetic + potential + stored - energy - work + lost),
        "contacts_ball": ("time", after[:, 12].astype(np.int64)),
        "contacts_wall": ("time", after[:, 13].astype(np.int64)),
        "greatest_contact_force": ("time", after[:, 14]),
    }
    coordinates = {
        "time": times,
        "ball": np.arange(1, p.balls.shape[0] + 1),
        "axis": np.array(["x", "y", "z"], dtype=object),
        "bearing": np.array([1, 2]),
        "ball_radius": ("ball", p.balls[:, at.RADIUS].copy()),
        "ball_mass": ("ball", p.balls[:, at.MASS].copy()),
        "chamber": ("ball", p.balls[:, at.CHAMBER].astype(np.int64) + 1),
    }
    return label(xr.Dataset({key: (dims, np.array(value)) for key, (dims, value) in data.items()}, coordinates))


def joined(parts: list[xr.Dataset]) -> xr.Dataset:
    """Parts of a run one after the other."""
    if len(parts) == 1:
        return parts[0]
    return xr.concat(parts, "time", data_vars="minimal", coords="minimal", compat="override", join="override")


def labeled(
    run: xr.Dataset, machine: ChamberMachine, attributes: dict[str, Any], outcome: str, text: str, duration: float
) -> xr.Dataset:
    """The dataset with attributes that say what it is."""
    return run.assign_attrs(
        title=f"Run of {machine.name}",
        **provenance(),
        machine=machine_text(machine),
        machine_name=machine.name,
        **attributes,
        outcome=outcome,
        outcome_text=text,
        duration=duration,
    )

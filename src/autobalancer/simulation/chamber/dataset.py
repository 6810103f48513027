"""From raw samples to a labelled result."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.chamber.chamber import Chamber
from autobalancer.kernels.chamber.records import ACCOUNT, SAMPLE
from autobalancer.kernels.fields import Rows
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.labels import label
from autobalancer.results.provenance import provenance
from autobalancer.simulation.chamber.answer import ChamberRun
from autobalancer.simulation.chamber.energy import energies

Array = Any
DIMENSIONS = ((), ("time",), ("time", "axis"), ("time", "bearing", "axis"))  # by their number
KEPT = [field.name for field in SAMPLE.fields if field.name not in ("body_rate", "tilting")]
LOSSES = [field.name for field in ACCOUNT.fields if field.name.startswith("loss_")]


def chamber_dataset(
    machine: ChamberMachine, chamber: Chamber, times: Array, samples: Rows, balls: Rows, energy: float
) -> xr.Dataset:
    """Samples as ``verlet`` keeps them as a dataset; ``energy`` is that at time 0."""
    kinetic, potential = energies(chamber, samples, balls)
    total = kinetic + potential + samples.energy_contact
    lost = sum(samples[name] for name in LOSSES)
    data: dict[str, Any] = {name: (DIMENSIONS[samples[name].ndim], samples[name]) for name in KEPT}
    data |= {f"ball_{name}": (("time", "ball", "axis"), balls[name]) for name in balls.dtype.names}
    data |= {
        "energy_kinetic": ("time", kinetic),
        "energy_potential": ("time", potential),
        "energy_error": ("time", total - energy - samples.work_motor + lost),
    }
    if chamber.contact.cylinders:
        data["tilting"] = ("time", samples.tilting)
    coordinates: dict[str, Any] = {
        "time": times,
        "ball": np.arange(1, chamber.balls.shape[0] + 1),
        "axis": np.array(["x", "y", "z"], dtype=object),
        "bearing": np.array([1, 2]),
        "ball_radius": ("ball", chamber.balls.radius.copy()),
        "ball_mass": ("ball", chamber.balls.mass.copy()),
        "chamber": ("ball", chamber.balls.chamber + 1),
    }
    if chamber.contact.cylinders:
        coordinates["ball_length"] = ("ball", 2.0 * chamber.balls.half_length)
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
    about = run.assign_attrs(
        title=f"Run of {machine.name}",
        **provenance(),
        machine=machine_text(machine),
        machine_name=machine.name,
        **attributes,
        outcome=outcome,
        outcome_text=text,
        duration=duration,
    )
    return ChamberRun.of(about)

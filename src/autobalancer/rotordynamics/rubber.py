"""Unbalance response on rubber that softens with the amplitude, and its own table."""

from __future__ import annotations

import numpy as np
import xarray as xr

from autobalancer.assembly.rotors import LateralModel, lateral_model
from autobalancer.assembly.rotors.ellipses.steady import Ellipses
from autobalancer.assembly.rotors.softened import Softened, softened
from autobalancer.laws.rubber import Motion
from autobalancer.machine import Machine
from autobalancer.rotordynamics.eigenproblem import FreeMotions, correlation, free_motions

PASSES, SAME = 60, 1e-12  # of a mode that is stiffened by its own amplitude, and relative change that counts as none
UNMOVED = 1e-9  # of the largest coordinate


def rubber_of(machine: Machine, model: LateralModel) -> Softened | None:
    """The softening rubber of a machine whose mass is that of ``model``; none without any."""
    return softened(machine, lateral_model(machine), model)


def add_rubber(found: xr.Dataset, soft: Softened, steady: Ellipses) -> None:
    """Add deflection, stiffness and loss of each piece of rubber, and what the first harmonic leaves out."""
    found.coords["rubber"] = (
        "rubber",
        np.array([mount.name for mount in soft.mounts], dtype=object),
        {"long_name": "rubber"},
    )
    for name, numbers, text, unit in (
        ("rubber_amplitude", steady.amplitude, "greatest deflection of the rubber", "m"),
        ("rubber_minor", steady.minor, "least deflection of the rubber, negative where it turns backward", "m"),
        ("rubber_stiffness", steady.stiffness.real, "stiffness of the rubber", "N/m"),
        ("rubber_loss", steady.stiffness.imag, "loss of the rubber", "N/m"),
        ("rubber_third_harmonic", steady.third, "its deflection at three times the speed, left out", "m"),
    ):
        found[name] = (("speed", "rubber"), numbers, {"long_name": text, "units": unit})
    beyond = [
        mount.name
        for mount, law, size in zip(soft.mounts, soft.laws, steady.amplitude.max(axis=0), strict=True)
        if size > law.largest_amplitude
    ]
    found.attrs["rubber_beyond_its_elements"] = beyond


def at_amplitude(soft: Softened, speed: float, start: FreeMotions, amplitude: float, motion: Motion) -> FreeMotions:
    """Free motions in which the farthest moving piece of rubber moves ``amplitude``; each has its own stiffness.

    K'' counts as the damping K''/w at the frequency of the motion. Pieces that move less in this shape are stiffer.
    """
    values, vectors = start.eigenvalue.copy(), start.vector.copy()
    for k in range(start.count):
        for _ in range(PASSES):
            stretch = np.array([mount.rows @ vectors[k] for mount in soft.mounts])  # (M, 2)
            size = np.sqrt(0.5 * ((np.abs(stretch) ** 2).sum(axis=1) + np.abs((stretch**2).sum(axis=1))))
            if size.max() <= UNMOVED * np.abs(vectors[k]).max():
                break  # a shape that leaves the rubber at rest
            model = soft.at_amplitude(amplitude * size / size.max(), float(values[k].imag), motion)
            every = free_motions(model, speed)
            alike = correlation(vectors[k][None], every.vector, model.mass)[0]
            same = int(np.argmax(alike - 1e-6 * np.abs(every.eigenvalue - values[k]) / abs(values[k])))
            moved = abs(every.eigenvalue[same] - values[k]) / abs(values[k])
            values[k], vectors[k] = every.eigenvalue[same], every.vector[same]
            if moved < SAME:
                break
    order = np.argsort(
        np.round(values.imag / np.abs(values).max(initial=1e-300), 9), kind="stable"
    )  # keeps pairs in order
    return FreeMotions(values[order], vectors[order], start.real)

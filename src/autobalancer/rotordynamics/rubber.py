"""Unbalance response on rubber that softens with the amplitude, and its own table."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import xarray as xr

from autobalancer.assembly.rotors import LateralModel, lateral_model
from autobalancer.assembly.rotors.ellipses import Ellipses, alike_springs
from autobalancer.assembly.rotors.equivalent_stiffness import Softened, softened
from autobalancer.assembly.rotors.lateral_model import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.eigenproblem import FreeMotions, correlation, free_motions

ModeMotion = Literal["line", "circle", "ellipse"]

PASSES, SAME, NEAR = (
    60,
    1e-12,
    1e-6,
)  # of a mode stiffened by its own amplitude, and relative changes: none, and accepted
ROUND = 1e-6  # of an ellipse that counts as a circle
UNMOVED = 1e-9  # of the largest coordinate


def _halfway(before: LateralModel | None, model: LateralModel) -> LateralModel:
    """Between two models, so that a shape and the stiffness that follows from it do not swing about each other."""
    if before is None:
        return model
    stiffness, damping = 0.5 * (before.stiffness + model.stiffness), 0.5 * (before.damping + model.damping)
    return replace(model, stiffness=stiffness, damping=damping)


def on_ellipses(soft: Softened, stretch: Complexes, size: Floats, frequency: float) -> LateralModel:
    """The rotor with springs that act as its rubber does in ellipses of a shape (M, 2) and sizes (M,), m."""
    stiffness, damping = soft.sliding.stiffness, soft.sliding.damping
    for law, mount, shape, amplitude in zip(soft.laws, soft.mounts, stretch, size, strict=True):
        if amplitude > UNMOVED * size.max():
            springs = alike_springs(law, shape, float(amplitude), frequency)
            stiffness = stiffness + mount.rows.T @ springs.real @ mount.rows
            damping = damping + mount.rows.T @ springs.imag @ mount.rows / frequency
        else:
            still = law.at_rest(frequency) - law.elastic - 1j * law.viscous * frequency
            stiffness = stiffness + still.real * (mount.rows.T @ mount.rows)
            damping = damping + still.imag / frequency * (mount.rows.T @ mount.rows)
    return replace(soft.sliding, stiffness=stiffness, damping=damping)


def rubber_of(machine: Machine, model: LateralModel) -> Softened | None:
    """The softening rubber of a machine whose mass is that of ``model``; none without any."""
    return softened(machine, lateral_model(machine), model)


def add_rubber(dataset: xr.Dataset, soft: Softened, steady: Ellipses) -> None:
    """Add deflection, stiffness and loss of each piece of rubber, and what the first harmonic leaves out."""
    dataset.coords["rubber"] = (
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
        dataset[name] = (("speed", "rubber"), numbers, {"long_name": text, "units": unit})
    beyond = [
        mount.name
        for mount, law, size in zip(soft.mounts, soft.laws, steady.amplitude.max(axis=0), strict=True)
        if size > law.largest_amplitude
    ]
    dataset.attrs["rubber_beyond_its_elements"] = beyond
    apart = np.abs(steady.minor) < (1.0 - ROUND) * steady.amplitude
    if apart.any() and not np.isnan(steady.third).any():
        dataset.attrs["rubber_third_harmonic"] = float((steady.third / steady.amplitude).max())


def at_amplitude(soft: Softened, speed: float, start: FreeMotions, amplitude: float, motion: ModeMotion) -> FreeMotions:
    """Free motions in which the farthest moving piece of rubber moves ``amplitude``; each has its own stiffness.

    K'' counts as the damping K''/w at the frequency of the motion. Pieces that move less in this shape are stiffer.

    Raises
    ------
    QuestionError
        If an ellipse of a mode and the stiffness of the rubber in it are not found together.
    """
    values, vectors = start.eigenvalue.copy(), start.vector.copy()
    for k in range(start.count):
        moved = 0.0
        model: LateralModel | None = None
        for _ in range(PASSES):
            stretch = np.array([mount.rows @ vectors[k] for mount in soft.mounts])  # (M, 2)
            size = np.sqrt(0.5 * ((np.abs(stretch) ** 2).sum(axis=1) + np.abs((stretch**2).sum(axis=1))))
            if size.max() <= UNMOVED * np.abs(vectors[k]).max():
                break  # a shape that leaves the rubber at rest
            sizes, frequency = amplitude * size / size.max(), float(values[k].imag)
            if motion == "ellipse":
                model = _halfway(model, on_ellipses(soft, stretch, sizes, frequency))
            else:
                model = soft.at_amplitude(sizes, frequency, motion)
            every = free_motions(model, speed)
            alike = correlation(vectors[k][None], every.vector, model.mass)[0]
            same = int(np.argmax(alike - 1e-6 * np.abs(every.eigenvalue - values[k]) / abs(values[k])))
            moved = abs(every.eigenvalue[same] - values[k]) / abs(values[k])
            values[k], vectors[k] = every.eigenvalue[same], every.vector[same]
            if moved < SAME:
                break
        if motion == "ellipse" and moved > NEAR:
            raise QuestionError(
                f"modes: mode {k + 1} and the stiffness of the rubber in its ellipse were not found together; give "
                "motion='line' or 'circle', or another amplitude"
            )
    order = np.argsort(
        np.round(values.imag / np.abs(values).max(initial=1e-300), 9), kind="stable"
    )  # keeps pairs in order
    return FreeMotions(values[order], vectors[order], start.real)

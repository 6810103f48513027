"""A machine with a planar rotor in place of another one: what is kept, and what is said of it."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from autobalancer.assembly.rotors import LateralModel, Rows, balancer_rows, unbalance_shape
from autobalancer.assembly.rotors.model import Complexes, Floats
from autobalancer.machine import Machine, PlanarRotor, Unbalance
from autobalancer.rotordynamics.synchronous_modes import PlaceMode

SAME_PLANE = 1e-9  # relative difference of the rows of two places


def planar_machine(
    machine: Machine,
    model: LateralModel,
    rows: Rows,
    place: str,
    constants: Floats,
    modes: list[PlaceMode],
    method: str,
    frequency: str,
    valid: list[tuple[float, float]],
    tolerance: float,
    at_mode: list[float],
) -> tuple[Machine, list[str]]:
    """The machine and notes on what it leaves out.

    ``constants`` are k, M, b along x and y, (2, 3). For each mode: ``valid``, the range of speeds that it represents, and
    ``at_mode``, the deviation of the receptance at its speed.
    """
    notes: list[str] = []
    mass, k, b = (float(c) for c in constants[0, [1, 0, 2]])
    stiffness: float | tuple[float, float] = k
    damping: float | tuple[float, float] = b
    if np.any(constants[0] != constants[1]):
        # a planar rotor has one mass: each direction keeps its frequency and damping ratio
        first, second = (float(m) for m in constants[:, 1])
        mass = math.sqrt(first * second)
        stiffness = (k * mass / first, float(constants[1, 0]) * mass / second)
        damping = (b * mass / first, float(constants[1, 2]) * mass / second)
        if abs(first / second - 1.0) > 1e-6:
            notes.append(
                f"the masses along x and y are {first:.5g} and {second:.5g} kg; the planar rotor has their geometric mean and "
                "the critical speeds and damping ratios of both directions"
            )
    kept, left = [], []
    for i, (balancer, there) in enumerate(zip(machine.balancers, balancer_rows(machine, model), strict=True)):
        size = float(np.abs(rows.deflection).max())
        if np.abs(there.deflection - rows.deflection).max() <= SAME_PLANE * size:
            entries = {key: getattr(balancer, key) for key in balancer.model_fields_set - {"station"}}
            kept.append(type(balancer)(**entries))
        else:
            left.append(balancer.name or f"balancer {i + 1}")
    if left:
        notes.append(f"left out, because in another plane: {', '.join(left)}")
    unbalances, difference = _unbalances(machine, model, modes)
    if difference > 0.01:
        notes.append(
            f"the unbalance drives the modes along x and y differently, by {100 * difference:.3g} %; the mean is kept"
        )
    way = "static stiffness" if method == "static" else "modal stiffness and mass"
    kind = "critical speed" if frequency == "critical" else "natural frequency"
    reach = []
    for i, (mode, (low, high), away) in enumerate(zip(modes, valid, at_mode, strict=True)):
        where = f"along {'xy'[i]}: " if len(modes) == 2 else ""
        if math.isfinite(low) and low < high:
            text = (
                f"its receptance is that of the rotor within {100 * tolerance:g} % from {low:.4g} to {high:.4g} rad/s"
            )
        else:
            text = f"near this speed its receptance deviates from that of the rotor by {100 * away:.3g} %"
        reach.append(f"{where}{kind} {mode.speed:.5g} rad/s, {text}")
    text = (
        f"Planar oscillator of {machine.name!r} at {place}: {way} at this place; {'; '.join(reach)}. "
        "Unbalances count as far as they drive the mode."
    )
    fields: dict[str, Any] = {key: getattr(machine, key) for key in ("axis", "gravity", "drive", "start", "run")}
    wanted = {key: value for key, value in fields.items() if key in machine.model_fields_set}
    inertia = machine.rotor.inertia
    rotor = PlanarRotor(mass=mass, stiffness=stiffness, damping=damping, inertia=inertia)
    planar = Machine(
        name=f"{machine.name}, planar",
        description=" ".join([text, *(note[0].upper() + note[1:] + "." for note in notes), machine.description]).strip(),
        rotor=rotor, unbalances=unbalances, balancers=tuple(kept), **wanted,
    )  # fmt: skip
    return planar, notes


def _unbalances(machine: Machine, model: LateralModel, modes: list[PlaceMode]) -> tuple[tuple[Unbalance, ...], float]:
    """Point unbalances at the place that drive the mode as those of the rotor do, and how far x and y differ."""
    found, worst = [], 0.0
    largest = 0.0
    sizes = []
    for i, unbalance in enumerate(machine.unbalances):
        shape = unbalance_shape(machine, model, i)
        values = [_driven(mode, shape, axis, model) for axis, mode in enumerate(modes)]
        moment = complex(np.mean(values))
        sizes.append(abs(values[0] - values[-1]))
        largest = max(largest, abs(moment))
        found.append(
            Unbalance(moment=abs(moment), angle=cmath.phase(moment) if moment else 0.0, schedule=unbalance.schedule)
        )
    if largest:
        worst = max(sizes) / largest
    return tuple(found), worst


def _driven(mode: PlaceMode, shape: Complexes, axis: int, model: LateralModel) -> complex:
    """phi^H u over phi^H r: of an anisotropic rotor the part of the mode along its direction."""
    vector = mode.vector if model.isotropic else mode.vector[axis * model.pairs : (axis + 1) * model.pairs]
    return complex(vector.conj() @ shape / np.conj(mode.deflection))

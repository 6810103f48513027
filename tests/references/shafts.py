"""Shaft rotors for tests, and what is read off their matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import eigh

from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.machine import Machine, ShaftRotor

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poisson_ratio": 0.3}
DRIVE = {"kind": "speed", "profile": {"kind": "table", "time": [0.0, 1.0], "speed": [0.0, 100.0]}}


def machine(rotor: Any, axis: str = "vertical", **more: Any) -> Machine:
    return Machine(name="shaft", axis=axis, rotor=rotor, drive=DRIVE, **more)


def shaft(length: float = 1.0, diameter: float = 0.05, elements: int = 8, **more: Any) -> dict[str, Any]:
    """A uniform steel shaft; ``material``, ``disks``, ``supports`` and so on replace or add."""
    inner = more.pop("inner_diameter", 0.0)
    segment = {"length": length, "diameter": diameter, "inner_diameter": inner, "elements": elements}
    if "shear_coefficient" in more:
        segment["shear_coefficient"] = more.pop("shear_coefficient")
    return {"kind": "shaft", "material": STEEL, "segments": [segment], **more}


def model_of(rotor: dict[str, Any], axis: str = "vertical", **more: Any) -> LateralModel:
    return lateral_model(machine(rotor, axis, **more))


def part(rotor: dict[str, Any]) -> ShaftRotor:
    return ShaftRotor(**rotor)


def frequencies(model: LateralModel, fixed: tuple[int, ...] = ()) -> np.ndarray:
    """Natural frequencies at rest in one plane, rad/s, with the coordinates ``fixed`` held."""
    n = model.pairs
    free = [i for i in range(n) if i not in [f % n for f in fixed]]
    stiffness, mass = model.stiffness_at(0.0)[:n, :n], model.mass[:n, :n]
    # turned over, so that the slowest are the most accurate
    inverse = eigh(mass[np.ix_(free, free)], stiffness[np.ix_(free, free)], eigvals_only=True)
    return 1.0 / np.sqrt(np.abs(inverse[::-1]))


def whirl(model: LateralModel, speed: float, fixed: tuple[int, ...] = ()) -> np.ndarray:
    """Whirl frequencies of an undamped isotropic rotor, rad/s, ascending, forward positive."""
    mass, turning, stiffness = model.complex_matrices(speed)
    free = [i for i in range(model.pairs) if i not in [f % model.pairs for f in fixed]]
    mass, turning, stiffness = (a[np.ix_(free, free)] for a in (mass, turning, stiffness))
    size = mass.shape[0]
    first = np.block([
        [np.zeros((size, size)), np.eye(size)],
        [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, turning)],
    ])  # fmt: skip
    return np.sort(np.linalg.eigvals(first).imag)

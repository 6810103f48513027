"""The planes of the balancers: where they are, what they are called, and what their balls have to balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors import LateralModel, balancer_rows
from autobalancer.assembly.rotors.lateral_model import Complexes, Floats, Rows
from autobalancer.machine import Machine, PlanarRotor


@dataclass(frozen=True)
class Planes:
    """Balancers at the same place of the axis share a plane."""

    names: tuple[str, ...]  # (P,)
    rows: tuple[Rows, ...]  # (P,)
    of_balancer: tuple[int, ...]  # plane of each balancer, from 0


def planes_of(machine: Machine, model: LateralModel) -> Planes:
    """The planes of a machine, named by their station, else by their first balancer, else by its number."""
    names: list[str] = []
    rows: list[Rows] = []
    place: list[int] = []
    for number, (balancer, row) in enumerate(zip(machine.balancers, balancer_rows(machine, model), strict=True), 1):
        same = [i for i, other in enumerate(rows) if np.array_equal(other.deflection, row.deflection)]
        if not same:
            rows.append(row)
            name = balancer.station if isinstance(balancer.station, str) else balancer.name or f"plane {number}"
            names.append(name if name not in names else f"{name} ({number})")
        place.append(same[0] if same else len(rows) - 1)
    if isinstance(machine.rotor, PlanarRotor):
        names = ["rotor"] * len(names)
    return Planes(tuple(names), tuple(rows), tuple(place))


def least_moments(host: Complexes, wanted: Complexes, capability: Floats) -> Complexes:
    """Moments s with ``host`` s = ``wanted``, (..., P); of many, those that take the least share of the capabilities.

    ``host`` is (..., Q, P) and ``wanted`` (..., Q).
    """
    share = np.asarray(capability, np.float64)
    share = np.where(share > 0.0, share, 1e-6 * share.max(initial=0.0) or 1.0)  # a full race can balance nothing
    inverse = np.linalg.pinv(host * share, rcond=1e-11)
    return np.asarray(share * (inverse @ wanted[..., None])[..., 0], np.complex128)

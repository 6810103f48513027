"""Where bearings that become stiffer as they deflect sit in a rotor."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from autobalancer.assembly.rotors.model import LateralModel, Matrix
from autobalancer.machine import Hardening, Machine, MultibodyRotor, PlanarRotor


def hardenings(machine: Machine) -> Iterator[tuple[int, Hardening]]:
    """Each of them with the number of its support, from 0."""
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.hardening is not None:
            yield 0, rotor.hardening
    elif not isinstance(rotor, MultibodyRotor):
        for number, support in enumerate(rotor.supports):
            if support.hardening is not None:
                yield number, support.hardening


def hardening_rows(machine: Machine, model: LateralModel) -> Matrix:
    """Rows of the deflections along x and y in all of them, (2 bearings, N)."""
    rotor = machine.rotor
    found: list[Matrix] = []
    for number, _ in hardenings(machine):
        if isinstance(rotor, PlanarRotor):
            found.append(np.eye(2))
        elif not isinstance(rotor, MultibodyRotor):
            place = model.axis.rows(float(rotor.supports[number].position), None).deflection
            found.append(np.asarray(model.both(place[None])))
    return np.vstack(found) if found else np.zeros((0, model.size))

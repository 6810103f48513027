"""Loads of the unbalances of a machine on the coordinates of its rotor."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.profile import schedule_times, unbalance_factor, unbalance_vector
from autobalancer.assembly.rotors import LateralModel, unbalance_shape
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, Unbalance
from autobalancer.stability.host.planar import Complexes


def load_of(machine: Machine, model: LateralModel, largest: bool) -> tuple[Complexes, complex]:
    """Load and resultant after all schedules, or at the time at which the load is largest."""
    if not largest:
        return _load_at(machine, model, np.inf, False)
    inverse = np.linalg.inv(model.mass[: model.pairs, : model.pairs])
    found = loads_at_corners(machine, model)
    return max(found, key=lambda one: float(np.real(one[0].conj() @ inverse @ one[0])))


def loads_at_corners(machine: Machine, model: LateralModel) -> list[tuple[Complexes, complex]]:
    """Load and resultant just before and after each time of all schedules; between two of them both change linearly."""
    return [_load_at(machine, model, time, before) for time in schedule_times(machine) for before in (False, True)]


def _load_at(machine: Machine, model: LateralModel, time: float, before: bool) -> tuple[Complexes, complex]:
    load = np.zeros(model.pairs, np.complex128)
    for number, part in enumerate(machine.unbalances):
        load += unbalance_factor(part, time, before=before) * unbalance_shape(machine, model, number)
    return load, unbalance_vector(machine, time, before=before)


def load_of_size(machine: Machine, model: LateralModel, unbalance: complex | float) -> tuple[Complexes, complex]:
    """Load and resultant with another size or vector of the only unbalance, kg m."""
    if len(machine.unbalances) != 1 or machine.unbalances[0].is_couple:
        raise QuestionError(
            f"unbalance: the machine has {len(machine.unbalances)} unbalances along its axis; change the one you mean in "
            "the machine, such as 'unbalances[1].moment'"
        )
    value, part = complex(unbalance), machine.unbalances[0]
    if not np.isfinite(value) or (not isinstance(unbalance, complex) and value.real < 0.0):
        raise QuestionError(f"unbalance: given {unbalance!r}; must be a size not below zero, in kg m, or a vector")
    direction = complex(np.exp(1j * float(part.angle)))
    if isinstance(unbalance, complex):
        value = value / direction
    one = machine.model_copy(update={"unbalances": (Unbalance(moment=1.0, angle=part.angle, station=part.station),)})
    return np.asarray(value * unbalance_shape(one, model, 0)), value * direction

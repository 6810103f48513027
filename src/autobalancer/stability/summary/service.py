"""What the rotor does at its service speed without balancing: the state of things before balls do anything."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.gauges import gauges_of
from autobalancer.assembly.place_response import plane_unbalances, without_balancing
from autobalancer.assembly.places import places_of, turning_mass
from autobalancer.assembly.profile import unbalance_vector
from autobalancer.assembly.system import Assembly
from autobalancer.assembly.terms import Theory, ignores
from autobalancer.kernels.measures.gauges import Gauges
from autobalancer.laws.balance_quality import balance_grade
from autobalancer.machine import Machine

LATE = 1e300  # a time after all schedules, s


@dataclass(frozen=True)
class Service:
    """At the highest speed of the drive, steady, with the balls spread evenly and held, after all schedules; SI.

    ``grade`` is G of ISO 21940-11, U W/M in mm/s, with the ``unbalance`` U (kg m) of the rotor in its
    plane; of several planes (``added_up``) with the sum of what each of them has to balance. ``vibration`` is the greatest at
    each place, ``force`` that on each support; empty where the machine is shaken from outside.
    """

    speed: float
    unbalance: float
    added_up: bool
    grade: float
    vibration: tuple[tuple[str, float], ...]
    force: tuple[tuple[str, float], ...]
    ignores: str = ""


def service_of(machine: Machine, assembly: Assembly, highest: float | None) -> Service | None:
    """The service of a machine; None where its drive does not say how fast it runs, or it has no unbalance."""
    if highest is None or not highest > 0.0:
        return None
    places = places_of(machine, assembly)
    gauges = gauges_of(assembly, places, centered=True)
    unbalance, several = _unbalance(machine, assembly, gauges, highest), len(places.planes) > 1
    if not (math.isfinite(unbalance) and unbalance > 0.0):
        return None
    grade = balance_grade(unbalance, turning_mass(places), highest)
    if machine.excitations:
        return Service(highest, unbalance, several, grade, (), ())
    vibration, force = (found.tolist() for found in without_balancing(assembly, places, gauges, LATE, highest))
    return Service(
        highest,
        unbalance,
        several,
        grade,
        tuple(zip(places.names, vibration, strict=True)),
        tuple(zip(places.supports, force, strict=True)),
        ignores(machine, Theory.ROTOR),
    )


def _unbalance(machine: Machine, assembly: Assembly, gauges: Gauges, speed: float) -> float:
    if gauges.capability.size > 1:
        return float(np.abs(plane_unbalances(assembly, gauges, LATE, speed)).sum())
    return abs(unbalance_vector(machine, np.inf))

"""Masses, critical speeds and damping of the rotor in a machine, whatever its kind; and what each station has to balance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rubber import rubbers
from autobalancer.assembly.system import total_mass
from autobalancer.assembly.terms import weightless
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.results.number_text import significant
from autobalancer.stability.host.damping import damping_ratio
from autobalancer.stability.host.forces import without_forces
from autobalancer.stability.host.loads import loads_at_corners
from autobalancer.stability.host.stations import Stations, stations
from autobalancer.stability.states.described import service_speed
from autobalancer.stability.states.stations import required

SHOWN = 6  # critical speeds of a rotor that tilts or bends


@dataclass(frozen=True)
class StationSummary:
    """A plane of balancers: what its balls can balance, and what they have to so that all stations are at rest, kg m.

    ``required`` is the greatest over time of what this station needs, where unbalances change by a schedule; stations may
    need their greatest at different times. ``speed`` (rad/s) is that for which ``required`` holds; on a rigid rotor with
    two planes it holds for any.
    """

    name: str
    capability: float
    required: float
    speed: float


@dataclass(frozen=True)
class Frame:
    """Rotor and supports as a whole, SI."""

    rotor_mass: float
    total_mass: float
    critical_speeds: tuple[float, ...]  # undamped, with the balls on the rotor; a planar rotor: along x, y
    damping_ratios: tuple[float, ...]
    stations: tuple[StationSummary, ...] = ()


def frame_of(machine: Machine, highest: float | None) -> Frame:
    """The frame of a machine; ``highest`` is the speed for which its stations are asked."""
    rotor = machine.rotor
    if not isinstance(rotor, PlanarRotor):
        return _spatial(machine, highest)
    mass = total_mass(machine, resolve(machine))
    model = lateral_model(machine)
    stiffness, damping = model.stiffness[0], model.damping[0]
    if stiffness[0, 1] != 0.0:  # it rests in its bearing between x and y
        axes = np.linalg.eigh(stiffness)[1]
        stiffness, damping = axes.T @ stiffness @ axes, axes.T @ damping @ axes
    pairs = list(zip(np.diag(stiffness).tolist(), np.diag(damping).tolist(), strict=True))
    if pairs[0] == pairs[1]:
        pairs = pairs[:1]
    return Frame(
        float(rotor.mass),
        mass,
        tuple(math.sqrt(k / mass) for k, _ in pairs),
        tuple(b / (2.0 * math.sqrt(k * mass)) for k, b in pairs),
    )


def rubber_texts(machine: Machine) -> tuple[str, ...]:
    """How soft each piece of softening rubber becomes, and what is counted with it; empty without any."""
    found = []
    for name, rubber in rubbers(machine):
        stiff, soft = (significant(1e-3 * one) for one in (rubber.initial_stiffness, float(rubber.stiffness)))
        found.append(f"{name}: {stiff} kN/m in small motions, {soft} kN/m in the largest, when all elements slide")
    if not found:
        return ()
    what = "critical speeds, borders and what friction holds are those of small motions"
    return (*found, f"{what}; release, capture and vibration without balancing know how far it moves")


def _spatial(machine: Machine, highest: float | None) -> Frame:
    guided = weightless(without_forces(machine)).model_copy(update={"tilting_races": "deflection"})
    st = stations(guided, largest=True)
    speeds = st.critical_speeds[:SHOWN]
    return Frame(
        lateral_model(machine).total_mass,
        st.model.total_mass,
        speeds,
        tuple(damping_ratio(st.model, speed) for speed in speeds),
        _needs(guided, st, highest),
    )


def _needs(machine: Machine, st: Stations, highest: float | None) -> tuple[StationSummary, ...]:
    if st.moment.size == 0:
        return ()
    speed = service_speed(st, highest)
    try:
        loads = [load for load, _ in loads_at_corners(machine, st.model)]
        needed = np.max([np.abs(required(replace(st, load=load), speed)) for load in loads], axis=0)
    except QuestionError:  # a critical speed of an undamped rotor
        needed = np.full(len(st.names), math.nan)
    return tuple(
        StationSummary(name, float(have), float(need), float(speed))
        for name, have, need in zip(st.names, st.capability, needed, strict=True)
    )

"""The numbers that measures need of a machine, and room for them, as kernels/measures/workspace.py names them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalancer.assembly.contact import Tables, law_numbers
from autobalancer.assembly.places import Places
from autobalancer.assembly.reduced_rotor import has_hardening
from autobalancer.assembly.system import Assembly
from autobalancer.assembly.touches import Touch
from autobalancer.kernels.measures.columns_of_measures import ITERATED, LINEAR, OF_IMPACTS, UNKNOWN
from autobalancer.kernels.measures.workspace import SCALARS, MeasureInputs, Observables, Workspace
from autobalancer.kernels.records import MEETING
from autobalancer.kernels.system import Floats, Matrix, Rows
from autobalancer.machine import Machine, PlanarRotor

MOST = 200_000  # impacts that are kept


def gauges_of(
    assembly: Assembly, places: Places, jumps: Sequence[float] = (), touches: Sequence[Touch] = (), *, centered: bool
) -> MeasureInputs:
    """The numbers of an assembled machine; ``centered`` says that nothing can deflect its rotor for good."""
    basis, model, balls = places.basis, places.model, assembly.balls
    meetings, rebounds = meetings_of(touches)
    scalars = np.zeros(SCALARS)
    scalars[:] = (
        centered,
        assembly.resolved,
        min(assembly.critical_speeds, default=math.nan),
        _held(places.machine, places, bool(balls)),
        isinstance(places.machine.rotor, PlanarRotor),
    )
    return MeasureInputs(
        scalars=scalars,
        rows=_flat(places.rows),
        speeds=np.array(places.speeds, np.float64),
        stiffness=_turned(places.run_stiffness),
        damping=_turned(places.run_damping),
        weight=np.array(places.weight, np.float64).ravel(),
        rubber=_flat(places.rubber_rows),
        hard=_flat(places.hard_rows),
        ball_mass=np.array([ball.effective_mass for ball in balls], np.float64),
        ball_moment=np.array([ball.moment for ball in balls], np.float64),
        ball_centers=np.array([[b.eccentricity.real, b.eccentricity.imag] for b in balls], np.float64).reshape(-1, 2),
        ball_planes=np.array(places.plane_of_ball, np.int64),
        capability=np.array(places.capability, np.float64),
        mass=np.ascontiguousarray(basis.T @ model.mass @ basis, np.float64),
        gyroscopic=np.ascontiguousarray(basis.T @ model.gyroscopic @ basis, np.float64),
        model_speeds=np.array(model.speeds, np.float64),
        model_damping=np.array([basis.T @ damping @ basis for damping in model.damping], np.float64),
        model_stiffness=np.array([basis.T @ stiffness @ basis for stiffness in model.stiffness], np.float64),
        held_stiffness=_turned(places.stiffness),
        held_damping=_turned(places.damping),
        held_loads=np.stack([places.centers.real, places.centers.imag]),
        jumps=np.array(jumps, np.float64),
        meetings=meetings,
        rebounds=rebounds,
    )


def desk_for(gauges: MeasureInputs, states: int, bins: int = 0, hits: int = 0) -> Workspace:
    """Room for runs of machines with arrays of the same size: states of places, bins of an envelope, impacts."""
    size, balls, planes = gauges.rows.shape[0], gauges.ball_mass.size, gauges.capability.size
    places, supports = gauges.rows.shape[1] // 2, gauges.weight.size // 2
    most, columns = max(places, supports, 1), 1 + 2 * (1 + balls)

    def complexes(*shape: int) -> Any:
        return np.zeros(shape, np.complex128)

    def seen(count: int) -> Any:
        return complexes(states, count)

    return Workspace(
        Observables(
            seen(places), seen(places), seen(supports), seen(planes), seen(planes), seen(1), seen(1),
            np.zeros((states, balls)),
        ),
        np.zeros(size), np.zeros(size), np.zeros(2 * most), np.zeros(states),
        np.zeros(bins), np.zeros(bins), np.zeros(bins), np.zeros(bins), np.zeros((bins, balls)), np.zeros((bins, balls)),
        np.zeros((4, balls)),
        np.zeros((5, most)),
        complexes(max(states, columns, planes), columns + most + planes + 1),
        complexes(max(size, columns, planes), max(size + planes + 1, columns + most, planes + 2)),
        complexes(most),
        np.zeros((4, hits)),
        np.zeros(1, np.int64),
        np.zeros(OF_IMPACTS),
    )  # fmt: skip


def meetings_of(touches: Sequence[Touch]) -> tuple[Rows, Floats]:
    """What an impact means in each contact, and the laws of restitution of those where that depends on the speed."""
    rows, laws = MEETING.rows(len(touches)), Tables(law_numbers)
    for row, touch in zip(rows, touches, strict=True):
        row.mass, row.restitution, row.least = touch.mass, touch.restitution, touch.least
        row.law = laws.first(touch.rebound, touch.restitution, touch.slowest)
    return rows, laws.numbers


def _held(machine: Machine, places: Places, balls: bool) -> int:
    if not balls or machine.excitations or has_hardening(machine):
        return UNKNOWN
    return ITERATED if places.rubber_rows.size else LINEAR


def _flat(rows: Matrix) -> Matrix:
    """Rows of pairs (L, 2, R) coordinate by coordinate, (R, 2 L)."""
    return np.ascontiguousarray(rows.reshape(2 * rows.shape[0], rows.shape[2]).T, np.float64)


def _turned(rows: Matrix) -> Matrix:
    """The same of rows for each speed, (k, S, 2, R) to (k, R, 2 S)."""
    return np.ascontiguousarray(
        rows.reshape(rows.shape[0], 2 * rows.shape[1], rows.shape[3]).swapaxes(1, 2), np.float64
    )

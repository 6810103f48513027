"""What shakes the machine, as rows of kernels/records/drive.py."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.fluids import FluidRows, UniformTable, uniform_table
from autobalancer.assembly.rotors import rows_at
from autobalancer.assembly.spatial import Parts
from autobalancer.kernels.records.drive import RECORDED, SHAKE
from autobalancer.kernels.system import Floats, Matrix, Rows
from autobalancer.machine import BaseMotion, HarmonicForce, Machine, RecordedBaseMotion, RecordedForce


def excitations(machine: Machine, parts: Parts, width: int, tables: FluidRows) -> tuple[Rows, Matrix]:
    """The rows of a machine's excitations, and accelerations of its coordinates per unit of each, along x and y."""
    rows, vectors = SHAKE.rows(len(machine.excitations)), np.zeros((2 * len(machine.excitations), width))
    inverse = np.linalg.inv(parts.mass)
    for number, (row, shake) in enumerate(zip(rows, machine.excitations, strict=True)):
        direction = np.array([math.cos(float(shake.direction)), math.sin(float(shake.direction))])
        if isinstance(shake, (BaseMotion, RecordedBaseMotion)):
            row.felt, moved = 1, _base(parts)
        else:
            place = rows_at(machine, parts.model, shake.station, "excitations", number, "station")
            moved = (parts.model.both(place.deflection[None]) @ parts.reduction.basis).T
        vectors[2 * number : 2 * number + 2, : parts.size] = (inverse @ moved).T
        if isinstance(shake, (BaseMotion, HarmonicForce)):
            vector = _size(shake) * np.exp(1j * float(shake.phase)) * direction
            row.x_real, row.x_imaginary, row.y_real, row.y_imaginary = vector.view(np.float64)
            row.frequency = float(shake.frequency if shake.frequency is not None else shake.order or 0.0)
            row.by_angle = int(shake.frequency is None)
            continue
        assert isinstance(shake, (RecordedBaseMotion, RecordedForce))
        row.kind = RECORDED
        values = shake.acceleration if isinstance(shake, RecordedBaseMotion) else shake.force
        table = uniform_table(*_with_silence(np.array(shake.time, np.float64), np.array(values, np.float64)))
        row.table_x, row.table_y = (tables.add_table(_times(table, float(share))) for share in direction)
    return rows, vectors


def _base(parts: Parts) -> Matrix:
    """Forces on the coordinates per acceleration of the base along x and y, seen from there."""
    n = parts.model.pairs
    moved = np.zeros((parts.model.size, 2))
    moved[:n, 0] = moved[n:, 1] = parts.model.translation
    return np.asarray(-parts.reduction.basis.T @ parts.model.mass @ moved)


def _size(shake: BaseMotion | HarmonicForce) -> float:
    """Amplitude of force or acceleration."""
    if isinstance(shake, HarmonicForce):
        return float(shake.force)
    if shake.acceleration is not None:
        return float(shake.acceleration)
    return -float(shake.displacement or 0.0) * float(shake.frequency or 0.0) ** 2


def _times(table: UniformTable, share: float) -> UniformTable:
    return UniformTable(table.start, table.step, share * table.values, share * table.slopes)


def _with_silence(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The record with zeros one step before and after it, since a table keeps its last value."""
    step = float(np.diff(times).min())
    if values[-1] != 0.0:
        times, values = np.append(times, times[-1] + step), np.append(values, 0.0)
    if values[0] != 0.0 and times[0] > step:
        times, values = np.insert(times, 0, times[0] - step), np.insert(values, 0, 0.0)
    return times, values

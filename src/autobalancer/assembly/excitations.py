"""What shakes the machine, as the rows of kernels/race_layout.py."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.fluid_numbers import table_numbers
from autobalancer.assembly.rotors import rows_at
from autobalancer.assembly.spatial import Parts
from autobalancer.kernels import race_layout as at
from autobalancer.kernels.rotor_layout import WIDTH
from autobalancer.kernels.system import Floats
from autobalancer.machine import BaseMotion, HarmonicForce, Machine, RecordedBaseMotion, RecordedForce


def add_excitations(machine: Machine, parts: Parts, numbers: list[float]) -> int:
    """Append what shakes the machine to the numbers of its rotor; returns where it begins, 0 if nothing does."""
    if not machine.excitations:
        return 0
    width = int(numbers[WIDTH])
    inverse = np.linalg.inv(parts.mass)
    n = parts.model.pairs
    basis = parts.reduction.basis
    moved = np.zeros((parts.model.size, 2))
    for name, part in (("x", slice(0, n)), ("y", slice(n, 2 * n))):
        shape = parts.model.translation
        moved[part, 0 if name == "x" else 1] = shape
    base = -inverse @ basis.T @ parts.model.mass @ moved
    blocks, tables = [], []
    for number, shake in enumerate(machine.excitations):
        block = np.zeros(at.SHAKE_VECTORS + 2 * width)
        direction = np.array([math.cos(float(shake.direction)), math.sin(float(shake.direction))])
        if isinstance(shake, (BaseMotion, RecordedBaseMotion)):
            vectors = base
            block[at.FELT] = 1.0
        else:
            rows = rows_at(machine, parts.model, shake.station, "excitations", number, "station")
            vectors = inverse @ (parts.model.both(rows.deflection[None]) @ basis).T
        block[at.SHAKE_VECTORS : at.SHAKE_VECTORS + parts.size] = vectors[:, 0]
        block[at.SHAKE_VECTORS + width : at.SHAKE_VECTORS + width + parts.size] = vectors[:, 1]
        if isinstance(shake, (BaseMotion, HarmonicForce)):
            if isinstance(shake, HarmonicForce):
                size = float(shake.force)
            elif shake.acceleration is not None:
                size = float(shake.acceleration)
            else:
                size = -float(shake.displacement or 0.0) * float(shake.frequency or 0.0) ** 2
            vector = size * direction[:, None] * np.array([math.cos(float(shake.phase)), math.sin(float(shake.phase))])
            block[at.AMP_XR : at.AMP_YI + 1] = vector.ravel()
            block[at.SHAKE_FREQUENCY] = float(shake.frequency if shake.frequency is not None else shake.order or 0.0)
            block[at.BY_ANGLE] = float(shake.frequency is None)
            blocks.append(block)
            continue
        assert isinstance(shake, (RecordedBaseMotion, RecordedForce))
        block[at.SHAKE_KIND] = at.RECORDED
        values = shake.acceleration if isinstance(shake, RecordedBaseMotion) else shake.force
        times, record = _with_silence(np.array(shake.time, np.float64), np.array(values, np.float64))
        for column, share in ((at.TABLE_X, direction[0]), (at.TABLE_Y, direction[1])):
            tables.append((len(blocks), column, table_numbers(times, share * record)))
        blocks.append(block)
    for which, column, table in tables:
        blocks[which][column] = len(numbers)
        numbers += table
    begin = len(numbers)
    numbers += [float(len(blocks)), *np.concatenate(blocks).tolist()]
    return begin


def _with_silence(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The record with zeros one step before and after it, since a table keeps its last value."""
    step = float(np.diff(times).min())
    if values[-1] != 0.0:
        times, values = np.append(times, times[-1] + step), np.append(values, 0.0)
    if values[0] != 0.0 and times[0] > step:
        times, values = np.insert(times, 0, times[0] - step), np.insert(values, 0, 0.0)
    return times, values

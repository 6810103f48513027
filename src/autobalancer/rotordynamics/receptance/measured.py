"""Measured receptances from files: deflection over force at the race, whatever was measured and in which unit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.samples import sample_hint
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.units import optional_argument

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
POWERS = {"receptance": 0, "mobility": 1, "accelerance": 2}  # of i w, to divide by


def load_receptance(
    path: str | Path, *, function: int | None = None, mass_added: float | str | None = None
) -> xr.Dataset:
    """Read a measured frequency response, force to deflection, velocity or acceleration along the same direction.

    Parameters
    ----------
    path
        A table (``.csv``, ``.txt``, ...) with a line of column names, each with its unit in brackets, such as
        ``frequency [Hz], real [m/s^2/N], imag [m/s^2/N]``; ``amplitude [...]`` and ``phase [deg]`` can be used instead,
        and ``coherence`` is used if present. Or a universal file with datasets of type 58 in ASCII.
    function
        Which frequency response of a universal file, counted from 1; by default the only one at a driving point.
    mass_added
        Mass (kg) that was fixed to the rotor at the race in the test and is no part of it, such as that of the accelerometer and
        of balls; what is read is the rotor without it.

    Returns
    -------
    xarray.Dataset
        ``receptance_real`` and ``receptance_imag`` (m/N, convention e^(+i w t)) over ``frequency`` (rad/s, ascending,
        above zero), and ``coherence`` if the file has one.

    Raises
    ------
    ResultError
        If the file cannot be read; the message says where and what is expected.
    QuestionError
        If the added mass is negative.
    """
    from autobalancer.rotordynamics.receptance.table_file import read_table
    from autobalancer.rotordynamics.receptance.universal_file import read_universal

    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as reason:
        raise ResultError(f"{path}: cannot be read: {reason.strerror}{sample_hint(path)}") from None
    lines = text.splitlines()
    if any(line.strip() == "-1" for line in lines[:5]):
        found = read_universal(lines, path.name, function)
    else:
        found = read_table(lines, path.name)
    mass = optional_argument("mass_added", mass_added, "kg")
    return found if mass is None else _without(found, mass)


def _without(measured: xr.Dataset, mass: float) -> xr.Dataset:
    """The same without a mass at the place: 1/H0 = 1/H + m w^2."""
    if not mass >= 0.0:
        raise QuestionError(f"mass_added: given {mass:g} kg; must not be negative")
    values = measured["receptance_real"].values + 1j * measured["receptance_imag"].values
    values = values / (1.0 + mass * measured["frequency"].values ** 2 * values)
    found = measured.copy()
    for name, part in (("receptance_real", values.real), ("receptance_imag", values.imag)):
        found[name] = measured[name].copy(data=part)
    return found.assign_attrs(mass_added=mass)


def receptance_dataset(
    frequency: Floats, values: Complexes, kind: str, *, title: str, coherence: Floats | None = None
) -> xr.Dataset:
    """Label values of kind *receptance*, *mobility* or *accelerance* (SI, over rad/s); a line at zero is left out.

    Raises
    ------
    ResultError
        If there are values that are no numbers, or a frequency comes twice.
    """
    frequency, values = np.asarray(frequency, np.float64), np.asarray(values, np.complex128)
    order = np.argsort(frequency, kind="stable")
    order = order[frequency[order] > 0.0]
    frequency, values = frequency[order], values[order]
    if not np.isfinite(values).all() or not np.isfinite(frequency).all():
        raise ResultError(f"{title}: a value is not a finite number")
    if (np.diff(frequency) == 0.0).any():
        raise ResultError(f"{title}: a frequency comes twice; give one value for each")
    if not (np.abs(values) > 0.0).all():
        raise ResultError(f"{title}: a value is exactly zero, which cannot be a measurement; delete that line")
    values = values / (1j * frequency) ** POWERS[kind]
    found = xr.Dataset(
        {
            "receptance_real": ("frequency", values.real, {"long_name": "receptance, real part", "units": "m/N"}),
            "receptance_imag": ("frequency", values.imag, {"long_name": "receptance, imaginary part", "units": "m/N"}),
        },
        {"frequency": ("frequency", frequency, {"long_name": "frequency", "units": "rad/s"})},
        {**provenance(), "title": title, "measured": kind},
    )
    if coherence is not None:
        found["coherence"] = ("frequency", np.asarray(coherence)[order], {"long_name": "coherence", "units": ""})
    return Labeled.of(found)


def hertz(frequency: float) -> str:
    """A frequency in rad/s as messages give it, without the unit: Hz."""
    return f"{frequency / (2.0 * math.pi):.4g}"

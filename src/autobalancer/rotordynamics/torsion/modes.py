"""Torsional natural frequencies and shapes, and the speeds at which something in the drive excites them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.optimize import bisect

from autobalancer.assembly.terms import Theory
from autobalancer.assembly.torsion.model import Torsion, damping_at, shakes_of, torsion_of
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.rotordynamics.question import attributes
from autobalancer.rotordynamics.torsion.answers import TorsionalCriticalSpeeds, TorsionalModes
from autobalancer.rotordynamics.torsion.eigenproblem import free_torsion, shape_name, undamped_torsion
from autobalancer.units import argument

SEARCHED = 401  # speeds between which damped frequencies are met once
MET = 1e-4  # relative
USUAL = (1.0, 2.0)  # where nothing in the machine excites its torsion


def torsional_modes(machine: Machine | str | Path, speed: float | str = 0.0) -> TorsionalModes:
    """Natural frequencies and shapes of the drive train with its rotor.

    Where the speed of the motor is prescribed it is held; else all turns freely, and turning as a whole is no mode. Balls run
    freely in their races and are left out; the rotor does not twist in itself.

    Parameters
    ----------
    machine
        A machine or the path of a machine file, with ``couplings`` or a ``mount`` in its drive.
    speed
        Rotor speed, rad/s; it counts where the torque of the motor depends on the speed.

    Returns
    -------
    xarray.Dataset
        Over ``mode``, by frequency: ``name``, ``frequency`` (damped, rad/s), ``undamped_frequency``, ``damping_ratio``,
        ``decay_rate`` (1/s). Over ``mode`` and ``part``: ``angle_real``, ``angle_imag``, the greatest angle being 1.
        ``inertia`` (kg m^2) over ``part``.

    Raises
    ------
    QuestionError
        For a speed that is negative or not finite.
    MachineError
        If nothing in the drive turns elastically.
    """
    speed = argument("speed", speed, "rad/s")
    if not (math.isfinite(speed) and speed >= 0.0):
        raise QuestionError(f"torsional_modes: speed: given {speed:g} rad/s; must be finite and not negative")
    machine = balls_in_races(machine)
    model = torsion_of(machine)
    found = free_torsion(model, damping_at(machine, model, speed))
    values = found.eigenvalue
    result = xr.Dataset(
        coords={
            "mode": ("mode", np.arange(1, values.size + 1), {"long_name": "mode, counted from 1"}),
            "part": ("part", np.array(model.names, dtype=object), {"long_name": "what turns"}),
            "inertia": ("part", model.inertia, {"long_name": "inertia", "units": "kg m^2"}),
        }
    )
    names = np.array([shape_name(model.names, shape) for shape in found.shape], dtype=object)
    both = ("mode", "part")
    for key, dims, numbers, text, unit in (
        ("name", "mode", names, "name of the mode", ""),
        ("frequency", "mode", values.imag, "natural frequency, damped", "rad/s"),
        ("undamped_frequency", "mode", found.undamped, "natural frequency without damping", "rad/s"),
        ("damping_ratio", "mode", -values.real / np.abs(values), "damping ratio", ""),
        ("decay_rate", "mode", -values.real, "decay rate", "1/s"),
        ("angle_real", both, found.shape.real, "real part of the angle", ""),
        ("angle_imag", both, found.shape.imag, "imaginary part of the angle", ""),
    ):
        result[key] = (dims, numbers, {"long_name": text, "units": unit})
    result.attrs = attributes(
        machine, f"Torsional natural frequencies of {machine.name}", balls=False, theory=Theory.TORSION
    ) | {"speed": speed}
    return TorsionalModes.of(result)


def torsional_critical_speeds(
    machine: Machine | str | Path, *, harmonics: Sequence[float] | None = None
) -> TorsionalCriticalSpeeds:
    """Speeds at which h times the speed is a torsional natural frequency without damping.

    Parameters
    ----------
    machine
        As for ``ab.rotor.torsional_modes``.
    harmonics
        h; by default what the machine has: 1 where the weight of an unbalance loads the drive once per turn, the orders of
        errors of alignment and of ripples; 1 and 2 where it has none of these.

    Returns
    -------
    xarray.Dataset
        Over ``critical``, ascending: ``critical_speed`` (rad/s), ``harmonic``, ``name`` of the mode, ``excited_by``, empty where
        the machine has nothing of this order. Over ``crossing`` the same with damping, as ``crossing_speed``,
        ``crossing_harmonic``, ``crossing_name`` and ``crossing_damping_ratio``: h times the speed is the damped frequency of a
        mode at this speed. A motor whose torque changes strongly with its speed ties parts together that swing apart without it.

    Raises
    ------
    QuestionError
        If a harmonic is not above zero.
    MachineError
        If nothing in the drive turns elastically.
    """
    machine = balls_in_races(machine)
    model = torsion_of(machine)
    causes: dict[float, list[str]] = {}
    for shake in shakes_of(machine, model):
        causes.setdefault(shake.order, []).append(shake.what)
    lines = sorted(causes) or list(USUAL) if harmonics is None else [float(h) for h in harmonics]
    if not lines or not all(math.isfinite(h) and h > 0.0 for h in lines):
        raise QuestionError(
            f"torsional_critical_speeds: harmonics: given {harmonics!r}; give at least one, greater than zero"
        )
    rates, shapes = undamped_torsion(model)
    found = sorted((rate / h, h, i) for h in lines for i, rate in enumerate(rates))
    result = xr.Dataset()
    for key, numbers, text, unit in (
        ("critical_speed", np.array([w for w, _, _ in found], np.float64), "critical speed of torsion", "rad/s"),
        ("harmonic", np.array([h for _, h, _ in found], np.float64), "frequency over speed", ""),
        ("name", _texts(shape_name(model.names, shapes[i]) for _, _, i in found), "name of the mode", ""),
        (
            "excited_by",
            _texts(", ".join(causes.get(h, ())) for _, h, _ in found),
            "what excites it in this machine",
            "",
        ),
    ):
        result[key] = ("critical", numbers, {"long_name": text, "units": unit})
    damped = _crossings(machine, model, lines, max((w for w, _, _ in found), default=0.0))
    for key, place, text, unit in (
        ("crossing_speed", 0, "speed at which a damped frequency is met", "rad/s"),
        ("crossing_harmonic", 1, "frequency over speed", ""),
        ("crossing_damping_ratio", 3, "damping ratio of the mode there", ""),
    ):
        result[key] = (
            "crossing",
            np.array([row[place] for row in damped], np.float64),
            {"long_name": text, "units": unit},
        )
    result["crossing_name"] = ("crossing", _texts(row[2] for row in damped), {"long_name": "name of the mode"})
    result.attrs = attributes(
        machine, f"Torsional critical speeds of {machine.name}", balls=False, theory=Theory.TORSION
    )
    return TorsionalCriticalSpeeds.of(result)


def _crossings(
    machine: Machine, model: Torsion, lines: Sequence[float], highest: float
) -> list[tuple[float, float, str, float]]:
    """Where so many times the speed is the damped frequency of a mode at this speed: speed, h, name and damping ratio."""

    def above(speed: float, h: float) -> int:
        return int((free_torsion(model, damping_at(machine, model, speed)).eigenvalue.imag > h * speed).sum())

    top = max(highest, *(float(w) for w in free_torsion(model, damping_at(machine, model, 0.0)).eigenvalue.imag), 1.0)
    found = []
    for h in lines:
        grid = np.linspace(0.0, 1.1 * top / min(h, 1.0), SEARCHED)
        counts = [above(speed, h) for speed in grid.tolist()]
        for low, high, one, other in zip(grid, grid[1:], counts, counts[1:], strict=False):
            if one == other:
                continue
            speed = bisect(lambda w, h=h, one=one: 1.0 if above(w, h) == one else -1.0, low, high, rtol=1e-9)
            modes = free_torsion(model, damping_at(machine, model, speed))
            met = int(np.argmin(np.abs(modes.eigenvalue.imag - h * speed)))
            value = modes.eigenvalue[met]
            if abs(value.imag - h * speed) < MET * value.imag:  # else a mode stops to oscillate there
                found.append((speed, h, shape_name(model.names, modes.shape[met]), float(-value.real / abs(value))))
    return sorted(found)


def _texts(texts: object) -> np.ndarray:
    return np.array(list(texts), dtype=object)  # type: ignore[call-overload]

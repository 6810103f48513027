"""Natural frequencies and mode shapes of a rotor at one speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
import xarray as xr
from scipy.optimize import linear_sum_assignment

from autobalancer.assembly.rotors import LateralModel
from autobalancer.assembly.rotors.model import Floats
from autobalancer.assembly.rotors.softened import Softened
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.answers import Modes
from autobalancer.rotordynamics.eigenproblem import FreeMotions, correlation, decay_rates, free_motions
from autobalancer.rotordynamics.question import along_axis, attributes, checked_speeds, chosen_places, rotor_of
from autobalancer.rotordynamics.rubber import ModeMotion, at_amplitude, rubber_of
from autobalancer.rotordynamics.shapes import ellipses_of, mode_names
from autobalancer.rotordynamics.whirl import Whirl, whole_direction
from autobalancer.units import argument


def modes(
    machine: Machine | str | Path,
    speed: float | str = 0.0,
    *,
    balls: bool = True,
    modes: int = 10,
    stations: Sequence[str | float] | None = None,
    rubber_amplitude: float | str | None = None,
    motion: ModeMotion = "line",
) -> Modes:
    """Damped and undamped natural frequencies of the rotor with mode shapes and whirl directions.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speed
        Rotor speed, rad/s, for the gyroscopic terms and for tables of stiffness and damping.
    balls
        Whether the effective masses of the balls are added to the rotor in the planes of their balancers.
    modes
        Number of modes, the lowest ones.
    stations
        Names or positions (m) for the whirl directions; by default all stations.
    rubber_amplitude
        Greatest deflection (m) of the rubber that softens with the amplitude, in each mode; by default small motions, in which
        it is stiffest.
    motion
        Of this rubber: ``line`` after a blow, ``circle`` in whirl, ``ellipse`` that of each mode itself, which is a circle where
        the machine is alike along x and y.

    Returns
    -------
    xarray.Dataset
        Over ``mode``, counted from 1 by frequency: ``name``, ``frequency`` (damped, rad/s), ``undamped_frequency``
        (without damping, of the mode with the most similar shape), ``damping_ratio``, ``decay_rate`` (1/s, negative where
        the motion grows), ``whirl`` (forward, backward, mixed along the axis, or straight). Over ``mode`` and ``place``
        along the axis: the amplitudes ``x_real``, ``x_imag``, ``y_real``, ``y_imag``, the greatest deflection of a mode
        being 1; over ``mode`` and ``station`` the same with the prefix ``station_`` and ``station_whirl``.
        ``attrs["decay_rates_without_frequency"]`` (1/s) are those of motions that do not oscillate.

    Raises
    ------
    QuestionError
        For a negative speed, no modes, an unknown station, a motion that is none, or rubber that is not known in it.
    MachineError
        If the rotor is not possible as described.
    """
    speed = argument("speed", speed, "rad/s")
    machine, model = rotor_of(machine, balls=balls)
    omega = float(checked_speeds(speed, model, "modes")[0])
    check_count(modes, "modes")
    at, axis = chosen_places(machine, model, stations, "modes"), along_axis(machine, model)
    every = free_motions(model, omega)
    found = every.lowest(modes)
    if rubber_amplitude is not None:
        rubber_amplitude = float(argument("rubber_amplitude", rubber_amplitude, "m"))
        soft = _soft(machine, model, rubber_amplitude, motion)
        found = at_amplitude(soft, omega, found, rubber_amplitude, motion)
    ellipses, station_ellipses = (ellipses_of(model, found.vector, places) for places in (axis, at))
    words = [whole_direction(_row(ellipses, i)) for i in range(found.count)]
    values = found.eigenvalue
    decay = decay_rates(values)
    result = xr.Dataset(
        coords={
            "mode": ("mode", np.arange(1, found.count + 1), {"long_name": "mode, counted from 1"}),
            "place": ("place", axis.positions, {"long_name": "position along the axis", "units": "m"}),
            "station": ("station", np.array(at.names, dtype=object), {"long_name": "station"}),
            "position": ("station", at.positions, {"long_name": "position along the axis", "units": "m"}),
        }
    )
    data: dict[str, tuple[Any, Any, str, str]] = {
        "name": ("mode", np.array(mode_names(model, found.vector, axis), dtype=object), "name of the mode", ""),
        "frequency": ("mode", values.imag, "natural frequency, damped", "rad/s"),
        "undamped_frequency": (
            "mode",
            _undamped(model, omega, found) if rubber_amplitude is None else np.abs(values),
            "natural frequency without damping",
            "rad/s",
        ),
        "damping_ratio": ("mode", decay / np.abs(values), "damping ratio", ""),
        "decay_rate": ("mode", decay, "decay rate", "1/s"),
        "whirl": ("mode", np.array(words, dtype=object), "direction of whirl", ""),
        "station_whirl": (("mode", "station"), station_ellipses.direction, "direction of whirl at the station", ""),
    }
    size = ellipses.semi_major.max(axis=1, keepdims=True)
    size = np.where(size > 0.0, size, 1.0)
    for prefix, dim, part in (("", "place", ellipses), ("station_", "station", station_ellipses)):
        x, y = part.forward + part.backward.conj(), (part.forward - part.backward.conj()) / 1j
        for letter, values_at in (("x", x / size), ("y", y / size)):
            for kind, numbers in (("real", values_at.real), ("imag", values_at.imag)):
                text = f"{'real' if kind == 'real' else 'imaginary'} part of the amplitude along {letter}"
                data[f"{prefix}{letter}_{kind}"] = (("mode", dim), numbers, text, "")
    for key, (dims, numbers, text, unit) in data.items():
        result[key] = (dims, numbers, {"long_name": text, "units": unit})
    result.attrs = attributes(machine, f"Natural frequencies of {machine.name}", balls=balls) | {
        "speed": omega,
        "rubber_amplitude": math.nan if rubber_amplitude is None else rubber_amplitude,
        "decay_rates_without_frequency": (-every.real).tolist(),
        "x_and_y": "alike" if model.isotropic else "different",
    }
    return Modes.of(result)


def _soft(machine: Machine, model: LateralModel, size: float, motion: ModeMotion) -> Softened:
    """The rubber of a machine that is asked for modes at an amplitude."""
    if not (math.isfinite(size) and size >= 0.0):
        raise QuestionError(f"modes: rubber_amplitude: given {size:g} m; must be finite and not negative")
    if motion not in get_args(ModeMotion):
        raise QuestionError(f"modes: motion: given {motion!r}; must be line, circle or ellipse")
    soft = rubber_of(machine, model)
    if soft is None:
        raise QuestionError(
            "modes: rubber_amplitude: this machine has no rubber that softens with the amplitude; leave it out"
        )
    return soft


def check_count(count: int, owner: str) -> None:
    """A number of modes is a whole number from 1."""
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise QuestionError(f"{owner}: modes: given {count!r}; must be a whole number from 1")


def _row(ellipses: Whirl, number: int) -> Whirl:
    return Whirl(ellipses.forward[number], ellipses.backward[number])


def _undamped(model: LateralModel, speed: float, found: FreeMotions) -> Floats:
    """Frequency without damping of the mode with the most alike shape."""
    plain = free_motions(model, speed, damped=False)
    frequencies = np.full(found.count, math.nan)
    rows, columns = linear_sum_assignment(-correlation(found.vector, plain.vector, model.mass))
    frequencies[rows] = plain.eigenvalue.imag[columns]
    return frequencies

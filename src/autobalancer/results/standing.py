"""What of a motion in space stands still: its mean over whole turns of everything that whirls."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.machine import Machine
from autobalancer.results.series import plain

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

WEIGHT, RECORD, NONE = "weight", "recorded excitation", "none"


def static_load(machine: Machine) -> str:
    """What can deflect a rotor for good: ``"weight"``, ``"recorded excitation"`` or ``"none"``.

    Without such a load no direction in space is preferred, on any supports: with every motion its opposite is possible, too.
    """
    if machine.axis == "horizontal":
        return WEIGHT
    recorded = any(part.kind in ("recorded_force", "recorded_base_motion") for part in machine.excitations)
    return RECORD if recorded else NONE


def standing(z: Complexes, rotor: Floats, balls: Floats, load: str) -> Complexes:
    """The part of x + i y that stands still, (columns,); zero without a static ``load``.

    Parameters
    ----------
    z
        (times, columns), at equal steps of the rotor angle over whole turns.
    rotor
        Angle of the rotor, rad, (times,).
    balls
        Angles of the balls in space, rad, (times, balls). Where some of them go round both in space and in the rotor, the
        revolutions of the rotor are not those of the deflection. Then the standing part is fitted together with what whirls
        with the rotor, with the balls, and against them. Weights that vanish at both ends (Hann's) suppress the rest.
    """
    found = np.zeros(z.shape[1], np.complex128)
    if load == NONE:
        return found
    from autobalancer.kernels.measures import motion

    count, columns = z.shape[0], 1 + 2 * (1 + balls.shape[1])
    work = np.zeros((max(count, columns), columns + z.shape[1] + 1), np.complex128)
    small = np.zeros((columns, columns + z.shape[1]), np.complex128)
    motion.standing(complexes(z), count, plain(rotor), plain(balls), 0, work, small, found)
    return found


def complexes(values: Any) -> Complexes:
    """x + i y as compiled functions take it."""
    return np.require(values, np.complex128, ["C", "W"])


def calm_mean(values: Complexes | Floats) -> Complexes:
    """Mean over the first axis with weights that vanish at both ends (Hann's), so that parts of turns hardly count.

    What goes round n times adds about 1/n^3 of its size, to the plain mean 1/n.
    """
    steps = len(values)
    weight = np.sin(np.pi * (np.arange(steps) + 0.5) / steps) ** 2
    return np.asarray(np.tensordot(weight / weight.sum(), values, axes=1), np.complex128)


def standing_in(run: xr.Dataset, z: Complexes, prefix: str = "turn_") -> Complexes:
    """The same for the last revolutions of a run, or with ``prefix`` "" for its samples; ``z`` is (times, columns)."""
    rotor = run[f"{prefix}rotor_angle"].values
    name = f"{prefix}ball_angle_in_rotor"
    inside = run[name].values if name in run else np.zeros((rotor.size, 0))
    return standing(z, rotor, rotor[:, None] + inside, load_of(run.attrs))


def load_of(attributes: dict[Any, Any]) -> str:
    """The static load of a run; runs of earlier versions say only how the axis lies."""
    known = WEIGHT if attributes.get("axis", "vertical") == "horizontal" else NONE
    return str(attributes.get("static_load", known))

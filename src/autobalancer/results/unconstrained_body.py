"""How a body that is held in planar motion would move if it were released: Pakuła (2021), section 4.3."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.linalg import expm

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.results.answers.answer import Labeled
from autobalancer.units import optional_argument


@dataclass(frozen=True)
class LooseBody:
    """The body of equation (52): three oscillators that do not touch each other.

    Attributes
    ----------
    mass
        M (kg).
    inertia_y, inertia_z
        J_y, J_z (kg m²).
    stiffness, damping
        k_x (N/m) and b_x (N s/m) of a support; two of them hold the body along x.
    height, depth, half_width
        h, B, L (m).
    """

    mass: float
    inertia_y: float
    inertia_z: float
    stiffness: float
    damping: float
    height: float
    depth: float
    half_width: float

    def oscillators(self) -> dict[str, tuple[float, float, float]]:
        """Inertia, damping and stiffness of x, of the rotation about y and of that about z.

        The print has 4h + 4B and 4L + 2B, which are lengths, where N m/rad needs their squares: 4h² + 4B², 4L² + 2B².
        """
        about_y = 4.0 * self.height**2 + 4.0 * self.depth**2
        about_z = 4.0 * self.half_width**2 + 2.0 * self.depth**2
        return {
            "x": (self.mass, 2.0 * self.damping, 2.0 * self.stiffness),
            "rotation_y": (self.inertia_y, about_y * self.damping, about_y * self.stiffness),
            "rotation_z": (self.inertia_z, about_z * self.damping, about_z * self.stiffness),
        }


def pakula_body(height: float) -> LooseBody:
    """The body of the source; only its ``height`` h (m) is not printed."""
    return LooseBody(120.0, 25.0, 20.0, 32500.0, 41.0, height, depth=0.2, half_width=1.0)


def unconstrained_motion(run: xr.Dataset, body: LooseBody, until: float | str | None = None) -> xr.Dataset:
    """Motion of a body released from rest under the reactions that held it. It has no effect on the balls.

    A sample holds the mean of a reaction since the sample before; it acts over that time, so that every impact keeps its impulse
    however short it is. The oscillators are solved exactly for that.

    Parameters
    ----------
    run
        Samples with ``constraint_force`` and ``constraint_moment``.
    body
        Masses, springs and lengths.
    until
        Reactions after this time (s) are set to zero. The source leaves out those of the steady state, where they are
        caused by a friction law without sticking acting on balls at rest.

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``x`` (m), ``rotation_y`` and ``rotation_z`` (rad), and the ``_load`` on each (N, N m).

    Raises
    ------
    QuestionError
        If a mass, spring or length is not positive, or the samples are not at equal times.
    """
    until = optional_argument("until", until, "s")
    for name, value in vars(body).items():
        if not (np.isfinite(value) and (value > 0.0 or (name in ("damping", "height") and value == 0.0))):
            raise QuestionError(f"{name}: given {value:g}; must be greater than zero")
    time = run["time"].values
    steps = np.diff(time)
    if steps.size == 0 or np.ptp(steps) > 1e-6 * steps.max():
        raise QuestionError("the samples of the run are not at equal times")
    loads = {
        "x": run["constraint_force"].isel(axis=0).values,
        "rotation_y": run["constraint_moment"].isel(axis=1).values,
        "rotation_z": run["constraint_moment"].isel(axis=2).values,
    }
    dataset = xr.Dataset(coords={"time": run["time"]})
    for name, (inertia, damping, stiffness) in body.oscillators().items():
        load = np.array(loads[name], float)
        if until is not None:
            load[time > until] = 0.0
        motion = _oscillator(load, float(steps.mean()), inertia, damping, stiffness)
        unit, force = ("m", "N") if name == "x" else ("rad", "N m")
        spoken = name.replace("_", " about ")
        dataset[name] = ("time", motion, {"units": unit, "long_name": f"{spoken} of the body if released"})
        dataset[f"{name}_load"] = ("time", load, {"units": force, "long_name": f"reaction against {spoken}"})
    return Labeled.of_run(run, "Motion of the released body", dataset)


def _oscillator(load: Floats, step: float, inertia: float, damping: float, stiffness: float) -> Floats:
    """Exact for a load that is constant over each step: it is part of the state."""
    rate = np.zeros((3, 3))
    rate[0, 1] = 1.0
    rate[1] = [-stiffness / inertia, -damping / inertia, 1.0 / inertia]
    flow = expm(rate * step)[:2]
    place = speed = 0.0
    motion = np.zeros_like(load)
    for i in range(1, load.size):
        place, speed = (float(value) for value in flow @ np.array([place, speed, load[i]]))
        motion[i] = place
    return motion

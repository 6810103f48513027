"""The steady response of a drive train to what shakes it so many times per turn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.assembly.terms import Theory
from autobalancer.assembly.torsion.model import Complexes, Floats, Shake, Torsion, damping_at, shakes_of, torsion_of
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.rotordynamics.question import attributes
from autobalancer.rotordynamics.torsion.answers import TorsionalResponse
from autobalancer.units import list_argument


def torsional_response(
    machine: Machine | str | Path, speeds: Sequence[float | str] | Floats | str
) -> TorsionalResponse:
    """Twist and torque over the speed, by the weight of the unbalance, bad alignment and ripples of the torque.

    Small motions about each steady speed, without a load on the rotor. Deflections of the rotor do not react on the torsion
    here; in a run they do.

    Parameters
    ----------
    machine
        A machine or the path of a machine file, with ``couplings`` or a ``mount`` in its drive, and at least one of: an
        unbalance on a horizontal axis with gravity, an ``error`` of a coupling, ``ripples``.
    speeds
        Rotor speeds above zero, rad/s.

    Returns
    -------
    xarray.Dataset
        Over ``speed``, ``harmonic`` (frequency over speed) and ``link``: ``twist`` (rad; of the stator its angle),
        ``twist_phase`` (rad, ahead of the rotor angle times the harmonic), ``link_torque`` (N m). Over ``speed``,
        ``harmonic`` and ``part``: ``angle`` (rad), what is added to steady turning. ``excited_by`` over ``harmonic``.

    Raises
    ------
    QuestionError
        If a speed is not above zero, or nothing shakes the drive train.
    MachineError
        If nothing in the drive turns elastically.
    """
    omega = np.atleast_1d(np.asarray(list_argument("speeds", speeds, "rad/s"), np.float64))
    if omega.ndim != 1 or omega.size == 0 or not np.all(np.isfinite(omega) & (omega > 0.0)):
        raise QuestionError("torsional_response: speeds: give at least one; all must be finite and greater than zero")
    machine = balls_in_races(machine)
    model = torsion_of(machine)
    shakes = list(shakes_of(machine, model))
    if not shakes:
        raise QuestionError(
            "torsional_response: nothing shakes this drive train; give a coupling an 'error', the drive 'ripples', or the "
            "rotor an unbalance on a horizontal axis"
        )
    orders = sorted({shake.order for shake in shakes})
    by_order = {h: [shake for shake in shakes if shake.order == h] for h in orders}
    angle = np.zeros((omega.size, len(orders), model.inertia.size), np.complex128)
    twist = np.zeros((omega.size, len(orders), len(model.links)), np.complex128)
    torque = np.zeros_like(twist)
    for i, w in enumerate(omega):
        damping = damping_at(machine, model, float(w))
        for j, h in enumerate(orders):
            angle[i, j], twist[i, j], torque[i, j] = _at(model, damping, by_order[h], h * float(w))
    return _dataset(machine, model, omega, by_order, (angle, twist, torque))


def _at(model: Torsion, damping: Floats, shakes: list[Shake], rate: float) -> tuple[Complexes, Complexes, Complexes]:
    """Angles, twists and torques at a frequency, rad/s."""
    dynamic = model.stiffness + 1j * rate * damping - rate**2 * np.diag(model.inertia)
    own = model.own[:, 0] + 1j * rate * model.own[:, 1]
    load, error = np.zeros(model.inertia.size, np.complex128), np.zeros(own.size, np.complex128)
    for shake in shakes:
        if shake.link >= 0:
            error[shake.link] += shake.amplitude
            load += shake.row * own[shake.link] * shake.amplitude
        else:
            load += shake.row * shake.amplitude
    angle = np.asarray(np.linalg.solve(dynamic, load), np.complex128)
    twist = np.asarray(model.twist @ angle, np.complex128)
    return angle, twist, own * (twist - error)


def _dataset(
    machine: Machine,
    model: Torsion,
    speeds: Floats,
    by_order: dict[float, list[Shake]],
    found: tuple[Complexes, Complexes, Complexes],
) -> TorsionalResponse:
    angle, twist, torque = found
    causes = [", ".join(shake.what for shake in shakes) for shakes in by_order.values()]
    result = xr.Dataset(
        coords={
            "speed": ("speed", speeds, {"long_name": "rotor speed", "units": "rad/s"}),
            "harmonic": ("harmonic", np.array(list(by_order)), {"long_name": "frequency over speed"}),
            "excited_by": ("harmonic", np.array(causes, dtype=object), {"long_name": "what excites it"}),
            "link": ("link", np.array(model.links, dtype=object), {"long_name": "what is behind the link"}),
            "part": ("part", np.array(model.names, dtype=object), {"long_name": "what turns"}),
        }
    )
    links, parts = ("speed", "harmonic", "link"), ("speed", "harmonic", "part")
    for key, dims, numbers, text, unit in (
        ("twist", links, np.abs(twist), "amplitude of the twist", "rad"),
        ("twist_phase", links, np.angle(twist), "phase of the twist", "rad"),
        ("link_torque", links, np.abs(torque), "amplitude of the torque", "N m"),
        ("angle", parts, np.abs(angle), "amplitude of the angle beside steady turning", "rad"),
    ):
        result[key] = (dims, numbers, {"long_name": text, "units": unit})
    result.attrs = attributes(machine, f"Torsional response of {machine.name}", balls=False, theory=Theory.TORSION)
    return TorsionalResponse.of(result)

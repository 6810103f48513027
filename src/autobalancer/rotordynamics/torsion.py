"""How a drive train twists freely, at which speeds it is in resonance, and how it responds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eig, eigh
from scipy.optimize import bisect, linear_sum_assignment

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.drive_train import Torsion, damping_at, shakes_of, torsion_of
from autobalancer.assembly.terms import Theory
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer
from autobalancer.results.labels import labeled
from autobalancer.rotordynamics.natural_modes import attributes
from autobalancer.units import argument, list_argument

# Torsional natural frequencies and shapes, and the speeds at which something in the drive excites them.


SEARCHED = 401  # speeds between which damped frequencies are met once
MET = 1e-4  # relative
USUAL = (1.0, 2.0)  # where nothing in the machine excites its torsion


def torsional_modes(machine: Machine | str | Path, speed: float | str = 0.0) -> Answer:
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
    names = np.array([shape_name(model.names, shape) for shape in found.shape], dtype=object)
    both = ("mode", "part")
    result = labeled(
        {
            "name": ("mode", names, "name of the mode", ""),
            "frequency": ("mode", values.imag, "natural frequency, damped", "rad/s"),
            "undamped_frequency": ("mode", found.undamped, "natural frequency without damping", "rad/s"),
            "damping_ratio": ("mode", -values.real / np.abs(values), "damping ratio", ""),
            "decay_rate": ("mode", -values.real, "decay rate", "1/s"),
            "angle_real": (both, found.shape.real, "real part of the angle", ""),
            "angle_imag": (both, found.shape.imag, "imaginary part of the angle", ""),
        },
        {
            "mode": ("mode", np.arange(1, values.size + 1), "mode, counted from 1"),
            "part": ("part", np.array(model.names, dtype=object), "what turns"),
            "inertia": ("part", model.inertia, "inertia", "kg m^2"),
        },
        _attributes(machine, "Torsional natural frequencies") | {"speed": speed},
    )
    return Answer.of(result, "TorsionalModes")


def torsional_critical_speeds(machine: Machine | str | Path, *, harmonics: Sequence[float] | None = None) -> Answer:
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
    # which harmonics of the speed excite the train
    causes: dict[float, list[str]] = {}
    for shake in shakes_of(machine, model):
        causes.setdefault(shake.order, []).append(shake.what)
    lines = sorted(causes) or list(USUAL) if harmonics is None else [float(h) for h in harmonics]
    if not lines or not all(math.isfinite(h) and h > 0.0 for h in lines):
        raise QuestionError(
            f"torsional_critical_speeds: harmonics: given {harmonics!r}; give at least one, greater than zero"
        )
    # undamped: each natural frequency over each harmonic
    rates, shapes = undamped_torsion(model)
    answer = sorted((rate / h, h, i) for h in lines for i, rate in enumerate(rates))
    # damped: where a line of harmonics meets a damped frequency
    damped = _crossings(machine, model, lines, max((w for w, _, _ in answer), default=0.0))

    def texts(entries: Iterable[str]) -> np.ndarray:
        return np.array(list(entries), dtype=object)

    def numbers(rows: Sequence[tuple[Any, ...]], place: int) -> Floats:
        return np.array([row[place] for row in rows], np.float64)

    at, met = "critical", "crossing"
    result = labeled(
        {
            "critical_speed": (at, numbers(answer, 0), "critical speed of torsion", "rad/s"),
            "harmonic": (at, numbers(answer, 1), "frequency over speed", ""),
            "name": (at, texts(shape_name(model.names, shapes[i]) for _, _, i in answer), "name of the mode", ""),
            "excited_by": (
                at,
                texts(", ".join(causes.get(h, ())) for _, h, _ in answer),
                "what excites it in this machine",
                "",
            ),
            "crossing_speed": (met, numbers(damped, 0), "speed at which a damped frequency is met", "rad/s"),
            "crossing_harmonic": (met, numbers(damped, 1), "frequency over speed", ""),
            "crossing_damping_ratio": (met, numbers(damped, 3), "damping ratio of the mode there", ""),
            "crossing_name": (met, texts(row[2] for row in damped), "name of the mode"),
        },
        None,
        _attributes(machine, "Torsional critical speeds"),
    )
    return Answer.of(result, "TorsionalCriticalSpeeds")


def _crossings(
    machine: Machine, model: Torsion, lines: Sequence[float], highest: float
) -> list[tuple[float, float, str, float]]:
    """Where so many times the speed is the damped frequency of a mode at this speed: speed, h, name and damping ratio."""

    def above(speed: float, h: float) -> int:
        return int((free_torsion(model, damping_at(machine, model, speed)).eigenvalue.imag > h * speed).sum())

    top = max(highest, *(float(w) for w in free_torsion(model, damping_at(machine, model, 0.0)).eigenvalue.imag), 1.0)
    crossings = []
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
                crossings.append((speed, h, shape_name(model.names, modes.shape[met]), float(-value.real / abs(value))))
    return sorted(crossings)


def _attributes(machine: Machine, what: str) -> dict[str, Any]:
    return attributes(machine, f"{what} of {machine.name}", balls=False, theory=Theory.TORSION)


# Free torsional motions of a drive train.


OSCILLATES = 0.995  # damping ratio above which nothing swings
RIGID_SHARE = 1e-6  # of the highest frequency; below it the train turns as a whole
SHARED = 0.05  # least share of the greatest angle for which a part is named


class FreeTorsion(NamedTuple):
    """Modes by ascending frequency: eigenvalues, undamped frequencies of the most alike shapes, shapes (modes, parts)."""

    eigenvalue: Complexes
    undamped: Floats
    shape: Complexes  # the greatest angle is 1


def free_torsion(model: Torsion, damping: Floats) -> FreeTorsion:
    """All motions that oscillate; turning as a whole is none."""
    n, j = model.inertia.size, model.inertia[:, None]
    block = np.zeros((2 * n, 2 * n))
    block[:n, n:] = np.eye(n)
    block[n:] = np.hstack([-model.stiffness / j, -damping / j])
    values, vectors = eig(block)
    squares, plain = eigh(model.stiffness, np.diag(model.inertia))
    undamped = np.sqrt(np.maximum(squares, 0.0))
    rate = np.abs(values)
    keep = (values.imag > RIGID_SHARE * undamped[-1]) & (-values.real < OSCILLATES * rate)
    values, shapes = values[keep], vectors[:n, keep].T
    order = np.argsort(values.imag)
    values, shapes = values[order], shapes[order]
    likeness = np.abs((shapes.conj() * model.inertia) @ plain)
    likeness /= np.sqrt(np.sum(np.abs(shapes) ** 2 * model.inertia, axis=1))[:, None]
    rows, columns = linear_sum_assignment(-likeness)
    matched = np.full(values.size, np.nan)
    matched[rows] = undamped[columns]
    greatest = np.argmax(np.abs(shapes), axis=1)
    shapes = shapes / shapes[np.arange(values.size), greatest][:, None]
    return FreeTorsion(values, matched, shapes)


def undamped_torsion(model: Torsion) -> tuple[Floats, Floats]:
    """Frequencies without damping, rad/s ascending, and shapes (modes, parts); turning as a whole is left out."""
    squares, shapes = eigh(model.stiffness, np.diag(model.inertia))
    rate = np.sqrt(np.maximum(squares, 0.0))
    keep = rate > RIGID_SHARE * rate[-1]
    return rate[keep], shapes.T[keep]


def shape_name(names: tuple[str, ...], shape: Complexes | Floats) -> str:
    """The part that turns most, and against which other one."""
    most = int(np.argmax(np.abs(shape)))
    angles = (shape / shape[most]).real
    other = int(np.argmin(angles))
    return f"{names[most]} against {names[other]}" if angles[other] < -SHARED else names[most]


# The steady response of a drive train to what shakes it so many times per turn.


def torsional_response(machine: Machine | str | Path, speeds: Sequence[float | str] | Floats | str) -> Answer:
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
    # angles, twists and torques at each frequency
    for i, w in enumerate(omega):
        damping = damping_at(machine, model, float(w))
        for j, h in enumerate(orders):
            rate = h * float(w)
            dynamic = model.stiffness + 1j * rate * damping - rate**2 * np.diag(model.inertia)
            own = model.own[:, 0] + 1j * rate * model.own[:, 1]
            load, error = np.zeros(model.inertia.size, np.complex128), np.zeros(own.size, np.complex128)
            for shake in by_order[h]:
                if shake.link >= 0:
                    error[shake.link] += shake.amplitude
                    load += shake.row * own[shake.link] * shake.amplitude
                else:
                    load += shake.row * shake.amplitude
            angle[i, j] = np.linalg.solve(dynamic, load)
            twist[i, j] = model.twist @ angle[i, j]
            torque[i, j] = own * (twist[i, j] - error)
    causes = [", ".join(shake.what for shake in own) for own in by_order.values()]
    links, parts = ("speed", "harmonic", "link"), ("speed", "harmonic", "part")
    result = labeled(
        {
            "twist": (links, np.abs(twist), "amplitude of the twist", "rad"),
            "twist_phase": (links, np.angle(twist), "phase of the twist", "rad"),
            "link_torque": (links, np.abs(torque), "amplitude of the torque", "N m"),
            "angle": (parts, np.abs(angle), "amplitude of the angle beside steady turning", "rad"),
        },
        {
            "speed": ("speed", omega, "rotor speed", "rad/s"),
            "harmonic": ("harmonic", np.array(orders), "frequency over speed"),
            "excited_by": ("harmonic", np.array(causes, dtype=object), "what excites it"),
            "link": ("link", np.array(model.links, dtype=object), "what is behind the link"),
            "part": ("part", np.array(model.names, dtype=object), "what turns"),
        },
        _attributes(machine, "Torsional response"),
    )
    return Answer.of(result, "TorsionalResponse")

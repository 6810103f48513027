"""What unbalance does at the planes and places of a machine at a steady speed."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.gauges import desk_for
from autobalancer.assembly.places import Places, table_shares
from autobalancer.assembly.profile import unbalance_factor
from autobalancer.assembly.rotors import lateral_model, unbalance_shape
from autobalancer.assembly.rotors.ellipses.steady import steadily
from autobalancer.assembly.rotors.model import Complexes, Floats
from autobalancer.assembly.rotors.softened import softened
from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.gauges import Gauges


def plane_unbalances(assembly: Assembly, gauges: Gauges, time: float, speed: float) -> Complexes:
    """The unbalance that the balls of each plane have to balance so that all planes rest, kg m in the rotor, (P,).

    It is what the unbalances do at the planes at this speed, put into these planes; on a planar rotor their sum. nan at
    a critical speed of an undamped rotor.
    """
    from autobalancer.kernels.measures import response

    found = np.zeros(gauges.capability.size, np.complex128)
    response.plane_unbalances(assembly.system, gauges, time, speed, desk_for(gauges, 0), found)
    return found


def off_center_unbalances(places: Places, speed: float) -> Complexes:
    """Residual unbalance of each plane for each meter by which the race of a plane is off the axis, kg, (P, P).

    Balls that rest in the rotor hold the centers of their races at rest, so the axis of the rotor is as far off the axis of
    rotation as the race is off the axis: of a planar rotor the residual is (M - (k + i b w)/w^2) E in the rotor. nan where
    the races cannot all be at rest, as in more than two planes of a rigid rotor, or without speed.
    """
    count = len(places.planes)
    if not speed:
        return np.full((count, count), np.nan + 0j)
    circles = (
        places.rows[:count, 0] - 1j * places.rows[:count, 1]
    ).T  # force of a unit vector that turns with the rotor
    dynamic = _dynamic_stiffness(places, np.array([float(speed)]))[0]
    try:
        moved = 0.5 * circles.conj().T @ np.linalg.solve(dynamic, circles)
        scale = np.abs(moved).max(initial=0.0)
        if np.linalg.matrix_rank(moved, tol=1e-9 * scale) < count:
            raise np.linalg.LinAlgError
        return np.asarray(-np.linalg.inv(moved) / speed**2, np.complex128)
    except np.linalg.LinAlgError:
        return np.full((count, count), np.nan + 0j)


def without_balancing(
    assembly: Assembly, places: Places, gauges: Gauges, time: float, speed: float
) -> tuple[Floats, Floats]:
    """Greatest vibration of each place, (L,) m, and greatest vibrating force on each support, (S,) N, without balancing.

    The balls are spread evenly over their races and held; the speed is steady, and nothing shakes the machine from outside.
    nan at a critical speed of an undamped rotor, and on softening rubber whose steady motion is not known.
    """
    if places.rubber_rows.size:
        return _on_rubber(places, time, speed)
    from autobalancer.kernels.measures import response

    vibration, force = np.zeros(len(places.names)), np.zeros(len(places.supports))
    response.with_balls_held(assembly.system, gauges, time, speed, desk_for(gauges, 0), vibration, force)
    return vibration, force


def _on_rubber(places: Places, time: float, speed: float) -> tuple[Floats, Floats]:
    """The same on rubber that is as soft as its own deflection makes it."""
    machine, bare = places.machine, lateral_model(places.machine)
    soft = softened(machine, bare, places.model)
    assert soft is not None
    load = sum(
        (
            unbalance_factor(part, float(time)) * unbalance_shape(machine, bare, number)
            for number, part in enumerate(machine.unbalances)
        ),
        places.center_loads,
    )
    try:
        found = steadily(soft, np.array([float(speed)]), load, "vibration without balls")
    except QuestionError:
        return np.full(len(places.names), np.nan), np.full(len(places.supports), np.nan)
    moved = np.linalg.lstsq(places.basis, found.motion[0], rcond=None)[0]
    force = places.rubber_rows @ found.pushes[0].ravel()
    for i, share in enumerate(table_shares(places.speeds, np.array([float(speed)]))):
        force = force + share * (places.run_stiffness[i] + 1j * speed * places.run_damping[i]) @ moved
    return _semi_major(np.asarray(places.rows @ moved, np.complex128)), _semi_major(force)


def _semi_major(pairs: Complexes) -> Floats:
    """Greatest length of Re((x, y) e^(i theta)), of complex (..., 2)."""
    x, y = pairs[..., 0], pairs[..., 1]
    return np.asarray(0.5 * (np.abs(x + 1j * y) + np.abs(x - 1j * y)), np.float64)


def _dynamic_stiffness(places: Places, speed: Floats) -> Complexes:
    """K + i w (C + w G) - w^2 M over the coordinates, with the balls on the rotor, (T, R, R)."""
    model, basis = places.model, places.basis
    w = speed[:, None, None]
    total = 1j * w**2 * (basis.T @ model.gyroscopic @ basis) - w**2 * (basis.T @ model.mass @ basis)
    for i, share in enumerate(table_shares(model.speeds, speed)):
        small = basis.T @ model.stiffness[i] @ basis + 1j * w * (basis.T @ model.damping[i] @ basis)
        total = total + share[:, None, None] * small
    return np.asarray(total, np.complex128)

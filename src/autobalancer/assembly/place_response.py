"""What unbalance does at the planes and places of a machine at a steady speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.measure_inputs import desk_for
from autobalancer.assembly.places import Places, table_shares
from autobalancer.assembly.profile import unbalance_factor
from autobalancer.assembly.rotors import lateral_model, unbalance_shape
from autobalancer.assembly.rotors.ellipses import steadily
from autobalancer.assembly.rotors.equivalent_stiffness import softened
from autobalancer.assembly.rotors.lateral_model import Complexes, Floats
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve import Ball
from autobalancer.catalog.small_tables import RING, TURNED, TURNED_ECCENTRICITY, ring_eccentricity
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.workspace import MeasureInputs
from autobalancer.results.number_text import length_text, moment_text


def plane_unbalances(assembly: Assembly, gauges: MeasureInputs, time: float, speed: float) -> Complexes:
    """The unbalance that the balls of each plane have to balance so that all planes rest, kg m in the rotor, (P,).

    It is what the unbalances do at the planes at this speed, put into these planes; on a planar rotor their sum. nan at
    a critical speed of an undamped rotor.
    """
    from autobalancer.kernels.measures import observables

    plane_unbalances = np.zeros(gauges.capability.size, np.complex128)
    observables.plane_unbalances(assembly.system, gauges, time, speed, desk_for(gauges, 0), plane_unbalances)
    return plane_unbalances


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
    assembly: Assembly, places: Places, gauges: MeasureInputs, time: float, speed: float
) -> tuple[Floats, Floats]:
    """Greatest vibration of each place, (L,) m, and greatest vibrating force on each support, (S,) N, without balancing.

    The balls are spread evenly over their races and held; the speed is steady, and nothing shakes the machine from outside.
    nan at a critical speed of an undamped rotor, and on softening rubber whose steady motion is not known.
    """
    if places.rubber_rows.size:
        return _on_rubber(places, time, speed)
    from autobalancer.kernels.measures import observables

    vibration, force = np.zeros(len(places.names)), np.zeros(len(places.supports))
    observables.with_balls_held(assembly.system, gauges, time, speed, desk_for(gauges, 0), vibration, force)
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
        result = steadily(soft, np.array([float(speed)]), load, "vibration without balls")
    except QuestionError:
        return np.full(len(places.names), np.nan), np.full(len(places.supports), np.nan)
    moved = np.linalg.lstsq(places.basis, result.motion[0], rcond=None)[0]
    force = places.rubber_rows @ result.pushes[0].ravel()
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


# What a race off the axis leaves, however well its balls balance: they bring the center of the race to rest, not the
# axis.
#
# Spannan (2021), section 4.2.4: on isotropic supports the axis then whirls at the eccentricity. Where the machine has
# none, a typical one is taken.


@dataclass(frozen=True)
class OffCenterPlane:
    """A plane of balancers: eccentricity of its races (the greatest, or a typical one) and vibration of the axis, m.

    ``residual`` (kg m) is the unbalance that stays in this plane while all races are at rest: of given eccentricities
    what they leave, of typical ones the most, over their directions; nan where the races cannot all be at rest. ``source``
    says where a typical eccentricity comes from.
    """

    name: str
    given: bool
    eccentricity: float
    residual: float
    source: str = ""


@dataclass(frozen=True)
class OffCenter:
    """The planes of a machine at a steady speed (rad/s)."""

    speed: float
    planes: tuple[OffCenterPlane, ...]

    @property
    def greatest(self) -> float:
        """The greatest eccentricity, m."""
        return max((plane.eccentricity for plane in self.planes), default=0.0)

    @property
    def given(self) -> bool:
        """Whether the machine gives the eccentricity of some race in each plane."""
        return all(plane.given for plane in self.planes)

    @property
    def sentence(self) -> str:
        """All that in words; empty for races that are said to be centered."""
        planes = [plane for plane in self.planes if plane.eccentricity > 0.0]
        if not planes:
            return ""
        unknown = not all(plane.given for plane in planes)
        several = len(self.planes) > 1
        parts = [
            f"{length_text(plane.eccentricity)}{f' at {plane.name}' if several else ''} "
            f"{'leaves' if plane.given else 'would leave'} a vibration of {length_text(plane.eccentricity)}"
            + (
                f" and {'up to ' * (several and unknown)}{moment_text(plane.residual)} of unbalance"
                if np.isfinite(plane.residual)
                else ""
            )
            for plane in planes
        ]
        sources = " or ".join(dict.fromkeys(plane.source for plane in planes if not plane.given))
        begin = f"not given{' everywhere' * any(p.given for p in planes)}; typical is {sources}: " if unknown else ""
        return begin + "; ".join(parts) + ", however well the balls balance"


def off_center(places: Places, balls: tuple[Ball, ...], speed: float) -> OffCenter | None:
    """The eccentricities of a machine and what they leave at a speed (rad/s); None without balls."""
    if not balls:
        return None
    given, greatest, fixed, sources = zip(
        *(_plane([ball for ball, p in zip(balls, places.plane_of_ball, strict=True) if p == i], places)
          for i in range(len(places.planes))),
        strict=True,
    )  # fmt: skip
    effect = off_center_unbalances(places, speed)
    known = np.array(given, bool)
    left = np.abs(effect[:, known] @ np.array(fixed)[known]) + np.abs(effect[:, ~known]) @ np.array(greatest)[~known]
    return OffCenter(
        float(speed),
        tuple(
            OffCenterPlane(name, bool(one), float(offset), float(residual), source)
            for name, one, offset, residual, source in zip(places.planes, given, greatest, left, sources, strict=True)
        ),
    )


def _plane(balls: list[Ball], places: Places) -> tuple[bool, float, complex, str]:
    """Whether an eccentricity is given, the greatest one or a typical one, the given one with its direction, m, and a source."""
    races = [places.machine.balancers[ball.balancer].races[ball.race] for ball in balls]
    if any("eccentricity" in race.model_fields_set for race in races):
        offset = max((ball.eccentricity for ball in balls), key=abs)
        return True, abs(offset), offset, ""
    if any(race.bearing is None for race in races):
        return False, TURNED_ECCENTRICITY, 0j, TURNED
    size = max((2.0 * ball.orbit_radius + ball.diameter for ball in balls), default=0.0)
    return False, ring_eccentricity(size), 0j, RING

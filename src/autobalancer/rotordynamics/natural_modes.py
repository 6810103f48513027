"""Free motions q = Re(Q e^(lambda t)) of a rotor at one speed.

An isotropic rotor is solved for z = q_x + i q_y, where each motion is a forward or a backward circle even where both
have one frequency, as at standstill. The states are scaled by the undamped frequencies at rest, so that stiff shafts
lose no digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import eig, eigh
from scipy.optimize import linear_sum_assignment

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.rotors import lateral_model, reference, rows_at, with_ball_mass
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows
from autobalancer.assembly.rotors.rigid import NodalAxis, Point
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import provenance

CREEPING = 0.1  # of |lambda|: with less frequency, damping ratios above 0.995, a motion creeps back and does not swing


@dataclass(frozen=True)
class FreeMotions:
    """Oscillating motions by ascending frequency; ``real`` are the real parts of those that do not oscillate."""

    eigenvalue: Complexes  # (modes,), imaginary part > 0
    vector: Complexes  # (modes, N), of unit kinetic norm Q^H M Q
    real: Floats

    @property
    def count(self) -> int:
        """Number of oscillating motions."""
        return int(self.eigenvalue.size)

    def lowest(self, count: int) -> FreeMotions:
        """The first ``count`` of them."""
        return FreeMotions(self.eigenvalue[:count], self.vector[:count], self.real)


def free_motions(model: LateralModel, speed: float, *, damped: bool = True) -> FreeMotions:
    """All free motions at a rotor speed, rad/s; ``damped=False`` leaves out C."""
    n = model.pairs
    if model.isotropic:
        mass, turning, stiffness = model.complex_matrices(speed)
        if not damped:
            damping = model.damping_at(speed)
            turning = turning - (damping[:n, :n] + 1j * damping[n : 2 * n, :n])
        values, shapes = _solved(mass, turning, stiffness)
        full = np.zeros((values.size, model.size), np.complex128)
        backward = values.imag < 0.0
        values = np.where(backward, values.conj(), values)
        shapes = np.where(backward[:, None], shapes.conj(), shapes)
        full[:, :n], full[:, n : 2 * n] = shapes, np.where(backward, 1j, -1j)[:, None] * shapes
        rest = slice(2 * n, None)
        others = _real_part(model, speed, rest, damped)
        later = np.concatenate([~backward, np.zeros(others[0].size, np.bool_)])  # of two circles of one frequency
        values, full = np.concatenate([values, others[0]]), np.concatenate([full, others[1]])
    else:
        values, full = _real_part(model, speed, slice(None), damped)
        later = np.zeros(values.size, np.bool_)
    # motions that swing, by frequency, of unit kinetic norm and with their greatest entry real
    swings = np.abs(values.imag) > CREEPING * np.abs(values)
    order = np.flatnonzero(swings)
    order = order[np.argsort((values.imag * (1.0 + 1e-9 * later))[order], kind="stable")]
    chosen = full[order]
    norm = np.sqrt(np.einsum("ij,jk,ik->i", chosen.conj(), model.mass, chosen).real)
    chosen = chosen / np.where(norm > 0.0, norm, 1.0)[:, None]
    largest = np.take_along_axis(chosen, np.argmax(np.abs(chosen), axis=1)[:, None], 1)
    return FreeMotions(values[order], chosen * np.exp(-1j * np.angle(largest)), np.sort(values.real[~swings])[::-1])


def correlation(one: Complexes, other: Complexes, mass: Floats) -> Floats:
    """Modal assurance criterion weighted with M, (modes, modes), of vectors of unit kinetic norm."""
    return np.asarray(np.abs(one.conj() @ mass @ other.T) ** 2)


def _real_part(model: LateralModel, speed: float, block: slice, damped: bool) -> tuple[Complexes, Complexes]:
    """Eigenvalues with imaginary part >= 0 of a block of coordinates that no other touches."""
    mass, stiffness = model.mass[block, block], model.stiffness_at(speed)[block, block]
    turning = speed * model.gyroscopic[block, block] + damped * model.damping_at(speed)[block, block]
    if mass.size == 0:
        return np.empty(0, np.complex128), np.empty((0, model.size), np.complex128)
    values, shapes = _solved(mass, turning, stiffness)
    keep = values.imag >= 0.0
    full = np.zeros((int(keep.sum()), model.size), np.complex128)
    full[:, block] = shapes[keep]
    return values[keep], full


def _solved(mass: Any, turning: Any, stiffness: Any) -> tuple[Complexes, Complexes]:
    """(lambda^2 M + lambda D + K) q = 0: all 2 n eigenvalues and vectors as rows."""
    hermitian = 0.5 * (stiffness + stiffness.conj().T)
    squares, basis = eigh(hermitian, mass)
    scale = np.sqrt(np.maximum(squares, 1e-16 * np.abs(squares).max(initial=0.0)))
    scale = np.where(scale > 0.0, scale, 1.0)
    n = scale.size
    adjoint = basis.conj().T
    spring = adjoint @ (stiffness - hermitian) @ basis + np.diag(squares)
    matrix = np.zeros((2 * n, 2 * n), np.result_type(turning, spring))
    matrix[:n, n:] = np.diag(scale)
    matrix[n:, :n] = -spring / scale
    matrix[n:, n:] = -adjoint @ turning @ basis
    values, vectors = eig(matrix)
    return values.astype(np.complex128), np.asarray((basis @ (vectors[:n] / scale[:, None])).T, np.complex128)


def decay_rates(values: Complexes) -> Floats:
    """Decay of motions with these eigenvalues, 1/s; zero where it is rounding, some 1e-16 of the greatest eigenvalue."""
    greatest = np.abs(values).max(initial=0.0, where=np.isfinite(values))
    return np.where(np.abs(values.real) > 1e-13 * greatest, -values.real, 0.0)


# Modes followed over the speed by the likeness of their shapes, so that branches may cross.


ALIKE, ANY_LIKENESS = 0.9, 0.05
DEEPEST = 6  # halvings of a step in which shapes change fast


@dataclass(frozen=True)
class Branches:
    """Eigenvalues (branches, S) and vectors (branches, S, N); nan where a branch has no oscillating motion."""

    eigenvalue: Complexes
    vector: Complexes


@dataclass(frozen=True)
class _Front:
    """Where the branches are: speed, eigenvalues and vectors, the last known ones where a branch has ended."""

    speed: float
    value: Complexes
    vector: Complexes


def tracked(motions: Callable[[float], FreeMotions], speeds: Floats, mass: Floats, count: int) -> Branches:
    """Follow the ``count`` lowest modes of the first speed.

    Parameters
    ----------
    motions
        Free motions at a speed, rad/s.
    speeds
        Ascending, rad/s.
    mass
        M, the weight of the likeness.
    count
        Branches at most.
    """
    first = motions(float(speeds[0])).lowest(count)
    front = _Front(float(speeds[0]), first.eigenvalue, first.vector)
    values, vectors = [front.value], [front.vector]
    for speed in speeds[1:]:
        front = _advanced(motions, front, float(speed), mass, DEEPEST)
        values.append(front.value)
        vectors.append(np.where(np.isnan(front.value)[:, None], np.nan, front.vector))
    return Branches(np.array(values).T, np.array(vectors).swapaxes(0, 1))


def _advanced(
    motions: Callable[[float], FreeMotions], front: _Front, speed: float, mass: Floats, halvings: int
) -> _Front:
    result = motions(speed)
    likeness = correlation(front.vector, result.vector, mass)
    rows, columns = linear_sum_assignment(-likeness)
    lost = likeness[rows, columns] < ANY_LIKENESS
    clear = likeness[rows, columns][~np.isnan(front.value[rows])].min(initial=1.0) >= ALIKE
    if not clear and halvings:
        middle = _advanced(motions, front, 0.5 * (front.speed + speed), mass, halvings - 1)
        return _advanced(motions, middle, speed, mass, halvings - 1)
    rows, columns = rows[~lost], columns[~lost]
    value, vector = np.full(front.value.size, np.nan + 0j), front.vector.copy()
    value[rows], vector[rows] = result.eigenvalue[columns], result.vector[columns]
    return _Front(speed, value, vector)


# Names of modes, by looking at their shapes along the axis.


BENT = (
    0.1  # part of the mean square deflection that a straight line misses, 0.19 for half a wave; above it the axis bends
)
ONE_PLANE = 0.6  # share of the kinetic energy along x or y above which a mode belongs to this direction


def mode_names(model: LateralModel, vectors: Complexes, axis: Places) -> list[str]:
    """Such as ``cylindrical y``, ``conical forward``, ``bending 1 backward``, ``axial, z of frame``.

    ``vectors`` (modes, N) by ascending frequency, of unit kinetic norm. Cylindrical and conical modes leave the axis
    nearly straight: without and with a node. Bending modes of one direction are counted.
    """
    names: list[str] = []
    counted: dict[str, int] = {}
    n = model.pairs
    for vector in vectors:
        energy = (vector.conj() * (model.mass @ vector)).real
        share_x, share_y, others = (float(part.sum()) for part in (energy[:n], energy[n : 2 * n], energy[2 * n :]))
        if others > 0.5:
            most = model.coordinates[2 * n + int(np.argmax(energy[2 * n :]))]
            kind = "axial" if most.startswith("z ") else "torsional" if most.startswith("turning") else ""
            names.append(f"{kind}, {most}" if kind else most)
            continue
        ellipses = ellipses_of(model, vector, axis)
        kind = _kind(ellipses, axis.positions)
        where = whole_direction(ellipses)
        if not model.isotropic:
            where = "x" if share_x > ONE_PLANE else "y" if share_y > ONE_PLANE else where
        if kind == "bending":
            counted[where] = counted.get(where, 0) + 1
            kind = f"bending {counted[where]}"
        names.append(f"{kind} {where}")
    return names


def ellipses_of(model: LateralModel, vectors: Complexes, places: Places) -> Whirl:
    """The ellipses of motions (..., N) at places: (..., places)."""
    n = model.pairs
    rows = places.deflection.T
    return whirl(vectors[..., :n] @ rows, vectors[..., n : 2 * n] @ rows)


def _kind(ellipses: Whirl, positions: Floats) -> str:
    """From the greater circle along the axis, turned into one plane as well as it goes."""
    circles = (ellipses.forward, ellipses.backward)
    line = max(circles, key=lambda circle: float((np.abs(circle) ** 2).sum()))
    plane = (line * np.exp(-0.5j * np.angle((line**2).sum()))).real
    if positions.size == 1:
        return "cylindrical"
    straight = np.polyval(np.polyfit(positions, plane, 1), positions)
    if ((plane - straight) ** 2).sum() > BENT * (plane**2).sum():
        return "bending"
    return "cylindrical" if straight[0] * straight[-1] > 0.0 else "conical"


# Elliptic whirl: forward and backward circle, semi-axes, inclination, direction.
#
# A harmonic motion x = Re(X e^(i v t)), y = Re(Y e^(i v t)) with v > 0 is the sum of two circles,
# x + i y = F e^(i v t) + B e^(-i v t) with F = (X + i Y)/2 and B = conj(X - i Y)/2: an ellipse with the semi-axes
# |F| + |B| and ||F| - |B||, inclined by (arg F + arg B)/2, passed through in the sense of the greater circle.


STRAIGHT = 1e-6  # a smaller ratio of the semi-axes is no ellipse but a line


@dataclass(frozen=True)
class Whirl:
    """Ellipses of any shape of array."""

    forward: Complexes
    backward: Complexes

    @property
    def semi_major(self) -> Floats:
        """Greatest deflection, max over time of sqrt(x^2 + y^2)."""
        return np.asarray(np.abs(self.forward) + np.abs(self.backward))

    @property
    def semi_minor(self) -> Floats:
        """Least deflection, positive where the whirl is forward, negative where it is backward."""
        return np.asarray(np.abs(self.forward) - np.abs(self.backward))

    @property
    def inclination(self) -> Floats:
        """Angle of the major axis from x, in (-pi/2, pi/2]; 0 for circles."""
        angle = 0.5 * np.angle(self.forward * self.backward)
        round_ = np.minimum(np.abs(self.forward), np.abs(self.backward)) <= 1e-12 * self.semi_major
        return np.asarray(np.where(round_, 0.0, np.where(angle <= -0.5 * np.pi, angle + np.pi, angle)))

    @property
    def sense(self) -> np.ndarray:
        """1 forward, -1 backward, 0 on a line or at rest."""
        level = self.semi_minor
        return np.asarray(np.where(np.abs(level) > STRAIGHT * self.semi_major, np.sign(level), 0.0).astype(np.int64))

    @property
    def direction(self) -> np.ndarray:
        """``forward``, ``backward`` or ``straight``, as texts."""
        return np.asarray(np.array(["backward", "straight", "forward"], dtype=object)[self.sense + 1])


def whirl(x: Complexes, y: Complexes) -> Whirl:
    """The ellipse of two complex amplitudes."""
    return Whirl(np.asarray(0.5 * (x + 1j * y)), np.asarray(0.5 * np.conj(x - 1j * y)))


def whole_direction(ellipses: Whirl) -> str:
    """One word for ellipses along a rotor: ``mixed`` where some run forward and others backward."""
    size = ellipses.semi_major
    seen = set(ellipses.sense[size > 1e-3 * size.max(initial=0.0)].tolist()) - {0}
    return "mixed" if len(seen) == 2 else {1: "forward", -1: "backward"}.get(next(iter(seen), 0), "straight")


def turning(ellipses: Whirl, angle: Floats) -> Complexes:
    """x + i y at phases ``angle`` = v t, (..., angles)."""
    turn = np.exp(1j * angle)
    return np.asarray(ellipses.forward[..., None] * turn + ellipses.backward[..., None] / turn)


def mean_of_greatest(ellipses: Whirl) -> Floats:
    """Mean over the last axis (stations) of the greatest deflections: Rodrigues et al. 2011, (3)."""
    return np.asarray(ellipses.semi_major.mean(axis=-1))


def greatest_mean(ellipses: Whirl, samples: int = 128) -> Floats:
    """Maximum over time of the mean over the last axis (stations) of the momentary deflections sqrt(x^2 + y^2)."""
    size = (np.abs(ellipses.forward) ** 2 + np.abs(ellipses.backward) ** 2)[..., None]
    product = (2.0 * ellipses.forward * np.conj(ellipses.backward))[..., None]

    def mean_radius(angle: Floats) -> Floats:
        square = size + (product * np.exp(2j * angle)).real
        return np.asarray(np.sqrt(np.maximum(square, 0.0)).mean(axis=-2))

    coarse = np.arange(samples) * np.pi / samples
    best = coarse[np.argmax(mean_radius(np.broadcast_to(coarse, (*product.shape[:-2], 1, samples))), axis=-1)]
    step = np.pi / samples
    for _ in range(4):  # zoom in on the best sample; each pass is ten times finer
        fine = best[..., None] + np.linspace(-1.0, 1.0, 21) * step
        best = np.take_along_axis(fine, np.argmax(mean_radius(fine[..., None, :]), axis=-1)[..., None], -1)[..., 0]
        step *= 0.1
    return np.asarray(mean_radius(best[..., None, None])[..., 0])


# What every question of this package starts with: the rotor, its places and the speeds, checked.


FEWEST = 21  # places along the axis, so that a shape is drawn as a shape


@dataclass(frozen=True)
class Places:
    """Places across the rotor: names, positions along the axis (m, nan where there is none) and rows."""

    names: list[str]
    positions: Floats
    deflection: Floats  # (places, pairs)


def station_coordinates(places: Places) -> dict[str, tuple[Any, ...]]:
    """The stations of a labeled result with their positions."""
    return {
        "station": ("station", np.array(places.names, dtype=object), "station"),
        "position": ("station", places.positions, "position along the axis", "m"),
    }


def rotor_of(machine: Machine | str | Path, *, balls: bool) -> tuple[Machine, LateralModel]:
    """The machine and its model, with the masses of the balls on the rotor or without balls."""
    machine = balls_in_races(machine)
    model = lateral_model(machine)
    return machine, with_ball_mass(machine, model) if balls else model


def checked_speeds(speeds: Sequence[float] | Floats | float, model: LateralModel, owner: str) -> Floats:
    """Finite speeds from zero to the end of the tables, ascending or not, (S,).

    Raises
    ------
    QuestionError
        If there is none, one is negative or not finite, or the tables of the rotor do not reach it.
    """
    array = np.atleast_1d(np.asarray(speeds, np.float64))
    if array.ndim != 1 or array.size == 0:
        raise QuestionError(f"{owner}: speeds: given none; give at least one, in rad/s")
    wrong = array[~np.isfinite(array) | (array < 0.0)]
    if wrong.size:
        raise QuestionError(
            f"{owner}: speeds: given {wrong[0]:g} rad/s; must be finite and not negative (backward whirl has its own sign)"
        )
    if array.max() > model.top_speed * (1.0 + 1e-12):
        raise QuestionError(
            f"{owner}: speeds: given up to {array.max():g} rad/s, but the tables of the rotor end at "
            f"{model.top_speed:g} rad/s; ask for less, or extend them"
        )
    return array


def chosen_places(
    machine: Machine, model: LateralModel, stations: Sequence[str | float] | str | float | None, owner: str
) -> Places:
    """The places asked for: names of stations or positions (m); ``None`` is all stations, else the reference place.

    Raises
    ------
    QuestionError
        If the list is empty, or a station is unknown.
    MachineError
        If a position is not on the rotor.
    """
    if stations is None:
        stations = [station.name for station in machine.stations]
        if not stations:
            name, rows = reference(machine, model)
            return Places([name], np.array([np.nan]), rows.deflection[None])
    wanted = [stations] if isinstance(stations, (str, int, float)) else list(stations)
    if not wanted:
        raise QuestionError(f"{owner}: stations: given none; name at least one, or leave them out for all")
    known = {station.name: float(station.position) for station in machine.stations}
    names, positions, rows_found = [], [], []
    for place in wanted:
        if isinstance(place, str) and place not in known:
            there = ", ".join(map(repr, known)) or "none"
            raise QuestionError(f"{owner}: stations: no station is named {place!r}; there is {there}")
        names.append(place if isinstance(place, str) else f"z = {float(place):g} m")
        positions.append(known[place] if isinstance(place, str) else float(place))
        rows_found.append(rows_at(machine, model, place, "stations").deflection)
    return Places(names, np.array(positions), np.array(rows_found))


def along_axis(machine: Machine, model: LateralModel) -> Places:
    """Places from end to end, planes of stations and balancers that overhang included.

    A rotor that tilts on one support is shown to a radius of gyration on both sides of it.
    """
    line = list(model.axis.line())
    low, high = min(z for z, _ in line), max(z for z, _ in line)
    if model.pairs > 1 and not isinstance(model.axis, Point):  # the modes of a rotor at one plane have no length
        if low == high:
            reach = float(np.sqrt(model.mass[1, 1] / model.mass[0, 0]))
            line += [(z, model.axis.rows(z, None)) for z in (low - reach, low + reach)]
        line += [(z, rows) for z, rows in _overhanging(machine, model) if not low <= z <= high]
    line.sort(key=lambda entry: entry[0])
    positions, deflection = np.array([z for z, _ in line]), np.array([rows.deflection for _, rows in line])
    if 1 < positions.size < FEWEST:
        finer = np.union1d(np.linspace(positions[0], positions[-1], FEWEST), positions)
        if isinstance(model.axis, NodalAxis):
            from scipy.interpolate import CubicHermiteSpline

            # few nodes of a rotor that bends: cubics by their slopes
            slopes = np.array([rows.slope for _, rows in line])
            deflection = CubicHermiteSpline(positions, deflection, slopes)(finer)
        else:
            deflection = np.array([np.interp(finer, positions, column) for column in deflection.T]).T
        positions = finer
    return Places([f"{z:g}" for z in positions], positions, deflection)


def _overhanging(machine: Machine, model: LateralModel) -> list[tuple[float, Rows]]:
    known = {station.name: station for station in machine.stations}
    overhanging: list[tuple[float, Rows]] = []
    for place in [*known, *(balancer.station for balancer in machine.balancers)]:
        if isinstance(place, str) and known[place].body is None:
            overhanging.append((float(known[place].position), rows_at(machine, model, place, "stations")))
        elif isinstance(place, float):
            overhanging.append((float(place), rows_at(machine, model, place, "balancers")))
    return overhanging


def attributes(machine: Machine, title: str, *, balls: bool, theory: Theory = Theory.ROTOR) -> dict[str, Any]:
    """What every result of this package carries."""
    return {
        "title": title,
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "balls": "their mass is on the rotor" if balls else "none",
        "ignores": ", ".join(unknown(machine, theory)),
    }

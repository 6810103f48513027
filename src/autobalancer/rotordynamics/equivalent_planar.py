"""The planar oscillator that moves like one place of a rotor: Spannan 2021, section 6.1.7."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from scipy.linalg import eig, eigh

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.rotors import balancer_rows, lateral_model, reference, rows_at, unbalance_shape
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows
from autobalancer.errors import MachineError, QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Disk, Machine, PlanarRotor, ShaftMaterial, ShaftRotor, ShaftSegment, Support, Unbalance
from autobalancer.results.answers.answer import Answer
from autobalancer.results.labels import labeled
from autobalancer.rotordynamics.natural_modes import attributes

# Rotors of ROSS (Timbó et al. 2020) as shaft rotors.
#
# ROSS is imported only to read one of its files; a rotor that is handed over is read off its attributes.


KNOWN = ("2.3.", "3.")  # how the versions begin whose attributes are read here
INSTALL = "install it with: pip install 'autobalancer[ross]'"


def from_ross(rotor: Any) -> ShaftRotor:
    """Convert a rotor of ROSS to a shaft rotor with the same nodes; axial and torsional parts are left out.

    Parameters
    ----------
    rotor
        A ``ross.Rotor``, or the path of a file that ``Rotor.save`` wrote.

    Returns
    -------
    ShaftRotor
        Nodes, element matrices and bearing coefficients are those of ROSS. Between the speeds of a table coefficients
        are interpolated linearly, and constant below the first; ROSS uses splines.

    Raises
    ------
    MachineError
        If the rotor has something that a shaft rotor cannot have: cones, layers, axial force or torque, elements without
        shear, rotary inertia or gyroscopic effect, damped elements, damping across (c_xy), stiffness across (k_xy) that
        depends on the speed, masses in bearings, supports between them and the ground. The message names it.
    QuestionError
        If ROSS is missing, cannot be imported, has an unknown version, or ``rotor`` is not one of its rotors.
    """
    if isinstance(rotor, (str, Path)):
        rotor = _ross().Rotor.load(rotor)
    kind = type(rotor)
    if kind.__name__ != "Rotor" or kind.__module__.split(".")[0] != "ross":
        raise QuestionError(f"from_ross: given {kind.__module__}.{kind.__name__}; must be a ross.Rotor, or its file")
    _check_ross_version()
    for name in ("alpha", "beta", "modal_damping_ratio", "default_damping_ratio"):  # of version 3
        if np.any(np.asarray(getattr(rotor, name, None) or 0.0, np.float64)):
            raise MachineError(f"from_ross: {name} = {getattr(rotor, name)} of the rotor cannot be read; leave it out")
    segments = [_segment(element, number) for number, element in enumerate(rotor.shaft_elements)]
    places = np.concatenate([[0.0], np.cumsum([segment.length for segment in segments])])
    disks = [_disk(element, places) for element in (*rotor.disk_elements, *rotor.point_mass_elements)]
    supports = [_support(element, places) for element in rotor.bearing_elements]
    return ShaftRotor(segments=tuple(segments), disks=tuple(disks), supports=tuple(supports))


def _ross() -> Any:
    _check_ross_version()
    try:
        return import_module("ross")
    except Exception as reason:  # what is wrong with its dependencies shows up as any kind of error
        raise QuestionError(
            f"from_ross: ROSS cannot be imported: {str(reason).strip().splitlines()[0]}; "
            f"its 2.3 needs plotly below 7; {INSTALL}"
        ) from reason


def _check_ross_version() -> None:
    try:
        result = version("ross-rotordynamics")
    except PackageNotFoundError:
        raise QuestionError(f"from_ross: ROSS is not installed; {INSTALL}") from None
    if not result.startswith(KNOWN):
        raise QuestionError(
            f"from_ross: ROSS {result} is installed, but its rotors are known from versions 2.3 and 3 only"
        )


def _refuse(element: Any, what: str) -> None:
    tag = f" {element.tag!r}" if getattr(element, "tag", None) else ""
    raise MachineError(f"from_ross: {type(element).__name__}{tag} at node {element.n}: {what}")


def _segment(element: Any, number: int) -> ShaftSegment:
    if type(element).__name__ != "ShaftElement":
        _refuse(element, "only plain shaft elements can be read")
    if element.n_l != number:
        _refuse(element, "layers of elements between the same nodes cannot be read; give one section instead")
    if element.idl != element.idr or element.odl != element.odr:
        _refuse(element, "cones cannot be read; give cylinders in steps")
    for name in ("axial_force", "torque", "alpha", "beta"):
        if getattr(element, name):
            _refuse(element, f"{name} = {getattr(element, name)} cannot be read; set it to 0")
    for name in ("shear_effects", "rotary_inertia", "gyroscopic"):
        if not getattr(element, name):
            _refuse(element, f"{name} = False cannot be read; a Timoshenko element has it")
    stuff = element.material
    return ShaftSegment(
        length=float(element.L),
        diameter=float(element.odl),
        inner_diameter=float(element.idl),
        elements=1,
        shear_coefficient=float(element.kappa),
        material=ShaftMaterial(density=float(stuff.rho), youngs_modulus=float(stuff.E), shear_modulus=float(stuff.G_s)),
    )


def _place(element: Any, places: Floats) -> float:
    if not 0 <= element.n < len(places):
        _refuse(element, f"it is at none of the nodes of the shaft, which are 0 to {len(places) - 1}")
    return float(places[element.n])


def _disk(element: Any, places: Floats) -> Disk:
    if type(element).__name__ != "DiskElement":
        _refuse(element, "only plain disks can be read; a point mass is a disk without inertias")
    return Disk(
        position=_place(element, places),
        mass=float(element.m),
        transverse_inertia=float(element.Id),
        polar_inertia=float(element.Ip),
    )


def _support(element: Any, places: Floats) -> Support:
    if getattr(element, "n_link", None) is not None:
        _refuse(element, f"it is connected to node {element.n_link}, not on the ground, which cannot be read")
    for name in ("mxx", "myy", "mxy", "myx", "cxy", "cyx"):
        if np.any(np.asarray(getattr(element, name, 0.0), np.float64)):
            _refuse(element, f"{name} is not 0, which cannot be read")
    values = {name: np.asarray(getattr(element, name), np.float64).ravel() for name in ("kxx", "kyy", "cxx", "cyy")}
    support: dict[str, Any] = {"position": _place(element, places)}
    if max(entry.size for entry in values.values()) == 1:
        single = {name: float(entry[0]) for name, entry in values.items()}
        if single["kxx"] or single["kyy"]:
            support["stiffness"] = (single["kxx"], single["kyy"])
        support["damping"] = (single["cxx"], single["cyy"])
    else:
        axis = getattr(element, "speed", None)  # of version 3, where frequency is that of the vibration
        if axis is not None and getattr(element, "frequency", None) is not None:
            _refuse(element, "a table over speed and frequency cannot be read; give one over the speed")
        speed = np.asarray(element.frequency if axis is None else axis, np.float64)
        columns = {name: np.broadcast_to(entry, speed.shape).tolist() for name, entry in values.items()}
        support["table"] = {
            "speed": speed.tolist(),
            "stiffness": list(zip(columns["kxx"], columns["kyy"], strict=True)),
            "damping": list(zip(columns["cxx"], columns["cyy"], strict=True)),
        }
    across = [np.asarray(getattr(element, name), np.float64).ravel() for name in ("kxy", "kyx")]
    for name, entry in zip(("kxy", "kyx"), across, strict=True):
        if np.ptp(entry) != 0.0:
            _refuse(element, f"{name} depends on the speed, which cannot be read")
    if any(entry[0] for entry in across):
        support["cross_stiffness"] = (float(across[0][0]), float(across[1][0]))
    return Support(**support)


# Undamped modes of a rotor as a place on it sees them, in space at rest or turning with the rotor.
#
# With A = M (``natural``) or A = M - i G (``critical``: whirl at the speed of the rotor) the motion obeys (K - w^2 A)
# q = f e^(i w t). Modes phi with A phi = K phi / w_i^2 and phi^H K phi = 1 give the receptance at a place sum_i |r
# phi_i|^2 / (1 - w^2/w_i^2): the share of a mode in the static deflection, and its growth with the speed.


Kind = Literal["critical", "natural"]


@dataclass(frozen=True)
class Pencil:
    """K, A, C for q = Re(Q e^(i w t)) and the row of a place along one direction."""

    stiffness: Complexes
    inertia: Complexes
    damping: Complexes
    row: Floats

    def receptance(self, speed: float, *, damped: bool = True) -> complex:
        """Deflection over force at the place for w = ``speed``, m/N."""
        dynamic = self.stiffness - speed**2 * self.inertia + 1j * speed * damped * self.damping
        return complex(self.row @ np.linalg.solve(dynamic, self.row))


@dataclass(frozen=True)
class PlaceMode:
    """One mode as a place sees it."""

    speed: float  # w_i
    vector: Complexes  # phi, of unit elastic energy
    deflection: complex  # r phi


def pencil(model: LateralModel, row: Floats, direction: int, speed: float, kind: Kind) -> Pencil:
    """The matrices at a rotor speed; an isotropic rotor in complex coordinates, so that only forward whirl counts."""
    n, turns = model.pairs, float(kind == "critical")
    inertia = np.asarray(model.mass - 1j * turns * model.gyroscopic, np.complex128)
    stiffness, damping = model.stiffness_at(speed), model.damping_at(speed)
    if model.isotropic:
        k, a, c = (np.asarray(e[:n, :n] + 1j * e[n : 2 * n, :n], np.complex128) for e in (stiffness, inertia, damping))
        return Pencil(k, a, c, row)
    full = np.zeros(model.size)
    full[direction * n : (direction + 1) * n] = row
    return Pencil(np.asarray(stiffness, np.complex128), inertia, np.asarray(damping, np.complex128), full)


def place_modes(matrices: Pencil) -> list[PlaceMode]:
    """Modes with a real speed, by their share in the static deflection of the place, greatest first.

    Raises
    ------
    QuestionError
        If the rotor is not held, so that a static force moves it without end.
    """
    hermitian = 0.5 * (matrices.stiffness + matrices.stiffness.conj().T)
    levels = np.linalg.eigvalsh(hermitian)
    if levels[0] <= 1e-12 * levels[-1]:
        raise QuestionError("equivalent_planar: the rotor is not held, and has no static stiffness; give it supports")
    inverse, vectors = eigh(matrices.inertia, hermitian)
    place_modes = []
    for value, vector in zip(inverse, vectors.T, strict=True):
        if value > 1e-10 * np.abs(inverse).max():
            place_modes.append((float(value**-0.5), vector, complex(matrices.row @ vector)))
    return sorted((PlaceMode(*entry) for entry in place_modes), key=lambda mode: -(abs(mode.deflection) ** 2))


def damping_ratio(matrices: Pencil, mode: PlaceMode) -> float:
    """Damping ratio of the damped motion most alike, from (lambda^2 A + lambda C + K) Q = 0.

    Raises
    ------
    QuestionError
        If nothing oscillates.
    """
    n = mode.vector.size
    left, right = np.zeros((2, 2 * n, 2 * n), np.complex128)
    left[:n, n:] = mode.speed * np.eye(n)
    left[n:, :n], left[n:, n:] = -matrices.stiffness / mode.speed, -matrices.damping
    right[:n, :n], right[n:, n:] = np.eye(n), matrices.inertia
    values, motions = eig(left, right)
    finite = np.isfinite(values)
    values, shapes = values[finite], motions[:n, finite]
    energy = np.einsum("ij,ik,kj->j", shapes.conj(), matrices.stiffness, shapes).real
    likeness = np.abs((matrices.stiffness @ mode.vector).conj() @ shapes) ** 2 / np.maximum(energy, 1e-300)
    oscillating = values.imag > 1e-9 * np.abs(values)
    if not oscillating.any():
        raise QuestionError("equivalent_planar: no motion of the rotor oscillates; its damping is above critical")
    best = int(np.argmax(np.where(oscillating, likeness, -1.0)))
    return float(-values[best].real / abs(values[best]))


Method = Literal["static", "modal"]
METHODS = get_args(Method)


@dataclass(frozen=True)
class EquivalentPlanar:
    """The oscillators of a place, and the machine with the chosen one.

    ``data`` has over ``way`` (static, modal) and ``direction`` (x, y): ``stiffness`` (N/m), ``mass`` (kg), ``damping``
    (N s/m), ``valid_from`` and ``valid_to`` (rad/s), between which the receptance is that of the rotor within the
    tolerance; over ``direction``: ``critical_speed`` (or natural frequency, rad/s), ``damping_ratio``, ``static_share`` of
    the mode, ``other_modes_from`` (rad/s), where the other modes' share reaches the tolerance; over ``speed``, too:
    ``receptance`` of the rotor (amplitude, m/N), ``deviation`` of each way, ``other_modes_share``.
    """

    machine: Machine
    data: Answer

    def __repr__(self) -> str:
        return f"{self.machine!r}\n{self.data!r}"


@dataclass(frozen=True)
class _Direction:
    """What is known of one direction."""

    matrices: Pencil  # at the speed of the mode
    mode: PlaceMode
    share: float
    ratio: float
    constants: dict[str, tuple[float, float, float]]  # method -> k, M, b


def equivalent_planar(
    machine: Machine | str | Path,
    station: str | float | None = None,
    *,
    method: Method = "modal",
    frequency: Kind = "critical",
    tolerance: float = 0.1,
    speeds: Floats | None = None,
) -> EquivalentPlanar:
    """The planar oscillator that replaces a rotor at the plane of its balls.

    It represents the mode that carries most of the static deflection at the place. ``static``: k is the static
    stiffness, M = k/w^2 with the speed w of the mode, b = 2 D sqrt(k M) with its damping ratio D. ``modal``: k and M are
    stiffness and mass of the mode with a deflection of one at the place. They are equal where the other modes do not move
    the place. Along x and y of an anisotropic rotor each has its own mode. Springs with tables are read at w.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    station
        Name of a station or position (m); by default the plane of the first balancer.
    method
        Which of the two the returned machine has; the modal one holds near the speed of its mode.
    frequency
        ``critical``: modes that turn with the rotor, with the gyroscopic moments of synchronous whirl; ``natural``: modes
        at standstill, as a decay test gives them.
    tolerance
        Relative deviation of the synchronous receptance up to which an oscillator represents the rotor.
    speeds
        Speeds of the comparison, rad/s; by default from zero to three times the speed of the mode.

    Returns
    -------
    EquivalentPlanar
        The machine with a planar rotor: balancers of that plane, unbalances as far as they drive the mode, drive, start
        and run are kept. Its description states its origin and its range of validity.

    Raises
    ------
    QuestionError
        If the rotor is not supported, no mode moves the place, nothing oscillates, or an option is not possible.
    MachineError
        If the rotor is not possible as described, or the place is not on it.
    """
    machine = balls_in_races(machine)
    one_of("equivalent_planar: method", method, *METHODS)
    one_of("equivalent_planar: frequency", frequency, *get_args(Kind))
    if not 0.0 < tolerance < 1.0:
        raise QuestionError(f"equivalent_planar: tolerance: given {tolerance!r}; must lie between 0 and 1")
    model = lateral_model(machine)
    place, rows = reference(machine, model)
    if station is not None:
        place, rows = str(station), rows_at(machine, model, station, "station")
    # one oscillator for each direction, by every way; of isotropic rotors both are the same
    items = [_direction(model, rows.deflection, axis, frequency) for axis in range(1 if model.isotropic else 2)]
    both = [items[0], items[-1]]
    grid = _grid(speeds, both, model)
    coordinates = {
        "way": ("way", np.array(METHODS, dtype=object), "way to the oscillator"),
        "direction": ("direction", np.array(["x", "y"], dtype=object), "direction"),
        "speed": ("speed", grid, "rotor speed", "rad/s"),
    }
    md, d, ds, mds = ("way", "direction"), "direction", ("direction", "speed"), ("way", "direction", "speed")
    constants = np.array([[one.constants[m] for one in both] for m in METHODS])
    curves = [_curves(model, rows.deflection, axis % len(items), frequency, one, grid) for axis, one in enumerate(both)]
    # how far each is from the rotor, over the speed, and where that stays within the tolerance
    away = np.array(
        [[deviation(curve, grid, k, m, b) for curve, (k, m, b) in zip(curves, c, strict=True)] for c in constants]
    )
    # share of all other modes in the receptance without damping; it may exceed one
    others = np.array([np.abs(one.undamped - one.mode) / np.abs(one.undamped) for one in curves])
    holds = np.array(
        [[border(grid, entry, tolerance, one.mode.speed) for entry, one in zip(row, both, strict=True)] for row in away]
    )
    data = {
        "stiffness": (md, constants[..., 0], "stiffness of the oscillator", "N/m"),
        "mass": (md, constants[..., 1], "mass of the oscillator", "kg"),
        "damping": (md, constants[..., 2], "damping of the oscillator", "N*s/m"),
        "critical_speed": (d, [one.mode.speed for one in both], f"{frequency} speed of the mode", "rad/s"),
        "damping_ratio": (d, [one.ratio for one in both], "damping ratio of the mode", ""),
        "static_share": (d, [one.share for one in both], "share of the mode in the static deflection", ""),
        "other_modes_from": (
            d,
            [border(grid, entry, tolerance, one.mode.speed)[1] for entry, one in zip(others, both, strict=True)],
            "speed above the mode's at which the share of the other modes reaches the tolerance",
            "rad/s",
        ),
        "valid_from": (md, holds[..., 0], "lowest speed of the range that the oscillator represents", "rad/s"),
        "valid_to": (md, holds[..., 1], "highest speed of this range", "rad/s"),
        "receptance": (ds, [np.abs(curve.whole) for curve in curves], "receptance of the rotor, amplitude", "m/N"),
        "deviation": (mds, away, "relative deviation of the oscillator's receptance", ""),
        "other_modes_share": (ds, others, "share of the other modes in the receptance without damping", ""),
    }
    chosen = METHODS.index(method)
    planar, notes = planar_machine(
        machine, model, rows, place, constants[chosen], [item.mode for item in items], method, frequency,
        [(float(low), float(high)) for low, high in holds[chosen, : len(items)]],
        tolerance, [float(away[chosen, i, np.argmin(np.abs(grid - item.mode.speed))]) for i, item in enumerate(items)],
    )  # fmt: skip
    if min(one.share for one in both) < 0.5:
        notes.append(
            "no mode carries half of the static deflection at the place; a single oscillator is a poor model here"
        )
    about = attributes(machine, f"Planar oscillators of {machine.name} at {place}", balls=False) | {
        "place": place,
        "chosen": method,
        "frequency": frequency,
        "tolerance": tolerance,
        "planar_machine": planar.name,
        "notes": notes,
    }
    return EquivalentPlanar(planar, Answer.of(labeled(data, coordinates, about), "PlanarOscillators"))


def _direction(model: LateralModel, row: Floats, axis: int, kind: Kind) -> _Direction:
    """The mode at its own speed, where tables of stiffness are read, too."""
    speed = 0.0
    for _ in range(60):
        matrices = pencil(model, row, axis, speed, kind)
        modes = place_modes(matrices)
        if not modes or not abs(modes[0].deflection) > 0.0:
            raise QuestionError("equivalent_planar: no mode moves this place; choose another station")
        last, speed = speed, modes[0].speed
        if model.speeds.size == 1 or abs(last - speed) <= 1e-12 * speed:
            break
    static = matrices.receptance(0.0).real
    ratio = damping_ratio(matrices, modes[0])
    carried = abs(modes[0].deflection) ** 2
    constants = {}
    for name, flexibility in (("static", static), ("modal", carried)):
        k = 1.0 / flexibility
        constants[name] = (k, k / speed**2, 2.0 * ratio * k / speed)
    return _Direction(matrices, modes[0], carried / static, ratio, constants)


@dataclass(frozen=True)
class _Curves:
    """Receptance of the rotor, and without damping in total and of the mode alone; each (S,)."""

    whole: Complexes
    undamped: Complexes
    mode: Floats


def _curves(model: LateralModel, row: Floats, axis: int, kind: Kind, one: _Direction, grid: Floats) -> _Curves:
    whole, undamped = np.empty((2, grid.size), np.complex128)
    for i, speed in enumerate(grid):
        matrices = pencil(model, row, axis, float(speed), kind) if model.speeds.size > 1 else one.matrices
        whole[i], undamped[i] = matrices.receptance(speed), matrices.receptance(speed, damped=False)
    return _Curves(whole, undamped, abs(one.mode.deflection) ** 2 / (1.0 - (grid / one.mode.speed) ** 2))


def _grid(speeds: Floats | None, both: list[_Direction], model: LateralModel) -> Floats:
    slow, fast = min(one.mode.speed for one in both), max(one.mode.speed for one in both)
    if speeds is None:
        # beside the undamped resonance, where the receptance has a pole
        speeds = np.linspace(0.0, min(3.0 * fast, model.top_speed), 1201)
        near = np.array([s for one in both for s in (one.mode.speed * (1.0 - 1e-7), one.mode.speed * (1.0 + 1e-7))])
        speeds = np.union1d(speeds[np.min(np.abs(speeds[:, None] / [slow, fast] - 1.0), axis=1) > 1e-6], near)
    grid = np.asarray(speeds, np.float64)
    if grid.ndim != 1 or grid.size < 2 or not np.isfinite(grid).all() or grid[0] < 0.0 or np.any(np.diff(grid) <= 0.0):
        raise QuestionError("equivalent_planar: speeds: must ascend from zero or above, at least two, in rad/s")
    if grid[-1] > model.top_speed * (1.0 + 1e-12):
        raise QuestionError(
            f"equivalent_planar: speeds: given up to {grid[-1]:g} rad/s, but the tables of the rotor end at "
            f"{model.top_speed:g} rad/s"
        )
    if math.isclose(grid[0], grid[-1]):
        raise QuestionError("equivalent_planar: speeds: they must differ")
    return grid


# Over which speeds one oscillator stands for a rotor.


def deviation(curves: _Curves, speeds: Floats, stiffness: float, mass: float, damping: float) -> Floats:
    """Relative deviation of the receptance of an oscillator from that of the rotor."""
    own = 1.0 / (stiffness - speeds**2 * mass + 1j * speeds * damping)
    return np.asarray(np.abs(own - curves.whole) / np.abs(curves.whole))


def border(speeds: Floats, share: Floats, tolerance: float, center: float) -> tuple[float, float]:
    """The range around ``center`` in which ``share`` stays within the tolerance; nan if it does nowhere near.

    Linear between the speeds; an end of the speeds is an end of the range.
    """
    start = int(np.argmin(np.abs(speeds - center)))
    if not share[start] <= tolerance:
        return np.nan, np.nan
    ends = []
    for step, last in ((-1, 0), (1, speeds.size - 1)):
        i = start
        while i != last and share[i + step] <= tolerance:
            i += step
        if i == last:
            ends.append(float(speeds[i]))
            continue
        part = (tolerance - share[i]) / (share[i + step] - share[i])
        ends.append(float(speeds[i] + part * (speeds[i + step] - speeds[i])))
    return ends[0], ends[1]


# A machine with a planar rotor in place of another one: what is kept, and what is said of it.


SAME_PLANE = 1e-9  # relative difference of the rows of two places


def planar_machine(
    machine: Machine,
    model: LateralModel,
    rows: Rows,
    place: str,
    constants: Floats,
    modes: list[PlaceMode],
    method: str,
    frequency: str,
    valid: list[tuple[float, float]],
    tolerance: float,
    at_mode: list[float],
) -> tuple[Machine, list[str]]:
    """The machine and notes on what it leaves out.

    ``constants`` are k, M, b along x and y, (2, 3). For each mode: ``valid``, the range of speeds that it represents, and
    ``at_mode``, the deviation of the receptance at its speed.
    """
    notes: list[str] = []
    mass, k, b = (float(c) for c in constants[0, [1, 0, 2]])
    stiffness: float | tuple[float, float] = k
    damping: float | tuple[float, float] = b
    if np.any(constants[0] != constants[1]):
        # a planar rotor has one mass: each direction keeps its frequency and damping ratio
        first, second = (float(m) for m in constants[:, 1])
        mass = math.sqrt(first * second)
        stiffness = (k * mass / first, float(constants[1, 0]) * mass / second)
        damping = (b * mass / first, float(constants[1, 2]) * mass / second)
        if abs(first / second - 1.0) > 1e-6:
            notes.append(
                f"the masses along x and y are {first:.5g} and {second:.5g} kg; the planar rotor has their geometric mean and "
                "the critical speeds and damping ratios of both directions"
            )
    kept, left = [], []
    for i, (balancer, there) in enumerate(zip(machine.balancers, balancer_rows(machine, model), strict=True)):
        size = float(np.abs(rows.deflection).max())
        if np.abs(there.deflection - rows.deflection).max() <= SAME_PLANE * size:
            entries = {key: getattr(balancer, key) for key in balancer.model_fields_set - {"station"}}
            kept.append(type(balancer)(**entries))
        else:
            left.append(balancer.name or f"balancer {i + 1}")
    if left:
        notes.append(f"left out, because in another plane: {', '.join(left)}")
    unbalances, difference = _unbalances(machine, model, modes)
    if difference > 0.01:
        notes.append(
            f"the unbalance drives the modes along x and y differently, by {100 * difference:.3g} %; the mean is kept"
        )
    way = "static stiffness" if method == "static" else "modal stiffness and mass"
    kind = "critical speed" if frequency == "critical" else "natural frequency"
    reach = []
    for i, (mode, (low, high), away) in enumerate(zip(modes, valid, at_mode, strict=True)):
        where = f"along {'xy'[i]}: " if len(modes) == 2 else ""
        if math.isfinite(low) and low < high:
            text = (
                f"its receptance is that of the rotor within {100 * tolerance:g} % from {low:.4g} to {high:.4g} rad/s"
            )
        else:
            text = f"near this speed its receptance deviates from that of the rotor by {100 * away:.3g} %"
        reach.append(f"{where}{kind} {mode.speed:.5g} rad/s, {text}")
    text = (
        f"Planar oscillator of {machine.name!r} at {place}: {way} at this place; {'; '.join(reach)}. "
        "Unbalances count as far as they drive the mode."
    )
    fields: dict[str, Any] = {key: getattr(machine, key) for key in ("axis", "gravity", "drive", "start", "run")}
    wanted = {key: value for key, value in fields.items() if key in machine.model_fields_set}
    inertia = machine.rotor.inertia
    rotor = PlanarRotor(mass=mass, stiffness=stiffness, damping=damping, inertia=inertia)
    planar = Machine(
        name=f"{machine.name}, planar",
        description=" ".join([text, *(note[0].upper() + note[1:] + "." for note in notes), machine.description]).strip(),
        rotor=rotor, unbalances=unbalances, balancers=tuple(kept), **wanted,
    )  # fmt: skip
    return planar, notes


def _unbalances(machine: Machine, model: LateralModel, modes: list[PlaceMode]) -> tuple[tuple[Unbalance, ...], float]:
    """Point unbalances at the place that drive the mode as those of the rotor do, and how far x and y differ."""
    unbalances, worst = [], 0.0
    largest = 0.0
    sizes = []
    for i, unbalance in enumerate(machine.unbalances):
        shape = unbalance_shape(machine, model, i)
        values = [_driven(mode, shape, axis, model) for axis, mode in enumerate(modes)]
        moment = complex(np.mean(values))
        sizes.append(abs(values[0] - values[-1]))
        largest = max(largest, abs(moment))
        unbalances.append(
            Unbalance(moment=abs(moment), angle=cmath.phase(moment) if moment else 0.0, schedule=unbalance.schedule)
        )
    if largest:
        worst = max(sizes) / largest
    return tuple(unbalances), worst


def _driven(mode: PlaceMode, shape: Complexes, axis: int, model: LateralModel) -> complex:
    """phi^H u over phi^H r: of an anisotropic rotor the part of the mode along its direction."""
    vector = mode.vector if model.isotropic else mode.vector[axis * model.pairs : (axis + 1) * model.pairs]
    return complex(vector.conj() @ shape / np.conj(mode.deflection))

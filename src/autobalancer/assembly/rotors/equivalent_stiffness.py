"""A rotor on rubber that softens with the amplitude, turning steadily in circles: stiffness and motion that suit each other.

With z = q_x + i q_y = Z e^(i w t) the stretch of a piece of rubber m is s_m = r_m Z, and its elements add the stiffness
kappa_m(|s_m|, w). With D of the rotor whose elements all slide

    (D(w) + sum_m c_m kappa_m r_m^H r_m) Z = F,        c_m = 1 for rubber with two directions, 1/2 for one.

A circle is exact. Rubber that is stretched along one line only, such as bushings on a circle when the rotor tilts, counts with
its first harmonic; several of them act alike in all directions together, which is checked. Solved for the stretches:

    (1 + H kappa) s = s_0,    H = r D^-1 r^H c,    s_0 = r D^-1 F.

One piece has the scalar equation |1 + H kappa(a)| a = |s_0|. Its left side only grows with a, so that there is one motion at each
speed and the curve of the response never folds, however much the rubber softens. For an elastoplastic chain, with real E for the
rest, the left side is |E + K| a, and with sums over the elements that slip, which have x_j = a/a_j > 1,

    |E + K|^2 a^2 = (E a + P/a)^2 + S^2,    P = sum k_j a_j^2,    S = sum k_j a_j (1 - a_j^2/a^2)^(1/2),

whose slope is 2 E^2 a - 2 P^2/a^3 + 2 S S' >= 2 E^2 a, because S S' >= P^2/a^3 by Cauchy and Schwarz. The loss that comes with
the softening prevents the fold that softening alone would make. Damping only helps; endochronic elements do the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.rotors.lateral_model import SAME, LateralModel, turns_alike
from autobalancer.assembly.rotors.rig import RigAxis
from autobalancer.catalog.resolve import planar_rotor
from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Motion, RubberLaw
from autobalancer.machine import Hardening, Machine, MultibodyRotor, PlanarRotor, PointJoint, Rubber
from autobalancer.machine.rotors.body import GROUND

# Where bearings that become stiffer as they deflect sit in a rotor, and their stiffness where it rests.


@dataclass(frozen=True)
class HardPlace:
    """One such bearing: the rows of its deflection along x and y."""

    name: str
    hardening: Hardening
    rows: Matrix  # (2, N)
    support: int  # number of the support or joint of the rotor, from 1
    grounded: bool  # whether it stands on the ground

    def isotropic(self, pairs: int) -> bool:
        """Whether it is alike in all directions: its deflection, and the place where the rotor rests in it."""
        return self.hardening.center == (0.0, 0.0) and turns_alike(self.rows, pairs)

    @property
    def stiffness(self) -> Matrix:
        """What small motions about the place where the rotor rests feel, (2, 2)."""
        x, y = self.hardening.center
        return central_force(self.hardening).stiffness(-float(x), -float(y))


def hardenings(machine: Machine) -> Iterator[tuple[str, int, Hardening]]:
    """Each of them with a name for people and the number of its support or joint, from 1."""
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.hardening is not None:
            yield "support", 1, rotor.hardening
    elif isinstance(rotor, MultibodyRotor):
        for number, joint in enumerate(rotor.joints, 1):
            if isinstance(joint, PointJoint):
                yield from ((f"joint {number}", number, hardening) for hardening in joint.hardenings())
    else:
        for number, support in enumerate(rotor.supports, 1):
            if support.hardening is not None:
                yield f"support {number}", number, support.hardening


def hard_places(machine: Machine, model: LateralModel) -> tuple[HardPlace, ...]:
    """All of them, in the order of the file; a joint with several spots has one at each."""
    return tuple(
        HardPlace(name, one, rows, number, grounded)
        for name, number, one in hardenings(machine)
        for rows, grounded in _rows(machine, model, number)
    )


def central_force(hardening: Hardening) -> CentralForce:
    """A hardening in numbers."""
    table = zip(hardening.distance or (), hardening.force or (), strict=True)
    return CentralForce(
        float(hardening.cubic_stiffness), float(hardening.contact_stiffness or 0.0), float(hardening.clearance or 0.0),
        tuple((float(r), float(force)) for r, force in table),
    )  # fmt: skip


def _rows(machine: Machine, model: LateralModel, number: int) -> Iterator[tuple[Matrix, bool]]:
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        yield np.eye(2), True
    elif isinstance(rotor, MultibodyRotor):
        axis, joint = model.axis, rotor.joints[number - 1]
        assert isinstance(axis, RigAxis)
        assert isinstance(joint, PointJoint)
        kept = [axis.rig.coordinates.index(name) for name in model.coordinates]
        for six in axis.rig.spots(joint):
            yield six[:2, kept], GROUND in joint.between
    else:
        place = model.axis.rows(float(rotor.supports[number - 1].position), None).deflection
        yield np.asarray(model.both(place[None])), True


# Force of a nonlinear bearing towards its middle: a cubic spring, a stop behind a clearance, a measured
# characteristic.
#
#     F(r) = k r^3 + K max(r - g, 0) + T(r)
#
# T goes through the points of the table as a monotone cubic (Fritsch and Carlson 1980), and straight on with its last
# slope beyond them.


@dataclass(frozen=True)
class CentralForce:
    """The force in numbers, SI; ``points`` are distance (from 0, ascending) and force of the table."""

    cubic: float = 0.0
    contact: float = 0.0
    clearance: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    pieces: Floats = field(
        init=False, repr=False, compare=False
    )  # (n, 5) of T: distance where it begins, c3, c2, c1, c0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", _pieces(np.array(self.points, float).reshape(-1, 2)))

    def force(self, r: ArrayLike) -> Floats:
        """F at distances, N."""
        r = np.asarray(r, float)
        s, (c3, c2, c1, c0) = self._piece(r)
        far = np.maximum(r - self.clearance, 0.0)
        return np.asarray(self.cubic * r**3 + self.contact * far + ((c3 * s + c2) * s + c1) * s + c0)

    def slope(self, r: ArrayLike) -> Floats:
        """dF/dr, N/m; at the clearance itself that before the stop, unless there is no clearance."""
        r = np.asarray(r, float)
        s, (c3, c2, c1, _) = self._piece(r)
        touching = (r > self.clearance) | (self.clearance == 0.0)
        return np.asarray(3.0 * self.cubic * r**2 + self.contact * touching + (3.0 * c3 * s + 2.0 * c2) * s + c1)

    def stiffness(self, x: float, y: float) -> Floats:
        """What small motions about a deflection feel, (2, 2): F' along it and F/r across it."""
        r = float(np.hypot(x, y))
        along = float(self.slope(r))
        across = float(self.force(r)) / r if r > 0.0 else along
        n = np.array([x, y]) / r if r > 0.0 else np.array([1.0, 0.0])
        return np.asarray(across * np.eye(2) + (along - across) * np.outer(n, n))

    @property
    def reach(self) -> float:
        """The last distance of the table; infinite without one."""
        return float(self.points[-1][0]) if self.points else np.inf

    def _piece(self, r: Floats) -> tuple[Floats, Floats]:
        if not len(self.pieces):
            return np.zeros_like(r), np.zeros((4, *r.shape))
        number = np.maximum(np.searchsorted(self.pieces[:, 0], r, side="right") - 1, 0)
        return np.asarray(r - self.pieces[number, 0]), np.moveaxis(self.pieces[number, 1:], -1, 0)


def _pieces(points: Floats) -> Floats:
    if not len(points):
        return np.zeros((0, 5))
    from scipy.interpolate import PchipInterpolator  # only where needed: it takes a tenth of a second to load

    if points[0, 0] > 0.0:
        points = np.vstack([[0.0, 0.0], points])
    curve = PchipInterpolator(points[:, 0], points[:, 1])
    last = [points[-1, 0], 0.0, 0.0, float(curve(points[-1, 0], 1)), points[-1, 1]]
    return np.vstack([np.column_stack([points[:-1, 0], curve.c.T]), last])


# Where rubber that softens with the amplitude sits in a rotor, and what is left of the rotor when all of it slides.


@dataclass(frozen=True)
class Mount:
    """One piece of rubber: the rows of its stretch along two directions, the second zero where it has but one."""

    name: str
    rubber: Rubber
    rows: Matrix  # (2, N)
    support: int  # number of the support or joint of the rotor, from 1
    grounded: bool  # whether it stands on the ground

    def isotropic(self, pairs: int) -> bool:
        """Whether both directions are alike, so that its stretch turns with the machine when that is turned about its axis."""
        return turns_alike(self.rows, pairs)


def mounts(machine: Machine, model: LateralModel) -> tuple[Mount, ...]:
    """All rubber of a machine that softens with the amplitude, in the order of its file."""
    return tuple(_mounts(machine, model))


def sliding_model(machine: Machine, model: LateralModel, mounts: tuple[Mount, ...]) -> LateralModel:
    """The rotor with the stiffness and the damping of large motions only: what a run adds the elements to."""
    damping, stiffness = model.damping.copy(), model.stiffness.copy()
    for mount in mounts:
        square = mount.rows.T @ mount.rows
        more_stiffness, more_damping = beyond_sliding(machine, model, mount)
        stiffness -= more_stiffness[:, None, None] * square
        damping -= more_damping[:, None, None] * square
    if all(np.abs(stack - stack[0]).max() <= SAME * np.abs(stack).max(initial=0.0) for stack in (damping, stiffness)):
        return replace(model, speeds=model.speeds[:1], damping=damping[:1], stiffness=stiffness[:1])
    return replace(model, damping=damping, stiffness=stiffness)


def beyond_sliding(machine: Machine, model: LateralModel, mount: Mount) -> tuple[Floats, Floats]:
    """What the elements of rubber add to stiffness (N/m) and damping (N s/m) in small motions, at the model's speeds."""
    small = np.array([_small(machine, mount.rubber, float(speed)) for speed in model.speeds])
    return small[:, 0] - float(mount.rubber.stiffness), small[:, 1] - float(mount.rubber.damping)


def _small(machine: Machine, rubber: Rubber, speed: float) -> tuple[float, float]:
    """Stiffness and damping of small motions as the model has them."""
    if isinstance(machine.rotor, PlanarRotor):
        rotor = planar_rotor(machine)
        return rotor.stiffness_xy[0], rotor.damping_xy[0]
    return rubber.small_motions(speed)


def _mounts(machine: Machine, model: LateralModel) -> Iterator[Mount]:
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.rubber is not None:
            yield Mount("support", rotor.rubber, np.eye(2), 1, True)
    elif isinstance(rotor, MultibodyRotor):
        yield from _on_joints(rotor, model)
    else:
        for number, support in enumerate(rotor.supports, 1):
            if support.rubber is not None:
                place = model.axis.rows(float(support.position), None).deflection
                yield Mount(f"support {number}", support.rubber, model.both(place[None]), number, True)


def _on_joints(rotor: MultibodyRotor, model: LateralModel) -> Iterator[Mount]:
    axis = model.axis
    assert isinstance(axis, RigAxis)
    kept = [axis.rig.coordinates.index(name) for name in model.coordinates]
    for number, joint in enumerate(rotor.joints, 1):
        if not isinstance(joint, PointJoint) or not joint.rubbers():
            continue
        spots = axis.rig.spots(joint)
        for place, six in enumerate(spots, 1):
            name = f"joint {number}" + (f", {place} of {len(spots)}" if len(spots) > 1 else "")
            for rubber in joint.rubbers():
                rows = np.zeros((2, len(kept)))
                rows[: len(rubber.motions)] = six[np.ix_(rubber.motions, kept)]
                yield Mount(f"{name}, {rubber.name}", rubber.rubber, rows, number, GROUND in joint.between)


SAME_PLACE = 1e-9  # relative difference of two places that count as one
ALIKE = 1e-6  # relative difference of x and y that counts as none
NO_CIRCLE = "rubber: no steady circle was found at {0:.5g} rad/s; simulate the machine there, or leave the speed out"
ELLIPSES = (
    "{0}: the rubber of this machine softens with the amplitude, and its x and y differ, so that it moves in ellipses; this is "
    "known for circles only. Simulate the machine, or give it a stiffness and damping in place of rubber"
)


@dataclass(frozen=True)
class Steady:
    """Circles at S speeds: ``motion`` Z (S, n), and of each piece of rubber ``amplitude`` (m) and ``stiffness`` K (N/m)."""

    motion: Complexes
    amplitude: Floats
    stiffness: Complexes


@dataclass(frozen=True)
class Softened:
    """The rubber of a rotor, and the rotor when all of it slides, with what mass it was asked with."""

    sliding: LateralModel
    mounts: tuple[Mount, ...]
    laws: tuple[RubberLaw, ...]

    @property
    def rows(self) -> Complexes:
        """r, (M, n)."""
        n = self.sliding.pairs
        return np.array([mount.rows[0, :n] - 1j * mount.rows[0, n : 2 * n] for mount in self.mounts])

    @property
    def shares(self) -> Floats:
        """c, (M,)."""
        return np.array([1.0 if motion == "circle" else 0.5 for motion in self.motions])

    @property
    def motions(self) -> tuple[Motion, ...]:
        """In which each piece moves while the rotor circles: one with a single direction in a line."""
        return tuple("circle" if mount.rows[1].any() else "line" for mount in self.mounts)

    def added(self, amplitude: Floats, speed: Floats) -> Complexes:
        """kappa (..., M) at amplitudes (..., M) and speeds (...,)."""
        return _elements(list(zip(self.laws, self.motions, strict=True)), amplitude, speed)

    def steady(self, speeds: Floats, force: Complexes, owner: str, *, over: float = 1.0) -> Steady:
        """Circles under a ``force`` F at each of the whirl ``speeds``, (S, n).

        The rotor turns ``over`` times as fast as it whirls.

        Raises
        ------
        QuestionError
            If the machine moves in ellipses; ``owner`` is who asks.
        """
        circles = self.circles(speeds, force, over=over)
        if circles is None:
            raise QuestionError(ELLIPSES.format(owner))
        return circles

    def circles(
        self, speeds: Floats, force: Complexes, *, over: float | Floats = 1.0, attempted: bool = False
    ) -> Steady | None:
        """The same; none where the machine moves in ellipses. ``over`` may differ from speed to speed.

        If it is only ``attempted``, the motion is nan where no amplitude was found.
        """
        if not self.sliding.isotropic:
            return None
        dynamic = _dynamics(self.sliding, speeds, np.asarray(over * speeds))
        r, c = self.rows, self.shares
        one, group = self._alike(r)
        weight = np.array([c[group == g].sum() for g in range(len(one))])
        inverse = np.linalg.inv(dynamic)
        free = np.einsum("mi,sij,sj->sm", r[one], inverse, force)
        across = np.einsum("mi,sij,kj->smk", r[one], inverse, r[one].conj()) * weight
        laws = [(self.laws[m], self.motions[m]) for m in one]
        amplitude, wrong = (by_newton if attempted else in_turns)(laws, speeds, across, free)
        if wrong.size and not attempted:
            raise QuestionError(NO_CIRCLE.format(speeds[wrong[0]]))
        amplitude = amplitude[:, group]
        kappa = self.added(amplitude, speeds)
        if not self._in_circles(kappa):
            return None
        whole = dynamic + np.einsum("mi,sm,mj->sij", r.conj(), c * kappa, r)
        motion = np.linalg.solve(whole, force[..., None])[..., 0]
        motion[wrong] = np.nan
        elastic = np.array([law.elastic for law in self.laws]) + 1j * np.outer(
            speeds, [law.viscous for law in self.laws]
        )
        return Steady(np.asarray(motion, np.complex128), amplitude, np.asarray(kappa + elastic))

    def _alike(self, rows: Complexes) -> tuple[list[int], np.ndarray]:
        """The first of each group of pieces that always move alike, and the group of each piece."""
        one: list[int] = []
        group = np.zeros(len(rows), int)
        for m, row in enumerate(rows):
            for g, first in enumerate(one):
                same = abs(np.vdot(rows[first], row)) >= (1.0 - SAME_PLACE) * np.linalg.norm(
                    rows[first]
                ) * np.linalg.norm(row)
                as_far = abs(np.linalg.norm(rows[first]) - np.linalg.norm(row)) <= SAME_PLACE * np.linalg.norm(row)
                if same and as_far and (self.laws[m], self.motions[m]) == (self.laws[first], self.motions[first]):
                    group[m] = g
                    break
            else:
                group[m] = len(one)
                one.append(m)
        return one, group

    def at_amplitude(self, amplitude: ArrayLike, speed: float, motion: Motion = "circle") -> LateralModel:
        """The rotor with the stiffness K' and damping K''/w that its rubber has at amplitudes (m) and a frequency w (rad/s).

        One amplitude, or one of each piece; pieces with one direction always move in a line.
        """
        stiffness, damping = self.sliding.stiffness, self.sliding.damping
        sizes = np.broadcast_to(np.asarray(amplitude, dtype=float), (len(self.mounts),))
        for law, mount, own, size in zip(self.laws, self.mounts, self.motions, sizes, strict=True):
            how = own if own == "line" else motion
            more = complex(law.elements.stiffness(size, speed, how))
            square = mount.rows.T @ mount.rows
            stiffness = stiffness + more.real * square
            damping = damping + more.imag / speed * square
        return replace(self.sliding, stiffness=stiffness, damping=damping)

    def _in_circles(self, kappa: Complexes) -> bool:
        """Whether pieces with two directions act alike along x and y, those with one together, and none on other motions."""
        n = self.sliding.pairs
        squares = np.array([mount.rows.T @ mount.rows for mount in self.mounts])
        lines = [m for m, motion in enumerate(self.motions) if motion == "line"]
        every = [squares[m] for m in range(len(self.mounts)) if m not in lines]
        every += [np.einsum("m,mij->ij", one[lines], squares[lines]) for one in kappa] if lines else []
        others = np.einsum("sm,mij->sij", kappa, squares)[:, : 2 * n, 2 * n :]
        apart = np.abs(others).max(initial=0.0) > ALIKE * np.abs(kappa).max()
        return not apart and not any(_uneven(one, n) for one in every)


def _uneven(matrix: Complexes, n: int) -> bool:
    """Whether x and y differ."""
    xx, xy, yx, yy = matrix[:n, :n], matrix[:n, n : 2 * n], matrix[n : 2 * n, :n], matrix[n : 2 * n, n : 2 * n]
    return bool(max(np.abs(xx - yy).max(), np.abs(xy + yx).max()) > ALIKE * np.abs(matrix).max())


def softened(machine: Machine, bare: LateralModel, model: LateralModel | None = None) -> Softened | None:
    """The softening rubber of a machine with its ``bare`` model, and the mass of ``model`` if given; none without any."""
    equivalent = mounts(machine, bare)
    if not equivalent:
        return None
    sliding = sliding_model(machine, bare, equivalent)
    sliding = sliding if model is None else replace(sliding, mass=model.mass)
    return Softened(sliding, equivalent, tuple(law_of(mount.rubber) for mount in equivalent))


def law_of(rubber: Rubber) -> RubberLaw:
    """Rubber in numbers."""
    friction, maxwell = rubber.friction, rubber.maxwell
    return RubberLaw(
        float(rubber.stiffness),
        float(rubber.damping),
        () if friction is None else tuple(zip(friction.stiffness, friction.breakaway_amplitude, strict=True)),
        () if maxwell is None else tuple(zip(maxwell.stiffness, maxwell.relaxation_time, strict=True)),
        "elastoplastic" if friction is None else friction.law,
    )


def _dynamics(model: LateralModel, whirls: Floats, speeds: Floats) -> Complexes:
    """D at whirl speeds of a rotor that turns at ``speeds``, (S, n, n)."""
    if model.speeds.size == 1:
        mass, damping, stiffness = model.complex_matrices(0.0)
        turning = model.complex_matrices(1.0)[1] - damping
        v, w = whirls[:, None, None], speeds[:, None, None]
        return np.asarray(stiffness + 1j * v * (damping + w * turning) - v**2 * mass)
    dynamics = []
    for v, w in zip(whirls.tolist(), speeds.tolist(), strict=True):
        mass, damping, stiffness = model.complex_matrices(w)
        dynamics.append(stiffness + 1j * v * damping - v**2 * mass)
    return np.array(dynamics)


# How far pieces of rubber are stretched in circles, so that their stiffness and the motion of the rotor suit each
# other.
#
# With the receptance H between G groups of pieces, kappa of their elements and the stretches s_0 without them
#
#     (1 + H kappa(|s|)) s = s_0 .


STEPS, EXACT = 60, 1e-15  # of the search for an amplitude
ROUNDS, SURE, NEAR = (
    300,
    1e-12,
    1e-8,
)  # over several pieces, until no amplitude changes by more; and by how much at the end
FARTHER = 0.3, 20.0  # least and most by which a change is carried on
NEWTON, HALVES = 25, 8  # steps of Newton's method, and how often one is halved
DIFFERENCE = 1e-7  # relative, of an amplitude

Laws = list[tuple[RubberLaw, Motion]]


def in_turns(laws: Laws, speeds: Floats, across: Complexes, free: Complexes) -> tuple[Floats, np.ndarray]:
    """Amplitudes of groups of rubber, (S, G), and the numbers of speeds without any: of each in turn.

    It has the stiffness of the others, until none changes.

    Where they creep, they are carried on in the direction in which they change (Irons and Tuck 1969).
    """
    if len(laws) == 1:
        return _root(laws[0], speeds, across[:, 0, 0], np.abs(free[:, 0]))[:, None], np.zeros(0, np.int64)
    amplitude = np.abs(free)
    left = np.arange(speeds.size)  # speeds at which amplitudes still change
    before = np.zeros_like(amplitude)
    ahead = np.ones(speeds.size)
    for number in range(ROUNDS):
        result = _in_turn(laws, speeds[left], across[left], free[left], amplitude[left])
        change = result - amplitude[left]
        moved = np.abs(change).max(axis=1) > SURE * result.max(axis=1)
        amplitude[left[~moved]] = result[~moved]
        if not moved.any():
            return amplitude, np.zeros(0, np.int64)
        left, result, change = left[moved], result[moved], change[moved]
        if number:
            bend = change - before[left]
            size = np.maximum((bend**2).sum(axis=1), 1e-300)
            ahead[left] = np.clip(-ahead[left] * (before[left] * bend).sum(axis=1) / size, *FARTHER)
        before[left] = change
        amplitude[left] = np.maximum(amplitude[left] + ahead[left, None] * change, 0.1 * result)
    return amplitude, left[np.abs(change).max(axis=1) > NEAR * result.max(axis=1)]


def _in_turn(laws: Laws, speeds: Floats, across: Complexes, free: Complexes, amplitude: Floats) -> Floats:
    """The amplitude of each group that suits those of the others, one after the other."""
    result = amplitude.copy()
    kappa = _elements(laws, result, speeds)
    for g, law in enumerate(laws):
        h, s = _group_alone(g, across, free, kappa)
        result[:, g] = _root(law, speeds, h, np.abs(s))
        kappa[:, g] = law[0].elements.stiffness(result[:, g], speeds, law[1])
    return result


def _group_alone(g: int, across: Complexes, free: Complexes, kappa: Complexes) -> tuple[Complexes, Complexes]:
    """H and s_0 of one group where the others are springs."""
    rest = [other for other in range(kappa.shape[1]) if other != g]
    held = np.eye(len(rest)) + across[:, rest][:, :, rest] * kappa[:, None, rest]
    over = across[:, g, rest] * kappa[:, rest]
    h = across[:, g, g] - np.einsum("so,so->s", over, np.linalg.solve(held, across[:, rest, g, None])[..., 0])
    s = free[:, g] - np.einsum("so,so->s", over, np.linalg.solve(held, free[:, rest, None])[..., 0])
    return np.asarray(h), np.asarray(s)


def _elements(laws: Laws, amplitude: Floats, speeds: Floats) -> Complexes:
    """kappa (..., M) at amplitudes (..., M) and speeds (...,); pieces that are alike are asked at once."""
    result = np.zeros(amplitude.shape, np.complex128)
    for law, motion in dict.fromkeys(laws):
        same = [m for m, one in enumerate(laws) if one == (law, motion)]
        result[..., same] = law.elements.stiffness(amplitude[..., same], np.asarray(speeds)[..., None], motion)
    return result


def _root(law: tuple[RubberLaw, Motion], speeds: Floats, h: Complexes, free: Floats) -> Floats:
    """The root of |1 + H kappa(a)| a = |s_0| at each speed, (S,), by Ridders' method."""

    elements, motion = law[0].elements, law[1]

    def miss(amplitude: Floats) -> Floats:
        return np.asarray(np.abs(1.0 + h * elements.stiffness(amplitude, speeds, motion)) * amplitude - free)

    low, below, high = np.zeros_like(free), -free, free.copy()
    above = miss(high)
    for _ in range(200):  # kappa falls with the amplitude, so that this ends
        short = above < 0.0
        if not short.any():
            break
        low, below, high = np.where(short, high, low), np.where(short, above, below), np.where(short, 2.0 * high, high)
        above = miss(high)
    new = high
    for _ in range(STEPS):
        middle, before = 0.5 * (low + high), new
        at = miss(middle)
        root = np.sqrt(np.maximum(at * at - below * above, 0.0))
        new = np.clip(
            middle + (middle - low) * np.divide(-at, root, out=np.zeros_like(at), where=root > 0.0), low, high
        )
        for point, value in ((middle, at), (new, miss(new))):
            lower, upper = (value < 0.0) & (point >= low), (value >= 0.0) & (point <= high)
            low, below = np.where(lower, point, low), np.where(lower, value, below)
            high, above = np.where(upper, point, high), np.where(upper, value, above)
        if np.all((np.abs(new - before) <= EXACT * new) | (high - low <= EXACT * high)):
            break
    return np.where(np.abs(above) <= np.abs(below), high, low)


def by_newton(laws: Laws, speeds: Floats, across: Complexes, free: Complexes) -> tuple[Floats, np.ndarray]:
    """The same by Newton's method, much faster for several groups: from the stiffest rubber, the softest, and each breakaway.

    From a single start it may fail where there is an amplitude, and a branch that is followed would end there too early.
    """
    if len(laws) == 1:
        return in_turns(laws, speeds, across, free)
    amplitude, left = np.abs(free), np.arange(speeds.size)
    for size in (0.0, np.inf, *sorted({limit for law, _ in laws for _, limit in law.friction})):
        amplitude[left], wrong = _newton(laws, speeds[left], across[left], free[left], size)
        left = left[wrong]
        if not left.size:
            break
    return amplitude, left


def _newton(laws: Laws, speeds: Floats, across: Complexes, free: Complexes, size: float) -> tuple[Floats, np.ndarray]:
    """The same from one start, as stiff as at a ``size``."""
    count = len(laws)
    begun = np.full(free.shape, min(size, 1e3 * float(np.abs(free).max(initial=0.0)) + 1.0))
    kappa = _elements(laws, begun, speeds)
    s = np.linalg.solve(np.eye(count) + across * kappa[:, None, :], free[..., None])[..., 0].astype(np.complex128)
    left = np.arange(speeds.size)

    def missed(which: np.ndarray, s: np.ndarray) -> tuple[Complexes, Complexes]:
        kappa = _elements(laws, np.abs(s), speeds[which])
        return s + (across[which] @ (kappa * s)[..., None])[..., 0] - free[which], kappa

    miss, kappa = missed(left, s)
    for _ in range(NEWTON):
        here, h = s[left], across[left]
        size_of = np.abs(here)
        more = _elements(laws, size_of * (1.0 + DIFFERENCE), speeds[left])
        ahead = here / np.where(size_of > 0.0, size_of, 1.0)
        steeper = (more - kappa) / DIFFERENCE * ahead
        # over real and imaginary parts of s, each (S, G)
        slopes = [
            h * (kappa * part + steeper * along)[:, None] for part, along in ((1.0, ahead.real), (1j, ahead.imag))
        ]
        whole = np.concatenate([slopes[0] + np.eye(count), slopes[1] + 1j * np.eye(count)], axis=2)
        real = np.concatenate([whole.real, whole.imag], axis=1)
        step = -np.linalg.solve(real, np.concatenate([miss.real, miss.imag], axis=1)[..., None])[..., 0]
        change = step[:, :count] + 1j * step[:, count:]
        # a step that makes it worse is halved
        level, least = np.abs(miss).max(axis=1), NEAR * size_of.max(axis=1)
        miss, kappa = missed(left, here + change)
        for _ in range(HALVES):
            far = (np.abs(miss).max(axis=1) > level) & (np.abs(change).max(axis=1) > least)
            if not far.any():
                break
            change[far] *= 0.5
            miss, kappa = missed(left, here + change)
        s[left] = here + change
        further = ~(np.abs(change).max(axis=1) <= SURE * size_of.max(axis=1))
        left, miss, kappa = left[further], miss[further], kappa[further]
        if not left.size:
            break
    return np.abs(s), left

"""A rotor on rubber that softens with the amplitude, where x and y differ: steady motion in ellipses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.rotors.equivalent_stiffness import Softened
from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import RubberLaw

# Ellipses in which a rotor on softening rubber moves steadily: deflections and forces of all pieces that suit each
# other.
#
# The rotor whose elements all slide has the dynamic stiffness D, real rows R_m for the two directions of a piece m,
# and
#
#     D(v) Q + sum_m R_m^T F_m(R_m Q) = P,    q = Re(Q e^(i v t)).
#
# Solved for the stretches, each as its forward and backward circle u = (f, conj b), by Newton's method with real and
# imaginary parts apart, because the first harmonic of a friction element is no complex function of its deflection:
#
#     u + H F(u) = u_0,    H = R D^-1 R^T,    u_0 = R D^-1 P.
#
# The first harmonic is kept; the third, which a circle has not, is measured: the deflection that it would cause is an
# estimate of what is left out. Two searches, from the stiffest and from the softest rubber, must come to the same
# motion.


STEPS, HALVES = 40, 14  # of Newton's method, and of a step that does not lead nearer
CLOSE, ENOUGH = 1e-11, 1e-8  # last step over the deflection that ends the search, and that is accepted
PERIODIC = 1e-6  # force over k a_c by which an element may miss its period
LOADS = 2.0 ** np.arange(-12, 1)  # shares of the load, where the whole of it is not solved at once
SAME = 1e-5  # relative difference of two motions that count as one
TO_CIRCLES = 0.5 * np.array([[1.0, 1.0j], [1.0, -1.0j]])  # (f, conj b) of (x, y)
FROM_CIRCLES = np.linalg.inv(TO_CIRCLES)


@dataclass(frozen=True)
class Ellipses:
    """Ellipses at S speeds: ``motion`` Q (S, N) of q = Re(Q e^(i v t)); of each piece of rubber m, SI, (S, M):

    ``circles`` (f, conj b) of its stretch and ``forces`` of its elements, (S, M, 2); ``plain`` stiffness beside the elements;
    ``third`` the greatest deflection at three times the speed, which is left out, an estimate.
    """

    motion: Complexes
    circles: Complexes
    forces: Complexes
    plain: Complexes
    third: Floats

    @property
    def amplitude(self) -> Floats:
        """Greatest stretch, the major semi-axis."""
        return np.asarray(np.abs(self.circles).sum(axis=-1))

    @property
    def minor(self) -> Floats:
        """Least stretch, the minor semi-axis, positive where it goes around in the sense of rotation."""
        return np.asarray(np.abs(self.circles[..., 0]) - np.abs(self.circles[..., 1]))

    @property
    def stiffness(self) -> Complexes:
        """Mean K: the energy lost in a cycle is 2 pi K'' (|f|^2 + |b|^2), and K' is the same of the stored energy."""
        size = (np.abs(self.circles) ** 2).sum(axis=-1)
        added = (self.circles.conj() * self.forces).sum(axis=-1) / np.where(size > 0.0, size, 1.0)
        return np.asarray(self.plain + added)

    @property
    def pushes(self) -> Complexes:
        """Forces of the elements along x and y, (S, M, 2)."""
        return np.asarray(self.forces @ FROM_CIRCLES.T)


def steadily(soft: Softened, speeds: Floats, load: Complexes, owner: str, *, twice: bool = True) -> Ellipses:
    """Motion under an unbalance ``load`` (pairs,), kg m: in circles where the machine is alike along x and y, else in ellipses.

    ``twice``: see :func:`ellipses`.

    Raises
    ------
    QuestionError
        As of :func:`ellipses`.
    """
    square, n = speeds[:, None] ** 2, soft.sliding.pairs
    circling = soft.circles(speeds, square * load)
    rest = np.zeros(soft.sliding.size - 2 * n)
    if circling is None:
        return ellipses(soft, speeds, square * np.concatenate([load, -1j * load, rest]), owner, twice=twice)
    motion: Complexes = np.hstack([circling.motion, -1j * circling.motion, np.zeros((speeds.size, rest.size))])
    circles = rubber_motions(soft, motion)
    plain = plain_stiffness(soft, speeds)
    third = np.array([0.0 if motion == "circle" else np.nan for motion in soft.motions]) * np.ones((speeds.size, 1))
    return Ellipses(motion, circles, (circling.stiffness - plain)[..., None] * circles, plain, third)


def rubber_motions(soft: Softened, motion: Complexes) -> Complexes:
    """(f, conj b) of each piece of rubber, (S, M, 2), of a motion (S, N)."""
    rows = np.concatenate([mount.rows for mount in soft.mounts])
    return np.asarray((motion @ rows.T).reshape(len(motion), -1, 2) @ TO_CIRCLES.T)


def plain_stiffness(soft: Softened, speeds: Floats) -> Complexes:
    """Of each piece when all elements slide, (S, M), N/m."""
    return np.array([law.elastic for law in soft.laws]) + 1j * np.outer(speeds, [law.viscous for law in soft.laws])


def ellipses(
    soft: Softened, speeds: Floats, force: Complexes, owner: str, *, over: float | Floats = 1.0, twice: bool = True
) -> Ellipses:
    """Steady motion under forces Re(P e^(i v t)), P (S, N), at the ``speeds`` v (S,); the rotor turns ``over`` times as fast.

    It is sought ``twice``, or once only, from the stiffest rubber, where that comes to an end.

    Raises
    ------
    QuestionError
        If no motion is found or two are, at a speed that is named; ``owner`` is who asks.
    """
    problem = _Problem(soft, speeds, force, over)
    stiff, converged = problem.solved(problem.linear(1.0))
    if converged.all() and not twice:
        return problem.answer(stiff)
    loose, other = problem.solved(problem.linear(0.0))
    apart = np.abs(loose - stiff).max(axis=(1, 2)) > SAME * np.abs(stiff).max(axis=(1, 2))
    if (apart & converged & other).any():
        _refuse(owner, speeds[apart & converged & other], "two steady motions were found")
    stiff[~converged] = loose[~converged]
    left = np.flatnonzero(~converged & ~other)
    if left.size:
        stiff[left], grown = problem.grown(left)
        if not grown.all():
            _refuse(owner, speeds[left[~grown]], "no steady ellipse was found")
    return problem.answer(stiff)


def _refuse(owner: str, speeds: Floats, what: str) -> None:
    raise QuestionError(
        f"{owner}: rubber: {what} at {speeds[0]:.5g} rad/s; simulate the machine there, or leave the speed out"
    )


class _Problem:
    """The equations at S speeds."""

    def __init__(self, soft: Softened, speeds: Floats, force: Complexes, over: float | Floats) -> None:
        self.soft, self.speeds, self.force = soft, speeds, force
        self.elements = [Elements.of(law, speeds.size) for law in soft.laws]
        self.rows = np.concatenate([mount.rows for mount in soft.mounts])  # (2 M, N)
        self.rotor, self.count = (over * speeds).tolist(), len(soft.mounts)
        dynamic = self.dynamic(1.0)
        self.across = self._between(dynamic)
        self.free = rubber_motions(soft, np.asarray(np.linalg.solve(dynamic, force[..., None])[..., 0], np.complex128))

    def dynamic(self, harmonic: float) -> Complexes:
        """D of the rotor whose elements all slide, at a harmonic of the speeds, (S, N, N)."""
        model, matrices = self.soft.sliding, []
        for v, w in zip(self.speeds.tolist(), self.rotor, strict=True):
            whirl, turning = harmonic * v, model.damping_at(w) + w * model.gyroscopic
            matrices.append(model.stiffness_at(w) + 1j * whirl * turning - whirl**2 * model.mass)
        return np.array(matrices)

    def _between(self, dynamic: Complexes) -> Complexes:
        """H between the circles of all pieces, (S, 2 M, 2 M)."""
        answer = self.rows @ np.linalg.solve(dynamic, np.broadcast_to(self.rows.T, (len(dynamic), *self.rows.T.shape)))
        turn = np.kron(np.eye(self.count), TO_CIRCLES)
        return np.asarray(turn @ answer @ np.linalg.inv(turn))

    def linear(self, share: float) -> Complexes:
        """Circles u (S, M, 2) on elements of which a ``share`` of the stiffness of small motions acts."""
        rest = np.stack(
            [element.at_rest(self.speeds) * np.ones(self.speeds.size) for element in self.elements], axis=-1
        )
        whole = np.eye(2 * self.count) + self.across * (share * np.repeat(rest, 2, axis=1))[:, None, :]
        return np.asarray(np.linalg.solve(whole, self._flat(self.free)[..., None]).reshape(self.free.shape))

    @staticmethod
    def _flat(circles: Complexes) -> Complexes:
        return circles.reshape(len(circles), -1)

    def misfit(self, which: np.ndarray, u: Complexes, share: Floats, sloped: bool) -> tuple[Complexes, Floats]:
        """u + H F(u) - u_0, (n, 2 M), and its slopes, real and imaginary parts apart, (n, 4 M, 4 M)."""
        size = 4 * self.count
        force, slope = np.zeros(u.shape, np.complex128), np.zeros((which.size, size, size))
        for m, element in enumerate(self.elements):
            forces = element.on(which, u[:, m], self.speeds[which], sloped)
            force[:, m] = forces.force
            slope[:, 4 * m : 4 * m + 4, 4 * m : 4 * m + 4] = forces.slope
        h = self.across[which]
        miss = self._flat(u - share[:, None, None] * self.free[which]) + (h @ self._flat(force)[..., None])[..., 0]
        if not sloped:
            return miss, slope
        parted = np.zeros((which.size, size, size))
        parted[:, ::2, ::2] = parted[:, 1::2, 1::2] = h.real
        parted[:, 1::2, ::2], parted[:, ::2, 1::2] = h.imag, -h.imag
        return miss, np.eye(size) + parted @ slope

    def solved(
        self, start: Complexes, which: np.ndarray | None = None, share: float = 1.0
    ) -> tuple[Complexes, np.ndarray]:
        """Circles by Newton's method from a ``start`` (n, M, 2), and at which speeds it came to an end."""
        which = np.arange(self.speeds.size) if which is None else which
        u = start.copy()
        last = np.full(which.size, np.inf)
        left = np.arange(which.size)
        for _ in range(STEPS):
            at, shares = which[left], np.full(left.size, share)
            miss, slope = self.misfit(at, u[left], shares, True)
            step = -np.linalg.solve(slope, miss.view(np.float64)[..., None])[..., 0].view(np.complex128)
            level = np.abs(miss).max(axis=1)
            step = self._shorter(at, u[left], step.reshape(-1, self.count, 2), level, shares)
            u[left] += step
            size = np.abs(u[left]).max(axis=(1, 2))
            last[left] = np.abs(step).max(axis=(1, 2)) / np.where(size > 0.0, size, 1.0)
            left = left[~(last[left] < CLOSE)]
            if not left.size:
                break
        return u, last < ENOUGH

    def _shorter(self, at: np.ndarray, u: Complexes, step: Complexes, level: Floats, shares: Floats) -> Complexes:
        """Steps halved until they lead nearer."""
        far = np.arange(at.size)
        for _ in range(HALVES):
            miss, _ = self.misfit(at[far], u[far] + step[far], shares[far], False)
            size = np.abs(u[far]).max(axis=(1, 2))
            worse = (np.abs(miss).max(axis=1) > level[far]) & (np.abs(step[far]).max(axis=(1, 2)) > ENOUGH * size)
            far = far[worse]
            if not far.size:
                break
            step[far] *= 0.5
        return step

    def grown(self, which: np.ndarray) -> tuple[Complexes, np.ndarray]:
        """The same while the load grows from nearly nothing, at speeds at which the whole of it is not solved at once."""
        u, converged = LOADS[0] * self.linear(1.0)[which], np.ones(which.size, np.bool_)
        before = LOADS[0]
        for share in LOADS:
            u, converged = self.solved(u * share / before, which, float(share))
            before = share
        return u, converged

    def answer(self, u: Complexes) -> Ellipses:
        """All that is asked of the motion."""
        every, forces, third = np.arange(self.speeds.size), np.zeros_like(u), np.zeros_like(u)
        for m, element in enumerate(self.elements):
            elements = element.on(every, u[:, m], self.speeds, False)
            if (elements.miss > PERIODIC).any():
                raise QuestionError(
                    f"rubber: no periodic force was found at {self.speeds[elements.miss > PERIODIC][0]:.5g} rad/s; "
                    "simulate the machine there"
                )
            forces[:, m], third[:, m] = elements.force, elements.third
        pushed = (forces @ FROM_CIRCLES.T).reshape(len(u), -1) @ self.rows
        motion = np.linalg.solve(self.dynamic(1.0), (self.force - pushed)[..., None])[..., 0]
        plain = plain_stiffness(self.soft, self.speeds)
        return Ellipses(np.asarray(motion), u, forces, plain, self._left_out(u, forces, third))

    def _left_out(self, u: Complexes, forces: Complexes, third: Complexes) -> Floats:
        """Deflection at three times the speed that the third harmonic of the forces causes, rubber as stiff as at one time it."""
        size = (np.abs(u) ** 2).sum(axis=-1)
        kappa = (u.conj() * forces).sum(axis=-1) / np.where(size > 0.0, size, 1.0)
        h = self._between(self.dynamic(3.0))
        whole = np.eye(2 * self.count) + h * np.repeat(kappa, 2, axis=1)[:, None, :]
        moved = np.linalg.solve(whole, -(h @ self._flat(third)[..., None]))[..., 0]
        return np.asarray(np.abs(moved.reshape(u.shape)).sum(axis=-1))


# The force of rubber whose deflection is an ellipse: first harmonic, its slopes, and the third harmonic that is left
# out.
#
# With z = x + i y the deflection is z = f e^(i v t) + b e^(-i v t), here as u = (f, conj b), and the force alike.
# Turning the axes or beginning at another time turns f and b only, so that the sizes |f| and |b| decide everything,
#
#     F_f = e^(i arg f) Phi_f(|f|, |b|),    F_b = e^(i arg b) Phi_b(|f|, |b|),
#
# and four slopes of two complex functions give all. Phi is found by the method of alternating frequency and time
# domain: one period of every element, see :mod:`autobalancer.kernels.laws.rubber_elements`.


ROUND = 1e-7  # of an ellipse: a circle so small against the other counts as none
THIN = 1e-3  # ratio of the axes of an ellipse that stands for a line


@dataclass(frozen=True)
class Forces:
    """Of the elements of one piece of rubber on n ellipses."""

    force: Complexes  # (n, 2) first harmonic, N
    slope: Floats  # (n, 4, 4) of its real and imaginary parts over those of u, N/m
    third: Complexes  # (n, 2) third harmonic, N
    miss: Floats  # (n,) of the forces of the elements: what is left until they are periodic


@dataclass
class Elements:
    """The sliding and the relaxing elements of one piece of rubber; it remembers what they were at the last ellipses."""

    law: RubberLaw
    starts: Floats  # (S, 2 e) force of each element at the tip of the ellipse, of S speeds

    @classmethod
    def of(cls, law: RubberLaw, speeds: int) -> Elements:
        """Elements at a number of speeds, nothing remembered."""
        return cls(law, np.zeros((speeds, 2 * len(law.friction))))

    def at_rest(self, speed: Floats) -> Complexes:
        """Stiffness of small motions that the elements add, N/m."""
        return self.relaxing(speed) + sum(k for k, _ in self.law.friction)

    def relaxing(self, speed: Floats) -> Complexes:
        """Stiffness of the Maxwell elements, N/m."""
        return replace(self.law, elastic=0.0, viscous=0.0, friction=()).stiffness(0.0, speed)

    def on(self, which: np.ndarray, motion: Complexes, speed: Floats, sloped: bool = True) -> Forces:
        """On ellipses u (n, 2), m, at the speeds (n,) whose numbers are ``which``."""
        from autobalancer.kernels.laws.rubber_elements import (
            COLUMNS,
            FORCE,
            MISS,
            ORDER,
            OVER_BACKWARD,
            OVER_FORWARD,
            THIRD,
            forces_on_ellipses,
        )

        size = np.ascontiguousarray(np.abs(motion))
        elements = np.array([(limit, k) for k, limit in self.law.friction]).reshape(-1, 2)
        starts, out = self.starts[which], np.zeros((size.shape[0], COLUMNS))
        always = self.law.law == "endochronic"
        forces_on_ellipses(size, elements, always, starts, np.zeros((ORDER + 1, 5)), np.zeros(8), out, sloped)
        self.starts[which] = starts
        relaxing = np.broadcast_to(self.relaxing(speed), size.shape[:1])[:, None]
        turned = np.where(size > 0.0, motion / np.where(size > 0.0, size, 1.0), 1.0)  # e^(i arg u)
        radial = _pairs(out, FORCE)
        slopes = np.stack([_pairs(out, OVER_FORWARD), _pairs(out, OVER_BACKWARD)], axis=-1) if sloped else None
        force = turned * radial + relaxing * motion
        slope = np.zeros((size.shape[0], 4, 4))
        if slopes is not None:
            slope = _slopes(turned, size, radial, slopes, relaxing)
        third = _pairs(out, THIRD) * _third_turn(turned)
        return Forces(force, slope, third, out[:, MISS])


def alike_springs(law: RubberLaw, stretch: Complexes, amplitude: float, speed: float) -> Complexes:
    """The stiffness, (2, 2) complex and symmetric, of springs that act on an ellipse as the elements of a law do.

    ``stretch`` (2,) along x and y has the shape of the ellipse, ``amplitude`` (m) is its major semi-axis, ``speed`` rad/s. The
    springs act along the axes of the ellipse; across a line they have the stiffness of a thin ellipse.
    """
    x, y = stretch
    f, b = 0.5 * (x + 1j * y), 0.5 * np.conj(x - 1j * y)
    if min(abs(f), abs(b)) <= ROUND * (abs(f) + abs(b)):
        return np.eye(2) * law.elements.stiffness(amplitude, speed)
    size = amplitude / (abs(f) + abs(b))
    minor = size * (abs(f) - abs(b))
    minor = minor if abs(minor) > THIN * amplitude else np.copysign(THIN * amplitude, minor)
    motion = np.array([[0.5 * (amplitude + minor), 0.5 * (amplitude - minor)]], np.complex128)
    forward, backward = Elements.of(law, 1).on(np.zeros(1, np.int64), motion, np.array([speed]), False).force[0]
    lean = 0.5 * np.angle(f * b)
    axes = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])
    along = np.diag([(forward + backward) / amplitude, (forward - backward) / minor])
    return np.asarray(axes @ along @ axes.T, np.complex128)


def _pairs(out: Floats, column: int) -> Complexes:
    """(F_f, conj F_b) of four numbers, (n, 2)."""
    part = out[:, column : column + 4]
    return np.stack([part[:, 0] + 1j * part[:, 1], part[:, 2] - 1j * part[:, 3]], axis=-1)


def _third_turn(turned: Complexes) -> Complexes:
    """The phases of (f, conj b) of the third harmonic: with f at p and b at q they are 2 p - q and q - 2 p, doubled less."""
    p, minus_q = turned[:, 0], turned[:, 1]
    return np.stack([p * p * minus_q, p * minus_q * minus_q], axis=-1)


def _slopes(turned: Complexes, size: Floats, radial: Complexes, slopes: Complexes, relaxing: Complexes) -> Floats:
    """(n, 4, 4) of (Re, Im) of both circles."""
    near = size <= ROUND * size.sum(axis=1, keepdims=True)
    own = np.stack([slopes[:, 0, 0], slopes[:, 1, 1]], axis=-1)
    around = 1j * np.where(near, own, radial / np.where(near, 1.0, size))  # over a turn of its own phase
    result = np.zeros((size.shape[0], 4, 4))
    for i in range(2):
        for j in range(2):
            for part, direction in enumerate((1.0, 1j)):
                change: Complexes = direction * turned[:, j].conj()
                # a circle that is nothing changes the other one to its size, whatever its phase
                cross = np.where(near[:, j] & (i != j), 0j, slopes[:, i, j])
                force = np.asarray(turned[:, i] * (cross * change.real), np.complex128)
                if i == j:
                    force = force + turned[:, i] * around[:, i] * change.imag + relaxing[:, 0] * direction
                result[:, 2 * i, 2 * j + part], result[:, 2 * i + 1, 2 * j + part] = force.real, force.imag
    return result

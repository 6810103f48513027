"""The full equations by Chebyshev collocation: state, and the time integration in ``kernels/flow/spectral.py``."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus, Floats, Matrix, Walls
from autobalancer.flow.chebyshev import Grid, chebyshev_grid
from autobalancer.flow.speed import WallSpeed
from autobalancer.flow.track import Progress, Track
from autobalancer.kernels.flow import spectral as kernel

FIRST = 0.05  # first step over the diffusion time of the narrowest cell
LEAST = 1e-3  # step over the first one, or over a radian of the rotor, that says the flow is not resolved
CHUNK = 2000  # steps between two looks at the progress bar


class SpectralFlow:
    """State and steps on ``radial`` by ``axial`` intervals; ``order`` of the time integration is 1, 2 or 3."""

    def __init__(
        self, annulus: Annulus, radial: int, axial: int, *, walls: Walls | None = None, order: int = 3
    ) -> None:
        self.annulus, self.order = annulus, order
        self.grid = grid = chebyshev_grid(annulus, radial, axial)
        self.radius, self.height = grid.r.points, grid.z.points
        self.walls = (walls or Walls()).momentum(annulus, self.radius, self.height)
        edge = self.walls
        sides = grid.r.walls @ edge[[0, -1], 1:-1] + (grid.z.walls @ edge[1:-1, [0, -1]].T).T
        self._plan = _plan(annulus, grid, annulus.viscosity * grid.forward(sides))
        self._state = _state(radial - 1, axial - 1)
        self._clock = np.zeros(kernel.CLOCK)

    @property
    def swirl(self) -> Matrix:
        """g = r^2 (W - w), m^2/s; (radius, height)."""
        return self._state.g

    @property
    def vorticity(self) -> Matrix:
        """q = r eta, m/s."""
        return self._state.q

    @property
    def stream(self) -> Matrix:
        """psi, m^3/s."""
        return self._state.psi

    def orbit_speed(self) -> float:
        """Angular velocity of the fluid at the orbit relative to the rotor, rad/s."""
        return float(self._plan.orbit_r @ self.swirl @ self._plan.orbit_z)

    def momentum(self, speed: float) -> float:
        """Angular momentum of the fluid at the rotor speed ``speed``, kg m^2/s."""
        total = self.swirl + self.radius[:, None] ** 2 * speed
        weight = self.grid.r.weights * self.radius
        return float(2.0 * np.pi * self.annulus.density * (weight @ total @ self.grid.z.weights))

    def torque(self) -> float:
        """Torque of the walls on the fluid, N m."""
        g, grid, r = self.swirl, self.grid, self.radius
        around = (r[[0, -1], None] * (grid.r.derivative[[0, -1]] @ g) - 2.0 * g[[0, -1]]) @ grid.z.weights
        lids = (grid.r.weights * r) @ (g @ grid.z.derivative[[0, -1]].T)
        turning = around[1] - around[0] + lids[1] - lids[0]
        return float(2.0 * np.pi * self.annulus.density * self.annulus.viscosity * turning)

    def march(
        self,
        speed: WallSpeed,
        end: float,
        *,
        tolerance: float,
        stops: Sequence[float] = (),
        at_stop: Callable[[float], None] = lambda time: None,
        progress: Progress | None = None,
        fixed: float = 0.0,
    ) -> Track:
        """Run from time zero, fluid turning as before, to ``end``.

        A step is as long as the error, the waves in the turning fluid and convection allow:
        length (2 w + |u_r|/dr + |u_z|/dz) <= 0.7.

        Parameters
        ----------
        speed
            Of the walls.
        end
            s.
        tolerance
            Local error of the angular velocity, root mean square over the points, relative to the greatest speed.
        stops
            Times at which ``at_stop`` is called; the fields are then those of this time.
        progress
            Called now and then with time and end.
        fixed
            A step that is kept whatever happens, s; 0 for steps by error.

        Raises
        ------
        QuestionError
            If the grid does not resolve the flow.
        """
        clock, first = self._clock, speed.at(0.0)[0]
        goal = tolerance * max(speed.fastest(end), 1e-300)
        self._begin(first, speed.before)
        narrow = min(float(np.diff(self.radius).min()), float(np.diff(self.height).min()))
        step = min(fixed or FIRST * narrow**2 / self.annulus.viscosity, end)
        clock[kernel.LENGTH] = step
        clock[kernel.LEAST] = LEAST * min(step, 1.0 / max(speed.fastest(end), 1e-300))
        track = Track()
        track.note(0.0, first, speed.before - first)
        if 0.0 in stops:
            at_stop(0.0)
        record, corners = np.empty((CHUNK, 3)), set(speed.corners(end))
        for mark in sorted({*(t for t in stops if 0.0 < t < end), *corners, end}):
            piece = speed.piece(float(clock[kernel.TIME]))
            numbers = np.array(piece.numbers, np.float64)
            while clock[kernel.TIME] < mark:
                done = kernel.march(
                    self._plan, self._state, clock, piece.start, float(piece.kind), numbers, mark, fixed, goal, self.order, record
                )  # fmt: skip
                for time, w, lag in record[:done].tolist():
                    track.note(time, w, lag)
                if clock[kernel.LOST]:
                    raise QuestionError(
                        f"the flow solver cannot pass {clock[kernel.TIME]:.4g} s with steps of {clock[kernel.LENGTH]:.2g} s: "
                        "the flow is not resolved; take more 'points'"
                    )
                if progress is not None:
                    progress(float(clock[kernel.TIME]), end)
            if mark in stops:
                at_stop(mark)
            if mark in corners:  # the rate of the speed jumps, so the past is of no use
                clock[kernel.KNOWN], clock[kernel.LENGTH] = 1.0, step
        track.steps, track.rejected = int(clock[kernel.ACCEPTED]), int(clock[kernel.REJECTED])
        return track

    def _begin(self, speed: float, fluid_speed: float) -> None:
        """Fluid turning as a solid with ``fluid_speed`` between walls that turn with ``speed``."""
        self.swirl[:] = self.walls
        self.swirl[1:-1, 1:-1] = self.radius[1:-1, None] ** 2 * (fluid_speed - speed)
        self.vorticity[:], self.stream[:] = 0.0, 0.0
        self._clock[:] = 0.0
        self._clock[kernel.KNOWN] = 1.0
        kernel.remember(self._plan, self._state, self._clock, speed)


def _plan(annulus: Annulus, grid: Grid, lift: Matrix) -> kernel.Plan:
    r, z = grid.r, grid.z
    c, d = r.forward @ r.walls, z.forward @ z.walls
    p, s = r.derivative[[0, -1], 1:-1] @ r.backward, z.derivative[[0, -1], 1:-1] @ z.backward
    right, left = _corners(c, d, p, s)
    arrays = {
        "radius": r.points[1:-1],
        "space_r": np.gradient(r.points)[1:-1],
        "space_z": np.gradient(z.points)[1:-1],
        "orbit_r": r.values_at(annulus.orbit_radius) / annulus.orbit_radius**2,
        "orbit_z": z.values_at(0.5 * annulus.height),
        "along_r": r.derivative[1:-1],
        "along_z": z.derivative[1:-1].T,
        "r_forward": r.forward,
        "r_backward": r.backward,
        "z_forward": z.forward.T,
        "z_backward": z.backward.T,
        "laplacian": grid.laplacian,
        "c": c,
        "d": d,
        "p": p,
        "s": s,
        "right": right,
        "left": left,
        "lift": lift,
    }
    return kernel.Plan(
        **{key: np.ascontiguousarray(value, np.float64) for key, value in arrays.items()}, viscosity=annulus.viscosity
    )


def _corners(c: Matrix, d: Matrix, p: Matrix, s: Matrix) -> tuple[Matrix, Matrix]:
    """Patterns of wall vorticity that act on no inner point, and combinations of slopes that always vanish."""
    m, n = c.shape[0], d.shape[0]
    right, left = np.zeros((2 * (m + n), 4)), np.zeros((2 * (m + n), 4))
    for corner, (i, j) in enumerate(((0, 0), (0, 1), (1, 0), (1, 1))):
        right[i * n : (i + 1) * n, corner] = d[:, j]
        right[2 * n + j * m : 2 * n + (j + 1) * m, corner] = -c[:, i]
        left[i * n : (i + 1) * n, corner] = s[j]
        left[2 * n + j * m : 2 * n + (j + 1) * m, corner] = -p[i]
    return right, left


def _state(m: int, n: int) -> kernel.State:
    def zeros(*shape: int) -> Floats:
        return np.zeros(shape)

    size = 2 * (m + n)
    return kernel.State(
        g=zeros(m + 2, n + 2),
        q=zeros(m + 2, n + 2),
        psi=zeros(m + 2, n + 2),
        g_past=zeros(5, m, n),
        q_past=zeros(5, m, n),
        g_rate=zeros(5, m, n),
        q_rate=zeros(5, m, n),
        work=zeros(6, m, n),
        a=zeros(m, n),
        b=zeros(m, n),
        f=zeros(m, n),
        scale=zeros(m, n),
        influence=zeros(size, size),
        pivots=zeros(size),
        rows=zeros(size),
        columns=zeros(size),
        unknown=zeros(size),
        weights=zeros(3, 5),
    )

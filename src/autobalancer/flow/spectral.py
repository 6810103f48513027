"""The full equations by Chebyshev collocation: implicit diffusion, explicit convection, exact no slip.

    g_t = nu D2 g - u.grad g + 2 w psi_z - r^2 w'
    q_t = nu D2 q - u.grad q + 2 u_r q/r + (g^2/r^2 + 2 w g)_z,   D2 psi = -q

follow from Spannan 2021, (3.10) to (3.12), with G = g + r^2 w and q = r eta: the large part r^4 w^2 of G^2 drops out, and the
three elliptic operators become one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.flow.annulus import Annulus, Floats, Matrix, Walls
from autobalancer.flow.chebyshev import chebyshev_grid
from autobalancer.flow.multistep import weights_of_step
from autobalancer.flow.no_slip import Influence, traces

KEPT = 8  # influence matrices of the last steps


@dataclass(frozen=True)
class Moment:
    """What the time integration remembers of one instant; at the inner points."""

    length: float  # of the step that led to it, s
    g: Matrix
    q: Matrix
    g_rate: Matrix  # all explicit terms
    q_rate: Matrix


class SpectralFlow:
    """State and steps. ``order`` of the time integration is 1, 2 or 3; the first steps after a restart have less."""

    def __init__(
        self, annulus: Annulus, radial: int, axial: int, *, walls: Walls | None = None, order: int = 3
    ) -> None:
        self.annulus, self.order = annulus, order
        self.grid = grid = chebyshev_grid(annulus, radial, axial)
        self.radius, self.height = grid.r.points, grid.z.points
        self.walls = (walls or Walls()).momentum(annulus, self.radius, self.height)
        nu, edge = annulus.viscosity, self.walls
        self._lift = nu * grid.forward(
            grid.r.walls @ edge[[0, -1], 1:-1] + (grid.z.walls @ edge[1:-1, [0, -1]].T).T
        )
        self._traces = traces(grid)
        self._influences: dict[float, Influence] = {}
        self._r = self.radius[1:-1, None]
        self._dr, self._dz = grid.r.derivative[1:-1], np.ascontiguousarray(grid.z.derivative[1:-1].T)
        self._orbit = grid.r.values_at(annulus.orbit_radius), grid.z.values_at(0.5 * annulus.height)
        self.swirl = np.zeros((radial + 1, axial + 1))
        self.vorticity = np.zeros_like(self.swirl)  # q, not eta
        self.stream = np.zeros_like(self.swirl)
        self.convection = 0.0  # greatest |u_r|/dr + |u_z|/dz, 1/s
        self._space = 1.0 / np.gradient(self.radius)[1:-1, None], 1.0 / np.gradient(self.height)[None, 1:-1]
        self.history: list[Moment] = []

    def begin(self, speed: float, fluid_speed: float) -> None:
        """Fluid turning as a solid with ``fluid_speed`` between walls that turn with ``speed``, rad/s."""
        self.swirl = self.walls.copy()
        self.swirl[1:-1, 1:-1] = self._r**2 * (fluid_speed - speed)
        self.vorticity[:], self.stream[:] = 0.0, 0.0
        self.history = [self._moment(0.0, speed)]

    def restart(self) -> None:
        """Forget the past, because the rate of the speed jumps here."""
        del self.history[1:]

    def step(self, length: float, speed: float, rate: float) -> float:
        """Go on by ``length`` (s) to where the walls turn with ``speed`` and ``rate``.

        Returns
        -------
        float
            Root mean square of the difference to the extrapolated angular velocity, divided as for a local error, rad/s.
            The state is not yet part of the past: call :meth:`accept`, or step again.
        """
        past = self.history[: self.order]
        known = self.history[: len(past) + 1]
        lengths = (length, *(moment.length for moment in known[:-1]))
        slope, ahead, guess = weights_of_step(lengths, len(past))
        g, q = -self._r**2 * rate, np.zeros_like(past[0].q)
        for moment, a, b in zip(past, slope[1:], ahead, strict=True):
            g = g + (b * moment.g_rate - a * moment.g)
            q += b * moment.q_rate - a * moment.q
        grid, solver = self.grid, self._influence(float(slope[0]))
        self._now = length, speed
        self.swirl = self.walls.copy()
        self.swirl[1:-1, 1:-1] = grid.backward((grid.forward(g) + self._lift) * solver.scale)
        q_hat, psi_hat, (x, y) = solver.solve(grid.forward(q))
        self.vorticity[1:-1, 1:-1] = grid.backward(q_hat)
        self.vorticity[[0, -1], 1:-1] = x @ grid.z.backward.T
        self.vorticity[1:-1, [0, -1]] = (y @ grid.r.backward.T).T
        self.stream[1:-1, 1:-1] = grid.backward(psi_hat)
        miss = self.swirl[1:-1, 1:-1] - sum(w * moment.g for w, moment in zip(guess, known, strict=True))
        return float(np.sqrt(np.mean((miss / self._r**2) ** 2))) / (len(past) + 2)

    def accept(self) -> None:
        """Make the last step part of the past."""
        self.history.insert(0, self._moment(*self._now))
        del self.history[self.order + 1 :]

    def orbit_speed(self) -> float:
        """Angular velocity of the fluid at the orbit relative to the rotor, rad/s."""
        return float(self._orbit[0] @ self.swirl @ self._orbit[1]) / self.annulus.orbit_radius**2

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

    def _moment(self, length: float, speed: float) -> Moment:
        g, q, psi, r = self.swirl, self.vorticity, self.stream, self._r
        inner = slice(1, -1)
        fields = np.concatenate([g[:, inner], q[:, inner], psi[:, inner]], axis=1)
        along_r = np.split(self._dr @ fields, 3, axis=1)
        along_z = np.split(np.concatenate([g[inner], q[inner], psi[inner]]) @ self._dz, 3)
        g_z = along_z[0]
        u, v = -along_z[2] / r, along_r[2] / r
        g_in, q_in = g[inner, inner], q[inner, inner]
        self.convection = float((np.abs(u) * self._space[0] + np.abs(v) * self._space[1]).max())
        return Moment(
            length,
            g_in.copy(),
            q_in.copy(),
            2.0 * speed * along_z[2] - u * along_r[0] - v * g_z,
            2.0 * (u * q_in / r + g_in * g_z / r**2 + speed * g_z) - u * along_r[1] - v * along_z[1],
        )

    def _influence(self, shift: float) -> Influence:
        found = self._influences.get(shift)
        if found is None:
            if len(self._influences) >= KEPT:
                del self._influences[next(iter(self._influences))]
            found = Influence(self.grid, self._traces, shift, self.annulus.viscosity)
            self._influences[shift] = found
        return found


def orbit_velocity(flow: SpectralFlow, speed: float) -> Floats:
    """Angular velocity of the fluid over the gap at mid-height, rad/s; (radius,)."""
    return np.asarray(speed + flow.swirl @ flow._orbit[1] / flow.radius**2, np.float64)

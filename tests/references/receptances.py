"""Rotors of several modes with known receptance, their exact linearization with balls, and files of measurements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from autobalancer.measurement.loop import RaceBalls
from autobalancer.rotordynamics.receptances import PoleModel, receptance_dataset


@dataclass(frozen=True)
class Host:
    """M z'' + C z' + K z = B f for forward rotating z; C may be complex (gyroscopic), the race is at B^T z."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    at: np.ndarray

    def receptance(self, frequency: np.ndarray) -> np.ndarray:
        dynamic = (
            -self.mass * frequency[:, None, None] ** 2 + 1j * self.damping * frequency[:, None, None] + self.stiffness
        )
        return np.array([self.at @ np.linalg.solve(one, self.at) for one in dynamic])

    def poles(self) -> PoleModel:
        n = self.at.size
        first = np.zeros((2 * n, 2 * n), complex)
        first[:n, n:] = np.eye(n)
        first[n:, :n], first[n:, n:] = (
            -np.linalg.solve(self.mass, self.stiffness),
            -np.linalg.solve(self.mass, self.damping),
        )
        values, vectors = np.linalg.eig(first)
        drive = np.concatenate([np.zeros(n), np.linalg.solve(self.mass, self.at)])
        return PoleModel(values, (self.at @ vectors[:n]) * np.linalg.solve(vectors, drive))

    def eigenvalues(self, balls: RaceBalls, angles: np.ndarray, speed: float) -> np.ndarray:
        """Of the rotor with these balls on it, written down for the real components in the rotating frame."""
        n, count, w = self.at.size, balls.count, speed
        mass = self.mass + balls.mass.sum() * np.outer(self.at, self.at)
        size = 2 * n + count
        m, c, k = (np.zeros((size, size)) for _ in range(3))

        def put(target: np.ndarray, value: np.ndarray) -> None:
            target[:n, :n], target[:n, n : 2 * n] = value.real, -value.imag
            target[n : 2 * n, :n], target[n : 2 * n, n : 2 * n] = value.imag, value.real

        put(m, mass.astype(complex))
        put(c, 2j * w * mass + self.damping)
        put(k, -(w**2) * mass + 1j * w * self.damping + self.stiffness)
        for i in range(count):
            force = 1j * balls.moment[i] * np.exp(1j * angles[i]) * self.at
            for target, factor in ((m, 1.0), (c, 2j * w), (k, -(w**2))):
                target[:n, 2 * n + i], target[n : 2 * n, 2 * n + i] = (factor * force).real, (factor * force).imag
                felt = factor * balls.moment[i] * np.exp(-1j * angles[i]) * self.at
                target[2 * n + i, :n], target[2 * n + i, n : 2 * n] = felt.imag, felt.real
        m[2 * n :, 2 * n :], c[2 * n :, 2 * n :] = np.diag(balls.inertia), np.diag(balls.drag)
        first = np.zeros((2 * size, 2 * size))
        first[:size, size:] = np.eye(size)
        first[size:, :size], first[size:, size:] = -np.linalg.solve(m, k), -np.linalg.solve(m, c)
        return np.linalg.eigvals(first)


def chain() -> Host:
    """The race on a disc that hangs on a second mass."""
    damping = np.array([[30.0, -22.0], [-22.0, 60.0]])
    stiffness = np.array([[6e4, -5e4], [-5e4, 2.1e5]])
    return Host(np.diag([5.0, 8.0]), damping, stiffness, np.array([1.0, 0.0]))


def tilting(speed: float) -> Host:
    """A rigid rotor with tilt and a heavy disc, race above its mass center; the receptance holds at this speed only."""
    gyroscopic = -1j * speed * np.diag([0.0, 0.09])
    damping = np.array([[60.0, 3.0], [3.0, 0.8]])
    stiffness = np.array([[8e4, 4e3], [4e3, 1.4e3]])
    return Host(np.diag([9.0, 0.06]), damping + gyroscopic, stiffness, np.array([1.0, 0.12]))


def measured(frequency: np.ndarray, values: np.ndarray, noise: float = 0.0, seed: int = 0) -> xr.Dataset:
    """A measurement of these values with multiplicative noise of this size."""
    random = np.random.default_rng(seed).normal(size=(2, frequency.size)) / np.sqrt(2.0)
    return receptance_dataset(
        frequency, values * (1.0 + noise * (random[0] + 1j * random[1])), "receptance", title="test"
    )


def universal_text(
    frequency: np.ndarray,
    values: np.ndarray,
    *,
    motion: int = 12,
    double: bool = False,
    even: bool = True,
    units: str = "",
    motion_unit: str = "",
    directions: tuple[int, int] = (1, 1),
) -> str:
    """A universal file with one frequency response in dataset 58; frequencies in Hz."""
    head = ["    -1", "    58", "hammer on the race", "NONE", "01-Jan-24 12:00:00", "NONE", "NONE"]
    place = f"{'NONE':>10}{7:10d}{directions[0]:4d}", f"{'NONE':>10}{7:10d}{directions[1]:4d}"
    head.append(f"{4:5d}{1:10d}{0:5d}{0:10d} {place[0]} {place[1]}")
    step = frequency[1] - frequency[0] if even else 0.0
    head.append(
        f"{6 if double else 5:10d}{frequency.size:10d}{int(even):10d}{frequency[0] * even:13.5E}{step:13.5E}{0.0:13.5E}"
    )
    for kind, name, unit in (
        (18, "Frequency", "Hz"),
        (motion, "Response", motion_unit),
        (13, "Force", ""),
        (0, "NONE", ""),
    ):
        head.append(f"{kind:10d}{0:5d}{0:5d}{0:5d} {name:20s} {unit:20s}")
    cells = []
    for f, value in zip(frequency, values, strict=True):
        row = [] if even else [f"{f:13.5E}"]
        cells += row + [f"{part:20.12E}" if double else f"{part:13.5E}" for part in (value.real, value.imag)]
    per_line = (4 if even else 3) if double else 6
    data = ["".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line)]
    return "\n".join([*([units] if units else []), *head, *data, "    -1", ""])


def planar_model(mass: float, damping: float, stiffness: float, added_mass: float = 0.0) -> PoleModel:
    """The receptance 1/(M sigma^2 + b sigma + k) of a planar rotor."""
    poles = np.roots([mass, damping, stiffness]).astype(np.complex128)
    residues = np.array([1.0, -1.0]) / (mass * (poles[0] - poles[1]))
    return PoleModel(poles, residues.astype(np.complex128), added_mass)


def accelerance(frequency: np.ndarray, values: np.ndarray, floor: float, share: float, seed: int) -> xr.Dataset:
    """An accelerometer's measurement of a receptance: noise of a floor (m/s^2/N) and of a share of each value."""
    random = np.random.default_rng(seed)
    even, own = (random.normal(size=(2, frequency.size)).T.copy().view(complex)[:, 0] / np.sqrt(2.0) for _ in range(2))
    heard = -(frequency**2) * values * (1.0 + share * own) + floor * even
    return receptance_dataset(frequency, heard, "accelerance", title="accelerometer")

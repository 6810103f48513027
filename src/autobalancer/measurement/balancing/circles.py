"""Runs without phase as circles in the plane of masses.

With a mass w on the rotor the amplitude is A = h |w - c|, c being the correction that brings the rotor to rest and h what a
unit of mass does. So c lies on a circle of radius A / h around each w, the run without trial mass among them (w = 0). Three
unknowns (h and the two parts of c) need three runs, which two points satisfy; a fourth one, off their line, decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
STEPS, CLOSE = 60, 1e-12
DIRECTIONS = 24  # of the starts of the search


@dataclass(frozen=True)
class Meeting:
    """A point in which circles meet: correction c, sensitivity h, covariance (3, 3) of h and both parts of c, and the misfit, the
    sum of squares of readings less prediction in standard deviations.
    """

    correction: complex
    sensitivity: float
    covariance: Floats
    misfit: float
    missed: Floats  # (R,), in standard deviations


def closed_form(amplitudes: Floats, masses: Complexes) -> tuple[complex, float] | None:
    """c and h from four runs or more whose masses are not on one circle or line through them: linear in h^2, h^2 c and h^2 |c|^2.

    None where the runs do not determine them, or h^2 is not above zero.
    """
    rows = np.column_stack([np.abs(masses) ** 2, -2.0 * masses.real, -2.0 * masses.imag, np.ones(masses.size)])
    size = np.abs(masses).max()
    scale = np.array([size**2, size, size, 1.0])
    found, _, rank, _ = np.linalg.lstsq(rows / scale, amplitudes**2, rcond=1e-9)
    if rank < 4:
        return None
    square, x, y, _ = found / scale
    return (complex(x, y) / square, float(np.sqrt(square))) if square > 0.0 else None


def meetings(amplitudes: Floats, masses: Complexes, sure: Floats) -> list[Meeting]:
    """All points in which the circles meet best, the best one first: minima of the weighted squares from starts all around."""
    starts: list[tuple[complex, float]] = []
    first = closed_form(amplitudes, masses)
    if first is not None:
        starts.append(first)
    step = float(np.abs(masses).max())
    for far in (0.3, 1.0, 3.0, 10.0):
        for angle in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
            place = far * step * np.exp(1j * angle)
            starts.append((place, float(amplitudes.sum() / np.abs(masses - place).sum())))
    found: list[Meeting] = []
    for one in _minima(amplitudes, masses, sure, np.array([[s.real, s.imag, h] for s, h in starts]), step):
        apart = [abs(one.correction - other.correction) for other in found]
        if not apart or min(apart) > 1e-4 * max(step, abs(one.correction)):
            found.append(one)
    return sorted(found, key=lambda one: one.misfit)


def _minima(amplitudes: Floats, masses: Complexes, sure: Floats, starts: Floats, step: float) -> list[Meeting]:
    """Damped Gauss-Newton from all starts at once; those that end at a minimum."""
    scale = np.array([step, step, amplitudes.max() / step])
    u = starts / scale
    damping = np.full(len(u), 1e-3)
    missed, rows = _rows(u * scale, amplitudes, masses, sure)
    rows = rows * scale
    cost = (missed**2).sum(axis=1)
    for _ in range(STEPS):
        normal = rows.transpose(0, 2, 1) @ rows
        slope = (rows.transpose(0, 2, 1) @ missed[..., None])[..., 0]
        diagonal = np.einsum("nii->ni", normal)
        matrix = (
            normal
            + damping[:, None, None] * np.eye(3) * (diagonal + 1e-12 * diagonal.max(axis=1, keepdims=True))[:, None, :]
        )
        change = np.linalg.solve(matrix, -slope[..., None])[..., 0]
        tried = u + change
        new_missed, new_rows = _rows(tried * scale, amplitudes, masses, sure)
        new_cost = (new_missed**2).sum(axis=1)
        better = new_cost <= cost
        u = np.where(better[:, None], tried, u)
        missed = np.where(better[:, None], new_missed, missed)
        rows = np.where(better[:, None, None], new_rows * scale, rows)
        cost = np.where(better, new_cost, cost)
        damping = np.clip(np.where(better, 0.2 * damping, 8.0 * damping), 1e-12, 1e8)
        if np.abs(change).max() < CLOSE:
            break
    found = []
    for n in range(len(u)):
        normal = rows[n].T @ rows[n]
        slope = np.abs(rows[n].T @ missed[n])
        flat = slope <= 1e-5 * (1.0 + np.linalg.norm(rows[n], axis=0) * np.sqrt(cost[n]))
        if flat.all() and u[n, 2] > 0.0:
            c = complex(*(u[n, :2] * scale[:2]))
            covariance = np.linalg.pinv(normal) * np.outer(scale, scale)
            found.append(Meeting(c, float(u[n, 2] * scale[2]), covariance, float(cost[n]), missed[n]))
    return sorted(found, key=lambda one: one.misfit)


def _rows(u: Floats, amplitudes: Floats, masses: Complexes, sure: Floats) -> tuple[Floats, Floats]:
    """Prediction less reading in deviations, (N, R), and its derivatives by both parts of c and h, (N, R, 3)."""
    way = u[:, 0, None] + 1j * u[:, 1, None] - masses
    far = np.maximum(np.abs(way), 1e-300)
    h = u[:, 2, None]
    rows = np.stack([h * way.real / far, h * way.imag / far, far], axis=2) / sure[:, None]
    return (h * far - amplitudes) / sure, rows


def refuse_places(masses: Complexes, runs: tuple[str, ...], owner: str) -> None:
    """Refuse runs with one mass at one place, and too few of them.

    Raises
    ------
    QuestionError
        It names the runs.
    """
    step = np.abs(masses).max()
    if step == 0.0:
        raise QuestionError(
            f"{owner}: no run has a trial mass; make one run without and three with it, at three places"
        )
    for i in range(masses.size):
        for j in range(i):
            if abs(masses[i] - masses[j]) < 1e-6 * step:
                raise QuestionError(
                    f"{owner}: runs {runs[j]!r} and {runs[i]!r} have the same mass at the same place; move it, best by 120 deg"
                )
    if masses.size < 3:
        raise QuestionError(
            f"{owner}: given {masses.size} runs; without phases at least three are needed, and four decide"
        )


def on_a_line(masses: Complexes) -> bool:
    """Whether all masses lie on one straight line, so that a point and its mirror image do equally well."""
    apart = masses[1:] - masses[0]
    way = apart[int(np.argmax(np.abs(apart)))]
    return bool(np.abs((apart * np.conj(way)).imag).max() < 1e-6 * abs(way) ** 2)

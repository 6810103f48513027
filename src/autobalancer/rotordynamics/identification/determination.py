"""How well measurements determine parameters: singular values, standard uncertainties, correlation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Floats
from autobalancer.rotordynamics.identification.free import Unknown

WEAK = 0.5  # standard uncertainty of a combination, relative to the values, above which a note says so
LIKE = 0.98  # correlation above which two parameters are hardly told apart
PART = 0.1  # of a direction: smaller parts are not named


@dataclass(frozen=True)
class Determination:
    """Standard uncertainties (inf where undetermined, nan at a bound), correlation and the directions of the data."""

    uncertainty: Floats
    correlation: Floats
    singular: Floats  # (p,) of the weighted Jacobian over relative changes, descending
    directions: Floats  # (p, p) one per row
    rank: int
    notes: list[str]


def determination(
    unknowns: list[Unknown], values: Floats, jacobian: Floats, at_bound: np.ndarray, no_effect: float = 1e-7
) -> Determination:
    """From the weighted Jacobian of the residuals (rows, p) over the search variables.

    Singular values below ``no_effect`` of the greatest one are errors of its differences.
    """
    count = len(unknowns)
    free = np.flatnonzero(~at_bound)
    singular, directions = np.zeros(count), np.zeros((count, count))
    uncertainty, correlation = np.full(count, np.nan), np.full((count, count), np.nan)
    notes = [
        f"{unknowns[i].name} lies at its bound, {values[i]:.6g} {unknowns[i].unit}" for i in np.flatnonzero(at_bound)
    ]
    if free.size == 0:
        return Determination(uncertainty, correlation, singular, directions, 0, notes)
    padded = np.vstack([jacobian[:, free], np.zeros((max(0, free.size - jacobian.shape[0]), free.size))])
    _, found, rows = np.linalg.svd(padded, full_matrices=False)
    singular[: free.size], directions[: free.size, free] = found, rows
    rank = int(np.sum(found > no_effect * max(found[0], 1e-300)))
    names = [unknowns[i].name for i in free]
    lost = np.abs(rows[rank:]).max(axis=0, initial=0.0) > 1e-3
    inverse = rows[:rank].T / found[:rank]
    covariance = inverse @ inverse.T
    deviation = np.sqrt(np.diag(covariance))
    slopes = np.array([abs(unknowns[i].slope(values[i])) for i in free])
    uncertainty[free] = np.where(lost, np.inf, deviation * slopes)
    with np.errstate(divide="ignore", invalid="ignore"):
        related = covariance / np.outer(deviation, deviation)
    related[lost, :] = related[:, lost] = np.nan
    correlation[np.ix_(free, free)] = related * np.outer(*[np.sign([unknowns[i].slope(values[i]) for i in free])] * 2)
    for row in rows[rank:]:
        notes.append(f"the data do not determine {_combination(row, names)}; fix one of them, or measure more")
    for size, row in zip(found[:rank], rows[:rank], strict=True):
        if 1.0 / size > WEAK:
            notes.append(f"hardly determined, within {100.0 / size:.0f} %: {_combination(row, names)}")
    pairs = [(a, b) for a in range(free.size) for b in range(a) if abs(related[a, b]) > LIKE]
    notes += [
        f"{names[b]} and {names[a]} can hardly be distinguished: correlation {related[a, b]:.4f}" for a, b in pairs
    ]
    return Determination(uncertainty, correlation, singular, directions, rank, notes)


def _combination(direction: Floats, names: list[str]) -> str:
    turned = direction * np.sign(direction[np.argmax(np.abs(direction))])
    parts = [(part, name) for part, name in zip(turned, names, strict=True) if abs(part) > PART]
    if len(parts) == 1:
        return parts[0][1]
    text = " ".join(f"{'+' if part > 0 else '-'} {abs(part):.2f} {name}" for part, name in parts)
    return f"the joint relative change {text.removeprefix('+ ')}"

"""Fewer coordinates: one criterion for runs and for stability, :func:`fewest`, and those for integration in time.

These are modes of the rotor at rest, with the deflection at one place in front. The new coordinates r are the deflection (X, Y)
at the reference place and combinations of modes orthogonal to it, in the same unit. On an isotropic rotor they come in pairs
(x, y), so that turning the machine turns each pair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows
from autobalancer.errors import MachineError

FREQUENCIES = 48  # at which the receptances of both models are compared
AIM = 1e-3  # error of the receptance at which no further mode is added, for runs and for stability
AT_ONCE = 200_000  # entries of matrices that are solved at once
FEW = 6  # so many pairs are kept without asking


@dataclass(frozen=True)
class Reduction:
    """q = ``basis`` r."""

    basis: Matrix  # (N, R)
    error: float  # greatest relative error of the receptance at the places, up to ``top`` rad/s
    top: float
    kept: int
    total: int


class Tried(NamedTuple):
    """A basis over the coordinates along x or over all, the same over all, and the answers of the rotor in it."""

    basis: Matrix
    whole: Matrix
    small: Complexes | None


class Reducer:
    """Modes of one rotor that carry the motion at places under forces there, for any unbalance loads.

    Parameters
    ----------
    front
        The place whose deflection comes first.
    places
        Rows along x of all places, (P, pairs).
    top
        Greatest speed, rad/s.
    wanted
        Number of modes (of pairs on isotropic supports); ``None`` takes as many as bring the error below 1e-3.
    isotropic
        Whether x and y are alike, and so modes come in pairs without motion along the axis or about it.
    """

    def __init__(
        self, model: LateralModel, front: Rows, places: Matrix, top: float, wanted: int | None, *, isotropic: bool
    ) -> None:
        from scipy.linalg import eigh

        self._model, self._wanted, self._isotropic = model, wanted, isotropic
        self._top = float(min(top, model.top_speed))
        n = model.pairs
        stiffness = model.stiffness_at(0.0)
        stiffness = 0.5 * (stiffness + stiffness.T)
        mass = model.mass
        if isotropic:
            stiffness, mass = stiffness[:n, :n], mass[:n, :n]
        _, self._modes = eigh(stiffness, mass)
        self._ahead = _ahead(front, n if isotropic else model.size, isotropic, n)
        self._answers = Answers(model, places, self._top)
        self._coming, self._lock = self._bases(), Lock()
        self._tried: list[Tried] = []

    def carrying(self, loads: Complexes) -> Reduction:
        """The modes for unbalance loads, (pairs,).

        Raises
        ------
        MachineError
            If the modes that are wanted cannot move the places.
        """
        result = None
        with self._lock:
            for candidate in self._candidates():
                result = candidate, self._answers.error_of(candidate.basis, candidate.small, loads)
                if result[1] <= AIM:
                    break
        if result is None:
            text = f"rotor.modes: given {self._wanted}; too few modes to move the plane of the balancer in x and y"
            raise MachineError(text)
        candidate, error = result
        return Reduction(candidate.whole, error, self._top, candidate.basis.shape[1], self._modes.shape[1])

    def _candidates(self) -> Iterator[Tried]:
        """Bases, fewest modes first; what was tried for other loads is kept."""
        yield from self._tried
        for basis in self._coming:
            whole = _paired(basis, self._model) if self._isotropic else basis
            self._tried.append(Tried(basis, whole, self._answers.reduced(basis)))
            yield self._tried[-1]

    def _bases(self) -> Iterator[Matrix]:
        total, isotropic = self._modes.shape[1], self._isotropic
        if self._wanted is not None:
            if self._wanted < 1:
                raise MachineError(f"rotor.modes: given {self._wanted}; at least 1 is needed")
            counts = [min(self._wanted if isotropic else 2 * self._wanted, total)]
        else:
            few = min(total, FEW if isotropic else 2 * FEW)
            counts = [total] if total <= few else [*range(few // 2, total, 1 if isotropic else 2), total]
        for count in counts:
            chosen = self._modes[:, :count]
            seen = self._ahead @ chosen
            movable = np.linalg.matrix_rank(seen, tol=1e-9 * np.abs(seen).max(initial=1e-300)) == seen.shape[0]
            if count >= (1 if isotropic else 2) and movable:
                # combine modes so that the first coordinates are what is seen of them
                from scipy.linalg import null_space

                size = float(np.exp(np.log(np.linalg.norm(seen, axis=1)).mean()))
                forward = np.vstack([seen, size * null_space(seen).T])
                yield np.asarray(chosen @ np.linalg.inv(forward))


def _ahead(front: Rows, size: int, isotropic: bool, pairs: int) -> Matrix:
    if isotropic:
        return front.deflection[None]
    rows = np.zeros((2, size))
    rows[0, :pairs] = front.deflection
    rows[1, pairs : 2 * pairs] = front.deflection
    return rows


def _paired(basis: Matrix, model: LateralModel) -> Matrix:
    n, count = basis.shape
    both = np.zeros((model.size, 2 * count))
    both[:n, 0::2] = basis
    both[n : 2 * n, 1::2] = basis
    return both


def fewest(
    model: LateralModel, candidates: Iterable[Matrix], places: Matrix, loads: Complexes, top: float
) -> tuple[Matrix, float] | None:
    """The first of several bases whose error (:meth:`Answers.error_of`) is below 1e-3, else the last, and its error."""
    modes, answers = None, Answers(model, places, top)
    for basis in candidates:
        modes = basis, answers.error_of(basis, answers.reduced(basis), loads)
        if modes[1] <= AIM:
            break
    return modes


class Answers:
    """How places (P, pairs) of a rotor move under any force e^(i w t) on it, at speeds up to ``top``.

    These are rows times the inverse of its dynamic matrix: on isotropic rotors of forward and backward whirl, (2, S, P, pairs),
    unless a basis knows other directions, too; else of the ellipses of all coordinates, (1, S, 2 P, N).
    """

    def __init__(self, model: LateralModel, places: Matrix, top: float) -> None:
        self._model, self._places = model, places
        self._speeds = np.linspace(0.0, top, FREQUENCIES + 1)[1:]
        self._whole: dict[bool, tuple[Complexes, NDArray[np.bool_]]] = {}

    def reduced(self, basis: Matrix) -> Complexes | None:
        """The same of the rotor in the coordinates of a basis; None of all coordinates, infinite where its matrix is singular."""
        if basis.shape[0] == basis.shape[1]:
            return None
        whirls = self._whirls(basis)
        rows, regular = _inverse_rows(
            self._linear(whirls).over(basis), self._speeds, self._seen(whirls) @ basis, whirls
        )
        rows = rows @ basis.T
        rows[~regular] = np.inf
        return np.asarray(rows)

    def error_of(self, basis: Matrix, small: Complexes | None, loads: Complexes) -> float:
        """Greatest relative error of what forces at the places, and the unbalance, move there in a basis with answers ``small``.

        The basis is over all coordinates, (N, R), or, on isotropic rotors, over those along x, (pairs, r). An unbalance that
        hardly moves the places is compared with what a force of its size does. All coordinates have no error. A speed at which
        the matrix of the whole rotor is singular, a critical one without damping, does not count, since nothing is determined
        there; where only that of the reduced rotor is, the error is infinite.
        """
        if small is None:
            return 0.0
        whirls = self._whirls(basis)
        if whirls not in self._whole:
            self._whole[whirls] = _inverse_rows(self._linear(whirls), self._speeds, self._seen(whirls), whirls)
        whole, regular = self._whole[whirls]
        if not np.isfinite(small[:, regular.all(axis=0)]).all():
            return float(np.inf)
        whole, small = whole[:, regular.all(axis=0)], small[:, regular.all(axis=0)]
        share = float(np.abs(loads).max(initial=0.0)) / max(float(np.abs(self._places).max(initial=0.0)), 1e-300)
        pushed = self._seen(whirls).T
        load = np.sqrt(2.0) * loads if whirls else circular(self._model, loads)
        apart, size = (_sizes(rows @ pushed) for rows in (whole - small, whole))
        of_load, load_size = (_sizes(rows[:1] @ load[:, None]) for rows in (whole - small, whole))  # backward: none
        worst = 0.0
        for error, norm in ((apart, size), (of_load, np.maximum(load_size, share * size))):
            worst = max(worst, float((error[norm > 0.0] / norm[norm > 0.0]).max(initial=0.0)))
        return worst

    def _whirls(self, basis: Matrix) -> bool:
        return self._model.isotropic and basis.shape[0] == self._model.pairs

    def _seen(self, whirls: bool) -> Matrix:
        return self._places if whirls else self._model.both(self._places)

    def _linear(self, whirls: bool) -> _Linear:
        m, n = self._model, self._model.pairs
        parts: list[Any] = [m.mass, m.gyroscopic, m.damping, m.stiffness]
        if whirls:
            parts = [part[..., :n, :n] + 1j * part[..., n : 2 * n, :n] for part in parts]
        return _Linear(m.speeds, *parts)


class _Linear(NamedTuple):
    """Matrices of a rotor, or of one in fewer coordinates; real, or complex over x + i y."""

    speeds: Floats
    mass: Any
    gyroscopic: Any
    damping: Any  # (k, N, N)
    stiffness: Any

    def over(self, basis: Matrix) -> _Linear:
        """The same in the coordinates of a basis."""
        return _Linear(self.speeds, *(basis.T @ part @ basis for part in self[1:]))

    def dynamic(self, speeds: Floats, way: float) -> Complexes:
        """K + i w (C + W G) - w^2 M at frequencies w = ``way`` W, (S, N, N)."""
        shares = np.array([np.interp(speeds, self.speeds, row) for row in np.eye(self.speeds.size)]).T
        w, turn = speeds[:, None], 1j * way
        factors = np.hstack([shares, turn * w * shares, turn * w**2, -(w**2)])
        parts = np.concatenate([self.stiffness, self.damping, self.gyroscopic[None], self.mass[None]])
        return np.asarray((factors @ parts.reshape(factors.shape[1], -1)).reshape(-1, *self.mass.shape))


def _inverse_rows(linear: _Linear, speeds: Floats, seen: Matrix, whirls: bool) -> tuple[Complexes, NDArray[np.bool_]]:
    """``seen`` times the inverse of the dynamic matrix, (ways, S, P, N), and where that is not singular, (ways, S)."""
    ways, size = (1.0, -1.0) if whirls else (1.0,), linear.mass.shape[0]
    rows = np.zeros((len(ways), speeds.size, *seen.shape), np.complex128)
    regular = np.ones((len(ways), speeds.size), np.bool_)
    step = max(1, AT_ONCE // size**2)
    for number, way in enumerate(ways):
        for first in range(0, speeds.size, step):
            part = slice(first, first + step)
            turned = linear.dynamic(speeds[part], way).swapaxes(1, 2)
            try:
                rows[number, part] = np.linalg.solve(turned, seen.T.astype(np.complex128)).swapaxes(1, 2)
            except np.linalg.LinAlgError:
                for i, matrix in enumerate(turned, first):
                    try:
                        rows[number, i] = np.linalg.solve(matrix, seen.T.astype(np.complex128)).T
                    except np.linalg.LinAlgError:
                        regular[number, i] = False
    return rows, regular


def _sizes(answers: Complexes) -> Floats:
    """Of the answers at each speed."""
    return np.asarray(np.sqrt((np.abs(answers) ** 2).sum(axis=(0, 2, 3))), np.float64)


def circular(model: LateralModel, loads: Complexes) -> Complexes:
    """An unbalance load (pairs,) as a force e^(i w t) on all coordinates: u along x and -i u along y."""
    force = np.zeros(model.size, np.complex128)
    force[: model.pairs] = loads
    force[model.pairs : 2 * model.pairs] = -1j * loads
    return force

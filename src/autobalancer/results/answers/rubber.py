"""What a fit of rubber found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Friction, Motion, RubberLaw, friction_stiffness
from autobalancer.machine import Rubber, RubberFriction, RubberRelaxation
from autobalancer.tables import Column, html_table, text_table

Floats = NDArray[np.float64]
FAR = 3.0  # standard deviations from which a point is named


@dataclass(frozen=True, repr=False)
class RubberFit:
    """Fitted rubber: ``law`` in numbers, ``rubber`` for a machine, the points, and how sure it is.

    ``limits`` are all breakaway amplitudes that were tried (m), ``times`` the relaxation times (s), ``covariance`` that of
    elastic, viscous, friction and Maxwell elements in this order; ``freedom`` counts points less free unknowns.
    """

    law: RubberLaw
    points: RubberPoints
    limits: tuple[float, ...]
    times: tuple[float, ...]
    covariance: Floats
    freedom: int

    @property
    def rubber(self) -> Rubber:
        """The part of a machine."""
        friction, maxwell = self.law.friction, self.law.maxwell
        return Rubber(
            stiffness=self.law.elastic,
            damping=self.law.viscous,
            friction=RubberFriction(
                law=self.law.law,
                breakaway_amplitude=tuple(a for _, a in friction),
                stiffness=tuple(k for k, _ in friction),
            ),
            maxwell=RubberRelaxation(
                relaxation_time=tuple(t for _, t in maxwell), stiffness=tuple(k for k, _ in maxwell)
            )
            if maxwell
            else None,
        )

    def stiffness(
        self, amplitude: ArrayLike, frequency: ArrayLike, motion: Motion = "circle"
    ) -> NDArray[np.complex128]:
        """K (N/m) at ``amplitude`` (m) and ``frequency`` (rad/s) in a ``motion``, within what was measured.

        Raises
        ------
        QuestionError
            Beyond it; ``law.stiffness`` extrapolates.
        """
        for name, given, factor, unit in (
            ("amplitude", amplitude, 1e3, "mm"),
            ("frequency", frequency, 0.5 / np.pi, "Hz"),
        ):
            measured, value = getattr(self.points, name), np.asarray(given, dtype=float)
            if name == "frequency" and not self.times and not np.any(value < 0.0):
                continue  # the fitted rubber has no frequency in it but the viscous part
            low, high = float(measured.min()), float(measured.max())
            if np.any(value < low * (1.0 - 1e-9)) or np.any(value > high * (1.0 + 1e-9)):
                raise QuestionError(
                    f"rubber: {name}: given {factor * value.min():.4g} to {factor * value.max():.4g} {unit}, but measured was "
                    f"{factor * low:.4g} to {factor * high:.4g} {unit}; this would extrapolate. Measure there, or ask "
                    "law.stiffness(...), which extrapolates"
                )
        return self.law.stiffness(amplitude, frequency, motion)

    def uncertainty(
        self, amplitude: ArrayLike, frequency: ArrayLike, motion: Motion = "circle"
    ) -> tuple[Floats, Floats]:
        """Standard deviations of K' and K'' (N/m) at ``amplitude`` (m) and ``frequency`` (rad/s) in a ``motion``."""
        a, w = np.broadcast_arrays(*(np.asarray(one, dtype=float) for one in (amplitude, frequency)))
        rows = element_columns(w.ravel(), a.ravel(), [motion] * a.size, np.array(self.limits), self.times, self.law.law)
        real, imaginary = (
            np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", part, self.covariance, part), 0.0)).reshape(a.shape)
            for part in (rows.real, rows.imag)
        )
        return np.asarray(real), np.asarray(imaginary)

    @property
    def fitted(self) -> NDArray[np.complex128]:
        """K at the points, N/m."""
        found = np.empty(len(self.points), np.complex128)
        for i, motion in enumerate(self.points.motion):
            found[i] = self.law.stiffness(self.points.amplitude[i], self.points.frequency[i], motion)
        return found

    @property
    def remarks(self) -> tuple[str, ...]:
        """Points that do not agree with the rest, and what the rubber does beyond them."""
        said = []
        fitted = self.fitted
        for i, name in enumerate(self.points.names):
            for what, value in (("stiffness", fitted[i].real), ("loss", fitted[i].imag)):
                measured = float(getattr(self.points, what)[i])
                sure = float(getattr(self.points, f"{what}_uncertainty")[i])
                if abs(value - measured) > FAR * sure:  # not if it is nan
                    said.append(
                        f"{name}: {what} {measured:.4g} N/m, but the rubber that suits all points best has {value:.4g}, "
                        f"{abs(value - measured) / sure:.2g} standard deviations away; these targets contradict each other"
                    )
        largest = float(self.points.amplitude.max())
        said.append(f"above {1e3 * largest:.3g} mm nothing was measured; elements there continue those below")
        return tuple(said)

    def toml(self, place: str = "rotor.rubber") -> str:
        """The lines of a machine file, as the table ``place``."""
        law = self.law
        lines = [f"[{place}]", f'stiffness = "{law.elastic:.6g} N/m"', f'damping = "{law.viscous:.6g} N*s/m"']
        lines += ["", f"[{place}.friction]", f'law = "{law.law}"']
        lines += [f"breakaway_amplitude = {_listed([1e3 * a for _, a in law.friction], 'mm')}"]
        lines += [f"stiffness = {_listed([k for k, _ in law.friction], 'N/m')}"]
        if law.maxwell:
            lines += ["", f"[{place}.maxwell]", f"relaxation_time = {_listed([1e3 * t for _, t in law.maxwell], 'ms')}"]
            lines += [f"stiffness = {_listed([k for k, _ in law.maxwell], 'N/m')}"]
        return "\n".join(lines) + "\n"

    def columns(self) -> list[Column]:
        """Elements with their uncertainty, for tables."""
        sure = np.sqrt(np.diag(self.covariance))
        index = {limit: 2 + i for i, limit in enumerate(self.limits)}
        last = {time: 2 + len(self.limits) + i for i, time in enumerate(self.times)}
        rows: list[tuple[str, float, str, float]] = [
            ("elastic", self.law.elastic, "N/m", float(sure[0])),
            ("viscous", self.law.viscous, "N s/m", float(sure[1])),
        ]
        rows += [(f"friction, {1e3 * a:.4g} mm", k, "N/m", float(sure[index[a]])) for k, a in self.law.friction]
        rows += [(f"Maxwell, {1e3 * t:.4g} ms", k, "N/m", float(sure[last[t]])) for k, t in self.law.maxwell]
        return [
            Column("element", [row[0] for row in rows]),
            Column("value", [row[1] for row in rows], form=".5g"),
            Column("uncertainty", [row[3] for row in rows], form=".2g"),
            Column("unit", [row[2] for row in rows]),
        ]

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        columns = self.columns()
        return [column.head for column in columns], [
            list(row) for row in zip(*(c.cells() for c in columns), strict=True)
        ]

    def __repr__(self) -> str:
        head, rows = self._cells()
        return "\n".join([f"rubber, {self.law.law}", text_table(head, rows), *self.remarks])

    def _repr_html_(self) -> str:
        head, rows = self._cells()
        return html_table(head, rows, f"rubber, {self.law.law}")


def _listed(values: Sequence[float], unit: str) -> str:
    return "[" + ", ".join(f'"{value:.6g} {unit}"' for value in values) + "]"


def element_columns(
    frequency: Floats, amplitude: Floats, motion: Sequence[str], limits: Floats, times: Sequence[float], law: Friction
) -> NDArray[np.complex128]:
    """K of each element of stiffness one (of the viscous one, damping one): (points, 2 + elements + Maxwell elements)."""
    w, a = np.asarray(frequency), np.asarray(amplitude)
    found = np.zeros((w.size, 2 + limits.size + len(times)), np.complex128)
    found[:, 0], found[:, 1] = 1.0, 1j * w
    circle = np.array([one == "circle" for one in motion])
    for column, limit in enumerate(limits, 2):
        for mask, name in ((circle, "circle"), (~circle, "line")):
            if mask.any():
                found[mask, column] = friction_stiffness(a[mask] / limit, law, "circle" if name == "circle" else "line")
    for column, tau in enumerate(times, 2 + limits.size):
        found[:, column] = 1j * w * tau / (1.0 + 1j * w * tau)
    return found


# Measured stiffness and loss of rubber.


@dataclass(frozen=True)
class RubberPoints:
    """Complex stiffness K' + i K'' of rubber at n points, SI; arrays of shape (n,).

    ``frequency`` rad/s, ``amplitude`` m, ``stiffness`` K' and ``loss`` K'' N/m (nan where it was not measured), their standard
    uncertainties, N/m; ``motion`` circle or line, ``kind`` loop or resonance, ``names`` for messages.
    """

    frequency: Floats
    amplitude: Floats
    stiffness: Floats
    loss: Floats
    stiffness_uncertainty: Floats
    loss_uncertainty: Floats
    motion: tuple[Motion, ...]
    kind: tuple[str, ...]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return self.frequency.size


def joined(parts: list[RubberPoints]) -> RubberPoints:
    """All points in one."""

    def array(name: str) -> Floats:
        return np.concatenate([getattr(part, name) for part in parts])

    return RubberPoints(
        array("frequency"),
        array("amplitude"),
        array("stiffness"),
        array("loss"),
        array("stiffness_uncertainty"),
        array("loss_uncertainty"),
        tuple(one for part in parts for one in part.motion),
        tuple(one for part in parts for one in part.kind),
        tuple(one for part in parts for one in part.names),
    )

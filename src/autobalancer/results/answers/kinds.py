"""What shows an answer of which kind: a file keeps its name, and what is read back shows itself as before."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from importlib import import_module
from itertools import chain, product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Friction, Motion, RubberLaw, friction_stiffness
from autobalancer.machine import Rubber, RubberFriction, RubberRelaxation
from autobalancer.machine_kinds import machine_kind
from autobalancer.results.answers.answer import FORMS, UNKNOWN, Answer, Form
from autobalancer.results.display_units import length_axis, measure_unit, speed_axis
from autobalancer.tables import Column, html_table, text_table

PACKAGE = "autobalancer"
HOMES = {  # of kinds that are a class, modules, some of them above this one, imported when such an answer is read
    "Branches": "stability.curve_explorer",
    "ChamberRun": "simulation.chamber.chamber_run",
    "Designed": "studies.design.designs",
    "Ends": "results.answers.studied",
    "Ensemble": "results.answers.studied",
    "Labeled": "results.answers.answer",
    "LiquidResponse": "rotordynamics.liquid",
    "Orders": "results.signals",
    "RaceShape": "measurement.race_measurements",
    "Run": "results.answers.run",
    "Signals": "results.signals",
    "Spectrum": "results.signals",
    "SteppedResponse": "results.answers.run",
    "Studied": "results.answers.studied",
}


def as_kind(dataset: xr.Dataset, kind: str) -> xr.Dataset:
    """The same data as an answer of that name; of a name that this version does not know, a plain dataset.

    Runs of earlier versions, which kept no name, are recognized.
    """
    if not kind and "outcome_text" in dataset.attrs:
        kind = machine_kind(dataset).run
    if kind not in HOMES:
        answer = Answer.of(dataset, kind)
        return answer if answer.form() is not UNKNOWN else dataset
    home: type[Answer] = getattr(import_module(f"{PACKAGE}.{HOMES[kind]}"), kind)
    return home.of(dataset)


# The measures of a run as a table: one row for each number.


def _numbers(found: Answer, unit: str) -> list[Column]:
    """Name, of what where there are several, value, unit and meaning, which is shown at the first number of a measure."""
    rows = [row for entry in found.data_vars.values() for row in _rows(entry, unit or "rpm")]
    heads = ("measure", "of", "value", "unit", "meaning")
    last = len(heads) - 1
    return [Column(head, [row[k] for row in rows], wraps=k == last, once=k == last) for k, head in enumerate(heads)]


FORMS["Measured"] = Form(
    _numbers,
    there=lambda it: (
        bool(it.data_vars) and all({"units", "long_name"} <= set(entry.attrs) for entry in it.data_vars.values())
    ),
    heading=lambda it: f"{it.attrs.get('machine_name', 'run')}: {it.attrs.get('outcome_text', 'measures')}",
    most=200,
)


def _rows(entry: xr.DataArray, speed_unit: str) -> Iterator[tuple[str, str, float, str, str]]:
    speed = speed_axis(speed_unit)
    sign, factor = measure_unit(entry.attrs["units"])
    if entry.attrs["units"] == "rad/s":
        sign, factor = speed.sign, speed.factor
    dim = str(entry.dims[0]) if entry.dims else ""
    names = entry[dim].values if dim in entry.coords else range(1, entry.size + 1)
    for name, value in zip(names if dim else ("",), np.atleast_1d(entry.values), strict=True):
        of = str(name) if isinstance(name, str) else f"{dim} {name}"
        yield str(entry.name), of if dim else "", float(value) * factor, sign, entry.attrs["long_name"]


# Studies of deep chambers as a table: the vertical amplitude over balls and friction.


SHOWN = "vertical_amplitude"


def _amplitudes(found: Answer, _: str) -> list[Column]:
    """A row for each chamber and friction, a column for each number of balls; seeds are averaged."""
    values = found[SHOWN].mean("seed", skipna=True) if "seed" in found[SHOWN].dims else found[SHOWN]
    values = values.transpose("layers", "friction", ...)
    length = length_axis(None, float(np.nanmax(values.values, initial=0.0)))
    rows = list(product(found["layers"].values, found["friction"].values))
    table = values.values.reshape(len(rows), -1) * length.factor
    heads = [f"{count} balls" for count in found["balls"].values] if "balls" in values.dims else ["mean amplitude"]
    return [
        Column("chamber", [str(layer) for layer, _ in rows]),
        Column("friction", [float(friction) for _, friction in rows], form="g"),
        *(Column(head, table[:, k], length.sign, ".4g") for k, head in enumerate(heads)),
    ]


def _mean_over(found: Answer) -> list[str]:
    over = f", mean over {found.sizes['seed']} seeds" if found.sizes.get("seed", 1) > 1 else ""
    return [f"the table has {SHOWN}{over}"]


FORMS["ChamberStudy"] = Form(
    _amplitudes,
    there=lambda it: (
        SHOWN in it and {"layers", "friction"} <= set(it[SHOWN].dims) <= {"layers", "friction", "balls", "seed"}
    ),
    remarks=_mean_over,
)


# What a fit of rubber found.


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
        result = np.empty(len(self.points), np.complex128)
        for i, motion in enumerate(self.points.motion):
            result[i] = self.law.stiffness(self.points.amplitude[i], self.points.frequency[i], motion)
        return result

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
    result = np.zeros((w.size, 2 + limits.size + len(times)), np.complex128)
    result[:, 0], result[:, 1] = 1.0, 1j * w
    circle = np.array([one == "circle" for one in motion])
    for column, limit in enumerate(limits, 2):
        for mask, name in ((circle, "circle"), (~circle, "line")):
            if mask.any():
                result[mask, column] = friction_stiffness(
                    a[mask] / limit, law, "circle" if name == "circle" else "line"
                )
    for column, tau in enumerate(times, 2 + limits.size):
        result[:, column] = 1j * w * tau / (1.0 + 1j * w * tau)
    return result


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
    columns = {field.name: [getattr(part, field.name) for part in parts] for field in fields(RubberPoints)}
    whole: dict[str, Any] = {
        name: np.concatenate(column) if isinstance(column[0], np.ndarray) else tuple(chain(*column))
        for name, column in columns.items()
    }
    return RubberPoints(**whole)

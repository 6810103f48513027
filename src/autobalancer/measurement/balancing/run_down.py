"""Unbalance of all planes from one run-down and a model of the rotor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine, Unbalance
from autobalancer.measurement.balancing.arrays import Complexes, Floats
from autobalancer.measurement.balancing.channels import Orders, seen_by_channels
from autobalancer.measurement.balancing.order_table import given_orders
from autobalancer.measurement.balancing.uncertainty import polar_deviations
from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import moment_text, share_text
from autobalancer.results.provenance import provenance
from autobalancer.shown import Column

OWNER = "run-down"
INSEPARABLE, POOR = 1e8, 50.0  # condition numbers beyond which planes cannot be, and are hardly, told apart
FAR = 3.0  # chi square of each reading beyond which the model does not describe the rotor


def unbalance_from_run_down(
    machine: Machine | str | Path,
    orders: xr.Dataset | str | Path,
    *,
    planes: Sequence[str | float] | None = None,
    lowest: float = 0.0,
    highest: float = np.inf,
) -> PlaneUnbalances:
    """Unbalance vectors of several planes that explain what sensors saw over the speed, by weighted least squares.

    The model of the rotor takes the place of trial runs: it says what an unbalance in each plane does at each sensor and speed.
    Speeds near several critical speeds tell planes apart.

    Parameters
    ----------
    machine
        Any rotor; its own unbalances and the unbalance of its balls are ignored, their masses are in.
    orders
        Amplitude and phase of the first order over ``speed`` and ``channel``: ``amplitude`` (SI), ``phase`` (rad, lead of the
        vibration over the mark) and perhaps ``amplitude_deviation`` and ``phase_deviation``; with ``place`` (a station or a
        position, m), ``direction`` (``x``, ``y`` or degrees from x) and ``quantity`` of each channel. Or a table, see
        :func:`~autobalancer.measure.load_orders`.
    planes
        Stations or positions (m) whose unbalance is asked for; by default all stations of the machine, else the plane of its
        first balancer.
    lowest, highest
        Speeds that are used, rad/s.

    Returns
    -------
    PlaneUnbalances
        Over ``plane``: ``unbalance`` (kg m) and ``unbalance_angle`` (rad) with one standard ``_deviation`` each, and
        ``covariance`` over both parts; over ``combination``: ``combination_deviation`` (kg m), that of combinations of all
        planes, the worst known first, and ``weight``, ``weight_phase`` of each plane in them; over ``speed`` and ``channel``
        what was ``measured`` and ``fitted``.

    Raises
    ------
    QuestionError
        If channels or speeds are missing, or planes cannot be told apart; it names the combination.
    """
    machine = balls_in_races(machine)
    asked = _planes(machine, planes)
    known = _used(given_orders(orders), lowest, highest)
    rows = _rows(machine, known, asked)
    values, spread, given = _flat(known)
    weighted = rows / spread[:, None]
    size = np.linalg.norm(weighted, axis=0)
    if not (size > 0.0).all():
        raise QuestionError(
            f"{OWNER}: unbalance in plane {asked[int(np.argmin(size))]!r} moves no sensor of these; leave it out"
        )
    _, singular, turned = np.linalg.svd(weighted / size, full_matrices=False)
    condition = float(singular[0] / singular[-1]) if singular.size == len(asked) and singular[-1] > 0.0 else np.inf
    if values.size < len(asked) or condition > INSEPARABLE:
        raise QuestionError(
            f"{OWNER}: planes {', '.join(map(str, asked))} cannot be told apart by {values.size} readings: "
            f"{_words(turned[-1] / size, asked)} "
            "moves no sensor. Ask for fewer planes, or use more speeds and sensors"
        )
    found = np.linalg.lstsq(weighted, values / spread, rcond=None)[0]
    freedom = values.size - len(asked)
    miss = float((np.abs((values - rows @ found) / spread) ** 2).sum()) / 2.0  # of each of two directions
    chi = miss / freedom if freedom > 0 else 1.0
    more = chi if not given else max(1.0, chi)
    covariance = more * np.linalg.inv((weighted.conj().T @ weighted).astype(complex))
    return _dataset(machine, known, asked, found, covariance, rows, condition, chi if given else np.nan, turned, size)


def _planes(machine: Machine, planes: Sequence[str | float] | None) -> list[str | float | None]:
    if planes is not None:
        if not len(planes):
            raise QuestionError(f"{OWNER}: planes: given none; name at least one")
        return list(planes)
    return [station.name for station in machine.stations] or [None]


def _used(known: Orders, lowest: float, highest: float) -> Orders:
    inside = (known.speeds >= lowest) & (known.speeds <= highest)
    if not inside.any():
        raise QuestionError(f"{OWNER}: no speed from {lowest:g} to {highest:g} rad/s was measured")
    return known.at(inside)


def _rows(machine: Machine, known: Orders, planes: list[str | float | None]) -> Complexes:
    """What a unit unbalance in each plane does at each speed and channel, (S C, P)."""
    loads: list[Any] = [1.0 if plane is None else (Unbalance(moment=1.0, station=plane),) for plane in planes]
    columns = [seen_by_channels(machine, known, load, OWNER, balls=True).ravel() for load in loads]
    return np.stack(columns, axis=1)


def _flat(known: Orders) -> tuple[Complexes, Floats, bool]:
    """Readings, deviations (those that are missing as equal shares of the greatest reading), and whether all were given."""
    values, spread = known.readings.ravel(), known.deviations.ravel()
    given = bool(np.isfinite(spread).all() and (spread > 0.0).all())
    return values, spread if given else np.full(values.size, float(np.abs(values).max()) or 1.0), given


def _words(vector: Complexes, planes: list[str | float | None]) -> str:
    v = vector.conj()
    v = v / v[int(np.argmax(np.abs(v)))]
    parts = [
        f"{abs(one):.2g} in {'the plane of the balancer' if plane is None else plane} at {np.degrees(np.angle(one)):.0f} deg"
        for one, plane in zip(v, planes, strict=True)
        if abs(one) > 0.03
    ]
    return " with ".join(parts)


def _dataset(
    machine: Machine, known: Orders, planes: list[str | float | None], found: Any, covariance: Any, rows: Complexes,
    condition: float, chi: float, turned: Complexes, size: Floats,
) -> PlaneUnbalances:  # fmt: skip
    real = np.block([[covariance.real, -covariance.imag], [covariance.imag, covariance.real]])
    sizes, angles = polar_deviations(found, real)
    spread, vectors = np.linalg.eigh(covariance)
    names = ["plane of the first balancer" if plane is None else str(plane) for plane in planes]
    shape = known.readings.shape
    fitted = (rows @ found).reshape(shape)
    over, both = ("plane",), ("speed", "channel")
    data: dict[str, tuple[Any, Any, str, str]] = {
        "unbalance": (over, np.abs(found), "unbalance", "kg m"),
        "unbalance_deviation": (over, sizes, "its standard deviation", "kg m"),
        "unbalance_angle": (over, np.angle(found), "angle of the unbalance in the rotor", "rad"),
        "unbalance_angle_deviation": (over, angles, "its standard deviation", "rad"),
        "covariance": (("component", "other_component"), real, "covariance, real parts of all planes first", "kg^2 m^2"),
        "combination_deviation": (("combination",), np.sqrt(np.maximum(spread[::-1], 0.0)), "standard deviation of a "
        "combination", "kg m"),
        "weight": (("combination", "plane"), np.abs(vectors[:, ::-1].T), "weight of a plane in a combination", "1"),
        "weight_phase": (("combination", "plane"), np.angle(vectors[:, ::-1].T), "angle of this weight", "rad"),
        "measured": (both, np.abs(known.readings), "amplitude measured", ""),
        "measured_phase": (both, np.angle(known.readings), "its phase", "rad"),
        "fitted": (both, np.abs(fitted), "amplitude of the model with these unbalances", ""),
        "fitted_phase": (both, np.angle(fitted), "its phase", "rad"),
        "deviation": (both, known.deviations, "standard deviation of the reading", ""),
    }  # fmt: skip
    answer = xr.Dataset(
        {name: (dims, values, {"long_name": text, "units": unit}) for name, (dims, values, text, unit) in data.items()},
        {
            "plane": np.array(names, dtype=object),
            "speed": ("speed", known.speeds, {"long_name": "rotor speed", "units": "rad/s"}),
            "place": ("channel", np.array([str(place) for place in known.places], dtype=object)),
            "direction": (
                "channel",
                np.array(known.directions, dtype=float),
                {"long_name": "angle from x", "units": "rad"},
            ),
            "quantity": ("channel", np.array(known.quantities, dtype=object)),
        },
    )
    left = float(np.linalg.norm(fitted - known.readings) / np.linalg.norm(known.readings))
    warnings = []
    if condition > POOR:
        warnings.append(
            f"planes are hardly told apart (condition number {condition:.3g}): {_words(turned[-1] / size, planes)} is "
            "known worst; more "
            "speeds, through another critical speed, or more sensors help"
        )
    if np.isfinite(chi) and chi > FAR:
        warnings.append(
            f"the model does not describe the rotor within the deviations of the readings (chi square {chi:.3g} for "
            "each); fit it first "
            "with rotor.identify. The uncertainty contains what is left, not what is wrong with the model"
        )
    answer.attrs = {
        "title": f"Unbalance from a run-down: {machine.name}", **provenance(), "machine_name": machine.name,
        "condition": condition, "left_over": left, "warnings": "\n".join(warnings),
    }  # fmt: skip
    return PlaneUnbalances.of(answer)


# Unbalances of all planes as a table.


class PlaneUnbalances(Answer):
    """Unbalance vectors of several planes, from one run-down."""

    __slots__ = ()
    drawn_by = "run_down"
    row_of = "plane"
    needed: ClassVar[tuple[str, ...]] = ("unbalance", "unbalance_angle")

    def columns(self, unit: str = "") -> list[Column]:
        """Size and angle in each plane with their standard deviations."""
        turn = 180.0 / np.pi
        return [
            Column("plane", [str(name) for name in self["plane"].values]),
            Column("unbalance", 1e6 * self["unbalance"].values, "g mm", ".4g"),
            Column("+-", 1e6 * self["unbalance_deviation"].values, "g mm", ".2g"),
            Column("angle", np.mod(turn * self["unbalance_angle"].values, 360.0), "deg", ".1f"),
            Column("+-", turn * self["unbalance_angle_deviation"].values, "deg", ".2g"),
        ]

    def facts(self) -> list[tuple[str, str]]:
        """How well the model explains the readings, and what is known worst."""
        told = [
            ("of the readings not explained", share_text(float(self.attrs["left_over"]))),
            ("condition number", f"{self.attrs['condition']:.3g}"),
        ]
        if self.sizes["plane"] > 1:
            worst = self.isel(combination=0)
            parts = [
                f"{float(weight):.2g} {name} at {np.degrees(float(way)):.0f} deg"
                for weight, way, name in zip(
                    worst["weight"].values, worst["weight_phase"].values, self["plane"].values, strict=True
                )
            ]
            told.append(("known worst", f"{', '.join(parts)}: +- {moment_text(float(worst['combination_deviation']))}"))
        return told

    def has_table(self) -> bool:
        """Its numbers must be there, too."""
        return super().has_table() and {"left_over", "condition"} <= set(self.attrs)

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]

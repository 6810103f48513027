"""Machines fitted to a measurement: what is free, the fit with what it tried so far, and the fits that were kept."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import norm

from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured_files import Measurements
from autobalancer.app.store.signal_pictures import PictureOptions, tracked
from autobalancer.assembly.quantities import in_author_units, parameter_of
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.machine import Machine
from autobalancer.machine.path import unit_at
from autobalancer.measurement.pairs import MeasuredRunUp, is_orders
from autobalancer.measurement.run_up_fit import MeasuredOrders
from autobalancer.results.folder_store import Shelf
from autobalancer.results.signals import Signals
from autobalancer.results.store import save_run
from autobalancer.rotordynamics.identify import identify
from autobalancer.rotordynamics.parameter_fit import FreeParameter
from autobalancer.safe_file import write_text_safely
from autobalancer.units import argument

METHODS = {
    "steady": "orders of a slow run-up, as the steady response of the rotor",
    "orders": "orders of a run-up; each trial is a run of the machine",
    "samples": "every sample; each trial is a run of the machine",
}
COVERED = 0.95
WIDE = float(norm.ppf(0.5 + 0.5 * COVERED))  # standard deviations
FIT_FILES = {"fitted.toml": "application/toml", "fit.nc": "application/x-netcdf"}


@dataclass
class Free:
    """A number of the machine that the fit may change."""

    path: str
    lower: str = ""
    upper: str = ""


@dataclass
class Question:
    """What is fitted to a measurement, and how."""

    free: list[Free]
    way: str = "steady"
    error: str = ""
    balls: bool = False
    starts: int = 1
    lowest: str = ""
    highest: str = ""


@dataclass
class Trials:
    """How far a fit has come: its trials, and the best of them."""

    count: int = 0
    best: float = np.inf  # root mean square of the deviations, in standard deviations
    text: str = ""  # the machine of the best trial


@dataclass
class FitEntry:
    """What a list of fits shows of one; numbers in SI."""

    name: str
    machine: str
    made: str
    way: str
    rows: list[dict[str, Any]]
    notes: list[str] = field(default_factory=list)
    finished: bool = True
    scatter: float = 0.0


class Watched:
    """A measurement whose every trial is counted; it ends the fit when the job is cancelled."""

    def __init__(self, measured: Any, job: Job, trials: Trials) -> None:
        self.measured, self.job, self.trials = measured, job, trials

    def __getattr__(self, name: str) -> Any:
        return getattr(self.measured, name)

    def predict(self, trial: Any) -> Any:
        """As that of the measurement."""
        self.job.progress(0.0, 0.0)
        found = self.measured.predict(trial)
        self.trials.count += 1
        away = self.measured.residual(found)
        size = float(np.sqrt(np.mean(away**2))) if np.isfinite(away).all() else np.inf
        if size < self.trials.best:
            self.trials.best, self.trials.text = size, machine_text(trial.machine)
        return found


def fit(shelf: Measurements, name: str, text: str, question: Question, asked: PictureOptions, job: Job) -> str:
    """Fit the machine of a text to a measurement; gives the name of the fit, also of one that was cancelled.

    Raises
    ------
    QuestionError
        If nothing is free, the noise is not known, or the measurement does not suffice.
    """
    machine = parse_machine(text, "machine")
    if not isinstance(machine, Machine):
        raise QuestionError("a machine with a deep chamber cannot be fitted to a measurement")
    if not question.free:
        raise QuestionError("say what is free: choose at least one number of the machine")
    free = [FreeParameter(one.path, one.lower or -np.inf, one.upper or np.inf) for one in question.free]
    trials = Trials()
    job.result = trials
    measured = Watched(_measured(shelf.data(name), question, asked), job, trials)
    try:
        found = identify(machine, free, [measured], starts=question.starts)
    except KeyboardInterrupt:
        if not trials.text:
            raise
        return _keep_best(shelf, name, machine, question, trials)
    entry = _entry(
        shelf,
        name,
        machine.name,
        question,
        _parameter_rows(found.data),
        [str(note) for note in found.data.attrs["notes"]],
    )
    entry.scatter = float(found.data.attrs["scatter_ratio"])
    plain = found.data.assign_attrs(notes="\n".join(entry.notes))
    plain["at_bound"] = plain["at_bound"].astype("int8")
    save_run(plain, fits(shelf, name).folder(entry.name) / "fit.nc")
    return _store_fit(shelf, name, entry, machine_text(found.machine))


def fits(shelf: Measurements, name: str) -> Shelf[FitEntry]:
    """The fits to a measurement."""
    return Shelf(shelf.folder(name) / "fits", FitEntry, "fit")


def fit_file(shelf: Measurements, name: str, fit_name: str, kind: str) -> Path:
    """A file of a fit.

    Raises
    ------
    QuestionError
        If there is none.
    """
    path = fits(shelf, name).folder(fit_name) / kind
    if kind not in FIT_FILES or not path.is_file():
        raise QuestionError(f"fit {fit_name[:40]!r}: has no {kind[:20]!r}")
    return path


def _measured(data: xr.Dataset, question: Question, asked: PictureOptions) -> Any:
    if question.way == "samples":
        part = asked.piece(data) if isinstance(data, Signals) else data
        return MeasuredRunUp(_with_error(part, question.error))
    found = data if is_orders(data) else tracked(asked.piece(data), asked)
    return MeasuredOrders(
        found,
        error=question.error.strip() or None,
        balls=question.balls,
        lowest=question.lowest.strip() or 0.0,
        highest=question.highest.strip() or np.inf,
        steady=question.way == "steady",
    )


def _with_error(data: xr.Dataset, error: str) -> xr.Dataset:
    """Signals whose noise is given, where it is not known."""
    if not error.strip() or not isinstance(data, Signals):
        return data
    known = Signals.of(data.copy())
    for one in known.data_vars.values():
        if "uncertainty" not in one.attrs and one.attrs.get("quantity") not in ("tacho", "angle", "speed"):
            one.attrs["uncertainty"] = argument("error", error.strip(), str(one.attrs["units"]))
    return known


def _parameter_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Of each parameter value, interval of 95 %, and where the fit began."""
    rows = []
    for k in range(data.sizes["parameter"]):
        one = data.isel(parameter=k)
        value, spread = float(one["value"]), float(one["uncertainty"])
        sure = bool(np.isfinite(spread)) and not bool(one["at_bound"])
        rows.append(
            {
                "path": str(one["paths"].values),
                "unit": str(one["unit"].values),
                "start": float(one["start"]),
                "value": value,
                "low": value - WIDE * spread if sure else None,
                "high": value + WIDE * spread if sure else None,
                "said": "at its bound" if bool(one["at_bound"]) else "" if sure else "not determined",
            }
        )
    return rows


def _keep_best(shelf: Measurements, name: str, machine: Machine, question: Question, trials: Trials) -> str:
    """What a cancelled fit leaves: the machine of its best trial."""
    best = parse_machine(trials.text)
    rows = [
        {
            "path": one.path,
            "unit": unit_at(one.path),
            "start": parameter_of(machine, one.path),
            "value": parameter_of(best, one.path),  # type: ignore[arg-type]
            "low": None,
            "high": None,
            "said": "not finished",
        }
        for one in question.free
    ]
    note = f"cancelled after {trials.count} trials; this is the best of them, and nothing is known of its uncertainty"
    entry = _entry(shelf, name, machine.name, question, rows, [note])
    entry.finished, entry.scatter = False, trials.best
    return _store_fit(shelf, name, entry, machine_text(in_author_units(best, machine)))


def _entry(
    shelf: Measurements, name: str, machine: str, question: Question, rows: list[dict[str, Any]], notes: list[str]
) -> FitEntry:
    """What is known of a new fit, which has its folder."""
    made = f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}"
    return FitEntry(fits(shelf, name).new().name, machine, made, question.way, rows, notes)


def _store_fit(shelf: Measurements, name: str, entry: FitEntry, machine: str) -> str:
    """Keep the machine of a fit and what is known of it; gives its name."""
    kept = fits(shelf, name)
    write_text_safely(kept.folder(entry.name) / "fitted.toml", machine)
    kept.note(entry)
    return entry.name

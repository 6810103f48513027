"""How much a design depends on what is never exactly as assumed: unbalance, friction, sizes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.patience import shows_progress
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.archive.folder import Archive
from autobalancer.results.provenance import provenance
from autobalancer.studies.chamber_design.candidate import Candidate, machine_of
from autobalancer.studies.chamber_design.chosen import candidate_of
from autobalancer.studies.chamber_design.limits import JUDGED, numbers_of
from autobalancer.studies.chamber_design.statistics import mean_interval, share_interval
from autobalancer.studies.chamber_many import Job, Many, measured_runs

CHANGED = ("unbalance", "friction", "ball_friction", "diameter", "density", "viscosity")
AS_DESIGNED = "as designed"


@shows_progress
def design_sensitivity(
    designs: xr.Dataset,
    changes: Mapping[str, float],
    *,
    place: int = 1,
    archive: Archive | str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a design again with each of several quantities a little smaller and larger, with the same fillings.

    Parameters
    ----------
    designs
        From :func:`design`.
    changes
        Shares by which ``unbalance``, ``friction``, ``diameter``, ``density`` or ``viscosity`` is changed, such as 0.2.
    place
        Of the design, 1 for the best.
    archive
        That of the search, whose runs of the design itself are not repeated.
    workers, progress
        As for :func:`design`.

    Returns
    -------
    xarray.Dataset
        Over ``change``, the first one none: mean vibration with its interval (m), worst values and pick-up; over ``change``
        and ``seed`` the numbers of every run. nan where the balls do not fit.

    Raises
    ------
    QuestionError
        For an unknown quantity, a share that is not between 0 and 1, or a place that no design has.
    """
    if "place" not in designs or "machine" not in designs.attrs:
        raise QuestionError("design_sensitivity: wants the answer of chamber.design")
    there = designs["place"].values == place
    if not there.any():
        raise QuestionError(f"place: given {place}; the designs have 1 to {int(designs['place'].max())}")
    candidate, size = candidate_of(designs.isel(design=int(there.argmax()))), float(designs["unbalance"].max())
    cases = [(AS_DESIGNED, candidate, size), *_cases(candidate, size, changes)]
    machine = parse_machine(str(designs.attrs["machine"]))
    assert isinstance(machine, ChamberMachine)
    kept = archive if isinstance(archive, Archive) or archive is None else Archive(archive)
    duration, last = float(designs.attrs["duration"]), float(designs.attrs["last"])
    seeds = [int(seed) for seed in designs["seed"].values]

    jobs = []
    for _, changed, unbalance in cases:
        made = _machine(machine, changed, unbalance)
        names = [changed.run_name(unbalance, duration, last, seed) for seed in seeds]
        jobs += [Job(name, made, seed, {"unbalance": unbalance}) for name, seed in zip(names, seeds, strict=True)]
    measured = measured_runs(jobs, Many(duration, last, kept, workers), progress)
    told = [
        numbers_of(job.machine, row) if isinstance(job.machine, ChamberMachine) and row["outcome"] == "finished" else {}
        for job, row in zip(jobs, measured, strict=True)
    ]
    rows = np.array(told, object).reshape(len(cases), len(seeds))
    found = xr.Dataset(coords={"change": [name for name, _, _ in cases], "seed": seeds})
    values = {name: np.array([[row.get(name, np.nan) for row in several] for several in rows]) for name in JUDGED}
    means = np.array([mean_interval(several) for several in values["vibration"]])
    for k, name in enumerate(("vibration_mean", "vibration_low", "vibration_high")):
        found[name] = ("change", means[:, k], {"units": "m"})
    for name in ("vibration", "synchronous", "settling_time"):
        found[f"worst_{name}"] = ("change", values[name].max(axis=1), {"units": JUDGED[name].unit})
    carried = [share_interval(int((shares >= 1.0 - 1e-9).sum()), len(seeds))[0] for shares in values["share_carried"]]
    found["pick_up"] = ("change", np.array(carried), {"units": "1"})
    for name, entry in JUDGED.items():
        found[name] = (("change", "seed"), values[name], {"units": entry.unit, "long_name": entry.text})
    title = f"{candidate.label}: what changes if something is not as designed"
    found.attrs = {"title": title, **provenance(), "machine_name": machine.name}
    return Labeled.of(found)


def _machine(machine: ChamberMachine, candidate: Candidate, unbalance: float) -> ChamberMachine | MachineError:
    try:
        return machine_of(machine, candidate, unbalance)
    except MachineError as reason:
        return reason


def _cases(candidate: Candidate, size: float, changes: Mapping[str, float]) -> list[tuple[str, Candidate, float]]:
    if not changes:
        raise QuestionError("changes: given none; give at least one, such as unbalance 0.2")
    found = []
    for name, share in changes.items():
        if name not in CHANGED:
            raise QuestionError(f"changes: given {name!r}; must be one of {', '.join(CHANGED)}")
        if not 0.0 < share < 1.0:
            raise QuestionError(f"changes: {name}: given {share:g}; must be a share between 0 and 1")
        if name in ("viscosity", "ball_friction") and not getattr(candidate, name) > 0.0:
            raise QuestionError(f"changes: {name}: the design has none of its own")
        for sign in (-1.0, 1.0):
            factor, label = 1.0 + sign * share, f"{name} {100.0 * sign * share:+.3g} %"
            changed = (
                candidate if name == "unbalance" else replace(candidate, **{name: getattr(candidate, name) * factor})
            )
            found.append((label, changed, size * factor if name == "unbalance" else size))
    return found

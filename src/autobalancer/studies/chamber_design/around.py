"""How much a design depends on what is never exactly as assumed: unbalance, friction, sizes."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.assembly.author_units import in_author_units
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.archive import Archive
from autobalancer.results.provenance import provenance
from autobalancer.studies.chamber_design.candidate import (
    JUDGED,
    Candidate,
    machine_of,
    mean_interval,
    numbers_of,
    share_interval,
)
from autobalancer.studies.chamber_study import Job, Many, measured_runs

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


def refuse_changes(changes: Mapping[str, float]) -> None:
    """Refuse quantities that no design has, and shares that are none.

    Raises
    ------
    QuestionError
        With what is allowed.
    """
    for name, share in changes.items():
        if name not in CHANGED:
            raise QuestionError(f"changes: given {name!r}; must be one of {', '.join(CHANGED)}")
        if not 0.0 < share < 1.0:
            raise QuestionError(f"changes: {name}: given {share:g}; must be a share between 0 and 1")


def _cases(candidate: Candidate, size: float, changes: Mapping[str, float]) -> list[tuple[str, Candidate, float]]:
    if not changes:
        raise QuestionError("changes: given none; give at least one, such as unbalance 0.2")
    refuse_changes(changes)
    found = []
    for name, share in changes.items():
        if name in ("viscosity", "ball_friction") and not getattr(candidate, name) > 0.0:
            raise QuestionError(f"changes: {name}: the design has none of its own")
        for sign in (-1.0, 1.0):
            factor, label = 1.0 + sign * share, f"{name} {100.0 * sign * share:+.3g} %"
            changed = (
                candidate if name == "unbalance" else replace(candidate, **{name: getattr(candidate, name) * factor})
            )
            found.append((label, changed, size * factor if name == "unbalance" else size))
    return found


# The machine of a design, with what was assumed written into its description.


NUMBERS = ("diameter", "density", "friction", "ball_friction", "viscosity", "fluid_density", "fill")


def designed_machine(designs: xr.Dataset, place: int = 1, *, unbalance: float | None = None) -> ChamberMachine:
    """The machine of the design at a place, 1 for the best, that can be saved and run.

    Parameters
    ----------
    designs
        From :func:`design`.
    place
        In their order.
    unbalance
        kg m; by default the greatest for which they were made.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    if "place" not in designs or "machine" not in designs.attrs:
        raise QuestionError("designed_machine: wants the answer of chamber.design")
    there = designs["place"].values == place
    if not there.any():
        raise QuestionError(f"place: given {place}; the designs have 1 to {int(designs['place'].max())}")
    one = designs.isel(design=int(there.argmax()))
    machine = parse_machine(str(designs.attrs["machine"]))
    assert isinstance(machine, ChamberMachine)
    candidate = candidate_of(one)
    size = float(designs["unbalance"].max()) if unbalance is None else unbalance
    made = in_author_units(machine_of(machine, candidate, size), machine)
    return made.model_copy(
        update={"name": f"{machine.name}, {candidate.label}", "description": _said(designs, one, candidate)}
    )


def candidate_of(one: xr.Dataset) -> Candidate:
    """The candidate of one design of the answer."""
    return Candidate(int(one["balls"]), *(float(one[name]) for name in NUMBERS))


def _said(designs: xr.Dataset, one: xr.Dataset, candidate: Candidate) -> str:
    limits = json.loads(designs.attrs["limits"])
    asked = ", ".join(f"{name} {value:g}" for name, value in limits.items()) or "none"
    sizes = ", ".join(f"{size:g}" for size in designs["unbalance"].values)
    meets = "It meets them." if int(one["meets"]) else f"It misses {str(one['missed'].values) or 'them'}."
    fluid = ""
    if candidate.viscosity > 0.0:
        fluid = (
            f" Fluid of {candidate.viscosity:g} Pa s and {candidate.fluid_density:g} kg/m^3 that fills {candidate.fill:g} of the "
            f"chamber, its drag that of balls far from walls, c_d = 24/Re + 0.44; buoyancy is left out."
        )
    worst = float(one["worst_vibration"])
    found = f"Worst vibration {worst:.3g} m" if not math.isnan(worst) else "Worst vibration not known"
    return (
        f"Design {int(one['place'])} of {designs.sizes['design']} for unbalances of {sizes} kg m. Limits (SI): {asked}. {meets} "
        f"{found} in {designs.sizes['seed']} fillings of {designs.attrs['duration']:g} s. Assumed: a friction of "
        f"{candidate.friction:g}, restitution and rolling resistance of the machine it was made from.{fluid}"
    )

"""Which pictures there are of a result, whatever it is the result of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import autobalancer as ab
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr
    from matplotlib.figure import Figure

    from autobalancer.results.answers.studied import Studied

Pictures = dict[str, "Callable[[], Figure]"]

RACES = ("run-up", "race", "orbit", "impacts", "drive-train")
CHAMBER = ("history", "energy", "collisions", "bearings", "reactions", "arrangement")
STUDY = ("amplitudes", "means", "carried")
DESIGNS = ("designs",)
ENSEMBLE = ("shares", "distribution")
MACHINE = ("machine",)
DESIGN = ("design",)
MANY = ("picture", "distribution", "rest-positions")
ANSWER = ("picture",)  # of any other answer


@dataclass(frozen=True)
class Wishes:
    """What was asked for besides the kind; None, or a default, where nothing was."""

    speed_unit: str
    deflection_unit: str | None
    log: bool | None
    time: float | None
    start: float | None
    end: float | None
    frame: str
    place: str


def pictures_of(result: xr.Dataset, wishes: Wishes) -> Pictures:
    """Name of each picture and what draws it."""
    from autobalancer.results.answers.studied import Studied
    from autobalancer.results.chamber.shape import is_chamber_run

    if is_chamber_run(result):
        return _of_chamber(result, wishes)
    if {"place", "stage", "total_mass"} <= set(result.data_vars):
        _refuse(wishes, "of designs of a deep chamber", "log", "time", "start", "end", "frame", "place")
        return {"designs": lambda: ab.plot.chamber_designs(result)}
    if {"place", "stage", "front"} <= set(result.data_vars):
        _refuse(wishes, "of a design", "log", "time", "start", "end", "frame", "place", "deflection_unit")
        return {"design": lambda: ab.plot.design(result)}
    if {"layers", "friction", "balls"} <= set(result.dims):
        return _of_study(result, wishes)
    if isinstance(result, Studied) and "verdict" in result:
        return _of_many(result, wishes)
    if draw := _own_picture(result):
        _refuse(wishes, "of this result", "log", "frame", "place", "time", "start", "end", "deflection_unit")
        return {"picture": lambda: draw(result)}
    if "member" in result.dims:
        _refuse(wishes, "of an ensemble", "log", "frame", "place", "time", "start", "end", "deflection_unit")
        return {
            "shares": lambda: ab.plot.ensemble(result, speed_unit=wishes.speed_unit),
            "distribution": lambda: ab.plot.ensemble_distribution(result, speed_unit=wishes.speed_unit),
        }
    return _of_races(result, wishes)


def _own_picture(result: xr.Dataset) -> Callable[[xr.Dataset], Figure] | None:
    """The function that draws an answer which is no run and no ensemble."""
    from autobalancer.results.answers.answer import Answer

    if {"deviation", "correlation", "parameter"} <= set(result.variables):
        return ab.plot.identification
    name = result.drawn_by if isinstance(result, Answer) else ""
    return getattr(ab.plot, name) if name not in ("", "run_up", "ensemble") else None


def of_machine(machine: Path, wishes: Wishes) -> Pictures:
    """The drawing of a machine file."""
    _refuse(wishes, "of a machine", "log", "time", "start", "end", "frame", "place", "deflection_unit")
    return {"machine": lambda: ab.plot.machine(machine)}


def _of_races(run: xr.Dataset, wishes: Wishes) -> Pictures:

    both: dict[str, Any] = {
        "speed_unit": wishes.speed_unit,
        "deflection_unit": wishes.deflection_unit,
        "start": wishes.start,
        "end": wishes.end,
    }
    pictures: Pictures = {
        "run-up": lambda: ab.plot.run_up(run, log_deflection=wishes.log, **both),
        "race": lambda: ab.plot.race(run, time=wishes.time, speed_unit=wishes.speed_unit),
        "orbit": lambda: ab.plot.orbit(
            run,
            frame=wishes.frame or "space",  # type: ignore[arg-type]
            place=wishes.place or None,
            **both,
        ),
    }
    part: dict[str, Any] = {"speed_unit": wishes.speed_unit, "start": wishes.start, "end": wishes.end}
    if run.sizes.get("link", 0):
        pictures["drive-train"] = lambda: ab.plot.drive_train(run, **part)
    if run.sizes.get("impact", 0):
        pictures["impacts"] = lambda: ab.plot.impacts(run, **part)
    return pictures


def _of_chamber(run: xr.Dataset, wishes: Wishes) -> Pictures:

    _refuse(wishes, "of a deep chamber", "log", "frame", "place")
    part = run.sel(time=slice(wishes.start, wishes.end))
    if part.sizes["time"] < 2:
        first, last = float(run["time"][0]), float(run["time"][-1])
        raise QuestionError(
            f"--start, --end: fewer than two samples there; the run goes from {first:g} s to {last:g} s"
        )
    part = part.load()
    units: dict[str, Any] = {"speed_unit": wishes.speed_unit, "deflection_unit": wishes.deflection_unit}
    return {
        "history": lambda: ab.plot.chamber_run(part, **units),
        "energy": lambda: ab.plot.chamber_energy(part),
        "collisions": lambda: ab.plot.chamber_collisions(part),
        "bearings": lambda: ab.plot.chamber_bearing_forces(part),
        "reactions": lambda: ab.plot.chamber_reactions(part),
        "arrangement": lambda: ab.plot.chamber_arrangement(
            run if wishes.time else part, [wishes.time] if wishes.time else None
        ),
    }


def _of_many(study: Studied, wishes: Wishes) -> Pictures:
    """The pictures of a study of runs."""
    _refuse(wishes, "of a study", "log", "frame", "place", "time", "start", "end", "deflection_unit")
    unit = wishes.speed_unit
    return {
        "picture": lambda: ab.plot.study(study, speed_unit=unit),
        "distribution": lambda: ab.plot.ensemble_distribution(study, speed_unit=unit),
        "rest-positions": lambda: ab.plot.rest_positions(study, speed_unit=unit),
    }


def _of_study(study: xr.Dataset, wishes: Wishes) -> Pictures:
    from autobalancer.studies.chamber_means import optimal_means

    _refuse(wishes, "of a study", "log", "frame", "place", "time", "start", "end", "deflection_unit")
    return {
        "amplitudes": lambda: ab.plot.chamber_amplitudes(study),
        "means": lambda: ab.plot.chamber_optimal_means(optimal_means(study)),
        "carried": lambda: ab.plot.chamber_carried(study),
    }


def _refuse(wishes: Wishes, what: str, *names: str) -> None:
    for name in names:
        if getattr(wishes, name) not in (None, False, ""):
            raise QuestionError(f"--{name.replace('_', '-')}: has no meaning for the pictures {what}; leave it out")

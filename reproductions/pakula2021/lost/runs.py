"""Runs of candidates, kept one a line as soon as they are done, so that a search that was stopped goes on."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from autobalancer.errors import MachineError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.chamber_measures import (
    ball_places_in_rotor,
    ball_settling_time,
    balls_carried,
    chamber_measures,
)
from autobalancer.results.unconstrained_body import pakula_body, unconstrained_motion
from autobalancer.simulation.chamber import simulate_chamber
from reproductions.pakula2021.lost.candidate import SOFT_STEEL, STEEL, Candidate

DURATION, LAST, SAMPLE = 16.0, 1.0, 2e-3  # s
ENOUGH = 0.9  # of the balls that must go around, for all to count as carried
LEAST_RUN = 2.0  # s before a run may end because its balls are carried


class Cell(NamedTuple):
    """One run of a figure: ``"deep"`` or ``"single"``, friction, number of balls."""

    layers: str
    friction: float
    balls: int


class _Carried(Exception):
    """All balls have gone around for two seconds: what happens later does not change who is carried."""


def key_of(candidate: Candidate) -> str:
    """A short name, the same for the same numbers."""
    return hashlib.sha256(json.dumps(candidate.as_dict(), sort_keys=True).encode()).hexdigest()[:10]


def run(candidate: Candidate, cell: Cell, seed: int, *, whole: bool = False, soft: bool = False) -> dict[str, Any]:
    """Who is carried, and with ``whole`` everything that figures 9 to 14 say.

    Without ``whole`` a run ends as soon as all balls have gone around for two seconds. ``soft`` takes a tenth of the modulus of
    steel, with which steps are longer.
    """
    found = _run(candidate, cell, seed, whole, SOFT_STEEL if soft else STEEL)
    return {**found, "soft": soft}


def _run(candidate: Candidate, cell: Cell, seed: int, whole: bool, modulus: float) -> dict[str, Any]:
    try:
        machine = candidate.machine(
            balls=cell.balls, friction=cell.friction, layers=cell.layers, youngs_modulus=modulus
        )
        if not whole:
            return {**watched(machine, seed, DURATION), "whole": False}
        ended = simulate_chamber(machine, duration=DURATION, sample=SAMPLE, seed=seed)
    except MachineError as reason:
        return {"outcome": f"does not fit: {reason}", "share": 0.0, "whole": True}
    return {"outcome": str(ended.attrs["outcome"]), "whole": True, **measured(ended, candidate)}


def watched(machine: ChamberMachine, seed: int, duration: float) -> dict[str, Any]:
    """Who is carried; the run ends as soon as all balls have gone around for two seconds."""
    watch = _Watch()
    try:
        ended = simulate_chamber(
            machine, duration=duration, sample=SAMPLE, seed=seed, on_chunk=watch, chunk=500, keep=False
        )
    except _Carried:
        return {"outcome": "carried", "share": 1.0, "until": watch.time}
    return {"outcome": str(ended.attrs["outcome"]), "share": watch.share, "until": watch.time, "turns": watch.turns}


class _Watch:
    """What is seen of a run while it goes on."""

    def __init__(self) -> None:
        self.time, self.share, self.since = 0.0, 0.0, math.inf
        self.turns = 0.0  # of the ball that went around least

    def __call__(self, part: xr.Dataset, checkpoint: Any) -> None:
        self.time = float(part["time"].values[-1])
        self.share = float(np.mean(balls_carried(part, last=self.time - float(part["time"].values[0]))))
        self.turns += float(turns(part).min())
        self.since = min(self.since, self.time) if self.share >= ENOUGH else math.inf
        if self.time >= LEAST_RUN + self.since and self.share >= ENOUGH:
            raise _Carried


def turns(run: xr.Dataset) -> np.ndarray:
    """How often each ball went around the axis, in space."""
    place = run["ball_position"].transpose("time", "ball", "axis").values
    around = place[:, :, 1] + 1j * place[:, :, 2]
    return np.asarray(np.angle(around[1:] * np.conj(around[:-1])).sum(axis=0) / (2.0 * math.pi))


def measured(ended: xr.Dataset, candidate: Candidate) -> dict[str, float]:
    """Numbers of a whole run, SI; greatest reactions are those of the steady state."""
    found = chamber_measures(ended, last=LAST)
    steady = found.sel(stage="steady")
    last = ball_places_in_rotor(ended).isel(time=slice(-round(LAST / SAMPLE), None))
    numbers = {
        "share": float(found["share_carried"]),
        "turns": float(turns(ended).min()),
        "amplitude": float(found["vertical_amplitude"]),
        "synchronous": float(found["vertical_synchronous"]),
        "settled": float(ball_settling_time(ended, last=LAST).max(skipna=False)),  # from the start, as in the article
        "residual": float(found["residual_unbalance"]),
        "force_x": float(steady["constraint_x_greatest"]),
        "moment_y": float(steady["constraint_moment_y_greatest"]),
        "heavy": float((last.mean("time").isel(axis=1) > 0.0).mean()),
    }
    body = pakula_body(candidate.below)
    until = numbers["settled"] if math.isfinite(numbers["settled"]) else DURATION
    moved = unconstrained_motion(ended, body, until)
    for name in ("x", "rotation_y", "rotation_z"):
        numbers[f"loose_{name}"] = float(np.abs(moved[name].values).max())
    return numbers


class Kept:
    """A file of runs, one a line. A run with the modulus of steel replaces one with less, a whole run one that was ended."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.found: dict[tuple[str, Cell, int], dict[str, Any]] = {}
        if path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                row = json.loads(line)
                self._enter((row["machine"], Cell(*row["cell"]), row["seed"]), row["found"])

    def _enter(self, place: tuple[str, Cell, int], found: dict[str, Any]) -> None:
        held = self.found.get(place)
        if held is None or _worth(found) >= _worth(held):
            self.found[place] = found

    def of(
        self, candidate: Candidate, cell: Cell, seed: int, *, whole: bool = False, soft: bool = False
    ) -> dict[str, Any]:
        """A run: from the file, or run now and written there."""
        place = (key_of(candidate), cell, seed)
        held = self.found.get(place)
        if held is not None and _worth(held) >= (not soft, whole):
            return held
        found = run(candidate, cell, seed, whole=whole, soft=soft)
        self._enter(place, found)
        with self.path.open("a", encoding="utf-8") as file:
            print(json.dumps({"machine": place[0], "cell": cell, "seed": seed, "found": found}), file=file, flush=True)
        return found

    def held(self, machine: str, cell: Cell) -> list[dict[str, Any]]:
        """All runs of a cell; soft ones only if there are no others."""
        rows = [found for (name, place, _), found in self.found.items() if name == machine and place == cell]
        hard = [found for found in rows if not found.get("soft")]
        return hard or rows


def _worth(found: dict[str, Any]) -> tuple[bool, bool]:
    return not found.get("soft", False), bool(found["whole"])

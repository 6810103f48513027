"""What lifts the balls: runs in which one thing at a time is taken away, kept in a table.

``python -m reproductions.pakula2021.lost.mechanism``: run what the table lacks.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from reproductions.pakula2021.lost.candidate import A, Candidate
from reproductions.pakula2021.lost.drum import changed
from reproductions.pakula2021.lost.runs import DURATION, SAMPLE, Cell, watched

TABLE = Path(__file__).parents[1] / "data" / "mechanism_of_pick_up.csv"
SEEDS = (0, 1, 2)
SPREAD = 1.01
BORDER = (Cell("deep", 0.7, 4), Cell("deep", 0.5, 8), Cell("single", 0.3, 3))


class Trial(NamedTuple):
    """A question, what is changed for it, and the run."""

    question: str
    change: str
    cell: Cell
    seed: int


def trials() -> Iterator[Trial]:
    """All of the table, question by question."""
    for seed in SEEDS:
        for friction in (0.5, 0.7):
            for side_by_side in (1, 2, 3, 6):
                yield Trial("rows", f"{side_by_side} in a row", Cell("deep", friction, 6), seed)
        for side_by_side in (1, 2, 4):
            yield Trial("rows of four", f"{side_by_side} in a row", Cell("deep", 0.7, 4), seed)
        for balls in (2, 3, 5):
            for change in ("between walls", "without walls"):
                yield Trial("walls", change, Cell("single", 0.3, balls), seed)
        for cell in (*BORDER, Cell("deep", 0.5, 7)):
            for between in (0.0, 0.3, 1.0, 2.0):
                yield Trial("friction between balls", f"{between:g} of that of the walls", cell, seed)
        for cell in BORDER:
            for change in ("as it is", "body held"):
                yield Trial("shaking", change, cell, seed)


def machine_of(trial: Trial, candidate: Candidate = A) -> ChamberMachine:
    """The machine of a trial."""
    cell = trial.cell
    asked: dict[str, Any] = {"balls": cell.balls, "friction": cell.friction, "layers": cell.layers}
    if trial.question == "friction between balls":
        return replace(candidate, between=float(trial.change.split()[0])).machine(**asked)
    machine = candidate.machine(**asked)
    if trial.change == "body held":
        return changed(machine, body={"freedom": "fixed"})
    if trial.question.startswith("rows"):
        depth = 1.01 * int(trial.change.split()[0]) * 2.0 * candidate.ball_radius(cell.balls)
        return changed(machine, chamber={"depth": depth})
    if trial.change == "without walls":
        return _without_walls(machine, candidate, cell, trial.seed)
    return machine


def _without_walls(machine: ChamberMachine, candidate: Candidate, cell: Cell, seed: int) -> ChamberMachine:
    """The same balls at the same places, but exactly in the middle of a deep chamber, where nothing moves them along the axis."""
    start = simulate_chamber(machine, duration=SAMPLE, sample=SAMPLE, seed=seed)
    settled = start["ball_position"].transpose("time", "ball", "axis").values[0]
    # a little apart, as balls that are pressed together may not start
    angle = SPREAD * np.arctan2(settled[:, 1], -settled[:, 2])
    wall, radius = candidate.radius - candidate.ball_radius(cell.balls), np.hypot(settled[:, 1], settled[:, 2])
    radius = np.where(radius > wall - 1e-4, wall - 1e-5, radius - 1e-4)
    places = np.stack([0.0 * angle, radius * np.sin(angle), -radius * np.cos(angle)], axis=1)
    deep = candidate.machine(balls=cell.balls, friction=cell.friction)
    return changed(deep, balls={"positions": np.round(places, 9).tolist()})


def row_of(trial: Trial) -> dict[str, Any]:
    """Run a trial."""
    found = watched(machine_of(trial), trial.seed, DURATION)
    return {
        "question": trial.question, "change": trial.change, **trial.cell._asdict(), "seed": trial.seed, "share": found["share"],
        "time": round(found["until"], 3),
    }  # fmt: skip


def kept() -> list[dict[str, Any]]:
    """The rows of the table."""
    if not TABLE.exists():
        return []
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [
            {**row, "friction": float(row["friction"]), "share": float(row["share"]), "time": float(row["time"])}
            | {name: int(row[name]) for name in ("balls", "seed")}
            for row in csv.DictReader(file)
        ]


def complete() -> None:
    """Run what the table lacks."""
    there = {
        (row["question"], row["change"], row["layers"], row["friction"], row["balls"], row["seed"]) for row in kept()
    }
    for trial in trials():
        if (trial.question, trial.change, *trial.cell, trial.seed) in there:
            continue
        row = row_of(trial)
        new = not TABLE.exists()
        with TABLE.open("a", encoding="utf-8", newline="") as file:
            write = csv.DictWriter(file, list(row), lineterminator="\n")
            if new:
                write.writeheader()
            write.writerow(row)
        print(*row.values(), flush=True)


def chances(rows: list[dict[str, Any]]) -> xr.Dataset:
    """Fillings carried and run, for each question, change and cell."""
    groups: dict[tuple[Any, ...], list[float]] = {}
    for row in rows:
        name = (row["question"], row["change"], row["layers"], row["friction"], row["balls"])
        groups.setdefault(name, []).append(row["share"])
    keys = list(groups)
    return xr.Dataset(
        {
            "carried": ("trial", [sum(share >= 0.9 for share in groups[key]) for key in keys]),
            "runs": ("trial", [len(groups[key]) for key in keys]),
        },
        {
            name: ("trial", [key[i] for key in keys])
            for i, name in enumerate(("question", "change", "layers", "friction", "balls"))
        },
    )


if __name__ == "__main__":
    complete()

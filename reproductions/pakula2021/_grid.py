"""The wide grid of runs behind figures 10 and 12, kept as a table because it takes half an hour to compute.

``python -m reproductions.pakula2021.figure_10 --full`` runs what the table lacks, one run after the other, and writes each
as soon as it is done; ``--full --fresh`` starts from an empty table. Numbers are written with all their digits.
"""

from __future__ import annotations

import csv
import math
import sys
import time
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import xarray as xr

import autobalancer as ab
from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.studies.chamber_study import Cell, gathered

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "deep_chamber.toml"
LOST = "the machine of the source is not printed; who is carried depends on its masses, supports and motor"
TABLE = Path(__file__).parent / "data" / "amplitudes_of_the_reference_machine.csv"
DURATION, LAST = 16.0, 1.0  # s of a run, and of its end that is the steady state
MEASURES = (
    *(f"{name}_{kind}" for name in ("vertical", "horizontal") for kind in ("amplitude", "synchronous", "peak")),
    "share_carried",
)
COUNTS = {"deep": (4, 5, 6, 8, 12, 16, 20, 30, 40, 50), "single": (3, 4, 5, 6, 8, 10)}
BORDERS = {"deep": (4, 8, 12, 20), "single": (3, 5, 8)}  # counts for frictions between those of the source


def wanted() -> list[Cell]:
    """The runs of the table, the most telling first."""
    found: list[Cell] = []
    for seed in (0, 1, 2):
        for layer in ("single", "deep"):
            found += [Cell(layer, friction, n, seed) for friction, n in product((0.3, 0.5, 0.7), COUNTS[layer])]
        if seed == 0:
            for layer in ("single", "deep"):
                found += [Cell(layer, mu, n, seed) for mu, n in product((0.4, 0.6, 0.8, 0.9), BORDERS[layer])]
    return found


def run(cell: Cell) -> dict[str, Any]:
    """Outcome and measures of one run."""
    found = ab.chamber.amplitudes(
        balls_in_chambers(MACHINE),
        [cell.balls],
        [cell.friction],
        layers=[cell.layers],
        seeds=[cell.seed],
        duration=DURATION,
        last=LAST,
        workers=1,
    ).squeeze()
    numbers = {name: float(found[name]) for name in MEASURES if name in found}
    return {"outcome": str(found["outcome"].values), **numbers}


def kept() -> dict[Cell, dict[str, Any]]:
    """The runs in the table."""
    if not TABLE.exists():
        return {}
    with TABLE.open(encoding="utf-8", newline="") as file:
        found = {}
        for row in csv.DictReader(file):
            cell = Cell(row["layers"], float(row["friction"]), int(row["balls"]), int(row["seed"]))
            numbers = {name: float(row[name]) for name in MEASURES if row[name]}
            found[cell] = {"outcome": row["outcome"], **numbers}
    return found


def table() -> xr.Dataset:
    """The table as a study."""
    held = kept()
    return gathered(list(held), list(held.values()))


def deviation(cells: Sequence[Cell]) -> float:
    """Greatest relative difference of any measure between ``cells`` run now and in the table; infinite if it lacks one."""
    held = kept()
    greatest = 0.0
    for cell in cells:
        now, then = run(cell), held.get(cell, {})
        if now["outcome"] != then.get("outcome"):
            return math.inf
        for name in MEASURES:
            one, two = now.get(name, math.nan), then.get(name, math.nan)
            if math.isnan(one) != math.isnan(two):
                return math.inf
            if one != two and not math.isnan(one):
                greatest = max(greatest, abs(one - two) / max(abs(one), abs(two)))
    return greatest


def complete(*, fresh: bool = False) -> None:
    """Run what the table lacks; refuses to mix runs of other code or another processor with those of this one."""
    if fresh:
        TABLE.unlink(missing_ok=True)
    there = kept()
    if there and deviation([next(iter(there))]) > 0.0:
        sys.exit(f"{TABLE}: was made by other code, or on another processor; start it again with --full --fresh")
    missing = [cell for cell in wanted() if cell not in there]
    began = time.process_time()
    for number, cell in enumerate(missing, 1):
        row = run(cell)
        new = not TABLE.exists()
        with TABLE.open("a", encoding="utf-8", newline="") as file:
            write = csv.writer(file, lineterminator="\n")
            if new:
                write.writerow([*Cell._fields, "outcome", *MEASURES])
            write.writerow([*cell, row["outcome"], *(repr(row[name]) if name in row else "" for name in MEASURES)])
        spent = time.process_time() - began
        print(f"{number} of {len(missing)}: {cell.layers}, {cell.balls} balls, friction {cell.friction:g}, "
              f"seed {cell.seed}; {spent:.0f} s of processor time", flush=True)  # fmt: skip

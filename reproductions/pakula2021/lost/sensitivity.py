"""One free number changed at a time: what it does to who is carried and to the numbers of the statements.

``python -m reproductions.pakula2021.lost.sensitivity [--folder DIR]``: around the fitted machine; runs are kept, tables written.
One filling is run of each cell with soft contacts, as in screening; where that is other than on the machine itself, two
fillings with the modulus of steel are run and count. (So a change that only soft contacts hide is not seen.)
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from reproductions.pakula2021.lost.candidate import Candidate
from reproductions.pakula2021.lost.runs import ENOUGH, Cell, Kept, key_of
from reproductions.pakula2021.lost.scores import CLOSED
from reproductions.pakula2021.lost.tables import SENSITIVITY, candidates, write

CELLS = (
    Cell("deep", 0.7, 3), Cell("deep", 0.7, 4), Cell("deep", 0.5, 5), Cell("deep", 0.5, 7), Cell("deep", 0.5, 8),
    Cell("deep", 0.3, 12), Cell("single", 0.3, 2), Cell("single", 0.3, 3),
)  # fmt: skip
SEEDS = (0, 1)
FACTORS = {
    "unbalance": (0.7, 1.4), "ball_mass": (0.7, 1.4), "density": (0.7, 1.4), "radius": (0.85, 1.2), "rolling_arm": (0.1, 5.0),
    "between": (0.3, 2.0), "torque": (0.6, 1.6), "supports": (0.5, 2.0), "body_inertia": (0.6, 1.6),
}  # fmt: skip
WORDS = {
    "unbalance": "unbalance", "ball_mass": "mass of the balls", "density": "density of the balls", "radius": "chamber radius",
    "rolling_arm": "rolling arm", "between": "friction between balls", "torque": "motor torque", "supports": "stiffness, damping",
    "body_inertia": "body inertia",
}  # fmt: skip


def changes(base: Candidate) -> Iterator[tuple[str, Candidate]]:
    """The machine itself, and with each number less and more."""
    yield "as it is", base
    for name, factors in FACTORS.items():
        for factor in factors:
            yield f"{WORDS[name]} × {factor:g}", replace(base, **{name: float(f"{factor * getattr(base, name):.4g}")})


def name_of(cell: Cell) -> str:
    """Short, for pictures."""
    return f"{cell.layers}, {cell.friction:g}: {cell.balls}"


def tabulate(folder: Path, base: Candidate, seconds: float) -> None:
    """Run what is missing, so many seconds at most, and write the table anew after each change."""
    kept, began = Kept(folder / "sensitivity.jsonl"), time.monotonic()
    rows: list[dict[str, object]] = []
    before: dict[Cell, float] = {}
    for change, candidate in changes(base):
        if time.monotonic() - began > seconds:
            break
        for cell in CELLS:
            found = [kept.of(candidate, cell, 0, soft=True)]
            share = found[0]["share"]
            if change == "as it is":
                before[cell] = share
            if not found[0]["soft"] or (share >= ENOUGH) != (before[cell] >= ENOUGH):  # run with steel, now or earlier
                found = [kept.of(candidate, cell, seed) for seed in SEEDS]
            hits = sum(row["share"] >= ENOUGH for row in found)
            rows.append({"change": change, "what": name_of(cell), "value": float(hits), "runs": len(found)})
        for name, of in CLOSED.items():
            rows.append({"change": change, "what": name, "value": of(candidate), "runs": 0})
        write(SENSITIVITY, rows)
        print(change, key_of(candidate), *(row["value"] for row in rows[-len(CELLS) - len(CLOSED) :]), flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("build/lost_machine"), help="where runs are kept")
    parser.add_argument("--seconds", type=float, default=3600.0, help="of runs at most")
    asked = parser.parse_args()
    tabulate(asked.folder, candidates()["fitted"], asked.seconds)

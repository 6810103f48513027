"""The machines of the table, judged by all statements: runs with the modulus of steel, in several fillings.

``python -m reproductions.pakula2021.lost.judge [--folder DIR] [--seconds S]``: run what is missing, so many seconds at most, and
write the tables of candidates, of judged statements and of all that was searched, from the runs that there are.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from reproductions.pakula2021.lost.candidate import B2, A, B, Candidate
from reproductions.pakula2021.lost.runs import Cell, Kept, key_of
from reproductions.pakula2021.lost.scores import score
from reproductions.pakula2021.lost.search import MORE, MUST, MUST_NOT, SAVED, WHOLE, Searched
from reproductions.pakula2021.lost.statements import read
from reproductions.pakula2021.lost.tables import JUDGED, MACHINES, SEARCHED, judged, write

WIDER = replace(B2, radius=0.118)  # from here on seven balls stay with 0.5
LIGHTER = Candidate(  # second of all that were searched: light balls, a heavy rotor, a strong motor
    unbalance=0.1069, ball_mass=1.655, radius=0.095, rolling_arm=2.835e-05, torque=21.6, overload=1.8, slip=0.374,
    rotor_inertia=0.6231, supports=1.0, half_span=0.3923, below=0.29, body_below=0.147, body_inertia=10.87,
)  # fmt: skip
NAMED = {"A": A, "B": B, "fitted": B2, "wider": WIDER, "lighter": LIGHTER}
FILLINGS = {"A": 3, "B": 3, "fitted": 5, "wider": 3, "lighter": 3}


def wanted() -> Iterator[tuple[Candidate, Cell, int, bool]]:
    """Runs of the tables, the most telling first; the last number says whether a run is whole."""
    for seed in range(max(FILLINGS.values())):
        for name, candidate in NAMED.items():
            if seed < FILLINGS[name]:
                for cell in (*MUST, *MUST_NOT, *MORE):
                    yield candidate, cell, seed, False
                for cell in WHOLE:
                    yield candidate, cell, seed, True
    for name, candidate in NAMED.items():
        for cell in SAVED:
            for seed in (0, 1) if name == "fitted" else (0,):
                yield candidate, cell, seed, True


def judge(folder: Path, seconds: float) -> int:
    """Run, write the tables, and say how many runs are still missing."""
    kept, began, missing = Kept(folder / "runs.jsonl"), time.monotonic(), 0
    for candidate, cell, seed, whole in wanted():
        if time.monotonic() - began < seconds:
            kept.of(candidate, cell, seed, whole=whole)
        else:
            found = kept.found.get((key_of(candidate), cell, seed))
            missing += found is None or found.get("soft", False) or (whole and not found["whole"])
    statements = read()
    entries, machines = [], []
    for name, candidate in NAMED.items():
        key = key_of(candidate)

        def held(cell: Cell, key: str = key) -> list[dict[str, object]]:
            return kept.held(key, cell)

        entries += [entry._asdict() for entry in judged(name, statements, candidate, held)]
        machines.append({"machine": name, **candidate.as_dict(), "score": score(statements, candidate, held)})
    searched = Searched(folder)
    order = sorted(searched.candidates, key=lambda key: (searched.rung[key], searched.score[key]), reverse=True)
    if order:
        rows = [(searched.rung[key], searched.score[key], searched.candidates[key].as_dict()) for key in order]
        write(SEARCHED, [{"rung": rung, "score": value, **numbers} for rung, value, numbers in rows])
    write(JUDGED, entries)
    write(MACHINES, machines)
    return missing


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("build/lost_machine"), help="where runs are kept")
    parser.add_argument("--seconds", type=float, default=3600.0, help="of runs at most")
    asked = parser.parse_args()
    print("runs missing:", judge(asked.folder, asked.seconds))

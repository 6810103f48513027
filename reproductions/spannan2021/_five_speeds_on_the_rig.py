"""Which rolling resistance, adherence and drag the five speeds exclude on the rig of bodies and softening bushings.

``python -m reproductions.spannan2021._five_speeds_on_the_rig`` makes the table ``data/five_speeds_on_the_rig.csv`` in ten
minutes or more: the speed of the slowest ball at the end of each speed. A run of guided balls costs about two seconds,
one of resolved balls about four.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import numpy as np

from reproductions.spannan2021._five_speeds import STARTS, lines_of, meets_all, profile
from reproductions.spannan2021._rig_on_rubber import on_the_rig

TABLE = Path(__file__).parent / "data" / "five_speeds_on_the_rig.csv"
ROLLING = (0.0, 0.001, 0.002, 0.003, 0.005, 0.01)
CASES: dict[str, dict[str, float]] = {
    "": {},
    "twice the adherence": {"times": 2.0},
    "five times the adherence": {"times": 5.0},
    "drag plateau 0.48": {"plateau": 0.48},
    "drag plateau 0.74": {"plateau": 0.74},
}
HEAD = ["balls", "case", "rolling_resistance", "start", "rpm_460", "rpm_520", "rpm_580", "rpm_640", "rpm_700"]


def make() -> None:
    """Run all cases and write the table."""
    with TABLE.open("w", newline="") as file:
        file.write(
            "# Speed of the slowest ball in space at the end of each speed, rad/s; made by _five_speeds_on_the_rig.py\n"
        )
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(HEAD)
        for balls in ("guided", "resolved"):
            for name, case in CASES.items():
                for rolling in ROLLING:
                    for number, start in enumerate(STARTS, 1):
                        machine = on_the_rig(profile(), rolling, resolved=balls == "resolved", start=start, **case)
                        found = [f"{line:.2f}" for line in lines_of(machine)]
                        rows.writerow([balls, name, f"{rolling:g}", number, *found])
                        file.flush()


def lines_of_case(balls: str, case: str, rolling: float, start: int) -> np.ndarray:
    """Speeds of the slowest ball of one run of the table, rad/s; starts count from 1."""
    for row in read():
        if (row["balls"], row["case"]) == (balls, case) and (float(row[HEAD[2]]), int(row["start"])) == (
            rolling,
            start,
        ):
            return np.array([float(row[key]) for key in HEAD[4:]])
    raise KeyError((balls, case, rolling, start))


def starts_that_meet(balls: str) -> dict[str, list[int]]:
    """How many of three starts meet all five speeds, for each case and rolling resistance."""
    numbers = range(1, len(STARTS) + 1)
    return {
        case: [sum(meets_all(lines_of_case(balls, case, rolling, start)) for start in numbers) for rolling in ROLLING]
        for case in CASES
    }


@cache
def read() -> list[dict[str, str]]:
    """Rows of the table."""
    with TABLE.open(newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


if __name__ == "__main__":
    make()

"""How well a candidate meets the statements: chances over the fillings, with intervals, and one number of all.

A published run is one filling, so what a statement counts is the chance that a run of the candidate says the same. With k of
n fillings that do, (k + 1/2)/(n + 1) is its estimate and Wilson's interval its range. The score is the mean of the logarithm over
the statements: 0 if all are met for certain. What a number counts falls like a normal law of its distance, down to a limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from reproductions.pakula2021.lost.candidate import DAMPING, TOTAL_MASS, Candidate
from reproductions.pakula2021.lost.closed import chatter, filled
from reproductions.pakula2021.lost.runs import DURATION, ENOUGH, Cell
from reproductions.pakula2021.lost.statements import Statement

READ = 24.0  # s, two dozen: the source calls a few dozen seconds typical; free vibrations decay until then
NORMAL = 1.645  # of a two-sided interval of 90 %
WORST = -4.0  # of a number that is far off: it must not outweigh all others
Held = Callable[[Cell], Sequence[dict[str, Any]]]

CLOSED: dict[str, Callable[[Candidate], float]] = {
    "chatter": chatter,
    "diameter_of_four": lambda candidate: 2.0 * candidate.ball_radius(4),
    "filled_by_nine": lambda candidate: filled(candidate, 9),
    "filled_by_ten": lambda candidate: filled(candidate, 10),
}
SAVING = {"deep": (8, 12, 20, 30, 50), "single": (3, 5, 7, 8, 9, 10)}


def interval(hits: float, runs: int) -> tuple[float, float]:
    """Wilson's interval of a chance, 90 %; from 0 to 1 without runs."""
    if runs == 0:
        return 0.0, 1.0
    square, share = NORMAL**2, hits / runs
    middle = (share + square / (2.0 * runs)) / (1.0 + square / runs)
    half = NORMAL / (1.0 + square / runs) * math.sqrt(share * (1.0 - share) / runs + square / (4.0 * runs**2))
    return max(middle - half, 0.0), min(middle + half, 1.0)


def agreeing(statement: Statement, cell: Cell, held: Held) -> tuple[int, int]:
    """(fillings that do as the statement says, fillings) of a cell."""
    rows = held(cell)
    wanted = statement.demands(cell.balls) if not statement.some else True
    return sum((row["share"] >= ENOUGH) == wanted for row in rows), len(rows)


def number(statement: Statement, candidate: Candidate, held: Held) -> float:
    """The number of a statement, the median over fillings; nan where there is no run."""
    values = numbers(statement, candidate, held)
    return float(np.median(values)) if values else math.nan


def numbers(statement: Statement, candidate: Candidate, held: Held) -> list[float]:
    """The number of a statement in each filling; infinite for balls that did not settle."""
    if statement.measure in CLOSED:
        return [CLOSED[statement.measure](candidate)]
    if statement.measure == "saving":
        return [value for value in [saving(statement.friction, candidate, held)] if math.isfinite(value)]
    rows = [row for cell in statement.cells for row in held(cell) if statement.measure in row]
    if statement.measure == "amplitude":
        return [late(row, candidate) for row in rows]
    return [row[statement.measure] if math.isfinite(row[statement.measure]) else math.inf for row in rows]


def late(row: dict[str, Any], candidate: Candidate) -> float:
    """Vertical amplitude when the source may have read it (m): the free vibration of the end of the run has decayed by then."""
    rate = candidate.supports * DAMPING / (TOTAL_MASS + candidate.ball_mass)  # half of twice the damping along z
    free = max(row["amplitude"] - row["synchronous"], 0.0) if row["share"] >= ENOUGH else 0.0
    return float(row["amplitude"] - free * (1.0 - math.exp(-rate * (READ - DURATION))))


def saving(friction: float, candidate: Candidate, held: Held) -> float:
    """One less the ratio of the mean amplitudes of both chambers, %."""
    means = {}
    for layers, counts in SAVING.items():
        rows = [[row for row in held(Cell(layers, friction, n)) if "amplitude" in row] for n in counts]
        each = [[late(row, candidate) for row in found] for found in rows]
        means[layers] = over_counts(counts, [float(np.mean(values)) if values else math.nan for values in each])
    return 100.0 * (1.0 - means["deep"] / means["single"])


def over_counts(counts: Sequence[int], values: Sequence[float]) -> float:
    """Mean over all whole numbers from the first to the last count, straight lines between those that were run."""
    whole = np.arange(counts[0], counts[-1] + 1)
    return float(np.interp(whole, counts, values).mean())


def log_chance(statement: Statement, candidate: Candidate, held: Held) -> float:
    """Logarithm of the chance that the candidate says what the statement does; nan without runs."""
    if statement.value is not None:
        chances = [math.exp(_of_number(statement, value)) for value in numbers(statement, candidate, held)]
        return math.log(float(np.mean(chances))) if chances else math.nan
    found = [agreeing(statement, cell, held) for cell in statement.cells]
    found = [(hits, runs) for hits, runs in found if runs]
    if not found:
        return math.nan
    chances = [(hits + 0.5) / (runs + 1.0) for hits, runs in found]
    return math.log(max(chances)) if statement.some else float(np.mean(np.log(chances)))


def _of_number(statement: Statement, value: float) -> float:
    wanted = statement.value or 0.0
    if statement.within is not None:
        off = (value - wanted) / statement.within
    else:
        off = math.log(max(value, 1e-30) / wanted) / math.log(statement.factor or 2.0)
    if (statement.most and off < 0.0) or (statement.least_value and off > 0.0):
        off = 0.0
    return max(-0.5 * off**2, WORST)


def score(statements: Sequence[Statement], candidate: Candidate, held: Held) -> float:
    """Mean of the logarithms of the statements that can be judged."""
    found = [(log_chance(statement, candidate, held), statement.weight) for statement in statements]
    known = [(value, weight) for value, weight in found if weight and not math.isnan(value)]
    if not known:
        return -math.inf
    values, weights = zip(*known, strict=True)
    return float(np.average(values, weights=weights))

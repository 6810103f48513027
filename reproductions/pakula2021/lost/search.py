"""The search: rungs of more and more costly runs, and only the better candidates climb.

Every run is kept as soon as it is done, so a search that was stopped goes on. Statements that exclude each other are scored
like all others; the sum then is greatest where both happen by chance.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from reproductions.pakula2021.lost.candidate import BETWEEN, A, B, C, Candidate
from reproductions.pakula2021.lost.explore import anywhere, near
from reproductions.pakula2021.lost.runs import Cell, Kept, key_of
from reproductions.pakula2021.lost.scores import SAVING, score
from reproductions.pakula2021.lost.statements import Statement, read

POOL = 30  # best candidates from which new ones come
WIDE = 0.12  # share of new candidates that come from anywhere
PICKED_FROM = 6  # drawings, of which the one with the best size of balls is run


class Rung(NamedTuple):
    """Runs of one rung, whether they are whole, the share of candidates that climbs on, whether contacts are soft."""

    cells: tuple[Cell, ...]
    seeds: tuple[int, ...]
    whole: bool
    climbs: float
    soft: bool = False


MUST = (Cell("deep", 0.7, 4), Cell("deep", 0.5, 8), Cell("single", 0.3, 3))
MUST_NOT = (Cell("deep", 0.5, 7), Cell("deep", 0.7, 3), Cell("deep", 0.3, 12), Cell("single", 0.3, 2))
WHOLE = (Cell("deep", 0.7, 5), Cell("deep", 0.5, 5))
MORE = (Cell("single", 0.3, 5), Cell("single", 0.3, 8), Cell("deep", 0.3, 8), Cell("deep", 0.3, 20))
SAVED = tuple(Cell(layers, 0.5, n) for layers, counts in SAVING.items() for n in reversed(counts))
RUNGS = (
    Rung(MUST, (0,), False, 0.4, soft=True),
    Rung(MUST_NOT, (0,), False, 0.4, soft=True),
    Rung(SAVED, (0,), True, 0.5, soft=True),
    Rung(WHOLE, (0, 1), True, 0.5),
    Rung((*MUST, *MUST_NOT, *MORE), (0, 1, 2), False, 0.0),
)


class Searched:
    """Candidates with the rung that they reached and their score, in files of a folder."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.statements: list[Statement] = read()
        self.runs = Kept(folder / "runs.jsonl")
        self.path = folder / "candidates.jsonl"
        self.rung: dict[str, int] = {}
        self.score: dict[str, float] = {}
        self.at: list[list[float]] = [[] for _ in RUNGS]  # scores of all candidates that stood on a rung
        self.candidates: dict[str, Candidate] = {}
        if self.path.exists():
            for line in self.path.read_text(encoding="utf-8").splitlines():
                row = json.loads(line)
                self._enter(Candidate(**row["candidate"]), row["scores"])

    def _enter(self, candidate: Candidate, scores: list[float]) -> None:
        key = key_of(candidate)
        self.candidates[key], self.rung[key], self.score[key] = candidate, len(scores), scores[-1]
        for rung, value in enumerate(scores):
            self.at[rung].append(value)

    def best(self) -> list[Candidate]:
        """The pool of parents: those that climbed highest, by their score."""
        order = sorted(self.candidates, key=lambda key: (self.rung[key], self.score[key]), reverse=True)
        return [self.candidates[key] for key in order[:POOL]]

    def judged(self, candidate: Candidate) -> float:
        """Score of all that is known of a candidate."""
        key = key_of(candidate)
        return score(self.statements, candidate, lambda cell: self.runs.held(key, cell))

    def climb(self, candidate: Candidate) -> list[float]:
        """Run a candidate up the rungs until others are better."""
        scores = []
        for number, rung in enumerate(RUNGS):
            for cell in rung.cells:
                for seed in rung.seeds:
                    self.runs.of(candidate, cell, seed, whole=rung.whole, soft=rung.soft)
            value = self.judged(candidate)
            scores.append(value)
            past = self.at[number]
            if value < float(np.quantile([*past, value], 1.0 - rung.climbs)):
                break
        self._enter(candidate, scores)
        with self.path.open("a", encoding="utf-8") as file:
            print(json.dumps({"candidate": candidate.as_dict(), "scores": scores}), file=file, flush=True)
        return scores


def proposals(searched: Searched, random: np.random.Generator) -> Iterator[Candidate]:
    """Candidates without end: the three of the first search and some between them, then new ones."""
    yield from (A, B, C, *BETWEEN)
    while True:
        drawn = []
        for _ in range(PICKED_FROM):
            drawn.append(anywhere(random) if random.random() < WIDE else near(random, searched.best()))
        yield max(drawn, key=lambda candidate: score(searched.statements, candidate, lambda cell: []))


def search(folder: Path, minutes: float) -> None:
    """Search for so many minutes of processor time; every candidate is a line of the log."""
    searched = Searched(folder)
    random = np.random.default_rng(len(searched.candidates))
    began = time.process_time()
    for candidate in proposals(searched, random):
        key = key_of(candidate)
        if key in searched.candidates:
            continue
        scores = searched.climb(candidate)
        spent = (time.process_time() - began) / 60.0
        told = " ".join(f"{value:.2f}" for value in scores)
        numbers = " ".join(f"{value:g}" for value in candidate.as_dict().values())
        print(f"{spent:.1f} min, {len(searched.candidates)}: {key} rung {len(scores)}: {told} | {numbers}", flush=True)
        if spent > minutes:
            break

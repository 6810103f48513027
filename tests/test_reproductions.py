"""The scoreboard of reproduced publications: kinds, totals and the long tables behind it."""

from __future__ import annotations

import math
from importlib import import_module

import numpy as np
import pytest
from reproductions import KINDS, Found, compared_all, said
from reproductions.pakula2021._grid import MEASURES, deviation, kept, run
from reproductions.rodrigues2011.balls import from_heavy_spot, with_balls
from tools.ledger import BENCHMARKS, REPRODUCTIONS, Ledger, markdown, totals

from autobalancer.studies.chamber_study import Cell


def test_a_row_of_no_known_kind_is_refused_with_those_there_are() -> None:
    row = Found("guessed", "speed", "rad/s", 1.0, 1.0, 0.1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"speed: kind 'guessed'; must be one of printed, misprint, closed form"):
        compared_all("A 2000", "1", [row])


def test_totals_count_hits_and_misses_of_each_kind() -> None:
    rows = compared_all(
        "A 2000",
        "1",
        [
            Found("printed", "one", "1", 1.0, 1.05, 0.1),
            Found("printed", "two", "1", 1.0, 1.2, 0.1, "why"),
            Found("fitted", "three", "1", 1.0, 1.0, 0.0, figure="2"),
            Found("words", "not a number", "1", 1.0, math.nan, 0.1),
            said("four", True),
            Found("excluded model", "five", "1", 1.0, 1.2, 0.1),
            Found("excluded model", "six", "1", 1.0, 1.05, 0.1),
            Found("excluded model", "no number", "1", 1.0, math.nan, 0.1),
        ],
    )
    assert [row["verdict"] for row in rows] == ["hit", "missed", "hit", "missed", "hit", "hit", "missed", "missed"]
    assert [row["figure"] for row in rows] == ["1", "1", "2", "1", "1", "1", "1", "1"]
    assert [row.get("note") for row in rows] == [None, "why", None, None, None, None, None, None]
    kept = REPRODUCTIONS.checked(rows)
    assert totals(REPRODUCTIONS, kept) == [
        {"kind": "printed", "rows": 2, "hits": 1, "missed": 1},
        {"kind": "words", "rows": 2, "hits": 1, "missed": 1},
        {"kind": "excluded model", "rows": 3, "hits": 1, "missed": 2},
        {"kind": "fitted", "rows": 1, "hits": 1, "missed": 0},
        {"kind": "all", "rows": 8, "hits": 4, "missed": 4},
    ]
    assert "| A 2000 | 1 | printed | two |" in markdown(list(REPRODUCTIONS.shown), kept)


def test_a_row_without_a_kind_is_not_kept() -> None:
    rows = compared_all("A 2000", "1", [said("four", True)])
    del rows[0]["kind"]
    with pytest.raises(ValueError, match=r"missing \['kind'\]"):
        REPRODUCTIONS.checked(rows)
    assert totals(BENCHMARKS, [{"name": "speed", "value": 1.0}]) == []


@pytest.mark.parametrize("ledger", [BENCHMARKS, REPRODUCTIONS], ids=lambda ledger: ledger.name)
def test_every_module_finds_what_it_imports(ledger: Ledger) -> None:
    modules = [import_module(f"{ledger.name}.{name}") for name in ledger.modules()]
    assert sum(hasattr(module, ledger.function) for module in modules) > 10


def test_every_kind_is_explained() -> None:
    assert all(len(text) > 20 for text in KINDS.values())


@pytest.mark.slow
@pytest.mark.parametrize("cell", [Cell("single", 0.7, 5, 0), Cell("deep", 0.7, 4, 0)], ids=["single", "deep"])
def test_the_table_behind_the_amplitudes_of_deep_chambers_is_that_of_the_present_code(cell: Cell) -> None:
    # Processors round differently, by vectors of four or eight numbers; impacts over 16 s make 6e-9 of it where it was seen.
    assert deviation([cell]) < 1e-6


@pytest.mark.slow
def test_the_table_behind_the_amplitudes_of_deep_chambers_tells_a_friction_that_is_a_little_greater() -> None:
    cell = Cell("deep", 0.7, 4, 0)
    greater, then = run(cell._replace(friction=0.7 * (1.0 + 1e-4))), kept()[cell]
    assert max(abs(greater[name] / then[name] - 1.0) for name in MEASURES if then.get(name)) > 1e-5


@pytest.mark.slow
def test_balls_in_thick_fluid_end_at_the_amplitudes_of_an_independent_integration() -> None:
    # equations (1), (2) of Rodrigues et al. (2011) with c_b = 1, integrated apart from this package for 60 s
    known = {2040.0: 0.043, 2310.0: 0.066, 2550.0: 0.024}  # rpm, mm
    found = from_heavy_spot(with_balls(1.0), np.array(list(known)), dwell=59.0, window=1.0)
    np.testing.assert_allclose(found["greatest_mean_deflection"] * 1e3, list(known.values()), atol=5e-4)

"""Pictures of the search: statements by machines, and what one change does to each statement."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from autobalancer.plots.style import INK, heading, look, picture
from reproductions.pakula2021.lost.statements import Statement
from reproductions.pakula2021.lost.tables import Entry

COLORS = "PRGn"  # a half is white: what a coin would do


def statements_by_machines(statements: Sequence[Statement], found: Sequence[Entry], title: str) -> Figure:
    """Chance of every statement (rows) on every machine (columns); in each field what was run, or the number."""
    machines = list(dict.fromkeys(entry.machine for entry in found))
    rows = [statement for statement in statements if any(entry.statement == statement.key for entry in found)]
    chance = np.full((len(rows), len(machines)), np.nan)
    place = {statement.key: i for i, statement in enumerate(rows)}
    with look():
        figure = picture(3.6 + 1.35 * len(machines), 0.9 + 0.34 * len(rows))
        axes = figure.subplots()
        for entry in found:
            i, j = place[entry.statement], machines.index(entry.machine)
            chance[i, j] = entry.chance
            dark = abs(entry.chance - 0.5) > 0.35
            axes.text(
                j,
                i,
                entry.shown.replace("um", "µm"),
                ha="center",
                va="center",
                fontsize=7.0,
                color="white" if dark else INK,
            )
        image = axes.imshow(chance, cmap=COLORS, vmin=0.0, vmax=1.0, aspect="auto")
        axes.set_yticks(range(len(rows)), [_label(statement) for statement in rows])
        axes.set_xticks(range(len(machines)), machines)
        axes.xaxis.tick_top()
        axes.grid(visible=False)
        axes.tick_params(length=0)
        bar = figure.colorbar(image, ax=axes, fraction=0.03, pad=0.02)
        bar.set_label("chance that a run says the same")
        heading(figure, title)
    return figure


def _label(statement: Statement) -> str:
    words = {
        "deep_07": "deep, 0.7: 3 stay, 4 go", "deep_05": "deep, 0.5: 7 stay, 8 go", "five_at_05": "deep, 0.5: 5 go",
        "deep_03": "deep, 0.3: none goes", "not_below_03": "deep, 0.3: some go", "as_one_ball": "deep, 0.7: 4 stay",
        "single_two": "single, 0.3: 2 stay", "single_more": "single, 0.3: 3, 5, 8 go", "best": "5 at 0.7: 6 µm",
        "saving": "saving 83 %", "settled": "5 at 0.5: 8.6 s", "force_x": "force 1500 N",
        "row_of_four": "row of four: 50 mm", "half_the_race": "nine fill half", "ten_fit": "ten fit",
    }  # fmt: skip
    return words.get(statement.key, statement.key)


def changes(base: dict[str, float], found: Sequence[tuple[str, str, float]], title: str) -> Figure:
    """Who is carried (green) after one change (rows) in each cell (columns), with a ring where the change made the difference."""
    rows, columns = ["as it is", *dict.fromkeys(change for change, _, _ in found)], list(base)
    field = np.full((len(rows), len(columns)), np.nan)
    field[0] = list(base.values())
    for change, cell, chance in found:
        field[rows.index(change), columns.index(cell)] = chance
    with look():
        figure = picture(2.9 + 0.62 * len(columns), 1.1 + 0.24 * len(rows))
        axes = figure.subplots()
        axes.imshow(field, cmap=COLORS, vmin=-0.35, vmax=1.35, aspect="auto")
        for i, j in zip(*np.nonzero(np.isfinite(field) & (np.abs(field - field[0]) > 0.4)), strict=True):
            axes.plot(j, i, "o", mfc="none", mec=INK, ms=8, mew=1.2)
        axes.set_yticks(range(len(rows)), rows)
        axes.set_xticks(range(len(columns)), columns, rotation=40, ha="left")
        axes.xaxis.tick_top()
        axes.grid(visible=False)
        axes.tick_params(length=0)
        heading(figure, title)
    return figure

"""Pictures of a study with their words, for those who do not see them: the package's own plots."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.shelf import Studies
from autobalancer.app.store.studies.work import columns_of
from autobalancer.plots.studies.fan import envelopes as envelopes_picture
from autobalancer.plots.studies.rests import rest_positions
from autobalancer.plots.studies.sensitivity import sensitivity as sensitivity_picture
from autobalancer.plots.studies.study import study as study_picture
from autobalancer.results.answers.studied import Studied
from autobalancer.shown import Column
from autobalancer.studies.study.fan import envelopes
from autobalancer.studies.study.sensitivity import sensitivity

OVER, RESTS, DRIVES, FAN = "over", "rests", "drives", "fan"
WORDS = {OVER: "over the grid", RESTS: "rest positions", DRIVES: "what drives it", FAN: "fan of run-ups"}
FAN_RUNS = 60
SAID = 12  # rows of a table that the words of a picture repeat

Drawn = tuple[Callable[[], Any], str]  # draws a figure; says what it shows


def offered(found: Studied) -> dict[str, str]:
    """Which pictures there are of a study."""
    grid = bool(found.grid_names())
    known = {OVER: WORDS[OVER] if grid else "distribution"}
    if "ball_angle_to_unbalance" in found:
        known[RESTS] = WORDS[RESTS]
    if [name for name in np.atleast_1d(found.attrs.get("inputs", [])) if str(name) != "start"] or (
        found.attrs.get("plan") == "sensitivity"
    ):
        known[DRIVES] = WORDS[DRIVES]
    if "balanced" in found and not found.sudden:
        known[FAN] = WORDS[FAN]
    return known


def drawn(shelf: Studies, name: str, found: Studied, kind: str, quantity: str, point: int, job: Job) -> Drawn:
    """A picture of a study, ready to be drawn.

    Raises
    ------
    QuestionError
        If the study has no such picture, in the words of the package.
    """
    if kind == RESTS:
        return lambda: rest_positions(found), _rests(found)
    if kind == DRIVES:
        driven = sensitivity(found, quantity)
        return lambda: sensitivity_picture(driven, point=point), said(driven.heading(), driven.columns())
    if kind == FAN:
        asked = shelf.file(name, shelf.entry(name).file)
        fan = envelopes(asked, members=FAN_RUNS, point=point, progress=job.progress)
        return lambda: envelopes_picture(fan), said(str(fan.attrs["title"]), _some(fan.columns("rpm")))
    return lambda: study_picture(found, quantity), said(
        f"{found.heading()}: {quantity.replace('_', ' ')}", columns_of(found, quantity)
    )


def said(title: str, columns: list[Column]) -> str:
    """A table in words."""
    cells = [[f"{column.head} {cell} {column.unit}".strip() for cell in column.cells()] for column in columns]
    rows = [", ".join(row) for row in zip(*cells, strict=True)]
    more = f"; and {len(rows) - SAID} more" if len(rows) > SAID else ""
    return f"{title}. {'; '.join(rows[:SAID])}{more}"


def needs_quantity(kind: str) -> bool:
    """Whether a picture shows one quantity."""
    return kind in (OVER, DRIVES)


def default_quantity(found: Studied, known: dict[str, str]) -> str:
    """What is shown first: what the study shows in its table, else the first quantity that is not the same in all members."""
    asked = np.atleast_1d(found.attrs.get("show", [])).astype(str).tolist()
    differs = [name for name in known if np.unique(found[name].values.astype(float)).size > 1]
    return next((name for name in (*asked, *differs, *known) if name in known), "")


def _some(columns: list[Column]) -> list[Column]:
    """A few rows of a long table."""
    count = max((len(column.values) for column in columns), default=0)
    rows = np.unique(np.linspace(0, count - 1, min(count, SAID)).astype(int))
    return [Column(one.head, [one.values[row] for row in rows], one.unit, one.form) for one in columns]


def _rests(found: Studied) -> str:
    """Of each point, how many balls end within 15 degrees of where."""
    texts = found.point_texts("rpm")
    parts = []
    for where, text in zip(found.at_points(), texts, strict=True):
        angles = np.degrees(found["ball_angle_to_unbalance"].values[where & found.counted()])
        known = angles[np.isfinite(angles)] % 360.0
        if known.size:
            counts = np.bincount(((known + 15.0) // 30.0).astype(int) % 12, minlength=12)
            best = int(counts.argmax())
            parts.append(
                f"{text or 'all'}: most balls, {100.0 * counts[best] / known.size:.0f} %, near {30 * best} degrees"
            )
    return f"{found.heading()}: places of the balls at the end, counted from the unbalance. {'; '.join(parts[:SAID])}"

"""Pages of runs: one run-up as picture and verdict, many from random starts as shares and quantiles."""

from __future__ import annotations

import math
from shlex import quote
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.either_kind import compare, measures, verdict
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine import Machine
from autobalancer.patience import silent
from autobalancer.plots.measured.overlay import overlay
from autobalancer.plots.run.race import race
from autobalancer.plots.run.run_up import run_up
from autobalancer.plots.stability.ensemble import ensemble_distribution
from autobalancer.plots.studies.fan import envelopes as envelopes_picture
from autobalancer.plots.studies.sensitivity import sensitivity as sensitivity_picture
from autobalancer.plots.studies.study import study as study_picture
from autobalancer.reporting.page import (
    Block,
    Decisive,
    Paragraph,
    Rows,
    Section,
    columns_table,
    drawing,
    facts,
    yes_or_no,
)
from autobalancer.results.answers.ensemble import Ensemble
from autobalancer.results.answers.studied import Studied
from autobalancer.results.number_text import length_text
from autobalancer.results.verdict.rule import BALANCED
from autobalancer.results.verdict.text import verdict_lines
from autobalancer.shown import rpm_and_si
from autobalancer.studies.basin import basin
from autobalancer.studies.study.fan import envelopes
from autobalancer.studies.study.sensitivity import sensitivity

SCATTER = 0.01  # of a peak, below which its distribution is not drawn
SHOWN = ("balanced", "peak_deflection", "settling_time")


def run_page(run: xr.Dataset, held: xr.Dataset, command: str) -> Section:
    """The run-up with its verdict, compared with the same machine with its balls held."""
    judged = verdict(run, held)
    headline, rows, notes = verdict_lines(judged, rpm_and_si)
    page = Section("Run-up", [Paragraph(headline, strong=True)], command)
    about = "one run of the machine file"
    page.decisive.append(Decisive("one run-up", headline.partition(";")[0], yes_or_no(judged.word == BALANCED), about))
    page.blocks.append(
        drawing(
            run_up(run, held=held), "Rotor and ball speeds, deflection (shaded) and ball angles in the rotor over time."
        )
    )
    page.blocks.append(facts(rows))
    page.blocks += [Paragraph(text) for text in notes]
    if "time" in run.dims:
        page.blocks.append(drawing(race(run), "Balls, races and unbalance at the end of the run, seen in the rotor."))
    return page


def residual_of(run: xr.Dataset) -> float:
    """Residual unbalance at the end of a run, kg m; nan if it has none."""
    found = measures(run)
    values = found["residual_unbalance"].values if "residual_unbalance" in found else np.array([np.nan])
    return float(np.sum(values))


def starts_page(found: Ensemble, command: str) -> Section:
    """How run-ups from random starts end."""
    page = Section(f"{found.sizes['member']} random starts of the balls", replay=command)
    page.blocks.append(columns_table(found.columns("rpm")))
    page.blocks.append(Paragraph("95 %: the share of very many starts is in this interval with a probability of 95 %."))
    page.blocks += [Paragraph(text) for text in (*found.spread(), *found.without())]
    share, low, high = (100.0 * one for one in found.share_of(found["balanced"].values))
    page.decisive.append(
        Decisive(
            "run-ups from random starts",
            f"{share:.3g} % ({low:.3g} to {high:.3g} %) end balanced",
            condition=f"{found.sizes['member']} starts of the machine file, with its unbalance and its fluid",
        )
    )
    peaks = found["peak_deflection"].values
    known = peaks[np.isfinite(peaks)]
    if known.size and np.ptp(known) > SCATTER * known.max():
        page.blocks.append(
            drawing(ensemble_distribution(found, "peak_deflection"), "Share of the starts below each peak deflection.")
        )
    return page


def fan_page(machine: Machine, starts: int, seed: int, command: str) -> Section:
    """Run-up and coast-down from random starts, as percentiles."""
    page = Section("Run-up and coast-down", replay=command)
    down = True
    try:
        fan = envelopes(machine, members=starts, coast_down=True, seed=seed, progress=silent)
    except QuestionError as reason:
        down = False
        page.blocks.append(Paragraph(f"No coast-down: {reason}"))
        fan = envelopes(machine, members=starts, seed=seed, progress=silent)
    top = np.array([fan[f"below_{percent}"].values for percent in (50, 95, 100)])
    half = top.shape[1] // 2 if down else top.shape[1]
    parts = [("run-up", top[:, :half]), *([("coast-down", top[:, half:])] if down else [])]
    rows = [(name, *(length_text(float(row.max())) for row in part)) for name, part in parts]
    heads = ("", "greatest of the median", "of 95 % of the runs", "of all runs")
    said = "; ".join(f"{row[0]} {row[2]}" for row in rows)
    about = f"{int(fan.attrs['members'])} random starts of the machine file"
    page.decisive.append(Decisive("deflection that 95 % of the runs stay below", said, condition=about))
    page.blocks.append(Rows(heads, tuple(rows), (False, True, True, True)))
    words = "Deflection of run-ups from random starts, and back down as fast as up" if down else "Deflection of run-ups"
    page.blocks.append(
        drawing(envelopes_picture(fan), f"{words}: bands of 50 % and 90 % of {int(fan.attrs['members'])} runs.")
    )
    return page


def basin_page(machine: Machine, speed: float, starts: int, seed: int, command: str) -> Section:
    """Which states are reached at the highest speed, from random angles of the balls."""
    page = Section("Basins at the highest speed", replay=command)
    try:
        found = basin(machine, speed, random=starts, seed=seed, progress=silent)
    except AutobalancerError as reason:
        page.blocks.append(Paragraph(f"Not stated: {reason}"))
        return page
    page.blocks.append(columns_table(found.columns("rpm")))
    page.blocks.append(
        Paragraph(
            "The rotor starts at its speed, the balls at random angles at rest in the rotor. "
            "95 %: the share of very many starts is in this interval with a probability of 95 %."
        )
    )
    page.blocks += [Paragraph(text) for text in found.remarks()]
    return page


def measured_page(run: xr.Dataset, measured: xr.Dataset, command: str) -> Section:
    """What was measured beside the run-up."""
    found = compare(run, measured)
    page = Section("Measured and computed", replay=command)
    if rows := found.facts():
        page.blocks.append(facts(rows))
    page.blocks.append(columns_table(found.columns("rpm")))
    page.blocks += [Paragraph(text) for text in found.remarks()]
    page.blocks.append(drawing(overlay(found), "What was measured, and the run-up of the model in its place."))
    return page


def study_pages(found: Studied, file: str) -> list[Section]:
    """A study with its pictures, and which scatter drives it."""
    command = f"autobalancer study {quote(str(found.attrs.get('study_file', 'study.toml')))} --out {quote(file)}"
    page = Section(f"Study {found.attrs.get('study_name', '')}".strip(), replay=command)
    page.blocks.append(facts(_asked(found)))
    page.blocks.append(columns_table(found.columns("rpm")))
    page.blocks += [Paragraph(text) for text in found.remarks()]
    pages = [page]
    driven, asked = Section("Which scatter drives the result"), list[str]()
    for name in (name for name in SHOWN if name in found):
        _add(page.blocks, lambda name=name: drawing(study_picture(found, name), f"{_words(name)} over the study."))
        if _add(driven.blocks, lambda name=name: _driven(found, name)):
            asked.append(f"{command} --sensitivity {name}")
    driven.replay = "\n".join(asked)
    if driven.blocks:
        pages.append(driven)
    return pages


def _driven(found: Studied, name: str) -> Block:
    return drawing(
        sensitivity_picture(sensitivity(found, name)),
        f"What drives the scatter of {_words(name)}, with 95 % intervals.",
    )


def _add(blocks: list[Block], made: Any) -> bool:
    """Add what can be drawn, and say whether it was; a quantity that does not scatter has no picture."""
    try:
        blocks.append(made())
    except AutobalancerError:
        return False
    return True


def _asked(found: Studied) -> list[tuple[str, str]]:
    import json

    asked = json.loads(found.attrs["study"])
    rows = [("plan", str(asked["plan"])), ("seed", str(asked["seed"])), ("members", str(found.sizes["member"]))]
    points = math.prod(len(values) for values in asked["grid"].values())
    rows += [("of them at each point of the grid", str(found.sizes["member"] // points))] if points > 1 else []
    rows += [(f"grid: {name} (SI)", ", ".join(values)) for name, values in asked["grid"].items()]
    return rows + [(f"scatter: {name} (SI)", str(text)) for name, (*_, text) in asked["scatter"].items()]


def _words(name: str) -> str:
    return name.replace("_", " ")

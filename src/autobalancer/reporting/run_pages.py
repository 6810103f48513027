"""Pages of runs: one run-up as picture and verdict, many from random starts as shares and quantiles."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.either_kind import measures, verdict
from autobalancer.errors import AutobalancerError
from autobalancer.plots.run.race import race
from autobalancer.plots.run.run_up import run_up
from autobalancer.plots.stability.ensemble import ensemble_distribution
from autobalancer.plots.studies.sensitivity import sensitivity as sensitivity_picture
from autobalancer.plots.studies.study import study as study_picture
from autobalancer.reporting.page import Block, Paragraph, Section, columns_table, drawing, facts
from autobalancer.results.answers.ensemble import Ensemble
from autobalancer.results.answers.studied import Studied
from autobalancer.results.verdict.text import verdict_lines
from autobalancer.shown import rpm_and_si
from autobalancer.studies.study.sensitivity import sensitivity

SCATTER = 0.01  # of a peak, below which its distribution is not drawn
SHOWN = ("balanced", "peak_deflection", "settling_time")


def run_page(run: xr.Dataset, held: xr.Dataset, command: str) -> Section:
    """The run-up with its verdict, compared with the same machine with its balls held."""
    headline, rows, notes = verdict_lines(verdict(run, held), rpm_and_si)
    page = Section("Run-up", [Paragraph(headline, strong=True)], command)
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
    peaks = found["peak_deflection"].values
    known = peaks[np.isfinite(peaks)]
    if known.size and np.ptp(known) > SCATTER * known.max():
        page.blocks.append(
            drawing(ensemble_distribution(found, "peak_deflection"), "Share of the starts below each peak deflection.")
        )
    return page


def study_pages(found: Studied, file: str) -> list[Section]:
    """A study with its pictures, and which scatter drives it."""
    command = f"autobalancer study {file}"
    page = Section(f"Study {found.attrs.get('study_name', '')}".strip(), replay=command)
    page.blocks.append(facts(_asked(found)))
    page.blocks.append(columns_table(found.columns("rpm")))
    page.blocks += [Paragraph(text) for text in found.remarks()]
    pages = [page]
    driven = Section("Which scatter drives the result", replay=command)
    for name in (name for name in SHOWN if name in found):
        _add(page.blocks, lambda name=name: drawing(study_picture(found, name), f"{_words(name)} over the study."))
        _add(driven.blocks, lambda name=name: _driven(found, name))
    if driven.blocks:
        pages.append(driven)
    return pages


def _driven(found: Studied, name: str) -> Block:
    return drawing(
        sensitivity_picture(sensitivity(found, name)),
        f"What drives the scatter of {_words(name)}, with 95 % intervals.",
    )


def _add(blocks: list[Block], made: Any) -> None:
    """Add what can be drawn; a quantity that does not scatter has no picture."""
    try:
        blocks.append(made())
    except AutobalancerError:
        return


def _asked(found: Studied) -> list[tuple[str, str]]:
    import json

    asked = json.loads(found.attrs["study"])
    rows = [("plan", str(asked["plan"])), ("seed", str(asked["seed"])), ("members", str(found.sizes["member"]))]
    rows += [(f"grid: {name} (SI)", ", ".join(values)) for name, values in asked["grid"].items()]
    return rows + [(f"scatter: {name} (SI)", str(text)) for name, (_, text) in asked["scatter"].items()]


def _words(name: str) -> str:
    return name.replace("_", " ")

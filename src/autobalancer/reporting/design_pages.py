"""Pages of a design: what was asked, what ran, which limits this machine keeps, and what was ruled out and why."""

from __future__ import annotations

import json
import math
from shlex import quote

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.plots.measured.receptance import receptance as receptance_picture
from autobalancer.plots.studies.design import UNITS
from autobalancer.plots.studies.design import design as design_picture
from autobalancer.reporting.page import (
    NO,
    YES,
    Decisive,
    Paragraph,
    Rows,
    Section,
    columns_table,
    drawing,
    facts,
    yes_or_no,
)
from autobalancer.results.number_text import significant
from autobalancer.studies.design.answer import Designed
from autobalancer.studies.design.chosen import designed_machine
from autobalancer.studies.design.measured import read_back
from autobalancer.studies.design.screening import ROUNDING
from autobalancer.studies.design.spec import ENOUGH, MARGIN, PRESSURE, STALL

WIDTH = 24  # designs in the table
OPEN = "undecided"  # too few runs to say


def design_pages(found: Designed, machine: Machine, file: str) -> list[Section]:
    """The design from which a machine was chosen.

    Raises
    ------
    QuestionError
        If the machine is none of its designs.
    """
    command = f"autobalancer design {quote(str(found.attrs.get('specification_file', 'design.toml')))}"
    place = _place(found, machine)
    page = Section(f"Design {found.attrs['design_name']}", replay=f"{command}  # written to {file}")
    best = found.best()
    label, count = str(best["label"].values[place - 1]), best.sizes["design"]
    page.blocks += [Paragraph(f"This machine is place {place} of {count}: {label}.", strong=True)]
    out = ", ".join(f"{stage} {many}" for stage, many in found.ruled_out().items()) or "none"
    about = _about(found)
    page.decisive.append(
        Decisive("design", f"place {place} of {count}: {label}; ruled out before: {out}", condition=about)
    )
    other = min(place, count - 1) if place == 1 else 0  # the next best, or the best
    if count > 1:
        page.decisive.append(
            Decisive(f"instead of place {other + 1}", _beside(best, place - 1, other), condition=about)
        )
    page.blocks += [facts(found.facts()), columns_table(found.isel(design=found.order()[:WIDTH]).columns("rpm"))]
    page.blocks += [Paragraph(f"{text}.") for text in found.meanings()]
    page.blocks.append(
        drawing(
            design_picture(found, title=""), "Candidates that each question ruled out; objectives of those that ran."
        )
    )
    why = Section("What was ruled out, and why", [Paragraph(text) for text in found.reasons()], command)
    return [page, *_rotor(found, command), _limits(found, place, command), *([why] if why.blocks else [])]


def _beside(best: xr.Dataset, one: int, other: int) -> str:
    """What another design would give: its name, and its objectives beside those of the chosen one."""
    said = []
    for name in best.attrs["objectives"]:
        sign, factor = UNITS[best[name].attrs["units"]]
        values = [float(best[name].values[place]) for place in (other, one)]
        words = [f"{significant(factor * value)} {sign}" if math.isfinite(value) else "never" for value in values]
        said.append(f"{name.replace('_', ' ')} {words[0]} for {words[1]}")
    return f"{best['label'].values[other]}: {', '.join(said)}"


def _about(found: Designed) -> str:
    """Of which runs the numbers of a design are."""
    known = dict(found.facts())
    return f"{found.attrs['members']} runs from random starts, {known['unbalance']}, {known['temperature']}"


def _rotor(found: Designed, command: str) -> list[Section]:
    """The measured rotor beside the fitted one; nothing if it was not measured."""
    fit = read_back(found)
    if fit is None:
        return []
    page = Section("Measured rotor", [facts(fit.facts()), columns_table(fit.columns("Hz"))], command)
    low, high = (60.0 * float(fit.attrs[f"band_{end}"]) / (2.0 * math.pi) for end in ("low", "high"))
    page.blocks.append(
        Paragraph(
            f"All runs and borders are those of the fitted rotor. It is known from {low:.4g} to {high:.4g} rpm, where it was "
            "measured; below, its stiffness is that of its modes. Its modes do not change with the speed, and it is alike in all "
            "directions."
        )
    )
    page.blocks += [Paragraph(f"{text}.") for text in fit.remarks()]
    page.blocks.append(
        drawing(receptance_picture(fit), "Receptance at the races: measured, and of the rotor that runs.")
    )
    return [page]


def _place(found: Designed, machine: Machine) -> int:
    wanted = _bare(machine)
    for place in range(1, found.best().sizes["design"] + 1):
        if _bare(designed_machine(found, place)) == wanted:
            return place
    raise QuestionError(
        f"study: this machine is no design of {found.attrs['design_name']!r}; take a machine file that it wrote"
    )


def _bare(machine: Machine) -> str:
    """A machine without the words that say where it is from."""
    return machine_text(machine.model_copy(update={"name": "machine", "description": ""}))


def _limits(found: Designed, place: int, command: str) -> Section:
    """The limits, what the chosen design reaches, and the share of its runs beyond with its interval."""
    one = found.isel(design=found.order()[place - 1])
    page, rows = Section("Limits of the design", replay=command), []
    for name, value in json.loads(found.attrs["limits"]).items():
        if row := _limit(one, name, value, float(found.attrs["share"])):
            asked, reached, share, enough = row
            words = name.replace("_", " ")
            rows.append((words, asked, reached, share, enough))
            beyond = f"; {share} of the runs are beyond it" if share != "-" else ""
            many = f"{100.0 * float(found.attrs['share']):g} % of " * (name in found)
            of = f"{many}{_about(found)}" if share != "-" else "the worst of all unbalances and temperatures"
            page.decisive.append(Decisive(f"limit: {words} {asked}", f"{reached}{beyond}", enough, of))
    head = ("limit", "asked", "reached", "share of the runs beyond it, 95 % interval", "kept")
    page.blocks.append(Rows(head, tuple(rows), (False, True, True, False, False)))
    page.blocks.append(
        Paragraph(
            f"Reached is the value that {100.0 * float(found.attrs['share']):g} % of the runs stay below, at the worst operating "
            "speed. A limit is kept if the upper end of the interval is not above the share that may be beyond "
            "it; undecided means that so few runs cannot tell."
        )
    )
    return page


def _limit(one: xr.Dataset, name: str, value: float, share: float) -> tuple[str, str, str, str] | None:
    """What was asked and reached, the share of the runs beyond with its interval, and whether that is enough."""
    if name in one and f"{name}_over" in one:
        sign, factor = UNITS[one[name].attrs["units"]]
        reached = f"{significant(factor * float(one[name]))} {sign}" if math.isfinite(float(one[name])) else "never"
        return f"{factor * value:.4g} {sign}", reached, *_beyond(one, f"{name}_over", 1.0 - share)
    if name == STALL:
        return f"{100.0 * value:.3g} %", f"{100.0 * float(one['stall']):.3g} %", *_beyond(one, "stall", value)
    if name == MARGIN:
        speeds = [float(one[border]) for border in ("release", "border") if not math.isnan(float(one[border]))]
        slowest = float(min(np.atleast_1d(one.attrs["speeds"])))
        margin = slowest / max(speeds) - 1.0 if speeds and max(speeds) > 0.0 else math.inf
        said = f"{significant(100.0 * margin)} %" if math.isfinite(margin) else "no border"
        return f"{100.0 * value:.3g} %", said, "-", yes_or_no(margin >= value * (1.0 - ROUNDING))
    if name == ENOUGH:
        margin = float(one["capability_margin"])
        return f"{value:g} times", f"{margin:.3g} times", "-", yes_or_no(margin >= value * (1.0 - ROUNDING))
    if name == PRESSURE:
        pressure = float(one["pressure"])
        return f"{1e-6 * value:.0f} MPa", f"{1e-6 * pressure:.0f} MPa", "-", yes_or_no(pressure <= value)
    return None


def _beyond(one: xr.Dataset, name: str, allowed: float) -> tuple[str, str]:
    """The share of the runs beyond a limit with its interval, and whether that is kept, by the rule of the order."""
    share, low, high = (float(one[f"{name}{end}"]) for end in ("", "_low", "_high"))
    kept = YES if high <= allowed else NO if low > allowed else OPEN
    return f"{100.0 * share:.3g} % ({100.0 * low:.2g} to {100.0 * high:.2g} %)", kept

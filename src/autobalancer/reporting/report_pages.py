"""What a report is made of: sections of paragraphs, tables, pictures and texts, whatever file they become."""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from shlex import quote
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import xarray as xr

import autobalancer.plots.stability_map as pictures
from autobalancer.api import compare, simulate
from autobalancer.assembly.quantities import value_of
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.laws.capabilities import grade_name, permissible_unbalance
from autobalancer.machine import Machine
from autobalancer.plots.ensembles import ensemble_distribution
from autobalancer.plots.fits import overlay
from autobalancer.plots.run.race_and_orbit import race as race_picture
from autobalancer.plots.run.run_up import run_up
from autobalancer.plots.studies import envelopes as envelopes_picture
from autobalancer.plots.studies import sensitivity as sensitivity_picture
from autobalancer.plots.studies import study as study_picture
from autobalancer.progress import silent
from autobalancer.results.answers.studied import FINISHED, Studied, stalled
from autobalancer.results.display_units import length_text, moment_text, side_text, significant
from autobalancer.results.verdict import BALANCED, NO_RESIDUAL, PARTLY, WORSE, Verdict, verdict_lines
from autobalancer.simulation.record import Samples
from autobalancer.sketch import machine as sketch
from autobalancer.stability.maps.stability_map import map as stability_map
from autobalancer.stability.summary import Summary
from autobalancer.studies.basin import basin
from autobalancer.studies.design.design import values_of
from autobalancer.studies.design.designs import SHOWN, USUAL, Designed, level
from autobalancer.studies.design.specification import MEASURED, STALL
from autobalancer.studies.ensemble.ensemble import ensemble
from autobalancer.studies.study.study import envelopes, sensitivity
from autobalancer.tables import SOME, Column, rpm_and_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DOTS = 170  # per inch of a picture


@dataclass(frozen=True)
class Paragraph:
    """A text; ``strong`` where it is what a reader looks for first."""

    text: str
    strong: bool = False


@dataclass(frozen=True)
class Rows:
    """A table: heads, which may be empty, and rows of texts. ``numeric`` columns stand right, ``wide`` ones get the room."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[bool, ...] = ()
    wide: tuple[bool, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """A picture (PNG) with what it shows in words."""

    png: bytes
    caption: str


@dataclass(frozen=True)
class Listing:
    """A text that keeps its lines, such as a machine file or a command."""

    text: str


Block = Paragraph | Rows | Drawing | Listing


@dataclass(frozen=True)
class Decisive:
    """What decides, for the first page: what is asked and found, whether that is enough, ``"-"`` where nobody asked, of what."""

    question: str
    found: str
    enough: str = "-"
    condition: str = ""  # of which unbalance, temperature, share of which runs


YES, NO, SOMEWHAT = "yes", "NO", "partly"
WIDE = (True, True, True, False, False)  # columns of the first page


def yes_or_no(holds: bool) -> str:
    """Whether it is enough, as the first page says it."""
    return YES if holds else NO


@dataclass
class Section:
    """A heading and what stands below it; ``replay`` are the commands that make its numbers again, ``decisive`` what decides."""

    title: str
    blocks: list[Block] = field(default_factory=list)
    replay: str = ""
    decisive: list[Decisive] = field(default_factory=list)


@dataclass(frozen=True)
class Report:
    """A whole report."""

    title: str
    about: tuple[tuple[str, str], ...]  # identity: names and texts
    sections: tuple[Section, ...]
    sign: bool = True  # with lines for name, date and signature


def first_page(pages: Sequence[Section]) -> Section:
    """What decides, gathered from all pages, each with the number of its page behind this one; what is not enough comes first."""
    page = Section("In short")
    known = [
        (one, f"{number} {section.title}") for number, section in enumerate(pages, start=2) for one in section.decisive
    ]
    ranks = {NO: 0, SOMEWHAT: 0, YES: 2, "-": 3}
    known.sort(key=lambda pair: ranks.get(pair[0].enough, 1))
    rows = [(one.question, one.found, one.condition, one.enough, where) for one, where in known]
    missed = [f"{one.question.rstrip('?')}: {one.found}" for one, _ in known if ranks.get(one.enough) == 0]
    said = f"Not enough: {'; '.join(missed)}." if missed else "Nothing that was asked for is missed."
    left = [f"{one.question} ({one.enough})" for one, _ in known if one.enough not in ranks]
    said += f" Look at: {'; '.join(left)}." if left else ""
    heads = ("question", "found", "of what", "enough", "page")
    page.blocks += [Paragraph(said, strong=True), Rows(heads, tuple(rows), wide=WIDE)]
    return page


def facts(rows: Sequence[tuple[str, str]]) -> Rows:
    """Names and texts as a table without heads."""
    return Rows((), tuple((name, text) for name, text in rows))


def columns_table(columns: Sequence[Column]) -> Rows:
    """Columns of a result as a table, units in the heads."""
    heads = tuple(f"{column.head} ({column.unit})" if column.unit else column.head for column in columns)
    cells = zip(*(column.cells() for column in columns), strict=True)
    numeric, wide = tuple(column.numeric for column in columns), tuple(column.wraps for column in columns)
    return Rows(heads, tuple(tuple(row) for row in cells), numeric, wide)


def drawing(figure: Figure, caption: str) -> Drawing:
    """A Matplotlib figure as a picture of a report."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=DOTS)
    return Drawing(stream.getvalue(), caption)


# A report as one HTML file that needs nothing else: pictures and style are in it.


PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ report.title }}</title>
<style>
body { font: 15px/1.5 system-ui, "Helvetica Neue", Arial, sans-serif; color: #222; max-width: 60rem;
  margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; margin-bottom: .3rem; }
  h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 2px solid #e3e3e3; }
table { border-collapse: collapse; margin: .8rem 0; font-size: .92rem; }
  th { text-align: left; border-bottom: 1.5px solid #606060; }
td, th { padding: .2rem .8rem .2rem 0; vertical-align: top; white-space: pre-line; } tr + tr td { border-top: 1px solid #ececec; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
  table.facts td:first-child { white-space: nowrap; }
td.wide { white-space: normal; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; } figcaption { font-size: .88rem; color: #505050; }
pre { background: #f5f6f7; padding: .7rem .9rem; white-space: pre-wrap; overflow-wrap: anywhere; font-size: .82rem; }
  .replay { font-size: .85rem; color: #505050; }
.strong { font-weight: 600; } .sign { display: flex; gap: 2rem; margin-top: 3rem; }
  .sign div { flex: 1; border-top: 1px solid #222; }
nav { font-size: .92rem; columns: 2; } a { color: #0072B2; }
@media (prefers-color-scheme: dark) { body { background: #1b1d1f; color: #e4e4e4; } pre { background: #26292c; }
  img { background: white; } tr + tr td { border-color: #333; } h2 { border-color: #444; }
  .replay, figcaption { color: #aaa; } a { color: #56B4E9; } }
@media print { body { max-width: none; margin: 0; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; }
  nav { display: none; } section:nth-of-type(2) { break-before: page; } }
</style>
</head>
<body>
<h1>{{ report.title }}</h1>
{{ block(about) }}
{% for section in report.sections %}
<section aria-labelledby="s{{ loop.index }}">
<h2 id="s{{ loop.index }}">{{ loop.index }} {{ section.title }}</h2>
{% for one in section.blocks %}{{ block(one) }}
{% endfor %}{% if section.replay %}<div class="replay">made by<pre>{{ section.replay }}</pre></div>{% endif %}
</section>
{% if loop.first %}{% if report.sign %}
<div class="sign"><div>name</div><div>date</div><div>signature</div></div>{% endif %}
<nav aria-label="contents">{% for section in report.sections %}
<div><a href="#s{{ loop.index }}">{{ loop.index }} {{ section.title }}</a></div>{% endfor %}
</nav>{% endif %}
{% endfor %}
</body>
</html>
"""
TABLE = """<table{% if not rows.head %} class="facts"{% endif %}>{% if rows.head %}<thead><tr>{% for cell in rows.head %}
<th{% if numeric[loop.index0] %} class="number"{% endif %}>{{ cell }}</th>{% endfor %}</tr></thead>{% endif %}<tbody>
{% for row in rows.rows %}<tr>{% for cell in row %}
<td{% if numeric[loop.index0] %} class="number"{% endif %}>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</tbody></table>"""


def html_text(report: Report) -> str:
    """The whole file."""
    from jinja2 import Environment
    from markupsafe import Markup, escape

    environment = Environment(autoescape=True)
    page, table = environment.from_string(PAGE), environment.from_string(TABLE)

    def block(block: Block) -> Markup:
        if isinstance(block, Paragraph):
            return Markup('<p class="strong">{}</p>' if block.strong else "<p>{}</p>").format(block.text)
        if isinstance(block, Rows):
            numeric = block.numeric or (False,) * 99
            return Markup(table.render(rows=block, numeric=numeric))
        if isinstance(block, Drawing):
            data = base64.b64encode(block.png).decode()
            words = escape(block.caption)
            return Markup(
                f'<figure><img alt="{words}" src="data:image/png;base64,{data}"><figcaption>{words}</figcaption></figure>'
            )
        assert isinstance(block, Listing)
        return Markup("<pre>{}</pre>").format(block.text)

    return page.render(report=report, about=Rows((), report.about), block=block)


# The list of pages. A page is a function with ``@report_page``; what it needs of the report it names as its parameters.


Page = Callable[..., Section | list[Section]]
Made = TypeVar("Made", bound=Page)
PAGES: list[tuple[Page, str]] = []  # in their order, each with what must be there


def report_page(*, after: Page | None = None, first: bool = False, needs: str = "") -> Callable[[Made], Made]:
    """Make a function a page of every report: behind another one, as the ``first`` one, or behind all so far.

    Its parameters are names of what a report is made of, of which ``needs`` must be there.
    """

    def listed(function: Made) -> Made:
        behind = [one for one, _ in PAGES].index(after) + 1 if after is not None else len(PAGES)
        PAGES.insert(0 if first else behind, (function, needs))
        return function

    return listed


# Pages that need no run: drawing of the numbers of a machine, capability, balance quality, border speeds, stress.


MAP = (41, 31)  # speeds and viscosities
HARDLY = "hardly"  # enough, with less than the usual margin
TYPICAL = "race off the axis as is typical (not given)"
UNKNOWN = "measure it"  # what nobody has said of the machine
DECIDES = ("release speed", "exact border")
UNITS = {"viscosity": (1e6, "mm^2/s"), "drag": (1.0, "N*m*s")}


@report_page()
def facts_page(summary: Summary) -> Section:
    """What is known before a run."""
    page = Section("Machine", [facts(summary.rows(rpm_and_si))], "autobalancer check machine.toml")
    page.blocks += [Paragraph(f"Note: {text}") for text in summary.warnings]
    if count := len(summary.warnings):
        page.decisive.append(Decisive("notes on the machine", f"{count} note{'s' * (count > 1)} to read"))
    return page


@report_page()
def drawing_page(machine: Machine) -> Section:
    """Rotor, supports, planes, races and balls."""
    page = Section("Drawing", replay="autobalancer plot machine.toml --out pictures")
    caption = "Rotor with its supports, planes and races along the axis, and each balancer from above; lengths in mm."
    page.blocks.append(drawing(sketch(machine, title=""), caption))
    return page


@report_page()
def capability_page(summary: Summary) -> Section:
    """What the balls of each race, and of each plane, can balance, and what they have to."""
    page = Section("Capability", replay="autobalancer check machine.toml")
    rows = []
    for race in summary.races:
        rows.append(
            (
                f"balancer {race.balancer}, race {race.race}",
                f"{race.balls}",
                f"{1e3 * race.ball_mass:.4g} g",
                moment_text(race.capability),
                f"{100.0 * race.occupied_angle / (2.0 * math.pi):.3g} %",
            )
        )
    if not rows:
        page.blocks.append(Paragraph("Not stated: the machine has no balls."))
        return page
    heads = ("race", "balls", "mass of the balls", "capability", "of the race that balls take")
    page.blocks.append(Rows(heads, tuple(rows), (False, True, True, True, True)))
    planes = [
        (station.name, station.capability, station.required) for station in summary.stations if station.required > 0.0
    ]
    if not planes and summary.unbalance > 0.0:
        planes = [("all races", summary.capability, summary.unbalance)]
    for name, capability, required in planes:
        ratio = capability / required
        word = NO if ratio < 1.0 else HARDLY if ratio < USUAL else YES
        said = f"{moment_text(capability)} for {moment_text(required)}, {ratio:.3g} times as much"
        page.decisive.append(
            Decisive(f"capability of the balls, {name}", said, word, "unbalance and fluid of the machine file")
        )
        enough = {
            NO: "NOT enough",
            YES: "enough",
            HARDLY: f"enough, but hardly ({ratio:.3g}): with less than {USUAL:g} to 2 times balls stand nearly side by side and "
            "react slowly",
        }[word]
        page.blocks.append(
            Paragraph(
                f"{name}: {moment_text(capability)} for an unbalance of {moment_text(required)}, {ratio:.3g} times as much: "
                f"{enough}.",
                strong=True,
            )
        )
    return page


@report_page()
def quality_page(summary: Summary, left: float, judged: Verdict, grade: float | None, command: str) -> Section:
    """Balance quality before, and with the balls as the run-up leaves them, against the grade that is asked for.

    A run-up whose balls do not turn with the rotor at the end, or that is worse than without balls, reaches no grade.

    Parameters
    ----------
    summary
        Of the machine.
    left
        Residual unbalance at the end of the run-up, kg m; nan if it has none.
    judged
        Verdict on the run-up.
    grade
        G in mm/s, or ``None``.
    command
        Makes the run-up again.
    """
    page = Section("Balance quality (ISO 21940-11)", replay=f"autobalancer check machine.toml\n{command}")
    service = summary.service
    if service is None:
        page.blocks.append(Paragraph("Not stated: the drive names no service speed, or the machine has no unbalance."))
        return page
    mass = 1e3 * service.unbalance * service.speed / service.grade
    size = moment_text(summary.unbalance)
    worse = f", {WORSE}" * (judged.word == WORSE)
    worse += ", the rotor held at a critical speed" * (judged.held_rotor is not None)
    at_end = f"balls {judged.state_of_balls}{worse}, at the end of the run-up"
    beside = "" if judged.turns_with_rotor else f"; {NO_RESIDUAL}"
    rows = [
        ("without balancing", service.unbalance, ""),
        (at_end, left, f"one run-up with {size}, from the start of the machine file{beside}"),
        *residuals_left(summary, size),
    ]
    allowed = math.inf if grade is None else permissible_unbalance(grade, mass, service.speed)
    known = [row for row in rows if math.isfinite(row[1])]
    fails = at_end if worse or beside else ""
    enough = [value <= allowed and name != fails for name, value, _ in known]
    heads: tuple[str, ...] = ("state", "unbalance", "velocity of the mass center (mm/s)", "grade reached")
    grades = [1e3 * value * service.speed / mass for _, value, _ in known]
    cells: list[tuple[str, ...]] = [
        (name, moment_text(value), significant(grade), grade_name(grade))
        for (name, value, _), grade in zip(known, grades, strict=True)
    ]
    if beside:
        cells = [(*row[:2], "-", "no grade") if row[0] == at_end else row for row in cells]
    if grade is not None:
        heads = (*heads, f"G {grade:g}")
        cells = [(*row, "reached" if reached else "NOT reached") for row, reached in zip(cells, enough, strict=True)]
        page.blocks.append(
            Paragraph(f"G {grade:g} at {rpm_and_si(service.speed)} permits {moment_text(allowed)}.", strong=True)
        )
    page.blocks.append(Rows(heads, tuple(cells), (False, True, True, False, False)[: len(heads)]))
    if grade is not None and summary.friction is not None and summary.friction.planes:
        page.blocks.append(
            Paragraph(
                "For every start the greatest residual decides, for 95 % of the starts the one that these end below."
            )
        )
    for row, (*_, condition), reached in list(zip(cells, known, enough, strict=True))[1:]:
        requested = "-" if grade is None else UNKNOWN if row[0] == TYPICAL else yes_or_no(reached)
        page.decisive.append(Decisive(f"residual unbalance, {row[0]}", f"{row[1]}, {row[3]}", requested, condition))
    return page


def residuals_left(summary: Summary, size: str) -> list[tuple[str, float, str]]:
    """What eccentric races and friction may leave, and of what; ``size`` is the unbalance in words."""
    rows = []
    if summary.off_center is not None and len(summary.off_center.planes) == 1:
        (plane,) = summary.off_center.planes
        kind = "race off the axis as given" if plane.given else TYPICAL
        rows.append(
            (kind, plane.residual, f"{length_text(plane.eccentricity)} off the axis, the balls in their best places")
        )
    held = summary.friction
    if (below := summary.friction_settled) is not None and all(plane.carried_on is False for plane in below.planes):
        held = below  # the drive rises slowly enough for balls to keep the places that they take there
    if held is not None and len(held.planes) == 1:
        (stuck,) = held.planes
        at = f"{size}, released at rest at the constant speed of {rpm_and_si(held.speed)}, no run-up"
        rows.append(
            ("95 % of the balls that friction stops end below", stuck.residual_95, f"{at}; {held.starts} starts")
        )
        most = max(stuck.sticking_residual, stuck.greatest_residual)
        stick = f"{at}; balls that stick on their way to balance leave at most {moment_text(stuck.sticking_residual)}"
        trapped = f", {100.0 * stuck.trapped_share:.2g} % of the starts end farther away, trapped" * (
            stuck.trapped_share > 0.0
        )
        rows.append(("greatest of all balls that friction stops", most, stick + trapped))
    return rows


@report_page()
def margin_page(summary: Summary) -> Section:
    """Border speeds, amplification and margins from the service speed."""
    page = Section("Border speeds and margins", replay="autobalancer borders machine.toml")
    if summary.no_borders_because:
        page.blocks.append(Paragraph(summary.no_borders_because))
    top = summary.highest_speed
    rows = []
    for border in summary.borders:
        margin = "-" if top is None or not math.isfinite(border.speed) else side_text(top, border.speed)
        rows.append((border.name, border.text(rpm_and_si), margin, border.note))
        if border.name in DECIDES and top is not None and not math.isnan(border.speed):
            said = border.text(rpm_and_si)
            if math.isfinite(border.speed):
                said += f"; the highest speed is {margin} it"
            some = border.best < top <= border.speed
            page.decisive.append(
                Decisive(
                    border.name,
                    said,
                    SOME if some else yes_or_no(border.speed < top),
                    f"{moment_text(summary.unbalance)}, fluid of the machine file",
                )
            )
    if rows:
        page.blocks.append(
            Rows(("border", "speed", "highest speed against it", "note"), tuple(rows), (False, False, True, False))
        )
    for speed, ratio in zip(summary.critical_speeds, summary.damping_ratios, strict=False):
        text = f"Critical speed {rpm_and_si(speed)}: damping ratio {100.0 * ratio:.3g} %"
        if ratio > 0.0:
            text += f", amplification factor {0.5 / ratio:.3g}"
        if top is not None:
            text += f"; separation margin: the highest speed is {side_text(top, speed)} it"
        page.blocks.append(Paragraph(f"{text}."))
    return page


@report_page()
def map_page(machine: Machine, summary: Summary) -> Section:
    """Where balancing is stable over speed and viscosity, or drag."""
    page = Section("Where balancing is stable")
    top = summary.highest_speed or 0.0
    lowest = min(summary.critical_speeds, default=0.0)
    if not top > lowest > 0.0:
        page.blocks.append(Paragraph("Not drawn: the machine does not run faster than its lowest critical speed."))
        return page
    low, high = 60.0 / (2.0 * math.pi) * 0.8 * lowest, 60.0 / (2.0 * math.pi) * 1.15 * top
    for name in ("viscosity", "drag"):
        try:
            value, (scale, unit) = _value(machine, name), UNITS[name]
            axes: dict[str, Any] = {
                "speed": f"{low:.4g}:{high:.4g} rpm:{MAP[0]}",
                name: f"{0.1 * scale * value:.4g}:{10.0 * scale * value:.4g} {unit}:{MAP[1]}:log",
            }
            picture = pictures.map(stability_map(machine, axes, borders=31, progress=silent), title="")
        except AutobalancerError as reason:
            why = str(reason)
            continue
        page.blocks.append(
            drawing(picture, f"Growth rate of the balanced state over speed and {name}; the point is this machine.")
        )
        page.replay = f'autobalancer map machine.toml --x "speed={axes["speed"]}" --y "{name}={axes[name]}"'
        return page
    page.blocks.append(Paragraph(f"Not drawn: {why}"))
    return page


def _value(machine: Machine, name: str) -> float:
    value = value_of(machine, name)
    if not value > 0.0:
        raise QuestionError(f"the machine has no single value of {name}")
    return value


# Pages of runs: one run-up as picture and verdict, many from random starts as shares and quantiles.


PER_TURN, MOST_SAMPLES = 40, 400_000  # of a run that is compared with a measurement
SCATTER = 0.01  # of a peak, below which its distribution is not drawn
RUN_COLUMNS = ("balanced", "peak_deflection", "settling_time")


@report_page(after=quality_page)
def run_page(run: xr.Dataset, held: xr.Dataset, judged: Verdict, command: str, machine: Machine) -> Section:
    """The run-up with its verdict, compared with the same machine with its balls held."""
    headline, rows, notes = verdict_lines(judged, rpm_and_si)
    page = Section("Run-up", [Paragraph(headline, strong=True)], command)
    about = f"one run of the machine file, unbalance {moment_text(value_of(machine, 'unbalance'))}"
    enough = SOMEWHAT if judged.word == PARTLY else yes_or_no(judged.word == BALANCED)
    page.decisive.append(Decisive("is one run-up balanced?", headline.partition(";")[0], enough, about))
    page.blocks.append(
        drawing(
            run_up(run, held=held), "Rotor and ball speeds, deflection (shaded) and ball angles in the rotor over time."
        )
    )
    page.blocks.append(facts(rows))
    page.blocks += [Paragraph(text) for text in notes]
    if "time" in run.dims:
        page.blocks.append(
            drawing(race_picture(run), "Balls, races and unbalance at the end of the run, seen in the rotor.")
        )
    return page


@report_page(after=run_page, needs="designed")
def ends_page(designed: Designed, machine: Machine, file: str, half: int | None, seed: int) -> list[Section]:
    """Run-ups at each end of the range of unbalances of a design: which one is worse, where a value between may be, too."""
    low, high = (float(end) for end in designed.attrs["unbalance_range"])
    if not low < high:
        return []
    starts, share, limits = half or 1, float(designed.attrs["share"]), json.loads(designed.attrs["limits"])
    many: Any = ensemble(machine, {"unbalance": [low, high]}, seeds=starts, seed=seed, progress=silent)
    ends = [many.isel(member=np.isclose(many["unbalance"].values, end, rtol=1e-9, atol=0.0)) for end in (low, high)]
    command = f'autobalancer ensemble {file} --column "unbalance={low!r},{high!r} kg*m" --seeds {starts}'
    page, rows = Section("Both ends of the range of unbalances", replay=f"{command} --seed {seed}"), []
    runs = f"{starts} random start{'s' * (starts > 1)}"
    alone = f"{runs} of the machine file at each end; an unbalance between may be worse"
    for name in dict.fromkeys((*limits, *designed.attrs["objectives"])):
        if name != STALL and name not in MEASURED:
            continue
        sign, factor = ("%", 100.0) if name == STALL else SHOWN[MEASURED[name][0]]
        values = [
            float((stalled(end) | (end["outcome"].values != FINISHED)).mean())
            if name == STALL
            else level(values_of(end, name), share)
            for end in ends
        ]
        found = [f"{significant(factor * value)} {sign}" if math.isfinite(value) else "never" for value in values]
        worse = "-" if values[0] == values[1] else moment_text((low, high)[values[1] > values[0]])
        limit, kept = limits.get(name), "-"
        if limit is not None:
            kept, asked = yes_or_no(max(values) <= limit), f"{significant(factor * limit)} {sign}"
            text = f"{found[0]} with {moment_text(low)}, {found[1]} with {moment_text(high)}"
            page.decisive.append(Decisive(f"limit at both ends: {_words(name)} {asked}", text, kept, alone))
        rows.append((_words(name), "-" if limit is None else asked, *found, worse, kept))
    head = ("", "limit", f"with {moment_text(low)}", f"with {moment_text(high)}", "worse end", "kept at both ends")
    page.blocks.append(Rows(head, tuple(rows), (False, True, True, True, True, False)))
    page.blocks.append(
        Paragraph(
            f"Each number is that which {100.0 * share:g} % of {runs} at this unbalance stay below, of a stall the share of "
            "them. Neither end need be the worst: an unbalance between may be worse, and in the table of the designs unbalances "
            "of all sizes are together, with all else that a design scatters (temperature, [scatter]), but not these runs. "
            "All other runs of this report have the unbalance of the machine file, "
            f"{moment_text(value_of(machine, 'unbalance'))}."
        )
    )
    return [page]


@report_page(needs="half")
def starts_page(machine: Machine, file: str, starts: int, seed: int) -> Section:
    """How run-ups from random starts end."""
    many: Any = ensemble(machine, seeds=starts, seed=seed, progress=silent)
    page = Section(
        f"{starts} random starts of the balls", replay=f"autobalancer ensemble {file} --seeds {starts} --seed {seed}"
    )
    page.blocks.append(columns_table(many.columns("rpm")))
    page.blocks.append(Paragraph("95 %: the share of very many starts is in this interval with a probability of 95 %."))
    page.blocks += [Paragraph(text) for text in (*many.spread(), *many.without())]
    share, low, high = (100.0 * one for one in many.share_of(many["balanced"].values))
    page.decisive.append(
        Decisive(
            "run-ups from random starts",
            f"{share:.3g} % ({low:.3g} to {high:.3g} %) end balanced",
            condition=f"{starts} starts of the machine file, with its unbalance and its fluid",
        )
    )
    peaks = many["peak_deflection"].values
    known = peaks[np.isfinite(peaks)]
    if known.size and np.ptp(known) > SCATTER * known.max():
        page.blocks.append(
            drawing(ensemble_distribution(many, "peak_deflection"), "Share of the starts below each peak deflection.")
        )
    return page


@report_page(after=run_page, needs="half")
def fan_page(machine: Machine, file: str, half: int, seed: int) -> Section:
    """Run-up and coast-down from random starts, half as many, as percentiles."""
    command = f"autobalancer envelopes {file} --members {half} --seed {seed} --coast-down"
    page = Section("Run-up and coast-down", replay=command)
    down = True
    try:
        fan = envelopes(machine, members=half, coast_down=True, seed=seed, progress=silent)
    except QuestionError as reason:
        down = False
        page.blocks.append(Paragraph(f"No coast-down: {reason}"))
        fan = envelopes(machine, members=half, seed=seed, progress=silent)
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


@report_page(after=map_page, needs="half")
def basin_page(machine: Machine, summary: Summary, file: str, half: int, seed: int) -> list[Section]:
    """Which states are reached at the highest speed, from random angles of the balls, half as many."""
    speed = summary.highest_speed
    if speed is None:
        return []
    command = f'autobalancer basin {file} --speed "{speed:.17g} rad/s" --random {half} --seed {seed}'
    page = Section("Basins at the highest speed", replay=command)
    try:
        result = basin(machine, speed, random=half, seed=seed, progress=silent)
    except AutobalancerError as reason:
        page.blocks.append(Paragraph(f"Not stated: {reason}"))
        return [page]
    page.blocks.append(columns_table(result.columns("rpm")))
    page.blocks.append(
        Paragraph(
            "The rotor starts at its speed, the balls at random angles at rest in the rotor. "
            "95 %: the share of very many starts is in this interval with a probability of 95 %."
        )
    )
    page.blocks += [Paragraph(text) for text in result.remarks()]
    return [page]


@report_page(after=fan_page, needs="measured")
def measured_page(
    machine: Machine, summary: Summary, seed: int, measured: xr.Dataset, measured_file: str, command: str
) -> Section:
    """What was measured beside the run-up, which has so many samples here that vibration can be compared."""
    assert machine.run is not None
    turns = float(machine.run.duration) * (summary.highest_speed or 0.0) / (2.0 * math.pi)
    count = int(min(max(PER_TURN * turns, 2000.0), MOST_SAMPLES)) + 1
    run = simulate(machine, seed=seed, save=[Samples(count)], progress=False)
    result = compare(run, measured)
    page = Section(
        "Measured and computed", replay=f"{command} --samples {count}\nautobalancer compare run.nc {measured_file}"
    )
    if rows := result.facts():
        page.blocks.append(facts(rows))
    page.blocks.append(columns_table(result.columns("rpm")))
    page.blocks += [Paragraph(text) for text in result.remarks()]
    page.blocks.append(drawing(overlay(result), "What was measured, and the run-up of the model in its place."))
    return page


@report_page(needs="study")
def study_pages(study: Studied, study_file: str) -> list[Section]:
    """A study with its pictures, and which scatter drives it."""
    command = f"autobalancer study {quote(str(study.attrs.get('study_file', 'study.toml')))} --out {quote(study_file)}"
    page = Section(f"Study {study.attrs.get('study_name', '')}".strip(), replay=command)
    page.blocks.append(facts(_option_rows(study)))
    page.blocks.append(columns_table(study.columns("rpm")))
    page.blocks += [Paragraph(text) for text in study.remarks()]
    pages = [page]
    driven, requested = Section("Which scatter drives the result"), list[str]()
    for name in (name for name in RUN_COLUMNS if name in study):
        _add(page.blocks, lambda name=name: drawing(study_picture(study, name), f"{_words(name)} over the study."))
        if _add(driven.blocks, lambda name=name: _driven(study, name)):
            requested.append(f"{command} --sensitivity {name}")
    driven.replay = "\n".join(requested)
    if driven.blocks:
        pages.append(driven)
    return pages


def _driven(studied: Studied, name: str) -> Block:
    return drawing(
        sensitivity_picture(sensitivity(studied, name)),
        f"What drives the scatter of {_words(name)}, with 95 % intervals.",
    )


def _add(blocks: list[Block], made: Any) -> bool:
    """Add what can be drawn, and say whether it was; a quantity that does not scatter has no picture."""
    try:
        blocks.append(made())
    except AutobalancerError:
        return False
    return True


def _option_rows(studied: Studied) -> list[tuple[str, str]]:
    requested = json.loads(studied.attrs["study"])
    rows = [
        ("plan", str(requested["plan"])),
        ("seed", str(requested["seed"])),
        ("members", str(studied.sizes["member"])),
    ]
    points = math.prod(len(values) for values in requested["grid"].values())
    rows += [("of them at each point of the grid", str(studied.sizes["member"] // points))] if points > 1 else []
    rows += [(f"grid: {name} (SI)", ", ".join(values)) for name, values in requested["grid"].items()]
    return rows + [(f"scatter: {name} (SI)", str(text)) for name, (*_, text) in requested["scatter"].items()]


def _words(name: str) -> str:
    return name.replace("_", " ")

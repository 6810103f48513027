"""One file that says what a machine does, with every number's run."""

from __future__ import annotations

import hashlib
import json
import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from shlex import quote
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.api import check, run_measures, simulate, verdict
from autobalancer.assembly.quantities import value_of, with_quantity
from autobalancer.assembly.terms import bibliography, printed, sources
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.laws.capabilities import grade_argument
from autobalancer.laws.impacts import STEEL, greatest_pressure
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.path import dimension_of, si_unit_of, text_of
from autobalancer.measurement.run_up_fit import load_measured
from autobalancer.memory import refuse_beyond_memory
from autobalancer.plots.answer import made_by
from autobalancer.plots.fits import receptance as receptance_picture
from autobalancer.plots.studies import UNITS
from autobalancer.plots.studies import design as design_picture
from autobalancer.progress import shows_progress, silent
from autobalancer.reporting.report_pages import (
    NO,
    PAGES,
    YES,
    Block,
    Decisive,
    Drawing,
    Listing,
    Paragraph,
    Report,
    Rows,
    Section,
    columns_table,
    drawing,
    facts,
    first_page,
    html_text,
    report_page,
    starts_page,
    yes_or_no,
)
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.answers.studied import Studied
from autobalancer.results.display_units import force_text, significant
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path, ready_to_write, write_safely, write_text_safely
from autobalancer.stability.summary import Summary
from autobalancer.studies.design.candidate import ROUNDING
from autobalancer.studies.design.design_file import PREFIX
from autobalancer.studies.design.designs import Designed, designed_machine
from autobalancer.studies.design.specification import ENOUGH, MARGIN, PRESSURE, STALL
from autobalancer.studies.ensemble.ensemble import bytes_of_a_member, ensemble
from autobalancer.studies.study.chunk import standing_numbers
from autobalancer.tables import speeds_in

FORMS = {".html": ("jinja2", "fills in its pages"), ".pdf": ("typst", "sets PDF files")}  # the package for each


@shows_progress
def report(
    machine: Machine | str | Path,
    path: str | Path,
    *,
    study: Studied | Designed | str | Path | None = None,
    grade: str | float | None = None,
    measured: xr.Dataset | str | Path | None = None,
    starts: int = 200,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write a report of a machine: what it is, what it does, how sure that is.

    Pages: identity and hash; what is known before a run; drawing; capability; balance quality by ISO 21940-11; run-up with
    verdict, its percentiles with those of the coast-down; border speeds with margins and map; basins; random starts; a study with
    sensitivity or a design, and a measurement, if given; forces and slip in the race; limits; sources; the machine file.

    Parameters
    ----------
    machine
        A machine with balls in races, or the path of its file. It needs a drive and a duration.
    path
        The file; ``.html`` is one file that needs nothing else, ``.pdf`` is typeset.
    study
        A result of :func:`autobalancer.study` of this machine, or of :func:`autobalancer.design` that chose it,
        or the path of its file.
    grade
        Balance quality that is asked for, such as ``"G 2.5"``.
    measured
        What was measured during the run-up, as for :func:`autobalancer.compare`, or the path of its file.
    starts
        Number of random starts; 0 for none. Of basins and percentiles half as many.
    seed
        Of the run-up and the first of the random starts.
    progress
        Called with (pages done, pages in all).

    Returns
    -------
    Path
        The file.

    Raises
    ------
    QuestionError
        For another suffix, a grade that is none, the study of another machine, or a package that is not installed
        (``pip install 'autobalancer[report]'``).
    ResultError
        If the file cannot be written.
    """
    path = as_path(path)
    if path.suffix.lower() not in FORMS:
        raise QuestionError(f"{path}: a report is written as .html or .pdf; end the name with one of these")
    ready_to_write(path)
    # refuse before any time is spent
    package, does = FORMS[path.suffix.lower()]
    if find_spec(package) is None:
        raise QuestionError(
            f"{path}: {package}, which {does}, is not installed; install it with: pip install 'autobalancer[report]'"
        )
    name = str(machine) if isinstance(machine, (str, Path)) else "machine.toml"
    described = balls_in_races(machine)
    refuse_beyond_memory("report", starts, "starts", bytes_of_a_member(described, False), "; ask for fewer")
    limit = None if grade is None else grade_argument(grade)
    chosen = _study(study, described)
    beside = load_measured(measured) if isinstance(measured, (str, Path)) else measured
    run = simulate(described, seed=seed, progress=False)  # first, as it says what the machine lacks
    summary = check(described)
    assert isinstance(summary, Summary)
    pages = _pages(
        Reported(
            machine=described,
            file=Path(name).name,
            grade=limit,
            study=None if isinstance(chosen, Designed) else chosen,
            designed=chosen if isinstance(chosen, Designed) else None,
            study_file=str(study) if isinstance(study, (str, Path)) else "study.nc",
            measured=beside,
            measured_file=str(measured) if isinstance(measured, (str, Path)) else "MEASURED",
            starts=starts,
            seed=seed,
            run=run,
            held=simulate(described, seed=seed, hold_balls=True, progress=False),
            summary=summary,
            command=f"autobalancer simulate {Path(name).name} --seed {seed} --out run.nc",
        ),
        progress,
    )
    # pages are data; HTML and PDF are two ways to print them
    made = provenance()
    identity = (
        ("machine", described.name),
        ("file", name),
        ("SHA-256 of the machine file below", hashlib.sha256(machine_text(described).encode()).hexdigest()),
        ("made by", made["source"]),
        ("on", made["created"]),
    )
    report = Report(f"{described.name}: automatic ball balancer", identity, tuple(pages))
    if path.suffix.lower() == ".pdf":
        write_pdf(report, path)
    else:
        write_text_safely(path, html_text(report))
    return path


@dataclass(frozen=True)
class Reported:
    """What pages are made of: a page gets of these what its parameters name. Files are named as in commands."""

    machine: Machine
    file: str
    grade: float | None
    study: Studied | None
    designed: Designed | None
    study_file: str
    measured: xr.Dataset | None
    measured_file: str
    starts: int
    seed: int
    run: xr.Dataset  # its run-up
    held: xr.Dataset  # the same with its balls held
    summary: Summary
    command: str  # makes the run-up again

    @property
    def half(self) -> int | None:
        """Random starts where half as many are enough; None without any."""
        return max(self.starts // 2, 2) if self.starts else None

    @cached_property
    def judged(self) -> Any:
        """The verdict on the run-up."""
        return verdict(self.run, self.held)

    @property
    def left(self) -> float:
        """Residual unbalance at the end of the run-up, kg m; nan if it has none."""
        measures = run_measures(self.run)
        return float(np.sum(measures["residual_unbalance"].values)) if "residual_unbalance" in measures else math.nan


def _pages(reported: Reported, progress: Callable[[int, int], None] | None) -> list[Section]:
    """All pages that ``PAGES`` has for it, the first page in front."""
    wanted = [one for one, needs in PAGES if not needs or getattr(reported, needs) is not None]
    done: list[Section] = []
    for count, one in enumerate(wanted, 1):
        made = one(**{name: getattr(reported, name) for name in signature(one).parameters})
        done += made if isinstance(made, list) else [made]
        if progress is not None:
            progress(count, len(wanted))
    for section in done:
        section.replay = section.replay.replace("machine.toml", reported.file)
        section.blocks = [  # sentences of the package have speeds in rad/s
            replace(one, text=speeds_in(one.text, 30.0 / math.pi, "rpm")) if isinstance(one, Paragraph) else one
            for one in section.blocks
        ]
    return [first_page(done), *done]


def _study(argument: Studied | Designed | str | Path | None, machine: Machine) -> Studied | Designed | None:
    if argument is None:
        return None
    study = load_run(argument) if isinstance(argument, (str, Path)) else argument
    if isinstance(study, Designed):
        _place(study, machine)  # refuses a machine that is none of it
        return study
    if not isinstance(study, Studied):
        raise QuestionError("study: this is no result of ab.study or ab.design")
    if study.attrs.get("base_machine", study.attrs.get("machine")) != machine_text(machine):
        raise QuestionError(
            f"study: it is of another machine, {study.attrs.get('machine_name')!r}; run the study with this machine file"
        )
    return study


# A report as a typeset PDF (typst).


HEAD = """#set page(paper: "a4", margin: (x: 2.2cm, top: 2.2cm, bottom: 2cm), numbering: "1 / 1")
#set text(size: 9.5pt, lang: "en")
#set par(justify: false)
#set heading(numbering: "1")
#show heading.where(level: 1): set text(size: 13pt)
#show heading.where(level: 1): set block(above: 1.6em, below: 0.8em)
#show raw.where(block: true): it => block(fill: luma(245), inset: 6pt, width: 100%, text(size: 7.5pt, it))
#show figure.caption: set text(size: 8pt, fill: luma(80))
#set table(stroke: (x, y) => if y == 0 { none } else { (top: 0.4pt + luma(210)) }, inset: (x: 4pt, y: 3pt))
"""


def write_pdf(report: Report, path: Path) -> None:
    """Write the file.

    Raises
    ------
    ResultError
        If the file cannot be written.
    """
    import typst

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "report.typ"
        source.write_text(_source(report, Path(folder)), encoding="utf-8")
        made = typst.compile(str(source))
        write_safely(path, lambda file: file.write_bytes(made))


def _source(report: Report, folder: Path) -> str:
    parts = [HEAD, f"#set document(title: {_text(report.title)})"]
    parts.append(f'#text(size: 18pt, weight: "bold")[#{_text(report.title)}]')
    parts.append(_block(Rows((), report.about), folder, 0, 0))
    for number, section in enumerate(report.sections):
        parts.append(f"#heading(level: 1)[#{_text(section.title)}]")
        parts += [_block(block, folder, number, place) for place, block in enumerate(section.blocks)]
        if section.replay:
            parts.append(f"#text(size: 8pt, fill: luma(80))[made by] #raw({_text(section.replay)}, block: true)")
        if not number and report.sign:  # the first page is the one that is signed
            parts.append(
                "#v(2.2cm) #grid(columns: (1fr, 1fr, 1fr), gutter: 1cm, "
                + ", ".join(
                    f"[#line(length: 100%, stroke: 0.5pt) #text(size: 8pt)[{one}]]"
                    for one in ("name", "date", "signature")
                )
                + ")"
            )
            parts.append("#pagebreak(weak: true)")
    return "\n\n".join(parts)


def _text(text: str) -> str:
    """A text as a string of typst, so that nothing in it is read as a command."""
    return json.dumps(text, ensure_ascii=False).replace("\\/", "/")


def _block(block: Block, folder: Path, section: int, place: int) -> str:
    if isinstance(block, Paragraph):
        return f'#text(weight: "{"bold" if block.strong else "regular"}")[#{_text(block.text)}]'
    if isinstance(block, Listing):
        return f"#raw({_text(block.text)}, block: true)"
    if isinstance(block, Drawing):
        name = f"picture-{section}-{place}.png"
        (folder / name).write_bytes(block.png)
        words = _text(block.caption)
        return f'#figure(image("{name}", width: 92%, alt: {words}), caption: [#{words}], numbering: none)'
    return _table(block)


def _table(rows: Rows) -> str:
    width = len(rows.rows[0]) if rows.rows else len(rows.head)
    numeric = rows.numeric or (False,) * width
    align = ", ".join("right" if one else "left" for one in numeric)
    wide = rows.wide if any(rows.wide) else (False, width == 2 and not rows.head) + (False,) * (width - 2)
    sizes = ", ".join("1fr" if one else "auto" for one in wide[:width])
    heads = [
        cell if one or not any(rows.wide) else cell.replace(" ", "\n")
        for cell, one in zip(rows.head, wide, strict=False)
    ]
    cells = [f"[*#{_text(cell)}*]" for cell in heads]
    cells += [f"[#{_text(cell)}]" for row in rows.rows for cell in row]
    return f"#table(columns: ({sizes},), align: ({align},), {', '.join(cells)})"


# Pages of a design: what was asked, what ran, which limits this machine keeps, and what was ruled out and why.


WIDTH = 24  # designs in the table
OPEN = "undecided"  # too few runs to say


@report_page(first=True, needs="designed")
def design_pages(designed: Designed, machine: Machine, study_file: str) -> list[Section]:
    """The design from which a machine was chosen.

    Raises
    ------
    QuestionError
        If the machine is none of its designs.
    """
    command = f"autobalancer design {quote(str(designed.attrs.get('specification_file', 'design.toml')))}"
    place = _place(designed, machine)
    page = Section(f"Design {designed.attrs['design_name']}", replay=f"{command}  # written to {study_file}")
    best = designed.best()
    label, count = str(best["label"].values[place - 1]), best.sizes["design"]
    page.blocks += [Paragraph(f"This machine is place {place} of {count}: {label}.", strong=True)]
    out = ", ".join(f"{stage} {many}" for stage, many in designed.ruled_out().items()) or "none"
    about = _about(designed)
    page.decisive.append(
        Decisive("design", f"place {place} of {count}: {label}; ruled out before: {out}", condition=about)
    )
    other = min(place, count - 1) if place == 1 else 0  # the next best, or the best
    if count > 1:
        page.decisive.append(
            Decisive(f"instead of place {other + 1}", _beside(best, place - 1, other), condition=about)
        )
    page.blocks += [
        facts(designed.facts()),
        columns_table(designed.isel(design=designed.order()[:WIDTH]).columns("rpm")),
    ]
    page.blocks += [Paragraph(f"{text}.") for text in designed.meanings()]
    page.blocks.append(
        drawing(
            design_picture(designed, title=""), "Candidates that each question ruled out; objectives of those that ran."
        )
    )
    why = Section("What was ruled out, and why", [Paragraph(text) for text in designed.reasons()], command)
    return [page, *_rotor(designed, command), _limits(designed, place, command), *([why] if why.blocks else [])]


def _beside(best: xr.Dataset, one: int, other: int) -> str:
    """What another design would give: its name, and its objectives beside those of the chosen one."""
    said = []
    for name in best.attrs["objectives"]:
        sign, factor = UNITS[best[name].attrs["units"]]
        values = [float(best[name].values[place]) for place in (other, one)]
        words = [f"{significant(factor * value)} {sign}" if math.isfinite(value) else "never" for value in values]
        said.append(f"{name.replace('_', ' ')} {words[0]} for {words[1]}")
    return f"{best['label'].values[other]}: {', '.join(said)}"


def _about(designed: Designed) -> str:
    """Of which runs the numbers of a design are."""
    known = dict(designed.facts())
    return f"{designed.attrs['members']} runs from random starts, {known['unbalance']}, {known['temperature']}"


def _rotor(designed: Designed, command: str) -> list[Section]:
    """The measured rotor beside the fitted one; nothing if it was not measured."""
    fit = _read_back(designed)
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


def _read_back(designs: Any) -> Answer | None:
    """The fit in the answer of a design; None if its rotor was no measured one."""
    if f"{PREFIX}receptance_real" not in designs:
        return None
    names = {name: str(name)[len(PREFIX) :] for name in designs.data_vars if str(name).startswith(PREFIX)}
    attrs = {str(name)[len(PREFIX) :]: value for name, value in designs.attrs.items() if str(name).startswith(PREFIX)}
    back = designs[list(names)].rename(names)
    back.attrs = {**attrs, "rotor": designs.attrs["rotor"], "modes": int(np.asarray(attrs["modes"]))}
    return Answer.of(back, "FittedReceptance")


def _place(designed: Designed, machine: Machine) -> int:
    wanted = _bare(machine)
    for place in range(1, designed.best().sizes["design"] + 1):
        if _bare(designed_machine(designed, place)) == wanted:
            return place
    raise QuestionError(
        f"study: this machine is no design of {designed.attrs['design_name']!r}; take a machine file that it wrote"
    )


def _bare(machine: Machine) -> str:
    """A machine without the words that say where it is from."""
    return machine_text(machine.model_copy(update={"name": "machine", "description": ""}))


def _limits(designed: Designed, place: int, command: str) -> Section:
    """The limits, what the chosen design reaches, and the share of its runs beyond with its interval."""
    one = designed.isel(design=designed.order()[place - 1])
    page, rows = Section("Limits of the design", replay=command), []
    for name, value in json.loads(designed.attrs["limits"]).items():
        if row := _limit(one, name, value, float(designed.attrs["share"])):
            requested, reached, share, enough = row
            words = name.replace("_", " ")
            rows.append((words, requested, reached, share, enough))
            beyond = f"; {share} of the runs are beyond it" if share != "-" else ""
            many = f"{100.0 * float(designed.attrs['share']):g} % of " * (name in designed)
            of = f"{many}{_about(designed)}" if share != "-" else "the worst of all unbalances and temperatures"
            page.decisive.append(Decisive(f"limit: {words} {requested}", f"{reached}{beyond}", enough, of))
    head = ("limit", "asked", "reached", "share of the runs beyond it, 95 % interval", "kept")
    page.blocks.append(Rows(head, tuple(rows), (False, True, True, False, False)))
    page.blocks.append(
        Paragraph(
            f"Reached is the value that {100.0 * float(designed.attrs['share']):g} % of the runs stay below, at the worst "
            "operating "
            "speed. A limit is kept if the upper end of the interval is not above the share that may be beyond "
            "it; undecided means that so few runs cannot tell."
        )
    )
    return page


def _limit(dataset: xr.Dataset, name: str, value: float, share: float) -> tuple[str, str, str, str] | None:
    """What was asked and reached, the share of the runs beyond with its interval, and whether that is enough."""
    if name in dataset and f"{name}_over" in dataset:
        sign, factor = UNITS[dataset[name].attrs["units"]]
        reached = (
            f"{significant(factor * float(dataset[name]))} {sign}" if math.isfinite(float(dataset[name])) else "never"
        )
        return f"{factor * value:.4g} {sign}", reached, *_beyond(dataset, f"{name}_over", 1.0 - share)
    if name == STALL:
        return f"{100.0 * value:.3g} %", f"{100.0 * float(dataset['stall']):.3g} %", *_beyond(dataset, "stall", value)
    if name == MARGIN:
        speeds = [float(dataset[border]) for border in ("release", "border") if not math.isnan(float(dataset[border]))]
        slowest = float(min(np.atleast_1d(dataset.attrs["speeds"])))
        margin = slowest / max(speeds) - 1.0 if speeds and max(speeds) > 0.0 else math.inf
        said = f"{significant(100.0 * margin)} %" if math.isfinite(margin) else "no border"
        return f"{100.0 * value:.3g} %", said, "-", yes_or_no(margin >= value * (1.0 - ROUNDING))
    if name == ENOUGH:
        margin = float(dataset["capability_margin"])
        return f"{value:g} times", f"{margin:.3g} times", "-", yes_or_no(margin >= value * (1.0 - ROUNDING))
    if name == PRESSURE:
        pressure = float(dataset["pressure"])
        return f"{1e-6 * value:.0f} MPa", f"{1e-6 * pressure:.0f} MPa", "-", yes_or_no(pressure <= value)
    return None


def _beyond(dataset: xr.Dataset, name: str, allowed: float) -> tuple[str, str]:
    """The share of the runs beyond a limit with its interval, and whether that is kept, by the rule of the order."""
    share, low, high = (float(dataset[f"{name}{end}"]) for end in ("", "_low", "_high"))
    kept = YES if high <= allowed else NO if low > allowed else OPEN
    return f"{100.0 * share:.3g} % ({100.0 * low:.2g} to {100.0 * high:.2g} %)", kept


# The page of the balls in their race: force and pressure on the wall, how fast they roll, what rolling asks of
# friction.


STATIC = 4.2e9  # Pa, ISO 76: pressure of a point contact at the static load rating of ball bearings
LEAST = 1e-5  # of the rotor speed, below which a slip is none
PRESSED = (
    0.5  # of the lowest critical speed: slower balls are not pressed to the wall well enough for a word on rolling
)


@report_page()
def balls_page(machine: Machine, summary: Summary, run: xr.Dataset, command: str) -> Section:
    """Force and pressure between ball and race at the highest speed; slip during a run.

    Parameters
    ----------
    machine, found
        The machine, and what is known of it.
    run
        Its run-up, with samples.
    command
        Makes the run-up again.
    """
    page = Section("Balls in their race", replay=f"autobalancer check machine.toml\n{command}")
    balls = resolve(machine)
    top = summary.highest_speed
    if top is None:
        page.blocks.append(Paragraph("Force and pressure are not stated: the drive names no highest speed."))
    else:
        _pressure(page, balls, top)
    _slip(page, balls, summary, run)
    return page


def _races(balls: tuple[Ball, ...]) -> dict[str, list[int]]:
    """The balls of each race, counted from 0."""
    races: dict[str, list[int]] = {}
    for number, ball in enumerate(balls):
        races.setdefault(f"balancer {ball.balancer + 1}, race {ball.race + 1}", []).append(number)
    return races


def _pressure(page: Section, balls: tuple[Ball, ...], top: float) -> None:
    rows = []
    for name, numbers in _races(balls).items():
        force, ball = max(
            ((float(balls[i].effective_mass) * float(balls[i].orbit_radius) * top**2, balls[i]) for i in numbers),
            key=lambda one: one[0],
        )
        text = "not known: no diameter"
        if ball.diameter > 0.0:
            radius = 0.5 * float(ball.diameter)
            pressure = greatest_pressure(force, STEEL, radius, float(ball.orbit_radius) + radius)
            text = f"{1e-6 * pressure:.0f} MPa, {100.0 * pressure / STATIC:.3g} % of the static limit of ball bearings (4200 MPa)"
            enough = yes_or_no(pressure <= STATIC)
            page.decisive.append(Decisive(f"pressure of a ball, {name}", text, enough, "the highest speed of the run"))
        rows.append((name, force_text(force), text))
    page.blocks.append(Rows(("race", "greatest force of a ball on the wall", "greatest pressure (Hertz)"), tuple(rows)))
    page.blocks.append(
        Paragraph(
            "A steel ball on a cylindrical steel wall (Johnson 1985); a groove that fits the ball closely lowers the pressure. "
            "Impacts are not counted. Limit: ISO 76."
        )
    )


def _slip(page: Section, balls: tuple[Ball, ...], summary: Summary, run: xr.Dataset) -> None:
    """How fast the balls move in their race, and the friction without which they would slide."""
    if "ball_speed_in_space" not in run or not run.sizes.get("time", 0) or not summary.critical_speeds:
        return
    time, rotor = run["time"].values, run["speed"].values
    own = np.asarray(run["ball_speed_in_space"].transpose("time", "ball").values, np.float64)
    pressed = np.abs(own) > PRESSED * summary.critical_speeds[0]
    rate = np.gradient(own - rotor[:, None], time, axis=0)
    rows = []
    for name, numbers in _races(balls).items():
        relative = np.abs(own[:, numbers] - rotor[:, None])
        fastest = float((relative * [float(balls[i].orbit_radius) for i in numbers]).max())
        spin = np.array([float(balls[i].spin_ratio * balls[i].mass / balls[i].effective_mass) for i in numbers])
        with np.errstate(divide="ignore", invalid="ignore"):
            requested = np.where(pressed[:, numbers], spin * np.abs(rate[:, numbers]) / own[:, numbers] ** 2, 0.0)
        left = float(relative[-1].max() / max(abs(rotor[-1]), 1e-12))
        rows.append(
            (
                name,
                f"{significant(fastest)} m/s",
                f"{significant(100.0 * left)} %" if left > LEAST else f"< {100.0 * LEAST:g} %",
                significant(float(requested.max())) if spin.max() > 0.0 else "- (point balls)",
            )
        )
    heads = (
        "race",
        "greatest speed of a ball in it",
        "slip at the end, of the rotor speed",
        "friction that rolling needs",
    )
    page.blocks.append(Rows(heads, tuple(rows), (False, True, True, True)))
    page.blocks.append(
        Paragraph(
            "Slip is the speed of a ball against the rotor. A ball rolls without sliding as long as the coefficient of friction "
            "at the wall is greater than its spin ratio times its acceleration in the race over the square of its speed in "
            "space, a little more in a fluid that carries part of it. Taken from samples every "
            f"{significant(float(np.diff(time).mean()))} s, above half of the lowest critical speed."
        )
    )


# The page of small changes: what a tenth more or less of a number of a machine does, and so which must be known well.


CHANGE = 0.1
NAMES = (
    "unbalance",
    "stiffness",
    "damping",
    "ball_diameter",
    "viscosity",
    "drag",
)  # drag where no viscosity can change
STANDING = {  # numbers that need no run, by their names in results
    "critical speed": "critical_speed",
    "release speed": "release_speed",
    "exact border": "exact_border",
    "capability": "capability",
}


@report_page(after=starts_page)
def change_page(machine: Machine, file: str, starts: int, seed: int) -> Section:
    """What changes of a tenth do to borders, capability, and run-ups from random starts.

    Parameters
    ----------
    machine
        As it is described.
    file
        Its name in commands.
    starts
        Random starts of the report, a tenth of them for each value; 0 for no runs.
    seed
        Of the first of them.
    """
    starts = -(-starts // 10)
    page, requested = Section("What small changes do"), [f"autobalancer borders {file}"]
    here, _ = standing_numbers(machine, STANDING)
    known = [name for name, key in STANDING.items() if math.isfinite(here[key]) and here[key] > 0.0]
    rows: list[tuple[str, ...]] = []
    middle, again = math.nan, f"--seeds {starts} --seed {seed}"
    if starts:
        middle = _median(ensemble(machine, seeds=starts, seed=seed, progress=silent)["peak_deflection"].values)
        requested.append(f"autobalancer ensemble {file} {again}")
    for name in NAMES:
        value = _value(machine, name)
        if not value > 0.0 or (name == "drag" and rows and rows[-1][0] == text_of("viscosity")):
            continue
        try:
            ends = [with_quantity(machine, name, end) for end in _ends(value)]
            runs = _runs(machine, name, value, starts, seed, middle)
        except AutobalancerError:
            continue
        items = [standing_numbers(end, STANDING)[0] for end in ends]
        cells = [_both([item[STANDING[key]] / here[STANDING[key]] for item in items]) for key in known]
        rows.append((text_of(name), *cells, *runs))
        requested.append(f'autobalancer borders {file} --over "{_span(name, value)}"')
        if starts:
            values = ",".join(f"{end:.6g}" for end in _ends(value))
            requested.append(f'autobalancer ensemble {file} --column "{name}={values} {si_unit_of(name)}" {again}')
    if not rows:
        page.blocks.append(Paragraph("Not stated: no number of the machine can be changed by itself."))
        return page
    measures = ["median peak deflection", "balanced (%)"] if starts else []
    heads = (f"{100.0 * CHANGE:g} % less / more of", *known, *measures)
    page.blocks.append(Rows(heads, tuple(rows), (False, *(True,) * (len(heads) - 1))))
    said = (
        f" Of {starts} run-ups from random starts, the same for all values: median, and the share that ends balanced."
    )
    page.blocks.append(
        Paragraph(
            "Changes in percent, of one number at a time; numbers that move a result by much must be known well. "
            "For scatter as it is expected, and how it acts together, add a study." + said * bool(starts)
        )
    )
    page.replay = "\n".join(requested)
    return page


def _value(machine: Machine, name: str) -> float:
    """The value that the machine has, nan if it has none that can be changed by its plain name."""
    if name in ("stiffness", "damping") and not isinstance(machine.rotor, PlanarRotor):
        return math.nan
    return value_of(machine, name)


def _ends(value: float) -> tuple[float, float]:
    """What is tried: a tenth less and more, as it stands in commands."""
    return float(f"{(1.0 - CHANGE) * value:.6g}"), float(f"{(1.0 + CHANGE) * value:.6g}")


def _span(name: str, value: float) -> str:
    low, high = _ends(value)
    return f"{name}={low:.6g}:{high:.6g} {si_unit_of(name)}:3"


def _runs(machine: Machine, name: str, value: float, starts: int, seed: int, middle: float) -> list[str]:
    """How run-ups with less and more change the median of the greatest deflection, and the shares that end balanced."""
    if not starts:
        return []
    result: Any = ensemble(machine, {name: _ends(value)}, seeds=starts, seed=seed, progress=silent)
    at = result[dimension_of(name)].values
    parts = [result.isel(member=np.isclose(at, end, rtol=1e-9)) for end in _ends(value)]
    ratios = [_median(part["peak_deflection"].values) / middle for part in parts]
    return [_both(ratios), " / ".join(f"{100.0 * float(part['balanced'].values.mean()):.3g}" for part in parts)]


def _median(values: Any) -> float:
    """Of the runs that have a number; nan if most have none."""
    known = np.isfinite(values)
    return float(np.median(values[known])) if known.mean() > 0.5 else math.nan


def _both(ratios: list[float]) -> str:
    return " / ".join("-" if not math.isfinite(ratio) else _signed(100.0 * (ratio - 1.0)) for ratio in ratios)


def _signed(percent: float) -> str:
    return "0" if abs(percent) < 0.05 else f"{'+' if percent > 0.0 else '−'}{significant(abs(percent), 2)}"


# The last pages: what the model leaves out, sources, the machine file.


LIMITS = (
    "The numbers are those of a model. It knows the machine only as far as the machine file at the end describes it, and ideal "
    "parts where nothing is said: round races on the axis without friction, rigid supports behind the springs, a fluid that "
    "fills the race.",
    "Border speeds say where balancing is stable for small disturbances; the run-up and the random starts say what happens on "
    "the way. Before a machine is built, measure a run-up and compare it.",
)


@report_page()
def limits_page(run: xr.Dataset) -> Section:
    """What the model leaves out, and whether this machine leaves the range of a law."""
    left = str(run.attrs.get("drag_warning", ""))
    own = [Paragraph(f"This machine leaves the range of its drag law: {left}.", strong=True)] if left else []
    return Section("Limits", [*own, *(Paragraph(text) for text in LIMITS)])


@report_page()
def sources_page(machine: Machine, run: xr.Dataset, summary: Summary, study: Studied | None) -> Section:
    """The literature of what this report uses, as ``autobalancer cite`` lists it."""
    made = {"report", "check", "basin"} | ({made_by(study)} if study is not None else set())
    found = sources(machine, run.attrs, made).items()
    rows = [("; ".join(uses) or "this program", printed(key) if key in bibliography() else key) for key, uses in found]
    planes = summary.off_center.planes if summary.off_center is not None else ()
    off = dict.fromkeys("this machine file" if plane.given else f"not given; {plane.source}" for plane in planes)
    rows += [("eccentricity of a race", text) for text in off]
    return Section(
        "Sources", [Rows((), tuple(rows)), *([Paragraph(machine.description)] if machine.description else [])]
    )


@report_page()
def file_page(machine: Machine) -> Section:
    """The whole machine file."""
    return Section("Machine file", [Listing(machine_text(machine))])

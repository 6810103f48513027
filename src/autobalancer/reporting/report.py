"""One file that says what a machine does, with every number's run."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.either_kind import check, simulate
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.laws.balance_quality import grade_argument
from autobalancer.machine import Machine
from autobalancer.measurement.comparison.opened import load_measured
from autobalancer.memory import refuse_what_does_not_fit
from autobalancer.patience import shows_progress, silent
from autobalancer.reporting.balls_page import balls_page
from autobalancer.reporting.change_page import change_page
from autobalancer.reporting.design_pages import design_pages
from autobalancer.reporting.html_file import html_text
from autobalancer.reporting.machine_pages import (
    capability_page,
    drawing_page,
    facts_page,
    map_page,
    margin_page,
    quality_page,
)
from autobalancer.reporting.page import Block, Listing, Paragraph, Report, Rows, Section, first_page
from autobalancer.reporting.pdf_file import write_pdf
from autobalancer.reporting.run_pages import (
    basin_page,
    fan_page,
    measured_page,
    residual_of,
    run_page,
    starts_page,
    study_pages,
)
from autobalancer.results.answers.studied import Studied
from autobalancer.results.provenance import provenance
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path, ready_to_write, write_text_safely
from autobalancer.shown import speeds_in_rpm
from autobalancer.simulation.sampling import Samples
from autobalancer.stability.summary.summary import Summary
from autobalancer.studies.design.answer import Designed
from autobalancer.studies.ensemble.ensemble import bytes_of_a_member, ensemble

TENTH = 10  # of the random starts, with which small changes are tried
PER_TURN, MOST_SAMPLES = 40, 400_000  # of a run that is compared with a measurement
FORMS = (".html", ".pdf")
LIMITS = (
    "The numbers are those of a model. It knows the machine only as far as the machine file at the end describes it, and ideal "
    "parts where nothing is said: round races on the axis without friction, rigid supports behind the springs, a fluid that "
    "fills the race.",
    "Border speeds say where balancing is stable for small disturbances; the run-up and the random starts say what happens on "
    "the way. Before a machine is built, measure a run-up and compare it.",
)

SOURCES = (
    (
        "equations of motion, averaged border, release speed",
        "Spannan (2021), On the dynamic modelling of automatic ball balancers",
    ),
    ("balance quality grades", "ISO 21940-11"),
    ("class of an eccentric race that is not given", "ISO 2768-2"),
    ("pressure between ball and race", "Johnson (1985), Contact mechanics; limit: ISO 76"),
    ("intervals of shares", "Wilson (1927), J. Am. Stat. Assoc. 22"),
    ("Sobol' indices", "Saltelli et al. (2010) and Jansen (1999), Comput. Phys. Commun. 181 and 117"),
    ("intervals of rank correlations", "Fieller, Hartley and Pearson (1957), Biometrika 44"),
)


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
    name = str(machine) if isinstance(machine, (str, Path)) else "machine.toml"
    described = balls_in_races(machine)
    refuse_what_does_not_fit("report", starts, "starts", bytes_of_a_member(described, False), "; ask for fewer")
    wanted = _Wanted(
        name=Path(name).name,
        grade=None if grade is None else grade_argument(grade),
        study=_study(study, described),
        study_file=str(study) if isinstance(study, (str, Path)) else "study.nc",
        measured=load_measured(measured) if isinstance(measured, (str, Path)) else measured,
        measured_file=str(measured) if isinstance(measured, (str, Path)) else "MEASURED",
        starts=starts,
        seed=seed,
    )
    pages = _pages(described, wanted, progress)
    found = Report(f"{described.name}: automatic ball balancer", _identity(described, name), tuple(pages))
    if path.suffix.lower() == ".pdf":
        write_pdf(found, path)
    else:
        write_text_safely(path, html_text(found))
    return path


@dataclass(frozen=True)
class _Wanted:
    """What a report is asked for; files as they are named in commands."""

    name: str
    grade: float | None
    study: Studied | Designed | None
    study_file: str
    measured: xr.Dataset | None
    measured_file: str
    starts: int
    seed: int


def _pages(machine: Machine, wanted: _Wanted, progress: Callable[[int, int], None] | None) -> list[Section]:
    file, seed, starts = wanted.name, wanted.seed, wanted.starts
    total = 12 + 3 * bool(starts) + 2 * (wanted.study is not None) + (wanted.measured is not None)
    done: list[Section] = []

    def add(*pages: Section) -> None:
        done.extend(pages)
        if progress is not None:
            progress(min(len(done), total), total)

    summary = check(machine)
    assert isinstance(summary, Summary)
    run = simulate(machine, seed=seed, progress=False)
    held = simulate(machine, seed=seed, hold_balls=True, progress=False)
    command = f"autobalancer simulate {file} --seed {seed} --out run.nc"
    half = max(starts // 2, 2)
    if isinstance(wanted.study, Designed):
        add(*design_pages(wanted.study, machine, wanted.study_file))
    add(facts_page(summary), drawing_page(machine), capability_page(summary))
    add(quality_page(summary, residual_of(run), wanted.grade, command), run_page(run, held, command))
    if starts:
        again = f"autobalancer envelopes {file} --members {half} --seed {seed} --coast-down"
        add(fan_page(machine, half, seed, again))
    if wanted.measured is not None:
        count = _samples(machine, summary)
        fine = simulate(machine, seed=seed, save=[Samples(count)], progress=False)
        again = f"{command} --samples {count}\nautobalancer compare run.nc {wanted.measured_file}"
        add(measured_page(fine, wanted.measured, again))
    add(margin_page(summary), map_page(machine, summary))
    if starts:
        top = summary.highest_speed
        if top is not None:
            turning = f'autobalancer basin {file} --speed "{top:.17g} rad/s" --random {half} --seed {seed}'
            add(basin_page(machine, top, half, seed, turning))
        many: Any = ensemble(machine, seeds=starts, seed=seed, progress=silent)
        add(starts_page(many, f"autobalancer ensemble {file} --seeds {starts} --seed {seed}"))
    add(change_page(machine, file, -(-starts // TENTH), seed))
    if isinstance(wanted.study, Studied):
        add(*study_pages(wanted.study, wanted.study_file))
    add(balls_page(machine, summary, run, command))
    left = str(run.attrs.get("drag_warning", ""))
    own = [Paragraph(f"This machine leaves the range of its drag law: {left}.", strong=True)] if left else []
    add(Section("Limits", [*own, *(Paragraph(text) for text in LIMITS)]))
    add(
        Section(
            "Sources",
            [Rows((), SOURCES), Paragraph(machine.description)] if machine.description else [Rows((), SOURCES)],
        )
    )
    add(Section("Machine file", [Listing(machine_text(machine))]))
    for page in done:
        page.replay = page.replay.replace("machine.toml", file)
        page.blocks = [_in_rpm(block) for block in page.blocks]
    return [first_page(done), *done]


def _in_rpm(block: Block) -> Block:
    """Sentences of the package have speeds in rad/s."""
    return replace(block, text=speeds_in_rpm(block.text)) if isinstance(block, Paragraph) else block


def _samples(machine: Machine, found: Summary) -> int:
    """So many samples of the run-up that vibration can be compared."""
    assert machine.run is not None
    turns = float(machine.run.duration) * (found.highest_speed or 0.0) / (2.0 * math.pi)
    return int(min(max(PER_TURN * turns, 2000.0), MOST_SAMPLES)) + 1


def _identity(machine: Machine, name: str) -> tuple[tuple[str, str], ...]:
    made = provenance()
    return (
        ("machine", machine.name),
        ("file", name),
        ("SHA-256 of the machine file below", hashlib.sha256(machine_text(machine).encode()).hexdigest()),
        ("made by", made["source"]),
        ("on", made["created"]),
    )


def _study(given: Studied | Designed | str | Path | None, machine: Machine) -> Studied | Designed | None:
    if given is None:
        return None
    found = load_run(given) if isinstance(given, (str, Path)) else given
    if isinstance(found, Designed):
        return found
    if not isinstance(found, Studied):
        raise QuestionError("study: this is no result of ab.study or ab.design")
    if found.attrs.get("base_machine", found.attrs.get("machine")) != machine_text(machine):
        raise QuestionError(
            f"study: it is of another machine, {found.attrs.get('machine_name')!r}; run the study with this machine file"
        )
    return found

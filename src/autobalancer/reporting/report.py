"""One file that says what a machine does, with every number's run."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from autobalancer.either_kind import check, simulate
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress, silent
from autobalancer.reporting.design_pages import design_pages
from autobalancer.reporting.html_file import html_text
from autobalancer.reporting.machine_pages import facts_page, map_page, margin_page, quality_page, stress_page
from autobalancer.reporting.page import Listing, Paragraph, Report, Section
from autobalancer.reporting.pdf_file import write_pdf
from autobalancer.reporting.run_pages import residual_of, run_page, starts_page, study_pages
from autobalancer.results.answers.studied import Studied
from autobalancer.results.provenance import provenance
from autobalancer.results.store import load_run
from autobalancer.safe_file import ready_to_write, write_text_safely
from autobalancer.stability.summary.summary import Summary
from autobalancer.studies.design.answer import Designed
from autobalancer.studies.ensemble.ensemble import ensemble

FORMS = (".html", ".pdf")
GRADE = re.compile(r"G?\s*([0-9]+(?:\.[0-9]+)?)")
LIMITS = (
    "The numbers are those of a model. It knows the machine only as far as the machine file at the end describes it, and ideal "
    "parts where nothing is said: round races on the axis without friction, rigid supports behind the springs, a fluid that "
    "fills the race.",
    "Border speeds say where balancing is stable for small disturbances; the run-up and the random starts say what happens on "
    "the way. Before a machine is built, measure a run-up and compare it.",
)


@shows_progress
def report(
    machine: Machine | str | Path,
    path: str | Path,
    *,
    study: Studied | Designed | str | Path | None = None,
    grade: str | float | None = None,
    starts: int = 200,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write a report of a machine: what it is, what it does, how sure that is.

    Pages: identity and hash; what is known before a run; balance quality by ISO 21940-11; border speeds with margins and map;
    run-up with verdict; random starts; a study with sensitivity or a design, if given; forces in the race; limits; machine file.

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
    starts
        Number of random starts; 0 for none.
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
    path = Path(path)
    if path.suffix.lower() not in FORMS:
        raise QuestionError(f"{path}: a report is written as .html or .pdf; end the name with one of these")
    ready_to_write(path)
    name = str(machine) if isinstance(machine, (str, Path)) else "machine.toml"
    described = balls_in_races(machine)
    asked = _grade(grade)
    given = _study(study, described)
    pages = _pages(
        described, name, given, str(study) if isinstance(study, (str, Path)) else "STUDY", asked, starts, seed, progress
    )
    found = Report(f"{described.name}: automatic ball balancer", _identity(described, name), tuple(pages))
    if path.suffix.lower() == ".pdf":
        write_pdf(found, path)
    else:
        write_text_safely(path, html_text(found))
    return path


def _pages(
    machine: Machine,
    name: str,
    study: Studied | Designed | None,
    study_file: str,
    grade: float | None,
    starts: int,
    seed: int,
    progress: Callable[[int, int], None] | None,
) -> list[Section]:
    file = Path(name).name
    total = 8 + (study is not None)
    done: list[Section] = []

    def add(*pages: Section) -> None:
        done.extend(pages)
        if progress is not None:
            progress(min(len(done), total), total)

    summary = check(machine)
    assert isinstance(summary, Summary)
    run = simulate(machine, seed=seed, progress=False)
    held = simulate(machine, seed=seed, hold_balls=True, progress=False)
    add(facts_page(summary), quality_page(summary, residual_of(run), grade))
    add(run_page(run, held, f"autobalancer simulate {file} --seed {seed} --out run.nc"))
    add(margin_page(summary), map_page(machine, summary))
    if starts:
        many: Any = ensemble(machine, seeds=starts, seed=seed, progress=silent)
        add(starts_page(many, f"autobalancer ensemble {file} --seeds {starts} --seed {seed}"))
    if study is not None:
        add(
            *(
                design_pages(study, machine, study_file)
                if isinstance(study, Designed)
                else study_pages(study, study_file)
            )
        )
    add(stress_page(machine, summary))
    add(Section("Limits", [Paragraph(text) for text in LIMITS]))
    add(Section("Machine file", [Listing(machine_text(machine))]))
    for page in done:
        page.replay = page.replay.replace("machine.toml", file)
    return done


def _identity(machine: Machine, name: str) -> tuple[tuple[str, str], ...]:
    made = provenance()
    return (
        ("machine", machine.name),
        ("file", name),
        ("SHA-256 of the machine file below", hashlib.sha256(machine_text(machine).encode()).hexdigest()),
        ("made by", made["source"]),
        ("on", made["created"]),
    )


def _grade(given: str | float | None) -> float | None:
    """A grade in m/s."""
    if given is None:
        return None
    found = GRADE.fullmatch(str(given).strip())
    if found is None or not float(found[1]) > 0.0:
        raise QuestionError(f"grade: given {given!r}; write it as in ISO 21940-11, such as 'G 2.5'")
    return 1e-3 * float(found[1])


def _study(given: Studied | Designed | str | Path | None, machine: Machine) -> Studied | Designed | None:
    if given is None:
        return None
    found = load_run(given) if isinstance(given, (str, Path)) else given
    if isinstance(found, Designed):
        return found
    if not isinstance(found, Studied):
        raise QuestionError("study: this is no result of ab.study or ab.design")
    if found.attrs.get("machine") != machine_text(machine):
        raise QuestionError(
            f"study: it is of another machine, {found.attrs.get('machine_name')!r}; run the study with this machine file"
        )
    return found

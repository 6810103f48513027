"""One analysis on the page: its form, the line of its job, its picture, and what it says."""

from __future__ import annotations

import time
from functools import partial
from html import escape
from typing import Any

from nicegui import core, run, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.check import PENCIL
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.work import Work
from autobalancer.app.store.analyses import ANALYSES, Entry, defaults, said
from autobalancer.app.store.drawn import file_of, svg_of
from autobalancer.app.store.jobs import Job, Latest
from autobalancer.app.store.known import Known
from autobalancer.app.store.latest import About, LatestAnswers
from autobalancer.app.text.quantities import alike
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine

FIELD = "dense outlined hide-bottom-space options-dense"
FORMS = {"png": "picture (PNG)", "svg": "picture (SVG)", "nc": "numbers (netCDF)"}
SOON = 6.0  # s, after which something is probably compiled
COMPILING = "working; what is asked for the first time is compiled before, up to a minute or two"
OLD = "This answer is of {name} as it was on {made}; the machine of the page is another one."


class Panel:
    """Asks one question in the queue of jobs, and shows its latest answer, whenever that was made."""

    def __init__(self, bench: Bench, name: str, answers: LatestAnswers) -> None:
        self.bench, self.name, self.answers = bench, name, answers
        self.analysis = ANALYSES[name]
        self.known: Known | None = None
        self.own: dict[str, str] = {}  # what the user has entered
        self.inputs: dict[str, Any] = {}
        self.about: About | None = None
        self.drawing = Latest(PENCIL)
        self.filling = False
        self.waits = self.wanted = False  # for what is known of another machine; whether it was started meanwhile
        self.why = ""  # why the question is not for the machine
        with ui.element("section").classes("card"):
            ui.label(self.analysis.about).classes("quiet")
            self.form = ui.row().classes("items-start gap-2 w-full q-mt-sm")
            with self.form:
                for key, entry in self.analysis.entries.items():
                    self.inputs[key] = self._entry(key, entry)
                self.button = ui.button("Work it out", icon="play_arrow", on_click=self.start)
                marked(self.button.props("unelevated no-caps"), at=f"ask {name}")
                self.work = Work(bench, name, self._word)
            self.wrong = marked(ui.label().classes("wrong").props('role="alert"'), at=f"wrong {name}")
        self.wrong.set_visibility(False)
        with ui.element("section").classes("card") as self.card:
            self.old = marked(ui.label().classes("note"), at=f"old {name}")
            self.place()
            self.words = marked(ui.html("", sanitize=False).classes("w-full"), at=f"words {name}")
            with ui.row().classes("gap-2 items-center q-mt-sm"):
                ui.label("Save as").classes("quiet")
                for kind, word in FORMS.items():
                    button = ui.button(word, on_click=partial(self.save, kind)).props("flat dense no-caps")
                    marked(button, at=f"save {name} {kind}")
        self.card.set_visibility(False)
        going = next((job for job in bench.jobs.of(bench.user) if not job.over and job.title == self.title), None)
        if going is not None:
            self.work.watch(going, self.over)

    @property
    def title(self) -> str:
        """Of its jobs."""
        return f"analysis {self.name}"

    def _word(self, job: Job) -> str:
        if job.share:
            return self.analysis.word(job.share)
        return COMPILING if job.begun and time.monotonic() - job.begun > SOON else "working"

    def place(self) -> None:
        """Make room for the picture."""
        self.picture = ui.html("", sanitize=False).classes("w-full stability-picture")
        marked(self.picture, at=f"picture {self.name}")

    def _entry(self, key: str, entry: Entry) -> Any:
        if entry.choices is not None:
            one: Any = ui.select({}, label=entry.label, on_change=partial(self._entered, key))
        else:
            one = ui.input(entry.label, on_change=partial(self._entered, key)).props("debounce=150")
        marked(one.props(FIELD), at=f"{self.name} {key}").classes("entry-of-analysis" + (" wide" if entry.wide else ""))
        hinted(one.without_auto_validation(), entry.help)
        return one

    def _entered(self, key: str, event: Any) -> None:
        if self.filling:
            return
        self.own[key] = str(event.value or "")
        self.inputs[key].error = None
        if self.analysis.entries[key].choices is not None:  # what depends on it is no longer the user's
            later = list(self.inputs)[list(self.inputs).index(key) + 1 :]
            self.own = {one: text for one, text in self.own.items() if one not in later or one == "speed"}
            self.fill(self.known, "")

    def fill(self, known: Known | None, why: str) -> None:
        """Take what is known of the machine into the form, or say why the question is not for it."""
        self.known = known
        why = why or (self.analysis.refusal(known) if known is not None else "")
        self.form.set_visibility(not why)
        self.why = why
        self.card.set_visibility(self.about is not None and not why)
        self.say_wrong(f"{self.analysis.title} {why}." if why else "")
        if known is None or why:
            return
        self.filling = True
        given = defaults(self.analysis, known, self.own)
        for key, entry in self.analysis.entries.items():
            if entry.choices is not None:
                self.inputs[key].set_options(dict(entry.choices(known)), value=given[key])
            else:
                self.inputs[key].set_value(given[key])
        self.filling = False
        self.mark_old()

    def ready(self) -> None:
        """The form is that of the machine of the page; what was started meanwhile begins."""
        wanted, self.waits, self.wanted = self.wanted, False, False
        if wanted:
            self.work.said.set_text("")
        if wanted and not self.why:
            self.start()

    def say_wrong(self, text: str) -> None:
        """What is wrong, below the form."""
        self.wrong.set_text(text)
        self.wrong.set_visibility(bool(text))

    def given(self) -> dict[str, str]:
        """The texts of the form."""
        return {key: str(one.value or "") for key, one in self.inputs.items()}

    def start(self) -> None:
        """Put the question into the queue; it goes on when the page is closed."""
        machine, text = self.bench.reading.machine, self.bench.text
        if self.waits:  # the form is still that of the machine before
            self.wanted = True
            self.work.said.set_text("begins")
            return
        if not isinstance(machine, Machine):
            return
        given = self.given()
        self.fault("")
        try:
            asked = self.analysis.read(machine, given)
        except AutobalancerError as error:
            self.fault(str(error))
            return
        self.work.start(
            self.title, lambda job: self.answers.ask(self.name, machine, text, asked, given, job), self.over
        )

    def fault(self, message: str) -> None:
        """Say what is wrong beside its entry, or below the form."""
        name, rest = self.analysis.wrong_entry(message)
        for key, one in self.inputs.items():
            one.error = rest if key == name else None
        self.say_wrong("" if name else message)

    def over(self, job: Job) -> None:
        """The job has ended."""
        if job.state == "failed":
            self.fault(job.message)
        elif job.result == self.name:
            self.show()

    def show(self) -> None:
        """Draw the latest answer in the background, if there is one."""
        about = self.answers.about(self.name)
        if about is None:
            return

        def work() -> Any:
            try:
                found = self.answers.answer(self.name)
                return found, self.drawn(found, about), self.told(found, about)
            except AutobalancerError as error:
                return None, str(error), ""

        def then(made: Any) -> None:
            if core.loop is not None:
                core.loop.call_soon_threadsafe(self._put, about, made)

        self.picture.classes(add="old")  # until the new one is there
        self.drawing.start(work, then)

    async def save(self, kind: str) -> None:
        """Send the answer to the browser as a file."""
        file = f"{self.name}.{kind}"
        if kind == "nc":
            ui.download.file(self.answers.path(self.name), file)
            return
        try:
            found = await run.io_bound(self.answers.answer, self.name)
            made = await run.io_bound(file_of, partial(self.analysis.draw, found), kind)
            if made is not None:  # the server does not end just now
                ui.download.content(made, file)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")

    def drawn(self, found: Any, about: About) -> Any:
        """The picture; called in another thread."""
        alternative = f"{self.analysis.title} of {about.name}. {' '.join(f'{text}.' for text in said(found))}"
        return svg_of(lambda: self.analysis.draw(found), alternative.strip())

    def told(self, found: Any, about: About) -> str:
        """What is said below the picture."""
        lines = "".join(f"<div>{escape(text)}</div>" for text in said(found))
        notes = "".join(f'<div class="note">{escape(text)}</div>' for text in about.notes)
        return f'{_table(found) if self.analysis.table else ""}<div class="quiet">{lines}</div>{notes}'

    def _put(self, about: About, made: Any) -> None:
        if self.card.is_deleted:
            return
        found, drawn, words = made
        with self.card:
            self.about = about
            self.picture.classes(remove="old")
            self.card.set_visibility(not self.why)
            self.words.set_content(words)
            if found is None:
                self.picture.set_content(f'<div class="wrong">{escape(drawn)}</div>')
            else:
                self.put(found, drawn)
            self.mark_old()

    def put(self, found: Any, drawn: Any) -> None:
        """Put the picture on the page."""
        self.picture.set_content(drawn)

    def mark_old(self) -> None:
        """Say so if the picture is not of the machine as it is."""
        old = self.about is not None and not self.is_of_the_machine()
        self.old.set_visibility(old)
        if old and self.about is not None:
            self.old.set_text(OLD.format(name=self.about.name, made=self.about.made))

    def is_of_the_machine(self) -> bool:
        """Whether the answer is of the machine of the page."""
        machine = self.bench.reading.machine
        if self.about is None or self.about.text == self.bench.text:
            return True
        try:
            return isinstance(machine, Machine) and alike(self.about.machine, machine)
        except AutobalancerError:
            return False


def _table(found: Any) -> str:
    columns = found.columns()
    heads = "".join(f"<th>{escape(f'{one.head} ({one.unit})' if one.unit else one.head)}</th>" for one in columns)
    rows = zip(*(one.cells() for one in columns), strict=True)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<table class="facts spaced"><tr>{heads}</tr>{body}</table>'

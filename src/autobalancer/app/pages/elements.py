"""One entry of the form: a quantity with its unit, a choice, a switch, a text."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

from fastapi import Request, Response
from fastapi.responses import PlainTextResponse
from nicegui import app, ui

from autobalancer.app.problems import EMPTY, LARGEST, Reading, read, self_contained
from autobalancer.app.store.jobs import Job, Jobs
from autobalancer.app.store.kept_runs import LOCAL, user_folder
from autobalancer.errors import AutobalancerError, ResultError
from autobalancer.files.examples import example_text
from autobalancer.safe_file import write_text_safely
from autobalancer.tables import Column

Changed = Callable[[Any], None]
E = TypeVar("E")  # what a list shows


def say_refused(event: Any, what: str, ends: str, largest: int) -> None:
    """Say why the browser did not take a file: its kind or its size."""
    kind = "accept" in json.dumps(event.args, default=str)
    ui.notify(f"{what} ends in {ends}" if kind else f"{what} has at most {largest // 1_000_000} MB", type="negative")


def uploader(take: Callable[[Any], Any], what: str, suffixes: Sequence[str], largest: int, *, at: str) -> ui.upload:
    """A hidden element that takes one file; ``run_method("pickFiles")`` asks for it."""
    box = ui.upload(on_upload=take, auto_upload=True, max_file_size=largest, max_files=1)
    box.on("rejected", lambda event: say_refused(event, what, ", ".join(suffixes), largest))
    box.props["accept"] = ",".join(suffixes)
    return marked(box.classes("hidden"), at=at)  # type: ignore[no-any-return]


def picker(options: Any, label: str, take: Callable[[str], Any], *, at: str) -> ui.select:
    """A list that one can search, whose choice is taken at once; its box shows none, so any can be taken once more."""

    def chosen(event: Any) -> None:
        if event.value:
            ui.timer(0.05, lambda: box.set_value(None), once=True)  # after what the browser does with the choice
            take(event.value)

    box = ui.select(options, label=label, with_input=True, on_change=chosen)
    box.props("dense outlined options-dense", remove="fill-input").style("width: 220px")
    marked(box, at=at)
    return box


# The help that comes when the mouse rests on something, and the names of elements.


def hinted(element: Any, text: str) -> Any:
    """Give an element of the page its help; the element comes back.

    The help is put within the element. NiceGUI's own ``tooltip`` looks for the element in what is shown, and does not find what
    is made while another part of the page is in front.
    """
    with element:
        ui.tooltip(text)
    return element


def marked(element: Any, *, at: str = "", label: str = "", about: str = "") -> Any:
    """Give an element of the page the mark by which tests find it, its name and its description for those who do not see it.

    They are set as data. NiceGUI's own ``props`` reads a text as code: what a user has named must never come into it.
    """
    for key, text in (("data-at", at), ("aria-label", label), ("aria-description", about)):
        if text:
            element.props[key] = text
    return element


# What pages have in common: buttons, refusals, questions before something goes, lists, pictures that a job draws.


FLAT = "flat dense no-caps"


def button(
    text: str,
    act: Any = None,
    icon: str | None = None,
    look: str = FLAT,
    *,
    at: str = "",
    label: str = "",
    hint: str = "",
) -> Any:
    """A button with its look, its marks and its help."""
    made = marked(ui.button(text, icon=icon, on_click=act), at=at, label=label)
    for name, _, value in (word.partition("=") for word in look.split()):
        made.props[name] = value or True
    return hinted(made, hint) if hint else made


@contextlib.contextmanager
def refusals() -> Iterator[None]:
    """What is refused while it lasts is said at the edge of the page."""
    try:
        yield
    except (AutobalancerError, OSError, ValueError) as error:
        ui.notify(str(error), type="warning")


def delete_button(what: str, question: str, gone: Callable[[], None], after: Callable[[], None]) -> None:
    """A button that takes something away for good once a person has said yes to a question."""

    def ask() -> None:
        def yes() -> None:
            dialog.close()
            with refusals():
                gone()
            after()

        with ui.dialog(value=True) as dialog, ui.card():
            ui.label(question)
            with ui.row():
                button("Delete", yes, look="no-caps color=negative")
                button("Keep", dialog.close, look="no-caps flat")

    button("", ask, "delete_outline", "flat dense round", label=f"delete {what}")


def notes_html(texts: Sequence[str], look: str = "note") -> str:
    """Sentences one below the other; by default as notes that the package gave."""
    return "".join(f'<div class="{look}">{escape(text)}</div>' for text in texts)


def table_html(columns: Sequence[Column], at: str = "", most: int = 200, look: str = "") -> str:
    """A table with numbers at the right; of a long one the first rows."""
    heads = [f"{column.head} ({column.unit})" if column.unit else column.head for column in columns]
    sides = [" class='number'" if column.numeric else "" for column in columns]
    rows = list(zip(*(column.cells() for column in columns), strict=True))
    top = "".join(f"<th{side}>{escape(head)}</th>" for head, side in zip(heads, sides, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{side}>{escape(cell)}</td>" for cell, side in zip(row, sides, strict=True)) + "</tr>"
        for row in rows[:most]
    )
    more = f"<div class='quiet'>and {len(rows) - most} more rows</div>" if len(rows) > most else ""
    return (
        f'<div class="wide-table"><table class="facts {look}" data-at="{at}"><tr>{top}</tr>{body}</table></div>{more}'
    )


class Lines(Generic[E]):
    """The lines of a list, one for each entry of a folder; those that are right stay under the hand of whoever uses them."""

    def __init__(self, put: Callable[[E, Any], None]) -> None:
        self.put = put
        self.list = ui.column().classes("w-full gap-0 q-mt-sm")
        self.known: dict[str, tuple[E, Any]] = {}  # entry and line by name

    def follow(self, wanted: Mapping[str, E], right: Callable[[str], bool] = lambda _name: True) -> None:
        """Show these entries in their order; what has changed, or is not ``right`` any more, is made anew."""
        for name, (entry, line) in [*self.known.items()]:
            if wanted.get(name) != entry or not right(name):
                line.delete()
                del self.known[name]
        for place, (name, entry) in enumerate(wanted.items()):
            if name not in self.known:
                with self.list:
                    line = marked(ui.row().classes("items-center gap-2 w-full no-wrap archive-line"), at=name)
                self.known[name] = (entry, line)
                with line:
                    self.put(entry, line)
                line.move(target_index=place)


# A text that is being written: who asks for it gets also what was typed a moment ago, so that no change overwrites
# another.


UNDONE = 200  # texts that can be brought back


class Typed:
    """The text, who wants to know of changes, and what an editor waits with until the typing pauses.

    It stays in the file at ``path`` when the page is left; ``first`` is what there is before. :meth:`set_text` is the only way in
    which it changes. Where another page has changed the file meanwhile, ``on_other_page`` is called, and its text can be brought
    back by undoing twice.
    """

    def __init__(self, path: Path, first: str) -> None:
        self._path, self._text = path, first
        with contextlib.suppress(OSError, ValueError):
            self._text = path.read_text(encoding="utf-8")[:LARGEST]
        self._written = self._text  # as this page knows the file
        self.on_other_page: Callable[[], None] = lambda: None
        self.typing: Callable[[], None] | None = None
        self._listeners: list[Callable[[object], None]] = []
        self.past: list[str] = []
        self.future: list[str] = []

    def take(self) -> None:
        """Take what is being typed."""
        typing, self.typing = self.typing, None
        if typing is not None:
            typing()

    @property
    def text(self) -> str:
        """With all that was typed."""
        self.take()
        return self._text

    def edit(self, change: Callable[[str], str], origin: object = None) -> None:
        """Change the text; where something typed has to be taken first, the entries of ``origin`` are not up to date either."""
        late = self.typing is not None
        text = change(self.text)
        self.set_text(text, None if late else origin)

    def on_change(self, listener: Callable[[object], None]) -> None:
        """Call ``listener`` with the origin of every change."""
        self._listeners.append(listener)

    def set_text(self, text: str, origin: object = None, *, keep: bool = True) -> None:
        """Take another text; ``origin`` is who changed it, and ``keep`` whether it can be undone."""
        self.take()
        if text == self._text or len(text) > LARGEST:
            return
        other = self._of_other_page()
        if keep:
            self.past = [*self.past, *([] if other is None else [other]), self._text][-UNDONE:]
            self.future = []
        self._text = text
        self._understand()
        with contextlib.suppress(OSError, ResultError):  # a full disk: the page goes on
            write_text_safely(self._path, text)
            self._written = text
        self.tell(origin)
        if other is not None:
            self.on_other_page()

    def tell(self, origin: object) -> None:
        """Call everyone who wants to know."""
        for listener in self._listeners:
            listener(origin)

    def look(self) -> None:
        """Follow another page that has changed the file, unless somebody types here; undo brings the text of this one back."""
        other = self._of_other_page() if self.typing is None else None
        if other is not None:
            self.past = [*self.past, self._text][-UNDONE:]
            self._text = self._written = other
            self._understand()
            self.tell(None)

    def _of_other_page(self) -> str | None:
        """What another page has written into the file since this one read or wrote it."""
        try:
            there = self._path.read_text(encoding="utf-8")[:LARGEST]
        except (OSError, ValueError):
            return None
        return there if there.splitlines() != self._written.splitlines() else None

    def undo(self) -> None:
        """Go back to the text before."""
        self.take()
        if self.past:
            self.future.append(self._text)
            self.set_text(self.past.pop(), keep=False)

    def redo(self) -> None:
        """Bring back what was undone."""
        self.take()
        if self.future:
            self.past.append(self._text)
            self.set_text(self.future.pop(), keep=False)

    def _understand(self) -> None:
        """What is made of every text before anybody is told of it."""


# The text of a file on the page: what is typed is told when the typing pauses.


PAUSE = 0.4  # s
LIGHT: Literal["githubLight"] = "githubLight"
LABEL_EDITORS = """(() => {
  document.querySelectorAll(".cm-content:not([aria-label])").forEach((one) =>
    one.setAttribute("aria-label", one.closest("[aria-label]")?.getAttribute("aria-label") || "text"));
  return document.body.classList.contains("body--dark");
})()"""
DARK: Literal["githubDark"] = "githubDark"


def toml_editor(of: Typed, dark: Any) -> Any:
    """Put an editor of a text on the page."""
    editor: Any = ui.codemirror(of.text, language="TOML", theme=LIGHT, line_wrapping=True, indent="  ")
    timer: dict[str, Any] = {}

    def later(event: Any) -> None:
        """Wait until the typing pauses, or somebody asks for the text."""
        of.typing = None
        if timer.get("now") is not None:
            timer["now"].cancel()
        if event.value == of.text:
            return
        of.typing = lambda: of.set_text(event.value or "", editor)
        timer["now"] = ui.timer(PAUSE, of.take, once=True)

    def follow(origin: object) -> None:
        if origin is not editor:
            editor.value = of.text

    editor.on_value_change(later)
    of.on_change(follow)

    def shade(now: bool | None) -> None:
        editor.theme = DARK if now else LIGHT

    async def as_browser() -> None:
        """Until somebody chooses, the page is as the browser is set."""
        with contextlib.suppress(TimeoutError):  # the page was closed
            shaded = await ui.run_javascript(LABEL_EDITORS)
            if dark.value is None:
                shade(shaded)

    shade(dark.value)
    dark.on_value_change(lambda _event: shade(dark.value))
    ui.timer(0.3, as_browser, once=True)
    return editor


# A line of the page that shows one job: its word, its bar, its end.


class Work:
    """Starts jobs one after the other and says how far the latest is; an older one ends when a newer is started."""

    def __init__(self, bench: Bench, at: str, word: Callable[[Job], str] | None = None) -> None:
        self.bench, self.word = bench, word
        self.job: Job | None = None
        self.then: Callable[[Job], None] = lambda _job: None
        with ui.row().classes("items-center gap-2") as self.line:
            self.spinner = ui.spinner(size="1.1em")
            self.said = marked(ui.label().classes("quiet").props('role="status"'), at=f"{at} state")
            self.cancel = button("Cancel", self.end, "stop", at=f"{at} cancel")
        self.timer = ui.timer(0.15, self.look, active=False)
        self._rest()

    def start(self, title: str, work: Callable[[Job], Any], then: Callable[[Job], None]) -> None:
        """Put work into the queue; ``then`` is called on the page when it is over, whatever came of it."""
        self.end()
        with refusals():
            self.watch(self.bench.jobs.start(self.bench.user, title, work), then)

    def draw(
        self,
        title: str,
        make: Callable[[Job], tuple[str, Any]],
        into: Any,
        then: Callable[[Any, Job], None] = lambda _found, _job: None,
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        """Let a job make a picture, as HTML, and what belongs to it, which ``then`` gets; none of a picture that failed.

        What came out is put in place only while it is ``wanted``; until then the picture before is pale.
        """
        into.classes(add="old")

        def over(job: Job) -> None:
            if into.is_deleted:
                return
            into.classes(remove="old")
            if job.state == "cancelled" or not wanted():
                return
            content, found = (
                job.result if job.state == "done" else (f'<div class="wrong">{escape(job.message)}</div>', None)
            )
            into.set_content(content)
            then(found, job)

        self.start(title, make, over)

    def follow(self, title: str, then: Callable[[Job], None]) -> None:
        """Follow the job of this title, or with this first word, if it was started before the page was opened."""
        known = [job for job in self.bench.jobs.of(self.bench.user) if not job.over]
        going = [job for job in known if job.title == title or (title.endswith(" ") and job.title.startswith(title))]
        if going:
            self.watch(going[0], then)

    def watch(self, job: Job, then: Callable[[Job], None]) -> None:
        """Follow a job, also one that was started before the page was opened."""
        self.job, self.then = job, then
        for one in (self.spinner, self.cancel):
            one.set_visibility(True)
        self.timer.activate()
        self.look()

    def end(self) -> None:
        """Cancel what is under way."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def look(self) -> None:
        """Say how far the job is."""
        job = self.job
        if job is None:
            return
        said = self.word(job) if self.word is not None else f"{100.0 * job.share:.0f} %" if job.share else "working"
        self.said.set_text("waits for its turn" if job.state == "waiting" else said)
        if not job.over:
            return
        self.job = None
        self._rest()
        self.said.set_text({"failed": "", "cancelled": job.message or "cancelled"}.get(job.state, ""))
        self.then(job)

    def _rest(self) -> None:
        self.timer.deactivate()
        for one in (self.spinner, self.cancel):
            one.set_visibility(False)


# What one open page works on: the text of a machine, its history, and who wants to know of changes.


FIRST = "stall_and_release"  # what a new user sees


class Bench(Typed):
    """The machine of a page; ``set_text`` is the only way in which it changes."""

    def __init__(self, user: str, home: Path, jobs: Jobs, long: Jobs | None = None) -> None:
        super().__init__(home / "draft.toml", example_text(FIRST))
        self.user, self.home, self.jobs = user, home, jobs
        self.files = home / "files"  # that machines of this user name
        self.long = long if long is not None else jobs  # of studies, one at a time, as each takes all cores
        self._reading: Reading = read(self._text, self.files)
        self.begun = self._text == EMPTY  # a machine from nothing: what is not filled in yet is no mistake

    @property
    def reading(self) -> Reading:
        """What the text says, with all that was typed."""
        self.take()
        return self._reading

    @property
    def whole_text(self) -> str:
        """The text of the machine, or the numbers of one that names files: what is asked of it needs nothing beside it."""
        machine = self.reading.machine
        return self.text if machine is None else self_contained(self.text, machine)

    def _understand(self) -> None:
        self._reading = read(self._text, self.files)
        self.begun = self._reading.machine is None and (self.begun or self._text == EMPTY)

    def reread(self, origin: object = None) -> None:
        """A file that the machine may name is another one now."""
        self._understand()
        self.tell(origin)

    def insist(self) -> None:
        """From now on, what is missing is wrong."""
        if self.begun:
            self.begun = False
            self.tell(None)


# Files of runs as answers of the server.


def user_of(request: Request) -> str:
    """Who asks, as the guard noted."""
    return str(request.scope.get("state", {}).get("user", LOCAL))


def serve_at(root: Path, route: str, find: Callable[..., Response]) -> None:
    """Answer a route with what is found in the folder of whoever asks by the names in it; 404 says what there is not."""

    @app.get(route)
    async def answer(request: Request) -> Response:
        try:
            return await asyncio.to_thread(find, user_folder(root, user_of(request)), **request.path_params)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)

"""Studies and designs: nothing of them is loaded until somebody comes here, so that the page opens at once."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import Any

from fastapi import Request, Response
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import app, run, ui

from autobalancer.app.pages.elements import Bench, user_of
from autobalancer.app.store.kept_runs import user_folder
from autobalancer.app.store.studies import Studies
from autobalancer.errors import AutobalancerError, QuestionError


class StudiesPage:
    """Stands for the page until it is seen."""

    def __init__(self, bench: Bench, dark: Any) -> None:
        self.bench, self.dark = bench, dark
        self.opened: Any = None
        self.begun = False
        self.place = ui.column().classes("w-full gap-3")
        with self.place:
            ui.spinner(size="1.4em")

    async def seen(self, now: bool) -> None:
        """The person has come to this page, or has left it."""
        if self.opened is not None:
            self.opened.seen(now)
        elif now and not self.begun:
            self.begun = True
            made: Any = await run.io_bound(_opened)
            self.place.clear()
            with self.place:
                self.opened = made(self.bench, self.dark)


def _opened() -> Any:
    from autobalancer.app.pages.studies.opened import Opened

    return Opened


# Files of studies and designs as answers of the server.


TABLE = "table.csv"
CHOSEN = re.compile(r"design_(\d{1,4})\.toml")
TYPES = {
    ".toml": "application/toml",
    ".nc": "application/x-netcdf",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".pdf": "application/pdf",
}


def serve_studies(root: Path) -> None:
    """Answer ``/study/NAME/FILE`` with the studies of whoever asks."""

    @app.get("/study/{name}/{kind}")
    async def answer(request: Request, name: str, kind: str) -> Response:
        shelf = Studies(user_folder(root, user_of(request)))
        try:
            if kind == TABLE:
                text = await asyncio.to_thread(_table, shelf, name)
                as_file = {"content-disposition": f'attachment; filename="{name}-{TABLE}"'}
                return Response(text, media_type=TYPES[".csv"], headers=as_file)
            chosen = CHOSEN.fullmatch(kind)
            if chosen:
                text = await asyncio.to_thread(_chosen, shelf, name, int(chosen[1]))
                as_file = {"content-disposition": f'attachment; filename="{name}-{kind}"'}
                return Response(text, media_type=TYPES[".toml"], headers=as_file)
            path = shelf.file(name, kind)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        # the texts keep their names, by which one names the other
        called = path.name if path.suffix == ".toml" else f"{name}-{path.name}"
        return FileResponse(path, media_type=TYPES[path.suffix], filename=called)


def _table(shelf: Studies, name: str) -> str:
    from autobalancer.app.store.studies import result_of
    from autobalancer.results.export import result_csv

    return result_csv(result_of(shelf, name))


def _chosen(shelf: Studies, name: str, place: int) -> str:
    from autobalancer.app.store.studies import chosen_text, design_of

    found = design_of(shelf, name, None)
    if found is None:
        raise QuestionError(f"study {name}: is no finished design")
    return chosen_text(found, place)

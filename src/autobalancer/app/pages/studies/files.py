"""Files of studies and designs as answers of the server."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path

from fastapi import Request, Response
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import app

from autobalancer.app.pages.files import user_of
from autobalancer.app.store.names import user_folder
from autobalancer.app.store.studies.shelf import Studies
from autobalancer.errors import AutobalancerError, QuestionError

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
    from autobalancer.app.store.studies.work import result_of
    from autobalancer.results.export import result_csv

    return result_csv(result_of(shelf, name))


def _chosen(shelf: Studies, name: str, place: int) -> str:
    from autobalancer.app.store.studies.designs import chosen_text, design_of

    found = design_of(shelf, name, None)
    if found is None:
        raise QuestionError(f"study {name}: is no finished design")
    return chosen_text(found, place)

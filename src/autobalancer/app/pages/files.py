"""Files of runs as answers of the server."""

from __future__ import annotations

import asyncio
from pathlib import Path

from fastapi import Request, Response
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import app

from autobalancer.app.store.archive import Archive
from autobalancer.app.store.export import TYPES, exported
from autobalancer.app.store.names import LOCAL, user_folder
from autobalancer.errors import AutobalancerError


def user_of(request: Request) -> str:
    """Who asks, as the guard noted."""
    return str(request.scope.get("state", {}).get("user", LOCAL))


def serve_files(root: Path) -> None:
    """Answer ``/run/NAME/FORM`` with the runs of whoever asks."""

    @app.get("/run/{name}/{kind}")
    async def answer(request: Request, name: str, kind: str) -> Response:
        archive = Archive(user_folder(root, user_of(request)))
        try:
            found = await asyncio.to_thread(exported, archive, name, kind)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        as_file = {"content-disposition": f'attachment; filename="{name}-{kind}"'} if kind != "view.bin" else {}
        if isinstance(found, Path):
            return FileResponse(found, media_type=TYPES[kind], headers=as_file)
        return Response(found, media_type=TYPES[kind], headers=as_file)

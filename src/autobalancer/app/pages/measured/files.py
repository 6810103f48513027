"""Measured files, their waveforms and the fits to them as answers of the server."""

from __future__ import annotations

import asyncio
from pathlib import Path

from fastapi import Request, Response
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import app

from autobalancer.app.pages.files import user_of
from autobalancer.app.store.measured.shelf import Shelf
from autobalancer.app.store.names import user_folder
from autobalancer.errors import AutobalancerError


def serve_measured(root: Path) -> None:
    """Answer with the measurements of whoever asks."""

    def shelf_of(request: Request) -> Shelf:
        return Shelf(user_folder(root, user_of(request)))

    @app.get("/measured/{name}/wave.bin")
    async def waves(request: Request, name: str) -> Response:
        from autobalancer.app.store.measured.wave import wave_block

        shelf = shelf_of(request)
        try:
            found = await asyncio.to_thread(lambda: wave_block(shelf.data(name)))
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        return Response(found, media_type="application/octet-stream")

    @app.get("/measured/{name}/file")
    async def file(request: Request, name: str) -> Response:
        try:
            path = shelf_of(request).path(name)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        return FileResponse(path, media_type="application/octet-stream", filename=path.name)

    @app.get("/measured/{name}/fit/{fit}/{kind}")
    async def fitted(request: Request, name: str, fit: str, kind: str) -> Response:
        from autobalancer.app.store.measured.fits import FILES_OF, fit_file

        try:
            path = fit_file(shelf_of(request), name, fit, kind)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        return FileResponse(path, media_type=FILES_OF[kind], filename=f"{fit}-{kind}")

"""``autobalancer app``: the bench as a web page."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import Json


def app(
    port: Annotated[int, typer.Option(help="At which the page is served.")] = 8123,
    host: Annotated[
        str, typer.Option(help="Address to listen on; any but this computer's own needs a token.")
    ] = "127.0.0.1",
    token: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME:TOKEN",
            help="Who may use the page; each name has runs of its own. May be repeated. "
            "With another host and without it, one is made and printed.",
        ),
    ] = None,
    folder: Annotated[
        Path | None, typer.Option(help="Where runs are kept; by default autobalancer-bench in your home folder.")
    ] = None,
    time_limit: Annotated[float, typer.Option(min=1.0, help="Seconds that a run may take.")] = 600.0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
    as_json: Json = False,
) -> None:
    """Open the bench in a browser: describe, check and run machines on one page. Ctrl-C ends it.

    It answers this computer only, unless you name another host. Needs pip install 'autobalancer\\[app]'.

    Example: autobalancer app
    """
    from autobalancer.app.server.serve import FOLDER, serve
    from autobalancer.cli.terminal.exit_codes import stop_code
    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.words import say

    def announce(address: str, home: Path) -> None:
        if as_json:
            print_json({"address": address, "folder": str(home)})
        else:
            say(f"the bench is at {address}")
            say(f"runs are kept in {home}; Ctrl-C ends the server")

    browser, code = not no_browser, 0
    try:
        serve(
            folder or FOLDER,
            host=host,
            port=port,
            tokens=token or [],
            browser=browser,
            limit=time_limit,
            announce=announce,
        )
    except KeyboardInterrupt:
        typer.echo("stopped", err=True)
        code = stop_code()
    _leave(code)


def _leave(code: int) -> None:
    """End the process now: a thread that compiles cannot be interrupted, and every file is complete at any time."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)

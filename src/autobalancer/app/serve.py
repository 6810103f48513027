"""Starting the server."""

from __future__ import annotations

import gc
import hmac
import secrets
import socket
import threading
from collections.abc import Awaitable, Callable, MutableMapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from autobalancer.app.store.kept_runs import LOCAL, user_folder
from autobalancer.errors import AutobalancerError, QuestionError, ResultError, unwarned
from autobalancer.safe_file import ready_to_write

FOLDER = Path.home() / "autobalancer-bench"
SHORTEST = 12  # characters of a token
SHARE, LEAST = 0.8, 2_000_000_000  # of the free memory, and bytes, that the server may take
GRACE = 3.0  # s that jobs have at the end of the server to keep what they computed


def serve(
    folder: str | Path = FOLDER,
    *,
    host: str = "127.0.0.1",
    port: int = 8123,
    tokens: Sequence[str] = (),
    browser: bool = True,
    limit: float = 600.0,
    announce: Callable[[str, Path], None] | None = None,
) -> None:
    """Serve the bench as a web page, until Ctrl-C.

    Parameters
    ----------
    folder
        Where runs are kept, one folder for each user.
    host
        The address to listen on; any but this computer's own needs tokens.
    port
        At which it listens.
    tokens
        ``"NAME:TOKEN"`` for each user, or a token alone for one user. With another ``host`` and none given, one is made.
    browser
        Whether to open the page in a browser.
    limit
        Seconds that a job may take.
    announce
        Called with the address, with its token, and the folder, before the server starts.

    Raises
    ------
    QuestionError
        If an argument is not possible, or NiceGUI is not installed.
    """
    rules = rules_for(host, tokens)
    if not 0 < port < 65536:
        raise QuestionError(f"port: given {port}; must be between 1 and 65535")
    try:
        from autobalancer.app.bench import build
    except ImportError as reason:
        raise QuestionError(f"app: {reason}; install what it needs with: pip install 'autobalancer[app]'") from None
    from nicegui import ui

    home = writable(folder)
    refuse_taken(host, port)
    app = build(home, limit, several=len(rules.tokens) > 1)
    app.add_middleware(Guard, rules=rules)
    load_packages()
    limit_memory()
    threading.Thread(target=_warm_up, daemon=True).start()
    shown = f"[{host}]" if ":" in host else host
    token = next(iter(rules.tokens), "")
    address = f"http://{shown}:{port}/" + (f"?token={token}" if token else "")
    if announce is not None:
        announce(address, home)
    try:
        ui.run(
            host=host,
            port=port,
            title="autobalancer",
            show=f"/?token={token}" if browser and token else browser,
            reload=False,
            tailwind=False,
            dark=None,
            favicon="⚖",
            show_welcome_message=False,
            message_history_length=200,
            reconnect_timeout=20.0,
            timeout_graceful_shutdown=2,
        )
    finally:
        app.state.jobs.wait(GRACE)


def writable(folder: str | Path) -> Path:
    """The folder of the runs; it is made if there is none.

    Raises
    ------
    QuestionError
        If it cannot be written.
    """
    home = Path(folder).expanduser().resolve()
    try:
        ready_to_write(home / "trial")
        home.mkdir(parents=True, exist_ok=True)
    except (OSError, ResultError) as reason:
        why = str(reason).rpartition(": ")[2]
        raise QuestionError(f"folder: {home} cannot be written ({why}); name another with --folder") from None
    return home


def refuse_taken(host: str, port: int) -> None:
    """Try the port before anything is said of it.

    Raises
    ------
    QuestionError
        If another program listens there, or the address is not one of this computer.
    """
    try:
        with socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET):
            pass
    except OSError as reason:
        where = f"port: {port} of {host} cannot be taken: {reason.strerror or reason}"
        raise QuestionError(f"{where}; another program may have it: take another with --port") from None


def limit_memory() -> None:
    """Let what would take more memory than this computer has fail by itself, before the system ends the server for all."""
    try:
        import resource
    except ImportError:  # Windows
        return
    from autobalancer.memory import free_memory

    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = SHARE * free_memory()
    if wanted < float("inf"):
        limit = max(int(wanted), LEAST)
        resource.setrlimit(resource.RLIMIT_DATA, (limit if most == resource.RLIM_INFINITY else min(limit, most), most))


def rules_for(host: str, tokens: Sequence[str]) -> Rules:
    """Who may ask; a token is made where the server is open to others and none is given.

    Raises
    ------
    QuestionError
        If a token is too short, or a name is not possible.
    """
    known: dict[str, str] = {}
    for given in tokens:
        name, _, token = given.rpartition(":")
        name = name or LOCAL
        user_folder(Path(), name)
        if len(token) < SHORTEST or not token.isascii() or not all(sign.isalnum() or sign in "-_" for sign in token):
            raise QuestionError(
                f"token of {name}: must have at least {SHORTEST} letters, digits, '-' or '_'; give it as NAME:TOKEN"
            )
        known[token] = name
    if host in LOOPBACK:
        return Rules(known)
    return Rules(known or {secrets.token_urlsafe(18): LOCAL}, None)


def _warm_up() -> None:
    """Load or compile the equations, so that the first run of a user does not wait for them, and set what is loaded apart."""
    from autobalancer.api import check, run_measures, simulate, verdict
    from autobalancer.files.examples import example

    with unwarned():
        try:
            machine = example("stall_and_release")
            check(machine)
            run = simulate(machine, duration=0.5, progress=False)
            verdict(run, simulate(machine, duration=0.5, hold_balls=True, progress=False))
            run_measures(run)
        except AutobalancerError:  # whoever runs a machine is told
            pass
    gc.collect()
    gc.freeze()  # what stays is not looked at again, so that the collector comes around to what runs leave behind


# Who may ask the server: every request, of pages, files and sockets, passes here first.


Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

COOKIE = "autobalancer_token"
LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
LARGEST = 25_000_000  # bytes of a request
DIGITS = 12  # of a length that is looked at
TOO_LARGE = f"a request may have at most {LARGEST // 1_000_000} MB"
POLICY = (  # NiceGUI puts code into its pages and evaluates texts; what it runs can send nothing to another host
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; worker-src 'self' blob:; object-src 'none'; "
    "base-uri 'self'; form-action 'self'; frame-ancestors 'self'"
)
HEADERS = [
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"x-frame-options", b"SAMEORIGIN"),
]


@dataclass(frozen=True)
class Rules:
    """Users by their token, and the names under which the server may be called; without tokens anyone on this computer."""

    tokens: dict[str, str] = field(default_factory=dict)
    hosts: frozenset[str] | None = LOOPBACK  # None: any, where tokens say who asks

    def user(self, token: str) -> str | None:
        """The user of a token; ``None`` if there is none."""
        if not self.tokens:
            return LOCAL
        found = None
        for known, user in self.tokens.items():
            if hmac.compare_digest(known.encode(), token.encode("utf-8", "replace")):
                found = user
        return found


class Guard:
    """Refuses what is not allowed, and notes the user in ``scope["state"]["user"]``."""

    def __init__(self, app: Any, rules: Rules) -> None:
        self.app, self.rules = app, rules

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        host = headers.get("host", "")
        if self.rules.hosts is not None and _name(host) not in self.rules.hosts:
            await _refuse(scope, send, 403, "this server answers on this computer only")
            return
        origin = headers.get("origin", "")
        if origin and _place(origin) != host:
            await _refuse(scope, send, 403, "requests of other pages are not answered")
            return
        asked = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        user = self.rules.user(asked or _cookie(headers.get("cookie", "")))
        if user is None:
            await _refuse(scope, send, 401, "open the page with its token: http://.../?token=...")
            return
        if asked and self.rules.tokens and scope["type"] == "http" and scope["path"] == "/":
            await _keep_token(send, asked)
            return
        length = headers.get("content-length", "0")
        if not length.isdecimal() or len(length) > DIGITS or int(length) > LARGEST:
            await _refuse(scope, send, 413, TOO_LARGE)
            return
        scope.setdefault("state", {})["user"] = user
        await self.app(scope, _limited(receive), _with_headers(send))


def _name(host: str) -> str:
    """The name in a Host header, without its port; empty if it is none."""
    try:
        return (urlsplit(f"//{host}").hostname or "") if "@" not in host and "/" not in host else ""
    except ValueError:  # brackets that do not close
        return ""


def _place(origin: str) -> str:
    """Host and port of an Origin header; empty if they are none."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ""


def _cookie(text: str) -> str:
    try:
        held = SimpleCookie(text).get(COOKIE)
    except CookieError:
        return ""
    return held.value if held else ""


def _limited(receive: Receive) -> Receive:
    """No more bytes than allowed, whatever the request says of its length."""
    seen = 0

    async def counted() -> MutableMapping[str, Any]:
        nonlocal seen
        message = await receive()
        if message["type"] == "http.request":
            seen += len(message.get("body", b""))
            if seen > LARGEST:
                from starlette.exceptions import HTTPException

                raise HTTPException(413, TOO_LARGE)
        return message

    return counted


def _with_headers(send: Send) -> Send:
    async def sent(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", []), *HEADERS]
        await send(message)

    return sent


async def _keep_token(send: Send, token: str) -> None:
    """Put the token into a cookie and take it out of the address."""
    cookie = f"{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict"
    headers = [(b"location", b"/"), (b"set-cookie", cookie.encode("latin-1"))]
    await send({"type": "http.response.start", "status": 303, "headers": headers})
    await send({"type": "http.response.body", "body": b""})


async def _refuse(scope: Scope, send: Send, status: int, text: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": text.encode()})


# What is loaded before the first thread of the server starts.


PACKAGES = (
    "PIL.Image",
    "autobalancer.api",
    "autobalancer.assembly.chamber_assembly",
    "autobalancer.assembly.rotors",
    "autobalancer.flow",
    "autobalancer.simulation.chamber",
    "autobalancer.stability",
    "contourpy",
    "dask.array",  # Pint and xarray ask for it where it is installed
    "distributed",  # xarray asks for it before it writes a file
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
    "netCDF4",
    "pint",
    "scipy.integrate",
    "scipy.interpolate",
    "scipy.io",
    "scipy.linalg",
    "scipy.optimize",
    "scipy.signal",
    "scipy.special",
    "scipy.stats",
    "xarray.namedarray._array_api",
)


def load_packages() -> None:
    """Load the packages that threads would else load at need, perhaps two threads at the same time.

    Python 3.11 can give both of them a package of which half is missing, and it may stay so: files could not be written any
    more where Pint and xarray met in Dask. That happens to packages that load their own modules, of which the modules are
    asked for, too.
    """
    from numba import njit

    for name in PACKAGES:
        with suppress(ImportError):  # not all of them need to be there
            import_module(name)
    njit(lambda number: number)(1.0)  # Numba loads most of itself with its first function

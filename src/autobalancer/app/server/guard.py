"""Who may ask the server: every request, of pages, files and sockets, passes here first."""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

from autobalancer.app.store.names import LOCAL

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

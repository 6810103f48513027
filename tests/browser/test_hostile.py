"""A hundred malformed and hostile requests to the running server: it refuses each, its folder stays, and it goes on."""

from __future__ import annotations

import base64
import json
import os
import re
import select
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tools.browser import Server

pytestmark = pytest.mark.browser
NAME = "20260101-000000-abcdef"
SECRET = "what nobody may read"
LONGEST = 25_000_000  # bytes of a request, as the documentation says


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server with one run in its folder, and a file beside it that is none of its business."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "secret").write_text(SECRET)
    run = folder / "bench" / "local" / "runs" / NAME
    run.mkdir(parents=True)
    (run / "machine.toml").write_text('name = "kept"\n')
    (run / "note.json").write_text(
        json.dumps({"name": NAME, "machine": "kept", "made": "", "seconds": 1, "outcome": ""})
    )
    running = Server(folder / "bench")
    yield running
    running.stop()


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server that wants a token."""
    running = Server(tmp_path_factory.mktemp("guarded"), "--token", "ada:0123456789abcdef")
    yield running
    running.stop()


def answer(server: Server, sent: bytes, *, patience: float = 60.0) -> bytes:
    """What comes back to these bytes until the server hangs up."""
    found = b""
    with socket.create_connection(("127.0.0.1", server.port), timeout=patience) as line:
        try:
            line.sendall(sent)
            while part := line.recv(65536):
                found += part
        except (ConnectionError, TimeoutError):
            pass
    return found


def status(found: bytes) -> int:
    """The status of an answer; 0 if there is none."""
    head = re.match(rb"HTTP/1\.1 (\d{3}) ", found)
    return int(head[1]) if head else 0


def asked(server: Server, path: str, method: str = "GET", body: bytes = b"", **headers: str) -> bytes:
    given = {"Host": f"127.0.0.1:{server.port}", "Connection": "close"}
    given |= {name.replace("_", "-"): text for name, text in headers.items()}
    if body or method in ("POST", "PUT", "PATCH"):
        given.setdefault("Content-Length", str(len(body)))
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {text}" for name, text in given.items() if text)]
    return answer(server, "\r\n".join(lines).encode("latin-1") + b"\r\n\r\n" + body)


def contents(folder: Path) -> dict[str, tuple[bytes, int]]:
    """Every file of a folder, with its bytes and the time of its last change."""
    return {
        str(path.relative_to(folder)): (path.read_bytes(), path.stat().st_mtime_ns)
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


PATHS = [
    *(f"/run/{'../' * k}secret/machine.toml" for k in range(1, 6)),
    *(f"/run/{'%2e%2e%2f' * k}secret/run.nc" for k in range(1, 6)),
    *(f"/run/{'..%5c' * k}secret/run.nc" for k in range(1, 4)),
    *(
        f"/run/{NAME}/{kind}"
        for kind in ("..%2f..%2f..%2fsecret", "note.json", "secret", "%00", "film.gif", "run.nc%00")
    ),
    f"/run/{NAME}%00/machine.toml",
    f"/run/{NAME}%0a/machine.toml",
    f"/run/{NAME.upper()}/machine.toml",
    f"/run/{'x' * 8000}/run.nc",
    "/run/%c0%ae%c0%ae/machine.toml",
    "/run/%ff%fe/machine.toml",
    "/run/20260101-000000-000000/view.bin",
    "/run//machine.toml",
    "/../../../../etc/passwd",
    "/%2e%2e/%2e%2e/etc/passwd",
    "//etc/passwd",
    "/_nicegui/3/static/../../../../../etc/passwd",
    "/_nicegui/client/none/upload/1",
    *(f"/measured/{name}/file" for name in ("..%2f..%2fsecret", "..", "%00", NAME, "x" * 500)),
    f"/measured/{NAME}/wave.bin",
    f"/measured/{NAME}/fit/..%2f..%2fsecret/machine.toml",
    f"/measured/..%2f..%2f..%2fsecret/fit/{NAME}/machine.toml",
    "/docs",
    "/openapi.json",
]


@pytest.mark.parametrize("path", PATHS)
def test_a_path_that_leads_nowhere_is_not_found(served: Server, path: str) -> None:
    before = contents(served.folder.parent)
    found = asked(served, path)
    assert status(found) in (400, 403, 404, 422)
    assert SECRET.encode() not in found
    assert b"root:" not in found
    assert contents(served.folder.parent) == before


METHODS = ["POST", "PUT", "PATCH", "DELETE", "TRACE", "CONNECT", "PROPFIND", "BREW"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("path", ["/", f"/run/{NAME}/machine.toml"])
def test_a_run_is_only_read(served: Server, method: str, path: str) -> None:
    before = contents(served.folder.parent)
    assert status(asked(served, path, method, b"x")) in (400, 404, 405, 501)
    assert contents(served.folder.parent) == before


HEADERS: list[dict[str, str]] = [
    {"Host": "evil.example"},
    {"Host": ""},
    {"Host": "127.0.0.1@evil.example"},
    {"Host": "127.0.0.1/evil"},
    {"Host": "[::1"},
    {"Host": "127.0.0.1.evil.example"},
    {"Origin": "http://evil.example"},
    {"Origin": "null"},
    {"Origin": "http://[::1"},
    {"Content_Length": str(LONGEST + 1)},
    {"Content_Length": "-1"},
    {"Content_Length": "1e9"},
    {"Content_Length": "\u00b2"},
    {"Transfer_Encoding": "rubbish"},
]


@pytest.mark.parametrize("headers", HEADERS, ids=str)
def test_a_head_that_is_not_right_is_refused(served: Server, headers: dict[str, str]) -> None:
    found = asked(served, f"/run/{NAME}/machine.toml", **headers)
    assert status(found) in (400, 403, 411, 413, 501)
    assert b"kept" not in found


BODIES = {
    "no multipart": ("multipart/form-data; boundary=x", b"rubbish"),
    "cut off": (
        "multipart/form-data; boundary=x",
        b'--x\r\nContent-Disposition: form-data; name="f"; filename="../../secret"\r\n',
    ),
    "no boundary": ("multipart/form-data", b"--\r\n\r\n--"),
    "no JSON": ("application/json", b"{[}"),
    "deep JSON": ("application/json", b"[" * 50_000),
    "text": ("text/plain", b"\xff" * 1000),
}


@pytest.mark.parametrize("kind", BODIES)
def test_an_upload_that_is_none_is_refused(served: Server, kind: str) -> None:
    before = contents(served.folder.parent)
    for place in upload_places(served):
        found = asked(served, place, "POST", BODIES[kind][1], Content_Type=BODIES[kind][0])
        assert status(found) in (200, 400, 403, 404, 405, 422), found[:200]
    assert contents(served.folder.parent) == before


def upload_places(server: Server) -> list[str]:
    """Where a page that is open takes files, and where none does."""
    shown = asked(server, "/").decode("utf-8", "replace")
    return ["/", "/_nicegui/client/none/upload/7", *set(re.findall(r"/_nicegui/client/[0-9a-f-]+/upload/\d+", shown))]


def test_a_body_without_end_is_cut_off(served: Server) -> None:
    place = upload_places(served)[-1]
    head = f"POST {place} HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nTransfer-Encoding: chunked\r\n"
    begin = b'--x\r\nContent-Disposition: form-data; name="f"; filename="f"\r\n\r\n'
    chunk = b"100000\r\n" + b"x" * 0x100000 + b"\r\n"
    with socket.create_connection(("127.0.0.1", served.port), timeout=60) as line:
        line.sendall(head.encode() + b"Content-Type: multipart/form-data; boundary=x\r\n\r\n")
        line.sendall(f"{len(begin):x}\r\n".encode() + begin + b"\r\n")
        sent = 0
        while sent < 4 * LONGEST and not select.select([line], [], [], 0)[0]:
            try:
                line.sendall(chunk)
            except ConnectionError:  # the answer came while it was sent
                break
            sent += len(chunk)
        assert status(line.recv(1000)) == 413
    assert sent < 3 * LONGEST  # some of it is on the way when the answer comes
    assert alive(served)


@pytest.mark.parametrize(
    "sent", [b"\x16\x03\x01\x02\x00\x01\x00", b"\0" * 5000, b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\r\n" * 200]
)
def test_what_is_no_request_gets_no_page(served: Server, sent: bytes) -> None:
    assert status(answer(served, sent, patience=1.0)) in (0, 400, 403, 505)


def frame(text: bytes, kind: int = 1) -> bytes:
    """One masked frame of a web socket."""
    size = len(text)
    head = bytes([0x80 | kind]) + (bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big"))
    return head + b"\0\0\0\0" + text


def socket_with(server: Server, query: str, *frames: bytes, patience: float = 0.3, **headers: str) -> bytes:
    """What a web socket answers to these frames, so long (s) at most."""
    key = base64.b64encode(os.urandom(16)).decode()
    lines = [
        f"GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket{query} HTTP/1.1",
        f"Host: 127.0.0.1:{server.port}",
        "Upgrade: websocket",
        "Connection: Upgrade",
        f"Sec-WebSocket-Key: {key}",
        "Sec-WebSocket-Version: 13",
        *(f"{name}: {text}" for name, text in headers.items()),
    ]
    head = "\r\n".join(lines).encode() + b"\r\n\r\n"
    return answer(server, head + b"".join(frames), patience=patience)


RUBBISH = [
    b"",
    b"rubbish",
    b"4",
    b"42",
    b"42{",
    b"42[]",
    b'42["event"]',
    b'42["event",null]',
    b'42["event",{}]',
    b'42["event",{"client_id":"none","id":1,"listener_id":"x","args":[]}]',
    b'42["event",{"client_id":["a"],"id":{},"listener_id":4}]',
    b'42["handshake",{}]',
    b'42["handshake",{"client_id":"none"}]',
    b'42["ack",{"client_id":"none","next_message_id":"x"}]',
    b'42["log",{"client_id":"none","level":"rm","message":{}}]',
    b'42["javascript_response",{"request_id":5,"client_id":7}]',
    b'42["nothing",1,2,3]',
    b'451-["event"]',
    b'40/other,{"token":1}',
    b"42[" + b"[" * 3000,
    b"\xff\xfe\xfd",
]


@pytest.mark.parametrize("rubbish", RUBBISH, ids=lambda text: text[:24].decode("latin-1"))
def test_rubbish_on_the_socket_changes_nothing(served: Server, rubbish: bytes) -> None:
    before = contents(served.folder.parent)
    page = re.search(r"'client_id': '([0-9a-f-]{36})'", asked(served, "/").decode("utf-8", "replace"))
    assert page
    for query in ("", f"&client_id={page[1]}&tab_id=t&document_id=d&next_message_id=0&implicit_handshake=true"):
        socket_with(served, query, frame(b"40"), frame(rubbish))
    socket_with(served, "&client_id=none", frame(rubbish, 2))
    assert contents(served.folder.parent) == before
    assert alive(served)


def test_a_malformed_event_of_an_open_page_changes_nothing(served: Server) -> None:
    before = contents(served.folder.parent)
    shown = asked(served, "/").decode("utf-8", "replace")
    page = re.search(r"'client_id': '([0-9a-f-]{36})'", shown)
    assert page
    told = [
        {"client_id": page[1], "id": number, "listener_id": listener, "args": args}
        for number in (-1, 0, 5, 10**9, "x", None)
        for listener in ("none", None, 3)
        for args in (["{"], [5], "x", [None] * 50)
    ]
    query = f"&client_id={page[1]}&tab_id=t&document_id=d&next_message_id=0&implicit_handshake=true"
    frames = [frame(b"42" + json.dumps(["event", one]).encode()) for one in told]
    socket_with(served, query, frame(b"40"), *frames)
    assert contents(served.folder.parent) == before
    assert alive(served)


def test_a_page_of_another_site_gets_no_socket(served: Server) -> None:
    assert status(socket_with(served, "", frame(b"40"), patience=60.0, Origin="http://evil.example")) == 403


WRONG: list[Any] = [
    ("/", {}),
    ("/?token=wrong", {}),
    ("/?token=", {}),
    ("/?token=0123456789abcde", {}),
    ("/?token=0123456789abcdef0", {}),
    ("/?token=%00%ff", {}),
    ("/", {"Cookie": "autobalancer_token=wrong"}),
    ("/", {"Cookie": "autobalancer_token"}),
    ("/", {"Cookie": "=;;;=\x01"}),
    ("/", {"Cookie": "x" * 5000}),
    (f"/run/{NAME}/machine.toml", {}),
    ("/_nicegui_ws/socket.io/?EIO=4&transport=polling", {}),
    ("/_nicegui_ws/socket.io/?EIO=4&transport=websocket", {"Upgrade": "websocket"}),
]


@pytest.mark.parametrize(("path", "headers"), WRONG, ids=str)
def test_without_the_token_nothing_is_shown(guarded: Server, path: str, headers: dict[str, str]) -> None:
    found = asked(guarded, path, **headers)
    assert status(found) in (400, 401)
    assert b"Describe" not in found
    assert not list(guarded.folder.iterdir())


def test_without_the_token_there_is_no_socket(guarded: Server) -> None:
    assert status(socket_with(guarded, "", frame(b"40"), patience=60.0)) == 403


def alive(server: Server) -> bool:
    """Whether the run that was there is still answered; the page, which is dearer, is asked for at the end."""
    run = asked(server, f"/run/{NAME}/machine.toml")
    return status(run) == 200 and b"kept" in run


def test_afterwards_the_server_answers_as_before(served: Server) -> None:
    assert alive(served)
    assert status(asked(served, "/")) == 200
    assert served.process.poll() is None

"""What a browser can be made to ask the dashboard for, and what is let in."""

from __future__ import annotations

from typing import Any

import pytest
from starlette.middleware import Middleware
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pages.shared.requests_let_in import guards
from tests.unit.own_loop import awaited

LET_IN = 200


async def answering(scope: Scope, receive: Receive, send: Send) -> None:
    """Let in whatever comes this far."""
    await send({"type": f"{scope['type']}.let_in", "status": LET_IN})


def behind(guards: list[Middleware]) -> ASGIApp:
    served: ASGIApp = answering
    for guard in reversed(guards):
        served = guard.cls(served, *guard.args, **guard.kwargs)
    return served


def told(path: str, body: bytes = b"") -> tuple[dict[str, str], bytes]:
    """The headers and the content that a page is answered with."""
    said: list[Message] = []

    async def page(scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"%d" % len(body))]})
        for piece in (body[:5], body[5:]):
            await send({"type": "http.response.body", "body": piece, "more_body": piece == body[:5]})

    async def send(message: Message) -> None:
        said.append(message)

    served: ASGIApp = page
    for guard in reversed(guards(["localhost"], "inside".__eq__)):
        served = guard.cls(served, *guard.args, **guard.kwargs)
    scope: dict[str, Any] = {"type": "http", "path": path, "method": "GET", "headers": [(b"host", b"localhost")]}
    awaited(served(scope, None, send))
    headers = {name.decode().lower(): value.decode() for name, value in said[0]["headers"]}
    return headers, b"".join(message["body"] for message in said[1:])


def answers(path: str = "/", **headers: str) -> set[int]:
    """The status that a page and a session's websocket are answered with; one session may send files."""
    said: list[Message] = []

    async def send(message: Message) -> None:
        said.append(message)

    async def nothing() -> Message:
        return {"type": "http.request"}

    raw = [(name.encode(), value.encode()) for name, value in headers.items()]
    served = behind(guards(["localhost", "127.0.0.1", "::1"], "inside".__eq__))
    for kind in ("http", "websocket"):
        scope: dict[str, Any] = {"type": kind, "path": path, "method": "GET", "headers": raw, "query_string": b""}
        awaited(served(scope, nothing, send))
    return {message["status"] for message in said if "status" in message}


@pytest.mark.parametrize("host", ["localhost", "LOCALHOST:8501", "127.0.0.1:8501", "[::1]:8501"])
def test_requests_under_the_dashboards_own_names_are_let_in(host: str) -> None:
    assert answers(host=host) == answers(host=host, origin=f"http://{host}") == {LET_IN}


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8501", "localhost.evil.example", "127.0.0.1.evil.example", "[::2]", "a b"]
)
def test_a_foreign_name_that_leads_here_gets_no_page_and_no_session(host: str) -> None:
    assert answers(host=host, origin=f"http://{host}") == {400}


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:3000", "null", "", "http://[x", "file://"])
def test_a_page_of_another_origin_gets_nothing(origin: str) -> None:
    assert answers(host="127.0.0.1:8501", origin=origin) == {403}


def test_a_request_without_host_is_refused() -> None:
    assert answers() == {400}


def test_only_who_was_let_in_sends_files() -> None:
    sent = "/_stcore/upload_file/{}/1"
    assert answers(sent.format("inside"), host="localhost") == {LET_IN}
    assert answers(sent.format("outside"), host="localhost") == {LET_IN, 403}  # of the two, the page
    assert answers(sent.format(""), host="localhost") == {LET_IN, 403}


@pytest.mark.parametrize(
    ("host", "origin"),
    [("shop.example:443", "https://shop.example"), ("shop.example", "https://shop.example:443"),
     ("shop.example:80", "http://shop.example")],
)  # fmt: skip
def test_the_usual_port_of_a_scheme_is_none(host: str, origin: str) -> None:
    served = behind(guards(["shop.example"], "inside".__eq__))
    said: list[Message] = []

    async def send(message: Message) -> None:
        said.append(message)

    raw = [(b"host", host.encode()), (b"origin", origin.encode())]
    awaited(served({"type": "websocket", "path": "/", "headers": raw, "query_string": b""}, None, send))
    assert [message["status"] for message in said] == [LET_IN]
    assert answers(host="localhost:8501", origin="https://localhost") == {403}


@pytest.mark.parametrize("path", ["/", "/Job", "/_stcore/health"])
def test_no_foreign_page_shows_the_dashboard_in_a_frame(path: str) -> None:
    headers, body = told(path, b"a page in pieces")
    assert (headers["content-security-policy"], headers["x-frame-options"]) == ("frame-ancestors 'self'", "SAMEORIGIN")
    assert body == b"a page in pieces"

"""Let in what is meant for the dashboard alone, of all that a browser can be made to ask for.

A page of somebody else's can make a browser ask this server something: under a name of its own that it has led here
(DNS rebinding), or across sites. The first is known by the Host that the browser states, the second by the Origin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send


class OwnPagesAlone:
    """Refuse what a page of another origin asks for.

    Streamlit refuses it too, after it has asked a server outside for the address of this network.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] in ("http", "websocket"):
            headers = Headers(scope=scope)
            origin = headers.get("origin")
            if origin is not None and _place(origin) != headers.get("host"):
                await PlainTextResponse("Another site's page", status_code=403)(scope, receive, send)
                return
        await self.app(scope, receive, send)


class FilesOfVisitors:
    """Refuse files that are sent by a session that may not send any: Streamlit takes them from each."""

    def __init__(self, app: ASGIApp, may_send: Callable[[str], bool]) -> None:
        self.app, self.may_send = app, may_send

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            _, _, sent = scope["path"].partition("/_stcore/upload_file/")
            if sent and not self.may_send(sent.partition("/")[0]):
                await PlainTextResponse("Not signed in", status_code=403)(scope, receive, send)
                return
        await self.app(scope, receive, send)


def guards(names: Iterable[str], may_send: Callable[[str], bool]) -> list[Middleware]:
    """Return what every request passes before it reaches the dashboard.

    Parameters
    ----------
    names
        under which the dashboard answers.
    may_send
        tells of a session, by its id, whether it may send files.
    """
    hosts = [bracketed(name) for name in names]
    return [
        Middleware(TrustedHostMiddleware, allowed_hosts=hosts, www_redirect=False),
        Middleware(OwnPagesAlone),
        Middleware(FilesOfVisitors, may_send=may_send),
    ]


def bracketed(name: str) -> str:
    """Write a host as a request does: IPv6 addresses in brackets."""
    return f"[{name}]" if ":" in name else name


def _place(origin: str) -> str | None:
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None

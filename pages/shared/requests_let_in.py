"""Let in what is meant for the dashboard alone, of all that a browser can be made to ask for.

A page of somebody else's can make a browser ask this server something: under a name of its own that it has led here
(DNS rebinding), or across sites. The first is known by the Host that the browser states, the second by the Origin. Nor
may it show the dashboard in a frame of its own, where a click meant for that page would be one in the dashboard.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send


class OwnPagesAlone:
    """Refuse what a page of another origin asks for, and files of a session that may send none.

    Streamlit refuses the first too, after it has asked a server outside for the address of this network; files it takes
    from each. Pages of the dashboard alone show it in a frame; ``client.allowedOrigins`` lets none send it messages.
    """

    def __init__(self, app: ASGIApp, may_send: Callable[[str], bool]) -> None:
        self.app, self.may_send = app, may_send

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers["Content-Security-Policy"] = "frame-ancestors 'self'"
                headers["X-Frame-Options"] = "SAMEORIGIN"
            await send(message)

        why = self._refused(scope) if scope["type"] in ("http", "websocket") else ""
        await (PlainTextResponse(why, status_code=403) if why else self.app)(scope, receive, guarded)

    def _refused(self, scope: Scope) -> str:
        headers = Headers(scope=scope)
        origin = headers.get("origin")
        if origin is not None and _place(origin) != _without_usual_port(headers.get("host", ""), origin):
            return "Another site's page"
        _, _, sent = scope["path"].partition("/_stcore/upload_file/") if scope["type"] == "http" else ("", "", "")
        return "Not signed in" if sent and not self.may_send(sent.partition("/")[0]) else ""


def guards(names: Iterable[str], may_send: Callable[[str], bool]) -> list[Middleware]:
    """Return what every request passes before it reaches the dashboard."""
    hosts = [bracketed(name) for name in names]
    return [
        Middleware(TrustedHostMiddleware, allowed_hosts=hosts, www_redirect=False),
        Middleware(OwnPagesAlone, may_send=may_send),
    ]


def bracketed(name: str) -> str:
    """Write a host as a request does: IPv6 addresses in brackets."""
    return f"[{name}]" if ":" in name else name


def _place(origin: str) -> str | None:
    try:
        return _without_usual_port(urlsplit(origin).netloc, origin)
    except ValueError:
        return None


def _without_usual_port(host: str, origin: str) -> str:
    """Return a host without the port that its scheme has anyway: browsers leave it out, some proxies do not."""
    return host.removesuffix({"https": ":443", "http": ":80"}.get(origin.partition(":")[0], ""))

"""The dashboard where others reach it: who is let in, and which requests are refused."""

from __future__ import annotations

import http.client
import json
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from .conftest import end, free_port, playwright_api, started
from .provider import CLIENT, SECRET, Provider, provider

pytestmark = pytest.mark.slow
expect = playwright_api.expect
Visit = Callable[[str], playwright_api.Page]
UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def answer(server: str, path: str, **headers: str) -> int:
    """The status of the server's answer to one request."""
    connection = http.client.HTTPConnection(urlsplit(server).netloc, timeout=60)
    try:
        connection.putrequest("GET", path, skip_host=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        return connection.getresponse().status
    finally:
        connection.close()


def test_the_server_refuses_foreign_names_and_pages_of_other_origins(server: str) -> None:
    own = urlsplit(server).netloc
    stream = "/_stcore/stream"
    assert answer(server, "/", Host=own) == 200
    assert answer(server, stream, Host=own, Origin=server, **UPGRADE) == 101
    for path, headers in (("/", {}), ("/Diagnosis", {}), ("/_stcore/health", {}), (stream, UPGRADE)):
        assert answer(server, path, Host="evil.example", Origin="http://evil.example", **headers) == 400
    assert answer(server, stream, Host=own, Origin="http://evil.example", **UPGRADE) == 403
    assert answer(server, stream, Host=own, Origin="http://127.0.0.1:1", **UPGRADE) == 403


def test_no_page_outside_may_send_the_dashboard_messages(server: str) -> None:
    with urllib.request.urlopen(f"{server}/_stcore/host-config", timeout=60) as told:
        assert json.load(told)["allowedOrigins"] == []


@dataclass
class Guarded:
    """A dashboard at which people sign in, its provider, and the list of who may use it."""

    address: str
    provider: Provider
    allowed: Path


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    folder = tmp_path_factory.mktemp("guarded")
    port, allowed = free_port(), folder / "allowed.toml"
    allowed.touch(0o600)
    allowed.write_text('users = ["ana@shop.example"]\ngroups = ["bench"]\n', encoding="utf-8")
    with provider() as known:
        (folder / "secrets.toml").write_text(
            f"""[auth]
redirect_uri = "http://127.0.0.1:{port}/oauth2callback"
cookie_secret = "0123456789abcdef0123456789abcdef"
client_id = "{CLIENT}"
client_secret = "{SECRET}"
server_metadata_url = "{known.address}/.well-known/openid-configuration"
""",
            encoding="utf-8",
        )
        (folder / "secrets.toml").chmod(0o600)
        process, address = started(folder, folder, "--host", "atleak.shop.example", port=port)
        try:
            yield Guarded(address, known, allowed)
        finally:
            end(process)


def sign_in(page: playwright_api.Page, guarded: Guarded, **claims: object) -> None:
    guarded.provider.claims = claims
    page.get_by_role("button", name="Sign in").click()


def test_every_page_is_shut_until_somebody_of_the_list_signs_in(guarded: Guarded, visit: Visit) -> None:
    page = visit(f"{guarded.address}/Job_book")  # the first visit of this server, and past the bare address
    page.get_by_role("button", name="Sign in").wait_for()
    for name in ("Diagnosis", "Report", ""):
        page.goto(f"{guarded.address}/{name}")
        page.get_by_role("button", name="Sign in").wait_for()
        expect(page.get_by_text("Sample job")).to_have_count(0)
        expect(page.get_by_test_id("stFileUploader")).to_have_count(0)
        expect(page.locator(".st-key-steps")).to_have_count(0)
    sign_in(page, guarded, email="ana@shop.example", email_verified=True)
    page.get_by_text("Signed in: ana@shop.example").wait_for()
    page.goto(f"{guarded.address}/Diagnosis")
    page.get_by_text("Sample job: made-up data").wait_for()
    page.get_by_role("button", name="Sign out").click()
    page.get_by_role("button", name="Sign in").wait_for()
    expect(page.get_by_text("Sample job")).to_have_count(0)


def test_who_is_signed_in_and_not_on_the_list_is_told_so_until_he_is(guarded: Guarded, visit: Visit) -> None:
    page = visit(guarded.address)
    sign_in(page, guarded, email="ben@shop.example", groups=["office"])
    page.get_by_text("ben@shop.example may not use this dashboard").wait_for()
    page.get_by_role("button", name="Sign out").wait_for()
    expect(page.get_by_test_id("stFileUploader")).to_have_count(0)
    before = guarded.allowed.read_text(encoding="utf-8")
    try:
        guarded.allowed.write_text('groups = ["office"]\n', encoding="utf-8")
        page.goto(f"{guarded.address}/Diagnosis")
        page.get_by_text("Sample job: made-up data").wait_for()
        guarded.allowed.write_text("groups = []\n", encoding="utf-8")
        page.goto(f"{guarded.address}/Diagnosis")
        page.get_by_text("Nobody can come in: allowed.toml: allows nobody").wait_for()
    finally:
        guarded.allowed.write_text(before, encoding="utf-8")

"""Who may use the dashboard, and with whom these people sign in."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from atleak.common.access import answered_names, is_here_alone
from atleak.common.errors import InputError
from atleak.common.sign_in import Allowed, read_allowed, read_sign_in

SECRETS = """[auth]
redirect_uri = "https://atleak.shop.example/oauth2callback"
cookie_secret = "0123456789abcdef0123456789abcdef"
client_id = "atleak"
client_secret = "secret"
server_metadata_url = "https://id.example/.well-known/openid-configuration"
"""
SHOP = Allowed(users=["ana@shop.example"], groups=["bench"])


def secrets_of(folder: Path, text: str = SECRETS) -> Path:
    """A file of secrets that its owner alone can read."""
    path = folder / "secrets.toml"
    path.write_text(text, encoding="utf-8")
    path.chmod(0o600)
    return path


@pytest.mark.parametrize(
    "claims",
    [
        {"email": "ana@shop.example"},
        {"email": "Ana@Shop.example", "email_verified": True},
        {"email": "other@shop.example", "groups": ["office", "bench"]},
        {"groups": "bench"},
    ],
)
def test_people_of_the_list_and_of_its_groups_come_in(claims: dict[str, object]) -> None:
    assert SHOP.admits(claims)


@pytest.mark.parametrize(
    "claims",
    [
        {},
        {"email": "other@shop.example"},
        {"email": "ana@shop.example", "email_verified": False},
        {"email": "ana@shop.example", "email_verified": "false"},
        {"email": ["ana@shop.example"]},
        {"preferred_username": "ana@shop.example"},
        {"groups": ["Bench", "bench2"]},
        {"groups": {"bench": True}},
        {"groups": [["bench"]]},
        {"email": "", "groups": ""},
    ],
)
def test_nobody_else_comes_in(claims: dict[str, object]) -> None:
    assert not SHOP.admits(claims)


def test_the_file_may_name_the_claims_of_its_provider() -> None:
    allowed = Allowed(users=["ana"], groups=["bench"], user_claim="preferred_username", group_claim="roles")
    assert allowed.admits({"preferred_username": "ana", "email_verified": False})
    assert allowed.admits({"roles": ["bench"]})
    assert not allowed.admits({"email": "ana", "groups": ["bench"]})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "allows nobody to use the dashboard"),
        ('users = [" "]\ngroups = []', "allows nobody to use the dashboard"),
        ('users = "ana@shop.example"', "a list in square brackets"),
        ('user = ["ana@shop.example"]', "did you mean 'users'?"),
        ("users = [", "is not valid TOML"),
    ],
)
def test_a_list_that_says_nobody_or_something_else_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "allowed.toml"
    path.write_text(text, encoding="utf-8")
    path.chmod(0o600)
    with pytest.raises(InputError, match=r"allowed\.toml") as refused:
        read_allowed(path)
    assert said in str(refused.value)


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
@pytest.mark.parametrize("mode", [0o644, 0o620, 0o606])
def test_a_list_that_others_can_read_or_change_is_refused(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "allowed.toml"
    path.write_text('users = ["ana@shop.example"]', encoding="utf-8")
    path.chmod(mode)
    with pytest.raises(InputError, match=r"others on this machine can read or change it; expected .*chmod 600 allowed"):
        read_allowed(path)
    path.chmod(0o600)
    assert read_allowed(path).users == ["ana@shop.example"]


def test_a_list_is_read_as_it_is_now(tmp_path: Path) -> None:
    path = tmp_path / "allowed.toml"
    path.touch(0o600)
    for name in ("ana@shop.example", "ben@shop.example"):
        path.write_text(f'users = ["{name}"]', encoding="utf-8")
        assert read_allowed(path).admits({"email": name})
    path.unlink()
    with pytest.raises(InputError, match="cannot be read: No such file or directory"):
        read_allowed(path)


def test_the_secrets_say_where_people_come_back_to(tmp_path: Path) -> None:
    path = secrets_of(tmp_path)
    assert read_sign_in(path) == "atleak.shop.example"


@pytest.mark.parametrize("key", [line.partition(" ")[0] for line in SECRETS.splitlines()[1:]])
def test_a_key_that_signing_in_needs_is_named(tmp_path: Path, key: str) -> None:
    path = secrets_of(tmp_path, "".join(line for line in SECRETS.splitlines(True) if not line.startswith(key)))
    with pytest.raises(InputError, match=f"secrets.toml.*{key}.*required key is missing"):
        read_sign_in(path)


@pytest.mark.parametrize(
    "address", ["https://atleak.shop.example/", "atleak.shop.example/oauth2callback", "https://[x"]
)
def test_an_address_to_which_nobody_comes_back_is_refused(tmp_path: Path, address: str) -> None:
    path = secrets_of(tmp_path, SECRETS.replace("https://atleak.shop.example/oauth2callback", address))
    with pytest.raises(InputError, match="people cannot come back there"):
        read_sign_in(path)


@pytest.mark.parametrize("secret", ["…", "x", "", " " * 40, "a" * 31])
def test_the_placeholder_of_the_document_is_no_secret(tmp_path: Path, secret: str) -> None:
    path = secrets_of(tmp_path, SECRETS.replace("0123456789abcdef0123456789abcdef", secret))
    with pytest.raises(InputError, match=r"key 'cookie_secret': too short.*at least 32 characters.*token_urlsafe"):
        read_sign_in(path)


@pytest.mark.skipif(os.name != "posix", reason="who may read a file is told otherwise there")
@pytest.mark.parametrize("mode", [0o644, 0o640, 0o602])
def test_secrets_that_others_can_read_or_change_are_refused(tmp_path: Path, mode: int) -> None:
    path = secrets_of(tmp_path)
    path.chmod(mode)
    with pytest.raises(
        InputError, match=r"others on this machine can read or change it; expected .*chmod 600 secrets\.toml"
    ):
        read_sign_in(path)


@pytest.mark.parametrize("blank", ["", " "])
def test_a_blank_name_on_the_list_lets_nobody_in(blank: str) -> None:
    allowed = Allowed(users=[blank, "ana@shop.example"], groups=[blank, "bench"])
    assert not allowed.admits({"email": blank})
    assert not allowed.admits({"groups": blank})
    assert allowed.admits({"email": "ana@shop.example"})
    assert allowed.admits({"groups": "bench"})


def test_what_is_missing_is_told_with_both_files_and_where_they_are_explained(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"secrets\.toml.*allowed\.toml.*docs/network\.md.*--without-login"):
        read_sign_in(tmp_path / "secrets.toml")
    with pytest.raises(InputError, match=r"allowed\.toml.*docs/network\.md"):
        read_allowed(tmp_path / "allowed.toml")


OF_MACHINE = ("127.0.0.1", "192.168.1.5", "fe80::1%eth0")


@pytest.mark.parametrize("name", ["localhost", "LOCALHOST", "127.0.0.1", "127.0.0.2", "::1"])
def test_names_of_this_machine_alone(name: str) -> None:
    assert is_here_alone(name)


@pytest.mark.parametrize("name", ["0.0.0.0", "::", "192.168.1.5", "shop.example", "localhost.example", ""])
def test_every_other_name_may_lead_others_here(name: str) -> None:
    assert not is_here_alone(name)


def test_a_dashboard_of_every_interface_answers_under_each_of_its_addresses_and_its_name() -> None:
    names = answered_names("0.0.0.0", OF_MACHINE, [])
    assert {"192.168.1.5", "fe80::1", "localhost", "127.0.0.1", "::1"} < set(names)
    assert names[0] == socket.gethostname().casefold()
    assert "0.0.0.0" not in names
    assert "shop.example" not in names


def test_a_dashboard_of_one_address_answers_there_and_under_names_that_were_given() -> None:
    names = answered_names("192.168.1.5", ("127.0.0.1", "192.168.1.5", "10.0.0.2"), ["Shop.example"])
    assert names[:2] == ("shop.example", "192.168.1.5")
    assert "10.0.0.2" not in names

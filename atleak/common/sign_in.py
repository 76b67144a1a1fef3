"""Read who may use the dashboard where other machines reach it, and with whom people sign in."""

from __future__ import annotations

import os
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, field_validator

from atleak.common.errors import InputError, Place, reason_of, text_reason
from atleak.common.file_faults import validated
from atleak.common.sentences import Sentence

CALLBACK = "/oauth2callback"  # where Streamlit takes people back who have signed in
_DOCUMENT = "docs/network.md"  # says what stands in both files
_EMAIL = "email"
_SECRET_LENGTH = 32  # characters of the secret with which cookies are signed: a shorter one is guessed or a placeholder
_SHARED = stat.S_IRGRP | stat.S_IWGRP | stat.S_IROTH | stat.S_IWOTH


class Allowed(BaseModel):
    """Who may use the dashboard: people by what the provider calls them, and groups.

    ``user_claim`` and ``group_claim`` name the entries of the identity token in which it does.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    users: list[str] = []
    groups: list[str] = []
    user_claim: str = _EMAIL
    group_claim: str = "groups"

    @field_validator("users", "groups")
    @classmethod
    def _without_blanks(cls, names: list[str]) -> list[str]:
        """Return the names alone: a blank one would let in whoever the provider has no name for."""
        return [name for name in names if name.strip()]

    def admits(self, claims: Mapping[str, Any]) -> bool:
        """Tell whether somebody with these claims may come in; capitals from A to Z count in groups, not in users.

        >>> Allowed(users=["ana@shop.example"]).admits({"email": "Ana@shop.example"})
        True

        A sign that only looks alike belongs to somebody else's address:

        >>> Allowed(users=["ana@shop.example"]).admits({"email": "ana@\u017fhop.example"})
        False

        An address that the provider itself has not confirmed is nobody's:

        >>> Allowed(users=["ana@shop.example"]).admits({"email": "ana@shop.example", "email_verified": False})
        False
        """
        user = claims.get(self.user_claim)
        confirmed = self.user_claim != _EMAIL or claims.get("email_verified", True) in (True, "true")
        if isinstance(user, str) and confirmed and _folded(user) in map(_folded, self.users):
            return True
        groups = claims.get(self.group_claim)
        groups = [groups] if isinstance(groups, str) else groups if isinstance(groups, list) else []
        return any(group in self.groups for group in groups)


def _folded(name: str) -> str:
    """Return a name with its letters from A to Z small, and every other sign as it is."""
    return "".join(sign.lower() if sign.isascii() else sign for sign in name)


class _Provider(BaseModel):
    """What Streamlit needs to know of the provider with which people sign in."""

    redirect_uri: str
    cookie_secret: str
    client_id: str
    client_secret: str
    server_metadata_url: str


class _Secrets(BaseModel):
    auth: _Provider


def read_allowed(path: Path) -> Allowed:
    """Read the file of who may use the dashboard.

    Raises
    ------
    InputError
        where it cannot be read, or can be by others on this machine, says something else, or names nobody.
    """
    expected = Sentence("a file of who may use the dashboard: see {document}", document=_DOCUMENT)
    allowed = validated(Allowed, _tables(path, expected), path.name)
    _check_own(path)
    if not (allowed.users or allowed.groups):
        expected = Sentence("somebody under users, or a group under groups")
        raise InputError(Sentence("allows nobody to use the dashboard"), place=Place(file=str(path)), expected=expected)
    return allowed


def read_sign_in(path: Path) -> str:
    """Check the file of secrets with which people sign in; return the name of the dashboard that they come back to.

    Raises
    ------
    InputError
        where it cannot be read, or can be by others on this machine, where a key is missing that signing in needs, or
        the secret that signs cookies is a short one.
    """
    expected = Sentence(
        "a file of secrets that says with whom people sign in, and allowed.toml that says who may come in "
        "(see {document}), or --without-login",
        document=_DOCUMENT,
    )
    provider = validated(_Secrets, _tables(path, expected), path.name).auth
    _check_own(path)
    _check_secret(provider.cookie_secret, path)
    address = provider.redirect_uri
    try:
        parts = urlsplit(address)
        name = parts.hostname if parts.scheme in ("http", "https") and parts.path.endswith(CALLBACK) else None
    except ValueError:
        name = None
    if name is None:
        place = Place(file=str(path), table="auth", key="redirect_uri")
        expected = Sentence("the address of the dashboard, such as https://atleak.shop.example/oauth2callback")
        raise InputError(Sentence("people cannot come back there"), place=place, value=address, expected=expected)
    return name


def _check_own(path: Path) -> None:
    """Refuse a file that others on this machine can read or change, where the system tells: it lets people in."""
    if os.name == "posix" and path.stat().st_mode & _SHARED:
        expected = Sentence("one for its owner alone: {command}", command=f"chmod 600 {path.name}")
        raise InputError(
            Sentence("others on this machine can read or change it"), place=Place(file=str(path)), expected=expected
        )


def _check_secret(secret: str, path: Path) -> None:
    if len(secret.strip()) < _SECRET_LENGTH:
        expected = Sentence(
            "at least {count} characters that nobody can guess, as this prints: {command}",
            count=_SECRET_LENGTH,
            command='python -c "import secrets; print(secrets.token_urlsafe(32))"',
        )
        place = Place(file=str(path), table="auth", key="cookie_secret")
        raise InputError(Sentence("too short: who guesses it is anybody"), place=place, expected=expected)


def _tables(path: Path, expected: Sentence) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise InputError(problem, place=Place(file=str(path)), expected=expected) from error
    except (ValueError, RecursionError) as error:
        problem = Sentence("is not valid TOML: {reason}", reason=text_reason(error))
        raise InputError(problem, place=Place(file=str(path)), expected=expected) from error

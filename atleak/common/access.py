"""Name the addresses at which the dashboard answers, and tell which of them other machines reach."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Collection

ALLOWED = "ATLEAK_ALLOWED"
"""The variable of the environment by which the server knows the file of who may use it; empty where nobody signs in."""

ENDS_AFTER = "ATLEAK_ENDS_AFTER"
"""The variable of the environment that says after how many seconds without a connected page the server ends."""


def is_here_alone(name: str) -> bool:
    """Tell whether a name or address of this machine reaches no other one.

    >>> [is_here_alone(name) for name in ("localhost", "127.0.0.1", "::1", "0.0.0.0", "192.168.1.5", "shop.example")]
    [True, True, True, False, False, False]
    """
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return name.casefold() == "localhost"


def answered_names(address: str, addresses: Collection[str], named: Collection[str]) -> tuple[str, ...]:
    """Return the names under which the dashboard answers when it serves an address; the first is what people type.

    Parameters
    ----------
    address
        that is served; an address of every interface serves all of them.
    named
        further names, such as that of a proxy.

    >>> answered_names("192.168.1.5", ["127.0.0.1", "192.168.1.5", "10.0.0.2"], ["shop.example"])[:2]
    ('shop.example', '192.168.1.5')
    """
    every = address in ("0.0.0.0", "::")
    own = [each.partition("%")[0] for each in addresses] if every else [address]
    host = socket.gethostname()
    names = (*named, *([] if every else own), host, f"{host}.local", *own, "localhost", "127.0.0.1", "::1")
    return tuple(dict.fromkeys(name.casefold() for name in names))

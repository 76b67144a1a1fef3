"""Turn a message into the record that scripts rely on."""

from __future__ import annotations

from typing import Any

from atleak.errors import Message


def message_record(message: Message) -> dict[str, Any]:
    """Return a message, with its place where it has one."""
    record: dict[str, Any] = {"level": message.level, "code": message.code, "text": message.text}
    if message.place is not None:
        record["place"] = message.place.known or None
    return record

"""What may reach a terminal, and what an odd standard stream does to a command."""

from __future__ import annotations

import io
import logging
import sys
import tomllib
import traceback
from pathlib import Path

import pytest

from atleak.common.printable import PrintableStream, printable, printable_log, printable_streams, unguarded


def test_every_control_character_but_line_ends_and_tabs_is_left_out() -> None:
    everything = "".join(map(chr, (*range(0x100), 0x141, 0x1F527)))
    kept = printable(everything)
    assert set(everything) - set(kept) == {chr(code) for code in (*range(0x20), *range(0x7F, 0xA0))} - {"\n", "\t"}
    assert kept == "".join(sign for sign in everything if sign in kept)


def test_a_stream_is_what_it_stands_for_in_all_but_writing() -> None:
    target = io.StringIO()
    stream = PrintableStream(target)
    assert stream.write("a\x1b[0m") == 5
    stream.writelines(["b\x07", "c"])
    assert (target.getvalue(), stream.getvalue()) == ("a[0mbc", "a[0mbc")
    assert unguarded(stream) is target
    assert unguarded(target) is target


def _say_and_fail() -> None:
    with printable_streams():
        print("\x1bhere")
        print("nowhere", file=sys.stderr)
        sys.stderr.flush()
        raise RuntimeError


def test_standard_streams_are_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setattr(sys, "stderr", None)
    with pytest.raises(RuntimeError):
        _say_and_fail()
    assert sys.stdout is stream
    assert sys.stderr is None
    assert stream.getvalue() == "here\n"


def test_what_a_server_logs_holds_no_control_character(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal, elsewhere = io.StringIO(), io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    logger = logging.getLogger("atleak.test_printable")
    monkeypatch.setattr(logger, "handlers", [logging.StreamHandler(), logging.StreamHandler(elsewhere)])
    printable_log()
    printable_log()
    try:
        raise ValueError("log \x1b]0;renamed\x07 \x9b2J.csv: is damaged")
    except ValueError as error:
        logger.exception("Uncaught app execution")
        traceback.print_exception(error)
    assert terminal.getvalue().count("ValueError: log ]0;renamed 2J.csv: is damaged") == 2
    assert not set(terminal.getvalue()) & set("\x1b\x07\x9b")
    assert "\x1b" in elsewhere.getvalue(), "a file is no terminal"


def test_the_server_logs_tracebacks_without_colours_of_its_own() -> None:
    config = Path(__file__).resolve().parents[3] / ".streamlit" / "config.toml"
    assert tomllib.loads(config.read_text(encoding="utf-8"))["logger"] == {"enableRich": False}

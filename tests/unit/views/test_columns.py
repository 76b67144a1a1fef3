"""Columns of tables: their words and units follow the reader, their cells stay numbers."""

from __future__ import annotations

import pytest

from atleak.verdicts import Verdict
from atleak.views.columns import Column
from atleak.wording import languages, wording


@pytest.mark.parametrize(
    ("language", "units", "heading"),
    [("en", "metric", "Clearance [µm]"), ("de", "metric", "Spiel [µm]"), ("pl", "us", "Luz [0.0001 in]")],
)
def test_a_heading_has_the_readers_words_and_unit(language: str, units: str, heading: str) -> None:
    assert Column("clearance", "clearance").heading(wording(language, units)) == heading


def test_a_cell_is_a_number_in_the_readers_unit_rounded_as_it_is_written() -> None:
    pressure, say = Column("held", "pressure", digits=0), wording("de", "us")
    value = pressure.value(1000.0, say)
    assert (value, pressure.written(value, say)) == (145.0, "145,0")
    assert pressure.value(None, say) is None
    assert pressure.written(None, say) == "–"


def test_words_and_verdicts_stay_as_they_are() -> None:
    say = wording("pl", "us")
    assert Column("source").value("CMM, 0.5 mm", say) == "CMM, 0.5 mm"
    assert Column("verdict", "verdict").value(Verdict.OK, say) is Verdict.OK
    assert Column("verdict", "verdict").heading(say) == "Ocena"


def test_only_a_column_that_needs_it_says_what_it_means() -> None:
    for language in languages():
        assert Column("wear", "percent").help(wording(language)) is not None
        assert Column("source").help(wording(language)) is None

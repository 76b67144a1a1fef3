"""What the program says: a sentence keeps its wording, and every language says every one of them."""

from __future__ import annotations

import ast
import copy
import datetime as dt
import pickle
from collections.abc import Iterator

from atleak.common.errors import InputError, Place, one_of
from atleak.common.sentences import Name, Sentence, counted
from atleak.common.units import Quantity
from atleak.common.wording import wording
from tests.unit.product_code import nodes


def _sentences() -> Iterator[tuple[str, ast.expr]]:
    for path, found in nodes().items():
        for node in found:
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Sentence":
                yield f"{path}:{node.lineno}:{node.col_offset}", node.args[0]


def test_a_sentence_is_a_text_that_keeps_its_wording() -> None:
    said = Sentence(
        "{land}: {width} {width.unit} of {planes}",
        land="25/1",
        width=Quantity(3.06, "clearance", 1),
        planes=("I", "II"),
    )
    assert said == "25/1: 3.1 µm of I, II"
    for again in (pickle.loads(pickle.dumps(said)), copy.deepcopy(said)):
        assert (again, again.template, again.values) == (said, said.template, said.values)
    assert Sentence("{braces} stand as they are") == "{braces} stand as they are"
    quoted = Sentence("found {value!r}", value=["a", "b"])
    assert (quoted, wording("de", "us").sentence(quoted)) == ("found ['a', 'b']", "found ['a', 'b']")


def test_values_are_written_in_the_reader_s_language_and_units() -> None:
    inner = Sentence("{width} {width.unit}, {width:g}, {width:.2f}", width=Quantity(-59.5, "clearance", 1))
    said = Sentence(
        "{inner}; {number:,.1f}; {name}; {found!r}",
        inner=inner,
        number=12345.67,
        name=Name("manual valve"),
        found="1.5",
    )
    assert said == "-59.5 µm, -59.5, -59.50; 12,345.7; manual valve; '1.5'"
    assert wording("de").sentence(said) == "−59,5 µm, −59,5, −59,50; 12\u00a0345,7; Wählschieber; '1.5'"
    assert wording("en", "us").sentence(inner) == "−0.00234 in, −0.00234, −0.002343"
    assert wording("de").sentence("any other text 1.5") == "any other text 1.5"


def test_an_error_is_said_with_its_place_and_what_was_expected() -> None:
    wrong = InputError(
        Sentence("no such system of units"),
        place=Place(file="a.toml", row=3),
        value="usa",
        expected=one_of(["us"]),
        nearest="us",
    )
    assert str(wrong) == "a.toml, row 3: no such system of units (found 'usa'); expected one of us; did you mean 'us'?"
    assert str(wrong) == wrong.sentence
    german = wording("de").sentence(wrong.sentence)
    assert german.startswith("a.toml, Zeile 3: ")
    assert "'usa'" in german
    assert not {"row", "expected", "found"} & set(german.split())


def test_a_date_that_was_found_is_written_as_people_write_it() -> None:
    assert str(InputError(Sentence("no day"), value=dt.date(2026, 1, 2))) == "no day (found '2026-01-02')"


def test_every_sentence_is_worded_in_the_code() -> None:
    """One that is put together before it becomes a sentence could be said in no other language."""
    assert [place for place, node in _sentences() if not isinstance(node, ast.Constant)] == []


def test_a_language_has_plural_forms_of_its_own() -> None:
    said = [counted(count, "{count} row", "{count} rows") for count in (1, 2, 5, 22)]
    assert said == ["1 row", "2 rows", "5 rows", "22 rows"]
    assert wording("de").sentence(pickle.loads(pickle.dumps(said[1]))) == "2 Zeilen"
    assert [wording("pl").sentence(each) for each in said] == ["1 wiersz", "2 wiersze", "5 wierszy", "22 wiersze"]
    assert [wording("pl")("fleet.units", count=count) for count in (1, 4, 1234)] == [
        "1 egzemplarz", "4 egzemplarze", "1\u00a0234 egzemplarze",
    ]  # fmt: skip

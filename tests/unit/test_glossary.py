"""Translations use the words of the trade, one for each thing, as `docs/glossary.toml` has them."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from typing import Any

import pytest
from babel.messages.pofile import read_po

from atleak.common.translations import languages, source
from tests.unit.product_code import ROOT

GLOSSARY = tomllib.loads((ROOT / "docs/glossary.toml").read_text(encoding="utf-8"))
TERMS: list[dict[str, Any]] = GLOSSARY["term"]
OTHERWISE: list[dict[str, Any]] = GLOSSARY.get("otherwise", [])
TRANSLATED = [each for each in languages() if any(each in term for term in TERMS)]
NOT_FOUND = "usage in the trade, no document found"


@cache
def pairs(language: str) -> list[tuple[str, str]]:
    """Every English text with its translation, in each of its forms."""
    with source(language).open("rb") as file:
        texts = [(message.id, message.string) for message in read_po(file, language) if message.id]
    counted = [(english, said) for english, said in texts if isinstance(english, tuple)]
    plural = [(one, forms[0]) for (one, _), forms in counted] + [
        (more, f) for (_, more), forms in counted for f in forms[1:]
    ]
    return [(english, said) for english, said in texts if isinstance(english, str)] + plural


def has_term(english: str, term: str) -> bool:
    """Whether a text has a term as a whole word: names at its places, what is typed, file names and a maker aside."""
    words = re.sub(r"\{[^}]*\}|`[^`]*`|'value [^']*'|=spool|Land Rover", "", english)
    return re.search(rf"(?<![\w-]){term}(s|'s)?(?![\w-]|\.\w)", words, re.IGNORECASE) is not None


@pytest.mark.parametrize("language", TRANSLATED)
def test_no_word_is_used_that_the_glossary_calls_wrong(language: str) -> None:
    wrong = [(term["english"], word) for term in TERMS for word in term.get(f"not_{language}", ())]
    assert [(term, word, said) for _, said in pairs(language) for term, word in wrong if re.search(word, said)] == []


@pytest.mark.parametrize("language", TRANSLATED)
def test_a_term_is_translated_by_its_word(language: str) -> None:
    free = {(text, each["term"]) for each in OTHERWISE for text in each["texts"]}
    checked = [(term["english"], term[f"{language}_stem"]) for term in TERMS if f"{language}_stem" in term]
    assert [
        (term, english, said)
        for english, said in pairs(language)
        for term, stem in checked
        if has_term(english, term) and not re.search(stem, said) and (english, term) not in free
    ] == []


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term["english"])
def test_a_term_says_what_it_means_and_where_its_words_are_from(term: dict[str, Any]) -> None:
    assert term["meaning"]
    for language in TRANSLATED:
        assert term[language]
        assert term[f"source_{language}"]
        stem = term.get(f"{language}_stem")
        assert stem is None or re.search(stem, term[language])


def test_what_is_translated_otherwise_is_still_a_text() -> None:
    known = {english for language in TRANSLATED for english, _ in pairs(language)}
    assert [text for each in OTHERWISE for text in each["texts"] if text not in known] == []
    assert {each["term"] for each in OTHERWISE} <= {term["english"] for term in TERMS}
    assert all(each["reason"] for each in OTHERWISE)

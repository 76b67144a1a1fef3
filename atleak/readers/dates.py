"""Reads names as plain words, and dates, in the languages that people and loggers write."""

from __future__ import annotations

import datetime as dt
import re
import tomllib
import unicodedata
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from importlib import resources
from typing import Any, Literal

_TRANSLATE = str.maketrans(
    {"ß": "ss", "ä": "ae", "ö": "oe", "ü": "ue", "ł": "l", "ø": "o", "æ": "ae", "№": "no", "đ": "d"}
)
_CAMEL = re.compile(r"(?<=[a-zа-яё])(?=[A-ZА-ЯЁ])|(?<=[A-Z])(?=[A-Z][a-z]{2})")
# digits between letters are kept with them: "n2", "o2"
_SEPARATORS = re.compile(r"[^0-9a-zа-яёͰ-Ͽ一-鿿]+")


@cache
def vocabulary(package: str, file: str) -> Mapping[str, Mapping[str, Any]]:
    """Return the words that stand in a TOML file of a package."""
    return tomllib.loads(resources.files(package).joinpath(file).read_text(encoding="utf-8"))


@lru_cache(maxsize=8192)
def words(name: str) -> str:
    """Return a name in lower-case words separated by one blank; umlauts written out, accents dropped, Cyrillic kept.

    >>> words("Getriebeöltemperatur"), words("VehicleSpeed"), words("P/L Solenoid_Valve-Pressure")
    ('getriebeoeltemperatur', 'vehicle speed', 'p l solenoid valve pressure')
    """
    text = unicodedata.normalize("NFKC", name)
    text = _CAMEL.sub(" ", text).lower().translate(_TRANSLATE)
    text = unicodedata.normalize("NFKD", text)
    # й and ё stay letters of their own
    text = "".join(sign for sign in text if not unicodedata.combining(sign) or sign in "\u0306\u0308")
    return _SEPARATORS.sub(" ", unicodedata.normalize("NFKC", text)).strip()


DateOrder = Literal["dmy", "mdy"]

# English, German, French, Polish, Portuguese, Spanish, Italian, Russian; compared by the first letters
_MONTHS: tuple[tuple[str, ...], ...] = (
    ("jan", "janv", "sty", "ene", "gen", "янв"),
    ("feb", "fev", "fevr", "lut", "фев"),
    ("mar", "maer", "mrz", "mars", "marz", "мар"),
    ("apr", "avr", "kwi", "abr", "апр"),
    ("may", "mai", "maj", "mag", "май", "мая", "maio", "mayo"),
    ("jun", "juin", "cze", "giu", "июн"),
    ("jul", "juil", "lip", "lug", "июл"),
    ("aug", "aout", "sie", "ago", "авг"),
    ("sep", "sept", "wrz", "set", "сен"),
    ("oct", "okt", "paz", "out", "ott", "окт"),
    ("nov", "lis", "ноя"),
    ("dec", "dez", "gru", "dic", "дек"),
)
_HALF = re.compile(r"(?<![a-z])([ap])\.?\s?m\b\.?", re.IGNORECASE)


def half_day(text: str) -> str | None:
    """Return ``am`` or ``pm`` where the text says so, else None.

    >>> half_day("05/05/2023  PM"), half_day("28.01.2016 ")
    ('pm', None)
    """
    match = _HALF.search(text)
    return f"{match[1].lower()}m" if match else None


@lru_cache(maxsize=2048)
def month(name: str) -> int | None:
    """Return a month's number from its name, full or short, with or without a dot.

    >>> month("oct."), month("März"), month("Tue")
    (10, 3, None)
    """
    text = words(name)
    if len(text) < 3 or text in {"mardi", "mar dim", "martes", "martedi"}:  # "mar" is March, but these are days
        return None
    fit = [
        (len(start), -number)
        for number, starts in enumerate(_MONTHS, start=1)
        for start in starts
        if text.startswith(start)
    ]
    return -max(fit)[1] if fit else None


def likely_order(dates: Sequence[str], halves: Sequence[str | None]) -> DateOrder:
    """Decide whether slashed dates put the day or the month first: by a number over 12, else by AM and PM."""
    for text in dates:
        match = re.search(r"(?<!\d)(\d{1,2})[/.\-](\d{1,2})[/.\-]\d{2,4}", text)
        if match and int(match[1]) > 12:
            return "dmy"
        if match and int(match[2]) > 12:
            return "mdy"
    return "mdy" if any(halves) else "dmy"


@lru_cache(maxsize=4096)
def day_number(text: str, order: DateOrder = "dmy") -> int | None:
    """Return the day's ordinal, or None where the text holds no date.

    >>> day_number("27-Sep-2014") - day_number("2014-09-26"), day_number("28-oct.-2021") - day_number("20211027")
    (1, 1)
    >>> day_number("Tue Aug 21  MESZ 2012") == day_number("21.08.2012"), day_number(" PM")
    (True, None)
    """
    with suppress(ValueError):
        return _day(_HALF.sub(" ", text), order)
    return None


def sure_date(texts: Sequence[str]) -> dt.date | None:
    """Return the earliest of some dates written alike.

    None where one of them is none or lacks its year, or where day and month may be swapped.

    >>> sure_date(["2026-03-04"]), sure_date(["4.3.2026"]), sure_date(["03/04/2026"])
    (datetime.date(2026, 3, 4), datetime.date(2026, 3, 4), None)
    >>> sure_date(["03/04/2026", "03/14/2026"])
    datetime.date(2026, 3, 4)
    """
    if any(len(re.findall(r"\d+", text)) < 2 and not re.search(r"\d{8}", text) for text in texts):
        return None  # "27 Sep"
    dotted = any(re.search(r"(?<!\d)\d{1,2}\.\d{1,2}\.\d{2}", text) for text in texts)  # the day stands first
    orders: tuple[DateOrder, ...] = ("dmy",) if dotted else ("dmy", "mdy")
    read = [[day_number(text, order) for text in texts] for order in orders]
    first = {
        min(days) for each in read if (days := [day for day in each if day is not None]) and len(days) == len(each)
    }
    return dt.date.fromordinal(first.pop()) if len(first) == 1 else None


def _day(text: str, order: DateOrder) -> int | None:
    for iso in (r"(\d{4})[/.\-](\d{1,2})[/.\-](\d{1,2})", r"((?:19|20)\d{2})(\d{2})(\d{2})"):
        if match := re.search(rf"(?<!\d){iso}(?!\d)", text):
            return dt.date(int(match[1]), int(match[2]), int(match[3])).toordinal()
    if match := re.search(r"(?<!\d)(\d{1,2})[/.\-](\d{1,2})[/.\-](\d{4}|\d{2})(?!\d)", text):
        first, second, year = int(match[1]), int(match[2]), int(match[3])
        year += 2000 if year < 100 else 0
        day, number = (first, second) if order == "dmy" else (second, first)
        return dt.date(year, number, day).toordinal()
    months = [each for each in map(month, re.findall(r"[^\W\d_]{3,}\.?", text)) if each]
    digits = re.findall(r"\d+", text)
    years = [int(piece) for piece in digits if len(piece) == 4]
    days = [int(piece) for piece in digits if len(piece) <= 2]
    if not months or not days:
        return None
    if not years and len(days) >= 2:
        years, days = [2000 + days[-1]], days[:-1]
    # the last month name counts: a weekday ("Mar" in French, Tuesday) stands before it
    return dt.date(years[0] if years else 2000, months[-1], days[0]).toordinal()

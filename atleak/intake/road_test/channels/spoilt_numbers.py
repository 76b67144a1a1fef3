"""Says why the cells of a column are no numbers: thousands parted by a sign, another decimal sign, several units."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from atleak.intake.road_test.files.cells import Decimal, is_destroyed, kind_of, unit_behind
from atleak.sentence import Sentence

TEXT = Sentence("text instead of numbers")
_LONGEST_QUOTE = 40  # characters of a cell that a message shows
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?P<sign>[.,'’\u00a0\u202f ])\d{3}(?:(?P=sign)\d{3})*(?P<rest>[.,]\d*)?\Z")
_OTHER: dict[Decimal, Decimal] = {".": ",", ",": "."}


def quoted(cell: object) -> str:
    """Return a cell as a message shows it: cut where it is long.

    >>> quoted(" 1.#INF"), quoted("9" * 5000)[-3:]
    ('1.#INF', '99…')
    """
    text = str(cell).strip()
    return text if len(text) <= _LONGEST_QUOTE else text[:_LONGEST_QUOTE] + "…"


def holds(column: str, what: Sentence, found: str) -> Sentence:
    """Return the sentence that a column is not used, and for which cells."""
    return Sentence("{column!r} holds {what} ({found}): it is not used", column=column, what=what, found=found)


def cause(cells: pd.Series, values: np.ndarray, decimal: Decimal) -> tuple[Sentence, str]:
    """Return what is wrong with cells that are no numbers, and one of them.

    ``values`` are the column's numbers, NaN where there is none.
    """
    few = [str(cell).strip() for cell in (*cells.head(200), *cells.tail(50))]
    destroyed = next(filter(is_destroyed, few), None)
    if destroyed is not None:
        return Sentence("numbers a spreadsheet has destroyed"), destroyed
    units = {unit: text for text in few if (unit := unit_behind(text))}
    if len(units) > 1:
        return Sentence("numbers in several units"), ", ".join(map(quoted, list(units.values())[:2]))
    numbers = [match for text in few if (match := _THOUSANDS.match(text))]
    if 2 * len(numbers) > len(few):
        sign, shown = numbers[0]["sign"], quoted(numbers[0][0])
        known = values[np.isfinite(values)]
        if sign not in ".," or any(match["rest"] for match in numbers) or (len(known) and np.median(known) > 100):
            return Sentence("numbers in which {sign!r} parts thousands", sign=sign), shown
        return Sentence("numbers in which {sign!r} parts thousands or is the decimal sign", sign=sign), shown
    if sum(kind_of(text, _OTHER[decimal]) == "number" for text in few) * 2 > len(few):
        said = Sentence("numbers with the decimal sign {sign!r}, beside others with {usual!r}", sign=_OTHER[decimal],
                        usual=decimal)  # fmt: skip
        return said, quoted(few[0])
    return TEXT, quoted(few[0])

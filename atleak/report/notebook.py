"""Show a diagnosis in a notebook: the tables of its record as DataFrames, and its picture with the worst lands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import pandas as pd

from atleak.analysis.answer import answer_of
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts.drawing import controller_svg
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.answer import answer_lines
from atleak.report.tables.first_sentence import shown_verdict
from atleak.report.tables.lands import leaking_worst_first, pair_table
from atleak.report.tables.sentences import caveat_marks

_COLUMNS = ("verdict", "pair", "clearance", "mounting", "wear", "leakage", "share", "decision")
_SHOWN = 8  # lands under the picture
_LAND = ["component", "land"]


def frames(diagnosis: Diagnosis) -> dict[str, pd.DataFrame]:
    """Return the tables of `diagnosis_record`, each list of rows that is not empty by its name."""
    record = diagnosis_record(diagnosis)
    inside = {
        "lands_at_conditions": [
            {**{name: land[name] for name in _LAND}, **at} for land in record["lands"] for at in land["conditions"]
        ],
        "circuits": [{"condition": at["name"], **each} for at in record["conditions"] for each in at["circuits"]],
        "explained": record["answer"]["explained"],
    }
    lists = {name: rows for name, rows in {**record, **inside}.items() if isinstance(rows, list) and rows}
    return {name: _frame(rows) for name, rows in lists.items()}


def _frame(rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return rows without what one of them holds as a table of its own."""
    nested = {name for row in rows for name, value in row.items() if isinstance(value, list | dict)}
    frame = pd.DataFrame([{name: value for name, value in row.items() if name not in nested} for row in rows])
    of_lands = frame.columns[:2].to_list() == _LAND and bool(frame[_LAND].notna().all(axis=None))
    return frame.set_index(_LAND) if of_lands else frame


def html(diagnosis: Diagnosis) -> str:
    """Return the answer, the valve body with the verdict of every land, and the lands that leak most, as HTML."""
    say = wording("en")
    lines = "<br>".join(map(escape, answer_lines(answer_of(diagnosis), say, whole=False)))
    drawn = controller_svg(diagnosis.controller, {land.key: land.verdict for land in diagnosis.lands}, named=say.name)
    rows = [row.land for row in leaking_worst_first(diagnosis)[:_SHOWN]]
    table = pair_table(diagnosis, rows, say).only(*_COLUMNS).filled.html()
    marks = ", ".join((say.signed(shown_verdict(diagnosis)), *caveat_marks(diagnosis, say)))
    head = f"<strong>{escape(diagnosis.controller.name)}: {escape(marks)}</strong>"
    return f'<div style="max-width:64rem"><p>{head}<br>{lines}</p>{drawn}{table}</div>'

"""A workbook of repeated readings → the readings of a gauge study.

Either a reading on each row, with its part, its operator and perhaps its trial, or readings side by side: a column for
each trial, for each part (as AIAG's form has them) or for each operator. Everything wrong is listed at once, with
file, sheet, row and column.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from atleak.doors import own_errors_only
from atleak.errors import Place, one_of
from atleak.faults import together
from atleak.gauge_study.readings import GaugeStudyError, StudyReadings
from atleak.intake.gauge_study.table import StudyTable, find_table, likeness
from atleak.intake.gauge_study.values import crossed
from atleak.intake.sheets.sheet import Sheet
from atleak.intake.sheets.sheet_file import open_sheets
from atleak.intake.units import unit
from atleak.sentence import Sentence

__all__ = ["read_study"]

WANTED = Sentence("a workbook (.xlsx) or text (.csv) of repeated readings")
_HEADINGS = Sentence(
    "a row of headings with part, operator, trial and reading, or part and operator beside a column for each trial; "
    "page Gauge study gives a workbook to fill in"
)


@own_errors_only(GaugeStudyError, "name", "source")
def read_study(
    source: str | Path | bytes, *, name: str | None = None, sheet: str | None = None, length_unit: str | None = None
) -> StudyReadings:
    """Return the readings of a gauge study.

    Parameters
    ----------
    source
        path of a file, or its bytes: ``.xlsx`` (also xls, ods), or text with columns separated by comma, semicolon or
        tab.
    name
        what to call the file in messages; the path's own name by default.
    sheet
        the sheet to read; the one sheet with readings by default.
    length_unit
        of all readings; by default that of their heading, else mm.

    Returns
    -------
    StudyReadings
        values in metres; ``messages`` say what was assumed and what looks like another unit.

    Raises
    ------
    GaugeStudyError
        with all problems found: a cell that is no number, a part that an operator did not read, or not as often as
        the others; fewer than two parts, operators or readings of each; or no such table.
    InputError
        a unit that is none of length.
    """
    stated = None if length_unit is None else unit(length_unit, "length")
    data, file, sheets = open_sheets(source, name, likeness, GaugeStudyError, WANTED)
    table = _the_table(sheets, file, sheet)
    readings, problems = crossed(table, stated, hashlib.sha256(data).hexdigest())
    if problems or readings is None:
        raise together(problems)
    return readings


def _the_table(sheets: list[Sheet], file: str, wanted: str | None) -> StudyTable:
    shown = [sheet for sheet in sheets if not sheet.hidden and wanted in (None, sheet.name)]
    if not shown:
        names = one_of(repr(sheet.name) for sheet in sheets if not sheet.hidden)
        raise GaugeStudyError(Sentence("no such sheet"), place=Place(file), value=wanted, expected=names)
    tables = [table for table in map(find_table, shown) if table is not None]
    if not tables:
        raise GaugeStudyError(Sentence("holds no table of repeated readings"), place=Place(file), expected=_HEADINGS)
    if len(tables) > 1:
        sheets_named = tuple(repr(table.sheet.name) for table in tables)
        problem = Sentence("several sheets hold readings: {sheets}", sheets=sheets_named)
        raise GaugeStudyError(problem, place=Place(file), expected=Sentence("one of them"))
    return tables[0]

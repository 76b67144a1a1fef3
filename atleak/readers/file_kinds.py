"""Say what a file of measured values holds: diameters, gauge readings, the log of a road test, or a valve body.

Only the content counts, never the name. Nothing is read to the end here: whoever reads the file says what is wrong
with it.
"""

from __future__ import annotations

from enum import StrEnum

from atleak.catalogue.controller import Controller
from atleak.common.damage import DAMAGE, is_own_fault
from atleak.common.errors import ReadingsError
from atleak.readers.cells.sheet import Sheet
from atleak.readers.cells.sheet_file import read_sheets
from atleak.readers.controller_workbook import describes_controller
from atleak.readers.gauges import gauge_table
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.layout import find_tables
from atleak.readers.sheets.words import is_word

_WORKBOOK = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_LOG_OF_BUS = (b"MDF     ", b"UnFinMF ")  # ASAM MDF, finished and unfinished
_PARQUET = b"PAR1"
_REFUSED: tuple[type[Exception], ...] = (ReadingsError, *DAMAGE)
_START = 60_000  # bytes of a text that are looked at


class TableKind(StrEnum):
    """What a file of values may hold, by the name of the job's part that it becomes."""

    READINGS = "readings"
    ROAD_TEST = "road_test"
    PRESSURES = "pressures"
    CONTROLLER = "controller"


def table_kind(data: bytes, controller: Controller) -> TableKind:
    """Return what a workbook or a text holds.

    Parameters
    ----------
    data
        the file's bytes.
    controller
        whose component names a measuring sheet may use.

    Returns
    -------
    Table
        a workbook in which nothing is understood counts as a measuring sheet, any other file as a log.
    """
    if data.startswith((*_LOG_OF_BUS, _PARQUET)):
        return TableKind.ROAD_TEST
    is_workbook = data.startswith(_WORKBOOK)
    if not is_workbook:
        data = data[:_START].rpartition(b"\n")[0] if len(data) > _START else data
    names, likeness = ControllerNames(controller), gauge_table.likeness_of(controller)

    def diameters(sheet: Sheet) -> float:
        return max((table.score for table in find_tables(sheet, names) if table.complete), default=0.0)

    try:
        sheets = read_sheets(data, "", lambda sheet: max(diameters(sheet), likeness(sheet)), is_word, only_look=True)
    except _REFUSED as error:
        if is_own_fault(error):
            raise
        return TableKind.READINGS if is_workbook else TableKind.ROAD_TEST  # whoever reads it says what is wrong with it
    if describes_controller(sheets):
        return TableKind.CONTROLLER
    if any(map(diameters, sheets)):
        return TableKind.READINGS
    if gauge_table.find_tabs(sheets, controller).tables:
        return TableKind.PRESSURES
    return TableKind.ROAD_TEST if any(sheet.rows for sheet in sheets) else TableKind.READINGS

"""Read a table of units: one row for each, with where its files lie and what is known of it."""

from atleak.intake.unit_table.headings import MEASURED, column_meant, nearest_heading
from atleak.intake.unit_table.reading import TableColumn, TableRow, UnitTable, is_unit_table, read_unit_table

__all__ = [
    "MEASURED",
    "TableColumn",
    "TableRow",
    "UnitTable",
    "column_meant",
    "is_unit_table",
    "nearest_heading",
    "read_unit_table",
]

"""Hold the cells of a text, a workbook or an office table, whatever its form."""

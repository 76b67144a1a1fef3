"""Hold the cells of a table, whether it came as text, workbook or office document."""

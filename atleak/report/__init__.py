"""Print answers: tables, charts and sentences on the terminal, as PDF, workbook, JSON and blank sheets."""

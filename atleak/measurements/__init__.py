"""Hold what was measured, as typed values: readings, road tests, gauge readings, the job card."""

"""A logger's bytes become a table of cells."""

"""Makes a table of cells of a logger's bytes."""

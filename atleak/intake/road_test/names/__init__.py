"""Derives the quantity that a column holds from its name and unit."""

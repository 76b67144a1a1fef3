"""A column's name and unit give the quantity that it holds."""

"""Write the blank sheets that a workshop fills in."""

"""A column of stamps becomes time in seconds."""

"""Converts a column of time stamps to seconds."""

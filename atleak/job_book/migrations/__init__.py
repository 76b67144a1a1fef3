"""Bring a job book of an earlier version up to date."""

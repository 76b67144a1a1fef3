"""Describe the catalogue's files as sheets to fill in, for workbooks and pages."""

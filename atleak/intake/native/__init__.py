"""Reads files that only native code can read (workbooks, Parquet, MDF) in a process of their own, with limits.

No check made beforehand keeps a damaged file from crashing the process that reads it or from filling its memory. So
that process is never the caller's: ``process`` is the caller's side, ``child`` runs on the other, ``workbooks``,
``parquet_tables`` and ``measurements`` hold the functions that read there.
"""

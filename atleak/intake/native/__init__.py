"""Files that only native code reads (workbooks, MDF) are read in a process of their own, with limits.

No check made beforehand keeps a damaged file from ending or filling the process that reads it. So that process is
never the caller's: ``process`` is the caller's side, ``child`` what runs on the other, ``workbooks`` and
``measurements`` hold the functions that read there.
"""

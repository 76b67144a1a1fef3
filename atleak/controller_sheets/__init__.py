"""Declare the sheets of the workbook that describes a valve body: one declaration for writing and for reading them.

`units` and `kinds` say what stands in a cell, `shapes` how the rows of a sheet become tables of a controller's file,
`layout` which sheets and columns there are. `atleak.report.controller_workbook` writes such a workbook and
`atleak.intake.controller_workbook` reads one.
"""

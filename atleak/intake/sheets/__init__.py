"""A file of tables (xlsx, xls, ods, csv) into sheets of cells, before anything in it is understood."""

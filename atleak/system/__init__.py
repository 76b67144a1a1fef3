"""The computer around the package: files written whole, the marks on them, a terminal, files that ship with it."""

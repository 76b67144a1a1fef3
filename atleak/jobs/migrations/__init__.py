"""Bring the tables of a book that an earlier version made to today's; a new book is made as `tables` declares it."""

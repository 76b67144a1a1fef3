"""Keep every job that was worked on in one book, on SQLite or PostgreSQL: `open_book` opens it."""

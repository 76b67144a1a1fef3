"""Keep every job, on SQLite or PostgreSQL."""

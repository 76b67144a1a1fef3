"""A job: what the workshop writes down, and all of it in one file."""

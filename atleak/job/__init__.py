"""Hold a job: its files and choices, what the workshop writes down, and all of it in one zip."""

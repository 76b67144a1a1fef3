"""Hold what every room shares: errors, messages, units, verdicts, files, access."""

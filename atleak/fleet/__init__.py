"""Many jobs at once: where they come from, how they are shared out to workers, and what their results say together."""

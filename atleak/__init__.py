"""atleak: internal leakage of automatic-transmission valve bodies."""

__version__ = "0.1.0"

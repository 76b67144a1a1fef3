"""Hold the pages of the dashboard; ``app.py`` finds them by their names."""

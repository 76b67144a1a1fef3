"""Read outside files into measurements: the only place that guesses and converts."""

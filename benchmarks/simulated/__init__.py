"""Simulated units whose truth is known: their pairs, what gauges read of them, and what leaks through them.

Nothing of atleak's engine or of its uncertainty is used here, so that they can be compared with it.
"""

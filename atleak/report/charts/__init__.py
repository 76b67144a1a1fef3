"""Describe each chart once; draw it on screen and on paper."""

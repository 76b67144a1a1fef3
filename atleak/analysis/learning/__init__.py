"""Learn the mounting clearances of a valve body's file from measuring sheets of new or known-good units.

Begin at `learned_clearances.learn`. `outliers` names pairs and units that cannot be new, `estimate_clearance` gives a
land's clearance with its uncertainty and the spread of new pairs, `learned_words.with_learned` writes the file.
"""

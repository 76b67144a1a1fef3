"""From measuring sheets of new or known-good units to the mounting clearances of a valve body's file.

`learned_clearances.learn` is the way through it: `outliers` names the pairs and units that are no new ones,
`learned_clearances.estimate` gives each land's clearance with its uncertainty and the spread of new pairs,
`learned_words.with_learned` writes them into the tables of the file.
"""

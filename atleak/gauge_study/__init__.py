"""How well a gauge measures in this workshop's hands: repeated readings of several parts by several people.

``readings`` the values, ``anova`` their analysis of variance, ``instrument`` the study's result as an instrument of the
user's own catalogue.
"""

"""Compute further channels of a road test from those it has, by formulas that people type: ``p_g − p_k``.

`parse` reads a formula into a tree, `evaluate` computes the tree over a road test, units carried along.
"""

from atleak.analysis.formulas.evaluation import CHANNEL_NAMES, FormulaChannel, evaluate, formula_channel
from atleak.analysis.formulas.parsing import FUNCTIONS, parse

__all__ = ["CHANNEL_NAMES", "FUNCTIONS", "FormulaChannel", "evaluate", "formula_channel", "parse"]

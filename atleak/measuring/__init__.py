"""Measuring at the bench: what is to be measured in which order, what was typed, and what is doubtful about it.

1. `plan` lists the cells, one for every diameter, in the order in which they are measured.
2. `typed` holds the texts of the cells, and what is done to them: an entry, a pasted block, one step back.
3. `doubts` judges them by the rules of the measuring sheet, cell by cell, and says which of them count.
4. `typed_file` keeps them as a measuring sheet, which `atleak.intake.readings` reads as any other.
5. `record` says all of it in a reader's words, for a grid on a screen.
"""

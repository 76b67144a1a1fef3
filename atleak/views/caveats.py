"""Say in a reader's language that a verdict is provisional, or leakage an upper bound, and why."""

from __future__ import annotations

from atleak.diagnosis import Diagnosis
from atleak.wording import Wording


def caveat_marks(diagnosis: Diagnosis, say: Wording) -> list[str]:
    """Return the words that stand beside the verdict: that it is provisional, that leakage is an upper bound."""
    marks = ["provisional"] if diagnosis.provisional else []
    marks += ["upper_bound"] if diagnosis.upper_bound else []
    return [say.get("caveat_marks", mark) for mark in marks]


def caveats(diagnosis: Diagnosis, say: Wording) -> list[str]:
    """Return a sentence for each of them."""
    sentences = []
    if diagnosis.provisional:
        values = ", ".join(say.get("bases", basis) for basis in diagnosis.provisional)
        sentences.append(say("caveats.provisional", values=values))
    if diagnosis.upper_bound:
        sentences.append(say("caveats.upper_bound"))
    return sentences

"""The words of a measuring sheet that several of its tabs, or those who read it back, ask for."""

from __future__ import annotations

from collections.abc import Mapping

from atleak.sentence import Sentence

SHEET = Sentence("Measurements")
UNWORN_END = Sentence("unworn end")  # what marks a reading there; the intake's vocabulary knows it in every language
PUMP_SIDE, PUMP_TIP = Sentence("Pump side clearance"), Sentence("Pump tip clearance")  # the intake reads them
REPRESENTATIVE, AS_STATED = Sentence("representative"), Sentence("as stated")
PART_NAMES: Mapping[str, Sentence] = {
    "spool": Sentence("spool"),
    "piston": Sentence("piston"),
    "end plug": Sentence("end plug"),
    "sleeve": Sentence("sleeve"),
}

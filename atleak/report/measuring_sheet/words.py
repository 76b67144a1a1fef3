"""The words of a measuring sheet that several of its tabs, or those who read it back, ask for."""

from __future__ import annotations

from collections.abc import Mapping

from atleak.sentence import Sentence

SHEET = Sentence("Measurements")
UNWORN_END = Sentence("unworn end")  # what marks a reading there; the intake's vocabulary knows it in every language
PUMP_SIDE, PUMP_TIP = Sentence("Pump side clearance [µm]"), Sentence("Pump tip clearance [µm]")  # the intake reads them
PART_NAMES: Mapping[str, Sentence] = {
    "spool": Sentence("spool"),
    "piston": Sentence("piston"),
    "end plug": Sentence("end plug"),
    "sleeve": Sentence("sleeve"),
}

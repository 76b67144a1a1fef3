"""Write the first sentence of the summary as a formula: what it says follows from the sheets that compute.

It counts the lands past a limit and names the condition at which the unit leaks worst. What no formula gives, such as
how sure a verdict is, stands in the sentence as issued.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from atleak.diagnosis import Diagnosis
from atleak.report.xlsx.live import LiveSheets
from atleak.report.xlsx.live_cells import RANKED, quote
from atleak.report.xlsx.names import NOTHING_DELIVERED
from atleak.verdicts import BANDS, FLAGGED
from atleak.views.first_sentence import lands_part, total_part
from atleak.wording import Wording

_PLACE = re.compile("\x01([^\x01]+)\x01")  # where a formula stands in a sentence


class Headline:
    """The first sentence of one diagnosis, as formulas.

    Parameters
    ----------
    rank
        the formula of the rank of the unit's verdict.
    """

    def __init__(self, diagnosis: Diagnosis, live: LiveSheets, rank: str, say: Wording) -> None:
        self.diagnosis, self.live, self.rank, self.say = diagnosis, live, rank, say
        verdicts = live.sheet.whole("verdict")
        self.counts = {level: f"COUNTIF({verdicts},{quote(say.signed(level))})" for level in reversed(FLAGGED)}
        self.flagged = "+".join(self.counts.values())
        self.nothing_open = not diagnosis.unmeasured and not diagnosis.in_doubt  # else the unit is never called good

    @property
    def issued(self) -> str:
        """Return the sentence as it follows from the diagnosis."""
        diagnosis, say = self.diagnosis, self.say
        lands, total = lands_part(diagnosis, say), total_part(diagnosis, say)
        return f"{say.signed(diagnosis.verdict)}: {lands}; {total}."

    def formula(self, verdict: str) -> str:
        """Return the formula of the sentence; ``verdict`` is the cell with the verdict's sign and word."""
        return _joined([verdict, quote(": "), self._lands(), quote("; "), self._total(), quote(".")])

    def _lands(self) -> str:
        """Return the formula of how many of the measured lands are past a limit."""
        say, measured = self.say, self.diagnosis.judged
        named, before = [], ""
        for level, count in self.counts.items():
            comma = [f'IF({before}>0,", ","")'] if before else []
            named.append(f'IF({count}>0,{_joined([*comma, count, quote(f" {say.signed(level)}")])},"")')
            before = f"{before}+{count}" if before else count
        past = self._said("diagnosis.flagged", {"flagged": _joined(named)}, measured=measured)
        within = quote(say("diagnosis.none_past", measured=measured))
        if self.nothing_open:
            within = f"IF({self.rank}>1,{within},{quote(say('diagnosis.all_within', measured=measured))})"
        return f"IF({self.flagged}>0,{past},{within})"

    def _total(self) -> str:
        """Return the formula of what the unit leaks where that is worst, and which band that is."""
        totals, say = self.live.totals, self.say
        worst = f"MATCH(MAX({totals.row_of('order')}),{totals.row_of('order')},0)"
        condition, share, order = (
            f"INDEX({cells},1,{worst})" for cells in (totals.labels, totals.row_of("share"), totals.row_of("order"))
        )
        bands = ([band for band in BANDS if band.verdict.rank <= verdict.rank][-1] for verdict in RANKED)
        band = f"CHOOSE(INT({order}),{','.join(quote(say.signed(each)) for each in bands)})"
        places = {"share": self._percent(share), "condition": condition, "band": band}
        leaks = self._said("diagnosis.leaks", places)
        good = f"OR(INT({order})>1,{self.rank}<2)" if self.nothing_open else f"INT({order})>1"
        said = f"IF({good},{leaks},{self._said('diagnosis.leaks_open', places)})"
        nothing = self._said("diagnosis.no_delivery", {"condition": condition})
        return f"IF({share}>={NOTHING_DELIVERED}/10,{nothing},{said})"

    def _percent(self, share: str) -> str:
        """Return the formula of a share [%] as text, with the language's decimal sign whatever program shows it."""
        tenths = f"ROUND({share}*10,0)"
        return _joined([f"INT({tenths}/10)", quote(self.say.texts["decimal"]), f"MOD({tenths},10)", quote("\u00a0%")])

    def _said(self, key: str, live: Mapping[str, str], **values: object) -> str:
        """Return the formula of a sentence of the texts with formulas at some of its places."""
        text = self.say(key, **{name: f"\x01{name}\x01" for name in live}, **values)
        return _joined(live[part] if at % 2 else quote(part) for at, part in enumerate(_PLACE.split(text)) if part)


def _joined(parts: Iterable[str]) -> str:
    return f"CONCATENATE({','.join(parts)})"

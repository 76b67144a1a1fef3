"""Write the summary, one page wide in print, and what of it follows from the sheets that compute.

Its first sentence counts the lands past a limit and names the condition at which the unit leaks worst. What no formula
gives, such as how sure a verdict is, stands there as issued; so do the lands that were flagged, beside those flagged
since.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.common.sentences import Name, Sentence
from atleak.common.verdicts import BANDS, FLAGGED, VERDICTS
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.report.tables.first_sentence import lands_part, total_part
from atleak.report.xlsx.book import ReportBook, cell_span, formula
from atleak.report.xlsx.lands import LiveSheets
from atleak.report.xlsx.live_sheet import NOTHING_DELIVERED, RANKED, ColumnKey, LiveCell, quote
from atleak.report.xlsx.page import SheetPage

_LABELS = 25, 42  # [characters] least and most width of the first column
_NAMES, _VERDICTS, _OTHERS = 22, 15, 12  # width of the second, the third and any other
_ROOM = 190  # of all columns, which prints at three quarters of its size on A4
_SIDES, _TOP = 0.3, 0.5  # [in] margins
_PLACE = re.compile("\x01([^\x01]+)\x01")  # where a formula stands in a sentence
OF_A_LAND = (Sentence("component"), Sentence("name"), Sentence("verdict"), Sentence("land"))
_COLUMNS: tuple[ColumnKey, ...] = ("component", "name", "verdict", "land")  # the same on the sheet of lands
_BOLD = {"bold": True}
ALSO = 8  # rows for lands that are flagged since


def summary_page(book: ReportBook, sheet: Worksheet, columns: int) -> SheetPage:
    """Return the page of a summary; ``columns`` is how many the widest of its tables has."""
    others = _NAMES, _VERDICTS, *[_OTHERS] * (columns - 3)
    least, most = _LABELS
    sheet.set_margins(left=_SIDES, right=_SIDES, top=_TOP)
    return SheetPage(book, sheet, (min(max(_ROOM - sum(others), least), most), *others))


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
        return _joined([f"INT({tenths}/10)", quote(self.say.decimal), f"MOD({tenths},10)", quote("\u00a0%")])

    def _said(self, key: str, live: Mapping[str, str], **values: object) -> str:
        """Return the formula of a sentence of the texts with formulas at some of its places."""
        text = self.say(key, **{name: f"\x01{name}\x01" for name in live}, **values)
        return _joined(live[part] if at % 2 else quote(part) for at, part in enumerate(_PLACE.split(text)) if part)


def _joined(parts: Iterable[str]) -> str:
    return f"CONCATENATE({','.join(parts)})"


class FlaggedLands:
    """The flagged lands of one diagnosis."""

    def __init__(self, book: ReportBook, diagnosis: Diagnosis, live: LiveSheets, headline: Headline) -> None:
        self.book, self.diagnosis, self.live, self.headline = book, diagnosis, live, headline
        shown = [at for at in live.conditions if any(at.projection is each for each in diagnosis.reported)]
        self._values: list[ColumnKey] = ["c_r", "c_m", "wear", *(("share", at.prefix) for at in shown)]

    @property
    def columns(self) -> int:
        """Return how many columns their list has; its last takes the room of three."""
        return len(OF_A_LAND) + len(self._values) + 3

    def write(self, page: SheetPage, row: int) -> int:
        """Write how many are flagged now and as issued, both lists; return the next free row."""
        flagged = self.diagnosis.flagged
        row = page.across(row, Sentence("Flagged lands as issued, the worst first"), bold=True)
        row = self._counts(page, row)
        columns = self.live.sheet.columns
        headings = [columns[self.live.sheet.place[key]].heading for key in self._values]
        if flagged:
            first, names = row + 1, [*OF_A_LAND, *headings, Sentence("because, as issued")]
            row = page.table(row, names, map(self._issued, flagged))
            self.book.colour_words(page.sheet, (first, 2), (row - 1, 2), VERDICTS)
        else:
            row = page.across(row, Sentence("none"))
        rows = min(ALSO, len(self.live.lands) - len(flagged))
        if not rows:
            return row
        title = page.across(row, Sentence("Flagged since, by the numbers of this workbook"), bold=True) - 1
        for number in range(1, rows + 1):
            self._since(page, row + number, number)
        self._more(page, title, rows)
        self.book.colour_words(page.sheet, (row + 1, 2), (row + rows, 2), VERDICTS)
        return row + rows + 2

    def _counts(self, page: SheetPage, row: int) -> int:
        """Write the number of flagged lands by level, now and as issued, beside one another; return the next row."""
        book, say, left = self.book, self.book.say, {"align": "left"}
        lands = self.diagnosis.lands
        pairs = [
            (Sentence("flagged now"), Sentence("flagged as issued"), self.headline.flagged, len(self.diagnosis.flagged))
        ]
        pairs += [
            (
                Sentence("{level} now", level=say.signed(level)),
                Sentence("{level} as issued", level=say.signed(level)),
                count,
                sum(land.verdict == level for land in lands),
            )
            for level, count in self.headline.counts.items()
        ]
        for at, (now, issued, count, known) in enumerate(pairs, start=row):
            page.text(at, 0, now, bold=True)
            formula(page.sheet, at, 1, count, known, book.form("count", **left))
            page.text(at, 2, issued)
            book.put(page.sheet, at, 3, known, book.form("count", **left))
        return row + len(pairs)

    def _issued(self, flag: LandDiagnosis) -> list[Any]:
        live, rule, (component, number), at = self.live, flag.deciding, flag.key, self.live.row_of[flag.key]
        values = {key: live.land_cell(flag, key) for key in self._values}
        origin = None if rule is None else self.book.say.get("origins", rule.origin)
        return [
            LiveCell("plain", component, look=_BOLD),
            Name(self.diagnosis.controller.components[component]),
            LiveCell("plain", self.book.say.signed(flag.verdict), live.sheet.cell(at, "verdict"), _BOLD),
            number,
            *(replace(each, formula=live.sheet.cell(at, key), look={}) for key, each in values.items()),
            None if rule is None else Sentence("{rule} ({origin})", rule=rule.label, origin=origin),
        ]

    def _since(self, page: SheetPage, row: int, number: int) -> None:
        """Write the land at this place among those flagged since; cells stay empty where there are not so many."""
        live = self.live
        first, here = (live.sheet.cell(at, "also") for at in (1, number))
        largest = f"LARGE({self._column('also')},ROWS({first}:{here.rpartition('!')[2]}))"
        place = f"MATCH({largest},{self._column('also')},0)"
        for column, key in enumerate((*_COLUMNS, *self._values)):
            like = live.land_cell(live.lands[0], key)
            shown = f'IF({largest}>0,INDEX({self._column(key)},{place}),"")'
            if key in _COLUMNS:
                page.formula(row, column, shown, "", bold=key in ("component", "verdict"))
            else:
                formula(page.sheet, row, column, shown, "", page.number(like.kind, like.of))

    def _more(self, page: SheetPage, title: int, rows: int) -> None:
        """Write below their list how many more lands are flagged since than it has rows."""
        row, count = title + rows + 1, f'COUNTIF({self._column("also")},">0")'
        page.text(row, 0, Sentence("further lands flagged since, not listed here"), bold=True)
        listed = cell_span(title + 1, title + rows, 0)
        left = self.book.form("count", align="left")
        formula(page.sheet, row, 1, f"MAX({count}-ROWS({listed}),0)", 0, left)

    def _column(self, key: ColumnKey) -> str:
        return self.live.sheet.whole(key)

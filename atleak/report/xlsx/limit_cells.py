"""Write the sheet of limits, and the limits that follow from it for one land or total as formulas.

A limit of wear depends on the land's mounting clearance, one of a share on the same share when new; see
`atleak.catalogue.limits.Steps`, which computes what these formulas give.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.limits import Level, Limits, RuleKind, Steps
from atleak.report.xlsx.book import Book, cell
from atleak.report.xlsx.live_cells import CHANGEABLE, largest_of
from atleak.report.xlsx.names import NOTHING_DELIVERED, of_limit
from atleak.sentence import Name, Sentence
from atleak.verdicts import BANDS, FLAGGED
from atleak.wording import Wording
from atleak.workshop_units import PERCENT, UM

Part = Literal["limit", "at_least", "growth", "added", "fall"]  # of a limit: each stands in a row of its own
LIMITS = Sentence("Limits")
_LIMIT, _ORIGIN, _SOURCE = Sentence("limit"), Sentence("origin"), Sentence("source")
_LABELS: dict[RuleKind, dict[Part, Sentence]] = {
    RuleKind.WEAR: {
        "limit": Sentence("wear [%]"),
        "at_least": Sentence("and clearance over c_m and its tolerance [µm]"),
    },
    RuleKind.CLEARANCE: {"limit": Sentence("radial clearance [µm]")},
    RuleKind.PAIR_SHARE: {
        "limit": Sentence("share of pump flow of one land [%]"),
        "growth": Sentence("and growth over the same land new [%]"),
        "added": Sentence("and points of pump flow added to it"),
    },
    RuleKind.TOTAL_SHARE: {
        "limit": Sentence("share of pump flow of the whole valve body [%]"),
        "growth": Sentence("and growth over the same unit new [%]"),
        "added": Sentence("and points of pump flow added to it"),
    },
    RuleKind.RESERVE: {
        "limit": Sentence("reserve of the pump, under [-]"),
        "fall": Sentence("or, where the same unit new is under it, fall from that [%]"),
    },
    RuleKind.CIRCUIT_LOSS: {"limit": Sentence("pressure that a circuit lost against new [kPa]")},
    RuleKind.PERMISSIBLE_PRESSURE: {"limit": Sentence("main pressure below the permissible [%]")},
    RuleKind.COMMANDED_PRESSURE: {"limit": Sentence("main pressure off the commanded [kPa]")},
}
_NOTE = Sentence(
    "A level begins where all of its rows are reached; a level of wear never begins below the one before it. An empty "
    "field asks for nothing, and a number filled in there is not followed. A level of the reserve is reached under its "
    "limit, one of a limit of 0 by anything over it."
)


@dataclass(frozen=True)
class _Row:
    kind: RuleKind
    part: Part
    values: Mapping[Level, float]  # in the unit that people read


class LimitCells:
    """The name of every part of every limit, and the sheet on which they stand."""

    def __init__(self, limits: Limits, say: Wording) -> None:
        self.limits = limits
        self._sheet = say.sentence(LIMITS)
        self.levels = list[Level](dict.fromkeys([*FLAGGED, *BANDS[1:]]))  # a column each
        self._rows = [row for kind, steps in limits.rules.items() for row in _rows(kind, steps)]
        self._names = {
            (row.kind, level, row.part): of_limit(row.kind, row.part, level)
            for row in self._rows
            for level in row.values
        }

    def wear(self, level: Level, mounting: str, tolerance: str | None, before: str | None) -> str:
        """Return the formula of a limit of wear [%] from the cells of c_m, its tolerance and the limit before it."""
        kind = RuleKind.WEAR
        terms = [self._names[kind, level, "limit"]]
        if (kind, level, "at_least") in self._names:
            at_least = self._names[kind, level, "at_least"]
            least = f"({at_least}+{tolerance})" if tolerance else at_least
            terms.append(f"{least}/{mounting}*100")
        return largest_of([*terms, *([before] if before else [])])

    def plain(self, kind: RuleKind, level: Level) -> str:
        """Return the cell of a limit that is the same for every value of its kind."""
        return self._names[kind, level, "limit"]

    def reserve(self, level: Level, new: str, worse: str | None) -> str:
        """Return the formula of a limit of the reserve from the cells of that when new and of the worse level's limit.

        See `atleak.catalogue.limits.Steps.under`.
        """
        limit, fall = (self._names[RuleKind.RESERVE, level, part] for part in ("limit", "fall"))
        fallen = f"IF({new}<{limit},(1-{fall}/100)*{new},{limit})"
        return largest_of([fallen, worse or f"MIN({limit},1)"])

    def share(self, kind: RuleKind, level: Level, new: str) -> str:
        """Return the formula of a limit of a share [%] from the cell of the same share when new [%]."""
        terms = [self._names[kind, level, "limit"]] if (kind, level, "limit") in self._names else []
        if (kind, level, "growth") not in self._names:
            return largest_of(terms)
        growth, added = (self._names[kind, level, part] for part in ("growth", "added"))
        grown = largest_of([*terms, f"{new}*(1+{growth}/100)", f"{new}+{added}"])
        return f"MIN({grown},{NOTHING_DELIVERED})"

    def write(self, book: Book, sheet: Worksheet) -> None:
        """Write every limit with its origin; what is blue is followed."""
        origin = 1 + len(self.levels)
        book.headings(sheet, 0, [_LIMIT, *(book.say.level(level) for level in self.levels), _ORIGIN, _SOURCE])
        for row, each in enumerate(self._rows, start=1):
            first = each.part == "limit"
            book.put(sheet, row, 0, _LABELS[each.kind][each.part], book.form(bold=first, indent=0 if first else 1))
            for level, value in each.values.items():
                column = 1 + self.levels.index(level)
                book.put(sheet, row, column, value, book.form("um", **CHANGEABLE))
                name = self._names[each.kind, level, each.part]
                book.workbook.define_name(name, f"={cell(row, column, self._sheet)}")
            if first:
                steps = self.limits.rules[each.kind]
                book.put(sheet, row, origin, book.say.get("origins", steps.origin), book.wrapped)
                book.put_text(sheet, row, origin + 1, steps.source, book.wrapped, 64)
        row = len(self._rows) + 2
        book.put(sheet, row, 0, _NOTE)
        book.pairs(
            sheet, row + 1, [(Sentence("limit set"), Name(self.limits.name)), (Sentence("note"), self.limits.note)]
        )
        sheet.set_column(0, 0, 46)
        sheet.set_column(1, origin - 1, 12)
        sheet.set_column(origin, origin, 24)
        sheet.set_column(origin + 1, origin + 1, 70)


def _rows(kind: RuleKind, steps: Steps) -> Iterable[_Row]:
    """Return the rows of one quantity: its limits first, then what else a level asks for."""
    yield _Row(kind, "limit", {level: limit * kind.factor for level, limit in steps.levels if steps.has_limit(level)})
    at_least = {level: value * UM for level, value in steps.at_least.items()}
    growth = {level: grown * PERCENT for level, (grown, _) in steps.growth.items()}
    added = {level: points * PERCENT for level, (_, points) in steps.growth.items()}
    fall = {} if steps.fall is None else {level: steps.fall * PERCENT for level, _ in steps.levels}
    others: tuple[tuple[Part, dict[Level, float]], ...] = (
        ("at_least", at_least), ("growth", growth), ("added", added), ("fall", fall),
    )  # fmt: skip
    for part, values in others:
        if values:
            yield _Row(kind, part, values)

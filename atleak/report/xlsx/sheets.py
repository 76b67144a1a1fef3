"""Write the sheets around the computation: summary, road test, job, messages, provenance, and the estimate."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from functools import partial
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.analysis.repair.plan import PumpStep, RepairPlan, RepairStep, plan_repairs
from atleak.common.errors import MessageLevel
from atleak.common.sentences import Name, Sentence
from atleak.common.style import cell_colour
from atleak.common.units import DM3_MIN, PERCENT, UnitOf
from atleak.common.verdicts import BANDS, VERDICTS, Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job, Record
from atleak.measurements.readings import CellKind, SheetCells
from atleak.readers.cells.sheet import column_letter
from atleak.report.json.conditions import named_record
from atleak.report.tables.answer import answer_facts
from atleak.report.tables.complaint import MEASURE_FIRST, finding, measure_first, reason
from atleak.report.tables.estimate import open_words
from atleak.report.tables.first_sentence import first_sentence
from atleak.report.tables.lands import MatrixRow, condition_matrix
from atleak.report.tables.names import spools_taken
from atleak.report.tables.repairs import no_help, option_table, plan_ends, pump_brings, step_consequence, step_in_words
from atleak.report.tables.sentences import (
    caveat_marks,
    caveats,
    fluid_in_state,
    measuring_temperature,
    option_value,
    profile_words,
)
from atleak.report.tables.what_was_read import (
    KIND_WORDS,
    WHAT_BECAME,
    as_written,
    column_said,
    kinds_in,
    meaning_said,
    row_said,
)
from atleak.report.xlsx.book import ReportBook, cell
from atleak.report.xlsx.conditions import AS_SPOOLS_MAY_LIE, DEMAND, covers
from atleak.report.xlsx.lands import LiveSheets
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    FLOW,
    RANKED,
    LiveCell,
    LiveCells,
    LiveColumn,
    LiveSheet,
    SheetCondition,
    component_width,
    verdict_of_rank,
)
from atleak.report.xlsx.page import SheetPage
from atleak.report.xlsx.road_sheet import RoadSheets
from atleak.report.xlsx.summary import OF_A_LAND, FlaggedLands, Headline, summary_page

#: rows of the summary's totals: quantities of the sheet of conditions, and among them what follows no number
_TOTALS = (
    "band", "decision", "leakage", "low", "high", "leakage_new", "growth", "share", "share_new", "share_concentric",
    "share_touching", "capacity", "n_min", "reserve", "reserve_new", "p_g", "p_g_held", "T", "n",
)  # fmt: skip
_ISSUED = {
    "decision": Sentence("decision as issued"),
    "low": Sentence("leakage, low as issued [{unit}]", unit=FLOW),
    "high": Sentence("leakage, high as issued [{unit}]", unit=FLOW),
}
_OF_A_STEP = (*OF_A_LAND, Sentence("total before [%]"), Sentence("total after [%]"), Sentence("band after"))
_HOW_TO_CHANGE = (
    Sentence("Blue cells may be changed: everything in black follows from them."),
    Sentence(
        "What is marked “as issued” is atleak's result and does not follow; nor do the sheets of the road test, of "
        "gauge readings, of the job and its messages. The estimate follows its own blue cells alone."
    ),
    Sentence(
        "All sheets are protected against slips, without a password: only blue cells take a change. Who wants to "
        "change more unprotects the sheet (Review, Unprotect Sheet)."
    ),
    Sentence(
        "What is for the screen is not printed: readings, directions, gaps, the series of a road test, and columns "
        "that would print too small. Clear a sheet's print area (Page Layout, Print Area) to print it all."
    ),
)
_FACTORS = Sentence(
    "Each formula converts the cells that it takes to the metric units of its equation, and its result back: a factor "
    "such as 25.4 beside a cell does that."
)
_LEVELS: dict[MessageLevel, Sentence] = {"info": Sentence("info"), "warning": Sentence("warning")}
_NARROWEST, _WIDEST = 9, 15  # columns of what was read [characters]
_LEAST = 10  # columns of the summary: what stands alone is a long text
_KINDS = {"_km": "distance", "_c": "temperature", "_um": "clearance"}  # of quantity, by the end of a field's name
_WORDED = ("name", "representative_note", "source")  # of an entry of the catalogue, in words


class Sheets:
    """The sheets around those that compute."""

    def __init__(
        self, book: ReportBook, diagnosis: Diagnosis, record: dict[str, Any], job: Job, live: LiveSheets
    ) -> None:
        self.book, self.diagnosis, self.record, self.job, self.live = book, diagnosis, record, job, live
        self.say = book.say
        measured = (*diagnosis.gauge_rules, *diagnosis.log_rules)
        of_pump = (each.rule for each in diagnosis.pump.decisions)
        shown = dict.fromkeys(rule.verdict for rule in (*diagnosis.vacuum_rules, *measured, *of_pump))
        shown |= {Verdict.WATCH: None} if diagnosis.too_tight else {}
        issued = "".join(f",{1 + RANKED.index(verdict)}" for verdict in shown)
        self.headline = Headline(diagnosis, live, f"MAX({live.rules.ranks}{issued})", self.say)

    # --- summary

    def write_summary(self, sheet: Worksheet) -> None:
        """Write the answer first, then the verdict, totals, flagged lands and the order of repair."""
        book, record, diagnosis = self.book, self.record, self.diagnosis
        plan = None if diagnosis.without_sheet else plan_repairs(diagnosis)
        flagged = FlaggedLands(book, diagnosis, self.live, self.headline)
        page = summary_page(book, sheet, max(_LEAST, flagged.columns, *(self._columns(plan) if plan else ())))
        title = self.say("title.report")
        self.book.put(
            sheet, 0, 0, f"{self.job.workshop.name}: {title}" if self.job.workshop.name else title, book.title
        )
        sheet.set_row(0, 24)
        answer = answer_facts(diagnosis, self.say).rows
        page.pairs(1, answer)
        self._verdict(page, 1 + len(answer))
        vehicle, box = self.job.vehicle, self.job.transmission
        rows: list[tuple[str, Any]] = [
            (Sentence("job"), self.job.number),
            (Sentence("date"), self.job.date),
            (Sentence("customer"), self.job.customer.name),
            (Sentence("vehicle"), " ".join(filter(None, (vehicle.make, vehicle.model, vehicle.registration)))),
            (Sentence("VIN"), vehicle.vin),
            (Sentence("transmission"), " ".join(filter(None, (box.maker, box.code, box.serial)))),
            (
                Sentence("mileage [{unit}]", unit=UnitOf("distance")),
                self._plain("mileage_km", record["mileage_km"] or vehicle.mileage_km),
            ),
            (Sentence("valve body"), Name(record["controller"]["name"])),
            (Sentence("fluid"), fluid_in_state(diagnosis, self.say)),
            (Sentence("limits"), Name(record["limits"]["name"])),
            (Sentence("profile"), profile_words(diagnosis.profile, self.say)),
            (Sentence("measuring sheet"), record["readings"]["file"]),
            (Sentence("measured at"), measuring_temperature(diagnosis, self.say)),
            (Sentence("road test"), diagnosis.log.road_test.file if diagnosis.log else None),
            (Sentence("gauge readings"), diagnosis.pressures.table.file if diagnosis.pressures else None),
            *self._complaint(),
        ]
        row = page.pairs(5 + len(answer), rows) + 1
        if plan is None:
            row = page.across(row, self.say("findings.alone"))
            if diagnosis.log is not None:
                for sentence, leads in RoadSheets(book, diagnosis, diagnosis.log).findings():
                    row = page.across(row, sentence, bold=leads)
        else:
            row = self._totals(page, row) + 1
            row = flagged.write(page, row) + 1
            row = self._repair(page, row, plan) + 1
            for note in (*_HOW_TO_CHANGE, *([] if self.say.units == "metric" else [_FACTORS])):
                row = page.across(row, note)
        sheet.print_area(0, 0, row - 1, page.last)  # the title may run further

    def _columns(self, plan: RepairPlan) -> tuple[int, ...]:
        """Return how many columns the tables of totals, of the order of repair and of the repairs have."""
        steps = len(_OF_A_STEP) + len(plan.ends) + 2 if plan.order else 0
        return 1 + len(self.live.conditions), steps, len(option_table(plan, self.say).parted.columns)

    def _complaint(self) -> list[tuple[str, Any]]:
        """Return the customer's complaint, where it shows, what explains it, and which lands to measure first."""
        diagnosis = self.diagnosis
        if diagnosis.complaint is None:
            return []
        ranked = measure_first(diagnosis)
        say = self.say
        lands = [f"{each.land.key[0]}/{each.land.key[1]}: {reason(each, say)}" for each in ranked[:MEASURE_FIRST]]
        return [
            (Sentence("complaint"), say.name(diagnosis.complaint.label)),
            (Sentence("shows at"), "; ".join(say.condition(each.condition) for each in diagnosis.complained)),
            (Sentence("what explains it, as issued"), finding(diagnosis, say)),
            *((f"{number}.", land) for number, land in enumerate(lands, start=1)),
        ]

    def _verdict(self, page: SheetPage, row: int) -> None:
        """Write the verdict of the unit as it follows from the workbook's rules, and below it the one issued."""
        book, diagnosis = self.book, self.diagnosis
        page.text(row, 0, Sentence("verdict of the unit"), bold=True)
        known = self.say.signed(diagnosis.verdict)
        if diagnosis.judged:  # half a pair is never called ok
            fine = Verdict.OK if any(land.state.can_be_ok for land in diagnosis.lands) else Verdict.NOT_MEASURED
            page.formula(row, 1, verdict_of_rank(self.headline.rank, self.say, fine), known, bold=True)
        else:
            page.text(row, 1, known, bold=True)
        book.colour_words(page.sheet, (row, 1), (row, 1), VERDICTS)
        said = f"{known}: {first_sentence(diagnosis, self.say)}"
        marks = caveat_marks(diagnosis, self.say)
        marked = [f"{', '.join(marks).capitalize()}."] if marks else []
        if diagnosis.judged:
            page.text(row + 1, 0, Sentence("by the numbers of this workbook"), bold=True)
            follows = self.headline.formula(cell(row, 1))
            page.formula(row + 1, 1, follows, self.headline.issued, page.last)
        page.text(row + 2, 0, Sentence("as issued"), bold=True)
        page.text(row + 2, 1, " ".join([*marked, said, *caveats(diagnosis, self.say)]), page.last)

    def _totals(self, page: SheetPage, row: int) -> int:
        """Write each condition's total beside the same unit new, how sure its band is, and as the spools may lie.

        Every condition has a column, every quantity a row.
        """
        live, first = self.live, row + 1
        page.text(row, 0, self.say("printed.condition"), bold=True)
        for column, at in enumerate(live.conditions, start=1):
            worst = at.projection is self.diagnosis.worst and len(live.conditions) > 1
            label = Sentence("{condition}; the worst, as issued", condition=at.label) if worst else at.label
            page.text(row, column, label, bold=True)
            quantities, issued = live.totals.quantities(at), self._issued(at)
            for line, name in enumerate(_TOTALS, start=first):
                if column == 1:
                    page.text(line, 0, _ISSUED.get(name) or quantities[name].heading)
                if name not in _ISSUED:
                    known = quantities[name]
                    page.put(line, column, LiveCell(known.kind, known.value, at(name), of=known.of))
                else:
                    page.put(line, column, LiveCell("flow", issued.get(name), of="flow"))
        band = first + _TOTALS.index("band")
        self.book.colour_words(page.sheet, (band, 1), (band, len(live.conditions)), BANDS)
        flows = Sentence(
            "Flows: {spools}. {lie} {demand}",
            spools=spools_taken(self.diagnosis.profile),
            lie=AS_SPOOLS_MAY_LIE,
            demand=DEMAND,
        )
        row = page.across(first + len(_TOTALS), flows)
        return page.across(row, covers(self.diagnosis, self.say))

    def _issued(self, at: SheetCondition) -> dict[str, Any]:
        """Return how sure the band of a total is and the interval of its leakage; nothing of a unit not measured."""
        uncertainty = self.diagnosis.uncertainty
        total = uncertainty.total(at.projection.condition.name) if uncertainty else None
        if total is None:
            return {}
        low, high = (end * DM3_MIN for end in total.leakage_interval)
        return {"decision": self.say.get("decisions", total.decision.decision), "low": low, "high": high}

    def _repair(self, page: SheetPage, row: int, plan: RepairPlan) -> int:
        order = Sentence("Order of repair as issued: each land is made as new after those before it")
        if plan.cost:
            order = Sentence(
                "Order of repair as issued: each land is as its repair leaves it, or as new, after those before it"
            )
        row = page.across(row, order, bold=True)
        if plan.order:
            ends = [Sentence("total after [%], {condition}", condition=total.condition) for total in plan.ends]
            first = row + 1
            headings = [*_OF_A_STEP, *ends, Sentence("helps most at"), self.say("columns.consequence")]
            row = page.table(row, headings, map(self._step, plan.order))
            self.book.colour_words(page.sheet, (first, 2), (row - 1, 2), VERDICTS)
            self.book.colour_words(page.sheet, (first, 6), (row - 1, 6), BANDS)
            options = option_table(plan, self.say).parted
            row = page.printed(row, options) if options.rows else row
        for sentence in (*plan_ends(plan, self.say), *open_words(self.diagnosis, self.job, self.say, closing=True)):
            row = page.across(row, sentence)
        return row

    def _step(self, step: PumpStep | RepairStep) -> list[Any]:
        at, helps = step.at, self.say.condition(step.at.condition)
        component, name, land = None, step_in_words(self.diagnosis, step, self.say), None
        if isinstance(step, RepairStep):
            component, land = step.land.key
            name = self.say.name(self.diagnosis.controller.components[component])
        else:
            helps = pump_brings(at, self.say)
        return [
            component,
            Name(name),
            self.say.signed(step.verdict),
            land,
            *(LiveCell("share", total.share * PERCENT if step.helps else None) for total in (at.before, at.after)),
            self.say.level(at.after.band) if step.helps else None,
            *(LiveCell("share", each.after.share * PERCENT) for each in step.conditions),
            helps if step.helps else no_help(step, self.say),
            step_consequence(self.diagnosis, step, self.say),
        ]

    # --- matrix

    def write_matrix(self, sheet: Worksheet) -> None:
        """Write every land at every condition: its share of the pump's flow and the verdict of that share."""
        live, say, names = self.live, self.say, self.diagnosis.controller.components
        left = {"align": "left"}

        def share_value(number: int, row: MatrixRow) -> float:
            return row.cells[number].share

        def share(at: SheetCondition, row: MatrixRow, _: LiveCells) -> str:
            return live.sheet.cell(live.row_of[row.land.key], ("share", at.prefix))

        def verdict(number: int, row: MatrixRow) -> str | None:
            judged = row.cells[number]
            return None if judged.rule is None or judged.verdict is None else say.signed(judged.verdict)

        def verdict_formula(number: int, row: MatrixRow, _: LiveCells) -> str | None:
            rule = row.cells[number].rule
            return None if rule is None else live.rules.verdict(row.land, rule)

        width = component_width(names)
        # fmt: off
        columns = [
            LiveColumn("component", Sentence("component"), value=lambda row: row.land.key[0], width=width, look=left),
            LiveColumn("name", Sentence("name"), value=lambda row: Name(names[row.land.key[0]]), width=28, look=left),
            LiveColumn("land", Sentence("land"), value=lambda row: row.land.key[1], width=7, look=left),
        ]
        for number, at in enumerate(live.conditions):
            heading = Sentence("share of pump capacity [%], {condition}", condition=at.label)
            columns.append(LiveColumn(("share", at.prefix), heading, "share", partial(share_value, number),
                                      partial(share, at), PERCENT, 16))
            heading = Sentence("verdict of the share, {condition}", condition=at.label)
            columns.append(LiveColumn(("verdict", at.prefix), heading, "plain", partial(verdict, number),
                                      partial(verdict_formula, number), width=16, look=AFTER_A_NUMBER))
        columns.append(LiveColumn("elsewhere", Sentence("elsewhere, as issued"), width=44,
                                  value=lambda row: row.elsewhere or None))
        # fmt: on
        rows = condition_matrix(self.diagnosis, [at.projection for at in live.conditions])
        LiveSheet(sheet.get_name(), columns, rows).write(self.book, sheet)
        self.book.colour_words(sheet, (1, 4), (len(rows), len(columns) - 2), VERDICTS)

    # --- job, messages, provenance

    def write_job(self, sheet: Worksheet) -> None:
        """Write the job record: only what was filled in."""
        row, page = 0, SheetPage(self.book, sheet, (24, 90))
        for name in type(self.job).model_fields:
            value = getattr(self.job, name)
            if value in (None, "", ()) or (isinstance(value, Record) and value.empty):
                continue
            for item in value if isinstance(value, tuple) else (value,):
                if isinstance(item, Record):
                    page.headings(row, [self._field(name)])
                    row = page.pairs(row + 1, self._pairs(item)) + 1
                else:
                    row = page.pairs(row, [(self._field(name), self._plain(name, item))])

    def write_messages(self, sheet: Worksheet) -> None:
        """Write what is to be known about the result, warnings among it."""
        headings = [Sentence("level"), Sentence("code"), Sentence("text"), Sentence("place")]
        rows = (
            [_LEVELS[each.level], each.code, each.text, each.place.sentence if each.place else None]
            for each in self.diagnosis.messages
        )
        SheetPage(self.book, sheet, (11, 34, 110, 40)).table(0, headings, rows)

    def write_provenance(self, sheet: Worksheet) -> None:
        """Write which program, options and files gave the result, with their SHA-256."""
        record = self.record
        page = SheetPage(self.book, sheet, (24, 100))
        row = page.pairs(0, [("atleak", record["atleak"]), (Sentence("format"), record["format"])]) + 1
        entries = {name: record[name] for name in ("profile", "controller", "fluid", "limits", "readings")}
        if self.diagnosis.log is not None:
            test = self.diagnosis.log.road_test
            entries["road_test"] = named_record(test, "file", "sha256", "rows", "duration_s")
        for name, entry in entries.items():
            page.headings(row, [self._field(name)])
            wanted = {key: value for key, value in entry.items() if isinstance(value, str | int | float | bool | list)}
            said = self._of_profile if name == "profile" else self._of_catalogue
            pairs = [(self._field(key), said(key, value)) for key, value in wanted.items()]
            row = page.pairs(row + 1, pairs) + 1

    def _pairs(self, record: Record) -> list[tuple[str, Any]]:
        fields = ((name, getattr(record, name)) for name in type(record).model_fields)
        return [(self._field(name), self._plain(name, value)) for name, value in fields]

    def _field(self, name: str) -> str:
        """Return a field's name as people read it: ``mileage_km`` → ``mileage [km]``."""
        return self.say(f"record_fields.{name}") if name in self.say.table("record_fields") else name

    def _of_profile(self, name: str, value: Any) -> Any:
        if not isinstance(value, str):
            return value
        return self.say.get("profile_names", value) if name == "name" else option_value(name, value, self.say)

    def _of_catalogue(self, name: str, value: Any) -> Any:
        """Return what is known of an entry of the catalogue, in the reader's language where its words are known."""
        if name == "state":
            return self.say.get("fluid_data", value)
        return Name(value) if name in _WORDED else self._plain(name, value)

    def _plain(self, name: str, value: Any) -> Any:
        if isinstance(value, list | tuple):
            return ", ".join(map(str, value))
        kind = next((kind for end, kind in _KINDS.items() if name.endswith(end)), None)
        if kind is not None and isinstance(value, int | float):
            return self.say.system[kind].stated(value)
        if name in ("grade", "decision") and isinstance(value, str):
            return self.say.get("grades" if name == "grade" else "job_decisions", value)
        return value if value is None or isinstance(value, bool | int | float | str | dt.date) else str(value)


def write_what_was_read(book: ReportBook, sheet: Worksheet, sheets: Sequence[SheetCells]) -> None:
    """Write the file's own tables as they stand, each cell in the colour of what it became, and the reasons beside."""
    form = {
        kind: book.form(bg_color=cell_colour(kind, on_screen=False), align="left", text_wrap=kind is CellKind.HEADING)
        for kind in KIND_WORDS
    }
    line = 0
    for kind in kinds_in(sheets):
        book.put(sheet, line, 1, KIND_WORDS[kind], form[kind])
        line += 1
    widths = {0: _NARROWEST, 1: 2 * _WIDEST}
    for each in sheets:
        columns = range(max(map(len, each.rows), default=0))
        said = [column_said(each, column, book.say) for column in columns]
        line += 1
        if each.name is not None:
            book.put(sheet, line, 1, each.name, book.bold)
        headings = [Sentence("row"), WHAT_BECAME, *map(column_letter, columns)]
        book.headings(sheet, line + 1, headings, [_NARROWEST, 2 * _WIDEST, *[_NARROWEST] * len(columns)])
        sheet.set_row(line + 2, 15.0 * max((1 + len(words) // _NARROWEST for words in said), default=1))
        for column, words in enumerate(said):
            book.put(sheet, line + 2, column + 2, words, book.wrapped)
        line += 3
        for row, cells in enumerate(each.rows):
            of_row = row_said(each, row, book.say)
            book.put(sheet, line, 0, each.numbers[row], book.form(align="left"))
            book.put(sheet, line, 1, of_row, book.wrapped)
            for column, (cell_of, meaning) in enumerate(zip(cells, each.meanings[row], strict=True), 2):
                if cell_of != "":
                    book.put(sheet, line, column, as_written(cell_of), form[meaning.kind] if meaning else book.form())
                    widths[column] = min(max(widths.get(column, _NARROWEST), len(str(cell_of)) + 2), _WIDEST)
                if meaning is not None and meaning.kind in (CellKind.ASIDE, CellKind.REFUSED):
                    why = meaning_said(meaning, book.say)
                    if why not in (of_row, said[column - 2]):
                        sheet.write_comment(line, column, why)
            line += 1
    for column, width in widths.items():
        sheet.set_column(column, column, width)
    book.for_screen(sheet, line + 1, max(widths) + 1)

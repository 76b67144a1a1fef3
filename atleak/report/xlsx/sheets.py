"""Write the sheets around the computation: summary, road test, job, messages, provenance."""

from __future__ import annotations

from typing import Any

from xlsxwriter.format import Format
from xlsxwriter.worksheet import Worksheet

from atleak.diagnosis import Diagnosis
from atleak.errors import MessageLevel
from atleak.job.record import Job, Record
from atleak.repair import RepairPlan, RepairStep, plan_repairs
from atleak.report.estimate_words import open_words
from atleak.report.xlsx.book import Book, cell, formula
from atleak.report.xlsx.conditions_sheet import AS_SPOOLS_MAY_LIE, DEMAND, covers
from atleak.report.xlsx.flagged_lands import OF_A_LAND, FlaggedLands
from atleak.report.xlsx.headline import Headline
from atleak.report.xlsx.live import LiveSheets
from atleak.report.xlsx.live_cells import (
    AFTER_A_NUMBER,
    RANKED,
    SheetCondition,
    component_width,
    verdict_of_rank,
)
from atleak.report.xlsx.road_sheet import RoadSheets
from atleak.sentence import Name, Sentence
from atleak.verdicts import BANDS, VERDICTS, Verdict
from atleak.views.caveats import caveat_marks, caveats
from atleak.views.condition_matrix import condition_matrix
from atleak.views.first_sentence import first_sentence
from atleak.views.measure_first import head, measure_first, reason
from atleak.views.positions import spools_taken
from atleak.views.repair_options import option_rows
from atleak.views.repair_words import no_help, plan_ends
from atleak.views.sentences import fluid_in_state, measuring_temperature
from atleak.workshop_units import DM3_MIN, PERCENT

#: columns of the summary's totals: quantities of the sheet of conditions, and among them what follows no number
_TOTALS = (
    "band", "decision", "leakage", "low", "high", "leakage_new", "growth", "share", "share_new", "share_concentric",
    "share_touching", "capacity", "n_min", "reserve", "reserve_new", "p_g", "p_g_held", "T", "n",
)  # fmt: skip
_ISSUED = {
    "decision": Sentence("decision as issued"),
    "low": Sentence("leakage, low as issued [dm³/min]"),
    "high": Sentence("leakage, high as issued [dm³/min]"),
}
_OF_AN_OPTION = (
    Sentence("step"),
    Sentence("repair"),
    Sentence("use"),
    Sentence("id"),
    Sentence("price"),
    Sentence("currency"),
    Sentence("hours"),
    Sentence("tool"),
    Sentence("lands"),
    Sentence("source"),
)
_HOW_TO_CHANGE = (
    Sentence("Blue cells may be changed: everything in black follows from them."),
    Sentence(
        "What is marked “as issued” is atleak's result and does not follow; nor do the sheets of the road test, of "
        "gauge readings, of the estimate, of the job and its messages."
    ),
    Sentence(
        "All sheets are protected against slips, without a password: only blue cells take a change. Who wants to "
        "change more unprotects the sheet (Review, Unprotect Sheet)."
    ),
)
_LEVELS: dict[MessageLevel, Sentence] = {"info": Sentence("info"), "warning": Sentence("warning")}
_SENTENCE = 9  # last column of a long sentence
MEASURE_FIRST = 6  # lands named for a complaint


class Sheets:
    """The sheets around those that compute."""

    def __init__(self, book: Book, diagnosis: Diagnosis, record: dict[str, Any], job: Job, live: LiveSheets) -> None:
        self.book, self.diagnosis, self.record, self.job, self.live = book, diagnosis, record, job, live
        self.say = book.say
        shown = dict.fromkeys(rule.verdict for rule in (*diagnosis.gauge_rules, *diagnosis.log_rules))
        issued = "".join(f",{1 + RANKED.index(verdict)}" for verdict in shown)
        self.headline = Headline(diagnosis, live, f"MAX({live.rules.ranks}{issued})", self.say)

    # --- summary

    def write_summary(self, sheet: Worksheet) -> None:
        """Write the verdict first, then totals, flagged lands and the order of repair."""
        book, record, diagnosis = self.book, self.record, self.diagnosis
        for column, width in enumerate((46, 28, 16)):
            sheet.set_column(column, column, width)
        sheet.set_column(3, len(_TOTALS), 14)
        title = self.say("title.report")
        self.book.put(
            sheet, 0, 0, f"{self.job.workshop.name}: {title}" if self.job.workshop.name else title, book.title
        )
        sheet.set_row(0, 24)
        self._verdict(sheet, 1)
        vehicle, box = self.job.vehicle, self.job.transmission
        rows: list[tuple[str, Any]] = [
            (Sentence("job"), self.job.number),
            (Sentence("date"), self.say.date(self.job.date) if self.job.date else None),
            (Sentence("customer"), self.job.customer.name),
            (Sentence("vehicle"), " ".join(filter(None, (vehicle.make, vehicle.model, vehicle.registration)))),
            (Sentence("VIN"), vehicle.vin),
            (Sentence("transmission"), " ".join(filter(None, (box.maker, box.code, box.serial)))),
            (Sentence("mileage [km]"), record["mileage_km"] or vehicle.mileage_km),
            (Sentence("valve body"), Name(record["controller"]["name"])),
            (Sentence("fluid"), fluid_in_state(diagnosis, self.say)),
            (Sentence("limits"), Name(record["limits"]["name"])),
            (Sentence("profile"), diagnosis.profile.label),
            (Sentence("measuring sheet"), record["readings"]["file"]),
            (Sentence("measured at"), measuring_temperature(diagnosis, self.say)),
            (Sentence("road test"), diagnosis.log.road_test.file if diagnosis.log else None),
            (Sentence("gauge readings"), diagnosis.pressures.table.file if diagnosis.pressures else None),
            (Sentence("representative"), record["controller"]["representative_note"]),
            *self._complaint(),
        ]
        row = book.pairs(sheet, 5, rows) + 1
        if diagnosis.without_sheet:
            self.book.put(sheet, row, 0, self.say("findings.alone"))
            if diagnosis.log is not None:
                RoadSheets(book, diagnosis, diagnosis.log).write_findings(sheet, row + 1)
            return
        row = self._totals(sheet, row) + 1
        row = FlaggedLands(book, diagnosis, self.live, self.headline).write(sheet, row) + 1
        row = self._repair(sheet, row) + 1
        for note in _HOW_TO_CHANGE:
            self.book.put(sheet, row, 0, note)
            row += 1
        sheet.print_area(0, 0, row - 1, len(_TOTALS))  # a long text beside it would shrink the page

    def _complaint(self) -> list[tuple[str, Any]]:
        """Return the customer's complaint, where it shows and which lands to measure first."""
        diagnosis = self.diagnosis
        if diagnosis.complaint is None:
            return []
        ranked = measure_first(diagnosis)
        say = self.say
        lands = [f"{each.land.key[0]}/{each.land.key[1]}: {reason(each, say)}" for each in ranked[:MEASURE_FIRST]]
        return [
            (Sentence("complaint"), say.name(diagnosis.complaint.label)),
            (Sentence("shows at"), "; ".join(say.condition(each.condition) for each in diagnosis.complained)),
            (Sentence("lands behind it, as issued"), head(ranked, say)),
            *((f"{number}.", land) for number, land in enumerate(lands, start=1)),
        ]

    def _verdict(self, sheet: Worksheet, row: int) -> None:
        """Write the verdict of the unit as it follows from the workbook's rules, and below it the one issued."""
        book, diagnosis = self.book, self.diagnosis
        self.book.put(sheet, row, 0, Sentence("verdict of the unit"), book.bold)
        if diagnosis.judged:  # half a pair is never called ok
            fine = Verdict.OK if any(land.state.can_be_ok for land in diagnosis.lands) else Verdict.NOT_MEASURED
            verdict = verdict_of_rank(self.headline.rank, self.say, fine)
            formula(sheet, row, 1, verdict, self.say.signed(diagnosis.verdict), book.bold)
        else:
            self.book.put(sheet, row, 1, self.say.signed(diagnosis.verdict), book.bold)
        book.colour_words(sheet, (row, 1), (row, 1), VERDICTS)
        said = f"{self.say.signed(diagnosis.verdict)}: {first_sentence(diagnosis, self.say)}"
        marks = caveat_marks(diagnosis, self.say)
        marked = [f"{', '.join(marks).capitalize()}."] if marks else []
        if diagnosis.judged:
            book.put(sheet, row + 1, 0, Sentence("by the numbers of this workbook"), book.bold)
            wrapped = self._wide(sheet, row + 1, self.headline.issued)
            formula(sheet, row + 1, 1, self.headline.formula(cell(row, 1)), self.headline.issued, wrapped)
        book.put(sheet, row + 2, 0, Sentence("as issued"), book.bold)
        issued = " ".join([*marked, said, *caveats(diagnosis, self.say)])
        book.put(sheet, row + 2, 1, issued, self._wide(sheet, row + 2, issued))

    def _wide(self, sheet: Worksheet, row: int, text: str) -> Format:
        """Make room for a long sentence beside its label, over several columns and lines; return its format."""
        wrapped = self.book.wrapped
        sheet.merge_range(row, 1, row, _SENTENCE, "", wrapped)
        sheet.set_row(row, 15.0 * (1 + len(text) // (_SENTENCE * 14)))
        return wrapped

    def _totals(self, sheet: Worksheet, row: int) -> int:
        """Write each condition's total beside the same unit new, how sure its band is, and as the spools may lie."""
        book, live = self.book, self.live
        left, first = {"align": "left"}, row + 1
        for row, at in enumerate(live.conditions, start=first):
            quantities, issued = live.totals.quantities(at), self._issued(at)
            if row == first:
                headings = [_ISSUED.get(name) or quantities[name].heading for name in _TOTALS]
                book.headings(sheet, first - 1, [self.say("printed.condition"), *headings], lines=5)
            worst = at.projection is self.diagnosis.worst and len(live.conditions) > 1
            self.book.put(
                sheet, row, 0, Sentence("{condition}; the worst, as issued", condition=at.label) if worst else at.label
            )
            for column, name in enumerate(_TOTALS, start=1):
                if name in _ISSUED:
                    self.book.put(sheet, row, column, issued.get(name), book.form("flow", **left))
                else:
                    now = quantities[name]
                    formula(sheet, row, column, at(name), now.value, book.form(now.kind, **left))
        book.colour_words(sheet, (first, 1), (row, 1), BANDS)
        flows = Sentence(
            "Flows: {spools}. {lie} {demand}",
            spools=spools_taken(self.diagnosis.profile),
            lie=AS_SPOOLS_MAY_LIE,
            demand=DEMAND,
        )
        self.book.put(sheet, row + 1, 0, flows)
        self.book.put(sheet, row + 2, 0, covers(self.diagnosis, self.say))
        return row + 3

    def _issued(self, at: SheetCondition) -> dict[str, Any]:
        """Return how sure the band of a total is and the interval of its leakage; nothing of a unit not measured."""
        uncertainty = self.diagnosis.uncertainty
        total = uncertainty.total(at.projection.condition.name) if uncertainty else None
        if total is None:
            return {}
        low, high = (end * DM3_MIN for end in total.leakage_interval)
        return {"decision": self.say.get("decisions", total.decision.decision), "low": low, "high": high}

    def _repair(self, sheet: Worksheet, row: int) -> int:
        plan, book = plan_repairs(self.diagnosis), self.book
        order = Sentence("Order of repair as issued: each land is made as new after those before it")
        if plan.cost:
            order = Sentence(
                "Order of repair as issued: each land is as its repair leaves it, or as new, after those before it"
            )
        book.put(sheet, row, 0, order, book.bold)
        row += 1
        if plan.steps:
            names = [*OF_A_LAND, Sentence("total before [%]"), Sentence("total after [%]"), Sentence("band after")]
            names += [Sentence("total after [%], {condition}", condition=total.condition) for total in plan.ends]
            names.append(Sentence("helps most at"))
            book.headings(sheet, row, names, lines=3)
            first = row + 1
            for row, step in enumerate(plan.steps, start=first):
                self._step(sheet, row, step)
            book.colour_words(sheet, (first, 2), (row, 2), VERDICTS)
            book.colour_words(sheet, (first, 6), (row, 6), BANDS)
            row = self._options(sheet, row + 1, plan)
        for sentence in (
            *plan_ends(plan, self.say),
            *open_words(self.diagnosis, self.job, self.say, closing=True),
        ):
            self.book.put(sheet, row, 0, sentence)
            row += 1
        return row

    def _options(self, sheet: Worksheet, row: int, plan: RepairPlan) -> int:
        """Write the repairs that the valve body's file names for the plan's lands; return the next free row."""
        rows, book, say = option_rows(plan), self.book, self.say
        if not rows:
            return row
        leaves = Sentence("leaves [{unit}]", unit=say.unit("clearance"))
        book.headings(sheet, row, [*_OF_AN_OPTION[:4], leaves, *_OF_AN_OPTION[4:]])
        for at, each in enumerate(rows, start=row + 1):
            repair = each.option.repair
            values: list[Any] = [each.number, each.name(say), each.use(say), repair.id, each.leaves(say), repair.price]
            values += [repair.currency, repair.hours, repair.tool, each.lands, repair.source]
            for column, value in enumerate(values):
                if value is not None:
                    self.book.put(sheet, at, column, value, book.form(align="left"))
        return row + len(rows) + 1

    def _step(self, sheet: Worksheet, row: int, step: RepairStep) -> None:
        book, (component, land) = self.book, step.land.key
        words = (
            component,
            Name(self.diagnosis.controller.components[component]),
            self.say.signed(step.land.verdict),
            land,
        )
        for column, value in enumerate(words):
            self.book.put(sheet, row, column, value, book.form(align="left"))
        if step.helps:
            for column, total in enumerate((step.at.before, step.at.after), start=4):
                self.book.put(sheet, row, column, total.share * PERCENT, book.form("share", align="left"))
            self.book.put(sheet, row, 6, self.say.level(step.at.after.band))
        for column, each in enumerate(step.conditions, start=7):
            self.book.put(sheet, row, column, each.after.share * PERCENT, book.form("share", align="left"))
        self.book.put(
            sheet,
            row,
            7 + len(step.conditions),
            self.say.condition(step.at.condition) if step.helps else no_help(step, self.say),
        )

    # --- matrix

    def write_matrix(self, sheet: Worksheet) -> None:
        """Write every land at every condition: its share of the pump's flow and the verdict of that share."""
        book, live = self.book, self.live
        names = [Sentence("component"), Sentence("name"), Sentence("land")]
        for at in live.conditions:
            names.append(Sentence("share of pump capacity [%], {condition}", condition=at.label))
            names.append(Sentence("verdict of the share, {condition}", condition=at.label))
        book.headings(sheet, 0, [*names, Sentence("elsewhere, as issued")], lines=4)
        rows = condition_matrix(self.diagnosis, [at.projection for at in live.conditions])
        for row, each in enumerate(rows, start=1):
            (component, number), place = each.land.key, live.row_of[each.land.key]
            for column, value in enumerate((component, Name(self.diagnosis.controller.components[component]), number)):
                self.book.put(sheet, row, column, value, book.form(align="left"))
            for column, (at, judged) in enumerate(zip(live.conditions, each.cells, strict=True)):
                share = cell(place, live.column_of["share", at.prefix], live.sheet)
                formula(sheet, row, 3 + 2 * column, share, judged.share * PERCENT, book.form("share"))
                if judged.rule is not None and judged.verdict is not None:
                    verdict = live.rules.verdict(each.land, judged.rule)
                    formula(
                        sheet,
                        row,
                        4 + 2 * column,
                        verdict,
                        self.say.signed(judged.verdict),
                        book.form(**AFTER_A_NUMBER),
                    )
            self.book.put(sheet, row, len(names), each.elsewhere or None)
        book.colour_words(sheet, (1, 4), (len(rows), len(names) - 1), VERDICTS)
        sheet.set_column(0, 0, component_width(self.diagnosis.controller.components))
        sheet.set_column(1, 1, 28)
        sheet.set_column(2, 2, 7)
        sheet.set_column(3, len(names) - 1, 16)
        sheet.set_column(len(names), len(names), 44)
        sheet.autofilter(0, 0, len(rows), len(names))

    # --- job, messages, provenance

    def write_job(self, sheet: Worksheet) -> None:
        """Write the job record: only what was filled in."""
        sheet.set_column(0, 0, 24)
        sheet.set_column(1, 1, 90)
        row = 0
        for name in type(self.job).model_fields:
            value = getattr(self.job, name)
            if value in (None, "", ()) or (isinstance(value, Record) and value.empty):
                continue
            if isinstance(value, Record):
                self.book.put(sheet, row, 0, self._field(name), self.book.heading)
                row = self.book.pairs(sheet, row + 1, self._pairs(value), 84) + 1
            elif isinstance(value, tuple):
                for item in value:
                    self.book.put(sheet, row, 0, self._field(name), self.book.heading)
                    if isinstance(item, Record):
                        row = self.book.pairs(sheet, row + 1, self._pairs(item), 84) + 1
                    else:
                        self.book.put(sheet, row, 1, item, self.book.wrapped)
                        row += 1
            else:
                self.book.put(sheet, row, 0, self._field(name), self.book.heading)
                row = self.book.put_text(sheet, row, 1, str(value), self.book.wrapped, 84) + 2

    def write_messages(self, sheet: Worksheet) -> None:
        """Write what is to be known about the result, warnings among it."""
        book, say = self.book, self.say
        for column, width in enumerate((10, 30, 110, 40)):
            sheet.set_column(column, column, width)
        headings = [Sentence("level"), Sentence("code"), Sentence("text"), Sentence("place")]
        book.headings(sheet, 0, headings, lines=1)
        for line, message in enumerate(self.diagnosis.messages, start=1):
            place = say.sentence(message.place.sentence) if message.place else ""
            for column, value in ((0, _LEVELS[message.level]), (1, message.code), (3, place)):
                book.put(sheet, line, column, value, book.wrapped)
            book.put_text(sheet, line, 2, message.text, book.wrapped, 100)

    def write_provenance(self, sheet: Worksheet) -> None:
        """Write which program, options and files gave the result, with their SHA-256."""
        record = self.record
        row = self.book.pairs(sheet, 0, [("atleak", record["atleak"]), (Sentence("format"), str(record["format"]))]) + 1
        entries = {name: record[name] for name in ("profile", "controller", "fluid", "limits", "readings")}
        if self.diagnosis.log is not None:
            test = self.diagnosis.log.road_test
            entries["road_test"] = {
                "file": test.file,
                "sha256": test.sha256,
                "rows": test.rows,
                "duration_s": test.duration,
            }
        for name, entry in entries.items():
            self.book.put(sheet, row, 0, self._field(name), self.book.heading)
            wanted = {key: value for key, value in entry.items() if isinstance(value, str | int | float | bool | list)}
            pairs = [(self._field(key), self._plain(key, value)) for key, value in wanted.items()]
            row = self.book.pairs(sheet, row + 1, pairs, 94) + 1
        sheet.set_column(0, 0, 24)
        sheet.set_column(1, 1, 100)

    def _pairs(self, record: Record) -> list[tuple[str, Any]]:
        fields = ((name, getattr(record, name)) for name in type(record).model_fields)
        return [(self._field(name), self._plain(name, value)) for name, value in fields]

    def _field(self, name: str) -> str:
        """Return a field's name as people read it: ``mileage_km`` → ``mileage [km]``."""
        return self.say.get("record_fields", name)

    def _plain(self, name: str, value: Any) -> Any:
        if isinstance(value, list | tuple):
            return ", ".join(map(str, value))
        if name in ("grade", "decision") and isinstance(value, str):
            return self.say.get("grades" if name == "grade" else "job_decisions", value)
        return value if value is None or isinstance(value, bool | int | float | str) else str(value)

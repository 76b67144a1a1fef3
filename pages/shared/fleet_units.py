"""List the units of a fleet, the worst first, and go down to one: its own job, or what the results hold of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.common.verdicts import Verdict, level_named
from atleak.common.wording import Wording
from atleak.diagnosis.uncertainty import DECISIONS
from atleak.fleet.folder import KnownFolder
from atleak.fleet.results import Results
from atleak.fleet.sources import KeptUnit, SourceRow, kept_unit
from atleak.fleet.summary_tables import FleetTables
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.sums import GROUP, SummedUnit
from atleak.fleet.units import BOOK
from atleak.report.tables.table import VERDICT, Column, Table
from pages.shared import fields, reader, show
from pages.shared.book import open_from_book, show_unit
from pages.shared.fleet import heading_words, reads
from pages.shared.state import way_back

_OPENED = "fleet-opened"  # set where the last click opened a job
_NONE = "\0"  # stands among groups for the units that state none
_FAULT = "fleet-unit-fault"  # reference of the unit that could not be opened, and why
_UNIT_COLUMNS = (
    *("verdict", "name", "group", "mileage", "decided_by", "lands_past", "lands_measured", "share_max"),
    *("number", "serial", "vin", "date", "body", "visits"),
)
_IF_STATED = ("group", "number", "serial", "vin", "date")


# --- the list


@dataclass(frozen=True)
class _Asked:
    """What units are looked for."""

    text: str = ""
    verdict: str = ""
    controller: str = ""
    group: str | None = None  # None: of any; "" states none

    def fits(self, unit: SummedUnit, label: str | None) -> bool:
        said = (unit.name, unit.number, unit.vin, unit.serial, unit.label, unit.group)
        within = " ".join(filter(None, said)).casefold()
        return (
            all(word in within for word in self.text.casefold().split())
            and self.verdict in ("", unit.verdict)
            and self.controller in ("", unit.controller)
            and self.group in (None, label or "")
        )


def choose(words: FleetWords) -> SummedUnit | None:
    """Show the units that are asked for, the worst first, page by page; return the one that is picked."""
    say, units = words.say, words.summary.worst
    label: Callable[[SummedUnit], str | None] = attrgetter("group" if words.summary.by is None else "label")
    asked = _asked(words, label)
    found = [unit for unit in units if asked.fits(unit, label(unit))]
    if not found:
        st.info(say("fleet.no_unit_fits"))
        return None
    names = [unit.name for unit in units]
    folder = _folder_of(os.path.commonprefix([min(names), max(names)]))  # noqa: RUF071  a row of a table has no path
    listed, key = _listed(words, label), f"fleet-units-{words.summary.folder}-{words.summary.by}-{asked}"

    def rows_from(first: int) -> Table:
        rows = [replace(unit, name=unit.name[len(folder) :]) for unit in found[first : first + show.PAGE]]
        return replace(listed, rows=rows, title="")

    picked = show.paged(len(found), rows_from, key, "single-row")
    said = [say("fleet.listed", count=say.number(len(found), 0), all=say.number(len(units), 0))]
    said += [say("fleet.folder", folder=show.plain(folder))] if folder else []
    st.caption(" ".join(said))
    return next((unit for unit in found for row in picked if unit.reference == row.reference), None)


def _folder_of(name: str) -> str:
    return name[: max(name.rfind("/"), name.rfind("\\")) + 1]


def _asked(words: FleetWords, label: Callable[[SummedUnit], str | None]) -> _Asked:
    say, summary = words.say, words.summary
    text = st.text_input(say("job_book.look_up"), **fields.kept("fleet-text", ""), placeholder=say("fleet.look_up_by"))
    verdicts = {str(each): say.signed(each) for each in reversed(Verdict) if summary.counts.verdicts[each]}
    labels = {label(unit) for unit in summary.worst}
    groups = {each: each for each in sorted(filter(None, labels))}
    if groups and not all(labels):
        groups[_NONE] = say("fleet.states_none")
    narrowed = []
    for place, what, options in zip(
        st.columns(3),
        (say("columns.verdict"), say("columns.controller"), heading_words(summary.by or GROUP, say)),
        (verdicts, {body.controller: words.body(body.controller) for body in summary.bodies}, groups),
        strict=True,
    ):
        names = {"": say("job_book.any"), **options}
        key = f"fleet-asked-{(summary.folder, what)}-{say.language}-{hash(tuple(names))}"
        kept = {"persist_state": "session", "disabled": len(names) < 2}  # over other pages
        narrowed.append(fields.one_of(what, names, key, place=place, **kept))
    verdict, controller, group = narrowed
    return _Asked(text, verdict, controller, None if not group else "" if group == _NONE else group)


def _listed(words: FleetWords, label: Callable[[SummedUnit], str | None]) -> Table:
    """Return the table of all units, without the columns of what none of them states."""
    say, units = words.say, words.summary.worst
    table = FleetTables(words).units(label).parted
    renamed = {"name": say("fleet.unit"), "group": heading_words(words.summary.by or GROUP, say)}
    taken = {column.heading(say) for column in table.columns if column.key != "group"} | {renamed["name"]}
    if renamed["group"] in taken:  # a table of units may have any heading
        renamed["group"] = f"{say('fleet.group')}: {renamed['group']}"
    columns = [replace(column, words=renamed.get(column.key, column.words)) for column in table.columns]
    shown = [key for key in _UNIT_COLUMNS if key != "body" or len(words.summary.bodies) > 1]
    shown = [key for key in shown if key != "visits" or any(unit.visits > 1 for unit in units)]
    table = replace(table, columns=tuple(columns)).only(*shown)
    filled = {column.key for column in table.filled.columns}
    return table.without(*(key for key in _IF_STATED if key not in filled))


# --- one unit


def opened() -> bool:
    """Tell whether the last click opened the own job of a unit."""
    return bool(st.session_state.pop(_OPENED, False))


def draw(folder: KnownFolder, unit: SummedUnit, words: FleetWords) -> None:
    """Show what the results hold of a unit, and offer its own job."""
    say = words.say
    kept = _kept(str(folder.path), reads(folder), unit.input_sha256)
    with st.container(border=True):
        decision = kept.unit["decision"]
        said = [unit.name, say.signed(unit.verdict)] + [say.get("decisions", decision)] * (decision in DECISIONS)
        said += [say("fleet.provisional")] if kept.unit["provisional"] else []
        st.markdown(" · ".join([f"**{show.plain(said[0])}**", *map(show.plain, said[1:])]))
        tip = say("fleet.open_help")
        st.button(say("fleet.open"), "fleet-open", tip, _open, (kept, folder), type="primary")
        reference, fault = st.session_state.get(_FAULT, ("", None))
        if fault is not None and reference == unit.reference:
            st.error(f"**{say('fleet.not_opened')}** {show.plain(fault)}\n\n{say('fleet.still_held')}")
        st.markdown(_facts(kept, unit, words))
        st.caption(say("fleet.as_evaluated", when=f"{kept.unit['evaluated_at']:%Y-%m-%d %H:%M}"))
        for table in (_lands(kept, unit, words), _conditions(kept, say)):
            if table.rows:
                show.table(table, empty=True)


@st.cache_resource(max_entries=8, show_spinner=False)
def _kept(folder: str, state: str, sha256: str) -> KeptUnit:
    return kept_unit(Results.open(folder), sha256)


def _facts(kept: KeptUnit, unit: SummedUnit, words: FleetWords) -> str:
    say, row = words.say, kept.unit
    measured = say("panel.lands_measured", measured=row["lands_measured"] or 0, lands=row["lands_total"] or 0)
    facts = {
        say("columns.controller"): words.body(unit.controller),
        say("columns.number"): unit.number,
        say("columns.serial"): unit.serial,
        say("columns.vin"): unit.vin,
        say("columns.mileage"): None if unit.mileage_km is None else say.quantity(unit.mileage_km, "distance"),
        say("columns.date"): say.date(unit.date) if unit.date else None,
        say("fleet.group"): unit.group,
        **dict(row["labels"] or ()),
        say("columns.decided_by"): words.decided_by(unit),
    }
    lines = [f"{show.plain(name)}: **{show.plain(value)}**" for name, value in facts.items() if value]
    return " · ".join([*lines, measured])


def _lands(kept: KeptUnit, unit: SummedUnit, words: FleetWords) -> Table:
    return _of_rows(
        kept.lands,
        "verdict",
        Column("pair", width=150, of=lambda row: words.land(unit.controller, (row["component"], row["land"]))),
        Column("clearance", "clearance", of="radial_clearance_um"),
        Column("uncertainty", "clearance", of="uncertainty_um"),
        Column("wear", "percent", of="wear_percent"),
        Column("share", "percent", of="share_percent"),
        Column("leakage", "leak", of="leakage_dm3_min"),
    )


def _conditions(kept: KeptUnit, say: Wording) -> Table:
    return _of_rows(
        kept.conditions,
        "band",
        Column("condition", width=190, of=lambda row: say.name(row["label"] or row["name"])),
        Column("share", "percent", of="share_percent"),
        Column("leakage", "flow", of="leakage_dm3_min"),
        Column("held", "pressure", of="p_g_held_kpa"),
        Column("required", "pressure", of="p_g_kpa"),
        Column("reserve", digits=2),
    )


def _of_rows(rows: Sequence[SourceRow], level: str, *columns: Column) -> Table:
    """Return rows of the results with the verdict before their columns, and how sure it is behind them."""
    say = reader.say()
    verdict = Column("verdict", VERDICT, width=92, of=lambda row: level_named(row[level]) if row[level] else None)
    sure = Column("decision", of=lambda row: say.get("decisions", row["decision"]) if row["decision"] else None)
    return Table("", (verdict, *columns, sure), rows, say)


def _open(kept: KeptUnit, folder: KnownFolder) -> None:
    """Open a unit's own job in this session, or keep why that is not possible; for a callback."""
    row = kept.unit
    st.session_state.pop(_FAULT, None)
    name = row["number"] or row["name"][len(_folder_of(row["name"])) :]

    def done(say: Wording) -> str:
        return say("done.opened", name=name)

    try:
        if row["reference"].startswith(BOOK):
            kept.opened()
            st.session_state[_OPENED] = open_from_book(row["reference"].removeprefix(BOOK), way_back(done))
        else:
            show_unit(kept, folder.id, done=done)
            st.session_state[_OPENED] = True
    except AtleakError as error:
        st.session_state[_FAULT] = row["reference"], error

"""Ask how a measuring sheet is to be read: which sheet, rows and unit, and which column is what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

import pandas as pd
import streamlit as st

from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import AtleakError, OutputError, ReadingsError
from atleak.common.units import MM, unit_names
from atleak.common.wording import Wording
from atleak.job.case import SourceFile
from atleak.measurements.readings import Readings, SheetCells
from atleak.readers.cells.sheet import column_letter
from atleak.readers.logs import NOT_LOGGED, default_path
from atleak.readers.remembered_columns import CONSTANT
from atleak.readers.sheets.mapping import (
    SheetMapping,
    diameter_role,
    diameter_said,
    names_column,
    remember_sheet,
    rows_role,
    with_row_turned,
)
from atleak.readers.sheets.measuring_sheet import SheetLook
from atleak.readers.typed_sheet import TYPED_FILE
from pages.shared import fields, reader, show, what_was_read
from pages.shared.cases import FITTED, PageCase, controller_of, readings_of, sheet_look
from pages.shared.state import choose, put_file, remember, session

AS_STATED = ""  # the unit that the sheet says
_ENDS = ("coordinate 1", "coordinate 2")
_ROLES = ("component", "plane", "part", "direction", "repeat", "value", "new", "deviation", *_ENDS)
_BY_CLICK = ("component", "plane", "part", "direction", "repeat", "value spool", "value sleeve", "value", "new")
_OF_DIAMETER = ("part", "plane", "direction", "repeat")
_DIRECTIONS, _REPEATS = ("0°", "45°", "90°", "135°"), ("1", "2", "3", "4", "5")
_TURNS = count()
_TEXTS = ("missing", "spool", "sleeve")
_SHOWN = 200  # readings of a preview
_NAMED = ("component ", "plane ", "land ")  # before the name of the one that the sheet has its own word for
_WORDS = 12  # of its own, that are asked for at a time


def pending(case: PageCase) -> SourceFile | None:
    """Return the sheet to ask about: the one refused last, else that of the job."""
    refused = session().refused.get("readings")
    return refused.file if refused is not None else case.readings


def unit_said(unit: str) -> str:
    """Return the name of a unit to choose, or that the sheet's own is taken."""
    return unit or reader.say()("sheet_form.as_stated")


def draw(case: PageCase) -> None:
    """Draw the form where the job has a sheet, or one was refused, that was not typed in here."""
    file = pending(case)
    if file is not None and file.name != TYPED_FILE:
        _form(file, case)
        _columns(file, case)


def _form(file: SourceFile, case: PageCase) -> None:
    """Ask for sheet, unit and rows: of a workbook with several sheets, no unit, or several states of one unit."""
    mine = file == case.readings
    say = reader.say()
    with st.expander(say("sheet_form.title"), expanded=not mine), st.form("sheet", border=False):
        name = st.text_input(
            say("sheet_form.sheet"), (case.sheet_name or "") if mine else "", placeholder=say("sheet_form.any_sheet")
        )
        units = [AS_STATED, *unit_names("length")]
        now = units.index(case.sheet_unit) if mine and case.sheet_unit in units else 0
        unit = st.selectbox(say("sheet_form.unit"), units, now, format_func=unit_said)
        where = case.sheet_where if mine else ()
        first, second = st.columns(2)
        chosen = where[0] if where else ("", "")
        heading = first.text_input(
            say("sheet_form.column"), chosen[0], placeholder=say("sheet_form.such_column")
        ).strip()
        value = second.text_input(say("sheet_form.says"), chosen[1], placeholder=say("sheet_form.such_value")).strip()
        fill_down = st.checkbox(say("sheet_form.fill_down"), mine and case.sheet_fill_down)
        if st.form_submit_button(show.plain(say("sheet_form.again", file=file.name))):
            put_file("readings", file)
            choose(
                sheet_name=name.strip() or None,
                sheet_unit=unit or None,
                sheet_where=((heading, value), *where[1:]) if heading else (),
                sheet_fill_down=fill_down,
            )
            st.rerun()


# --- which column is what


@dataclass
class _Draft:
    """What is said of a sheet on the page and is not used yet."""

    file: SourceFile
    case: PageCase
    mapping: dict[str, str]  # with which the widgets began
    unit: str
    stored: str  # under which the session keeps it
    sheet: str | None = None  # that is shown
    turn: int = field(default_factory=_TURNS.__next__)  # part of the widgets' keys: they begin anew after a click
    typed: dict[str, str] = field(init=False)  # the mapping as it stands in the widgets
    tried: Readings | AtleakError | None = None  # what came of it when it was read so last
    base: pd.DataFrame | None = None  # with which the table of columns began

    def __post_init__(self) -> None:
        self.typed = dict(self.mapping)

    @property
    def mine(self) -> bool:
        """Return whether the sheet is the job's, and not one that was refused."""
        return self.file == self.case.readings

    def anew(self, mapping: Mapping[str, str], tried: Readings | AtleakError | None = None) -> None:
        """Begin every widget anew with another mapping."""
        self.mapping, self.typed, self.tried = dict(mapping), dict(mapping), tried
        self.turn, self.base = next(_TURNS), None


def _columns(file: SourceFile, case: PageCase) -> None:
    """Show what was read of the file and ask which column is what; opened by itself where a sheet was refused."""
    say, mine, controller = reader.say(), file == case.readings, controller_of(case)
    refused = session().refused.get("readings")
    error = refused.error if refused is not None and refused.file == file else None
    try:
        now = readings_of(case, file) if mine else None
        look = sheet_look(file, controller, None, {})
    except AtleakError:
        return  # the file is no table at all, and was refused
    stored = f"sheet-said-{file.sha256}-{case.sheet_columns if mine else ''}"
    if stored not in st.session_state:
        likely = {} if look.understood else {**look.chosen, "header": look.header}
        likely = dict(error.offer) if isinstance(error, ReadingsError) and error.offer else likely
        unit = (case.sheet_unit or AS_STATED) if mine else AS_STATED
        st.session_state[stored] = _Draft(file, case, dict(now.columns) if now else likely, unit, stored)
    draft: _Draft = st.session_state[stored]
    draft.case = case
    wanting = not mine or error is not None
    with fields.fold(say("sheet_columns.title"), key=f"sheet-columns-{file.sha256}-{wanting}", opened=wanting) as place:
        if not place.open:
            return
        if session().unkept[0] == file.sha256:
            st.warning(say("mapping.not_kept", why=show.plain(session().unkept[1])))
        if isinstance(draft.tried, AtleakError):
            st.error(show.plain(draft.tried))
        if draft.base is not None and f"columns-{draft.turn}-header" not in st.session_state:
            draft.anew(draft.typed, draft.tried)  # back from another page, which drops what stands in widgets
        asking = any(name.startswith("value which") for name in draft.mapping)  # of which, only a person knows
        try:
            look = sheet_look(file, controller, draft.sheet, {} if asking else draft.mapping)
        except AtleakError as fault:
            st.error(show.plain(fault))
        _what_was_read(draft, look, draft.tried or error or now)
        _ask_for_columns(draft, look, draft.tried or error)


def _what_was_read(draft: _Draft, look: SheetLook, last: Readings | AtleakError | None) -> None:
    """Show the file's own table as it was read last, and let a click in it say what a row or a column is."""
    say, key = reader.say(), f"read-{draft.file.sha256}-{draft.turn}"
    if len(look.sheets) > 1:
        at = look.sheets.index(str(look.sheet))
        shown = st.selectbox(say("sheet_form.sheet"), look.sheets, at, key=f"{key}-sheet")
        if shown != look.sheet:
            draft.sheet = shown
            draft.anew(draft.typed, draft.tried)
            st.rerun()
    sheets: Sequence[SheetCells] = getattr(last, "sheets", ())
    sheet = next((each for each in sheets if each.name == look.sheet), look.cells)
    spot = what_was_read.draw(sheet, last.readings if isinstance(last, Readings) else (), f"{key}-{look.sheet}")
    turned = sheet.turned or look.header[:1].isupper()  # a row of the file is a column to a mapping
    number = None if spot.row is None or turned else sheet.numbers[spot.row]
    column = None if turned else spot.column
    row, headed, is_what = st.columns(3, vertical_alignment="bottom")
    counts = number is None or _counts(draft, sheet, number)
    row.button(
        say(f"what_was_read.{'counts_not' if counts else 'counts'}", row="…" if number is None else number),
        key=f"{key}-row", disabled=number is None, on_click=_row, args=(draft, look, sheet, number), width="stretch",
    )  # fmt: skip
    headed.button(
        say("what_was_read.headed", row="…" if number is None else number), key=f"{key}-headed",
        disabled=number is None, on_click=_header, args=(draft, look, str(number)), width="stretch",
    )  # fmt: skip
    of_column = f"{key}-is-{column}"
    is_what.selectbox(
        say("what_was_read.is", column="…" if column is None else column_letter(column)), _BY_CLICK, None, _said,
        key=of_column, disabled=column is None, on_change=_column, args=(draft, look, column, of_column),
        placeholder="–",
    )  # fmt: skip


def _counts(draft: _Draft, sheet: SheetCells, number: int) -> bool:
    try:
        return SheetMapping(draft.typed).counts(sheet.name, number)
    except AtleakError:
        return True  # what is typed is told where it is used


def _row(draft: _Draft, look: SheetLook, sheet: SheetCells, number: int) -> None:
    try:
        _say(draft, look, with_row_turned(draft.typed, sheet, number))
    except AtleakError as error:
        draft.tried = error


def _header(draft: _Draft, look: SheetLook, header: str) -> None:
    """Say where the headings stand; columns that were named stay what they are."""
    letters = {name: column_letter(index) for index, name in enumerate(look.columns)}
    mapping = {name: letters.get(text, text) if names_column(name) else text for name, text in draft.typed.items()}
    _say(draft, look, {**mapping, "header": header.strip()})


def _column(draft: _Draft, look: SheetLook, column: int, key: str) -> None:
    role = st.session_state[key]
    if role is not None:
        name = look.columns[column]
        others = {other: text for other, text in draft.typed.items() if text != name and other != role}
        _say(draft, look, {"header": look.header, **others, role: name})


def _say(draft: _Draft, look: SheetLook, mapping: Mapping[str, str]) -> None:
    """Take what a click says: at once where it is the job's own sheet, else as far as the form is filled in."""
    read, choices = _attempt(draft, look, mapping)
    if draft.mine and isinstance(read, Readings):
        remember(lambda say: say("done.sheet_read_anew", name=draft.file.name))
        _use(draft, read, choices)
    else:
        draft.anew(mapping, read)


def _attempt(
    draft: _Draft, look: SheetLook, mapping: Mapping[str, str]
) -> tuple[Readings | AtleakError, dict[str, Any]]:
    """Read the sheet so; return its readings, or why there are none, and the choices by which they are read."""
    own = {name: getattr(draft.case, name) for name in FITTED["readings"]} if draft.mine else FITTED["readings"]
    choices = {**own, "sheet_columns": tuple(mapping.items()), "sheet_unit": draft.unit or None}
    try:
        if SheetMapping(mapping) and len(look.sheets) > 1:
            choices["sheet_name"] = look.sheet
        return readings_of(replace(draft.case, **choices, remember=False), draft.file), choices
    except AtleakError as error:
        return error, choices


def _use(draft: _Draft, readings: Readings, choices: Mapping[str, Any]) -> None:
    try:
        remember_sheet(default_path(), readings, draft.unit or None)
        session().unkept = ("", "")
    except OutputError as error:
        session().unkept = (draft.file.sha256, error.problem)
    st.session_state.pop(draft.stored, None)
    put_file("readings", draft.file)
    choose(**choices)


def _said(role: str) -> str:
    """Return what a column is, in the reader's words."""
    part = diameter_said(role).get("part") if role.startswith("value") else None
    say = reader.say()
    return say(f"sheet_columns.{role.replace(' ', '_')}") if part is None else say(f"sheet_columns.value_{part}")


def _ask_for_columns(draft: _Draft, look: SheetLook, last: Readings | AtleakError | None) -> None:
    """Ask in a table, with a row for each column of the file, what it is; below, what holds for the whole sheet."""
    say, key = reader.say(), f"columns-{draft.turn}"
    titles = {name: say(f"sheet_columns.{name}") for name in ("column", "example", "is", *_OF_DIAMETER)}
    planes = {plane for land in controller_of(draft.case).lands for plane in land.planes}
    options: dict[str, dict[str, str]] = {
        "part": {_part_said(part, say): part for part in PART_WORDS},
        "plane": {plane: plane for plane in sorted(planes, key=lambda plane: (len(plane), plane))},
        "direction": {angle: angle for angle in _DIRECTIONS},
        "repeat": {number: number for number in _REPEATS},
    }
    roles = {_said(role): role for role in _ROLES}
    if draft.base is None:
        draft.base = _base(draft, look, titles, roles, options)
    config: dict[str, Any] = {titles[name]: st.column_config.TextColumn(disabled=True) for name in titles}
    config[titles["is"]] = st.column_config.MultiselectColumn(options=list(roles), width="medium")
    for name, words in options.items():
        known = list(dict.fromkeys([*words, *draft.base[titles[name]].dropna()]))
        config[titles[name]] = st.column_config.SelectboxColumn(options=known, width="small")
    table = st.container()  # above what is drawn before it: by that widget a visit is told from the last one
    typed_header = f"{key}-header"
    left, right = st.columns(2)
    left.text_input(
        say("sheet_columns.header"), look.header, key=typed_header, help=say("sheet_columns.header_help"),
        on_change=lambda: _header(draft, look, st.session_state[typed_header]),
    )  # fmt: skip
    units = [AS_STATED, *unit_names("length")]
    draft.unit = right.selectbox(
        say("sheet_form.unit"), units, units.index(draft.unit) if draft.unit in units else 0, unit_said,
        key=f"{key}-unit",
    )  # fmt: skip
    with table:
        edited = st.data_editor(
            draft.base, key=key, column_config=config, hide_index=True, width="stretch", placeholder=""
        )
    mapping, twice = _mapping(edited, look, titles, roles, options)
    draft.typed = {**_of_all_rows(draft, look, key), **_own_words(draft, last, key), **mapping}
    if mapping:
        draft.typed["header"] = look.header
    if twice:
        st.error(show.plain(twice))
    st.caption(say("sheet_columns.remembered_here"))
    left, right = st.columns(2)
    preview = left.button(say("sheet_columns.preview"), width="stretch", disabled=bool(twice))
    used = right.button(say("sheet_columns.use"), width="stretch", type="primary", disabled=bool(twice))
    if preview or used:
        read, choices = _attempt(draft, look, draft.typed)
        if used and isinstance(read, Readings):
            _use(draft, read, choices)
        else:
            draft.anew(draft.typed, read)
        st.rerun()
    if isinstance(draft.tried, Readings):
        _preview(draft.tried)


def _base(
    draft: _Draft,
    look: SheetLook,
    titles: Mapping[str, str],
    roles: Mapping[str, str],
    options: Mapping[str, Mapping[str, str]],
) -> pd.DataFrame:
    """Return the table of columns as the mapping says it."""
    named = look.chosen if any(text in look.chosen.values() for text in draft.mapping.values()) else {}
    words = {role: said for said, role in roles.items()}
    rows = []
    for index, column in enumerate(look.columns):
        of_column = [role for role, text in named.items() if text == column]
        plain_roles = {
            role if role in _ENDS else role.split(" ")[0].replace("land", "plane"): role for role in of_column
        }
        said = next((diameter_said(role) for role in of_column if role.startswith(("value", "deviation"))), {})
        letter = column_letter(index)
        row: dict[str, Any] = {
            titles["column"]: letter if column == letter else f"{letter} · {column}",
            titles["example"]: look.examples[index],
            titles["is"]: [words[role] for role in plain_roles if role in words],
        }
        for name, known in options.items():
            row[titles[name]] = next((word for word, value in known.items() if value == said.get(name)), said.get(name))
        rows.append(row)
    return pd.DataFrame(rows, columns=list(titles.values()), dtype=object)


def _mapping(
    edited: pd.DataFrame,
    look: SheetLook,
    titles: Mapping[str, str],
    roles: Mapping[str, str],
    options: Mapping[str, Mapping[str, str]],
) -> tuple[dict[str, str], str]:
    """Return what the table of columns says, and what is wrong with it: two columns that are the same."""
    mapping: dict[str, str] = {}
    twice = ""
    for column, (_, row) in zip(look.columns, edited.iterrows(), strict=True):
        of = {name: known.get(row[titles[name]], row[titles[name]]) for name, known in options.items()}
        of = {name: text for name, text in of.items() if isinstance(text, str)}
        for word in row[titles["is"]] if pd.api.types.is_list_like(row[titles["is"]]) else ():
            role = roles[word]
            name = diameter_role(of, role) if role in ("value", "deviation") else role
            if name in mapping:
                twice = reader.say()("sheet_columns.twice", first=mapping[name], second=column, what=word)
            mapping[name] = column
    return mapping, twice


def _of_all_rows(draft: _Draft, look: SheetLook, key: str) -> dict[str, str]:
    """Ask what holds for all rows of the sheet: which of them count, and its words; keep what is asked nowhere."""
    say, told, rows = reader.say(), draft.mapping, rows_role(look.sheet)
    asked = {rows: say("sheet_columns.rows"), **{name: say(f"sheet_columns.{name}") for name in _TEXTS}}
    typed: dict[str, str] = {}
    for (name, label), place in zip(asked.items(), st.columns(len(asked)), strict=True):
        held = told.get(name, told.get("rows", "") if name == rows else "")
        typed[name] = place.text_input(label, held, key=f"{key}-{name}").strip()
    left, right = st.columns(2)
    parts = [f"{CONSTANT}{part}" for part in PART_WORDS]
    constant = [told["part"]] if told.get("part") in parts else []
    part = left.selectbox(
        say("sheet_columns.all_rows_are"), parts, parts.index(constant[0]) if constant else None,
        lambda text: _part_said(text[1:], say), key=f"{key}-constant", placeholder="–",
    )  # fmt: skip
    nowhere = ("plane", "part", "direction", "repeat")
    absent = right.multiselect(
        say("sheet_columns.no_column"), nowhere, [name for name in nowhere if told.get(name) == NOT_LOGGED],
        key=f"{key}-no", format_func=_said, placeholder="–",
    )  # fmt: skip
    others = {name: text for name, text in told.items() if text.startswith(CONSTANT) and name != "part"}
    others |= {name: text for name, text in told.items() if name.startswith("rows ") and name != rows}
    others |= {"rows": told["rows"]} if "rows" in told and len(look.sheets) > 1 else {}
    typed = {name: text for name, text in typed.items() if text} | ({"part": part} if part else {})
    return {**others, **typed, **dict.fromkeys(absent, NOT_LOGGED)}


def _own_words(draft: _Draft, last: Readings | AtleakError | None, key: str) -> dict[str, str]:
    """Ask what each word of the sheet names that is not known: by the name of what it is, the word."""
    say, controller = reader.say(), controller_of(draft.case)
    said = ((*name.split(" ", 1), text) for name, text in draft.mapping.items() if name.startswith(_NAMED))
    known = {(role, word): name for role, name, word in said}
    problems = [each for each in getattr(last, "problems", (last,)) if isinstance(each, ReadingsError)]
    unknown = dict.fromkeys((each.role, str(each.value)) for each in problems if f"{each.role} " in _NAMED)
    asked = [*known, *[each for each in unknown if each not in known][:_WORDS]]
    of_role: dict[str, dict[str, str]] = {
        "component": {
            land.component: f"{land.component} · {controller.components[land.component]}" for land in controller.lands
        },
        "plane": {plane: plane for land in controller.lands for plane in land.planes},
        "land": {str(land.land): str(land.land) for land in controller.lands},
    }
    words = dict[str, str]()
    places = st.columns(3)
    for number, (role, word) in enumerate(asked):
        names = of_role[role]
        told = known.get((role, word))
        name = places[number % len(places)].selectbox(
            say(f"sheet_columns.word_of_{role}", word=show.plain(word)), list(names),
            list(names).index(told) if told in names else None, names.__getitem__,
            key=f"{key}-{role}-{word}", placeholder="–",
        )  # fmt: skip
        if name is not None:
            words[f"{role} {name}"] = word
    return words


def _part_said(part: str, say: Wording) -> str:
    return next((say.sentence(words) for name, words in PART_WORDS.items() if name == part), part)


def _preview(readings: Readings) -> None:
    say = reader.say()
    st.markdown(say("sheet_columns.read", count=len(readings.readings), unit=readings.unit))
    rows = [
        {
            say("sheet_columns.component"): one.component,
            say("sheet_columns.plane"): one.plane,
            say("sheet_columns.part"): _part_said(one.part, say),
            say("sheet_columns.direction"): None if one.direction is None else f"{one.direction:g}°",
            say("sheet_columns.repeat"): one.repeat,
            say("sheet_columns.diameter"): round(one.diameter * MM, 6),
            say("sheet_columns.place"): say.sentence(one.place),
        }
        for one in readings.readings[:_SHOWN]
    ]
    st.dataframe(pd.DataFrame(rows), hide_index=True, width="stretch", placeholder="–")
    show.messages(readings.messages, say("about.sheet"), opened=True)

"""Show the job record as a form. The record lives in the session, so that leaving the page loses nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, get_args

import pandas as pd
import streamlit as st
from pydantic import ValidationError
from streamlit.delta_generator import DeltaGenerator
from streamlit.typing import UploadedFile

from atleak.analysis.record_doubts import decision_faults
from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import PUMP
from atleak.catalogue.written_numbers import MEASURING_TEMPERATURE, PUMP_SIDE_CLEARANCE, PUMP_TIP_CLEARANCE
from atleak.common.errors import InputError
from atleak.common.pictures import printable_picture
from atleak.measurements.job_card import PICTURE_SUFFIXES, Grade, Job, Record, RepairState
from atleak.report.tables.names import component_words
from pages.shared import drop_zone, fields, reader, show
from pages.shared.state import RECORD, choose, job, job_generation, remember, session

_TABLES = ("workshop", "customer", "vehicle", "transmission")
_LINES = ("number", "technician", "revision", "replaces", "approved_by")
_NUMBERS = {
    "measuring_temperature_c": ("measuring_temperature", MEASURING_TEMPERATURE),
    "pump_side_clearance_um": ("pump_side", PUMP_SIDE_CLEARANCE),
    "pump_tip_clearance_um": ("pump_tip", PUMP_TIP_CLEARANCE),
}
_LONG = {"address", "note"}
_PARTS = {"spool": "measuring.spool", "piston": "measuring.piston", "sleeve": "measuring.bore"}  # the words of each
PICTURE_KINDS = [suffix.removeprefix(".") for suffix in PICTURE_SUFFIXES]


def draw(controller: Controller) -> Job:
    """Draw the form; return the record as it now is."""
    say, record = reader.say(), job()
    values: dict[str, Any] = {name: getattr(record, name) for name in Job.model_fields}
    with fields.fold(say("job_form.who"), key=key("fold-job"), opened=True):
        first, third, second = st.columns(4), st.columns(4), st.columns(5)  # the car before who approved what
        lines = zip(_LINES, (first[0], first[2], *second[2:]), strict=True)
        values |= {name: _line(place, name, getattr(record, name)) for name, place in lines}
        for name, place in zip(("date", "measured_on", "issued_on"), (first[1], *second[:2]), strict=True):
            own = fields.kept(key(name), getattr(record, name))
            values[name] = place.date_input(say(f"job_form.{name}"), format="YYYY-MM-DD", **own)
        for place, table in zip(third, _TABLES, strict=True):
            place.markdown(f"**{say(f'job_form.{table}')}**")
            held = getattr(record, table)
            texts = {name: _text(place, f"{table}-{name}", name, getattr(held, name)) for name in _texts(held)}
            values[table] = held.model_dump() | texts
        for name, (label, asked) in _NUMBERS.items():
            with first[3] if asked is MEASURING_TEMPERATURE else third[-1]:  # the pump is the transmission's
                place_key, start = key(label.replace("_", "-")), getattr(record, name)
                values[name] = fields.number(say(f"job_form.{label}"), asked, start, key=place_key, optional=True)
    with fields.fold(say("job_form.as_found"), key=key("fold-found")):
        values |= _as_found(record)
    with fields.fold(say("job_form.tables"), key=key("fold-tables")):
        tables, places = _tables(record, controller)
        values |= tables
    with fields.fold(say("job_form.pictures"), key=key("fold-pictures")):
        values |= _pictures(record)
    values["notes"] = st.text_area(say("job_form.notes"), **fields.kept(key("notes"), record.notes))
    end = st.container()
    try:
        changed = Job.model_validate(values).with_pictures(record.pictures)
    except ValidationError as error:  # what is at fault stays as it was, and all else is taken
        for each in error.errors(include_url=False):
            name, *where = map(str, each["loc"])
            problem = f"{' '.join((name, *where))}: {each['msg']}"
            places.get(name, end).error(show.plain(say("job_form.not_taken", problem=problem)))
            values[name] = getattr(record, name)
        changed = Job.model_validate(values).with_pictures(record.pictures)
    typed = changed.repair_decisions != record.repair_decisions
    for fault in (faults := list(decision_faults(changed, controller))):
        places["repair_decisions"].error(show.plain(say("job_form.not_taken", problem=fault) if typed else fault))
    if faults and typed:
        changed = changed.model_copy(update={"repair_decisions": record.repair_decisions})
    st.session_state[RECORD] = changed
    measured = {"measuring_temperature": changed.measuring_temperature_c, "pump_clearances": changed.pump_clearances}
    if any(getattr(session().case, name) != value for name, value in measured.items()):
        choose(**measured)
        st.rerun()  # what stands above this form was computed with what was measured before
    return changed


def draw_part(part: Callable[[Job], dict[str, Any]]) -> None:
    """Draw some fields of the record on another page, and take over what stands in them."""
    record = job()
    values = {name: getattr(record, name) for name in Job.model_fields} | part(record)
    st.session_state[RECORD] = Job.model_validate(values).with_pictures(record.pictures)


def complaint(record: Job) -> dict[str, Any]:
    """Ask for what the customer says; return the record's values."""
    label = reader.say()("job_form.complaint")
    return {"complaint": st.text_area(label, **fields.kept(key("complaint"), record.complaint))}


def scan_and_fluid(record: Job) -> dict[str, Any]:
    """Ask for fault codes and how the fluid looks; return the record's values."""
    oil = record.fluid_condition
    codes = _line(st, "fault_codes", ", ".join(record.fault_codes))
    names = _texts(oil)
    places = zip(names, st.columns(len(names)), strict=True)
    fluid = {name: _text(place, f"oil-{name}", name, getattr(oil, name), "oil_") for name, place in places}
    return {
        "fault_codes": tuple(code.strip() for code in codes.split(",") if code.strip()),
        "fluid_condition": oil.model_dump() | fluid,
    }


def _as_found(record: Job) -> dict[str, Any]:
    say, dirt = reader.say(), record.contamination
    found = complaint(record) | scan_and_fluid(record)
    grades = {each: say.get("grades", each) for each in ("", *get_args(Grade))}
    columns = st.columns(3)
    kept = {"place": columns[0], "persist_state": "session"}
    grade = fields.one_of(say("facts.contamination"), grades, key("grade"), dirt.grade or "", **kept)
    contamination = {
        "grade": grade or None,
        "particles": _text(columns[1], "particles", "particles", dirt.particles),
        "note": _text(columns[2], "dirt-note", "dirt_note", dirt.note),
    }
    return found | {"contamination": contamination}


def _choice(name: str, options: Iterable[Any], shown: Callable[[Any], str]) -> Any:
    label = reader.say()(f"job_table.{name}")
    return st.column_config.SelectboxColumn(label, options=list(options), format_func=shown)


def _tables(record: Job, controller: Controller) -> tuple[dict[str, Any], dict[str, DeltaGenerator]]:
    """Show the tables to edit; return their rows, and the place below each for what is wrong with it."""
    say = reader.say()

    def decided(each: Any) -> str:
        return say.get("job_decisions", str(each))

    shared = {
        "component": _choice(
            "component",
            dict.fromkeys(("", *controller.components, PUMP)),
            lambda each: component_words(controller, str(each), say) if each else "",
        ),
        "land": _choice("land", (None, *range(1, 10)), decided),
        "decision": _choice("decision", (None, *get_args(RepairState)), decided),
        "part": _choice("part", ("", *_PARTS), lambda each: say(_PARTS[str(each)]) if each else ""),
        **{
            name: st.column_config.DateColumn(say(f"job_table.{name}"), format="YYYY-MM-DD")
            for name in ("date", "calibrated")
        },
        **dict.fromkeys(("photo", "repair", "price", "hours")),  # in the folds above, and on the page Plan
    }
    tables, places = {}, {}
    for name in ("repair_decisions", "scratches", "instruments"):
        st.markdown(f"**{say(f'job_form.{name}')}**")
        if name == "repair_decisions":
            st.caption(say("job_form.proposed"))
        tables[name], places[name] = _table(record, name, shared), st.container()
    return tables, places


def _table(record: Job, name: str, columns: dict[str, Any]) -> list[dict[str, Any]]:
    """Show a table to edit. Its first content stays the same while it is on the page, else its edits would be lost."""
    own = key(name)
    model = get_args(Job.model_fields[name].annotation)[0]
    if own not in st.session_state:
        rows = [row.model_dump() for row in getattr(record, name)]
        st.session_state[f"{own}-base"] = pd.DataFrame(rows, columns=list(model.model_fields), dtype=object)
    base = st.session_state[f"{own}-base"]
    known = {
        column: columns.get(column, st.column_config.TextColumn(reader.say().get("job_table", column)))
        for column in base.columns
    }
    edited = st.data_editor(base, key=own, num_rows="dynamic", column_config=known, hide_index=True, placeholder="")
    rows = edited.astype(object).where(edited.notna(), None).to_dict("records")
    filled = [{column: value for column, value in row.items() if value not in (None, "")} for row in rows]
    return [row for row in filled if row]


def _pictures(record: Job) -> dict[str, Any]:
    """Show logo and photos, each with its caption; what is uploaded is in the record at once."""
    say = reader.say()
    _uploads("logo", several=False)
    logo = record.workshop.logo
    if logo is not None and logo in record.pictures:
        with st.container(horizontal=True, vertical_alignment="center"):
            _picture(st, logo, record.pictures[logo])
            st.button(say("job_form.remove_logo"), key=key("remove-logo"), on_click=_put, args=(record.without_logo(),))
    _uploads("photos", several=True)
    photos = []
    for photo in record.photos:
        places = st.columns([2, 3, 1], vertical_alignment="bottom")
        if photo.file in record.pictures:
            _picture(places[0], photo.file, record.pictures[photo.file])
        own = fields.kept(key(f"caption-{photo.file}"), photo.caption)
        caption = places[1].text_input(say("job_form.caption"), **own)
        remove = key(f"remove-{photo.file}")
        places[2].button(say("job_form.remove"), key=remove, on_click=_take_photo_away, args=(photo.file,))
        photos.append(photo.model_copy(update={"caption": caption}).model_dump())
    return {"photos": photos}


def _picture(place: Any, name: str, content: bytes) -> None:
    """Show a picture as it is printed; say why one that a job file brought cannot be."""
    try:
        place.image(_as_printed(name, content), width=160)
    except InputError as error:
        place.error(show.plain(error))


@st.cache_data(max_entries=32, show_spinner=False)
def _as_printed(name: str, content: bytes) -> bytes:
    return printable_picture(name, content)[1]


def _uploads(what: str, *, several: bool) -> None:
    """Offer to upload pictures."""

    def take(pictures: Sequence[UploadedFile]) -> None:
        names = ", ".join(picture.name for picture in pictures)
        remember(lambda say: say("done.taken_in", name=names))
        for picture in pictures:
            name, content = picture.name, picture.getvalue()
            with show.refusing(what):
                printable_picture(name, content)
                _put(job().with_photo(name, content) if several else job().with_logo(name, content))

    name = f"{what}-{session().in_book.place}"
    drop_zone.draw(name, reader.say()(f"job_form.{what}"), take, types=PICTURE_KINDS, several=several)
    with st.container():
        show.refused(what)


def _take_photo_away(file: str) -> None:
    remember(lambda say: say("done.taken_away", name=file.rpartition("/")[2]))
    _put(job().without_photo(file))


def _put(record: Job) -> None:
    """Change the record under its widgets; for a callback."""
    st.session_state[RECORD] = record


def _texts(table: Record) -> list[str]:
    """Return the names of the fields of a table that hold text, in the record's order."""
    return [name for name, field in type(table).model_fields.items() if field.default == ""]


def _line(place: Any, name: str, value: str) -> str:
    return str(place.text_input(reader.say()(f"job_form.{name}"), **fields.kept(key(name), value)))


def _text(place: Any, own: str, name: str, value: str, before: str = "") -> str:
    label = reader.say()(f"job_field.{'tax_number' if own == 'workshop-registration' else before + name}")
    return (place.text_area if name in _LONG else place.text_input)(label, **fields.kept(key(own), value))


def key(name: str) -> str:
    """Return a widget's key: another record gives fresh widgets."""
    return f"job{job_generation()}-{name}"

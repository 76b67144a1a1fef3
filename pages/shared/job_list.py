"""Look jobs up in the job book, and do something with those that are picked."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.common.verdicts import Verdict
from atleak.job_book.book import Book, JobRow, local_time
from atleak.job_book.erasure import erase, jobs_of_customer, same_vehicle
from atleak.job_book.exchange import export_zip, import_job
from atleak.job_book.merges import duplicates, merge, merged_rows, part
from atleak.job_book.search import Query, controllers_held
from atleak.report.tables.table import Column, Table
from pages.shared import fields, reader, show
from pages.shared.book import job_id, open_from_book
from pages.shared.job_form import key
from pages.shared.state import session
from pages.shared.undo import Steps

_TABLE = "job-list"
_SAID = "job-list-said"  # what was done by the last click
_ERASING = "job-list-erasing"  # ids of jobs whose customer is to be erased
_PAIRS = "job-list-pairs"  # units that may be one, as they were when somebody looked
_OF_RECORD = re.compile(r"job\d+-")  # the keys of what is typed in a job's record
_MERGED = "job-list-merged"  # unit that was merged last


def asked(book: Book) -> Query:
    """Show the fields that a job is looked up by; return what is asked for."""
    say = reader.say()
    text = st.text_input(
        say("job_book.look_up"),
        **fields.kept("job-list-text", ""),
        placeholder=say("job_book.look_up_by"),
        help=say("job_book.look_up_help"),
    )
    with book.reading() as connection:
        controllers = controllers_held(connection)

    def choice(place: Any, name: str, options: Sequence[str], shown: Callable[[Any], str]) -> Any:
        names = {"": say("job_book.any"), **{each: shown(each) for each in options}}
        return fields.one_of(say(f"columns.{name}"), names, f"job-list-{name}", place=place)

    with st.expander(say("job_book.narrow")):
        places = st.columns(4)
        first, last = (
            place.date_input(say(f"job_book.{name}"), format="YYYY-MM-DD", **fields.kept(f"job-list-{name}", None))
            for place, name in zip(places, ("from", "to"), strict=False)
        )
        verdict = choice(places[2], "verdict", tuple(Verdict), say.signed)
        controller = choice(places[3], "controller", controllers, str)
        archived = st.toggle(say("job_book.archived"), key="job-list-archived")
    return Query(
        text=text,
        date_from=first if isinstance(first, dt.date) else None,
        date_to=last if isinstance(last, dt.date) else None,
        verdict=verdict,
        controller=controller,
        archived=archived,
    )


def listed(book: Book, query: Query) -> list[JobRow]:
    """Show the jobs that fit, page by page; return those that are picked."""
    say = reader.say()
    show.refused(_TABLE)
    if said := st.session_state.pop(_SAID, ""):
        st.success(said)
    count = book.count(query)
    if not count:
        nothing = query == Query(limit=query.limit) and not book.count(Query(archived=True))
        st.info(say("job_book.empty" if nothing else "job_book.none_fits"))
        return []
    columns = (
        Column("verdict", "verdict", width=92, of=lambda row: Verdict(row.verdict)),
        Column("number", of=lambda row: row.number or (say("job_book.sample") if row.sample else row.id[:6])),
        *map(Column, ("customer", "plate", "date", "vin", "serial")),
        Column("mileage", "distance", of="mileage_km"),
        Column("controller"),
        Column("changed_at", of=lambda row: local_time(row.changed_at)),
    )

    def rows_from(first: int) -> Table:
        return Table("", columns, book.rows(replace(query, limit=show.PAGE, offset=first)), say)

    picked = show.paged(count, rows_from, f"{_TABLE}-{query}", "multi-row")
    st.caption(say("job_book.listed", count=count))
    return picked


# --- with the jobs that are picked


def actions(book: Book, picked: Sequence[JobRow]) -> tuple[str, dict[str, str]] | None:
    """Show what can be done with the picked jobs; return the page to go to, with its parameters."""
    say, ids = reader.say(), [row.id for row in picked]
    back = bool(picked) and all(row.archived_at is not None for row in picked)

    def button(name: str, fits: bool, said: str = "", **settings: Any) -> bool:
        return st.button(say(f"job_book.{said or name}"), disabled=not fits, key=f"job-{name}", **settings)

    with st.container(horizontal=True):
        opened = button("open", len(ids) == 1, on_click=open_from_book, args=tuple(ids[:1]), type="primary")
        unit = button("unit", len(ids) == 1, help=say("job_book.unit_help"))
        both = button("compare", len(ids) == 2, help=say("job_book.compare_help"))
        button(
            "archive", bool(ids), "bring_back" if back else "archive", on_click=_done,
            args=(_archived, book, ids, back), help=say("job_book.archive_help"),
        )  # fmt: skip
        st.download_button(
            say("job_book.export"),
            lambda: export_zip(book, ids),
            "atleak_jobs.zip",
            on_click="ignore",
            disabled=not ids,
            key="job-export",
            help=say("job_book.export_help"),
        )
        button("erase", bool(ids), "erase_customer", on_click=_begin, args=(ids,))
    if opened and job_id() in ids:
        return "Diagnosis", {}
    if unit:
        return "History", {"history": "unit", "unit": str(picked[0].unit)}
    if both:
        before, after = sorted(picked, key=lambda row: row.order)
        return "History", {"history": "compare", "before": before.id, "after": after.id}
    return None


def _done(act: Callable[..., str], *given: Any) -> None:
    """Carry something out in a callback, and keep what is to be said of it."""
    with show.refusing(_TABLE):
        st.session_state[_SAID] = act(*given)


def _archived(book: Book, ids: Sequence[str], back: bool) -> str:
    for id in ids:
        book.archive(id, back=back)
    return reader.say()("job_book.brought_back" if back else "job_book.done_archived", count=len(ids))


# --- erasing


def _begin(ids: Sequence[str]) -> None:
    st.session_state[_ERASING] = list(ids)


def erasing(book: Book) -> None:
    """Ask before a customer's data are erased, and say what goes and what stays."""
    ids = st.session_state.get(_ERASING)
    if not ids:
        return
    rows = [row for row in book.rows(Query(archived=None, limit=None)) if row.id in ids]
    say, names = reader.say(), sorted({row.customer for row in rows if row.customer})
    with st.container(border=True):
        st.header(say("job_book.erase_for_good"))
        for name in names:
            others = [row for row in jobs_of_customer(book, name) if row.id not in ids]
            if others:
                more = say("job_book.erase_more", count=len(others), name=name)
                st.button(more, on_click=_begin, args=([*ids, *(row.id for row in others)],), key=f"job-more-{name}")
        whose = "\n".join(f"- {show.plain(row.in_words)}" for row in rows)
        st.warning(f"**{say('job_book.what_goes')}**\n\n{whose}")
        for row in same_vehicle(book, ids):
            st.caption(say("job_book.not_erased", job=show.plain(row.in_words)))
        with st.container(horizontal=True):
            act = (_erase, book, ids)
            st.button(say("job_book.erase"), type="primary", on_click=_done, args=act, key="job-erase-now")
            st.button(say("job_book.keep"), on_click=_begin, args=([],), key="job-erase-not")


def _erase(book: Book, ids: Sequence[str]) -> str:
    st.session_state.pop(_ERASING)
    done = erase(book, ids)
    session().steps = session().steps.without_jobs(ids)
    if job_id() in ids:
        open_from_book(str(job_id()), Steps())  # what this session shows is what the book holds now
    for own in [*filter(_OF_RECORD.match, map(str, st.session_state))]:
        if not own.startswith(key("")):
            del st.session_state[own]
    lost = sum(bool(each.lost) for each in done)
    left = sorted({name for each in done for name in each.left_in})
    say = reader.say()
    said = [say("job_book.erased", count=len(done))]
    said += [say("job_book.erased_lost", count=lost)] if lost else []
    said += [say("job_book.erased_left", files=show.plain(", ".join(left)))] if left else []
    return " ".join(said)


# --- job files, and units that may be one


def taken_in(book: Book) -> None:
    """Take job files in that are uploaded."""
    say = reader.say()
    with st.expander(say("job_book.import_files")):
        generation = st.session_state.setdefault("job-import-generation", 0)
        files = st.file_uploader(
            say("job_book.job_files"), ["zip"], accept_multiple_files=True, key=f"job-import-{generation}"
        )
        if files and st.button(say("job_book.import", count=len(files)), key="job-import-now"):
            lines = [_import_one(book, file.name, file.getvalue()) for file in files]
            st.session_state["job-import-generation"] = generation + 1
            st.session_state[_SAID] = "  \n".join(lines)
            st.rerun()


def _import_one(book: Book, name: str, content: bytes) -> str:
    say = reader.say()
    try:
        taken = import_job(book, content, name=name)
    except AtleakError as error:
        return say("job_book.not_taken", problem=show.plain(error))
    name = show.plain(name)
    said = (
        say("job_book.known", name=name)
        if taken.known
        else say("job_book.taken_in", name=name, verdict=say.signed(Verdict(taken.verdict)))
    )
    return f"{said} {show.judged_otherwise(taken.result_by, taken.differs)}\n" if taken.differs else said


def suggestions(book: Book, picked: Sequence[JobRow]) -> None:
    """Point out units that may be one, to be merged, and what was merged into the unit of a picked job."""
    say, merged = reader.say(), st.session_state.get(_MERGED)
    with st.expander(say("job_book.may_be_one")):
        if merged is not None:
            st.button(say("job_book.undo_merge"), on_click=_done, args=(_parted, book, merged), key="job-part")
        for row in merged_rows(book, picked[0].unit) if len(picked) == 1 else []:
            st.button(say("job_book.part", unit=row.told_by), on_click=_done, args=(_parted, book, row.id))
        st.caption(say("job_book.merge_help"))
        st.button(say("job_book.look_for_them"), on_click=_done, args=(_look_for_pairs, book), key="job-duplicates")
        pairs = st.session_state.get(_PAIRS)
        if pairs == []:
            st.write(say("job_book.none_alike"))
        for pair in (pairs or [])[: show.PAGE]:
            words, button = st.columns([4, 1], vertical_alignment="center")
            one, other, why = map(show.plain, (pair.one.in_words, pair.other.in_words, pair.why))
            words.markdown(f"{one}  \n{other}  \n*{why}*")
            act, key = (_merged, book, pair.one.id, pair.other.id), f"job-merge-{pair.one.id}-{pair.other.id}"
            button.button(say("job_book.merge"), on_click=_done, args=act, key=key)


def _look_for_pairs(book: Book) -> str:
    st.session_state[_PAIRS] = duplicates(book)  # takes seconds in a book of 50 000 jobs: not at every click
    return ""


def _merged(book: Book, unit: int, other: int) -> str:
    st.session_state[_MERGED] = merge(book, unit, other)
    _look_for_pairs(book)
    return reader.say()("job_book.merged")


def _parted(book: Book, row: int) -> str:
    st.session_state.pop(_MERGED, None)
    part(book, row)
    _look_for_pairs(book)
    return reader.say()("job_book.parted")

"""Look jobs up in the job book, and do something with those that are picked."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import streamlit as st

from atleak.errors import AtleakError
from atleak.jobs.book import Book, JobRow
from atleak.jobs.erase import WHAT_GOES, erase, jobs_of_customer, same_vehicle
from atleak.jobs.exchange import export_zip, import_job
from atleak.jobs.merge import duplicates, merge, merged_rows, part
from atleak.jobs.search import Query, controllers_held
from atleak.verdicts import Verdict
from atleak.wording import signed
from pages.shared import show
from pages.shared.book import job_id, open_from_book
from pages.shared.fields import kept

PAGE = 50  # rows
_TABLE = "job-list"
_SAID = "job-list-said"  # what was done by the last click
_ERASING = "job-list-erasing"  # ids of jobs whose customer is to be erased
_PAIRS = "job-list-pairs"  # units that may be one, as they were when somebody looked
_MERGED = "job-list-merged"  # unit that was merged last
_EMPTY = (
    "The job book is empty. Every job stands here from its first file or entry on, to be looked up by VIN, plate, "
    "serial, customer or number."
)


def asked(book: Book) -> Query:
    """Show the fields that a job is looked up by; return what is asked for."""
    text = st.text_input(
        "Look up",
        **kept("job-list-text", ""),
        placeholder="VIN, plate, serial, customer or number",
        help="What one of them begins with, or what a VIN or a serial ends with. Of several words each must fit.",
    )
    with book.reading() as connection:
        controllers = controllers_held(connection)
    with st.expander("Narrow it down"):
        places = st.columns(4)
        first = places[0].date_input("From", format="YYYY-MM-DD", **kept("job-list-from", None))
        last = places[1].date_input("To", format="YYYY-MM-DD", **kept("job-list-to", None))
        verdict = places[2].selectbox(
            "Verdict", ["", *Verdict], key="job-list-verdict", format_func=lambda each: signed(each) if each else "any"
        )
        controller = places[3].selectbox(
            "Valve body", ["", *controllers], key="job-list-controller", format_func=lambda each: each or "any"
        )
        archived = st.toggle("Archived jobs", key="job-list-archived")
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
    said = st.session_state.pop(_SAID, "")
    if said:
        st.success(said)
    count = book.count(query)
    if not count:
        nothing = query == Query(limit=query.limit) and not book.count(Query(archived=True))
        st.info(_EMPTY if nothing else "No job fits.")
        return []
    pages = -(-count // PAGE)
    page = 1
    if pages > 1:
        page = st.selectbox(f"Page, of {pages}", range(1, pages + 1), key=f"job-list-page-{pages}")
    rows = book.rows(replace(query, limit=PAGE, offset=PAGE * (page - 1)))
    event = show.verdict_table(
        [_shown(row) for row in rows],
        {"km": 0},
        key=f"{_TABLE}-{query}-{page}",
        on_select="rerun",
        selection_mode="multi-row",
    )
    jobs = f"{count} job{'s' * (count != 1)}"
    st.caption(f"{jobs}, the last changed one first. Tick those to open, archive, export or erase.")
    return [rows[number] for number in event.selection.rows if number < len(rows)]


def _shown(row: JobRow) -> dict[str, Any]:
    return {
        "Verdict": row.verdict,
        "Number": row.number or ("sample" if row.sample else row.id[:6]),
        "Customer": row.customer,
        "Plate": row.plate,
        "Date": row.date,
        "VIN": row.vin,
        "Serial": row.serial,
        "km": row.mileage_km,
        "Valve body": row.controller,
        "Changed": f"{row.changed_at:%Y-%m-%d %H:%M}",
    }


# --- with the jobs that are picked


def actions(book: Book, picked: Sequence[JobRow]) -> tuple[str, dict[str, str]] | None:
    """Show what can be done with the picked jobs; return the page to go to, with its parameters."""
    ids = [row.id for row in picked]
    with st.container(horizontal=True):
        opened = st.button(
            "Open", on_click=_open, args=tuple(ids[:1]), disabled=len(ids) != 1, type="primary", key="job-open"
        )
        unit = st.button("Its unit", disabled=len(ids) != 1, key="job-unit", help="Its visits, and how it wears.")
        both = st.button("Compare", disabled=len(ids) != 2, key="job-compare", help="Two jobs side by side.")
        back = bool(picked) and all(row.archived_at is not None for row in picked)
        st.button(
            "Bring back" if back else "Archive",
            on_click=_done,
            args=(partial(_archived, book, ids, back=back),),
            disabled=not ids,
            key="job-archive",
            help="An archived job is out of lists and statistics; its link still opens it.",
        )
        st.download_button(
            "Export",
            lambda: export_zip(book, ids),
            "atleak_jobs.zip",
            on_click="ignore",
            disabled=not ids,
            key="job-export",
            help="A zip of their job files, and tables of them for other programs.",
        )
        st.button("Erase the customer …", on_click=_begin, args=(ids,), disabled=not ids, key="job-erase")
    if opened and job_id() in ids:
        return "4_Diagnosis", {}
    if unit:
        return "11_Unit", {"unit": str(picked[0].unit)}
    if both:
        before, after = sorted(
            picked, key=lambda row: (row.date or row.changed_at.date(), row.mileage_km or 0.0, row.changed_at)
        )
        return "12_Compare", {"before": before.id, "after": after.id}
    return None


def _open(id: str) -> None:
    open_from_book(id)  # where it cannot be opened, the head of the page says why


def _done(act: Callable[[], str]) -> None:
    """Carry something out in a callback, and keep what is to be said of it."""
    try:
        st.session_state[_SAID] = act()
    except AtleakError as error:
        st.session_state[_SAID] = ""
        st.session_state["job-list-fault"] = str(error)


def _archived(book: Book, ids: Sequence[str], *, back: bool) -> str:
    for id in ids:
        (book.bring_back if back else book.archive)(id)
    jobs = f"{len(ids)} job{'s' * (len(ids) != 1)}"
    return f"{jobs} brought back." if back else f"{jobs} archived: the switch *Archived jobs* shows them."


def fault() -> None:
    """Show why the last click could not be carried out."""
    said = st.session_state.pop("job-list-fault", "")
    if said:
        st.error(show.plain(said))


# --- erasing


def _begin(ids: Sequence[str]) -> None:
    st.session_state[_ERASING] = list(ids)


def erasing(book: Book) -> None:
    """Ask before a customer's data are erased, and say what goes and what stays."""
    ids = st.session_state.get(_ERASING)
    if not ids:
        return
    rows = [row for row in book.rows(Query(archived=None, limit=None)) if row.id in ids]
    names = sorted({row.customer for row in rows if row.customer})
    with st.container(border=True):
        st.subheader("Erase for good")
        for name in names:
            others = [row for row in jobs_of_customer(book, name) if row.id not in ids]
            if others:
                more = f"Take {len(others)} more of {name} too"
                st.button(more, on_click=_begin, args=([*ids, *(row.id for row in others)],), key=f"job-more-{name}")
        whose = "\n".join(f"- {show.plain(row.in_words)}" for row in rows)
        st.warning(f"**{WHAT_GOES}**\n\n{whose}")
        for row in same_vehicle(book, ids):
            st.caption(f"Not erased, of the same vehicle or transmission: {show.plain(row.in_words)}")
        with st.container(horizontal=True):
            st.button("Erase", type="primary", on_click=_done, args=(partial(_erase, book, ids),), key="job-erase-now")
            st.button("Keep them", on_click=_begin, args=([],), key="job-erase-not")


def _erase(book: Book, ids: Sequence[str]) -> str:
    st.session_state.pop(_ERASING)
    done = erase(book, ids)
    if job_id() in ids:
        open_from_book(str(job_id()))  # what this session shows is what the book holds now
    lost = sum(bool(each.lost) for each in done)
    left = sorted({name for each in done for name in each.left_in})
    said = f"The customer's data of {len(done)} job{'s' * (len(done) != 1)} are erased."
    said += f" Of {lost} a file could not be kept; the stored result stays." if lost else ""
    return said + (f" Left as they are, and they name the customer: {show.plain(', '.join(left))}." if left else "")


# --- job files, and units that may be one


def taken_in(book: Book) -> None:
    """Take job files in that are uploaded."""
    with st.expander("Import job files"):
        generation = st.session_state.setdefault("job-import-generation", 0)
        files = st.file_uploader("Job files", ["zip"], accept_multiple_files=True, key=f"job-import-{generation}")
        if files and st.button(f"Import {len(files)}", key="job-import-now"):
            lines = [_import_one(book, file.name, file.getvalue()) for file in files]
            st.session_state["job-import-generation"] = generation + 1
            st.session_state[_SAID] = "  \n".join(lines)
            st.rerun()


def _import_one(book: Book, name: str, content: bytes) -> str:
    try:
        taken = import_job(book, content, name=name)
    except AtleakError as error:
        return f"Not taken: {show.plain(error)}"
    said = "is in the job book already" if taken.known else f"taken in, {signed(Verdict(taken.verdict))}"
    before = f"; it was {taken.stored_verdict} when it was written" if taken.stored_verdict else ""
    return f"{show.plain(name)}: {said}{before}."


def suggestions(book: Book, picked: Sequence[JobRow]) -> None:
    """Point out units that may be one, to be merged, and what was merged into the unit of a picked job."""
    merged = st.session_state.get(_MERGED)
    with st.expander("Units that may be one"):
        if merged is not None:
            st.button("Undo the last merge", on_click=_done, args=(partial(_parted, book, merged),), key="job-part")
        for row in merged_rows(book, picked[0].unit) if len(picked) == 1 else []:
            act = partial(_parted, book, row.id)
            st.button(f"Part {row.told_by} from the picked job's unit", on_click=_done, args=(act,))
        st.caption("A slip in typing a VIN makes two units of one transmission. Merging can be undone.")
        st.button("Look for them", on_click=_done, args=(partial(_look_for_pairs, book),), key="job-duplicates")
        pairs = st.session_state.get(_PAIRS)
        if pairs == []:
            st.write("No two units look like one.")
        for pair in (pairs or [])[:PAGE]:
            words, button = st.columns([4, 1], vertical_alignment="center")
            words.markdown(f"{show.plain(pair.one.in_words)}  \n{show.plain(pair.other.in_words)}  \n*{pair.why}*")
            act = partial(_merged, book, pair.one.id, pair.other.id)
            button.button("Merge", on_click=_done, args=(act,), key=f"job-merge-{pair.one.id}-{pair.other.id}")


def _look_for_pairs(book: Book) -> str:
    st.session_state[_PAIRS] = duplicates(book)  # takes seconds in a book of 50 000 jobs: not at every click
    return ""


def _merged(book: Book, unit: int, other: int) -> str:
    merge(book, unit, other)
    _look_for_pairs(book)
    st.session_state[_MERGED] = other
    return "The two units are one now."


def _parted(book: Book, row: int) -> str:
    st.session_state.pop(_MERGED, None)
    part(book, row)
    _look_for_pairs(book)
    return "The two units stand by themselves again."

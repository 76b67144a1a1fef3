"""Show a customer one job at an address of its own, take in his yes or no, and draw what the workshop sees of it."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import parse_qs, urlsplit

import segno
import streamlit as st
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, RedirectResponse, Response

from atleak.analysis.estimate import with_line
from atleak.common.access import is_here_alone
from atleak.common.errors import AtleakError
from atleak.common.translations import languages
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.customer_screen import Answer, closed, customer_screen, shows_the_same, written
from pages.shared import book, plan, reader, show
from pages.shared.state import RECORD, job, session

PATH = "/customer"
_MOST = 20_000  # [bytes] of an answer
_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "same-origin", "X-Robots-Tag": "noindex"}


# --- the address


async def screen(request: Request) -> Response:
    """Show the job of an address, and take an answer in; whoever has no address of it sees that the page is closed."""
    token, body = str(request.path_params["token"]), b""
    async for part in request.stream():
        body += part
        if len(body) > _MOST:
            return Response(status_code=413)
    sent = None if request.method != "POST" else _fields(body)
    try:
        status, page = await run_in_threadpool(_answered, token, sent)
    except AtleakError:  # the book cannot be used just now
        status, page = 503, None
    if status == 303:
        return RedirectResponse(request.url.path, status_code=303)
    wanted = request.headers.get("accept-language", "")[:2]
    return HTMLResponse(page or closed(wanted if wanted in languages() else "en"), status, _HEADERS)


def _fields(body: bytes) -> dict[str, str]:
    try:
        return {name: values[-1] for name, values in parse_qs(body.decode(), max_num_fields=500).items()}
    except ValueError:
        return {}


def _answered(token: str, sent: Mapping[str, str] | None) -> tuple[int, str | None]:
    from atleak.job_book.customer_links import link_of, take_answer

    link = link_of(book.book(), token)
    if link is None:
        return 404, None
    if sent is None:
        return 200, written(link.screen, answer=link.answer, asks=True)
    if take_answer(book.book(), link, sent.get("name", ""), sent):
        return 303, None
    return 422, written(link.screen, answer=link.answer, asks=True, fault=True)


# --- the workshop's side


def take_answers(diagnosis: Diagnosis) -> None:
    """Write into the record what the customer has answered since it was last looked at."""
    in_book, record = session().in_book, job()
    if in_book.id is None or in_book.conflict is not None:
        return
    from atleak.job_book.customer_links import answers_of_job

    known = max((each.decided_at for each in record.repair_decisions if each.decided_at), default=None)
    try:
        answers = answers_of_job(book.book(), in_book.id)
    except AtleakError:  # said where the job is saved
        return
    for answer in answers:
        if known is None or answer.at > known:
            _take(diagnosis, answer)


def _take(diagnosis: Diagnosis, answer: Answer) -> None:
    said = [0, 0]
    for key, agreed in answer.agreed.items():
        line = next((each for each in plan.made(diagnosis).lines if each.key == key), None)
        if line is not None and line.decision.decision != "done":
            decided = {"decided_by": answer.name, "decided_at": answer.at, "date": answer.at.astimezone().date()}
            changes = {"decision": "approved" if agreed else "declined", **decided}
            st.session_state[RECORD] = with_line(job(), line, **changes)
            said[agreed] += 1
    if any(said):
        no, yes = said
        st.toast(show.plain(reader.say()("customer_link.answered", name=answer.name, yes=yes, no=no)))


def section(diagnosis: Diagnosis, name: str, language: str) -> None:
    """Offer the customer's screen as a file, and addresses of it; say what was answered."""
    say, in_book = reader.say(), session().in_book
    made = customer_screen(diagnosis, job(), language=language, units=say.units)
    with st.container(horizontal=True):
        st.download_button(
            say("customer_link.file"),
            lambda: written(made),
            f"{name}-customer.html",
            "text/html",
            key="customer-file",
            on_click="ignore",
            help=say("customer_link.file_help"),
        )
        st.button(
            say("customer_link.make"),
            key="customer-make",
            on_click=_make,
            args=(made,),
            disabled=in_book.id is None,
            help=say("customer_link.make_help"),
        )
    if in_book.id is None:
        st.caption(say("customer_link.not_kept"))
        return
    from atleak.job_book.customer_links import close_link, links_of_job

    try:
        links = links_of_job(book.book(), in_book.id)
    except AtleakError as error:
        st.error(show.error_line(error))
        return
    if any(link.open for link in links) and is_here_alone(str(st.get_option("server.address"))):
        st.info(say("customer_link.here_alone"))
    here = urlsplit(str(st.context.url or ""))
    for link in links:
        with st.container(horizontal=True, vertical_alignment="center", key=f"customer-link-{link.id}"):
            if link.open:
                address = f"{here.scheme}://{here.netloc}{PATH}/{link.token}"
                st.link_button(say("customer_link.show"), address)
                with st.popover(say("customer_link.code")):
                    st.image(segno.make(address).svg_data_uri(scale=5, border=4, light="white"))
                st.code(address, language=None)
                st.button(
                    say("customer_link.close"),
                    key=f"customer-close-{link.id}",
                    on_click=close_link,
                    args=(book.book(), link.id),
                )
            moment = "until" if link.open else "closed"
            words = [say(f"customer_link.{moment}", made=say.moment(link.made_at), until=say.moment(link.until))]
            if link.open and not shows_the_same(link.screen, made):
                words.append(say("customer_link.older"))
            if link.answer is not None:
                yes = sum(link.answer.agreed.values())
                counts = {"yes": yes, "no": len(link.answer.agreed) - yes, "moment": say.moment(link.answer.at)}
                words.append(say("customer_link.answered_at", name=link.answer.name, **counts))
            st.caption(show.plain(" ".join(words)))


def _make(made: Mapping[str, object]) -> None:
    from atleak.job_book.customer_links import make_link

    id = book.job_id()
    if id is not None:
        try:
            make_link(book.book(), id, made)
        except AtleakError as error:
            session().in_book.fault = error

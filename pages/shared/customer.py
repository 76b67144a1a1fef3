"""Show a customer one job at an address of its own, take in his yes or no, and draw what the workshop sees of it."""

from __future__ import annotations

import datetime as dt
import secrets
from collections.abc import Callable, Mapping
from typing import Any
from urllib.parse import parse_qs, urlsplit

import streamlit as st
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, RedirectResponse, Response

from atleak.analysis.estimate import with_line
from atleak.common.access import is_here_alone
from atleak.common.errors import AtleakError
from atleak.common.translations import languages
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.customer_screen import Answer, closed, offered, shows_the_same, written
from pages.shared import book, places, plan, reader, show
from pages.shared.state import RECORD, job, session

_TOLD = "answers-told"  # those that this session has taken or left
_SHOWN = "customer-shown"  # token of the screen to be opened
_UNKEPT: dict[str, dict[str, Any]] = {}  # screens of jobs that the book does not hold, by token: the latest
_MOST_UNKEPT = 20
_INSTANT = dt.timedelta(microseconds=1)
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
    page = page or closed(wanted if wanted in languages() else "en", busy=status == 503)
    return HTMLResponse(page, status, _HEADERS)


def _fields(body: bytes) -> dict[str, str]:
    try:
        return {name: values[-1] for name, values in parse_qs(body.decode(), max_num_fields=500).items()}
    except ValueError:
        return {}


def _answered(token: str, sent: Mapping[str, str] | None) -> tuple[int, str | None]:
    from atleak.job_book.customer_links import link_of, take_answer

    link = link_of(book.book(), token)
    if link is None:
        return (200, written(_UNKEPT[token])) if token in _UNKEPT else (404, None)
    if sent is None:
        return 200, written(link.screen, answer=link.answer, asks=True)
    if take_answer(book.book(), link, sent.get("name", ""), sent):
        return 303, None
    return 422, written(link.screen, answer=link.answer, asks=True, sent=sent)


# --- the workshop's side


def take_answers(diagnosis: Diagnosis) -> bool:
    """Write into the record what the customer has answered since; return whether there was anything.

    It is taken once what the page's fields hold is in the record. A line that was done since, or whose work or price
    is no longer what the customer saw, is left as it is, and said.
    """
    in_book, known = session().in_book, [each.decided_at for each in job().repair_decisions if each.decided_at]
    if in_book.id is None or in_book.conflict is not None:
        return False
    from atleak.job_book.customer_links import links_of_job

    try:
        links = links_of_job(book.book(), in_book.id)
    except AtleakError:  # said where the job is saved
        return False
    told = st.session_state.setdefault(_TOLD, set())
    answered = [(link, link.answer) for link in links if link.answer is not None]
    new = [(link, answer) for link, answer in answered if answer.at > max(known, default=answer.at - _INSTANT)]
    new = [(link, answer) for link, answer in new if (link.id, answer.at) not in told]
    for link, answer in sorted(new, key=lambda each: each[1].at):
        told.add((link.id, answer.at))
        _take(diagnosis, link.screen, answer)
    return bool(new)


def _take(diagnosis: Diagnosis, screen: Mapping[str, Any], answer: Answer) -> None:
    from atleak.report.pdf.customer_screen import customer_screen

    counts = {"yes": 0, "no": 0, "left": 0}
    say, asked = reader.say(), offered(screen)
    now = offered(customer_screen(diagnosis, job(), language=screen["language"], units=say.units))
    for key, agreed in answer.agreed.items():
        line = next((each for each in plan.made(diagnosis).lines if each.key == key), None)
        if line is None or line.decision.decision == "done" or now.get(key) != asked[key]:
            counts["left"] += 1
            continue
        decided = {"decided_by": answer.name, "decided_at": answer.at, "date": answer.at.astimezone().date()}
        changes = {"decision": "approved" if agreed else "declined", **decided}
        st.session_state[RECORD] = with_line(job(), line, **changes)
        counts["yes" if agreed else "no"] += 1
    left = say("customer_link.left", count=counts["left"]) if counts["left"] else ""
    st.toast(show.plain(f"{say('customer_link.answered', name=answer.name, **counts)} {left}".strip()))


def _screen(diagnosis: Diagnosis, language: str) -> dict[str, Any]:
    from atleak.report.pdf.customer_screen import customer_screen
    from pages.shared import comparison

    return customer_screen(diagnosis, job(), language=language, units=reader.say().units, visits=comparison.beside())


def draw_button(diagnosis: Diagnosis) -> None:
    """Offer to show the customer this job, in a tab of its own."""
    st.button(reader.say()("customer_link.show_customer"), key="customer-show", on_click=_show, args=(diagnosis,))
    show.refused(_SHOWN)
    if token := st.session_state.pop(_SHOWN, ""):
        address = f"'{places.CUSTOMER}/{token}'"
        opens = f"window.open({address}) ?? location.assign({address})"
        st.html(f"<script>{opens}</script>", unsafe_allow_javascript=True)


def _show(diagnosis: Diagnosis) -> None:
    """Take the open address that shows the job as it is, or make one; a job that is not in the book takes no answer."""
    from atleak.job_book.customer_links import links_of_job, make_link

    screen, id = _screen(diagnosis, reader.say().language), book.job_id()
    if id is None:
        token = st.session_state[_SHOWN] = secrets.token_urlsafe()
        st.toast(reader.say()("customer_link.no_answer"))
        _UNKEPT[token] = screen
        for old in list(_UNKEPT)[:-_MOST_UNKEPT]:
            _UNKEPT.pop(old, None)
        return
    with show.refusing(_SHOWN):
        known = (each for each in links_of_job(book.book(), id) if each.open and shows_the_same(each.screen, screen))
        link = next(known, None) or make_link(book.book(), id, screen)
        st.session_state[_SHOWN] = link.token


def section(diagnosis: Diagnosis, name: str, language: str) -> None:
    """Offer the customer's screen as a file, and addresses of it; say what was answered."""
    import segno

    from atleak.job_book.customer_links import close_link, links_of_job, make_link

    say, in_book, made = reader.say(), session().in_book, _screen(diagnosis, language)
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
            on_click=_in_book,
            args=(make_link, in_book.id, made),
            disabled=in_book.id is None,
            help=say("customer_link.make_help"),
        )
    if in_book.id is None:
        st.caption(say("customer_link.not_kept"))
        return
    try:
        links = links_of_job(book.book(), in_book.id)
    except AtleakError as error:
        st.error(show.error_line(error))
        return
    here = urlsplit(str(st.context.url or ""))
    addresses = (str(st.get_option("server.address")), here.hostname or "")
    if any(link.open for link in links) and any(map(is_here_alone, filter(None, addresses))):
        st.info(say("customer_link.here_alone"))
    for link in links:
        with st.container(horizontal=True, vertical_alignment="center", key=f"customer-link-{link.id}"):
            if link.open:
                address = f"{here.scheme}://{here.netloc}{places.CUSTOMER}/{link.token}"
                st.link_button(say("customer_link.show"), address)
                with st.popover(say("customer_link.code")):
                    st.image(segno.make(address).svg_data_uri(scale=5, border=4, light="white"))
                st.code(address, language=None)
                st.button(
                    say("customer_link.close"),
                    key=f"customer-close-{link.id}",
                    on_click=_in_book,
                    args=(close_link, link.id),
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


def _in_book(act: Callable[..., object], *given: object) -> None:
    """Do something in the job book; what is wrong with it is said at the head of the page."""
    try:
        act(book.book(), *given)
    except AtleakError as error:
        session().in_book.fault = error

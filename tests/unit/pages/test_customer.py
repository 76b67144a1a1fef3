"""The customer's screen: an address of it is made on the page Report, and what is answered there is in the job."""

from __future__ import annotations

import re
from typing import Any

import httpx
import pytest
from starlette.applications import Starlette
from starlette.routing import Route
from streamlit.testing.v1 import AppTest

from atleak.measurements.job_card import Job
from pages.shared import customer
from tests.unit.own_loop import awaited
from tests.unit.pages.conftest import go, press, texts

pytestmark = [pytest.mark.page("5_Plan"), pytest.mark.saved]
SERVED = Starlette(routes=[Route("/customer/{token}", customer.screen, methods=["GET", "POST"])])


def asks(method: str, path: str, **sent: Any) -> httpx.Response:
    async def asking() -> httpx.Response:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(SERVED), base_url="http://localhost") as phone:
            return await phone.request(method, path, **sent)

    return awaited(asking())


def record(app: AppTest) -> Job:
    return app.session_state["job-record"]


def priced(app: AppTest) -> str:
    """Type two prices, make an address on the page Report, and return its path."""
    for price, label in zip(("120,5", "80"), range(2), strict=True):
        fields = [each for each in app.main.text_input if each.label.startswith("Price")]
        fields[label].set_value(price).run()
    press(app, "Keep it in the job book")
    go(app, "6_Report")
    press(app, "Make an address")
    assert not app.exception
    return app.main.code[-1].value.removeprefix("://")  # without a browser no page has a host


def asked(page: str) -> list[str]:
    return re.findall(r'name="([^"]+)" value="yes"', page)


def shown(app: AppTest) -> str:
    """Press the button on the page Diagnosis, and return the path of the screen that it opens."""
    go(app, "4_Diagnosis")
    press(app, "Show customer")
    assert not app.exception
    return re.findall(r"window\.open\('([^']+)'", "".join(each.proto.body for each in app.get("html")))[0]


def test_the_screen_of_a_job_that_nobody_touched_is_shown_and_nothing_is_kept(app: AppTest) -> None:
    page = asks("GET", shown(app))
    assert page.status_code == 200
    assert "The valve body needs repair." in page.text
    assert not asked(page.text)
    assert app.session_state["atleak"].in_book.id is None
    app.run()
    assert not any("window.open" in each.proto.body for each in app.get("html"))  # opened once


def test_the_screen_of_a_job_in_the_book_has_an_address_that_is_used_until_the_job_changes(app: AppTest) -> None:
    path = priced(app)
    assert shown(app) == path == shown(app)
    app.main.toggle[0].set_value(False).run()
    assert (again := shown(app)) != path
    assert asks("GET", again).text.count('data-counts="yes"') == asks("GET", path).text.count('data-counts="yes"') - 1


def test_a_yes_and_a_no_on_the_phone_are_in_the_job_with_name_and_time(app: AppTest) -> None:
    path = priced(app)
    page = asks("GET", path)
    assert page.status_code == 200
    assert page.headers["cache-control"] == "no-store"
    first, second = asked(page.text)
    answer = {"name": "Ana", first: "yes", second: "no"}
    sent = asks("POST", path, data=answer)
    assert (sent.status_code, sent.headers["location"]) == (303, path)
    assert "Thank you, Ana." in asks("GET", path).text
    app.run()
    decided = {each.pair: each for each in record(app).repair_decisions}
    assert {key: each.decision for key, each in decided.items()} == {first: "approved", second: "declined"}
    assert {each.decided_by for each in decided.values()} == {"Ana"}
    assert "yes to 1, no to 1" in texts(app)
    go(app, "5_Plan")
    assert "approved (Ana, " in texts(app)
    assert "Why was it declined?" not in texts(app)  # the customer need not say


def test_what_the_workshop_changes_after_an_answer_stays_and_is_no_longer_the_customers(app: AppTest) -> None:
    path = priced(app)
    first, second = asked(asks("GET", path).text)
    asks("POST", path, data={"name": "Ana", first: "no", second: "no"})
    go(app, "5_Plan")
    state = next(each for each in app.main.selectbox if each.label == "State")
    state.select("done").run()
    app.run()
    changed = record(app).repair_decisions[0]
    assert (changed.decision, changed.decided_by) == ("done", "")
    asks("POST", path, data={"name": "Ana", first: "no", second: "yes"})
    app.run()
    assert [each.decision for each in record(app).repair_decisions] == ["done", "approved"]


def test_a_yes_to_another_price_is_no_approval(app: AppTest) -> None:
    path = priced(app)
    first, second = asked(asks("GET", path).text)
    go(app, "5_Plan")
    next(each for each in app.main.text_input if each.label.startswith("Price")).set_value("800").run()
    asks("POST", path, data={"name": "Ana", first: "yes", second: "yes"})
    app.run()
    assert [(each.pair, each.decision, each.decided_by) for each in record(app).repair_decisions] == [
        (first, "proposed", ""),
        (second, "approved", "Ana"),
    ]
    fields = [each for each in app.main.text_input if each.label.startswith("Price")]
    fields[1].set_value("90").run()
    assert record(app).repair_decisions[1].decided_by == "", "another price is not what the customer agreed to"


def test_nothing_but_a_whole_answer_to_an_open_address_is_taken(app: AppTest) -> None:
    path = priced(app)
    first, second = asked(asks("GET", path).text)
    assert asks("POST", path, data={"name": "Ana", first: "yes"}).status_code == 422
    assert asks("POST", path, content=b"x" * 30_000).status_code == 413
    assert asks("POST", path, content=b"\xff" * 9).status_code == 422
    assert asks("GET", "/customer/none").status_code == 404
    press(app, "Close the address")
    assert asks("GET", path).status_code == 404
    assert asks("POST", path, data={"name": "Ana", first: "yes", second: "no"}).status_code == 404
    app.run()
    assert {each.decision for each in record(app).repair_decisions} == {"proposed"}

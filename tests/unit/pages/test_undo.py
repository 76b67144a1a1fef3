"""What was done can be taken back and done again: only that, of the job on the screen alone, and nobody comes back."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from streamlit.testing.v1 import AppTest

from atleak.job_book.book import open_book
from atleak.job_book.erasure import erase
from atleak.measurements.job_card import Job, Photo, RepairDecision
from pages.shared.undo import Steps, taken_back
from tests.unit.pages.conftest import go, texts, uploader
from tests.unit.pages.test_in_book import field
from tests.unit.pages.test_job_book_page import small_job

pytestmark = [pytest.mark.page("1_Job"), pytest.mark.saved]
SHEET = b"component;part;plane;direction;diameter [mm]\n8;spool;1;0;10.000\n8;sleeve;1;0;10.120\n"
LISTS = st.lists(st.sampled_from("abcdef"), unique=True, max_size=4).map(tuple)


def press(app: AppTest, key: str) -> AppTest:
    return app.button(key=key).click().run()


def offered(app: AppTest) -> list[str]:
    return [each.label.replace("\\", "") for each in app.button if each.key in ("undo", "redo")]


def with_sheet(app: AppTest, name: str = "mine.csv") -> AppTest:
    press_new(app)
    uploader(app).upload(name, SHEET, "text/csv").run()
    assert app.session_state["atleak"].good.readings.name == name
    return app


def press_new(app: AppTest) -> AppTest:
    next(each for each in app.sidebar.button if each.label == "New, empty job").click().run()
    return app


def picture(colour: str) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (8, 8), colour).save(file, "JPEG")
    return file.getvalue()


def test_a_step_is_taken_back_without_what_was_typed_since_and_done_again(app: AppTest) -> None:
    with_sheet(app)
    field(app, "Technician").set_value("bench 2").run()
    field(app, "Make").set_value("BMW").run()
    assert offered(app) == ["Undo: mine.csv taken in"]
    press(app, "undo")
    assert app.session_state["atleak"].good.readings is None
    assert (field(app, "Technician").value, field(app, "Make").value) == ("bench 2", "BMW")
    assert offered(app) == ["Undo: new, empty job", "Redo: mine.csv taken in"]
    field(app, "Technician").set_value("bench 3").run()
    press(app, "redo")
    assert app.session_state["atleak"].good.readings.name == "mine.csv"
    assert (field(app, "Technician").value, field(app, "Make").value) == ("bench 3", "BMW")
    (row,) = open_book().rows()
    assert open_book().load(row.id).file.job.technician == "bench 3"


def test_a_job_that_another_took_the_place_of_comes_back_as_the_book_holds_it(app: AppTest) -> None:
    with_sheet(app)
    field(app, "Job number").set_value("A-1").run()
    press_new(app)
    assert field(app, "Job number").value == ""
    first = open_book().rows()[0]
    changed = open_book().load(first.id).file.job.model_copy(update={"notes": "written elsewhere"})
    open_book().save(small_job(**changed.model_dump()), id=first.id, version=open_book().version(first.id))
    press(app, "undo")
    assert (field(app, "Job number").value, app.text_area(key=app.text_area[-1].key).value) == (
        "A-1",
        "written elsewhere",
    )
    assert offered(app)[-1] == "Redo: new, empty job"
    press(app, "redo")
    assert field(app, "Job number").value == ""
    press(app, "undo")
    assert field(app, "Job number").value == "A-1"


def test_a_job_that_is_opened_offers_no_step_of_another_one(app: AppTest) -> None:
    other = open_book().save(small_job(number="B-9"))
    with_sheet(app)
    field(app, "Job number").set_value("A-3").run()
    app.query_params["job"] = other.id
    app.run()
    assert field(app, "Job number").value == "B-9"
    assert offered(app) == []


def test_what_is_not_in_the_book_can_be_gone_back_to(app: AppTest) -> None:
    other = open_book().save(small_job(number="B-9"))
    press_new(app)
    field(app, "Job number").set_value("A-3").run()
    (mine,) = (row for row in open_book().rows() if row.number == "A-3")
    changed = open_book().load(mine.id).file.job.model_copy(update={"notes": "elsewhere"})
    open_book().save(small_job(**changed.model_dump()), id=mine.id, version=open_book().version(mine.id))
    field(app, "Technician").set_value("typed in the conflict").run()
    assert "Changed elsewhere." in texts(app)
    app.query_params["job"] = other.id
    app.run()
    press(app, "undo")
    assert field(app, "Technician").value == "typed in the conflict"
    assert "Changed elsewhere." in texts(app)


@pytest.mark.parametrize("shown", [True, False], ids=["on the screen", "left before"])
def test_nobody_who_was_erased_comes_back(app: AppTest, shown: bool) -> None:
    with_sheet(app)
    field(app, "Job number").set_value("A-1").run()
    (id,) = (row.id for row in open_book().rows())
    if not shown:
        press_new(app)
    go(app, "10_Jobs")
    app.session_state["job-list-erasing"] = [id]
    app.run()
    press(app, "job-erase-now")
    assert not app.exception
    assert offered(app) == []
    assert not open_book().load(id).file.job.number
    assert "A-1" not in repr(app.session_state)


def test_nobody_comes_back_who_was_erased_in_a_conflict(app: AppTest) -> None:
    with_sheet(app)
    field(app, "Job number").set_value("A-1").run()
    (id,) = (row.id for row in open_book().rows())
    changed = open_book().load(id).file.job.model_copy(update={"notes": "elsewhere"})
    open_book().save(small_job(**changed.model_dump()), id=id, version=open_book().version(id))
    field(app, "Technician").set_value("typed in the conflict").run()
    go(app, "10_Jobs")
    app.session_state["job-list-erasing"] = [id]
    app.run()
    press(app, "job-erase-now")
    assert offered(app) == []
    assert not app.session_state["job-record"].number


def test_a_job_erased_by_somebody_else_is_not_brought_back(app: AppTest) -> None:
    with_sheet(app)
    field(app, "Job number").set_value("A-1").run()
    (id,) = (row.id for row in open_book().rows())
    press_new(app)
    erase(open_book(), [id])
    press(app, "undo")
    assert not app.exception
    assert field(app, "Job number").value == ""


def test_a_step_of_a_job_that_somebody_else_erased_brings_nothing_back(app: AppTest) -> None:
    with_sheet(app, "Zyxwvut.csv")
    (row,) = open_book().rows()
    press(app, "undo")  # the sheet is out of the job, and could be taken in again
    assert offered(app)[-1] == "Redo: Zyxwvut.csv taken in"
    press_new(app)
    erase(open_book(), [row.id])
    press(app, "undo")
    assert not app.exception
    assert offered(app) == ["Redo: new, empty job"]


@pytest.mark.parametrize("key", ["book-over", "book-another"])
def test_nobody_comes_back_whom_somebody_else_erased_from_the_job_on_the_screen(app: AppTest, key: str) -> None:
    with_sheet(app)
    field(app, "Job number").set_value("A-1").run()
    (row,) = open_book().rows()
    changed = open_book().load(row.id).file.job.model_copy(update={"notes": "written elsewhere"})
    open_book().save(small_job(**changed.model_dump()), id=row.id, version=open_book().version(row.id))
    field(app, "Technician").set_value("bench 2").run()
    assert "Changed elsewhere." in texts(app)
    erase(open_book(), [row.id])
    press(app, key)
    assert not app.exception
    assert "the customer was erased from this job" in texts(app)
    assert not [each.key for each in app.button if each.key in ("book-over", "book-another")]
    (kept,) = open_book().rows()
    assert not open_book().load(kept.id).file.job.number
    field(app, "Technician").set_value("bench 3").run()
    assert "the customer was erased from this job" in texts(app)
    press(app, "book-theirs")
    field(app, "Technician").set_value("bench 4").run()
    assert "Changed elsewhere." not in texts(app)
    record = open_book().load(row.id).file.job
    assert (record.number, record.technician) == ("", "bench 4")


def test_a_second_photo_of_one_name_is_a_second_photo_and_both_can_be_undone(app: AppTest) -> None:
    uploads = {"image.jpg": picture("red")}
    uploader(app).upload_all(uploads).run()
    uploader(app).upload("image.jpg", picture("blue"), "image/jpeg").run()
    uploader(app).upload("again.jpg", picture("red"), "image/jpeg").run()
    kept = app.session_state["job-record"]
    assert [photo.file for photo in kept.photos] == ["photos/image.jpg", "photos/image-2.jpg"]
    assert kept.pictures == {"photos/image.jpg": picture("red"), "photos/image-2.jpg": picture("blue")}
    press(app, "undo")
    assert [photo.file for photo in app.session_state["job-record"].photos] == ["photos/image.jpg"]


@given(LISTS, LISTS, LISTS)
def test_a_step_of_which_nothing_was_changed_since_is_taken_back_whole(
    before: tuple[str, ...], after: tuple[str, ...], since: tuple[str, ...]
) -> None:
    assert taken_back(after, after, before) == before
    both = taken_back((*after, *(each for each in since if each not in after)), after, before)
    assert {*since} - {*after} <= {*both}, "what came since stays"
    assert not ({*after} - {*before}) & {*both}, "what the step added goes"


def test_fields_of_a_record_are_taken_back_one_by_one() -> None:
    before = Job(number="", photos=(Photo(file="a.jpg"),))
    after = Job(number="7", notes="of the head", photos=(Photo(file="a.jpg"), Photo(file="b.jpg")))
    photos = (Photo(file="a.jpg", caption="worn"), Photo(file="b.jpg"))
    now = after.model_copy(update={"notes": "typed since", "photos": photos})
    assert taken_back(now, after, before) == Job(notes="typed since", photos=photos[:1])


def test_a_row_that_was_typed_into_since_is_taken_back_and_not_doubled() -> None:
    proposed, approved = (RepairDecision(component="25", land=1, decision=each) for each in ("proposed", "approved"))
    other = RepairDecision(component="8", work="clean")
    priced = approved.model_copy(update={"price": 10.0})
    before, after = (Job(repair_decisions=(each,)) for each in (proposed, approved))
    now = Job(repair_decisions=(other, priced))
    back = taken_back(now, after, before)
    assert back.repair_decisions == (priced.model_copy(update={"decision": "proposed"}), other)
    assert set(taken_back(back, before, after).repair_decisions) == {priced, other}


def test_a_photo_that_was_taken_away_comes_back_to_its_place() -> None:
    photos = tuple(Photo(file=f"{name}.jpg") for name in "abc")
    assert taken_back(Job(photos=photos[1:]), Job(photos=photos[1:]), Job(photos=photos)).photos == photos
    captioned = (photos[1].model_copy(update={"caption": "worn"}), photos[2])
    assert taken_back(Job(photos=captioned), Job(photos=photos[1:]), Job(photos=photos)).photos == (
        photos[0],
        *captioned,
    )


def test_only_so_many_steps_are_kept(app: AppTest) -> None:
    steps = Steps()
    for _ in range(30):
        steps = steps.with_step(app)
    assert len(steps.past) == 10

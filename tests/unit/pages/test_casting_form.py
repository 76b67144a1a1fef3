"""The photo of a valve body on the page Library, and the verdicts that the diagnosis draws on it."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest
from PIL import Image
from streamlit.testing.v1 import AppTest

from atleak.catalogue.castings import Casting, casting_file, keep_casting, load_casting
from atleak.catalogue.entries import shipped_files, write_own
from tests.unit.pages.conftest import go, part, press, texts

ID = "four_speed_2023"
SCHEMATIC = "Schematic; a clearance is half the difference of the diameters"

pytestmark = pytest.mark.page("20_Library")


def photo(width: int, height: int) -> bytes:
    target = io.BytesIO()
    Image.new("RGB", (width, height), "grey").save(target, "PNG")
    return target.getvalue()


def load(app: AppTest, name: str, content: bytes) -> AppTest:
    place = next(each for each in app.main.file_uploader if each.key.endswith(f"casting-{ID}"))
    app = place.set_value((name, content, "image/png")).run()
    assert not app.exception
    return app


def mounted(app: AppTest, what: str) -> dict[str, Any] | None:
    """What a component of the page is given, told by a name in it."""
    given = (json.loads(each.proto.json) for each in app.get("bidi_component"))
    return next((each for each in given if what in each), None)


def picture(app: AppTest) -> str:
    """The picture of the valve body on the diagnosis."""
    go(app, "4_Diagnosis")
    assert not app.exception
    return next(
        each["html"] for each in (json.loads(part.proto.json) for part in app.get("bidi_component"))
        if "details" in each.get("html", "")
    )  # fmt: skip


def test_a_photo_is_loaded_replaced_removed_and_brought_back(app: AppTest) -> None:
    assert mounted(app, "photo") is None
    load(app, "casting.png", photo(40, 30))
    first = load_casting(ID)
    assert first is not None
    shown = mounted(app, "photo")
    assert shown is not None
    assert shown["photo"] == first.photo
    assert ["25", "25 main pressure valve"] in shown["bores"]
    assert shown["words"]["marked"] == "{count} of {bores} bores marked"
    keep_casting(ID, first.marked({"25": (0.25, 0.5)}))
    app.run()
    assert (mounted(app, "photo") or {})["marks"] == {"25": [0.25, 0.5]}
    load(app, "another.png", photo(20, 60))
    assert (mounted(app, "photo") or {})["marks"] == {}
    press(app, "Bring back the photo before this")
    assert (mounted(app, "photo") or {})["marks"] == {"25": [0.25, 0.5]}
    press(app, "Remove photo")
    assert load_casting(ID) is None
    assert mounted(app, "photo") is None
    press(app, "Bring back the photo before this")
    assert dict(getattr(load_casting(ID), "marks", {})) == {"25": (0.25, 0.5)}


def test_what_is_no_picture_is_refused_and_the_photo_stays(app: AppTest) -> None:
    load(app, "casting.png", photo(40, 30))
    kept = load_casting(ID)
    load(app, "notes.png", b"no picture")
    assert "picture cannot be read" in texts(app)
    assert "notes.png" in texts(app)
    assert load_casting(ID) == kept


def test_the_diagnosis_draws_on_the_photo_and_says_where_it_has_only_a_schematic(app: AppTest) -> None:
    load(app, "casting.png", photo(40, 30))
    kept = load_casting(ID)
    assert kept is not None
    keep_casting(ID, kept.marked({"25": (0.25, 0.5), "14": (0.75, 0.5)}))
    drawn = picture(app)
    assert kept.photo in drawn
    assert drawn.count('class="leader"') == 2 * 2  # a dark line on a light one
    assert "25/1: 57\u00a0µm, was 34" in drawn
    assert "Not marked on the photo:" in drawn  # the others that are flagged
    assert SCHEMATIC not in drawn.replace("&#x27;", "'")
    casting_file(ID).write_text("{", encoding="utf-8")
    drawn = picture(app)
    assert SCHEMATIC in drawn.replace("&#x27;", "'")
    assert "load the photo again on the page Library" in texts(app)
    go(app, "6_Report")
    assert not app.exception  # the report is written, with the schematic


def test_a_valve_body_that_is_renamed_keeps_its_photo(app: AppTest) -> None:
    shipped = shipped_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    write_own("controllers", "my_box", shipped.replace('"minimal_example"', '"my_box"', 1))
    keep_casting("my_box", Casting.of_photo("casting.png", photo(40, 30)))
    part(app, "transmission", "library")
    press(app, "Edit")
    next(each for each in app.text_input if each.label == "Id *").set_value("your_box").run()
    next(each for each in app.checkbox if each.label.startswith("Rename")).check().run()
    press(app, "Save as own file")
    assert not app.exception
    assert load_casting("your_box") == load_casting("my_box") is not None
    press(app, "Undo")
    assert load_casting("my_box") is not None

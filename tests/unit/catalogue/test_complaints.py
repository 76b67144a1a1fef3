"""Which complaints a controller maps, and what its file may not say of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import controllers, load_controller
from atleak.common.errors import CatalogueError, InputError

Edited = Callable[..., Path]
COMPLAINT = """
[[complaints]]
id = "late_reverse"
label = "Late reverse"
conditions = ["hot_idle", "driving_second"]
lands = ["accumulator/1", "pressure_regulator/2"]
source = "diagram"
"""


def with_complaint(edited: Edited, *changes: tuple[str, str], more: str = "") -> Path:
    text = COMPLAINT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = edited("controllers", "minimal_example")
    with path.open("a", encoding="utf-8") as file:
        file.write(text + more)
    return path


def test_a_complaint_names_its_conditions_and_lands(edited: Edited) -> None:
    complaint = load_controller(with_complaint(edited)).complaint("late_reverse")
    assert complaint is not None
    assert (complaint.label, complaint.source) == ("Late reverse", "diagram")
    assert complaint.conditions == ("hot_idle", "driving_second")
    assert complaint.lands == (("accumulator", 1), ("pressure_regulator", 2))
    assert complaint.record["lands"] == ["accumulator/1", "pressure_regulator/2"]


def test_without_lands_and_source_every_land_counts_and_the_file_answers_for_it(edited: Edited) -> None:
    changes = (('lands = ["accumulator/1", "pressure_regulator/2"]\n', ""), ('source = "diagram"\n', ""))
    controller = load_controller(with_complaint(edited, *changes))
    complaint = controller.complaint("late_reverse")
    assert complaint is not None
    assert (complaint.lands, complaint.source) == ((), controller.source)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"hot_idle", ', '"hot_idel", ', ("conditions", "'hot_idel'", "driving_second, hot_idle", "'hot_idle'")),
        ('"hot_idle", ', '"driving_second", ', ("conditions", "operating point given twice")),
        ('["hot_idle", "driving_second"]', "[]", ("conditions", "at least 1")),
        ('"accumulator/1"', '"accumulator/9"', ("lands", "'accumulator/9'", "'accumulator/1'")),
        ('"accumulator/1"', '"accumulator"', ("lands", "no such land in this controller")),
        ('"accumulator/1"', '"pressure_regulator/2"', ("lands", "land given twice")),
        ('label = "Late reverse"', 'labels = "Late reverse"', ("labels", "label")),
        ('id = "late_reverse"', 'id = "Late reverse"', ("id", "Late reverse")),
    ],
)
def test_a_wrong_complaint_is_refused_by_file_table_key_and_value(
    edited: Edited, old: str, new: str, said: tuple[str, ...]
) -> None:
    with pytest.raises(CatalogueError) as caught:
        load_controller(with_complaint(edited, (old, new)))
    for words in ("own.toml", "complaints", *said):
        assert words in str(caught.value)


def test_an_id_given_twice_is_refused(edited: Edited) -> None:
    with pytest.raises(CatalogueError, match=r"complaints\[3\] \(late_reverse\).*given twice"):
        load_controller(with_complaint(edited, more=COMPLAINT))


def test_an_unknown_complaint_lists_the_known_ones(edited: Edited) -> None:
    controller = load_controller(with_complaint(edited))
    with pytest.raises(InputError, match=r"'late_revers'.*slips_hot, late_reverse.*did you mean 'late_reverse'"):
        controller.complaint("late_revers")


def test_a_controller_without_complaints_says_so(edited: Edited, minimal: Controller) -> None:
    path = edited("controllers", "minimal_example")
    text = path.read_text(encoding="utf-8")
    head, _, rest = text.partition("[[complaints]]")
    path.write_text(head + rest[rest.index("[[components]]") :], encoding="utf-8")
    bare = load_controller(path)
    assert bare.complaints == ()
    with pytest.raises(InputError, match=r"maps no complaint to its operating points \(found 'slips_hot'\)"):
        bare.complaint("slips_hot")
    assert bare.complaint(None) is None


@pytest.mark.parametrize("controller", controllers(), ids=lambda controller: controller.id)
def test_every_shipped_complaint_says_where_it_comes_from(controller: Controller) -> None:
    assert controller.complaints
    for complaint in controller.complaints:
        assert "choice of this project" in complaint.source
        assert "assumed" in complaint.source

"""The same fault has the same words, whichever of a person's files it stands in."""

from __future__ import annotations

import re
from typing import Any

import pytest

from atleak.catalogue.limits import LimitsFile
from atleak.common.errors import CatalogueError, InputError
from atleak.common.file_faults import validated
from atleak.common.wording import wording
from atleak.measurements.job_card import Job


def _fault(model: type, data: Any, kind: type[InputError] = InputError) -> InputError:
    with pytest.raises(kind) as caught:
        validated(model, data, "own.toml", kind)
    return caught.value


def test_an_unknown_key_is_named_alike_in_a_job_record_and_in_a_catalogue_file() -> None:
    job = _fault(Job, {"nots": "x"})
    limits = _fault(LimitsFile, {"nots": "x"}, CatalogueError)
    for fault in (job, limits):
        assert fault.problem == "unknown key"
        assert fault.place.key == "nots"
        assert fault.value == "x"
    assert job.nearest == "notes"
    assert limits.nearest == "note"


def test_text_where_a_table_belongs_is_named_alike() -> None:
    assert _fault(Job, {"vehicle": "x"}).expected == "a table"
    limits = _fault(LimitsFile, {"wear_percent": "x"}, CatalogueError)
    assert {fault.place.key: fault.expected for fault in (limits, *limits.others)}["wear_percent"] == "a table"


def test_a_table_in_a_list_is_counted_from_one_and_every_fault_is_listed() -> None:
    fault = _fault(Job, {"photos": [{"file": "a.png"}, {"fil": "b.png"}]})
    assert str(fault.place) == "own.toml, [photos[2]], key 'fil'"
    assert [other.problem for other in fault.others] == ["required key is missing"]


def test_a_long_value_is_shortened() -> None:
    fault = _fault(Job, {"vehicle": "x" * 500})
    assert len(str(fault.value)) < 100


ENGLISH = {"a", "expected", "found", "greater", "is", "less", "must", "not", "or", "than", "value", "with"}


@pytest.mark.parametrize("language", ["de", "pl"])
def test_every_fault_of_a_file_is_said_in_the_reader_s_language(language: str) -> None:
    table = {"origin": "published", "source": "x"}
    fault = _fault(
        LimitsFile,
        {
            "id": "Own limits", "name": " ", "source": 5, "date": "soon", "nots": "x",
            "wear_percent": {**table, "watch": 20.0, "replace": 10.0},
            "clearance_um": {**table, "watch": "wide"},
            "pair_share_percent": table,
            "total_share_percent": {**table, "origin": "mine", "amber": -1, "red": 2, "critical": {"percent": -3}},
            "reserve": {**table, "amber": 1.0, "red": 2.0, "critical": 0.5, "fall_percent": 120},
        },
        CatalogueError,
    )  # fmt: skip
    said = wording(language).sentence(fault.sentence)
    assert len(said.splitlines()) == len(str(fault).splitlines()) == 12
    assert not ENGLISH & set(re.findall(r"\w+", said)), said

"""The columns of the data sets: which there are, of which type."""

from __future__ import annotations

import re
from pathlib import Path

import pyarrow as pa
import pytest

from atleak.fleet.columns import DATA_SETS, ERROR_KINDS, HASH, PARTITION, columns_of
from atleak.report.json.schemas import schema


@pytest.mark.parametrize("data_set", DATA_SETS)
def test_every_data_set_says_of_which_unit_its_rows_are(data_set: str) -> None:
    columns = columns_of(data_set)  # type: ignore[arg-type]  # one of them
    assert columns.names[0] == HASH
    assert len(set(columns.names)) == len(columns.names)
    assert PARTITION not in columns.names, "the folder's name says it"


def test_lands_have_the_keys_of_the_record_with_their_types() -> None:
    columns = columns_of("lands")
    assert columns.names == [HASH, *schema("diagnose")["$defs"]["land"]["properties"]]
    types = {name: columns.field(name).type for name in columns.names}
    assert types["component"] == types["verdict"] == types["decision"] == types["seal"] == pa.string()
    assert types["land"] == types["spool_readings"] == pa.int64()
    assert types["wear_percent"] == types["radial_clearance_um"] == pa.float64()
    assert types["suspect"] == pa.bool_()
    assert types["representative"] == pa.list_(pa.string())
    at_condition = types["conditions"].value_type
    assert {field.name: field.type for field in at_condition}["share_percent"] == pa.float64()
    place = {field.name: field.type for field in types["messages"].value_type}["place"]
    assert {field.name: field.type for field in place} == {
        **dict.fromkeys(("file", "sheet", "column", "table", "key"), pa.string()),
        "row": pa.int64(),
    }


def test_circuits_stand_in_a_data_set_of_their_own() -> None:
    assert "circuits" not in columns_of("conditions").names
    assert columns_of("circuits").names[:3] == [HASH, "condition", "id"]
    assert "test" not in columns_of("events").names


def test_the_page_on_fleets_names_every_column_that_stands_in_no_record(root: Path) -> None:
    text = (root / "docs" / "fleet.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(\w+)`", text))
    assert {*DATA_SETS, PARTITION} <= named
    for data_set in ("units", "temperatures", "errors"):
        assert set(columns_of(data_set).names) <= named
    assert all(f"`{kind}`" in text for kind in ERROR_KINDS)

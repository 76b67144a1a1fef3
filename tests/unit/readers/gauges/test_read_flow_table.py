"""Tables of flows that were caught in a jug."""

from __future__ import annotations

import io

import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import FlowTableError
from atleak.common.units import DM3_MIN, find_unit, kinds_of
from atleak.common.wording import wording
from atleak.measurements.flow_readings import COOLER, consumer_of
from atleak.readers.gauges.value_table import read_flow_table


@pytest.fixture(scope="module")
def unit() -> Controller:
    return load_controller("five_speed_2005")


def flows(text: str, unit: Controller) -> list[tuple[str, str, float]]:
    table = read_flow_table(text.encode(), unit, name="flows.csv")
    return [(each.condition, each.what, round(each.flow * DM3_MIN, 6)) for each in table.readings]


def refused(text: str, unit: Controller) -> str:
    with pytest.raises(FlowTableError) as caught:
        read_flow_table(text.encode(), unit, name="flows.csv")
    return str(caught.value)


def test_a_jug_and_a_watch(unit: Controller) -> None:
    assert flows(
        "condition,what,value,unit\nhot_idle,cooler,946,ml/15 s\nstall,cooler,1,qt in 20 s\n"
        "hot idle,converter_and_cooler,3.8,l/min\nhot_idle,front_lubrication,1 gpm,\nhot_idle,cooler,3.5 dm³/min,\n",
        unit,
    ) == [
        ("hot_idle", "cooler", 3.784),
        ("stall", "cooler", 2.839059),
        ("hot_idle", "converter_and_cooler", 3.8),
        ("hot_idle", "front_lubrication", 3.785412),
        ("hot_idle", "cooler", 3.5),
    ]


def test_german_words_a_decimal_comma_and_no_headings(unit: Controller) -> None:
    assert flows("Betriebspunkt;Was;Wert;Einheit\nhot_idle;Kühler;946,5;ml in 15 s\n", unit) == [
        ("hot_idle", COOLER, 3.786)
    ]
    assert flows("hot_idle;Kühler;3,8;l/min\n", unit) == [("hot_idle", COOLER, 3.8)]
    label = next(point.label for point in unit.operating_points if point.name == "stall")
    german = wording("de").name(label)
    assert flows(f"Betriebspunkt;Was;Durchfluss [l/min]\n{german};Ölkühler;7,5\n", unit) == [("stall", COOLER, 7.5)]


@pytest.mark.parametrize("written", ["hot idle in drive", "hot idle in drive, 212 °F", "heißer Leerlauf in D"])
def test_an_operating_point_as_people_see_it(written: str, unit: Controller) -> None:
    assert flows(f"condition;what;value\n{written};cooler;3.8 l/min\n", unit)[0][0] == "hot_idle"


def test_a_workbook(unit: Controller) -> None:
    book = openpyxl.Workbook()
    for row in (("condition", "what", "value", "unit"), ("hot_idle", "cooler", 900, "ml/15 s")):
        book.active.append(row)
    target = io.BytesIO()
    book.save(target)
    table = read_flow_table(target.getvalue(), unit, name="flows.xlsx")
    assert (table.sheet, table.readings[0].flow) == ("Sheet", pytest.approx(6e-5, abs=0.0))
    assert (table.readings[0].place.row, table.readings[0].place.column) == (2, "C")


def test_everything_wrong_is_listed(unit: Controller) -> None:
    lines = refused(
        "condition,what,value,unit\nhot_idl,coler,946,ml/15\nhot_idle,cooler,much,l/min\n,cooler,-3,l/min\n", unit
    ).splitlines()
    assert "flows.csv, row 2, column condition: no such operating point" in lines[0]
    assert "did you mean 'hot_idle'" in lines[0]
    assert "column what: no such consumer of this unit (found 'coler')" in lines[1]
    assert "did you mean 'cooler'" in lines[1]
    assert "unknown unit (found 'ml/15'); expected one of l/min, dm³/min, ml/15 s, qt in 20 s, gpm" in lines[2]
    assert "row 3, column value: not accepted as flow (found 'much')" in lines[3]
    assert "no operating point in this row" in lines[4]
    assert "found '-3'" in lines[5]
    assert "expected 0 to 100 l/min" in lines[5]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the file is empty"),
        ("a;b\n1;2\n", "holds no table of flows"),
        ("condition;what;value\nhot_idle;cooler;3.8\n", "no unit stands with this value"),
        ("condition;what;value\nhot_idle;cooler;\n", "no flow is filled in"),
        ("condition;what;value;unit\nhot_idle;cooler;1.500;ml/15 s\n", "can be read in two ways"),
    ],
)
def test_refused(text: str, said: str, unit: Controller) -> None:
    assert said in refused(text, unit)


def test_the_cooler_is_the_consumer_that_speaks_of_one(unit: Controller) -> None:
    found = consumer_of(unit, COOLER)
    assert found is not None
    assert found.id == "converter_and_cooler"
    assert consumer_of(unit, "front_lubrication") is not unit.consumers[0]
    assert consumer_of(load_controller("minimal_example"), COOLER) is None


def test_a_volume_in_a_time_is_a_flow_and_no_unit_of_a_log() -> None:
    quart = 231 * 0.0254**3 / 4
    assert find_unit("qt/20s", "flow").factor == pytest.approx(quart / 20, rel=1e-9, abs=0.0)
    assert find_unit("ml / 12,5 s", "flow").factor == pytest.approx(1e-6 / 12.5, abs=0.0)
    assert find_unit("gpm", "flow").factor == pytest.approx(4 * quart / 60, rel=1e-8, abs=0.0)
    assert find_unit("ml/0 s", "flow") is None
    assert kinds_of("l/min") == kinds_of("ml/15 s") == []
    assert kinds_of("kPa") == ["pressure"]

"""A pump past its limits leads the page Plan: its order of repair and its lines."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import tomli_w
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller_file import checked_controller
from atleak.measurements.readings import Readings
from atleak.report.sheets.measuring_columns import PUMP_SIDE
from atleak.report.sheets.measuring_sheet import write_readings
from tests.unit.pages.conftest import choice, go, opened, texts, uploader

pytestmark = pytest.mark.page("2_Measure")


@pytest.fixture(scope="module")
def app(
    tmp_path_factory: pytest.TempPathFactory, root: Path, readings_of: Callable[..., Readings]
) -> Iterator[AppTest]:
    """The dashboard with a sheet of new pairs whose head states a side clearance past the limit of the pump."""
    folder = tmp_path_factory.mktemp("worn_pump")
    data = tomllib.loads((root / "tests" / "three_circuits.toml").read_text(encoding="utf-8"))
    data["pump"] |= {"kind": "crescent", "side_clearance_limit_um": 50.0, "published": ["side_clearance_limit_um"]}
    repair = {"id": "pump", "component": "pump", "kind": "overhaul", "name": "new gears", "source": "made up"}
    data["repairs"] = [{**repair, "price": 120.0, "currency": "EUR", "hours": 2.0}]
    own = folder / "home" / "catalogue" / "controllers" / f"{data['id']}.toml"
    own.parent.mkdir(parents=True)
    own.write_text(tomli_w.dumps(data), encoding="utf-8")
    unit = checked_controller(data)
    pairs = {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * land.new_clearance) for land in unit.lands}
    sheet = write_readings(unit, readings_of(unit, pairs).readings, fields={PUMP_SIDE: "85"})
    for app in opened(folder, "2_Measure"):
        choice(app, "Valve body").select(unit.id).run()
        uploader(app, "Measuring sheet").upload("sheet.xlsx", sheet, "application/x").run()
        yield app


def test_the_plan_names_the_pump_first_with_its_repair(app: AppTest) -> None:
    go(app, "5_Plan#order-of-repair")
    assert not app.exception
    assert "Repair the pump first." in texts(app)
    (first, *_) = [widget.label.replace("\\", "") for widget in app.main.toggle]
    assert first.startswith("**pump** · ■ replace: new gears")
    assert "work in no sum: pump." in texts(app)
    order, options = (
        next(frame.value for frame in app.dataframe if column in frame.value) for column in ("Helps most at", "Use")
    )
    assert order["Helps most at"].tolist() == ["for its own verdict: what a new one brings is not known"]
    assert order.iloc[0].astype(str).str.fullmatch("pump").any()
    assert (options["Repair"].tolist(), options["Use"].tolist()) == (["new gears"], ["planned"])
    assert not options.astype(str).apply(lambda cells: cells.str.contains("<")).any(axis=None)

"""The repairs that a valve body's file names: which are planned, what they leave, what they cost, and who shows it."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from atleak.analysis.repair.options import Options
from atleak.analysis.repair.plan import RepairPlan, plan_repairs
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.catalogue.repairs import Repair
from atleak.common.errors import InputError
from atleak.common.wording import begun, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import project, stated_condition
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.pdf.conditions import Conditions
from atleak.report.printed_names import PrintedNames
from atleak.report.tables.repairs import option_rows, plan_ends, planned
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook
from tests.unit.conftest import first_of

EN = wording("en")

Build = Callable[..., Readings]
PlanOf = Callable[..., tuple[Diagnosis, RepairPlan]]
PR = "pressure_regulator"


def repair(number: int, kind: str, **values: object) -> str:
    stated = {"component": PR, "kind": kind, "id": f"option_{number}", "name": f"option {number}", "source": "made up"}
    lines = [f"{key} = {_toml(value)}" for key, value in {**stated, **values}.items()]
    return "\n[[repairs]]\n" + "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


@pytest.fixture
def plan_of(tmp_path: Path, hipol: Fluid, limits: Limits, readings_of: Build) -> PlanOf:
    """Plans the repairs of the minimal example with some repairs in its file and both regulator lands worn."""

    def build(
        *repairs: str, worn: tuple[int, ...] = (1, 2), limits_of: dict[int, float] | None = None
    ) -> tuple[Diagnosis, RepairPlan]:
        path = tmp_path / "own.toml"
        text = load_controller("minimal_example").origin.path.read_text(encoding="utf-8")
        for land, most in (limits_of or {}).items():
            stated = f"{{ land = {land}, nominal_diameter_mm = {15.0 if land == 1 else 12.5}, "
            assert stated in text
            text = text.replace(stated, f"{stated}clearance_limit_um = {most}, ", 1)
        path.write_text(text + "".join(repairs), encoding="utf-8")
        controller = load_controller(path)
        readings = readings_of(controller, {(PR, land): _worn(controller, land) for land in worn})
        diagnosis = diagnose(controller, hipol, limits, readings=readings)
        return diagnosis, plan_repairs(diagnosis)

    return build


def _worn(controller: Controller, land: int) -> tuple[float, float]:
    nominal = controller.land(PR, land).nominal_diameter
    return nominal, nominal + 2.0 * 45e-6


def printed(diagnosis: Diagnosis, capsys: pytest.CaptureFixture[str]) -> str:
    print_diagnosis(diagnosis)
    return " ".join(capsys.readouterr().out.split())


def chosen(plan: RepairPlan) -> list[tuple[tuple[str, int], str | None]]:
    return [(step.land.key, step.chosen and step.chosen.repair.id) for step in plan.steps]


def test_without_repairs_in_the_file_every_land_is_as_new_and_nothing_is_said(
    plan_of: PlanOf,
    capsys: pytest.CaptureFixture[str],
) -> None:
    diagnosis, plan = plan_of()
    assert [option for _, option in chosen(plan)] == [None, None]
    assert plan.cost is None
    assert not option_rows(plan)
    said = " ".join([*plan_ends(plan, EN), printed(diagnosis, capsys)])
    assert "each land as new after those before it" in said
    assert "repair" not in " ".join(plan_ends(plan, EN)).lower()


def test_the_cheapest_repair_that_leaves_a_land_within_its_limit_is_planned_and_computed_with(
    plan_of: PlanOf,
) -> None:
    diagnosis, plan = plan_of(
        repair(1, "new_casting", price=400.0, currency="USD", hours=4.0),
        repair(2, "clean_and_reuse", price=5.0, currency="USD", hours=0.5),  # leaves what was measured
        repair(3, "other", price=10.0, currency="USD", mounting_clearance_um=40.0),  # past the limit of 30
        repair(
            4,
            "oversize_valve",
            lands=[1],
            price=60.0,
            currency="USD",
            hours=1.5,
            nominal_diameter_mm=15.3,
            mounting_clearance_um=[10.0, 20.0],
        ),
        worn=(1,),
        limits_of={1: 30.0},
    )
    assert chosen(plan) == [((PR, 1), "option_4")]
    step = plan.steps[0]
    assert {option.repair.id: option.mends((PR, 1)) for option in step.options} == {
        "option_1": True,
        "option_2": False,
        "option_3": False,
        "option_4": True,
    }
    state = step.chosen.states[PR, 1]
    assert state.spool_diameter == pytest.approx(15.3e-3, abs=1e-12)
    assert state.radial_clearance == pytest.approx((((20e-6) ** 4 - (10e-6) ** 4) / (4 * 10e-6)) ** (1 / 3), abs=1e-10)
    states = tuple(state if land.key == (PR, 1) else land.state for land in diagnosis.lands)
    model = LeakageModel(diagnosis.controller, states, diagnosis.fluid, diagnosis.profile)
    for each in step.conditions:
        assert each.after.share == pytest.approx(project(model, each.condition).share, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("name", first_of(["minimal_example", "zf_6hp26", "five_speed_2005", "gm_4l60e"]))
def test_a_repair_that_leaves_a_land_worn_is_none_however_cheap(
    name: str, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    controller = load_controller(name)
    land = next(each for each in controller.lands if not each.seal)
    new, made_up = land.mounting_high, ("made up", "made up")
    widths = {"nearly_all": 1.99 * new, "worn": 1.45 * new, "as_new": new}
    options = tuple(
        Repair(id, (land.key,), "other", *made_up, price=10.0 * price, currency="USD")
        for price, id in enumerate(widths, start=1)
    )
    options = tuple(replace(each, mounting_clearance=widths[each.id]) for each in options)
    worn = {land.key: (land.nominal_diameter, land.nominal_diameter + 4.0 * new)}
    described = replace(controller, repairs=options)
    diagnosis = diagnose(described, hipol, limits, readings=readings_of(controller, worn))
    plan = plan_repairs(diagnosis)
    assert chosen(plan) == [(land.key, "as_new")]
    assert plan.reached
    mended = {option.repair.id: option.mends(land.key) for option in plan.steps[0].options}
    assert mended == {"nearly_all": False, "worn": False, "as_new": True}
    still = stated_condition(described, engine_speed=1.0 / 60.0)  # at which most pumps deliver nothing
    [*_, as_new] = Options(
        diagnose(described, hipol, limits, readings=readings_of(controller, worn), condition=still)
    ).all
    assert as_new.mends(land.key)
    # what is measured after each agrees
    for id, width in widths.items():
        after = {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * width)}
        again = diagnose(controller, hipol, limits, readings=readings_of(controller, after))
        verdict = next(each.verdict for each in again.lands if each.key == land.key)
        assert verdict.flagged == (not mended[id])
    # the workshop's own choice is planned, and not called enough
    plan = plan_repairs(replace(diagnosis, repairs=options[:1]))
    assert chosen(plan) == [(land.key, "nearly_all")]
    assert not plan.reached
    assert any(
        said.startswith("Past a limit of their own with the repair that was chosen:") for said in plan_ends(plan, EN)
    )


def test_a_repair_that_leaves_more_than_the_share_of_one_land_is_none(hipol: Fluid, readings_of: Build) -> None:
    controller, limits = load_controller("five_speed_2005"), load_limits("project_default")
    sealed = {land.key for land in controller.lands if land.seal}
    at_idle = diagnose(controller, hipol, limits).projection
    key = max((land.key for land in controller.lands if land.key not in sealed), key=at_idle.share_drawn_by)
    land = controller.land(*key)
    only_shares = replace(limits, wear=None, clearance=None)
    repair = Repair("wide", (land.key,), "other", "wide", "made up")
    worn = {key: (land.nominal_diameter, land.nominal_diameter + 2.0 * 200e-6)}
    for width, mends in ((190e-6, False), (land.mounting_high, True)):
        described = replace(controller, repairs=(replace(repair, mounting_clearance=width),))
        diagnosis = diagnose(described, hipol, only_shares, readings=readings_of(controller, worn))
        [option] = Options(diagnosis).all
        assert option.mends(key) is mends


def test_one_repair_of_a_whole_valve_mends_its_lands_in_one_step_where_it_is_not_dearer(
    plan_of: PlanOf,
) -> None:
    single = [repair(number, "sleeve", lands=[number], price=50.0, currency="EUR", hours=1.0) for number in (1, 2)]
    _, plan = plan_of(
        *single, repair(3, "new_valve", price=90.0, currency="EUR", hours=1.0, mounting_clearance_um=15.0)
    )
    assert chosen(plan) == [((PR, 1), "option_3")]
    assert [land.key for land in plan.steps[0].together] == [(PR, 2)]
    assert plan.cost.prices == {"EUR": 90.0}
    _, dearer = plan_of(*single, repair(3, "new_valve", price=110.0, currency="EUR", mounting_clearance_um=15.0))
    assert sorted(chosen(dearer)) == [((PR, 1), "option_1"), ((PR, 2), "option_2")]
    assert (dearer.cost.prices, dearer.cost.hours) == ({"EUR": 100.0}, 2.0)
    assert [end.share for end in plan.ends] < [end.share for end in dearer.ends]  # 15 µm against 18 µm as new


def test_a_land_that_no_repair_of_the_file_mends_is_as_new_and_said(
    plan_of: PlanOf,
) -> None:
    _, plan = plan_of(repair(1, "clean_and_reuse", lands=[1]), worn=(1,))
    assert chosen(plan) == [((PR, 1), None)]
    assert plan.steps[0].options
    said = " ".join(plan_ends(plan, EN))
    assert "names no repair that brings them within their limit: 1" in said
    assert plan.cost.without_option == 1


def test_prices_in_two_currencies_are_added_apart_and_never_compared(
    plan_of: PlanOf,
) -> None:
    _, plan = plan_of(
        repair(1, "sleeve", lands=[1], price=500.0, currency="PLN"),
        repair(2, "sleeve", lands=[1], price=90.0, currency="EUR"),
        repair(3, "sleeve", lands=[2], price=90.0, currency="EUR"),
    )
    assert sorted(chosen(plan)) == [((PR, 1), "option_1"), ((PR, 2), "option_3")]
    assert plan.cost.prices == {"PLN": 500.0, "EUR": 90.0}
    assert plan.cost.without_hours == 2
    said = " ".join(plan_ends(plan, EN))
    assert "Parts 500.00 PLN + 90.00 EUR, work – h. Not in these sums" in said.replace("\u00a0", " ")


@pytest.mark.parametrize("name", first_of(["minimal_example", "five_speed_2005", "zf_6hp26", "gm_4l60e"]))
def test_a_currency_is_one_however_its_code_is_typed(
    name: str, tmp_path: Path, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    controller, path = load_controller(name), tmp_path / "own.toml"
    lands = {component: controller.lands_of(component) for component in controller.components}
    component, (one, other, *_) = next(each for each in lands.items() if len([x for x in each[1] if not x.seal]) > 1)
    text = controller.origin.path.read_text(encoding="utf-8")
    worn = {
        land.key: (land.nominal_diameter, land.nominal_diameter + 6.0 * land.mounting_high) for land in (one, other)
    }
    for typed, expected in (("usd", {"USD": 80.0}), (" Usd ", {"USD": 80.0}), ("PLN", {"USD": 500.0})):
        path.write_text(
            text
            + repair(1, "new_valve", component=component, lands=[one.land, other.land], price=500.0, currency="USD")
            + repair(2, "sleeve", component=component, lands=[one.land], price=40.0, currency=typed)
            + repair(3, "sleeve", component=component, lands=[other.land], price=40.0, currency=typed),
            encoding="utf-8",
        )
        own = load_controller(path)
        plan = plan_repairs(diagnose(own, hipol, limits, readings=readings_of(own, worn)))
        assert plan.cost.prices == expected
        told = [said for said in plan_ends(plan, EN) if "are in USD, PLN, which are not compared" in said]
        assert bool(told) == (typed == "PLN")


def test_a_repair_without_a_price_comes_after_those_with_one(
    plan_of: PlanOf,
) -> None:
    _, plan = plan_of(
        repair(1, "sleeve", lands=[1]), repair(2, "sleeve", lands=[1], price=900.0, currency="EUR"), worn=(1,)
    )
    assert chosen(plan) == [((PR, 1), "option_2")]
    _, unknown = plan_of(repair(1, "sleeve", lands=[1]), worn=(1,))
    assert "Repairs planned: 1. The valve body's file states neither price nor hours of them." in plan_ends(
        unknown, wording("en")
    )


def test_terminal_record_and_workbook_show_options_price_and_sum(
    plan_of: PlanOf,
    capsys: pytest.CaptureFixture[str],
) -> None:
    diagnosis, plan = plan_of(
        repair(
            1,
            "oversize_valve",
            price=61.5,
            currency="USD",
            hours=1.5,
            part_number="MADE-UP-1",
            tool="reamer MADE-UP-R",
            mounting_clearance_um=15.0,
            evidence="representative",
        ),
        repair(2, "new_casting", price=400.0, currency="USD"),
    )
    text = printed(diagnosis, capsys)
    assert "→ option 1 (MADE-UP-1) (assumed), leaves 15.0 µm, 61.50 USD, 1.5 h, reamer MADE-UP-R" in text
    assert "or option 2" in text
    assert "Repairs planned: 1. Parts 61.50 USD, work 1.5 h." in text
    assert "assumed for 1 of them" in text
    record = diagnosis_record(diagnosis)
    step = record["repair_plan"][0]
    assert step["chosen"] == "option_1"
    assert [option["id"] for option in step["options"]] == ["option_1", "option_2"]
    assert step["options"][0]["clearance_after_um"] == pytest.approx(15.0, abs=1e-9)
    assert step["together"] == [{"component": PR, "land": 2}]
    assert record["repair_plan_ends"]["cost"] == {
        "prices": [{"price": 61.5, "currency": "USD"}],
        "hours": 1.5,
        "repairs": 1,
        "without_price": 0,
        "without_hours": 0,
        "without_option": 0,
    }
    book = openpyxl.load_workbook(io.BytesIO(write_workbook(diagnosis)))
    cells = {cell.value for row in book.worksheets[0] for cell in row}
    assert {61.5, "option 1 (MADE-UP-1) (assumed)", "planned", "reamer MADE-UP-R"} <= cells
    assert planned(option_rows(plan)[0], EN).endswith(f"together on lands {PR}/1, {PR}/2")


@pytest.mark.parametrize("language", ["de", "pl"])
def test_every_language_prints_the_repairs_and_what_they_cost(language: str, plan_of: PlanOf) -> None:
    say = wording(language)
    diagnosis, plan = plan_of(repair(1, "sleeve", price=1061.5, currency="EUR", hours=1.5, mounting_clearance_um=12.5))
    said = " ".join(plan_ends(plan, say))
    assert "061,50 EUR" in said
    assert "1,5 h" in said
    blocks = [block for block in Conditions(PrintedNames(diagnosis, Job(), say)).repair_order() if block]
    texts = [block["text"] for block in blocks if block["kind"] == "text"]
    assert any(each.startswith(say("texts.repair_order_by_options")) for each in texts)
    tables = [block for block in blocks if block["kind"] == "table"]
    table = next(each for each in tables if begun(say("columns.use")) in each["names"])
    row, told = table["rows"]
    assert {"option 1", say("plan.chosen"), "12,5", "1,5"} <= set(row)
    name = say.name(diagnosis.controller.components[PR])
    assert f"{name}/1, {name}/2" in told[0]["remark"]


def test_what_the_workshop_chooses_goes_before_the_cheapest_and_stays_in_the_job_file(
    tmp_path: Path, plan_of: PlanOf
) -> None:
    diagnosis, _ = plan_of(
        repair(1, "sleeve", price=50.0, currency="EUR", mounting_clearance_um=12.0),
        repair(2, "new_valve", price=90.0, currency="EUR", mounting_clearance_um=10.0),
    )
    path = tmp_path / "own.toml"
    lines = ["Valve;Land;Part;Diameter [mm]"]
    for land in (1, 2):
        spool, sleeve = (diameter * 1e3 for diameter in _worn(diagnosis.controller, land))
        lines += [f"{PR};{land};spool;{spool:.4f}", f"{PR};{land};bore;{sleeve:.4f}"]
    sheet = tmp_path / "sheet.csv"
    sheet.write_text("\n".join(lines), encoding="utf-8")
    case = Case(readings=SourceFile.at(sheet), controller=SourceFile.at(path))
    assert chosen(plan_repairs(case.diagnose()))[0][1] == "option_1"
    other = replace(case, repairs=("option_2",))
    wanted = other.diagnose()
    assert chosen(plan_repairs(wanted))[0][1] == "option_2"
    bundle = write_job_file(wanted, case=other)
    assert read_job_file(bundle).case.repairs == ("option_2",)
    with pytest.raises(InputError, match="names no such repair"):
        replace(case, repairs=("option_3",)).diagnose()
    with pytest.raises(InputError, match="both repair component pressure_regulator land 1"):
        replace(case, repairs=("option_1", "option_2")).diagnose()


def test_a_land_that_the_chosen_repair_changes_and_does_not_mend_has_a_step_of_its_own(plan_of: PlanOf) -> None:
    """Land 2 may be 15 µm wide at most by its own limit, so that a valve which leaves 16 µm mends land 1 alone."""
    diagnosis, plan = plan_of(
        repair(1, "new_valve", price=50.0, currency="EUR", mounting_clearance_um=16.0), limits_of={1: 30.0, 2: 15.0}
    )
    assert chosen(plan) == [((PR, 1), "option_1"), ((PR, 2), None)]
    assert not plan.steps[0].together
    states = plan.steps[0].chosen.states
    assert states[PR, 2].radial_clearance == pytest.approx(16e-6, abs=1e-12)
    new = diagnosis.controller.land(PR, 2).new_clearance
    after = [
        replace(state, stations=())
        for state in (
            states[PR, 1],
            replace(states[PR, 2], radial_clearance=new, sleeve_diameter=states[PR, 2].spool_diameter + 2.0 * new),
            *(land.state for land in diagnosis.lands[2:]),
        )
    ]
    model = LeakageModel(diagnosis.controller, tuple(after), diagnosis.fluid, diagnosis.profile)
    for end in plan.ends:
        assert end.share == pytest.approx(project(model, end.condition).share, rel=1e-9, abs=0.0)


def test_new_parts_are_within_any_limit_and_a_choice_that_mends_nothing_says_so(plan_of: PlanOf) -> None:
    repairs = [repair(1, "new_casting"), repair(2, "clean_and_reuse")]
    diagnosis, plan = plan_of(*repairs, worn=(1,), limits_of={1: 18.0})
    assert chosen(plan) == [((PR, 1), "option_1")]
    diagnosis = replace(diagnosis, repairs=diagnosis.controller.repairs[1:])
    plan = plan_repairs(diagnosis)
    assert chosen(plan) == [((PR, 1), "option_2")]
    assert option_rows(plan)[0].use(wording("en")) == "planned, does not bring it within its limit"
    assert plan.ends[0].share == pytest.approx(diagnosis.projections[0].share, rel=1e-9, abs=0.0)

"""A verdict that rests on representative values is provisional and says on which; one that does not is not."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest

from atleak.analysis.assumed import assumed_values
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller, load_controller
from atleak.catalogue.entries import read_tables
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.translations import languages
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.provisional import AssumedBasis
from atleak.measurements.readings import Readings
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.assumed import assumed_table
from atleak.report.tables.sentences import caveat_marks
from atleak.report.terminal import print_diagnosis

Build = Callable[..., Readings]
UM = 1e-6


def described(evidence: str) -> dict[str, Any]:
    """The minimal example with its values known from something else, and with its gaps described."""
    tables = copy.deepcopy(read_tables("controllers", "minimal_example")[0])
    tables["representative_values"], tables["representative"] = [], ""
    tables["defaults"][evidence] = ["nominal_diameter_mm", "contact_length_mm", "mounting_clearance_um"]
    tables["pump"]["representative"] = []
    for table in (*tables["materials"].values(), *tables["operating_points"]):
        table["evidence"] = evidence
    tables["gaps"] = [
        {"component": each["id"], "land": land["land"], "from": "p_g", "to": "0", "gears": [1, 2], "evidence": evidence}
        for each in tables["components"]
        for land in each["lands"]
    ]
    return tables


def with_clearances(controller: Controller, clearance: float, readings_of: Build) -> Readings:
    return readings_of(
        controller,
        {each.key: (each.nominal_diameter, each.nominal_diameter + 2.0 * clearance) for each in controller.lands},
    )


@pytest.fixture(scope="module")
def data_sheet_fluid() -> Fluid:
    return load_fluid("mobil_atf_220")  # of its values the change of density with temperature is representative


def test_what_rests_on_readings_and_publications_alone_is_not_provisional(
    data_sheet_fluid: Fluid, limits: Limits, readings_of: Build
) -> None:
    unit = checked_controller(described("published"))
    for clearance in (14 * UM, 60 * UM):
        sheet = with_clearances(unit, clearance, readings_of)
        diagnosis = diagnose(unit, data_sheet_fluid, limits, readings=sheet)
        assert diagnosis.verdict != Verdict.NOT_MEASURED
        assert diagnosis.provisional == ()
        assert not diagnosis.upper_bound
        assert caveat_marks(diagnosis, wording("en")) == []


@pytest.mark.parametrize(
    ("change", "basis"),
    [
        (lambda tables: tables["pump"].update(representative=["displacement_mm3"]), AssumedBasis.PUMP),
        (lambda tables: tables["gaps"][2].update(evidence="representative"), AssumedBasis.GAPS),
        (lambda tables: tables["operating_points"][1].update(evidence="representative"), AssumedBasis.OPERATING_POINT),
        (lambda tables: tables["materials"]["steel"].update(evidence="representative"), AssumedBasis.MATERIALS),
        (
            lambda tables: (
                tables["defaults"].update(published=["nominal_diameter_mm", "mounting_clearance_um"]),
                tables.update(representative_values=["contact_length_mm"]),
            ),
            AssumedBasis.CONTACT_LENGTH,
        ),
    ],
)
def test_a_unit_within_its_limits_rests_on_every_value(
    change: Callable[[dict[str, Any]], None],
    basis: AssumedBasis,
    data_sheet_fluid: Fluid,
    limits: Limits,
    readings_of: Build,
) -> None:
    tables = described("published")
    change(tables)
    unit = checked_controller(tables)
    new = {each.key: (each.nominal_diameter, each.nominal_diameter + 2.0 * each.new_clearance) for each in unit.lands}
    diagnosis = diagnose(unit, data_sheet_fluid, limits, readings=readings_of(unit, new))
    assert diagnosis.verdict == Verdict.OK
    assert diagnosis.provisional == (basis,)


def test_a_worn_land_rests_on_its_mounting_clearance_alone(
    data_sheet_fluid: Fluid, limits: Limits, readings_of: Build
) -> None:
    five = load_controller("five_speed_2005")  # its mounting clearances are published, most else is representative
    worn = with_clearances(five, 12 * UM, readings_of)
    assert set(diagnose(five, data_sheet_fluid, limits, readings=worn).provisional) >= {
        AssumedBasis.GAPS,
        AssumedBasis.PUMP,
    }
    land = five.lands[0]
    diameters = {each.key: (each.nominal_diameter, each.nominal_diameter + 24 * UM) for each in five.lands}
    diameters[land.key] = (land.nominal_diameter, land.nominal_diameter + 80 * UM)
    diagnosis = diagnose(five, data_sheet_fluid, limits, readings=readings_of(five, diameters))
    assert diagnosis.decided_by is diagnosis.flagged[0]
    assert diagnosis.decided_by.deciding.kind in (RuleKind.WEAR, RuleKind.CLEARANCE)
    assert (diagnosis.verdict, diagnosis.provisional) == (Verdict.REPLACE, ())


@pytest.mark.parametrize(
    ("measured", "representative", "bases"),
    [
        ("spool", "nominal_diameter_mm", (AssumedBasis.NOMINAL_DIAMETER,)),
        ("spool", "mounting_clearance_um", (AssumedBasis.MOUNTING_CLEARANCE,)),
        ("sleeve", "nominal_diameter_mm", (AssumedBasis.NOMINAL_DIAMETER,)),
        ("both", "nominal_diameter_mm", ()),
    ],
)
def test_a_land_of_which_one_part_was_measured_rests_on_what_stands_for_the_other(
    measured: str,
    representative: str,
    bases: tuple[AssumedBasis, ...],
    data_sheet_fluid: Fluid,
    limits: Limits,
    readings_of: Build,
) -> None:
    tables = described("published")
    known = tables["defaults"]["published"]
    tables["defaults"]["published"] = [key for key in known if key != representative]
    tables["representative_values"] = [representative]
    unit = checked_controller(tables)
    land, wear = unit.lands[0], 100 * UM
    spool = None if measured == "sleeve" else land.nominal_diameter - wear
    sleeve = None if measured == "spool" else land.nominal_diameter + wear
    diagnosis = diagnose(unit, data_sheet_fluid, limits, readings=readings_of(unit, {land.key: (spool, sleeve)}))
    assert diagnosis.flagged
    assert diagnosis.decided_by is diagnosis.flagged[0]
    assert diagnosis.provisional == bases


@pytest.mark.parametrize(
    ("representative", "slip", "bases"),
    [
        ("volumetric_efficiency", 4e-8, ()),
        ("volumetric_efficiency", None, (AssumedBasis.PUMP,)),
        ("slip_coefficient", 4e-8, (AssumedBasis.PUMP,)),
    ],
)
def test_a_verdict_rests_on_the_efficiency_of_a_pump_only_where_no_slip_is_known(
    representative: str,
    slip: float | None,
    bases: tuple[AssumedBasis, ...],
    data_sheet_fluid: Fluid,
    limits: Limits,
    readings_of: Build,
) -> None:
    tables = described("published")
    tables["pump"].update(representative=[representative], **({} if slip is None else {"slip_coefficient": slip}))
    unit = checked_controller(tables)
    diagnosis = diagnose(unit, data_sheet_fluid, limits, readings=with_clearances(unit, 10 * UM, readings_of))
    assert diagnosis.provisional == bases


def test_nothing_measured_is_no_provisional_verdict(four_speed: Controller, hipol: Fluid, limits: Limits) -> None:
    assert diagnose(four_speed, hipol, limits).provisional == ()


def test_a_unit_whose_gaps_are_not_described_is_an_upper_bound(
    hipol: Fluid, limits: Limits, readings_of: Build, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = load_controller("minimal_example")
    diagnosis = diagnose(unit, hipol, limits, readings=with_clearances(unit, 16 * UM, readings_of))
    assert diagnosis.upper_bound
    record = diagnosis_record(diagnosis)["unit"]
    assert (record["upper_bound"], record["provisional"]) == (True, True)
    assert record["provisional_because"][:2] == ["mounting_clearance", "contact_length"]
    print_diagnosis(diagnosis)
    said = " ".join(capsys.readouterr().out.split())
    assert "(provisional, upper bound)" in said
    assert "are taken to leak from main pressure to the sump in every gear" in said


def test_every_assumed_value_has_its_words_in_every_language(sample_diagnoses: dict[str, Diagnosis]) -> None:
    sample = sample_diagnoses["workshop"]
    for language in languages():
        names = {row["assumed_what"] for row in assumed_table(sample, wording(language)).records()}
        assert not names & {each.what for each in assumed_values(sample)}
        assert wording(language)("bases.mounting_clearance") + " (47)" in names

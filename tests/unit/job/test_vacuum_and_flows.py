"""A vacuum test and flows as files of a job: alone, beside the rest, kept in its file, and gone with the person."""

from __future__ import annotations

from dataclasses import replace

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import FlowTableError, VacuumTableError
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.job_book.erasure import without_person
from atleak.job_book.plain_files import plain_flows, plain_vacuum
from atleak.measurements.job_card import Job
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.report.json.diagnosis import diagnosis_record

UNIT = "five_speed_2005"
FLOWS = "condition,what,value,unit\nhot_idle,cooler,400,ml/15 s\n"
VACUUM = """customer,Erika Mustermann
supply,25,in-Hg
calibration,0.5,mm,5.7,in-Hg,0.5 mm
flow area,0.6,mm2
circuit,reading [in-Hg],orifice [mm],state
forward_clutch,17.5,1,worn
boost_valve/1+boost_valve/2,12.25,0.5,repaired
"""


def flows(text: str = FLOWS) -> SourceFile:
    return SourceFile("flows.csv", text.encode())


def vacuum(text: str = VACUUM) -> SourceFile:
    return SourceFile("vacuum.csv", text.encode())


def test_keys_of_jobs_without_them_are_those_of_the_version_before() -> None:
    """Results that were kept stay found: both were computed by atleak as it was before it knew such files."""
    kept = "hipol_atf_iid"  # stood in every job for which no fluid was chosen
    gauges = SourceFile("gauges.csv", b"range;stall [kPa]\nD;1100\n")
    assert Case(fluid=kept).key == "4fbd531339b035c036fb4da28c2e87e163968d178c74d7fc6c5c2b28b489a22b"
    of_both = Case(controller=UNIT, pressures=gauges, temperature=95.0, fluid=kept)
    assert of_both.key == "c3c163b38d9496c35ce303d8a0691c0f6b415d4f28f0c3fd84e634c9f4fba134"


def test_each_changes_the_key() -> None:
    cases = [Case(), Case(flows=flows()), Case(vacuum=vacuum()), Case(flows=flows(FLOWS.replace("400", "401")))]
    assert len({each.key for each in cases}) == 4


def test_assumptions_of_an_older_job_file_that_are_all_defaults_are_none() -> None:
    case = Case(controller=UNIT, flows=flows())
    content = write_job_file(case.diagnose(), None, case)
    assert read_job_file(content).case.assumptions == ()


def test_flows_are_a_job_of_their_own_and_stand_in_its_file() -> None:
    case = Case(controller=UNIT, flows=flows())
    before = case.diagnose()
    opened = read_job_file(write_job_file(before, None, case))
    assert opened.case.flows is not None
    assert opened.case.flows.name == "flows.csv"
    after = opened.diagnose()
    assert after.flows == before.flows
    assert diagnosis_record(after)["flows"] == opened.result["flows"]
    assert opened.result["flows"][0]["bound"] is False


def test_a_job_file_wants_the_table_that_the_result_rests_on() -> None:
    case = Case(controller=UNIT, flows=flows())
    with pytest.raises(Exception, match="table of flows is not the one"):
        write_job_file(case.diagnose(), None, replace(case, flows=flows(FLOWS.replace("400", "390"))))


def test_a_bad_table_names_its_file() -> None:
    with pytest.raises(FlowTableError, match=r"flows\.csv, row 2, column condition"):
        Case(controller=UNIT, flows=flows(FLOWS.replace("hot_idle", "hot"))).diagnose()
    with pytest.raises(VacuumTableError, match=r"vacuum\.csv, row 6, column circuit"):
        Case(controller=UNIT, vacuum=vacuum(VACUUM.replace("forward_clutch", "backward_clutch"))).diagnose()


def test_plain_files_say_the_same_and_no_more() -> None:
    unit = load_controller(UNIT)
    test = read_vacuum_table(vacuum().content, unit, name="vacuum.csv")
    plain = plain_vacuum(test, unit)
    assert plain is not None
    assert b"Mustermann" not in plain.content
    again = read_vacuum_table(plain.content, unit, name=plain.name)
    assert [each.lands for each in again.readings] == [each.lands for each in test.readings]
    assert [each.repaired for each in again.readings] == [False, True]
    assert again.stand.calibrations[0].fitted == pytest.approx(0.5e-3, abs=0.0)
    caught = read_flow_table(flows().content, unit, name="flows.csv")
    written = plain_flows(caught, unit)
    assert written is not None
    assert read_flow_table(written.content, unit, name=written.name).readings[0].flow == pytest.approx(
        caught.readings[0].flow, rel=1e-9, abs=0.0
    )


def test_they_stay_when_the_person_goes() -> None:
    case = Case(controller=UNIT, flows=flows(FLOWS + "Erika,Mustermann,,\n"), vacuum=vacuum())
    job = Job.model_validate({"customer": {"name": "Erika Mustermann"}})
    left = without_person(read_job_file(write_job_file(case.diagnose(), job, case)))
    assert left.lost == ()
    assert {"vacuum", "flows"} <= set(left.parts.sources)
    assert not any(b"Mustermann" in file.content for file in left.parts.sources.values())

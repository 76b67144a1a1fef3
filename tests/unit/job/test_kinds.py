"""What a file that is handed over is, told by its content whatever its name says."""

from __future__ import annotations

import io
from pathlib import Path

import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import KINDS, catalogue_files
from atleak.common.errors import InputError
from atleak.job.case import Case, SourceFile
from atleak.job.kinds import FileKind, kind_of, slots_of
from atleak.job.zip_file import write_job_file
from atleak.report.sheets.controller_workbook import write_controller_workbook
from atleak.report.sheets.measuring_sheet import write_template

GAUGES = b"Range;Engine;Tap;Pressure [kPa]\nD;idle;line;412\nR;stall;line;1500\n"
VACUUM = b"supply;25;in-Hg\norifice;0,5;mm\ncomponent/land;reading [in-Hg]\naccumulator/1;17,5\n"
FLOWS = b"condition;what;value [l/min]\nhot_idle;cooler;3,8\n"
LOG = b"time [s];engine speed [rpm];line pressure [kPa]\n" + b"0,1;800;412\n" * 50


def as_workbook(text: bytes) -> bytes:
    book = openpyxl.Workbook()
    for line in text.decode().splitlines():
        book.active.append([float(cell.replace(",", ".")) if cell[:1].isdigit() else cell for cell in line.split(";")])
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"component;part;plane;direction;diameter [mm]\naccumulator;piston;1;0;18,0\n", FileKind.READINGS),
        (GAUGES, FileKind.PRESSURES),
        (as_workbook(GAUGES), FileKind.PRESSURES),
        (VACUUM, FileKind.VACUUM),
        (as_workbook(VACUUM), FileKind.VACUUM),
        (FLOWS, FileKind.FLOWS),
        (as_workbook(FLOWS), FileKind.FLOWS),
        (b"temperature;gear;value\n80;1;3\n81;1;4\n", FileKind.ROAD_TEST),
        (LOG, FileKind.ROAD_TEST),
        (as_workbook(LOG), FileKind.ROAD_TEST),
        (b"supply;25 in-Hg\ncircuit;reading [in-Hg]\naccumulator/1;17,5\n", FileKind.VACUUM),
        (
            as_workbook(b"circuit;reading [in-Hg]\naccumulator/1 + tcc_regulator/1;17,5\n"),
            FileKind.VACUUM,
        ),
        (b"condition;what;value\nhot_idle;cooler;3,8 l/min\n", FileKind.FLOWS),
        (as_workbook(b"condition;what;value;unit\nhot_idle;cooler;3,8;l/min\n"), FileKind.FLOWS),
        (b"temperature;20\nsupply;3\nvalve;reading\na;3\n", FileKind.READINGS),
        ("零件;位置;甲;乙\naccumulator;1;17,998;18,041\n".encode(), FileKind.READINGS),
        (as_workbook(b"X;Y;Z\naccumulator/1 bore;18.041;\ntcc_regulator/1 bore;11.031;\n"), FileKind.READINGS),
        (b"X;Y;Z\naccumulator;17;2\naccumulator;25.5;3\n", FileKind.ROAD_TEST),
        (b"MDF     4.10", FileKind.ROAD_TEST),
        (b"PAR1\x15\x04", FileKind.ROAD_TEST),
        (b"", FileKind.ROAD_TEST),
        (as_workbook(b""), FileKind.READINGS),
        (b"\x89PNG\r\n\x1a\n", FileKind.PICTURE),
        (b"RIFF\0\0\0\0WEBPVP8 ", FileKind.PICTURE),
        (b'number = "2026-0417"\n[customer]\nname = "A"\n', FileKind.RECORD),
        (b'{"number": "2026-0417"}', FileKind.RECORD),
    ],
    ids=lambda given: given.value if isinstance(given, FileKind) else "",  # a workbook's bytes name the second it is of
)
def test_a_file_is_told_by_its_content(minimal: Controller, content: bytes, kind: FileKind) -> None:
    assert kind_of(SourceFile("anything.dat", content), minimal) is kind


def test_templates_and_samples_are_told(minimal: Controller, sample_readings: Path, sample_log: Path) -> None:
    assert kind_of(SourceFile("a", write_template(minimal)), minimal) is FileKind.READINGS
    assert kind_of(SourceFile("a", write_controller_workbook()), minimal) is FileKind.CONTROLLER_WORKBOOK
    assert kind_of(SourceFile("a", sample_readings.read_bytes()), minimal) is FileKind.READINGS
    assert kind_of(SourceFile("a", sample_log.read_bytes()), minimal) is FileKind.ROAD_TEST


def test_a_job_file_is_told(minimal: Controller) -> None:
    job_file = write_job_file(Case(controller="minimal_example").diagnose())
    assert kind_of(SourceFile("a.xlsx", job_file), minimal) is FileKind.JOB


@pytest.mark.parametrize("folder", KINDS)
def test_every_shipped_entry_is_told_also_where_it_has_a_fault(minimal: Controller, folder: str) -> None:
    for path in catalogue_files(folder).values():
        text = path.read_text(encoding="utf-8")
        kind = kind_of(SourceFile("own.txt", text.encode()), minimal)
        assert f"{kind}s".replace("ss", "s") == folder
        broken = text.replace("= ", "= ,", 5)
        assert kind_of(SourceFile("own.toml", broken.encode()), minimal) is kind


def test_an_instrument_is_chosen_for_what_it_measures() -> None:
    class Gauge:
        measures = ("sleeve",)

    assert slots_of(FileKind.INSTRUMENT, Gauge()) == ("sleeve_instrument",)
    assert slots_of(FileKind.FLUID, object()) == ("fluid",)


@pytest.mark.parametrize(
    ("content", "broken"),
    [
        (b"a;b\n1;2\n", "atleak.job.kinds.read_sheets"),
        (b"PK\x03\x04 and no more", "atleak.job.kinds.zipfile"),
        (b'{"number": "1"}', "atleak.job.kinds.json"),
    ],
)
def test_a_fault_of_atleak_is_not_taken_for_what_a_file_is(
    minimal: Controller, monkeypatch: pytest.MonkeyPatch, content: bytes, broken: str
) -> None:
    monkeypatch.setattr(broken, None)
    with pytest.raises(InputError, match=r"^own\.txt: atleak could not make sense of it: TypeError|AttributeError"):
        kind_of(SourceFile("own.txt", content), minimal)


def test_a_gear_and_a_voltage_are_no_component_with_its_diameter() -> None:
    study = load_controller("four_speed_2023")
    log = b"a;b;c\n" + b"5;13,9;1\n" * 40
    assert kind_of(SourceFile("own.txt", log), study) is FileKind.ROAD_TEST
    sheet = b"N.;Sezione;Cursore\n5;1;13,999\n8;1;9,998\n8;2;11,997\n"
    assert kind_of(SourceFile("own.txt", sheet), study) is FileKind.READINGS


def test_a_sheet_of_another_valve_body_under_unknown_headings_is_no_log(minimal: Controller) -> None:
    rows = ["5;1;14.001;14.069", "6;1;9.937;9.967", "6;2;9.941;9.991", "7;1;13.999;14.066"]
    for other in (minimal, load_controller("four_speed_2023")):
        sheet = "\n".join(["N.;Sezione;Cursore;Sede", *rows])
        assert kind_of(SourceFile("scheda.csv", sheet.encode()), other) is FileKind.READINGS
    log = "\n".join(["a;b;c", *(f"{gear};{volt}" for gear in range(1, 7) for volt in (13.9, 14.1, 12.6))])
    assert kind_of(SourceFile("log.csv", log.encode()), minimal) is FileKind.ROAD_TEST

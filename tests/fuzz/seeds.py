"""Sound small files of every kind that comes in through a door, made here: what `damage` starts from."""

from __future__ import annotations

import gzip
import io
import json
import zipfile
from collections.abc import Callable
from functools import cache

import openpyxl
import pyarrow as pa
import pyarrow.parquet as pq
from PIL import Image

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import read_tables, shipped_files
from atleak.catalogue.workbook.cells import Units
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job
from atleak.measurements.measuring_plan import Plan
from atleak.report.sheets.controller_workbook import write_controller_workbook

File = tuple[str, bytes]  # name and content
Rows = list[list[object]]

SHEET: Rows = [
    ["component", "part", "plane", "direction", "repeat", "diameter [mm]"],
    *([component, part, "1", direction, repeat, size]
      for component, part, size in (("6", "spool", 9.939), ("6", "sleeve", 10.031), ("8", "spool", 10.0))
      for direction in ("0°", "90°") for repeat in (1, 2)),
]  # fmt: skip
COORDINATES: Rows = [
    ["Measuring temperature", "21,5 °C"],
    ["Component", "Part", "Plane", "Coordinate x1 [mm]", "Coordinate x2 [mm]", "Diameter [mm]"],
    ["6", "spool", "1", "1,000", "10,939", ""],
    ["6", "sleeve", "1", "", "", "10,031"],
]
GAUGES: Rows = [
    ["range", "slow idle [kPa]", "fast idle [kPa]", "stall [kPa]"],
    *([name, 500, 620, 1300 if name in "DR" else ""] for name in "PRND"),
]
VACUUM: Rows = [
    ["supply", 25, "in-Hg"],
    ["ambient", 98.5, "kPa"],
    ["calibration", "0.5 mm", "21.6 in-Hg"],
    ["circuit or component/land", "reading", "unit", "orifice", "state"],
    *([name, 17.5, "in-Hg", "1.0 mm", state] for name, state in (("24/1", "worn"), ("24/1+24/2", "repaired"))),
]
FLOWS: Rows = [["condition", "what", "value", "unit"], ["hot_idle", "cooler", 946, "ml/15 s"]]
STUDY: Rows = [
    ["part", "operator", "trial", "reading [mm]"],
    *([part, operator, trial, 16.0 + part / 100 + trial / 1000]
      for part in (1, 2, 3) for operator in "AB" for trial in (1, 2)),
]  # fmt: skip
LOG: Rows = [
    ["Time (s)", "Engine RPM", "Line Pressure (kPa)", "ATF Temp (°C)", "Gear", "Remark"],
    *([row / 10, 900 + 5 * row, 500 + row, 60 + row / 20, 1 + row // 20, "on" if row % 7 else "Off"]
      for row in range(60)),
]  # fmt: skip
CLOCKED = "Logger 7;serial 12\r\nDate;1.3.2026\r\n\r\nTime;n Motor;p Haupt\r\n;1/min;bar\r\n" + "".join(
    f"12:{row // 60:02d}:{row % 60:02d},5;{900 + row};{5 + row / 50:.2f}".replace(".", ",") + "\r\n"
    for row in range(90)
)
RECORD = {
    "number": "2026-0417",
    "date": "2026-04-17",
    "vehicle": {"model": "saloon", "mileage_km": 106_315},
    "complaint": "Slips when hot",
}


def text(rows: Rows, between: str = ";", quoted: bool = False) -> bytes:
    """Rows as delimited text, every cell in quotes where that is asked for."""
    cells = [[f'"{cell}"' if quoted else str(cell) for cell in row] for row in rows]
    return "".join(between.join(row) + "\r\n" for row in cells).encode()


def xlsx(rows: Rows, merged: str = "") -> bytes:
    """Rows as a workbook."""
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    if merged:
        book.active.merge_cells(merged)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def ods(rows: Rows) -> bytes:
    """Rows as an open document."""
    space = "urn:oasis:names:tc:opendocument:xmlns"
    lines = "".join(f"<table:table-row>{''.join(map(_ods_cell, row))}</table:table-row>" for row in rows)
    content = (
        f'<office:document-content xmlns:office="{space}:office:1.0" xmlns:table="{space}:table:1.0" '
        f'xmlns:text="{space}:text:1.0"><office:body><office:spreadsheet><table:table table:name="Sheet">{lines}'
        "</table:table></office:spreadsheet></office:body></office:document-content>"
    )
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
        archive.writestr("META-INF/manifest.xml", "<manifest/>")
    return stream.getvalue()


def _ods_cell(cell: object) -> str:
    if isinstance(cell, int | float):
        return f'<table:table-cell office:value-type="float" office:value="{cell}"/>'
    return f'<table:table-cell office:value-type="string"><text:p>{cell}</text:p></table:table-cell>'


def _tables(name: str, rows: Rows) -> list[File]:
    return [
        (f"{name}.csv", text(rows)),
        (f"{name} quoted.csv", text(rows, ",", quoted=True)),
        (f"{name} utf16.csv", text(rows, "\t").decode().encode("utf-16")),
        (f"{name}.xlsx", xlsx(rows)),
        (f"{name}.ods", ods(rows)),
    ]


def _logs() -> list[File]:
    logs = [*_tables("log", LOG), ("clocked.csv", CLOCKED.encode("cp1252")), ("log.csv.gz", gzip.compress(text(LOG)))]
    logs.append(("log.parquet", parquet(LOG)))
    try:
        import numpy as np
        from asammdf import MDF, Signal
    except ImportError:
        return logs
    stream = io.BytesIO()
    with MDF(version="4.10") as mdf:
        mdf.append([Signal(np.arange(60.0), np.arange(60.0) / 10, name="Engine Speed", unit="rpm")])
        mdf.save(stream)
    return [*logs, ("log.mf4", stream.getvalue())]


def parquet(rows: Rows) -> bytes:
    """A table as Parquet, its names those of the first row."""
    stream = io.BytesIO()
    names, *body = rows
    pq.write_table(
        pa.table([list(column) for column in zip(*body, strict=True)], names=[str(name) for name in names]), stream
    )
    return stream.getvalue()


def picture(form: str) -> bytes:
    """A picture of 12 by 8 points with a camera's notes."""
    stream, image = io.BytesIO(), Image.new("RGB", (12, 8), (200, 30, 30))
    notes = image.getexif()
    notes[0x0112], notes[0x010F] = 6, "camera"
    image.save(stream, form, exif=notes)
    return stream.getvalue()


@cache
def _job() -> bytes:
    case = Case(readings=SourceFile("sheet.csv", text(SHEET)), road_test=SourceFile("log.csv", text(LOG)))
    record = Job.model_validate({**RECORD}).with_photo("spool.jpg", picture("JPEG"))
    return write_job_file(case.diagnose(), record, case)


def _workbook() -> bytes:
    return write_controller_workbook(read_tables("controllers", "minimal_example")[0], Units())


def _toml(kind: str) -> list[File]:
    return [(path.name, path.read_bytes()) for path in list(shipped_files(kind).values())[:3]]


def _typed() -> list[File]:
    from atleak.readers.typed_sheet import TYPED_FILE, Typed, TypedEntry, written_sheet

    controller = load_controller("minimal_example")
    cells = Plan().cells(controller)[:4]
    size = f"{controller.lands[0].nominal_diameter * 1e3:.3f}"
    typed = Typed({cell: TypedEntry(size) for cell in cells}, Plan())
    return [(TYPED_FILE, written_sheet(typed, cells, controller) or b"")]


_SEEDS: dict[str, Callable[[], list[File]]] = {
    "readings": lambda: [*_tables("sheet", SHEET), *_tables("coordinates", COORDINATES)],
    "pressures": lambda: _tables("gauges", GAUGES),
    "vacuum": lambda: _tables("vacuum", VACUUM),
    "flows": lambda: _tables("flows", FLOWS),
    "study": lambda: _tables("study", STUDY),
    "road_test": _logs,
    "columns": _logs,
    "controller_workbook": lambda: [("unit.xlsx", _workbook())],
    "kind": lambda: [
        *_tables("sheet", SHEET), *_tables("log", LOG), ("job.json", json.dumps(RECORD).encode()),
        *_toml("limits"), ("job.zip", _job()),
    ],
    "typed": _typed,
    "job": lambda: [("job.zip", _job())],
    "record": lambda: [
        ("job.json", json.dumps(RECORD).encode()),
        ("job.toml", b'number = "7"\ndate = 2026-04-17\n[vehicle]\nmileage_km = 106_315\n'),
    ],
    "controllers": lambda: _toml("controllers"),
    "fluids": lambda: _toml("fluids"),
    "limits": lambda: _toml("limits"),
    "instruments": lambda: _toml("instruments"),
    "picture": lambda: [(f"photo.{form.lower()}", picture(form)) for form in ("PNG", "JPEG", "WEBP")],
    "remembered": lambda: [
        ("road-test-columns.json", json.dumps({"ab": {"mapping": {"engine_speed": "n"}, "units": {}}}).encode())
    ],
}  # fmt: skip
DOORS = tuple(_SEEDS)


@cache
def seeds(door: str) -> list[File]:
    """The sound files that a door takes."""
    return _SEEDS[door]()

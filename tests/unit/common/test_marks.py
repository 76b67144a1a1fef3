"""What the command line may write over: files that atleak made and nobody changed since; others only when told to."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pypdfium2
import pytest

from atleak import cli
from atleak.catalogue.controller import Controller
from atleak.common.errors import OutputError
from atleak.common.seals import SealedKind, check_seals
from atleak.job import case  # noqa: F401  # it takes `diagnose` by name, so before that is replaced here
from atleak.report.sheets.measuring_sheet import write_readings, write_template

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("ATLEAK_TRACEBACK", "1")

    def command(*arguments: object) -> tuple[int, str, str]:
        status = cli.main([str(argument) for argument in arguments])
        return status, *capsys.readouterr()

    return command


def fill_in(sheet: Path) -> None:
    book = openpyxl.load_workbook(sheet)
    book["Measurements"]["H9"] = 13.999
    book.save(sheet)


COMMANDS = {
    "diagnose --json": ("diagnose", "READINGS", "--json", "OUT.json"),
    "diagnose --xlsx": ("diagnose", "READINGS", "--xlsx", "OUT.xlsx"),
    "diagnose --pdf": ("diagnose", "READINGS", "--pdf", "OUT.pdf"),
    "diagnose --job-file": ("diagnose", "READINGS", "--job-file", "OUT.zip"),
    "variants": ("variants", "--json", "OUT.json"),
    "import-log --json": ("import-log", "LOG", "--json", "OUT.json"),
    "import-log --csv": ("import-log", "LOG", "--csv", "OUT.csv"),
    "template": ("template", "-o", "OUT.xlsx"),
    "controllers": ("controllers", "--json", "OUT.json"),
    "fluids": ("fluids", "--json", "OUT.json"),
    "limits": ("limits", "--json", "OUT.json"),
    "instruments": ("instruments", "--json", "OUT.json"),
}


@pytest.fixture
def arguments(request: pytest.FixtureRequest, tmp_path: Path, sample_readings: Path, sample_log: Path) -> list[object]:
    """A command of `COMMANDS` with its files; the last of them is what it writes."""
    places = {"READINGS": sample_readings, "LOG": sample_log}
    return [places.get(each, tmp_path / each if each.startswith("OUT") else each) for each in COMMANDS[request.param]]


@pytest.mark.parametrize("arguments", COMMANDS, indirect=True)
def test_a_foreign_file_is_left_before_anything_is_computed_unless_told(
    run: Run, arguments: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    target = Path(str(arguments[-1]))
    target.write_bytes(b"somebody's own work")
    with monkeypatch.context() as patched:
        for computing in ("job.case.diagnose", "cli.studies.run_variants", "cli.import_log.understand"):
            patched.setattr(f"atleak.{computing}", None)
        status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert str(target) in err
    assert "--force" in err
    assert target.read_bytes() == b"somebody's own work"
    assert run(*arguments, "--force")[0] == 0
    assert target.read_bytes() != b"somebody's own work"


@pytest.mark.parametrize("arguments", [name for name in COMMANDS if "--csv" not in name], indirect=True)
def test_what_atleak_made_is_made_again(run: Run, arguments: list[object]) -> None:
    assert run(*arguments)[0] == 0
    before = Path(str(arguments[-1])).read_bytes()
    assert run(*arguments)[0] == 0
    assert Path(str(arguments[-1])).read_bytes() == before


def test_a_table_bears_no_mark_and_is_never_written_over_unasked(run: Run, sample_log: Path, tmp_path: Path) -> None:
    again = ("import-log", sample_log, "--csv", tmp_path / "plain.csv")
    assert [run(*again)[0], run(*again)[0], run(*again, "--force")[0]] == [0, 2, 0]


def test_a_filled_sheet_is_left_and_an_empty_one_is_made_again(run: Run, tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.xlsx"
    assert run("template", "-o", sheet)[0] == 0
    assert run("template", "--controller", "minimal_example", "-o", sheet)[0] == 0
    fill_in(sheet)
    filled = sheet.read_bytes()
    for command in (("template", "-o", sheet), ("limits", "--json", sheet)):
        status, _, err = run(*command)
        assert status == 2
        assert "sheet.xlsx" in err
        assert "--force" in err
        assert sheet.read_bytes() == filled
    assert run("template", "-o", sheet, "--force")[0] == 0
    assert sheet.read_bytes() != filled


def test_a_sheet_filled_in_by_a_program_that_changes_nothing_else_is_left(
    run: Run, tmp_path: Path, minimal: Controller
) -> None:
    """One number written straight into the sheet's XML, the document's dates and properties as they were."""
    sheet = tmp_path / "sheet.xlsx"
    with zipfile.ZipFile(io.BytesIO(write_template(minimal))) as old, zipfile.ZipFile(sheet, "w") as new:
        for part in old.infolist():
            content = old.read(part)
            if part.filename == "xl/worksheets/sheet1.xml":
                assert content.count(b'<c r="H9"') == 1
                start = content.index(b'<c r="H9"')
                end = content.index(b"/>", start)
                content = content[:end] + b"><v>11.003</v></c>" + content[end + 2 :]
            new.writestr(part, content)
    assert openpyxl.load_workbook(sheet)["Measurements"]["H9"].value == 11.003
    assert run("template", "-o", sheet)[0] == 2


def test_names_at_the_head_of_a_sheet_count_as_filled_in(run: Run, tmp_path: Path, minimal: Controller) -> None:
    sheet = tmp_path / "sheet.xlsx"
    sheet.write_bytes(write_readings(minimal, (), fields={"Job": "2026-0417"}))
    assert run("template", "-o", sheet)[0] == 2


def test_a_report_that_somebody_saved_again_or_signed_is_left(run: Run, sample_readings: Path, tmp_path: Path) -> None:
    book, pdf = tmp_path / "report.xlsx", tmp_path / "report.pdf"
    again = ("diagnose", sample_readings, "--xlsx", book, "--pdf", pdf)
    assert run(*again)[0] == 0
    changed = openpyxl.load_workbook(book)
    changed["Summary"]["A40"] = "discussed with the customer"
    changed.save(book)
    pdf.write_bytes(pdf.read_bytes() + b"\n9 0 obj\n<<>>\nendobj\nxref\n0 0\ntrailer\n<<>>\nstartxref\n9\n%%EOF\n")
    with pypdfium2.PdfDocument(pdf) as document:
        assert len(document) > 1
    before = book.read_bytes(), pdf.read_bytes()
    status, _, err = run(*again)
    assert status == 2
    assert "report.xlsx" in err
    assert "report.pdf" in err
    assert (book.read_bytes(), pdf.read_bytes()) == before


def test_many_reports_are_refused_together_before_the_first_is_made(
    run: Run, sample_readings: Path, tmp_path: Path
) -> None:
    bundle, out = tmp_path / "a.zip", tmp_path / "out"
    assert run("diagnose", sample_readings, "--job-file", bundle)[0] == 0
    (tmp_path / "b.zip").write_bytes(bundle.read_bytes())
    out.mkdir()
    (out / "b.json").write_text('{"format": 1}', encoding="utf-8")
    again = ("report", bundle, tmp_path / "b.zip", "-o", out, "--formats", "json")
    status, _, err = run(*again)
    assert status == 2
    assert "b.json" in err
    assert not (out / "a.json").exists()
    assert run(*again, "--force")[0] == 0
    assert run(*again)[0] == 0


def packed(entries: dict[str, bytes]) -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as bundle:
        for name, content in entries.items():
            bundle.writestr(name, content)
    return target.getvalue()


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        ("record", b'{"atleak": "0.1.0"}'),
        ("record", b'{"format": 1, "atleak": 7}'),
        ("record", b'[{"id": "a"}]'),
        ("record", b"[" * 100_000),
        ("record", b'{"format": ' + b"9" * 10_000 + b"}"),
        ("record", b"{\xff}"),
        ("record", b'{"format": 1, "atleak": "0.1.0", "x": "' + b"x" * (17 << 20) + b'"}'),
        ("PDF", b"%PDF-1.7\nstartxref\n0\n%%EOF"),
        ("job file", b"PK\x03\x04 nothing"),
        ("job file", packed({"job.json": b'{"format": 1}'})),
        ("job file", packed({"job.json": b" " * (40 << 20)})),
        ("job file", packed({f"{number}": b"" for number in range(2000)} | {"job.json": b'{"format":1,"atleak":""}'})),
        ("report workbook", packed({"docProps/custom.xml": b" " * (40 << 20)})),
        ("measuring sheet", packed({"xl/workbook.xml": b"<workbook/>"})),
    ],
    ids=lambda value: value if isinstance(value, str) else f"{len(value)} bytes",
)
def test_files_that_only_look_like_atleak_s_are_left(tmp_path: Path, kind: SealedKind, content: bytes) -> None:
    target = tmp_path / "target"
    target.write_bytes(content)
    with pytest.raises(OutputError, match="--force"):
        check_seals([], [(kind, str(target))])


def test_what_is_no_file_with_content_is_no_obstacle(tmp_path: Path) -> None:
    (tmp_path / "empty.json").touch()
    check_seals([], [("record", str(tmp_path / name)) for name in ("empty.json", "none.json")])
    check_seals([], [("record", "-")])
    for place in (tmp_path / "empty.json", Path("-")):
        with pytest.raises(OutputError, match="another file of this command"):
            check_seals([], [("record", str(place)), ("table", str(place))], force=True)


def test_a_huge_foreign_file_is_not_read_whole(tmp_path: Path) -> None:
    for start in (b"PK\x03\x04", b"%PDF", b"{"):
        target = tmp_path / "huge"
        with target.open("wb") as stream:
            stream.write(start)
            stream.truncate(1 << 40)  # a hole: takes no room
        with pytest.raises(OutputError, match="--force"):
            check_seals([], [("job file", str(target))])


def test_a_listing_names_the_atleak_that_wrote_it(run: Run) -> None:
    from atleak.version import __version__

    rows = json.loads(run("limits", "--json", "-")[1])
    assert {row["atleak"] for row in rows} == {__version__}

"""A level is added in `common/verdicts.py`, `common/style.py` and the language files; every renderer shows it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from atleak.common.style import LOOKS
from atleak.common.translations import languages
from atleak.common.verdicts import BANDS, FLAGGED, VERDICTS, Band, Verdict
from atleak.common.wording import wording

ADDED_LEVEL = '    WATCH = "watch"\n    SOON = "soon"\n'
ADDED_LOOK = """    Verdict.SOON: Look(
        sign="◆", shape=SignShape(((0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))),
        screen="#e06a17", on_screen="#000000", fill="#EFA05A", line="#6B2E00", on_fill="#4A2000",
        tint="#FBDCBF", on_tint="#6B2E00", width=1.6, dashes="",
        style="bright_yellow", pattern="|", hatch="...", marker="diamond", box="warning",
    ),
    Verdict.REPLACE: Look("""

# Runs in a copy of the package that knows the new level, and prints what it could not find.
WALK = """
import io, json, os, sys
from pathlib import Path

import jsonschema, openpyxl, pypdfium2
from streamlit.testing.v1 import AppTest

import atleak
from atleak.cli import main as atleak_command
from atleak.report.charts import land_figures as figures
from atleak.report.charts.screen import drawn
from atleak.fleet.summary_charts import FleetCharts
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.summary import summed_up
from atleak.job.result import result_record
from atleak.measurements.readings import Reading
from atleak.report.sheets.measuring_sheet import write_readings
from atleak.report.json.schemas import schema
from atleak.common.verdicts import Verdict
from atleak.report.json.diagnosis import to_json
from atleak.analysis.repair.plan import plan_repairs
from atleak.report.pdf import write_pdf
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.terminal import print_diagnosis
from atleak.report.xlsx import write_workbook
from atleak.report.tables.lands import pair_table
from atleak.common.wording import wording

root, own = Path(sys.argv[1]), Path(sys.argv[2])
assert Path(atleak.__file__).is_relative_to(root), "the walk runs in the copy"
controller = atleak.load_controller("four_speed_2023")
sheet = root / "sample_data" / "measuring_sheet_four_speed.xlsx"
found = atleak.diagnose(
    controller, atleak.load_fluid("hipol_atf_iid"), atleak.load_limits(own),
    readings=atleak.read_readings(sheet, controller),
)
soon = [land for land in found.lands if land.verdict == "soon"]
assert soon, "no land has the new level"
keys = {land.key for land in soon}
assert keys <= {land.key for land in found.flagged}
assert keys <= {step.land.key for step in plan_repairs(found).steps}
record = diagnosis_record(found)
assert "soon" in {land["verdict"] for land in record["lands"]}

def as_described(output, written):
    jsonschema.Draft202012Validator(schema(output)).validate(json.loads(written))

as_described("diagnose", to_json(result_record(found)))
out = sys.stdout
sys.stdout = io.StringIO()
print_diagnosis(found)
said, sys.stdout = sys.stdout.getvalue(), out
assert "◆ repair soon" in said, "terminal"
pdf = pypdfium2.PdfDocument(write_pdf(found))
assert "repair soon" in "".join(page.get_textpage().get_text_range() for page in pdf), "PDF"
for language in ("de", "pl"):
    assert write_pdf(found, language=language).startswith(b"%PDF"), language
minimal = atleak.load_controller("minimal_example")
worn = minimal.lands[0].key
measured = [
    Reading(land.component, part, plane, direction, 1, land.nominal_diameter + gap * 2.0 * land.mounting_clearance)
    for land in minimal.lands for plane in land.planes for direction in (0.0, 90.0)
    for part, gap in (("spool", 0.0), ("sleeve", 1.35 if land.key == worn else 1.0))
]
limits = atleak.load_limits(own)
light = atleak.diagnose(
    minimal, atleak.load_fluid("hipol_atf_iid"), limits,
    readings=atleak.read_readings(write_readings(minimal, measured), minimal),
)
assert light.verdict == "soon", "the unit's own verdict"
as_described("diagnose", to_json(result_record(light)))
for language in ("en", "de", "pl"):
    assert write_pdf(light, language=language).startswith(b"%PDF"), language
book = openpyxl.load_workbook(io.BytesIO(write_workbook(found)), data_only=True)
for name in ("Summary", "Lands", "Rules"):
    cells = {cell.value for row in book[name].iter_rows() for cell in row}
    assert "◆ repair soon" in cells, name
assert "◆ repair soon" in {trace.name for trace in figures.leakage_ranking(found).data}, "ranking"
assert "repair soon" in {trace.name for trace in figures.land_wear(found).data}, "wear"
from few_units import Measured, Unit, condition, results_of, temperature_class

levels = list(Verdict)
units = [
    Unit(
        f"unit {n}", {("25", 1): Measured(10.0 + n, levels[n % len(levels)]), ("8", 1): Measured()},
        controller="four_speed_2023", conditions=[condition()], temperatures=[temperature_class()],
        own={"group": "ab"[n % 2], "mileage_km": 1e5 + 1e3 * n},
    )
    for n in range(120)
]
results = results_of(own.parent / "fleet", units)
summary = summed_up(results, by="group")
say, body = wording("en"), summary.bodies[0]
charts = FleetCharts(FleetWords(summary, say))
assert "◆ repair soon" in {trace.name for trace in drawn(charts.verdicts([("all", body.counts)]), say).data}
rates = drawn(charts.groups(body.comparison.groups), say).data
assert [trace.name for trace in rates][:4] == [
    "▲ watch or worse", "◆ repair soon or worse", "■ replace or worse", "✖ critical"
]
assert len({tuple(trace.y) for trace in rates[:4]}) == 4, "each level at a height of its own"
assert list(drawn(charts.pairs(body.pairs, ["25/1", "8/1"]), say).data)
for language in ("en", "de", "pl"):
    files = {name: own.parent / f"{language}.{name}" for name in ("pdf", "xlsx", "json")}
    asked = [str(word) for name, file in files.items() for word in (f"--{name}", file)]
    sys.stdout = io.StringIO()
    asked += ["--by", "group", "--language", language]
    status = atleak_command(["fleet", "summary", str(own.parent / "fleet"), *asked])
    said, sys.stdout = sys.stdout.getvalue(), out
    assert status == 0, language
    as_described("fleet-summary", files["json"].read_text(encoding="utf-8"))
    printed = "".join(page.get_textpage().get_text_range() for page in pypdfium2.PdfDocument(files["pdf"]))
    assert "repair soon" in printed, language
    cells = {cell.value for sheet in openpyxl.load_workbook(files["xlsx"]) for row in sheet.iter_rows() for cell in row}
    assert any("repair soon" in str(cell) for cell in cells), language
assert json.loads(files["json"].read_text(encoding="utf-8"))["counts"]["verdicts"]["soon"] == 20
main = root / "walk" / "main.py"
main.parent.mkdir()
main.write_text(f"import runpy\\nrunpy.run_path({str(root / 'app.py')!r})\\n", encoding="utf-8")
sys.path.insert(0, str(root))
os.environ["ATLEAK_ALLOWED"] = ""  # as on one machine alone
app = AppTest.from_file(str(main), default_timeout=120).run()
app.sidebar.file_uploader[0].upload("own.toml", own.read_bytes(), "text/plain").run()
assert not app.exception, "start"
words = {}
for page in sorted((root / "pages").glob("[0-9]*_*.py")):
    app.switch_page(str(page)).run()
    assert not app.exception, page.name
    words[page.name] = "".join(text.value for text in (*app.title, *app.caption))
assert "◆ repair soon" in words["4_Diagnosis.py"], "sentence"
assert "◆ repair soon" in pair_table(found, found.flagged, wording("en")).html(), "table"
print("walked")
"""


@pytest.mark.slow
def test_a_level_is_added_in_three_places_and_every_renderer_shows_it(root: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    copy.mkdir()
    for name in ("atleak", "pages", "sample_data"):
        shutil.copytree(root / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(root / "app.py", copy)
    for path, old, new in (
        ("common/verdicts.py", '    WATCH = "watch"\n', ADDED_LEVEL),
        ("common/style.py", "    Verdict.REPLACE: Look(", ADDED_LOOK),
        *(
            ("texts/report.toml", f"[{table}]\n", f'[{table}]\nsoon = "{words}"\n')
            for table, words in (("verdicts", "repair soon"), ("sentences", "Soon: {flagged} of {measured}, {total}."))
        ),
    ):
        file = copy / "atleak" / path
        text = file.read_text(encoding="utf-8")
        assert text.count(old) == 1, path
        file.write_text(text.replace(old, new), encoding="utf-8")
    own = tmp_path / "own.toml"
    limits = (root / "atleak" / "catalogue" / "limits" / "project_default.toml").read_text(encoding="utf-8")
    own.write_text(limits.replace("replace = 50.0", "soon = 15.0\nreplace = 50.0"), encoding="utf-8")
    walk = tmp_path / "walk.py"
    walk.write_text(WALK, encoding="utf-8")
    few_units = root / "tests" / "unit" / "fleet"
    environment = os.environ | {"PYTHONPATH": f"{copy}{os.pathsep}{few_units}", "ATLEAK_HOME": str(tmp_path)}
    walked = subprocess.run(
        [sys.executable, str(walk), str(copy), str(own)],
        capture_output=True, encoding="utf-8", env=environment, cwd=tmp_path, check=False,
    )  # fmt: skip
    assert walked.stdout.strip().endswith("walked"), walked.stderr[-4000:]


@pytest.mark.parametrize("language", languages())
def test_every_level_has_a_look_and_a_word(language: str) -> None:
    assert list(LOOKS) == list(VERDICTS)
    say = wording(language)
    assert all(say.level(level) for level in (*VERDICTS, *BANDS))
    for feature in ("sign", "fill", "pattern"):
        looks = {getattr(look, feature) for look in LOOKS.values()}
        assert len(looks) == len(LOOKS), feature


def test_order_of_severity() -> None:
    assert [verdict.value for verdict in sorted(VERDICTS, key=lambda verdict: verdict.rank)] == [
        "not_measured", "ok", "watch", "replace", "critical",
    ]  # fmt: skip
    assert FLAGGED == (Verdict.WATCH, Verdict.REPLACE, Verdict.CRITICAL)
    assert [verdict for verdict in VERDICTS if verdict.calls_for_repair] == [Verdict.REPLACE, Verdict.CRITICAL]
    assert [band.verdict for band in BANDS] == [Verdict.OK, *FLAGGED]
    assert Band.AMBER.verdict.flagged

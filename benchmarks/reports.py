"""Time the printed report and the workbook of a 60-land job with a log, beside the bare libraries.

    python benchmarks/reports.py [--batch 100] [--small]

Imports are done and one report written beforehand; median of 8 taken in turn, every second time the other way round:
typst keeps what it has just set, so that whoever comes second finds it done. Peers: typst compiling the same document
with its data ready, and XlsxWriter writing the same cells as plain values. Goals: customer's page at most 4 times and
all three documents at most 12 times its peer, the workbook 1.8 times. With ``--batch``, so many job files are also
reported one after another.
"""

from __future__ import annotations

import argparse
import datetime as dt
import io
import json
import shutil
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np
import openpyxl
import typst
import xlsxwriter
from PIL import Image
from rich.progress import Progress
from timing import options

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.common.style import find_paper
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.job.batch import write_reports
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Reading, Readings
from atleak.readers.logs import read_road_test
from atleak.report import pdf
from atleak.report.pdf import typesetting as compiling
from atleak.report.xlsx import write_workbook

OPTIONS = options(__doc__)
OPTIONS.add_argument("--batch", type=int, default=0, metavar="N", help="also the reports of so many job files")
ROOT = Path(__file__).resolve().parents[1]
LANDS = 60
RUNS = 8


def controller_of_60() -> Controller:
    """Return the shipped controller with some of its components a second time."""
    controller = load_controller("four_speed_2023")
    lands, gaps, components = list(controller.lands), list(controller.gaps), dict(controller.components)
    for land in controller.lands[: LANDS - len(lands)]:
        twin = replace(land, component=f"{land.component} b")
        components[twin.component] = components[land.component]
        lands.append(twin)
        gaps += [replace(gap, component=twin.component) for gap in controller.gaps if gap.key == land.key]
    lands.sort(key=lambda land: list(components).index(land.component))
    return replace(controller, lands=tuple(lands), gaps=tuple(gaps), components=MappingProxyType(components))


def job_of_60() -> tuple[Diagnosis, Job]:
    """Return a job with every land worn differently, two directions and repeats, a log and three photos."""
    controller = controller_of_60()
    readings = []
    for number, land in enumerate(controller.lands):
        sleeve = land.nominal_sleeve_diameter + 2.0 * land.mounting_high * (number % 7) / 6.0
        for part, diameter in (("spool", land.nominal_diameter), ("sleeve", sleeve)):
            for direction in (0.0, 90.0):
                for repeat in (1, 2):
                    size = diameter + 0.5e-6 * repeat
                    readings.append(Reading(land.component, part, land.planes[0], direction, repeat, size))  # type: ignore
    log = ROOT / "sample_data" / "minimum_acceleration_test.csv"
    diagnosis = diagnose(
        controller,
        load_fluid("hipol_atf_iid"),
        load_limits("project_default"),
        readings=Readings("sheet.xlsx", "0" * 64, "readings", "mm", False, "tidy", tuple(readings)),
        road_test=read_road_test(log),
        mileage_km=106_315.0,
    )
    noise = np.random.default_rng(1).integers(0, 255, (1200, 1600, 3), dtype=np.uint8)
    photo = io.BytesIO()
    Image.fromarray(noise).resize((1600, 1200)).save(photo, "JPEG", quality=70)
    names = [f"photo{number}.jpg" for number in range(3)]
    job = Job(
        number="60",
        date=dt.date(2026, 3, 14),
        workshop={"name": "Workshop", "address": "Street 1"},
        notes="Long notes. " * 200,
        photos=[{"file": name, "caption": name} for name in names],
    )
    return diagnosis, job.with_pictures(dict.fromkeys(names, photo.getvalue()))


def bare_typst(diagnosis: Diagnosis, job: Job, folder: Path, document: str) -> Callable[[], bytes]:
    """Return a run that compiles the same pages with everything but typst's own work done beforehand."""
    say = wording("en")
    folder.mkdir()
    pictures = compiling.write_pictures(job, folder)
    head = compiling.common_data(say("title.report"), say("title.subject"), job, find_paper("a4"), say, pictures)
    chosen = pdf.chosen_sections(None, document)
    data = {"attached": [], **head, **pdf.report_data(diagnosis, job, say, chosen, pictures, document=document)}
    for path in compiling.TEMPLATES.glob("*.typ"):
        shutil.copy(path, folder)
    inputs = {"data": json.dumps(data, ensure_ascii=False)}
    fonts = compiling.bundled_fonts()
    moment = dt.datetime(2026, 3, 14, tzinfo=dt.UTC)

    def run() -> bytes:
        compiler = typst.Compiler(folder / "report.typ", root=folder, font_paths=fonts, sys_inputs=inputs)
        return compiler.compile(format="pdf", pdf_standards=["a-2a", "ua-1"], timestamp=moment)  # type: ignore

    return run


def bare_xlsxwriter(content: bytes) -> Callable[[], bytes]:
    """Return a run that writes the same cells as plain values, without formats or charts."""
    book = openpyxl.load_workbook(io.BytesIO(content), data_only=True)
    sheets = {sheet.title: [(c.row - 1, c.column - 1, c.value) for row in sheet for c in row] for sheet in book}
    sheets = {name: [cell for cell in cells if cell[2] is not None] for name, cells in sheets.items()}

    def run() -> bytes:
        target = io.BytesIO()
        with xlsxwriter.Workbook(target, {"in_memory": True}) as workbook:
            for name, cells in sheets.items():
                sheet = workbook.add_worksheet(name)
                for row, column, value in cells:
                    sheet.write(row, column, value)
        return target.getvalue()

    return run


def batch(count: int) -> None:
    """Report so many jobs from their files, with progress."""
    controller = load_controller("four_speed_2023")
    diagnosis = diagnose(controller, load_fluid("hipol_atf_iid"), load_limits("project_default"))
    with tempfile.TemporaryDirectory() as folder, Progress() as progress:
        sources = []
        for number in range(count):
            sources.append(Path(folder) / f"job{number}.zip")
            sources[-1].write_bytes(write_job_file(diagnosis, Job(number=str(number))))
        task = progress.add_task("reports", total=count)
        start = time.perf_counter()
        done = write_reports(
            sources, Path(folder) / "out", formats=("pdf", "xlsx"), progress=lambda *_: progress.advance(task)
        )
        took = time.perf_counter() - start
        assert all(report.error is None for report in done)
    print(f"{count} jobs, PDF and workbook each: {took:.1f} s, {took / count * 1e3:.0f} ms a job")


def main(chosen: argparse.Namespace) -> None:
    diagnosis, job = job_of_60()
    print(f"{len(diagnosis.lands)} lands, {len(diagnosis.road.time)} samples, {len(job.pictures)} photos")
    with tempfile.TemporaryDirectory() as folder:
        runs = {
            "customer's page": partial(pdf.write_pdf, diagnosis, job, document="customer"),
            "customer's page, bare typst": bare_typst(diagnosis, job, Path(folder) / "customer", "customer"),
            "all three": partial(pdf.write_pdf, diagnosis, job, document="all"),
            "all three, bare typst": bare_typst(diagnosis, job, Path(folder) / "all", "all"),
            "workbook": lambda: write_workbook(diagnosis, job),
            "workbook, bare XlsxWriter": bare_xlsxwriter(write_workbook(diagnosis, job)),
        }
        sizes = {name: len(run()) for name, run in runs.items()}
        times: dict[str, list[float]] = {name: [] for name in runs}
        for turn in range(1 if chosen.small else RUNS):
            for name, run in list(runs.items())[:: -1 if turn % 2 else 1]:
                start = time.perf_counter()
                run()
                times[name].append(time.perf_counter() - start)
    took = {name: statistics.median(durations) for name, durations in times.items()}
    for (name, mine), (peer, bare) in zip(*[iter(took.items())] * 2, strict=True):
        for each, seconds, ratio in ((name, mine, f"   {mine / bare:4.1f} times"), (peer, bare, "")):
            print(f"{each:28} {seconds * 1e3:6.0f} ms   {sizes[each] / 1024:6.0f} KiB{ratio}")
    if count := chosen.batch or (2 if chosen.small else 0):
        batch(count)


if __name__ == "__main__":
    main(OPTIONS.parse_args())

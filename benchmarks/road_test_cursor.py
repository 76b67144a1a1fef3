"""Time another part of the log on the page In the car, beside the whole diagnosis of the same job.

    python benchmarks/road_test_cursor.py [--small]

The sample job, in Streamlit's own test harness: the page's script with a new part shown each time, from its
first line to its last, and of that the leakage over the part. The peer is the diagnosis with sheet and log read
beforehand. Processor time, median of 9 taken in turn. Goals: the page under 150 ms, the leakage under 0.05 of the
diagnosis.
"""

from __future__ import annotations

import argparse
import logging
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from streamlit.runtime.scriptrunner import script_runner
from streamlit.testing.v1 import AppTest
from timing import options

from atleak.catalogue.controller import Controller
from atleak.job.case import SLOTS, Case, CaseChoice, Reader, Slot
from atleak.measurements.readings import Readings
from atleak.readers.logs import Understood

OPTIONS = options(__doc__)
ROOT = Path(__file__).resolve().parents[1]
ROUNDS = 9
SMALL = 2
scripts: list[float] = []


def main(chosen: argparse.Namespace) -> None:
    logging.disable()  # the harness warns of what only a browser has
    sys.path.insert(0, str(ROOT))
    script_runner.exec_func_with_error_handling = _timed(script_runner.exec_func_with_error_handling)  # type: ignore[attr-defined]
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ATLEAK_HOME"] = folder
        start = Path(folder) / "main.py"  # the harness takes a script beside pages/ for an app without navigation
        start.write_text(f"import runpy\nrunpy.run_path({str(ROOT / 'app.py')!r})\n", encoding="utf-8")
        page = AppTest.from_file(str(start), default_timeout=60).run()
        page.switch_page(str(ROOT / "pages" / "3_In_the_car.py")).run()
        page.session_state["log-in-full-0"] = True
        page.run()
        _measure(page, SMALL if chosen.small else ROUNDS)


def _measure(page: AppTest, rounds: int) -> None:
    from pages.shared.cases import sample_case

    case = sample_case()
    reader = _Read(case)
    diagnosis = case.diagnose(reader)
    assert diagnosis.road is not None
    test = diagnosis.road.road_test
    times: dict[str, list[float]] = {"leakage": [], "diagnosis": []}
    scripts.clear()
    for number in range(rounds):
        ends = (test.time[0] + 1.0 + 0.5 * number, test.time[-1] - 2.0)
        cursors = next(slider for slider in page.main.slider if "Part shown" in slider.label)
        cursors.set_value(ends)
        page.run()
        assert not page.exception
        for name, run in (
            ("leakage", lambda ends=ends: diagnosis.over(test.window(*ends))),
            ("diagnosis", lambda: case.diagnose(reader)),
        ):
            begin = time.thread_time()
            run()
            times[name].append(time.thread_time() - begin)
    script, leakage, whole = map(statistics.median, (scripts, times["leakage"], times["diagnosis"]))
    assert len(scripts) == rounds
    print(f"leakage over the part / whole diagnosis         {leakage / whole:.3f}   ({_ms(leakage)} / {_ms(whole)})")
    print(f"the page's script / whole diagnosis             {script / whole:.2f}    ({_ms(script)} / {_ms(whole)})")


class _Read(Reader):
    """A reader of a job's files and catalogue entries that reads each once."""

    def __init__(self, case: Case) -> None:
        self._log, self._entries = super().log(case), {}
        self._sheet = super().readings(case, self.entry(SLOTS["controller"], case.controller))

    def entry(self, slot: Slot, choice: CaseChoice) -> Any:
        if slot.name not in self._entries:
            self._entries[slot.name] = super().entry(slot, choice)
        return self._entries[slot.name]

    def readings(self, case: Case, controller: Controller) -> Readings:
        return self._sheet

    def log(self, case: Case) -> Understood:
        return self._log


def _timed(run: Any) -> Any:
    def timed(*arguments: Any, **keywords: Any) -> Any:
        begin = time.thread_time()
        try:
            return run(*arguments, **keywords)
        finally:
            scripts.append(time.thread_time() - begin)

    return timed


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:.0f} ms" if seconds > 0.01 else f"{seconds * 1e3:.1f} ms"


if __name__ == "__main__":
    main(OPTIONS.parse_args())

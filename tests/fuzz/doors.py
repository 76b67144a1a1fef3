"""The doors through which files come in, each with what a caller does with what it gets; and how a file passes one."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.instruments import load_instrument
from atleak.catalogue.limits import load_limits
from atleak.common.damage import OWN_FAULT, damaged, own_line
from atleak.common.errors import AtleakError, InputError
from atleak.common.pictures import printable_picture
from atleak.job.case import SourceFile, load_source
from atleak.job.kinds import kind_of
from atleak.job.photos import without_notes
from atleak.job.result import judged_otherwise
from atleak.job.zip_file import parse_job, read_job_file
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.readers.gauges.gauge_study import read_study
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.readers.logs import log_columns, remember, understand
from atleak.readers.process.parent import FaultOfChild
from atleak.readers.remembered_columns import recall_all
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.typed_sheet import typed_in
from atleak.report.json.diagnosis import diagnosis_record
from tests.effort import in_time, most_calls

CALLS = 10_000_000
"""Calls of functions that a file may take; what a child process does has a budget of its own."""


class OwnFault(Exception):
    """A fault of atleak's own was turned into a refusal by a door's guard."""


@cache
def _controller() -> Controller:
    return load_controller("four_speed_2023")


def _job(name: str, content: bytes) -> None:
    job = read_job_file(content, name=name)
    judged_otherwise(job.result, diagnosis_record(job.diagnose()))


def _typed(name: str, content: bytes) -> None:
    minimal = load_controller("minimal_example")
    typed_in(content, read_readings(content, minimal, name=name), minimal)


def _picture(name: str, content: bytes) -> None:
    without_notes(content)
    printable_picture(name, content)


def _remembered(name: str, content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        recall_all(path)
        remember(path, "cd", {"engine_speed": "rpm"})
        recall_all(path)


OF: dict[str, Callable[[str, bytes], object]] = {
    "readings": lambda name, content: read_readings(content, _controller(), name=name),
    "pressures": lambda name, content: read_pressure_table(content, _controller(), name=name),
    "vacuum": lambda name, content: read_vacuum_table(content, _controller(), name=name),
    "flows": lambda name, content: read_flow_table(content, _controller(), name=name),
    "study": lambda name, content: read_study(content, name=name),
    "road_test": lambda name, content: understand(content, name=name),
    "columns": lambda name, content: log_columns(content, name=name),
    "controller_workbook": lambda name, content: read_controller_workbook(content, name=name),
    "kind": lambda name, content: kind_of(SourceFile(name, content), _controller()),
    "typed": _typed,
    "job": _job,
    "record": lambda name, content: parse_job(content, name),
    "controllers": lambda name, content: load_source(load_controller, SourceFile(name, content)),
    "fluids": lambda name, content: load_source(load_fluid, SourceFile(name, content)),
    "limits": lambda name, content: load_source(load_limits, SourceFile(name, content)),
    "instruments": lambda name, content: load_source(load_instrument, SourceFile(name, content)),
    "picture": _picture,
    "remembered": _remembered,
}
GUARD = damaged(ValueError()).problem.template
"""The wording of a refusal by a door's guard, where nobody thought of what is wrong with a file."""
NO_JOB = "this job cannot be computed ({reason})"
"""The wording of `Case.diagnose` where whatever came out of computing a job."""
KNOWN = {
    NO_JOB: ArithmeticError,  # numbers that no unit has overflow in whichever line computes with them first
}
"""What may come out of a line of atleak's own, by the wording of the refusal, and why."""
LONGEST = 20_000
"""Characters of an error: what a file says is shortened where it is quoted."""


def passes(door: str, name: str, content: bytes) -> InputError | None:
    """Hand a file to a door; return why it was refused, None where it was taken.

    Raises
    ------
    AssertionError
        where it took more work than it may.
    OwnFault
        where it was refused because atleak itself failed on it.
    Exception
        whatever else came out: nothing should.
    """
    refused: AtleakError | None = None
    with in_time(), most_calls(CALLS):
        try:
            OF[door](name, content)
        except AtleakError as error:
            refused = error
    if refused is not None:
        said = str(refused)
        said.encode("utf-8")  # it can be printed
        assert len(said) < LONGEST, f"{len(said)} characters of error"
        assert isinstance(refused, InputError)
        if (fault := fault_behind(refused)) is not None:
            raise OwnFault(fault) from refused
    return refused


def fault_behind(refused: BaseException | None) -> str | None:
    """Return which line of atleak failed on a file that was refused for that; None where the file was at fault."""
    while isinstance(refused, InputError):
        problem, refused = refused.problem, refused.__cause__ or refused.__context__
        if isinstance(refused, FaultOfChild):
            return problem
        if problem.template not in (OWN_FAULT, NO_JOB) or refused is None:
            continue
        if not isinstance(refused, KNOWN.get(problem.template, ())):
            return f"{type(refused).__name__} at {at}" if (at := own_line(refused)) else None
    return None

"""Units that are diagnosed quickly, and some that do a worker harm; workers of the tests import them too."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from atleak.fleet.columns import Rows
from atleak.fleet.units import FleetUnit
from atleak.job.case import Case, SourceFile
from atleak.measurements.job_card import Job


def small_unit(number: int, kind: type[FleetUnit] = FleetUnit, **more: object) -> FleetUnit:
    """A unit of the smallest valve body, worn a little more than the one before it."""
    rows = ["component,part,plane,direction,diameter [mm]"]
    for direction in (0, 90):
        rows.append(f"tcc_regulator,spool,1,{direction},11.0000")
        rows.append(f"tcc_regulator,sleeve,1,{direction},{11.03 + 0.0001 * number:.4f}")
    case = Case(
        readings=SourceFile(f"{number}.csv", "\n".join(rows).encode()), controller="minimal_example", remember=False
    )
    return kind(f"unit {number}", f"file:{number}", case=case, job=Job(number=str(number)), **more)  # type: ignore[arg-type]


def bad_unit(number: int) -> FleetUnit:
    """A unit whose measuring sheet is none."""
    case = Case(readings=SourceFile("bad.csv", b"no sheet at all, %d" % number), controller="minimal_example")
    return FleetUnit(f"unit {number}", f"file:{number}", case=case, job=Job())


class Faulty(FleetUnit):
    """A unit at which atleak has a fault."""

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        raise ZeroDivisionError("of atleak's own")


class Short(FleetUnit):
    """A unit for which the memory does not suffice, as the system says."""

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        raise MemoryError


class Slow(FleetUnit):
    """A unit that takes for ever, in Python."""

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        while True:
            time.sleep(0.01)


class Stuck(FleetUnit):
    """A unit that hangs in compiled code, which lets no other code of Python's run."""

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        if sys.platform == "win32":
            ctypes.PyDLL("kernel32").Sleep(600_000)
        else:
            ctypes.PyDLL(None).sleep(600)
        raise AssertionError


class Deadly(FleetUnit):
    """A unit at which a process ends, as a library's fault would end it."""

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        os._exit(13)


class Greedy(FleetUnit):
    """A unit that takes more and more memory."""

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        taken = []
        while True:
            taken.append(b"1" * (8 << 20))
            time.sleep(0.01)


@dataclass(frozen=True)
class OnceDeadly(FleetUnit):
    """A unit at which a process ends the first time alone."""

    mark: str = ""  # path of a file that is made then

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        try:
            os.close(os.open(self.mark, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            return self._later()
        return self._first()

    def _first(self) -> tuple[Case, Job]:
        os._exit(13)

    def _later(self) -> tuple[Case, Job]:
        return super().opened()


class Lost(OnceDeadly):
    """A unit whose process ends as it hands over its result the first time, and as it begins at any other."""

    def _first(self) -> tuple[Case, Job]:
        Rows.__reduce_ex__ = lambda self, protocol: os._exit(13)  # type: ignore[method-assign,assignment]
        return super()._later()

    def _later(self) -> tuple[Case, Job]:
        os._exit(13)

"""Hold one unit of a fleet, its files and what is known of it, ready to travel to the worker that diagnoses it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from atleak.common.errors import AtleakError, InputError, Place
from atleak.common.sentences import Sentence
from atleak.job.case import OWN_FILES, SLOTS, Case, SourceFile
from atleak.job.parts import name_within
from atleak.job.zip_file import read_job_file
from atleak.measurements.job_card import Job

FILE, TABLE, BOOK = "file:", "table:", "book:"
"""What a reference begins with: that of a job file, of a row of a table, of a job of the book."""
TRAVELS_UP_TO = 16 << 20  # bytes of a file that goes along with the unit; a larger one is read where the work is done


@dataclass(frozen=True)
class FleetUnit:
    """One unit to be diagnosed: a job file, or a case and what the workshop wrote down; or the reason why neither.

    It is small and can be pickled. What `find_units` gives has its hash, and with it those of its files, known.
    """

    name: str  # as people know it: a path as given; ``table.csv, row 7``; the number of a job of the book
    reference: str  # by which `reopened` opens it again
    group: str | None = None  # that it is compared in
    labels: tuple[tuple[str, str], ...] = ()  # heading → text of what else a table says of it: batch, supplier
    job_file: SourceFile | None = None  # of the unit, or None
    case: Case | None = None  # files and choices, where there is no job file
    job: Job | None = None  # what the workshop wrote down
    fault: AtleakError | None = None  # why it cannot be opened, where that was seen when it was found
    choices: str = ""  # those of the run for rows of a table that name none: with them `reopened` opens it again

    @cached_property
    def input_sha256(self) -> str:
        """Return the hash of all that its result and its rows rest on: of a job file that of its bytes.

        Raises
        ------
        InputError
            a file that cannot be read.
        """
        if self.job_file is not None and not self.of_table:
            return self.job_file.sha256
        record = None if self.job is None else self.job.model_dump_json(exclude_defaults=True)
        rests_on = (
            None if self.job_file is None else self.job_file.sha256,
            None if self.case is None else self.case.key,
            record,
            self.group,
            sorted(self.labels),
            None if self.fault is None else (self.reference, str(self.fault)),
        )
        return hashlib.sha256(repr(rests_on).encode("utf-8", "backslashreplace")).hexdigest()

    @property
    def of_table(self) -> bool:
        """Return whether it is the row of a table."""
        return self.reference.startswith(TABLE)

    def opened(self, folder: Path | None = None) -> tuple[Case, Job]:
        """Return the case to diagnose and the record of the job.

        Parameters
        ----------
        folder
            where a large log of a job file is unpacked; unless given, it is held.

        Raises
        ------
        AtleakError
            why it cannot be opened; a large file that is not what it was when the unit was found.
        """
        if self.fault is not None:
            raise self.fault
        for file in self._files():
            _check_unchanged(file)
        if self.job_file is not None:
            source = self.job_file
            kept = read_job_file(source.given, name=source.name, folder=folder)
            return kept.case, kept.job
        return self.case or Case(), self.job or Job()

    def name_within(self, error: InputError) -> None:
        """Name the job file, in an error about a file in it, as `atleak.job.parts.JobFile.diagnose` does."""
        whole = None if self.job_file is None else self.job_file.name
        if whole is not None and not (error.place.file or "").startswith(whole):  # which opening it names already
            name_within(error, whole)

    def _files(self) -> Iterator[SourceFile]:
        """Return the files of its own and those chosen in place of the catalogue's."""
        of_case = () if self.case is None else (getattr(self.case, name) for name in (*OWN_FILES, *SLOTS))
        yield from (file for file in (self.job_file, *of_case) if isinstance(file, SourceFile))


def travelling(path: Path) -> SourceFile:
    """Return a file as it goes along with a unit: its bytes, or where it lies, in full, where it is large.

    Raises
    ------
    InputError
        a file that cannot be read.
    """
    at = SourceFile(path.name, path=path.absolute())
    try:
        large = path.stat().st_size > TRAVELS_UP_TO
    except OSError:
        large = False  # `content` says why it cannot be read
    return at if large else SourceFile(at.name, at.content)


def _check_unchanged(file: SourceFile) -> None:
    if file.data is None and file.path is not None and SourceFile.at(file.path).sha256 != file.sha256:
        problem = Sentence("has changed since the run found it")
        raise InputError(problem, place=Place(file=str(file.path)), expected=Sentence("the run to be started again"))

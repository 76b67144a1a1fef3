"""Follow the log of a job while its logger is still writing it."""

from __future__ import annotations

import stat
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.limits import Limits
from atleak.common.errors import AtleakError, Place, RoadTestError, reason_of
from atleak.common.sentences import Sentence
from atleak.diagnosis.road import RoadFindings, road_findings
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR
from atleak.job.case import SLOTS, Case, Reader, SourceFile
from atleak.measurements.events import Event
from atleak.readers.cells.sheet_file import stated_encoding
from atleak.readers.logs import Understood
from atleak.readers.logs.log_file import HEAD_BYTES, form_of, refuse_what_is_no_log

SETTLED = 3.0  # [s] after which nothing that is still to come moves an event: the longest pause within a shift
LINES = (
    100  # a text that has more of them, and cannot be read as a log, is none; no logger writes as many above a table
)
TURN = 10.0  # [s] for which the log of a folder has no new line before one written since is followed in its place
EARLIER = 20  # logs kept that had begun before the one that is followed: the latest
_ENDINGS = (".csv", ".tsv", ".txt", ".log", ".dat", ".asc", ".json", ".jsonl")  # of logs that grow line by line
_GROWS = Sentence("a text that the logger writes line by line")


@dataclass
class WatchedLog:
    """A log that grows: what its whole lines hold so far. A last line without an end waits until it has one.

    The log is read anew whenever there is more of it, by the readers of every other log, for at most half of the time.
    A log that is replaced, or cut off, has begun anew: what was read before is kept in ``earlier``.
    """

    path: Path  # of the log, or of a folder of which the newest log is followed
    case: Case  # the job: how the log is read, and with what it is judged
    file: SourceFile | None = None  # what was read: the whole lines
    findings: RoadFindings | None = None  # what they say
    waits: AtleakError | None = None  # why what is there now says nothing, or nothing more
    since: float = field(default_factory=time.monotonic)  # when it had a new line last, or where it has none was begun
    earlier: list[SourceFile] = field(default_factory=list)  # the latest that had begun before this one
    _seen: tuple[object, ...] = ()  # path, size and time of the file that was read last
    _followed: Path | None = None  # the log of a folder
    _refused: dict[Path, int] = field(default_factory=dict)  # others in it that are no logs, by when they were written
    _rests_until: float = 0.0
    _told: set[tuple[object, ...]] = field(default_factory=set)

    @property
    def quiet(self) -> float:
        """Return for how long no whole line was added [s]."""
        return time.monotonic() - self.since

    @cached_property
    def controller(self) -> Controller:
        """Return the valve body by which it is judged."""
        controller: Controller = Reader().entry(SLOTS["controller"], self.case.controller)
        return controller

    @cached_property
    def _limits(self) -> Limits:
        limits: Limits = Reader().entry(SLOTS["limits"], self.case.limits)
        return limits

    def judge_by(self, case: Case) -> None:
        """Read and judge it from now on as another job says, such as one with another valve body."""
        if case != self.case:
            self.case, self._seen = case, (None,)
            for name in ("controller", "_limits"):
                vars(self).pop(name, None)

    def look(self) -> bool:
        """Read what was written since the last time; return whether there was any.

        Raises
        ------
        AtleakError
            a file that is no log, or cannot be opened, before anything was read.
        """
        now = time.monotonic()
        if now < self._rests_until:
            return False
        try:
            path = self._of_folder() if self.path.is_dir() else self.path
            state = path.stat()
            if not stat.S_ISREG(state.st_mode):
                raise RoadTestError(Sentence("is no file"), place=Place(file=path.name), expected=_GROWS)
            seen = (path, state.st_size, state.st_mtime_ns)
            if seen == self._seen:
                return False
            data = path.read_bytes()
        except (OSError, AtleakError) as error:
            if not isinstance(error, AtleakError):
                problem = Sentence("cannot be opened: {reason}", reason=reason_of(error))
                error = RoadTestError(problem, place=Place(file=self.path.name))
            self.waits, first = error, not self._seen
            self._seen = (None,)  # what comes there next is read
            if first:  # where one was there, a new one may be about to begin
                raise error from None
            return False
        first, again, self._seen = not self._seen, self._seen == (None,), seen
        try:
            new = self._take(path.name, data, again=again)
        except AtleakError:
            if path == self.path:
                raise
            self._refused[path] = state.st_mtime_ns  # another of the folder is looked for
            return False
        if new:
            written = max(0.0, time.time() - state.st_mtime) if first else 0.0
            self.since, self._rests_until = now - written, 2 * time.monotonic() - now
        return new

    def _of_folder(self) -> Path:
        """Return the log to follow in a folder: the one before while it has new lines, or else the newest.

        A file that is refused as a log is passed over until it is written anew.

        Raises
        ------
        AtleakError
            a folder without a log.
        """
        written = {path: path.stat().st_mtime_ns for path in self.path.iterdir() if _may_be_log(path)}
        logs = [path for path in written if self._refused.get(path) != written[path]]
        logs.sort(key=lambda path: (written[path], path.name), reverse=True)
        place, expected = Place(file=self.path.name), Sentence("a file of a logger in the folder")
        refusal: AtleakError = RoadTestError(Sentence("holds no log"), place=place, expected=expected)
        if self._followed in logs and self.quiet < TURN:
            return self._followed
        for path in logs:
            try:
                if path != self._followed:
                    WatchedLog(path, self.case).look()
            except AtleakError as error:
                self._refused[path], refusal = written[path], error
            else:
                self._followed = path
                return path
        raise refusal

    def _take(self, name: str, data: bytes, *, again: bool) -> bool:
        """Read the whole lines of a log, also where there is no new one if ``again``; return whether there is one."""
        before = b"" if self.file is None else self.file.content
        whole = whole_lines(data)
        if self.file is not None and (name != self.file.name or not whole.startswith(before)):
            if self.findings is not None:
                held = [e for e in self.earlier if (e.name, e.content) != (self.file.name, before[: len(e.content)])]
                self.earlier = [*held, self.file][-EARLIER:]
            self.file, self.findings, self.since, before = None, None, time.monotonic(), b""
            self._told.clear()
        if data.strip(b"\0 \t\r\n") and self.findings is None:
            _refuse_what_does_not_grow(name, data)
        if not whole or (whole == before and not again):
            if not whole:
                expected = Sentence("the first lines, as the logger writes them")
                self.waits = RoadTestError(Sentence("is empty so far"), place=Place(file=name), expected=expected)
            return False
        file, log = SourceFile(name, whole), None
        case = replace(self.case, road_test=file)
        try:
            log = Reader().log(case)
            self.findings, self.waits, self.file = self._found(case, log), None, file
        except AtleakError as error:
            self.waits = error
            if self.findings is None:  # otherwise what could be read last stays
                self.file = file
                if log is None and whole.count(b"\n") > LINES:
                    raise
        return whole != before

    def _found(self, case: Case, log: Understood) -> RoadFindings:
        test = case.driven(log, self.controller)
        guard = GUARD_FACTOR if case.guard_factor is None else case.guard_factor
        assumptions = DEFAULTS.with_settings(dict(case.assumptions))
        return road_findings(self.controller, test, self._limits, assumptions, guard)

    def news(self, *, ended: bool = False) -> Iterator[Event]:
        """Yield events that are over and were not told yet; with ``ended`` those too that reach to the last line."""
        if self.findings is None:
            return
        over = self.findings.road_test.time[-1:] - (0.0 if ended else SETTLED)
        for event in self.findings.events:
            named = (event.kind, round(event.start, 1))
            if named not in self._told and (event.stop <= over).any():
                self._told.add(named)
                yield event


def whole_lines(data: bytes) -> bytes:
    r"""Return the lines of a text that have an end.

    >>> whole_lines(b"t;p\r\n0.1;74")
    b't;p\r\n'
    """
    end = max(data.rfind(b"\n"), data.rfind(b"\r")) + 1
    return data[: end + end % 2] if (stated_encoding(data) or "").startswith("utf-16") else data[:end]


def _may_be_log(path: Path) -> bool:
    return path.suffix.lower() in _ENDINGS and not path.name.startswith(".") and path.is_file()


def _refuse_what_does_not_grow(name: str, data: bytes) -> None:
    refuse_what_is_no_log(data[:HEAD_BYTES], name)
    if data[:2] == b"\x1f\x8b" or form_of(data) not in ("text", "json"):
        raise RoadTestError(Sentence("is no log that grows line by line"), place=Place(file=name), expected=_GROWS)

"""Opens a log from a path or bytes and says what kind of file it is.

What is no log (pictures, archives, binaries, JSON, files of measured parts) is named and refused before all is read.
"""

from __future__ import annotations

import gzip
import hashlib
import io
import re
import tempfile
import zlib
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

from atleak.common.errors import Message, Place, RoadTestError, reason_of
from atleak.common.sentences import Sentence
from atleak.readers.cells.sheet_file import foreign_kind
from atleak.readers.logs.loggers import SHOWN, known_logger, logger_by_name

_FORMS = Sentence("delimited text, xlsx, Parquet or MDF4 as the logger exports it")
_DOCUMENTS = {b"<?xml": Sentence("an XML document"), **dict.fromkeys((b"<!DOCTYPE", b"<html"), Sentence("a web page"))}
_JSON_LINES = re.compile(rb"\A(?:\xef\xbb\xbf)?\s*\{.*\}[ \t\r]*\n\s*\{.*\}[ \t\r]*(?:\n|\Z)")
_JSON = re.compile(rb'\A\s*(?:\{\s*["}]|\[\s*[\[{"\]])')
_Q_DAS = re.compile(rb"\A\s*K\d{4}(?:/\d+)?[ \t]", re.MULTILINE)
# what reports of coordinate measuring machines call their columns, in five languages
_PARTS = re.compile(
    r"\b(?:nominal|nennma(?:ß|ss)|nennwert|nominell|sollma(?:ß|ss)|meas|measured|actual|istma(?:ß|ss)|istwert|medido|atual"
    r"|mesur[ée]|dev|deviation|abweichung|abw|desvio|[ée]cart|outtol|out of tol|tol|toleranz|toler[âa]ncia|tol[ée]rance"
    r"|radius|raio|rayon|durchmesser|di[âa]metro|diam[èe]tre|diameter|circle|kreis|c[íi]rculo|cercle|cylinder|zylinder"
    r"|cilindro|cylindre|plane|ebene|plano|plan|nominalny|zmierzony|odchy[łl]ka|tolerancja|promie[ńn]|[śs]rednica)\b",
    re.IGNORECASE,
)
_SEVERAL = 4  # such words make a report
_TEXT = bytes({7, 8, 9, 10, 12, 13, 27} | set(range(0x20, 0x100)))


def refuse_what_is_no_log(head: bytes, file: str) -> None:
    """Refuse a file whose first bytes show that it is no log, or none that can be read."""
    place = Place(file=file)
    shown = head[:SHOWN].decode("latin-1").replace("\r", "") if form_of(head) == "text" else ""
    if (logger := known_logger(shown)) is not None and (refusal := logger.refusal(file)) is not None:
        raise refusal
    if not head.strip(b" \t\r\n\x00\xef\xbb\xbf\xff\xfe"):
        problem = Sentence("is empty: the logger wrote nothing")
        if head.strip(b" \t\r\n"):
            problem = Sentence(
                "holds nothing but zero bytes: the logger did not finish writing it, or the card is damaged"
            )
        raise RoadTestError(problem, place=place)
    if (what := foreign_kind(head, _DOCUMENTS)) is not None:
        problem = Sentence("is {what}, no road-test log, whatever its name says", what=what)
        raise RoadTestError(problem, place=place, expected=_FORMS)
    if _JSON.match(head) and form_of(head) != "json":
        problem = Sentence("is JSON: nothing tells which of its values are the rows of a log")
        raise RoadTestError(problem, place=place, expected=_FORMS)
    if _Q_DAS.match(head):
        problem = Sentence("is a Q-DAS file of measured parts (K fields), no road-test log")
        raise RoadTestError(problem, place=place, expected=Sentence("a log; diameters belong in a measuring sheet"))


def without_a_table(head: bytes, file: str) -> RoadTestError:
    """Return the error for a text in which no table was found, naming what it is where that can be told."""
    place, binary = Place(file=file), len(head.translate(None, _TEXT)) > 0.02 * len(head)
    if binary:
        logger = logger_by_name(file)
        problem = Sentence("is no text: a binary file of a form that is not known")
        return (logger and logger.refusal(file)) or RoadTestError(problem, place=place, expected=_FORMS)
    return of_measured_parts(head, file) or RoadTestError(
        Sentence("no table of numbers was found in it"),
        place=place,
        expected=Sentence("a log with a header and rows of numbers, as the logger exports it"),
    )


def of_measured_parts(head: bytes, file: str) -> RoadTestError | None:
    """Return the error for a report of a coordinate measuring machine; None where it is none."""
    words = {word.lower() for word in _PARTS.findall(head.decode("utf-8", errors="replace"))}
    if len(words) < _SEVERAL:
        return None
    problem = Sentence("is a measuring machine's report of parts, no road-test log")
    expected = Sentence("a log; diameters belong in a measuring sheet")
    return RoadTestError(problem, place=Place(file=file), expected=expected)


HEAD_BYTES = 1 << 16
"""Bytes that show what a file is."""
LARGE = 1 << 18
"""Text files beyond this size are not read into memory as a whole unless they must be."""
SPARE = 120 << 20
"""Bytes a packed file may unfold to beyond `_GROWTH` times its size; keeps memory within 6 × size + 200 MB."""
_GROWTH = 4

TIMES = 6
"""How many times its size a text takes at most while it is read whole."""

Form = Literal["text", "workbook", "mdf", "parquet", "json", "mlg"]
_READ_FROM_DISK = ("text", "parquet", "mdf")  # forms of which a large file is not held


class Digest:
    """The SHA-256 of a file, computed in a thread while the file is read."""

    def __init__(self, source: bytes | Path) -> None:
        self._source, self._stopped = source, False
        self._computed: Future[str] | None = None

    def start(self) -> Future[str]:
        """Start computing, where that was not done already."""
        if self._computed is None:
            pool = ThreadPoolExecutor(1)
            self._computed = pool.submit(self._compute)
            pool.shutdown(wait=False)
        return self._computed

    def stop(self) -> None:
        """Compute no further, where nobody needs it: the file is open no more."""
        self._stopped = True
        if self._computed is not None:
            wait([self._computed])

    def _compute(self) -> str:
        if isinstance(self._source, bytes):
            return hashlib.sha256(self._source).hexdigest()
        digest = hashlib.sha256()
        with self._source.open("rb", buffering=0) as stream:
            while not self._stopped and (piece := stream.read(1 << 18)):
                digest.update(piece)
        return digest.hexdigest()

    def __str__(self) -> str:
        try:
            return self.start().result()
        except OSError as error:  # the disk does not give them
            raise RoadTestError(Sentence("cannot be read: {reason}", reason=reason_of(error))) from error


@dataclass(frozen=True)
class LogFile:
    """The bytes of a log, before anything in them is understood.

    ``head`` are its first bytes, ``data`` all of them (unpacked when it came packed), read from ``path`` only when
    asked for: a large clean file is read by the fast reader itself. A packed log lies unpacked in
    ``folder`` until `close`.
    """

    file: str
    digest: Digest
    head: bytes
    form: Form
    size: int
    path: Path | None = None
    content: bytes | None = field(default=None, repr=False)
    folder: tempfile.TemporaryDirectory[str] | None = field(default=None, repr=False)
    notes: tuple[Message, ...] = ()  # what is to be said of it
    tell: Callable[[int], object] = lambda _: None  # told how many rows are read so far

    @cached_property
    def data(self) -> bytes:
        """Return all bytes of the log."""
        if self.content is not None:
            return self.content
        assert self.path is not None
        return self.path.read_bytes()

    @property
    def apart(self) -> bytes | Path:
        """Return what another process reads it from: its bytes where they are read already, else where it lies."""
        return self.data if self.content is not None or self.path is None else self.path

    @property
    def whole_lines(self) -> bytes:
        """Return the first bytes up to the end of a line: no character of a text is cut there."""
        return self.head if self.size <= len(self.head) else self.head[: self.head.rfind(b"\n") + 1] or self.head

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the file as it was given."""
        return str(self.digest)

    def error(self, problem: Sentence, value: object = None, expected: Sentence | None = None) -> RoadTestError:
        """Return an error about the file."""
        return RoadTestError(problem, place=Place(file=self.file), value=value, expected=expected)

    def close(self) -> None:
        """Delete what was unpacked to disk."""
        if self.folder is not None:
            self.folder.cleanup()

    def part(self, start: int, stop: int) -> bytes:
        """Return the log's bytes from ``start`` to ``stop``."""
        if self.content is not None or self.path is None:
            return self.data[start:stop]
        with self.path.open("rb") as stream:
            stream.seek(start)
            return stream.read(stop - start)


def open_source(source: str | Path | bytes, name: str | None = None) -> LogFile:
    """Open a log: read it whole, but only the first bytes of a large text file.

    A `RoadTestError` refuses a file that is missing, empty, a picture or another file that is no log, only zeros, or
    packed so tightly that unpacking it would fill the memory.
    """
    if isinstance(source, bytes):
        file = name or "log"
        refuse_what_is_no_log(source[:HEAD_BYTES], file)
        return _packed_or_not(source, file, Digest(source), None)
    path = Path(source)
    file = name or path.name
    try:
        with path.open("rb") as stream:
            head = stream.read(LARGE)
            refuse_what_is_no_log(head[:HEAD_BYTES], file)
            size = path.stat().st_size
            form = form_of(head)
            if size > LARGE and form in _READ_FROM_DISK and head[:2] != b"\x1f\x8b":
                return LogFile(file, Digest(path), head, form, size, path)
            data = head + stream.read()
    except OSError as error:
        problem = Sentence("cannot be opened: {reason}", reason=reason_of(error))
        raise RoadTestError(problem, place=Place(file=file)) from error
    return _packed_or_not(data, file, Digest(data), path)


def _packed_or_not(data: bytes, file: str, digest: Digest, path: Path | None) -> LogFile:
    if data[:2] != b"\x1f\x8b":
        return LogFile(file, digest, data[:LARGE], form_of(data), len(data), path, data)
    folder = tempfile.TemporaryDirectory(prefix="atleak-")
    try:
        unpacked = Path(folder.name) / "log"
        _unpack(data, file, unpacked)
        size = unpacked.stat().st_size
        with unpacked.open("rb") as stream:
            head = stream.read(LARGE)
        form = form_of(head)
        if form in _READ_FROM_DISK and size > LARGE:
            return LogFile(file, digest, head, form, size, unpacked, None, folder)
        content = unpacked.read_bytes()
    except BaseException:
        folder.cleanup()
        raise
    folder.cleanup()
    return LogFile(file, digest, head, form, size, None, content)


def form_of(data: bytes) -> Form:
    """Return what the first bytes of a log show it to be."""
    if data[:4] == b"PK\x03\x04" or data[:8] == b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1":
        return "workbook"
    if data[:3] == b"MDF" or data[:8] == b"UnFinMF ":
        return "mdf"
    if data[:5] == b"MLVLG":
        return "mlg"
    if data[:4] == b"PAR1":
        return "parquet"
    return "json" if _JSON_LINES.match(data) else "text"


def _unpack(data: bytes, file: str, target: Path) -> None:
    """Unpack into a file."""
    limit, total = _GROWTH * len(data) + SPARE, 0
    place = Place(file=file)
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream, target.open("wb") as out:
            while part := stream.read(1 << 20):
                if not total:
                    refuse_what_is_no_log(part[:HEAD_BYTES], file)
                    if part[:2] == b"\x1f\x8b":
                        raise RoadTestError(Sentence("is packed twice; unpack it first"), place=place)
                total += len(part)
                if total > limit:
                    problem = Sentence('unfolds to more than {size} MB: this is no ordinary log (a "zip bomb"?)')
                    expected = Sentence("a log; if it really is one, unpack it first")
                    raise RoadTestError(problem.of(size=limit >> 20), place=place, expected=expected)
                out.write(part)
    except (OSError, EOFError, zlib.error) as error:
        raise RoadTestError(Sentence("its gz packing is damaged: {reason}", reason=str(error)), place=place) from error
    if not total:
        raise RoadTestError(Sentence("is empty: the logger wrote nothing"), place=place)

"""Mark the files that atleak makes and recognise them again, so that it writes over no others.

A file that bears the mark and was not changed since can be made again; a measuring sheet that somebody filled in
cannot. Little of a file is read: no archive is unpacked and no foreign file is read whole.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import struct
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO, Literal, get_args

from atleak.common.errors import OutputError, Place, reason_of
from atleak.common.sentences import Sentence
from atleak.version import __version__

SealedKind = Literal[
    "record", "report workbook", "measuring sheet", "controller workbook", "PDF", "job file", "table", "TOML file"
]  # fmt: skip

_NAMES: dict[SealedKind, Sentence] = {
    "record": Sentence("record"),
    "report workbook": Sentence("report workbook"),
    "measuring sheet": Sentence("measuring sheet"),
    "controller workbook": Sentence("controller workbook"),
    "PDF": Sentence("PDF"),
    "job file": Sentence("job file"),
    "table": Sentence("table"),
    "TOML file": Sentence("TOML file"),
}
KEYWORD = f"atleak {__version__}"  # of a PDF
PROPERTY = "atleak"  # a workbook's property: its kind, and the digest of its parts
_PART = "docProps/custom.xml"
_UNSEALED = "0" * 64
_SEALED = re.compile(rf'name="{PROPERTY}"><vt:lpwstr>([a-z ]+) ([0-9a-f]{{64}})</vt:lpwstr>')
_PDF = re.compile(rb"<pdf:Keywords>atleak [^<]+</pdf:Keywords>")
_MADE = re.compile(rb"<xmp:ModifyDate>([^<]+)</xmp:ModifyDate><xmp:CreateDate>\1</xmp:CreateDate>")
RECORD_LIMIT = 16 << 20  # bytes of a job record, and of a result
_TAIL = 1 << 20  # bytes at the end of a PDF: its metadata and table of contents
_ENTRIES = 1000  # most entries of an archive that is looked at
_DIRECTORY = 1 << 20  # bytes of an archive's table of contents
_PROPERTIES = 1 << 16  # bytes of a workbook's own properties
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # of the entries of every archive that atleak makes
NO_SOUND_ZIP = (  # the exceptions that zipfile raises for a damaged archive
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, struct.error,
    NotImplementedError, RuntimeError, ValueError, EOFError, IndexError,
)  # fmt: skip


def unsealed(kind: SealedKind) -> str:
    """Return what a workbook's property `PROPERTY` says before `sealed` puts in the digest of its parts."""
    return f"{kind} {_UNSEALED}"


def sealed(content: bytes) -> bytes:
    """Return the workbook with a digest of all its other parts in the place that `unsealed` kept for it.

    Any program that saves the workbook again writes at least one part differently, and the digest no longer fits.
    """
    target = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as parts, zipfile.ZipFile(target, "w") as whole:
        seal = _seal(parts.infolist()).encode()
        for part in parts.infolist():
            data = parts.read(part)
            whole.writestr(part, data.replace(_UNSEALED.encode(), seal) if part.filename == _PART else data)
    return target.getvalue()


def _seal(parts: Iterable[zipfile.ZipInfo]) -> str:
    entries = sorted(f"{part.filename}\0{part.file_size}\0{part.CRC}" for part in parts if part.filename != _PART)
    return hashlib.sha256("\n".join(entries).encode()).hexdigest()


def check_seals(
    inputs: Iterable[str | None], targets: Iterable[tuple[SealedKind, str | None]], *, force: bool = False
) -> None:
    """Check that nothing is written over an input, over another target, or over a file that atleak did not make.

    Parameters
    ----------
    inputs, targets
        names of files as a user gave them, a target's with what is to be written there; ``-`` is standard output, None
        a file that was not asked for.
    force
        whether files that atleak did not make, or that were changed since, may be written over.

    Raises
    ------
    OutputError
        naming the file and, where that helps, ``--force``. An empty file, a device and a file that is not there are no
        obstacle.
    """
    paths_in_use = {Path(name).resolve() for name in inputs if name is not None}
    foreign = []
    for kind, target in targets:
        if target is None:
            continue
        path = Path(target) if target == "-" else Path(target).resolve()
        if path in paths_in_use:
            where = Sentence("standard output") if target == "-" else target
            raise OutputError(Sentence("would be written over another file of this command"), place=Place(file=where))
        paths_in_use.add(path)
        if target != "-" and not force and (reason := _obstacle(path, kind)):
            expected = Sentence("another name, or --force to write over it")
            foreign.append(OutputError(reason, place=Place(file=target), expected=expected))
    if foreign:
        raise OutputError(foreign[0].problem, place=foreign[0].place, expected=foreign[0].expected, others=foreign[1:])


def _obstacle(path: Path, kind: SealedKind) -> Sentence | None:
    """Say why a file may not be replaced by one of this kind; None where it may."""
    try:
        if not path.is_file() or path.stat().st_size == 0 or _kind(path) == kind:
            return None
    except OSError as error:
        return Sentence("is there already and cannot be looked at ({reason})", reason=reason_of(error))
    if kind in {"table", "TOML file"}:
        return Sentence("is there already, and a {kind} bears no mark that atleak made it", kind=_NAMES[kind])
    return Sentence("is there already and is no {kind} that atleak made, or was changed since", kind=_NAMES[kind])


def _kind(path: Path) -> SealedKind | None:
    """Return the kind of file that atleak made; None where it did not make it, or the file was changed since."""
    with path.open("rb") as stream:
        start = stream.read(4)
        size = stream.seek(0, io.SEEK_END)
        if start == b"PK\x03\x04":
            return _archive(stream, size)
        if start == b"%PDF":
            return _pdf(stream, size)
        if start[:1] != b"{" and start[:1] != b"[":
            return None
        stream.seek(0)
        return _record(stream.read(RECORD_LIMIT + 1))


def _record(content: bytes) -> SealedKind | None:
    """Recognise a record: it names its format and atleak; in a list every entry has an id and names atleak."""
    if len(content) > RECORD_LIMIT:
        return None
    try:
        data = json.loads(content)
    except (ValueError, RecursionError):
        return None
    first, known = (data[0], "id") if isinstance(data, list) and data else (data, "format")
    return "record" if isinstance(first, dict) and known in first and isinstance(first.get("atleak"), str) else None


def _pdf(stream: BinaryIO, size: int) -> SealedKind | None:
    """Recognise a PDF of atleak that is unchanged.

    A signature or a note is added behind the end of a PDF; a program that saves it anew dates it.
    """
    stream.seek(max(size - _TAIL, 0))
    tail = stream.read(_TAIL)
    whole = tail.count(b"startxref") == 1 and tail.rstrip().endswith(b"%%EOF")
    return "PDF" if whole and _PDF.search(tail) and _MADE.search(tail) else None


def _archive(stream: BinaryIO, size: int) -> SealedKind | None:
    if not _few_entries(stream, size):
        return None
    try:
        with zipfile.ZipFile(stream) as bundle:
            if (record := _beginning(bundle, "job.json", RECORD_LIMIT + 1)) is not None:
                return "job file" if _record(record) else None
            mark = _SEALED.search((_beginning(bundle, _PART, _PROPERTIES) or b"").decode("utf-8", "replace"))
            if mark is None or mark[2] != _seal(bundle.infolist()):
                return None
            return next((kind for kind in get_args(SealedKind) if kind == mark[1]), None)
    except NO_SOUND_ZIP:
        return None


def _beginning(bundle: zipfile.ZipFile, name: str, limit: int) -> bytes | None:
    """Return the first bytes of an entry; None without one, or where it is packed in a way that atleak does not use."""
    entry = bundle.NameToInfo.get(name)
    if entry is None or entry.compress_type not in PACKINGS:
        return None
    with bundle.open(entry) as part:
        return part.read(limit)


def _few_entries(stream: BinaryIO, size: int) -> bool:
    """Return whether an archive's table of contents is short enough to read, judged by the archive's last bytes."""
    stream.seek(max(size - (1 << 16) - 22, 0))
    tail = stream.read()
    at = tail.rfind(b"PK\5\6")
    if at < 0 or len(tail) < at + 22 or tail[max(at - 20, 0) : at].startswith(b"PK\6\7"):  # the latter: ZIP64
        return False
    entries, length = struct.unpack_from("<HL", tail, at + 10)
    return entries <= _ENTRIES and length <= _DIRECTORY

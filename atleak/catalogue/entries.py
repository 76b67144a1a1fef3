"""Read the catalogue: one TOML file per controller, fluid, limit set and instrument, or a user's file by path.

What ships lies beside this module. The user's own entries lie in `own_folder` and are chosen by id like shipped ones.
Every file states its source and date and is checked against a pydantic model; what is wrong is named by file, table,
key and value.
"""

from __future__ import annotations

import hashlib
import re
import tomllib
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date
from enum import StrEnum
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Generic, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator, StringConstraints

from atleak.catalogue.keys import key
from atleak.common.damage import own_errors_only
from atleak.common.errors import CatalogueError, OutputError, Place, reason_of, text_reason, unknown
from atleak.common.file_faults import NotAccepted
from atleak.common.files import home, made_folder, replace_file
from atleak.common.sentences import Sentence


class Evidence(StrEnum):
    """What a value is known from, the surest first."""

    MEASURED = "measured"  # by the workshop, on such a unit
    PUBLISHED = "published"  # in the source that stands beside it
    REPRESENTATIVE = "representative"  # of such units in general: to be measured or looked up


_HERE = Path(__file__).parent
KINDS = ("controllers", "fluids", "limits", "instruments")
"""The catalogue's folders, of what ships and of the user's own."""
_REMOVED = "removed"  # folder of what was taken out of the own catalogue
_TOML_TEXT = Sentence("TOML text in UTF-8")
_THERE = Sentence("is in your catalogue already")
NO_ENTRY = {
    "controllers": Sentence("no such entry among the controllers"),
    "fluids": Sentence("no such entry among the fluids"),
    "limits": Sentence("no such entry among the limits"),
    "instruments": Sentence("no such entry among the instruments"),
}

NonEmptyText = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]
Identifier = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_]*$")]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


def _evidence(value: Any) -> Evidence | None:
    """Read what a value is known from."""
    if value is None or isinstance(value, Evidence):
        return value
    try:
        return Evidence(value)
    except ValueError:
        raise NotAccepted(Sentence("one of {names}", names=tuple(map(str, Evidence)))) from None


StatedEvidence = Annotated[Evidence | None, BeforeValidator(_evidence), key("How known", "Empty: not stated", width=15)]
Source = Annotated[NonEmptyText, key("Source", "Manual and page, or who measured it", width=40)]
ID_HELP = "Small letters, digits and _"


def _mounting_clearance(value: object) -> float | list[float]:
    """Check a mounting clearance [µm]: a number, or the two ends of the range in which new pairs lie."""
    ends: list[float] = []
    for end in value if isinstance(value, list) and len(value) == 2 else [value]:
        if isinstance(end, bool) or not isinstance(end, int | float) or not 1.0 <= end < 500.0:
            raise NotAccepted(Sentence("µm, a number from 1 to below 500, or a range of two such as [6.4, 20.0]"))
        ends.append(float(end))
    if len(ends) == 1:
        return ends[0]
    if not ends[0] < ends[1]:
        raise NotAccepted(Sentence("a range with its lower end first, such as [6.4, 20.0]"))
    return ends


MountingClearance = Annotated[float | list[float], PlainValidator(_mounting_clearance)]


def _day(value: Any) -> str:
    """Read a date as TOML writes it, or as text; an impossible day is refused."""
    try:
        return date.fromisoformat(str(value)).isoformat()
    except ValueError:
        raise NotAccepted(Sentence('a day such as "2026-01-31"')) from None


class Strict(BaseModel):
    """A table of a catalogue file: unknown keys are errors, and so is a number in quotes."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)


class Entry(Strict):
    """The keys at the head of every catalogue file."""

    id: Identifier = key("Id", f"{ID_HELP}, such as ford_4r44e_1996")
    name: NonEmptyText = key("Name", "What people see")
    source: NonEmptyText = key("Source", "Where the numbers come from")
    date: Annotated[str, BeforeValidator(_day)] = key("Date", "Of the source or of this entry, such as 2026-01-31")
    note: str = key("Note", "Anything a reader of the result must know", default="")


@dataclass(frozen=True)
class Origin:
    """The file that a catalogue object came from."""

    path: Path  # of the file
    sha256: str  # of its bytes
    own: bool = False  # whether it was chosen from the user's own catalogue

    @property
    def file(self) -> str:
        """Return the file's name."""
        return self.path.name


@dataclass(frozen=True)
class Headed:
    """What the head of a catalogue file says, of the object that it describes.

    Attributes
    ----------
    id
        by which options, files and reports name it.
    name
        what people see.
    source
        where its numbers come from.
    date
        of the source or of the entry, as ``2026-01-31``.
    note
        what a reader of a result must know; empty where there is nothing.
    """

    id: str
    name: str
    source: str
    date: str
    note: str


_Loaded = TypeVar("_Loaded")


@dataclass(frozen=True)
class ListedEntry(Generic[_Loaded]):
    """The entries of one kind, by id, and what is wrong with each own file that cannot be used."""

    entries: dict[str, _Loaded]  # by id
    faults: tuple[CatalogueError, ...]  # of own files that cannot be used, one for each


@dataclass(frozen=True)
class Shelf(Generic[_Loaded]):
    """The entries of one kind: how a file is checked, and what is made of it."""

    kind: str  # one of `KINDS`
    model: type[Entry]  # of their files
    made_of: Callable[[Mapping[str, Any], Origin], _Loaded]  # the tables of a file, once they are checked

    @own_errors_only(CatalogueError, "id_or_path")
    def load(self, id_or_path: str | Path) -> _Loaded:
        """Load a shipped entry or one of the user's own by id, or a file by path.

        Raises
        ------
        CatalogueError
            if the file is missing or wrong; the message names file, table, key and value.
        """
        path = _resolve(self.kind, id_or_path)
        if path == shipped_files(self.kind).get(path.stem):
            return _shipped(self, path, path.stat().st_mtime_ns)
        return self.made_of(*read_tables(self.kind, path))

    @own_errors_only(CatalogueError, "file")
    def checked(self, data: Mapping[str, Any], file: str = "this description") -> _Loaded:
        """Return the entry that tables describe which came another way than from a TOML file.

        Raises
        ------
        CatalogueError
            as `load`; ``place.steps`` of every fault leads to it through the tables.
        """
        return self.made_of(data, Origin(Path(file), ""))

    def usable(self) -> list[_Loaded]:
        """Return every entry that can be used, shipped or own."""
        return list(listed_entries(self.kind, self.load).entries.values())


@cache  # pages and fleets ask for the same ones again and again
def _shipped(shelf: Shelf[Any], path: Path, changed: int) -> Any:
    """Return the entry of a file that ships with atleak, as it is since it was ``changed`` last [ns]."""
    return shelf.made_of(*read_tables(shelf.kind, path))


@dataclass(frozen=True)
class ShippedName:
    """What one sees of a shipped entry where one chooses."""

    id: str
    name: str
    origin: Origin
    measures: tuple[str, ...]  # parts that an instrument measures


@cache
def shipped_names(kind: str) -> Mapping[str, ShippedName]:
    """Return what shipped entries of a kind are called, by id: read from the heads of their files, without the rest."""
    heads = {path: path.read_text(encoding="utf-8").partition("\n[")[0] for path in shipped_files(kind).values()}
    read = {path: tomllib.loads(head) for path, head in heads.items()}
    return MappingProxyType(
        {
            path.stem: ShippedName(head["id"], head["name"], Origin(path, ""), tuple(head.get("measures", ())))
            for path, head in read.items()
        }
    )


@cache  # they stay the same as long as a process, and a fleet asks for them with every unit
def shipped_files(kind: str) -> Mapping[str, Path]:
    """Return ids and files of one kind (one of `KINDS`) that ship with atleak, sorted by id."""
    return MappingProxyType({path.stem: path for path in sorted((_HERE / kind).glob("*.toml"))})


def own_folder(kind: str = "") -> Path:
    """Return the folder of the user's own entries of one kind, or of all; it need not be there."""
    return home() / "catalogue" / kind


def own_files(kind: str) -> dict[str, Path]:
    """Return ids and files of one kind in the user's own catalogue, sorted by id: a file is named as its id."""
    return {path.stem: path for path in sorted(own_folder(kind).glob("*.toml"))}


def catalogue_files(kind: str) -> dict[str, Path]:
    """Return ids and files of one kind, shipped and own, sorted by id; a shipped id stays the shipped file's."""
    return dict(sorted({**own_files(kind), **shipped_files(kind)}.items()))


def id_from_name(name: str) -> str:
    """Make an id from a name: small letters, digits and _; "" where nothing of the name can stand in one.

    >>> id_from_name("Ford 4R44E, 1996"), id_from_name("Skrzynia żółta"), id_from_name("変速機")
    ('ford_4r44e_1996', 'skrzynia_zolta', '')
    """
    plain = unicodedata.normalize("NFKD", name.replace("ł", "l").replace("Ł", "L").replace("ß", "ss"))
    return "_".join(re.findall(r"[a-z0-9]+", plain.encode("ascii", "ignore").decode().lower()))


def write_own(kind: str, name: str, text: str, *, over: str = "") -> Path:
    """Write a file into the user's own catalogue, whole or not at all; return its path.

    Parameters
    ----------
    over
        the SHA-256 of the file that may be replaced: another one that is there by now stays.

    Raises
    ------
    OutputError
        an id that ships with atleak, a file that is there, or a folder that cannot be written.
    """
    path = own_folder(kind) / f"{name}.toml"
    place = Place(file=path.name)
    if name in shipped_files(kind):
        problem, expected = Sentence("has the id of an entry that ships with atleak"), Sentence("an id of its own")
        raise OutputError(problem, place=place, expected=expected)
    if path.exists() and hashlib.sha256(path.read_bytes()).hexdigest() != over:
        problem = Sentence("was changed by someone else since") if over else _THERE
        raise OutputError(problem, place=place, expected=Sentence("another id, or a decision to replace it"))
    made_folder(path.parent)
    replace_file(path, text.encode("utf-8"))
    return path


def remove_own(kind: str, name: str) -> None:
    """Take a file out of the user's own catalogue; `restore_own` brings it back until another one of that id goes.

    Raises
    ------
    OutputError
        a file that is not there, or that cannot be moved.
    """
    _move(own_folder(kind) / f"{name}.toml", made_folder(own_folder(kind) / _REMOVED) / f"{name}.toml")


def removed_own(kind: str) -> dict[str, Path]:
    """Return ids and files that were taken out of the user's own catalogue, the last one first."""
    files = sorted((own_folder(kind) / _REMOVED).glob("*.toml"), key=lambda path: path.stat().st_ctime, reverse=True)
    return {path.stem: path for path in files}


def restore_own(kind: str, name: str) -> None:
    """Bring a file back into the user's own catalogue.

    Raises
    ------
    OutputError
        an id that is taken by now, or a file that is not there or cannot be moved.
    """
    path = own_folder(kind) / f"{name}.toml"
    if path.exists():
        raise OutputError(_THERE, place=Place(file=path.name), expected=Sentence("another id"))
    _move(own_folder(kind) / _REMOVED / f"{name}.toml", path)


def _move(path: Path, to: Path) -> None:
    try:
        path.replace(to)
    except OSError as error:
        problem = Sentence("cannot be moved: {reason}", reason=reason_of(error))
        raise OutputError(problem, place=Place(file=path.name)) from error


def listed_entries(kind: str, load: Callable[[str], _Loaded]) -> ListedEntry[_Loaded]:
    """Load every entry of a kind by id; an own file that cannot be used hinders none of the others.

    Raises
    ------
    CatalogueError
        for a shipped file alone.
    """
    shipped, own, entries = shipped_files(kind), own_files(kind), {}
    faults = [_same_id(own[name]) for name in own if name in shipped]
    for name in catalogue_files(kind):
        try:
            entries[name] = load(name)
        except CatalogueError as fault:
            if name in shipped:
                raise
            faults.append(fault)
    return ListedEntry(entries, tuple(faults))


def _same_id(path: Path) -> CatalogueError:
    """Return the fault of an own file with a shipped entry's id: no result would say which of the two it means."""
    return CatalogueError(
        Sentence("has the id of an entry that ships with atleak and is left aside"),
        place=Place(file=path.name, key="id"),
        value=path.stem,
        expected=Sentence("an id of its own, and a file named as it"),
    )


@own_errors_only(CatalogueError, "id_or_path")
def read_tables(kind: str, id_or_path: str | Path) -> tuple[dict[str, Any], Origin]:
    """Read the tables of a catalogue entry by id, or of a user's file by path, as its TOML holds them.

    Raises
    ------
    CatalogueError
        if there is no such entry (the message gives the nearest id), the file cannot be read, its TOML syntax is wrong,
        or it lies in the user's own catalogue under another name than its id.
    """
    path = _resolve(kind, id_or_path)
    own = path == own_files(kind).get(path.stem)
    try:
        content = path.read_bytes()
    except OSError as error:
        problem = Sentence("cannot be read: {reason}", reason=reason_of(error))
        raise CatalogueError(problem, place=Place(file=str(path)), expected=Sentence("a TOML file")) from error
    if content.startswith(b"PK"):  # as every .xlsx does, and no text that is TOML
        command = f"atleak controller from-workbook {path.name} -o {path.stem}.toml"
        expected = _TOML_TEXT
        if kind == "controllers":
            expected = Sentence("the file that '{command}' makes", command=command)
        raise CatalogueError(Sentence("is a workbook"), place=Place(file=path.name), expected=expected)
    try:
        data = tomllib.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:  # also a number of 5000 digits, or tables nested a thousand deep
        problem = Sentence("is not valid TOML: {reason}", reason=text_reason(error))
        raise CatalogueError(problem, place=Place(file=path.name), expected=_TOML_TEXT) from error
    if own and data.get("id", path.stem) != path.stem:
        problem = Sentence("a file of the own catalogue is named as its id")
        expected = Sentence("{id}, or another name of the file", id=path.stem)
        raise CatalogueError(problem, place=Place(file=path.name, key="id"), value=data["id"], expected=expected)
    return data, Origin(path, hashlib.sha256(content).hexdigest(), own)


def _resolve(kind: str, id_or_path: str | Path) -> Path:
    known = catalogue_files(kind)
    if isinstance(id_or_path, str) and id_or_path in known:
        return known[id_or_path]
    path = Path(id_or_path)
    try:
        if path.is_file():
            return path
        folder = bool(path.name) and path.is_dir()
    except OSError:  # the name is longer than the file system allows
        folder = False
    looks_like_path = path.suffix.lower() == ".toml" or len(path.parts) > 1
    problem = Sentence("is a folder") if folder else Sentence("no such file") if looks_like_path else NO_ENTRY[kind]
    otherwise = Sentence("the path of a TOML file")
    raise unknown(problem, str(id_or_path), known, kind=CatalogueError, otherwise=otherwise)

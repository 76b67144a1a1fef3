"""The catalogue: one TOML file per controller, fluid, limit set and instrument; a user's own file is read by path.

Every file states its source and date and is checked against a pydantic model; what is wrong is named by file,
table, key and value.
"""

from __future__ import annotations

import hashlib
import tomllib
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints, ValidationError

from atleak.errors import CatalogueError, Place, nearest_name

_HERE = Path(__file__).parent
_TOML_LINE = 300  # characters of a parser's message worth showing

NonEmptyText = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]
Identifier = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_]*$")]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


def _day(value: Any) -> str:
    """A date as TOML writes it, or as text; an impossible day is refused."""
    try:
        return date.fromisoformat(str(value)).isoformat()
    except ValueError:
        raise ValueError('a day such as "2026-01-31"') from None


class Strict(BaseModel):
    """A table of a catalogue file: unknown keys are errors, and a number in quotes is no number."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Entry(Strict):
    """What every catalogue file heads with."""

    id: Identifier
    name: NonEmptyText
    source: NonEmptyText
    date: Annotated[str, BeforeValidator(_day)]
    note: str = ""


EntryModel = TypeVar("EntryModel", bound=Entry)


@dataclass(frozen=True)
class Origin:
    """Which file a catalogue object came from."""

    path: Path
    sha256: str

    @property
    def file(self) -> str:
        return self.path.name


def catalogue_files(kind: str) -> dict[str, Path]:
    """Ids and files of one kind (``"controllers"``, ``"fluids"``, ``"limits"``), sorted by id."""
    return {path.stem: path for path in sorted((_HERE / kind).glob("*.toml"))}


def read_entry(kind: str, id_or_path: str | Path, model: type[EntryModel]) -> tuple[EntryModel, Origin]:
    """A catalogue entry by id, or a user's file by path, checked against its model.

    Raises
    ------
    CatalogueError
        no such entry (with the nearest id), unreadable file, TOML syntax, or a value that is missing, unknown or
        out of range: naming file, table, key, value and what was expected.
    """
    path = _resolve(kind, id_or_path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise CatalogueError(
            f"cannot be read: {error.strerror}", place=Place(file=str(path)), expected="a TOML file"
        ) from error
    origin = Origin(path, hashlib.sha256(content).hexdigest())
    try:
        data = tomllib.loads(content.decode("utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CatalogueError(
            f"is not valid TOML: {str(error)[:_TOML_LINE]}",
            place=Place(file=path.name),
            expected="TOML text in UTF-8",
        ) from error
    try:
        return model.model_validate(data), origin
    except ValidationError as error:
        raise _explain(error, path, data, model) from None


def _resolve(kind: str, id_or_path: str | Path) -> Path:
    shipped = catalogue_files(kind)
    if isinstance(id_or_path, str) and id_or_path in shipped:
        return shipped[id_or_path]
    path = Path(id_or_path)
    try:
        if path.is_file():
            return path
        folder = bool(path.name) and path.is_dir()
    except OSError:  # a name longer than the file system takes
        folder = False
    looks_like_path = path.suffix.lower() == ".toml" or len(path.parts) > 1
    raise CatalogueError(
        "is a folder" if folder else "no such file" if looks_like_path else f"no such entry among the {kind}",
        value=str(id_or_path),
        expected=f"one of {', '.join(shipped)}, or the path of a TOML file",
        nearest=nearest_name(str(id_or_path), shipped),
    )


def catalogue_error(path: Path, table: str, key: str | None, problem: str, **more: Any) -> CatalogueError:
    """An error of meaning (two keys that do not fit each other) in the same form as an error of type."""
    return CatalogueError(problem, place=Place(file=path.name, table=table or None, key=key), **more)


def _explain(error: ValidationError, path: Path, data: dict[str, Any], model: type[BaseModel]) -> CatalogueError:
    faults = error.errors(include_url=False)
    faults.sort(key=lambda fault: fault["type"] != "extra_forbidden")  # a mistyped key explains the one missing
    first, *others = (_explain_one(fault, path, data, model) for fault in faults)
    first.others = tuple(others)
    return first


def _explain_one(fault: Any, path: Path, data: dict[str, Any], model: type[BaseModel]) -> CatalogueError:
    location = [step for step in fault["loc"] if step != "[key]"]  # pydantic's mark of a fault in a table's own name
    found = fault["input"]
    if isinstance(found, dict) and fault["type"] == "value_error":  # keys that do not go together
        place = Place(file=path.name, table=_table_name(location, data) or None)
        return CatalogueError("the keys of this table do not go together", place=place, expected=_expected(fault))
    entry = f"[{location.pop() + 1}]" if location and isinstance(location[-1], int) else ""
    key = f"{location[-1]}{entry}" if location else ""
    place = Place(file=path.name, table=_table_name(location[:-1], data) or None, key=key or None)
    if fault["type"] == "missing":
        return CatalogueError("required key is missing", place=place)
    if fault["type"] == "extra_forbidden":
        allowed = _keys_at(model, location[:-1])
        return CatalogueError(
            "unknown key",
            place=place,
            value=None if isinstance(found, dict | list) else found,
            expected=f"one of {', '.join(allowed)}" if allowed else None,
            nearest=nearest_name(key, allowed),
        )
    return CatalogueError("value not accepted", place=place, value=found, expected=_expected(fault))


def _expected(fault: Any) -> str:
    """What a fault's key wants, in words of people rather than of pydantic."""
    more = fault.get("ctx", {})
    words = {
        "string_type": "text in quotes",
        "string_too_short": "text that is not empty",
        "string_pattern_mismatch": "small letters, digits and _",
        "float_type": "a number, without quotes",
        "int_type": "a whole number, without quotes",
        "int_from_float": "a whole number",
        "bool_type": "true or false",
        "list_type": "a list in square brackets",
        "dict_type": "a table",
        "model_type": "a table",
        "finite_number": "a number that is not infinite",
        "too_short": f"a list of at least {more.get('min_length')}",
    }
    said = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    return words.get(fault["type"], said)


def _table_name(location: list[Any], data: Any) -> str:
    """``components[3] (id 8).lands[1]``: where a person finds the table."""
    name = ""
    for step in location:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            data = None
        if isinstance(step, int):
            label = data.get("id", data.get("name")) if isinstance(data, dict) else None
            name += f"[{step + 1}]" + (f" ({label})" if label is not None else "")
        else:
            name += f".{step}" if name else str(step)
    return name


def _keys_at(model: type[BaseModel], location: list[Any]) -> list[str]:
    current: Any = model
    for step in location:
        if isinstance(step, int):
            continue
        field = getattr(current, "model_fields", {}).get(step)
        if field is not None:  # a key of a dictionary of tables is no field: its tables are of the model found before
            current = _model_in(field.annotation)
    return [field.alias or name for name, field in getattr(current, "model_fields", {}).items()]


def _model_in(annotation: Any) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for inner in getattr(annotation, "__args__", ()):
        found = _model_in(inner)
        if found is not None:
            return found
    return None

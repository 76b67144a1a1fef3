"""The catalogue: one TOML file per controller, fluid, limit set and instrument; a user's own file is read by path.

Every file states its source and date and is checked against a pydantic model; what is wrong is named by file,
table, key and value.
"""

from __future__ import annotations

import hashlib
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from atleak.errors import CatalogueError, Place, nearest_name

_HERE = Path(__file__).parent
_TOML_LINE = 300  # characters of a parser's message worth showing

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]
Identifier = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_]*$")]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


class Strict(BaseModel):
    """A table of a catalogue file: unknown keys are errors, numbers are numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Entry(Strict):
    """What every catalogue file heads with."""

    id: Identifier
    name: Text
    source: Text
    date: Annotated[str, StringConstraints(pattern=r"^\d{4}-\d{2}-\d{2}$")]
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
    if path.is_file():
        return path
    looks_like_path = path.suffix.lower() == ".toml" or len(path.parts) > 1
    raise CatalogueError(
        "no such file" if looks_like_path else f"no such entry among the {kind}",
        value=str(id_or_path),
        expected=f"one of {', '.join(shipped)}, or the path of a TOML file",
        nearest=nearest_name(str(id_or_path), shipped),
    )


def catalogue_error(path: Path, table: str, key: str | None, problem: str, **more: Any) -> CatalogueError:
    """An error of meaning (two keys that do not fit each other) in the same form as an error of type."""
    return CatalogueError(problem, place=Place(file=path.name, table=table or None, key=key), **more)


def _explain(error: ValidationError, path: Path, data: dict[str, Any], model: type[BaseModel]) -> CatalogueError:
    faults = [_explain_one(fault, path, data, model) for fault in error.errors(include_url=False)]
    first = faults[0]
    if len(faults) > 1:
        rest = "".join(f"\n  {fault}" for fault in faults[1:10])
        more = f"\n  … and {len(faults) - 10} more" if len(faults) > 10 else ""
        first.args = (f"{first}\nand {len(faults) - 1} more in the same file:{rest}{more}",)
        first.__class__ = _Several
    return first


class _Several(CatalogueError):
    """A catalogue error whose text lists further ones."""

    def __str__(self) -> str:
        return str(self.args[0])


def _explain_one(fault: Any, path: Path, data: dict[str, Any], model: type[BaseModel]) -> CatalogueError:
    location = list(fault["loc"])
    table, key = _table_name(location[:-1], data), str(location[-1]) if location else ""
    place = Place(file=path.name, table=table or None, key=key or None)
    kind = fault["type"]
    if kind == "missing":
        return CatalogueError("required key is missing", place=place)
    if kind == "extra_forbidden":
        allowed = _keys_at(model, location[:-1])
        return CatalogueError(
            "unknown key",
            place=place,
            value=fault["input"],
            expected=f"one of {', '.join(allowed)}" if allowed else None,
            nearest=nearest_name(key, allowed),
        )
    message = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    return CatalogueError("value not accepted", place=place, value=fault["input"], expected=message)


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

"""Faults that pydantic finds in a file that a person wrote, in words of people: table, key and what it wants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from atleak.errors import AnyInputError, InputError, Place, nearest_name, one_of

Model = TypeVar("Model", bound=BaseModel)

_SHOWN = 80  # characters of a value
_WANTED = {
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
    "too_short": "a list of at least {min_length}",
}


def validated(
    model: type[Model],
    data: Any,
    file: str,
    kind: type[AnyInputError] = InputError,  # type: ignore[assignment]
) -> Model:
    """Check what a file holds against its model.

    Parameters
    ----------
    model
        what the file must hold.
    data
        the file's tables, as a TOML or JSON reader gives them.
    file
        the file's name, for the message.
    kind
        the class of the error.

    Raises
    ------
    InputError
        of that class: a value that is missing, unknown or out of range, naming file, table, key, value and what was
        expected; the other faults of the file are listed below the first.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
    faults.sort(key=lambda fault: fault["type"] != "extra_forbidden")  # a mistyped key explains the one missing
    first, *others = (_in_words(fault, file, data, model, kind) for fault in faults)
    first.others = tuple(others)
    raise first


def _in_words(fault: Any, file: str, data: Any, model: type[BaseModel], kind: type[AnyInputError]) -> AnyInputError:
    location = [step for step in fault["loc"] if step != "[key]"]  # pydantic's mark of a fault in a table's own name
    value = fault["input"]
    if isinstance(value, dict) and fault["type"] == "value_error":  # keys that do not go together
        place = Place(file=file, table=_table_name(location, data) or None)
        return kind("the keys of this table do not go together", place=place, expected=_expected(fault))
    entry = f"[{location.pop() + 1}]" if location and isinstance(location[-1], int) else ""
    key = f"{location[-1]}{entry}" if location else ""
    place = Place(file=file, table=_table_name(location[:-1], data) or None, key=key or None)
    if fault["type"] == "missing":
        return kind("required key is missing", place=place)
    if fault["type"] == "extra_forbidden":
        known = _keys_at(model, location[:-1])
        shown = None if isinstance(value, dict | list) else _shortened(value)
        return kind("unknown key", place=place, value=shown, expected=one_of(known), nearest=nearest_name(key, known))
    return kind("value not accepted", place=place, value=_shortened(value), expected=_expected(fault))


def _shortened(value: Any) -> Any:
    return value if len(str(value)) <= _SHOWN else str(value)[:_SHOWN] + " …"


def _expected(fault: Any) -> str:
    """What a fault's key wants, in words of people rather than of pydantic."""
    wanted = _WANTED.get(fault["type"])
    if wanted is not None:
        return wanted.format(**fault.get("ctx", {}))
    return fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")


def _table_name(location: Sequence[Any], data: Any) -> str:
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


def _keys_at(model: type[BaseModel], location: Sequence[Any]) -> list[str]:
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
    return next((model for inner in getattr(annotation, "__args__", ()) if (model := _model_in(inner))), None)

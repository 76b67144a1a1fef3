"""Faults that pydantic finds in a file that a person wrote, in words of people: table, key and what it wants."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from atleak.common.errors import AnyInputError, InputError, KeySteps, Place, nearest_name, one_of
from atleak.common.sentences import Sentence

Model = TypeVar("Model", bound=BaseModel)


class NotAccepted(ValueError):
    """A value, or the cell of a workbook, that is not what is asked for there: raised with what is wanted instead."""

    def __init__(self, wanted: Sentence) -> None:
        self.wanted = wanted
        super().__init__(wanted)


class WrongTogether(NotAccepted):
    """Keys of a table that do not go together: what is wanted, and the steps from the table to the one to change."""

    def __init__(self, wanted: Sentence, *steps: str | int) -> None:
        self.steps = steps
        super().__init__(wanted)


_SHOWN = 80  # characters of a value
_NAMED_BY = ("id", "name", "component")  # keys of a table that name it, the first that it has
_WANTED: Mapping[str, Sentence] = {
    "string_type": Sentence("text in quotes"),
    "string_too_short": Sentence("text that is not empty"),
    "string_pattern_mismatch": Sentence("small letters, digits and _"),
    "float_type": Sentence("a number, without quotes"),
    "int_type": Sentence("a whole number, without quotes"),
    "int_from_float": Sentence("a whole number"),
    "bool_type": Sentence("true or false"),
    "list_type": Sentence("a list in square brackets"),
    "dict_type": Sentence("a table"),
    "model_type": Sentence("a table"),
    "finite_number": Sentence("a number that is not infinite"),
}
_WANTED_OF: Mapping[str, Callable[[Mapping[str, Any]], Sentence]] = {  # from what pydantic says beside the kind
    "too_short": lambda of: Sentence("a list of at least {count}", count=of["min_length"]),
    "greater_than": lambda of: Sentence("greater than {bound:.15g}", bound=of["gt"]),
    "greater_than_equal": lambda of: Sentence("greater than or equal to {bound:.15g}", bound=of["ge"]),
    "less_than": lambda of: Sentence("less than {bound:.15g}", bound=of["lt"]),
    "less_than_equal": lambda of: Sentence("less than or equal to {bound:.15g}", bound=of["le"]),
    "literal_error": lambda of: _alternatives(of["expected"]),
    "enum": lambda of: _alternatives(of["expected"]),
}


def validated(
    model: type[Model],
    data: Any,
    file: str,
    kind: type[AnyInputError] = InputError,  # type: ignore[assignment]
) -> Model:
    """Check what a file holds against its model.

    Raises
    ------
    InputError
        of that class: a value that is missing, unknown or out of range, naming file, table, key, value and what was
        expected; the other faults of the file are listed below the first.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise faults_together(fault_in_words(error, data, file, model, kind)) from None


def faults_together(faults: Sequence[AnyInputError]) -> AnyInputError:
    """Return the first of some faults, with the others listed below it."""
    first, *others = faults
    first.others = tuple(others)
    first.args = (first.sentence,)
    return first


def fault_in_words(
    error: ValidationError, data: Any, file: str, model: type[BaseModel], kind: type[AnyInputError]
) -> list[AnyInputError]:
    """Return what pydantic found wrong, one fault each, a mistyped key before the one that it leaves missing."""
    faults = error.errors(include_url=False)
    faults.sort(key=lambda fault: fault["type"] != "extra_forbidden")
    return [_in_words(fault, file, data, model, kind) for fault in faults]


def place_of(steps: Sequence[str | int], data: Any, file: str) -> Place:
    """Return where in a file's tables the steps lead: to a key, or to an entry of a list under a key."""
    rest = list(steps)
    entry = f"[{rest.pop() + 1}]" if rest and isinstance(rest[-1], int) else ""  # type: ignore[operator]
    key = f"{rest[-1]}{entry}" if rest else ""
    return Place(file=file, table=_table_name(rest[:-1], data) or None, key=key or None, steps=tuple(steps))


def place_of_table(steps: Sequence[str | int], data: Any, file: str) -> Place:
    """Return where in a file the table stands that the steps lead to."""
    return Place(file=file, table=_table_name(steps, data) or None, steps=tuple(steps))


def steps_to(fault: Any) -> KeySteps:
    """Return the steps through a file's tables to what pydantic found wrong."""
    location = tuple(fault["loc"])
    # a fault in a table's own name is marked by one step more; an unknown key may be called like that mark
    return location[:-1] if location[-1:] == ("[key]",) and fault["type"] != "extra_forbidden" else location


def _in_words(fault: Any, file: str, data: Any, model: type[BaseModel], kind: type[AnyInputError]) -> AnyInputError:
    location = steps_to(fault)
    value = fault["input"]
    if isinstance(value, dict) and fault["type"] == "value_error":  # keys that do not go together
        cause = fault["ctx"]["error"]
        steps = (*location, *(cause.steps if isinstance(cause, WrongTogether) else ()))
        place = replace(place_of_table(location, data, file), steps=steps)
        return kind(Sentence("the keys of this table do not go together"), place=place, expected=_expected(fault))
    place = place_of(location, data, file)
    if fault["type"] == "missing":
        return kind(Sentence("required key is missing"), place=place)
    if fault["type"] == "extra_forbidden":
        known = _keys_at(model, location[:-1])
        shown = None if isinstance(value, dict | list) else _shortened(value)
        nearest = nearest_name(str(location[-1]), known)
        return kind(Sentence("unknown key"), place=place, value=shown, expected=one_of(known), nearest=nearest)
    return kind(Sentence("value not accepted"), place=place, value=_shortened(value), expected=_expected(fault))


def _shortened(value: Any) -> Any:
    return value if len(str(value)) <= _SHOWN else str(value)[:_SHOWN] + " …"


def _expected(fault: Any) -> Sentence:
    """What a fault's key wants, in words of people rather than of pydantic."""
    kind, of = fault["type"], fault.get("ctx", {})
    if kind == "float_type" and isinstance(fault["input"], int) and not isinstance(fault["input"], bool):
        return Sentence("a number of at most 300 digits")
    if kind in _WANTED:
        return _WANTED[kind]
    if kind in _WANTED_OF:
        return _WANTED_OF[kind](of)
    if isinstance(of.get("error"), NotAccepted):
        return of["error"].wanted
    return Sentence("{reason}", reason=fault["msg"].removeprefix("Value error, ").removeprefix("Input should be "))


def _alternatives(listed: str) -> Sentence:
    """Say what pydantic lists as ``'a', 'b' or 'c'``."""
    first, _, last = listed.rpartition(" or ")
    return Sentence("{first} or {second}", first=first, second=last) if first else Sentence("{only}", only=last)


def _table_name(location: Sequence[Any], data: Any) -> str:
    """``components[3] (id 8).lands[1]``: where a person finds the table."""
    name = ""
    for step in location:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            data = None
        if isinstance(step, int):
            names = (data.get(key) for key in _NAMED_BY) if isinstance(data, dict) else ()
            label = next((name for name in names if name is not None), None)
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
            current = model_in(field.annotation)
    return [field.alias or name for name, field in getattr(current, "model_fields", {}).items()]


def model_in(annotation: Any) -> type[BaseModel] | None:
    """Return the model of the tables that a field holds, in a list too; None where it holds none."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((model for inner in getattr(annotation, "__args__", ()) if (model := model_in(inner))), None)

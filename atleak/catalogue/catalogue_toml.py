"""Write the tables of a catalogue entry as the TOML file that describes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tomli_w
from pydantic import BaseModel

from atleak.catalogue.controller_tables import ControllerFile
from atleak.faults import model_in


def written_toml(data: Mapping[str, Any], model: type[BaseModel] = ControllerFile) -> str:
    """Return the TOML file of an entry: the keys in the order of its model, none that is None, no comments.

    The same tables give the same text. Tables that are wrong are written too, so that they can be mended.

    Parameters
    ----------
    data
        the tables as a TOML file of the same content gives them.
    model
        what such a file holds; that of a controller unless given.
    """
    return tomli_w.dumps(_ordered(data, model))


def _ordered(table: Mapping[str, Any], model: type[BaseModel] | None) -> dict[str, Any]:
    """Return a table with its keys in the order of its model, unknown ones last."""
    fields = [] if model is None else [field.alias or name for name, field in model.model_fields.items()]
    known = [key for key in fields if key in table]
    keys = [*known, *sorted(key for key in table if key not in known)] if model is not None else list(table)
    return {key: _value(table[key], _model_of(model, key)) for key in keys if table[key] is not None}


def _value(value: Any, model: type[BaseModel] | None) -> Any:
    if isinstance(value, Mapping):
        if model is None or (any(isinstance(each, Mapping) for each in value.values()) and _is_named(value, model)):
            return {str(key): _value(each, model) for key, each in value.items() if each is not None}
        return _ordered(value, model)
    if isinstance(value, list | tuple):
        return [_value(each, model) for each in value]
    return value


def _is_named(value: Mapping[str, Any], model: type[BaseModel]) -> bool:
    """Tell whether a table holds tables by name, such as materials, rather than the keys of its model."""
    return not any((field.alias or name) in value for name, field in model.model_fields.items())


def _model_of(model: type[BaseModel] | None, key: str) -> type[BaseModel] | None:
    for name, field in (model.model_fields if model is not None else {}).items():
        if (field.alias or name) == key:
            return model_in(field.annotation)
    return None

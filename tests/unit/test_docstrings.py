"""Every public name describes what it takes: those of `atleak.__all__`, with their methods, and the equations."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import pydoc
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import atleak
from atleak import equations


def entries(docstring: str | None, heading: str) -> list[str]:
    """The names that a section of a docstring describes: its lines that are not indented, up to their types."""
    text = inspect.cleandoc(docstring or "")
    section = re.search(rf"^{heading}\n-+\n(.*?)(?=^\w[^\n]*\n--+$|\Z)", text, re.MULTILINE | re.DOTALL)
    lines = re.findall(r"^([*\w][^:\n]*?)(?: :.*)?\n +\S", section[1], re.MULTILINE) if section else []
    return [name.strip("* ") for line in lines for name in line.split(",")]


def faults(taken: list[str], described: list[str]) -> list[str]:
    missing = [f"{name}: not described" for name in taken if name not in described]
    return missing + [f"{name}: described, and not there" for name in described if name not in taken]


def public_functions() -> Iterator[tuple[str, Callable]]:
    """Every function and method that the package wrote itself, by its name."""
    rooms = [each.name for each in pkgutil.iter_modules(equations.__path__) if not each.name.startswith("_")]
    places = [importlib.import_module(f"atleak.equations.{room}") for room in rooms]
    values = [getattr(atleak, name) for name in atleak.__all__ if name != "PROFILES"]
    for place in (*places, *values):
        home = place.__name__ if inspect.ismodule(place) else place.__module__
        members = [("", place)] if inspect.isfunction(place) else inspect.getmembers(place, callable)
        for name, member in members:
            function = inspect.unwrap(getattr(member, "__func__", member))
            if inspect.isfunction(function) and function.__module__ == home and not name.startswith("_"):
                yield f"{function.__module__}.{function.__qualname__}", function


def test_functions_describe_their_parameters() -> None:
    wrong = {}
    for name, function in public_functions():
        taken = [each for each in inspect.signature(function).parameters if each not in ("self", "cls")]
        wrong[name] = faults(taken, entries(function.__doc__, "Parameters"))
    assert len(wrong) > 90
    assert {name: each for name, each in wrong.items() if each} == {}


IN_THE_NAME = {
    "°C": "temperature_c",
    "km": "mileage_km",
    "rev/min": "_rpm",
    "kPa": "_kpa",
    "µm": "um",
    "bar": "_bar",
    "mm": "_mm",
}


def test_a_number_that_is_not_si_names_its_unit() -> None:
    """In the calls of ``import atleak``; arguments without a unit in their name are SI."""
    seen = set()
    for name, function in public_functions():
        if name.startswith("atleak.equations."):  # °C alone, as its first page says
            continue
        section = re.search(
            r"^Parameters\n-+\n(.*?)(?=^\w[^\n]*\n--+$|\Z)", inspect.cleandoc(function.__doc__ or ""), re.M | re.S
        )
        for taken, text in re.findall(r"^(\w+)\n((?: +\S.*\n?)+)", section[1] if section else "", re.M):
            for unit in re.findall(r"\[([^\]]+)\]", text):
                if unit in IN_THE_NAME:
                    assert taken.endswith(IN_THE_NAME[unit]), f"{name}: {taken} [{unit}]"
                    seen.add(unit)
    assert seen >= {"°C", "km", "kPa", "µm"}


def test_functions_say_what_they_return_and_raise() -> None:
    """Of a method the site says it in the words of its first sentence (``tools/docstrings.py``)."""
    for name, function in public_functions():
        described = inspect.cleandoc(function.__doc__ or "")
        body = inspect.getsource(function).replace(function.__doc__ or "", "")
        assert "Raises\n---" in described or "raise " not in body, name
        returns = re.match("Return|Tell|Find|Count|Load", described) or "Returns\n---" in described
        assert returns or inspect.signature(function).return_annotation in ("None", "Any"), name
    public = [each for each in (getattr(atleak, name) for name in atleak.__all__) if inspect.isfunction(each)]
    assert [each.__name__ for each in public if "Returns\n---" not in inspect.cleandoc(each.__doc__ or "")] == []


def test_classes_describe_their_fields() -> None:
    wrong = {}
    for kind in (getattr(atleak, name) for name in atleak.__all__):
        if isinstance(kind, type) and dataclasses.is_dataclass(kind):
            described = [name for base in kind.__mro__ for name in entries(base.__doc__, "Attributes")]
            fields = [field.name for field in dataclasses.fields(kind) if not field.name.startswith("_")]
            wrong[kind.__name__] = faults(fields, described)
    assert len(wrong) == 10
    assert {name: each for name, each in wrong.items() if each} == {}


def test_what_the_reference_lists_is_there() -> None:
    pages = sorted((Path(__file__).parents[2] / "docs" / "reference").glob("*.md"))
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    listed = re.findall(r"^::: (\S+)(?:\n    options:\n      members: \[(.*)\])?", text, re.MULTILINE)
    names = [f"{place}.{name}".rstrip(".") for place, members in listed for name in members.split(", ")]
    assert len(names) > 200
    assert [name for name in names if pydoc.locate(name) is None] == []


def test_a_parameter_without_a_description_is_noticed() -> None:
    text = "It.\n\nParameters\n----------\na, b : float\n    two.\n**more\n    all.\n\nReturns\n-------\nint"
    described = entries(text, "Parameters")
    assert described == ["a", "b", "more"]
    assert faults(["a", "c"], ["a", "b"]) == ["c: not described", "b: described, and not there"]
